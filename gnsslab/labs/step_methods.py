"""Filters that are asked how late they follow a step: paper B's, the monitoring filter, and those of the literature, with settings to move."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from gnsslab.core.random_walk import random_walk_filter
from gnsslab.core.robust import igg3
from gnsslab.simulate.series import simulate_series
from gnsslab.simulate.series_presets import SeriesNoise, find_series_preset, with_shifts
from gnsslab.systems.deformation import B_FIXED, B_STEP
from gnsslab.systems.monitoring import Flag, MonitorSettings, monitor
from gnsslab.systems.step_followers import adaptive_follower, change_point_follower, cusum_follower, multi_process_follower
from gnsslab.systems.window_adjustment import adjust_with_adjusted_window, adjust_with_raw_window, weights_by_mean_error

PAPER, BUILDING = find_series_preset(B_STEP.preset), find_series_preset(B_FIXED.preset)
STEP_AT = {PAPER.name: PAPER.shifts[0].first, BUILDING.name: BUILDING.epochs // 2, "none": PAPER.shifts[0].first}  # epoch
HARDLY_ANY = SeriesNoise(white=1e-4, coloured=0.0, coloured_time=1.0, gross_share=0.0, gross=0.0, sigma_spread=0.0)
BASELINE = np.array(PAPER.baseline_enu)
ALONG = BASELINE / np.linalg.norm(BASELINE)
DIRECTIONS = {"along": ALONG, "south": np.array((0.0, -1.0, 0.0)), "across": np.array((-ALONG[1], ALONG[0], 0.0))}
IGG3 = {"none": None} | {f"{k0:g}, {k1:g}": igg3(k0, k1) for k0, k1 in ((1, 2), (1.5, 3), (2, 4), (2.5, 6))}  # weights, by their thresholds
BEFORE, AFTER = 1500, 260  # epochs about the step that are filtered
START = 400  # epochs before the step from which on many sizes are filtered at once
CM, CM2 = 1e-2, 1e-4
KEPT_SERIES, KEPT = 4, 64


class Scene(NamedTuple):
    """The errors of a series; nothing moves."""

    noise: str  # name of a series preset, or "none"
    gross: float  # [%] of the epochs
    seed: int


class Move(NamedTuple):
    """What is put into a series: the ground moves for good, or some solutions are wrong by as much."""

    step: float  # [cm]
    direction: str  # of DIRECTIONS
    lasts: int  # epochs; 0: for good
    at: int  # epoch

    @property
    def enu(self):
        """The step itself (3,) [m]."""
        return self.step * CM * DIRECTIONS[self.direction]

    def of(self, epochs):
        """Return by how much solutions are moved at each epoch (T, 3) [m]."""
        last = self.at + self.lasts if self.lasts else epochs
        k = np.arange(epochs)
        return ((k >= self.at) & (k < last))[:, None] * self.enu


class Answer(NamedTuple):
    """What a filter makes of T epochs."""

    level: np.ndarray  # (T, 3) [m]
    is_rejected: np.ndarray | None = None  # (T,) bool; None: it does not say
    found: np.ndarray = np.array([], dtype=int)  # epochs at which it found a step


@dataclass(frozen=True)
class Method:
    """A filter as the lab shows it."""

    label: str
    run: Callable  # (series, settings, axis) -> Answer; rejections are those of that axis
    uses: tuple = ()  # names of the settings that change what it makes of a series
    level: Callable | None = None  # (z (T, d) [m], sigma (T,) [m], settings) -> level (T, d), where axes are independent of each other


class StepSeries:
    """Series and what the filters make of them, kept by all that they depend on: one lab's own."""

    def __init__(self):
        self.still = lru_cache(KEPT_SERIES)(_simulated)
        self._kept = lru_cache(KEPT)(self._run)

    def answer(self, scene, move, part, name, settings):
        """Return the Answer of a method of METHODS to the epochs `part` = (first, last) of a Scene with a Move in it."""
        return self._kept(scene, move, part, name, tuple((used, settings[used]) for used in METHODS[name].uses))

    def _run(self, scene, move, part, name, used):
        series = moved(self.still(scene).at(slice(*part)), move._replace(at=move.at - part[0]))
        return METHODS[name].run(series, dict(used), int(np.argmax(np.abs(DIRECTIONS[move.direction]))))


def moved(series, move):
    """Return a Series with a Move put into it."""
    return replace(series, enu=series.enu + move.of(len(series)))


def levels_of_steps(series, move, sizes, name, settings):
    """Return what a method with independent axes makes of a Series with steps of several sizes (S,) [cm] at move.at, (S, T, 3) [m]."""
    z = np.stack([moved(series, move._replace(step=size)).enu for size in sizes], axis=1)  # (T, S, 3)
    level = METHODS[name].level(z.reshape(len(z), -1), series.sigma[:, 0], settings)
    return level.reshape(z.shape).swapaxes(0, 1)


def _simulated(scene):
    """Return the still Series of a Scene; its baseline is always that of the paper's platform."""
    preset = BUILDING if scene.noise == BUILDING.name else PAPER
    noise = HARDLY_ANY if scene.noise == "none" else replace(preset.noise, gross_share=scene.gross / 100)
    still = replace(with_shifts(preset), noise=noise, baseline_enu=PAPER.baseline_enu)
    return simulate_series(still, np.random.default_rng(scene.seed)).series


def _raw(series, settings, axis):
    return Answer(series.enu, _none(series))


def _none(series):
    """Nothing is rejected."""
    return np.zeros(len(series), dtype=bool)


def _adjusted(z, sigma, settings):
    adjust = adjust_with_adjusted_window if settings["holds"] == "adjusted" else adjust_with_raw_window
    return adjust(z, weights_by_mean_error(sigma, settings["window"]), settings["window"])


def _adjustment(series, settings, axis):
    return Answer(_adjusted(series.enu, series.sigma[:, 0], settings), _none(series))


def _walk(z, settings):
    return random_walk_filter(z, settings["q"] * CM2, B_STEP.r, IGG3[settings["thresholds"]])


def _walk_level(z, sigma, settings):
    return _walk(z, settings).level


def _joint_level(z, sigma, settings):
    return _walk(_adjusted(z, sigma, settings), settings).level


def _kalman(series, settings, axis):
    return _told(_walk(series.enu, settings), axis)


def _joint(series, settings, axis):
    return _told(_walk(_adjusted(series.enu, series.sigma[:, 0], settings), settings), axis)


def _told(walk, axis):
    return Answer(walk.level, walk.weight[:, axis] == 0)


def _monitored(series, settings, axis):
    found = monitor(series, replace(MonitorSettings(), threshold=float(settings["evidence"]), window=int(settings["patience"])))
    return Answer(found.level, found.flag == Flag.OUTLIER, np.array([step.found for step in found.steps], dtype=int))


def _follower(follow):
    """Return a run of one of `systems.step_followers`."""

    def run(series, settings, axis):
        found = follow(series)
        return Answer(found.level, None, np.flatnonzero(found.is_step))

    return run


_OF_FILTER, _OF_ADJUSTMENT = ("q", "thresholds"), ("window", "holds")
METHODS = {
    "raw": Method("raw", _raw, level=lambda z, sigma, settings: z),
    "joint": Method("joint", _joint, (*_OF_ADJUSTMENT, *_OF_FILTER), _joint_level),
    "kalman": Method("robust Kalman", _kalman, _OF_FILTER, _walk_level),
    "adjustment": Method("adjustment", _adjustment, _OF_ADJUSTMENT, _adjusted),
    "monitor": Method("monitor", _monitored, ("evidence", "patience")),
    "adaptive": Method("adaptive Kalman", _follower(adaptive_follower)),
    "processes": Method("multi-process", _follower(multi_process_follower)),
    "points": Method("change points", _follower(change_point_follower)),
    "cusum": Method("CUSUM", _follower(cusum_follower)),
}
