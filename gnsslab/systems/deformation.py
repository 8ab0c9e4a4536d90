"""Deformation monitoring as in paper B (Li et al. 2021): an adjustment with the window before, then a robust Kalman filter; and its competitors.

All of them take a series of solutions, no measurements: z (T, 3) [m] and the error stated for each epoch.
"""

from dataclasses import dataclass

from gnsslab.core.decomposition import eemd_wavelet
from gnsslab.core.denoise import moving_average, wavelet_threshold
from gnsslab.core.random_walk import random_walk_filter
from gnsslab.core.robust import igg3
from gnsslab.systems.window_adjustment import adjust_with_adjusted_window, weights_by_mean_error


@dataclass(frozen=True)
class PublishedSeries:
    """A series as the paper describes it: the preset of its noise, and how the methods were set. What the paper leaves open is calibrated."""

    preset: str  # of gnsslab.simulate.series_presets
    window: int = 30  # epochs of the adjustment; paper
    k0: float = 1.0  # of IGG3; paper
    k1: float = 2.0
    q: float = 0.48e-4  # [m^2] of the random walk, an epoch; calibrated
    r: float = 9.9e-4  # [m^2] of a solution on one axis; calibrated
    average: int = 15  # epochs of the moving average; calibrated
    wavelet_level: int = 3  # of db8, universal threshold, soft; calibrated
    eemd_trials: int = 25  # calibrated, as the two below
    eemd_noise: float = 0.2  # of the series' standard deviation
    eemd_modes: int = 3  # the first ones, which are shrunk


B_FIXED = PublishedSeries("b-fixed")
B_STEP = PublishedSeries("b-step")


def adjusted(series, system):
    """Return the adjustment alone (T, 3) [m]; its window holds adjusted solutions, and w is near one half."""
    return adjust_with_adjusted_window(series.enu, weights_by_mean_error(series.sigma[:, 0], system.window), system.window)


def robust_kalman(series, system):
    """Return the robust Kalman filter alone (T, 3) [m]: a random walk on each axis with IGG3 weights."""
    return filtered(series.enu, system)


def joint(series, system):
    """Return the paper's joint method (T, 3) [m]: the adjustment, then the robust Kalman filter."""
    return filtered(adjusted(series, system), system)


def filtered(z, system):
    """Return positions z (T, 3) [m] through the paper's robust Kalman filter."""
    return random_walk_filter(z, system.q, system.r, igg3(system.k0, system.k1)).level


def averaged(series, system):
    """Return the centred moving average (T, 3) [m]."""
    return moving_average(series.enu, system.average)


def wavelet(series, system):
    """Return the series with its db8 wavelet coefficients thresholded (T, 3) [m]."""
    return wavelet_threshold(series.enu, system.wavelet_level)


def eemd(series, system, rng, progress=None):
    """Return the series with the first modes of its ensemble empirical mode decomposition thresholded (T, 3) [m]: slow."""
    return eemd_wavelet(series.enu, rng, trials=system.eemd_trials, noise=system.eemd_noise, shrunk=system.eemd_modes, progress=progress)


# Those that take no time worth a thought, in the order of the paper's tables.
METHODS = {
    "joint": joint,
    "adjustment": adjusted,
    "robust Kalman": robust_kalman,
    "moving average": averaged,
    "wavelet": wavelet,
}
