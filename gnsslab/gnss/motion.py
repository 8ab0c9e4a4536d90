"""Motion: what is assumed of baseline and ambiguities between epochs, as transition, process noise and offset of the states."""

from typing import NamedTuple

import numpy as np

from gnsslab.gnss.times import seconds_between

SIGMA_OPEN = 100.0  # [m], of a baseline known from single-point positions only: generous, the codes will tell
AMBIGUITY_DRIFT = 1e-4  # [m per sqrt(s)], random walk of every ambiguity: multipath moves carriers by millimetres within minutes, so the
# average of an hour must not be believed to 0.1 mm. Without it the 24 h of beidou-slope fix at 92 % of the epochs, with it at 99 %.
_SIGMA_OPEN_VELOCITY = 100.0  # [m/s], of a velocity not known at all: a fast aircraft's is 2.5 sigma


class Path(NamedTuple):
    """Motion of p states, baseline and perhaps velocity, over T epochs: x <- F x + offset with process noise Q."""

    F: np.ndarray  # (T, p, p)
    Q: np.ndarray  # (T, p, p)
    offset: np.ndarray  # (T, p)
    drift: np.ndarray  # (T,) [m^2], variance that every ambiguity gains since the epoch before


def forgetful(time, near):
    """Return the Path of a baseline that starts anew at each epoch (T,), at its approximate value near (T, 3) [m]."""
    T = len(time)
    Q = np.broadcast_to(SIGMA_OPEN**2 * np.eye(3), (T, 3, 3)).copy()
    return Path(np.zeros((T, 3, 3)), Q, near.copy(), np.zeros(T))


def static(time, near):
    """Return the Path of a baseline that stands still from its first epoch on."""
    path = forgetful(time, near)
    path.F[1:] = np.eye(3)
    path.Q[1:] = 0.0
    path.offset[1:] = 0.0
    path.drift[1:] = AMBIGUITY_DRIFT**2 * seconds_between(time[1:], time[:-1])
    return path


def moving(time, near, acceleration=3.0, longest_gap=10.0):
    """Return the Path of a baseline whose velocity is driven by white acceleration [m/s^2 per sqrt(Hz)].

    After a step of more than max(longest_gap [s], 1.5 usual steps) position and velocity start anew at near (T, 3) [m].
    Q = q^2 [[dt^3/3, dt^2/2], [dt^2/2, dt]] on each axis (Brown and Hwang 2012, section 4.6, velocity as the integral of white noise).

    >>> time = np.array(["2024-01-01T00:00:00", "2024-01-01T00:00:02"], "M8[ns]")
    >>> moving(time, np.zeros((2, 3)), acceleration=1.0).Q[1, 0, [0, 3]].round(3).tolist()
    [2.667, 2.0]
    """
    dt = seconds_between(time[1:], time[:-1])
    starts = np.concatenate([[True], dt > max(longest_gap, 1.5 * np.median(dt))]) if len(dt) else np.array([True])
    T = len(time)
    F, Q, offset = np.zeros((T, 6, 6)), np.zeros((T, 6, 6)), np.zeros((T, 6))
    F[1:], Q[1:] = _white_acceleration(dt, acceleration)
    F[starts] = 0.0
    Q[starts] = np.diag([SIGMA_OPEN**2] * 3 + [_SIGMA_OPEN_VELOCITY**2] * 3)
    offset[starts, :3] = near[starts]
    return Path(F, Q, offset, AMBIGUITY_DRIFT**2 * np.concatenate([[0.0], dt]))


def _white_acceleration(dt, acceleration):
    """Return F (T, 6, 6) and Q (T, 6, 6) of steps dt (T,) [s]."""
    F = np.broadcast_to(np.eye(6), (len(dt), 6, 6)).copy()
    F[:, :3, 3:] = dt[:, None, None] * np.eye(3)
    block = np.array([[dt**3 / 3, dt**2 / 2], [dt**2 / 2, dt]]) * acceleration**2
    return F, np.einsum("abt,ij->taibj", block, np.eye(3)).reshape(-1, 6, 6)
