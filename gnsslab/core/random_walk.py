"""A level that walks: Kalman filter and smoother of a random walk per axis, robust by equivalent covariance.

    x_k = x_k-1 + w,  w ~ N(0, q)        z_k = x_k + v,  v ~ N(0, r)

Axes are independent of each other, so everything is scalar: one pass of a kernel over epochs and axes.
"""

import math
from dataclasses import dataclass

import numpy as np

from gnsslab.core.columns import columns, measurements, uncolumns
from gnsslab.core.jit import kernel, kernel_input
from gnsslab.core.robust import Weight, equivalent_weight


@dataclass(frozen=True, eq=False)
class RandomWalk:
    """A filtered random walk, all arrays (..., T, d); what is NaN has not begun, or was not measured."""

    level: np.ndarray  # [m] x after the epoch's measurement
    variance: np.ndarray  # [m^2] of the level, P
    innovation: np.ndarray  # [m] z - x predicted; NaN where nothing was measured
    innovation_sigma: np.ndarray  # [m] sqrt(P predicted + r), of an innovation that counts in full
    weight: np.ndarray  # eta in [0, 1]; 0 where the measurement was rejected or there is none

    def __repr__(self):
        measured = np.isfinite(self.innovation)
        rejected = np.count_nonzero(measured & (self.weight == 0))
        return f"RandomWalk: {' x '.join(map(str, self.level.shape))} values, {np.count_nonzero(measured)} measured, {rejected} rejected"


def random_walk_filter(z, q, r, weight=None):
    """Return the `RandomWalk` of measurements z (..., T, d) [m]: a Kalman filter for each axis.

        P^- = P + q,  v = z - x,  s = sqrt(P^- + r),  eta = weight(v / s)
        K = P^- / (P^- + r / eta),  x <- x + K v,  P <- (1 - K) P^-,  and for eta = 0: K = 0, P = P^-

    q: variance of the walk per epoch [m^2], r: variance of a measurement [m^2], a number or one per axis (d,). `weight` is a
    `gnsslab.core.robust.Weight`, such as igg3(1, 2); without it all measurements count in full. An axis begins at its first
    number: that is the prior level, with variance r, and then the first measurement too, so P = r / 2 after it; before it all
    is NaN. Where z is NaN the level is predicted and P grows. Raises ValueError for a z, q or r that makes no sense.

    Sources: Li et al. (2021), Electronic Measurement Technology, (13)-(21); equivalent covariance: Yang, He and Xu (2001), J. Geodesy 75:109-116.

    >>> from gnsslab.core.robust import igg3
    >>> walk = random_walk_filter([[0.0], [2.0], [90.0]], q=2.0, r=4.0, weight=igg3(1, 2))
    >>> walk.level.ravel().tolist(), walk.variance.ravel().tolist(), walk.weight.ravel().tolist()
    ([0.0, 1.0, 1.0], [2.0, 2.0, 4.0], [1.0, 1.0, 0.0])
    """
    z, weight = measurements(z), _weight(weight)
    q, r = _per_column(q, z, "q"), _per_column(r, z, "r")
    if (r == 0).any():
        raise ValueError("r, the variance of a measurement, must be above zero")
    filtered = kernel_input(np.empty((5, z.shape[-2], len(q))))  # from numpy, which asks for large pages: half of the time
    _filter(kernel_input(columns(z)), kernel_input(q), kernel_input(r), *weight.thresholds, filtered)
    return RandomWalk(*(uncolumns(array, z) for array in filtered))


def random_walk_smoother(filtered, q):
    """Return level and variance (..., T, d) of each epoch given the measurements of all epochs, from a `RandomWalk` filtered with q.

        C = P_k / (P_k + q),  x_k <- x_k + C (x_k+1 - x_k),  P_k <- P_k + C^2 (P_k+1 - P_k - q)

    Rejected and missing epochs need nothing of their own: P_k says what the filter knew.
    Source: Rauch, Tung and Striebel (1965), AIAA Journal 3:1445-1450.

    >>> level, variance = random_walk_smoother(random_walk_filter([[0.0], [2.0]], q=2.0, r=4.0), q=2.0)
    >>> level.ravel().tolist(), variance.ravel().tolist()
    ([0.5, 1.0], [1.5, 2.0])
    """
    level, variance, q = columns(filtered.level), columns(filtered.variance), _per_column(q, filtered.level, "q")
    smoothed = kernel_input(np.empty((2, *level.shape)))
    _smooth(kernel_input(level), kernel_input(variance), kernel_input(q), smoothed)
    return tuple(uncolumns(array, filtered.level) for array in smoothed)


def _weight(weight):
    if weight is None:
        return Weight()
    if not isinstance(weight, Weight):
        raise ValueError(f"weight must be a Weight of gnsslab.core.robust, such as igg3(1, 2) or huber(1.345); got {weight!r}")
    return weight


def _per_column(value, z, name):
    """Return q or r for each column of `columns`."""
    value = np.asarray(value, dtype=np.float64)
    if value.ndim > 1 or (value.ndim == 1 and value.shape != z.shape[-1:]):
        raise ValueError(f"{name} must be one number or one per axis, ({z.shape[-1]},); got shape {value.shape}")
    if not (np.isfinite(value) & (value >= 0)).all():
        raise ValueError(f"{name} is a variance in m^2: finite and not negative; got {value}")
    return np.broadcast_to(value, z.shape[:-2] + z.shape[-1:]).ravel()


@kernel
def _filter(z, q, r, full, zero, biweight, danish, filtered):
    """Write level, variance, innovation, its sigma and weight into filtered (5, T, columns)."""
    level, variance, innovation, sigma, weight = filtered[0], filtered[1], filtered[2], filtered[3], filtered[4]
    for k in range(len(z)):
        for j in range(len(q)):  # axes within: the processor works on all of them at once
            x, P = math.nan, math.nan
            if k > 0:
                x, P = level[k - 1][j], variance[k - 1][j] + q[j]
            if x != x and z[k][j] == z[k][j]:
                x, P = z[k][j], r[j]
            v, s, eta = z[k][j] - x, math.sqrt(P + r[j]), 0.0
            if v == v:
                eta = equivalent_weight(abs(v) / s, full, zero, biweight, danish)
            if eta > 0.0:
                G = P / (eta * P + r[j])  # K = eta G; r / eta may be past all numbers
                x, P = x + eta * G * v, r[j] * G
            level[k][j], variance[k][j], innovation[k][j], sigma[k][j], weight[k][j] = x, P, v, s, eta


@kernel
def _smooth(level, variance, q, smoothed):
    """Write level and variance given all epochs into smoothed (2, T, columns), from those given the epochs before."""
    x, P = smoothed[0], smoothed[1]
    for k in range(len(level) - 1, -1, -1):
        for j in range(len(q)):
            x[k][j], P[k][j] = level[k][j], variance[k][j]
            if k < len(level) - 1 and P[k][j] > 0.0:
                C = P[k][j] / (P[k][j] + q[j])
                x[k][j] += C * (x[k + 1][j] - level[k][j])
                P[k][j] += C * C * (P[k + 1][j] - variance[k][j] - q[j])
