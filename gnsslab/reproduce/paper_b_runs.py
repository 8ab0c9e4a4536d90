"""Paper B's two experiments, drawn and filtered in every way that the paper compares, and in those that it leaves open."""

from dataclasses import dataclass, replace

import numpy as np

from gnsslab.core.denoise import moving_average
from gnsslab.core.random_walk import random_walk_filter
from gnsslab.simulate import find_series_preset
from gnsslab.simulate.series import SimulatedSeries, simulate_series
from gnsslab.systems.deformation import B_FIXED, B_STEP, METHODS, adjusted, eemd, filtered, joint, robust_kalman
from gnsslab.systems.window_adjustment import adjust_with_adjusted_window, adjust_with_raw_window, weights_by_error_of_mean, weights_by_mean_error

WALKS = (0.05, 0.1, 0.2, 0.48, 1.0, 2.0, 5.0)  # [cm^2] an epoch, of the random walk
AVERAGES = (30, 120)  # [epochs]


@dataclass(frozen=True, eq=False)
class Experiment:
    """One draw of a series and what the methods make of it, by name: positions (T, 3) [m]."""

    drawn: SimulatedSeries
    outputs: dict


def draw(preset, seed):
    """Return the SimulatedSeries of a preset's name and a seed."""
    return simulate_series(find_series_preset(preset), np.random.default_rng(seed))


def fixed_experiment(seed):
    """Return the Experiment of the baseline at rest, with EEMD (which takes most of the time) and the variations."""
    drawn = draw(B_FIXED.preset, seed)
    return Experiment(drawn, _outputs(drawn.series, B_FIXED) | {"EEMD": with_eemd(drawn.series, B_FIXED, seed)} | _variations(drawn.series))


def step_experiment(seed):
    """Return the Experiment of the platform that moves: 63 857 epochs, no EEMD."""
    drawn = draw(B_STEP.preset, seed)
    return Experiment(drawn, _outputs(drawn.series, B_STEP))


def with_eemd(series, system, seed, progress=None):
    """Return the series (T, 3) [m] after EEMD-wavelet, whose own noise has the seed's second stream."""
    return eemd(series, system, np.random.default_rng((seed, 1)), progress)


def _outputs(series, system):
    return {"raw": series.enu} | {name: method(series, system) for name, method in METHODS.items()}


def _variations(series):
    """Return what the paper leaves open, settled in another way: windows, weights, thresholds, q."""
    z, system = series.enu, B_FIXED
    found = _windows(series)
    found |= {f"average {n}": moving_average(z, n) for n in AVERAGES}
    found |= {"plain Kalman": random_walk_filter(z, system.q, system.r).level}
    found |= {"IGG3 2.5 6": robust_kalman(series, replace(system, k0=2.5, k1=6.0))}
    for q in WALKS:
        walking = replace(system, q=q * 1e-4)
        found |= {f"Kalman q {q:g}": robust_kalman(series, walking), f"joint q {q:g}": joint(series, walking)}
    return found


def _windows(series):
    z, sigma, n = series.enu, series.sigma[:, 0], B_FIXED.window
    raw_window = adjust_with_raw_window(z, weights_by_mean_error(sigma, n), n)
    return {
        "raw window": raw_window,
        "joint raw window": filtered(raw_window, B_FIXED),
        "plain joint": random_walk_filter(adjusted(series, B_FIXED), B_FIXED.q, B_FIXED.r).level,
        "error of mean": adjust_with_adjusted_window(z, weights_by_error_of_mean(sigma, n), n),
    }
