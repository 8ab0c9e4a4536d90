"""What a step follower takes and gives: positions and their noise, prepared for its kernel; the level and the steps."""

from typing import NamedTuple

import numpy as np

from gnsslab.core.coloured_noise import learn_noise
from gnsslab.core.jit import kernel, kernel_input, matrix, vector
from gnsslab.systems.monitoring import epochs_since_last
from gnsslab.systems.step_followers.walking_level import COLOURED, P_COLOUR, P_LEVEL, WHITE, innovation, innovation_variance

LEARNT_FROM = 4096  # first epochs that the noise is learnt from, at most half of the series
AXES = 3


class Followed(NamedTuple):
    """A series of T epochs as a step follower sees it."""

    level: np.ndarray  # (T, 3) [m] where the point is; NaN before the first solution
    is_step: np.ndarray  # (T,) bool: at this epoch a step was found; it may have begun before


def follow(series, run, memory):
    """Return the `Followed` of run(z, dt, noise, level, is_step), a kernel that fills the last two, (T, 3) and (T,).

    z (T, 3) [m] counts from the first solution and is NaN where there is none; dt (T,) [epochs] since the epoch before; noise (3, 4) are
    rows for `walking_level`, see `noise_rows`. A series without a solution raises ValueError.

    >>> from gnsslab.gnss.series import series_of_numbers
    >>> series = series_of_numbers(np.arange(40).astype("M8[s]"), np.ones((40, 3)))
    >>> follow(series, lambda z, dt, noise, level, is_step: None, memory=10.0).level[-1].tolist()
    [1.0, 1.0, 1.0]
    """
    solved = np.flatnonzero(series.is_solved)
    if not len(solved):
        raise ValueError("a step is followed from solutions; the series has none")
    first, T = int(solved[0]), len(series)
    origin = series.enu[first]
    z = series.enu[first:] - origin
    level, is_step = matrix(T - first, AXES), vector(T - first)
    run(kernel_input(z), kernel_input(epochs_since_last(series.time[first:])), kernel_input(noise_rows(z, memory)), level, is_step)
    unknown = np.full((first, AXES), np.nan)
    return Followed(np.vstack([unknown, np.asarray(level) + origin]), np.concatenate([np.zeros(first), is_step]) > 0)


def noise_rows(z, memory):
    """Return white and coloured variance [m^2], correlation [epochs] and walk [m^2 an epoch] (3, 4), learnt from the first part of z (T, 3) [m].

    The walk is what makes the level forget in `memory` epochs: long-run variance over memory^2.
    """
    learnt = [learn_noise(axis) for axis in z[: max(min(LEARNT_FROM, len(z) // 2), 16)].T]
    return np.array([[*noise, noise.long_run / memory**2] for noise in learnt])


@kernel
def begin(state, noise):
    """Let the level be that of the first solution, as uncertain as the noise is, in place: state (3, 5), noise (3, 4)."""
    for axis in range(len(noise)):
        state[axis][P_LEVEL], state[axis][P_COLOUR] = noise[axis][WHITE] + noise[axis][COLOURED], noise[axis][COLOURED]


@kernel
def squared_length(state, noise, z):
    """Return the squared length of the innovation (3,), each axis in its own sigma: chi-square of 3 degrees of freedom where nothing is wrong."""
    total = 0.0
    for axis in range(len(z)):
        v = innovation(state[axis], z[axis])
        total += v * v / innovation_variance(state[axis], noise[axis])
    return total
