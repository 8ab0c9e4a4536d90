"""How good a filtered series is: scatter about its own mean, errors against the truth, how late it follows a step, and what an alarm makes of it.

The first is all that paper B (Li et al. 2021) looks at. A constant output has none of it, however wrong it is.
"""

from typing import NamedTuple

import numpy as np


def rmse_about_mean(values):
    """Return the RMSE of values (T,) about their own mean, equation (22) with "true value" = the mean: a standard deviation.

    >>> float(rmse_about_mean(np.array([1.0, 3.0]))), float(rmse_about_mean(np.full(9, 77.0)))
    (1.0, 0.0)
    """
    values = np.asarray(values, dtype=float)
    return np.sqrt(np.mean((values - values.mean()) ** 2))


def rmse_about_two_means(values, first):
    """Return the RMSE of values (T,) about their mean before epoch `first` and their mean from it on: the paper's "outer accuracy" of table 3.

    >>> float(rmse_about_two_means(np.array([1.0, 3.0, 7.0, 7.0]), 2))
    0.7071067811865476
    """
    values = np.asarray(values, dtype=float)
    parts = [values[:first] - values[:first].mean(), values[first:] - values[first:].mean()]
    return np.sqrt(np.mean(np.concatenate(parts) ** 2))


def rmse_about_truth(values, truth):
    """Return the RMSE of values (T,) or positions (T, p) about the truth: of positions, the root of the mean square of the distance.

    >>> float(rmse_about_truth([[3.0, 4.0], [0.0, 0.0]], [[0.0, 0.0], [0.0, 0.0]]).round(3))
    3.536
    """
    error = np.asarray(values, dtype=float) - np.asarray(truth, dtype=float)
    return np.sqrt(np.sum(error**2) / len(error))


def lengths(positions):
    """Return the length (T,) of each baseline (T, 3)."""
    return np.linalg.norm(positions, axis=-1)


def step_response(with_step, without_step, step):
    """Return the share (T,) of a step (p,) that is in a filtered series (T, p), against the same series, the same noise, without it.

    share = d'(y - y_0) / d'd: so the noise cancels, as far as the filter lets it.

    >>> step_response([[0.0], [0.5], [1.8]], [[0.0], [0.1], [-0.2]], [2.0]).round(9).tolist()
    [0.0, 0.2, 1.0]
    """
    step = np.asarray(step, dtype=float)
    return (np.asarray(with_step, dtype=float) - without_step) @ step / (step @ step)


def lag(response, first, share):
    """Return how many epochs after the step at epoch `first` the response (T,) reaches a share of it; NaN if never.

    0 where it does at the epoch of the step itself.

    >>> response = np.array([0.0, 0.0, 0.3, 0.6, 0.95])
    >>> lag(response, 2, 0.5), lag(response, 2, 0.9), lag(response, 2, 0.99)
    (1.0, 2.0, nan)
    """
    reached = np.flatnonzero(np.asarray(response)[first:] >= share)
    return float(reached[0]) if len(reached) else np.nan


def threshold_alarm(positions, reference, threshold):
    """Return where (T,) a filtered position is farther than `threshold` from the reference on the level: the plain alarm of a monitoring system.

    >>> threshold_alarm([[0.0, 0.01, 0.3], [0.03, 0.04, 0.0]], [0.0, 0.0, 0.0], 0.04).tolist()
    [False, True]
    """
    offset = np.asarray(positions, dtype=float) - reference
    return np.hypot(offset[:, 0], offset[:, 1]) > threshold


class AlarmCount(NamedTuple):
    """What an alarm did about one step."""

    false_alarms: int  # times it went off before the step
    lag: float  # [epochs] from the step to the first epoch of alarm; NaN: missed

    @property
    def is_missed(self):
        """The step never made an alarm."""
        return np.isnan(self.lag)


def count_alarms(is_alarm, first=None, quiet=1):
    """Return the `AlarmCount` of an alarm (T,) about a step at epoch `first`; None: nothing moves, and each alarm is a false one.

    An alarm goes off where it is on after `quiet` epochs or more without.

    >>> count_alarms(np.array([0, 1, 1, 0, 0, 0, 0, 1], dtype=bool), first=5)
    AlarmCount(false_alarms=1, lag=2.0)
    """
    is_alarm = np.asarray(is_alarm, dtype=bool)
    first = len(is_alarm) if first is None else first
    on = np.flatnonzero(is_alarm[:first])
    starts = int(np.sum(np.diff(on, prepend=-quiet - 1) > quiet)) if len(on) else 0
    after = np.flatnonzero(is_alarm[first:])
    return AlarmCount(starts, float(after[0]) if len(after) else np.nan)
