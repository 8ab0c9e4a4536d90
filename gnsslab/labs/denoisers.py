"""Paper B's methods and those that the field would set beside them, each with settings that a student can move."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from gnsslab.core.denoise import hampel_filter, moving_average, savitzky_golay
from gnsslab.core.random_walk import random_walk_filter, random_walk_smoother
from gnsslab.core.robust import igg3
from gnsslab.simulate.series import simulate_series
from gnsslab.simulate.series_presets import Shift, find_series_preset, with_shifts
from gnsslab.systems import deformation
from gnsslab.systems.deformation import B_FIXED
from gnsslab.systems.window_adjustment import adjust_with_adjusted_window, adjust_with_raw_window, weights_by_mean_error

PRESET = find_series_preset(B_FIXED.preset)
DIRECTION = np.array(PRESET.baseline_enu) / np.linalg.norm(PRESET.baseline_enu)
STEP_AT = PRESET.epochs // 2  # epoch
CM = 1e-2
CM2 = 1e-4
HAMPEL_HALF = 7  # epochs on either side, as many as the paper's moving average has; a longer window finds the same gross errors
DEGREE = 2  # of Savitzky and Golay's polynomial
KEPT = 64  # results; a move of one slider needs a few of them
WHOLE_SERIES = -1  # epochs ahead
IGG3 = {"none": None, "paper": igg3(B_FIXED.k0, B_FIXED.k1), "wide": igg3(2.5, 6.0)}  # weights, by name of their thresholds


class Scene(NamedTuple):
    """What is simulated: paper B's fixed baseline with other errors, and a step in the middle."""

    step: float  # [cm] along the baseline
    correlation: float  # [epochs] of the coloured errors
    gross: float  # [%] of the epochs
    seed: int


@dataclass(frozen=True)
class Denoiser:
    """A method as the lab shows it."""

    label: str
    denoise: Callable  # (series, settings) -> (T, 3) [m]
    uses: tuple  # names of the settings that change what it makes of a series
    ahead: Callable = lambda settings: 0  # (settings) -> epochs it needs from the time after; WHOLE_SERIES
    printed: float | None = None  # [cm] RMSE in the paper's tables 1 and 2


class Row(NamedTuple):
    """What a picture says of a method."""

    label: str
    printed: float | None  # [cm] RMSE in the paper's tables 1 and 2
    is_later: bool  # it needs epochs that come later


class DenoisedSeries:
    """Series and what the methods make of them, kept by all that they depend on: one lab's own."""

    def __init__(self):
        self.simulated = lru_cache(KEPT)(_simulated)
        self._kept = lru_cache(KEPT)(self._denoise)

    def denoised(self, scene, name, settings):
        """Return what a method of DENOISERS makes of a Scene, (T, 3) [m]; of the settings (a dictionary) only those matter that it uses."""
        return self._kept(scene, name, tuple((used, settings[used]) for used in DENOISERS[name].uses))

    def _denoise(self, scene, name, used):
        return DENOISERS[name].denoise(self.simulated(scene).series, dict(used))


def rows(settings):
    """Return the Row of each of DENOISERS, by name."""
    return {name: Row(one.label, one.printed, one.ahead(settings) != 0) for name, one in DENOISERS.items()}


def _simulated(scene):
    """Return the SimulatedSeries of a Scene."""
    noise = replace(PRESET.noise, coloured_time=scene.correlation * PRESET.interval, gross_share=scene.gross / 100)
    step = Shift(STEP_AT, STEP_AT, tuple(scene.step * CM * DIRECTION))
    return simulate_series(with_shifts(replace(PRESET, noise=noise), step), np.random.default_rng(scene.seed))


def _raw(series, settings):
    return series.enu


def _adjusted(series, settings):
    adjust = adjust_with_adjusted_window if settings["holds"] == "adjusted" else adjust_with_raw_window
    return adjust(series.enu, weights(series, settings), settings["window"])


def weights(series, settings):
    """Return the weight w (T,) of each epoch when the mean of its window counts as `counted` epochs, as far as it has them.

    w = s^2 / (s^2 + n s_k^2), s the mean of the window's stated errors: n = 1 is the paper's, n = 30 the error of a mean of 30.
    """
    w = weights_by_mean_error(series.sigma[:, 0], settings["window"])
    n = np.minimum(settings["counted"], np.clip(np.arange(len(w)), 1, settings["window"]))
    return w / (w + n * (1 - w))


def _walk(z, settings):
    return random_walk_filter(z, settings["q"] * CM2, B_FIXED.r, IGG3[settings["thresholds"]])


def _robust_kalman(series, settings):
    return _walk(series.enu, settings).level


def _joint(series, settings):
    return _walk(_adjusted(series, settings), settings).level


def _average(series, settings):
    return moving_average(series.enu, settings["average"])


def _wavelet(series, settings):
    return deformation.wavelet(series, B_FIXED)


def _eemd(series, settings):
    return deformation.eemd(series, B_FIXED, np.random.default_rng([settings["seed"], 1]))  # not the numbers that made the series


def _hampel(series, settings):
    return hampel_filter(series.enu, HAMPEL_HALF).filtered


def _polynomials(series, settings):
    return savitzky_golay(series.enu, odd(settings["average"]), DEGREE)


def odd(n):
    """Return n, or the next number if it is even."""
    return n // 2 * 2 + 1


def _smoothed(series, settings):
    return random_walk_smoother(_walk(series.enu, settings), settings["q"] * CM2)[0]


def _whole(settings):
    return WHOLE_SERIES


_OF_FILTER, _OF_ADJUSTMENT = ("q", "thresholds"), ("window", "counted", "holds")
# In the order of the paper's tables, then those beside it.
DENOISERS = {
    "raw": Denoiser("raw", _raw, (), printed=2.37),
    "joint": Denoiser("joint", _joint, (*_OF_ADJUSTMENT, *_OF_FILTER), printed=1.00),
    "adjustment": Denoiser("adjustment", _adjusted, _OF_ADJUSTMENT, printed=1.40),
    "kalman": Denoiser("robust Kalman", _robust_kalman, _OF_FILTER, printed=1.52),
    "average": Denoiser("moving average", _average, ("average",), lambda used: used["average"] - 1 - used["average"] // 2, 1.52),
    "wavelet": Denoiser("wavelet", _wavelet, (), _whole, 1.78),
    "eemd": Denoiser("EEMD-wavelet", _eemd, ("seed",), _whole, 1.74),
    "hampel": Denoiser("Hampel", _hampel, (), lambda used: HAMPEL_HALF),
    "polynomials": Denoiser("Savitzky-Golay", _polynomials, ("average",), lambda used: used["average"] // 2),
    "smoother": Denoiser("RTS smoother", _smoothed, _OF_FILTER, _whole),
}
