"""Kinds of alarm: each makes a line of a series, and goes off where the line is farther than a threshold from where it was at first."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from scipy.ndimage import minimum_filter1d

from gnsslab.core.denoise import trailing_average
from gnsslab.core.random_walk import random_walk_filter
from gnsslab.core.robust import igg3
from gnsslab.systems.deformation import B_FIXED, adjusted
from gnsslab.systems.monitoring import Flag, MonitorSettings, monitor

FIRST = 240  # epochs, an hour of 15 s: the reference is their median, and no alarm is given
FIRST_SHARE = 5  # of a shorter series: a fifth of it
AGAIN = 60  # epochs, 15 minutes: an alarm that goes on wakes people again
KEPT = 64


@dataclass(frozen=True, eq=False)
class Line:
    """What an alarm looks at, over T epochs."""

    distance: np.ndarray  # (T,) [m] on the level from the reference
    sigma: np.ndarray  # (T,) [m] of the position on one axis, NaN where the method tells none
    is_outlier: np.ndarray  # (T,) bool, solutions that the method does not believe
    score: np.ndarray  # (T,) [m] the alarm is on where this is above the threshold


@dataclass(frozen=True)
class Kind:
    """A kind of alarm as the lab shows it."""

    label: str
    find: Callable  # (series, settings) -> level (T, 3) [m], its sigma (T,), is_outlier (T,)
    uses: tuple = ()  # names of the settings that change the line
    waits: bool = True  # the line itself does not wait: the alarm has to


class Lines:
    """Lines of the series of one lab, each made once."""

    def __init__(self):
        self._kept = lru_cache(KEPT)(_line)

    def line(self, series, name, settings):
        """Return the Line of a kind of KINDS; of the settings (a dictionary) only those matter that it uses."""
        return self._kept(series, name, tuple((used, settings[used]) for used in (*KINDS[name].uses, "wait")))


def first_epochs(T):
    """Return how many epochs of T the reference is taken from.

    >>> first_epochs(5760), first_epochs(100)
    (240, 20)
    """
    return min(FIRST, max(T // FIRST_SHARE, 1))


def wake_ups(is_alarm, again=AGAIN):
    """Return how often an alarm (T,) wakes people: at its first epoch, and while or when it is on again `again` epochs or more after the last time.

    >>> wake_ups(np.arange(200) >= 10), wake_ups(np.isin(np.arange(200), (10, 30, 90)))
    (4, 2)
    """
    on, count, place = np.flatnonzero(is_alarm), 0, 0
    while place < len(on):
        count, place = count + 1, int(np.searchsorted(on, on[place] + again))
    return count


def _line(series, name, used):
    kind, settings = KINDS[name], dict(used)
    level, sigma, is_outlier = kind.find(series, settings)
    first = first_epochs(len(series))
    offset = (level - np.median(series.enu[:first], axis=0))[:, :2]
    distance = np.nan_to_num(np.hypot(*offset.T))  # a filter that does not use the first solutions has no level yet
    score = held_for(distance, settings["wait"]) if kind.waits else distance.copy()
    score[:first] = 0.0
    return Line(distance, sigma, is_outlier, score)


def held_for(distance, wait):
    """Return the least of each epoch and the wait - 1 before it (T,): it is above a threshold where the distance has been so for `wait` epochs.

    >>> held_for(np.array([0.0, 3.0, 2.0, 5.0]), 2).tolist()
    [0.0, 0.0, 2.0, 2.0]
    """
    return minimum_filter1d(distance, wait, origin=(wait - 1) // 2, mode="nearest")


def _nothing_told(series):
    return np.full(len(series), np.nan), np.zeros(len(series), dtype=bool)


def _raw(series, settings):
    return series.enu, *_nothing_told(series)


def _average(series, settings):
    return trailing_average(series.enu, settings["average"]), *_nothing_told(series)


def _joint(series, settings):
    equal = np.ones_like(series.sigma)  # where no sigma is stated all epochs are as good: w is one half
    walk = random_walk_filter(adjusted(replace(series, sigma=np.where(np.isfinite(series.sigma), series.sigma, equal)), B_FIXED),
                              B_FIXED.q, B_FIXED.r, igg3(B_FIXED.k0, B_FIXED.k1))  # fmt: skip
    return walk.level, _level_sigma(np.sqrt(walk.variance)), (walk.weight[:, :2] == 0).any(axis=1)


def _monitor(series, settings):
    found = monitor(series, MonitorSettings(fewest=settings["wait"]))
    return found.level, _level_sigma(found.sigma), found.flag == Flag.OUTLIER


def _level_sigma(sigma):
    """Return the root mean square of east and north (T,)."""
    return np.sqrt(np.mean(sigma[:, :2] ** 2, axis=1))


KINDS = {
    "raw": Kind("raw solutions", _raw),
    "average": Kind("moving average", _average, ("average",)),
    "joint": Kind("paper's joint filter", _joint),
    "monitor": Kind("monitor", _monitor, waits=False),
}
