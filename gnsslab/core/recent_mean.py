"""The calmest mean of the latest solutions that is as quick as asked: weights h from the noise of the series.

    minimise h' Q h   with   sum of all h = 1,   sum of the first n = share,  for (n, share) in QUICK      (h = Q^-1 A (A' Q^-1 A)^-1 b)

Q: covariance of white and Gauss-Markov noise. A step is half in such a
mean within 10 epochs, nine tenths within 50, and all of it within 100: QUICK asks for a little more, as what is clipped costs time.
"""

import numpy as np

from gnsslab.core.jit import kernel

LONGEST = 100  # epochs
QUICK = ((10, 0.52), (46, 0.93))  # epochs after a step, and the share of it that is then in the mean


@kernel
def recent_mean(values, begin, end, axis, weights):
    """Return the weighted mean of column `axis` of values (n, d), the rows from `begin` to `end` - 1 being at hand, end > begin.

    weights (100,): of the latest row, the one before, ...; where there are fewer rows, the first weights alone.

    >>> round(recent_mean(np.array([[9.0], [2.0], [4.0]]), 1, 3, 0, np.array([0.3, 0.1, 0.6])), 9)
    3.5
    """
    total, weight = 0.0, 0.0
    for age in range(min(len(weights), end - begin)):
        total += weights[age] * values[end - 1 - age][axis]
        weight += weights[age]
    return total / weight


def covariance(white, coloured, correlation):
    """Return Q (100, 100) of white noise (variance w) and Gauss-Markov noise (variance c, tau epochs) together: w I + c exp(-|i - j| / tau)."""
    row = np.arange(LONGEST)
    return white * np.eye(LONGEST) + coloured * np.exp(-np.abs(row[:, None] - row) / correlation)


def quick_weights(Q):
    """Return the weights (100,) of the calmest mean that is as quick as QUICK asks, for noise of covariance Q (100, 100).

    >>> np.cumsum(quick_weights(covariance(1.0, 0.0, 1.0)))[[9, 45, 99]].round(9).tolist()
    [0.52, 0.93, 1.0]
    """
    age = np.arange(LONGEST)
    A = np.stack([np.ones(LONGEST), *(1.0 * (age < n) for n, _ in QUICK)], axis=1)
    W = np.linalg.solve(Q, A)
    return W @ np.linalg.solve(A.T @ W, [1.0, *(share for _, share in QUICK)])


def variances_of_mean(weights, Q):
    """Return the variance (100,) of the mean of 1, 2, ... 100 rows.

    >>> variances_of_mean(np.full(100, 1 / 100), np.eye(100))[[0, 1, 9]].round(9).tolist()
    [1.0, 0.5, 0.1]
    """
    h = np.tril(np.ones((LONGEST, LONGEST))) * weights
    h /= h.sum(axis=1, keepdims=True)
    return np.sum(h @ Q * h, axis=1)
