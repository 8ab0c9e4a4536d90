"""The noise of a series learnt from the series itself: white and coloured parts of one axis, through its variogram.

A variogram is half the mean square of the differences z_(k+h) - z_k over the lag h. A level that stays, or that steps now and then, drops out
of it. White noise of variance w and a first-order Gauss-Markov series of variance c and correlation time tau [epochs] leave

    V(h) = w + c (1 - exp(-h / tau))

Medians instead of means keep gross errors and steps out (a robust variogram: Cressie and Hawkins 1980, Mathematical Geology 12:115-125).
"""

from typing import NamedTuple

import numpy as np
from scipy.special import ndtri

LAGS = np.array([1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256])
CORRELATION_TIMES = 2.0 ** np.arange(2, 8.1, 0.5)  # [epochs]: what is forgotten sooner than in four epochs is white for our purposes
MEDIAN_OF_SQUARE = 0.4549364  # of a standard normal number
MEDIAN_OF_SIZE = 0.6744898
FEWEST_DIFFERENCES = 8
TAIL = 0.01  # differences should be as large as a normal law says but for this share, or FEWEST_IN_TAIL of them: gross errors lie beyond
FEWEST_IN_TAIL = 5
LARGEST_FACTOR = 3.0  # a tail heavier than this is one of gross errors
SMALLEST_WHITE = 0.02  # of the whole variance: no receiver's solution is smoother from epoch to epoch


class ColouredNoise(NamedTuple):
    """The noise of one axis."""

    white: float  # [m^2] variance w
    coloured: float  # [m^2] variance c
    correlation: float  # [epochs] tau

    @property
    def long_run(self):
        """Variance of a mean of many epochs, times their number: w + 2 tau c [m^2]."""
        return self.white + 2 * self.correlation * self.coloured


def learn_noise(z):
    """Return the ColouredNoise of values z (T,) [m] of one axis, equally far apart; NaN where there is none.

    Where large differences are more frequent than the median promises (satellites rise and set, and with each the reflections change
    at once), both parts are enlarged until one difference in a hundred is beyond 2.58 sigma, threefold at most.
    Raises ValueError with fewer than 16 values.

    >>> rng = np.random.default_rng(1)
    >>> noise = learn_noise(0.02 * rng.standard_normal(4000))
    >>> round(float(np.sqrt(noise.white + noise.coloured)), 3)
    0.02
    """
    z = np.asarray(z, dtype=float)
    if np.isfinite(z).sum() < 2 * FEWEST_DIFFERENCES:
        raise ValueError(f"the noise of a series is learnt from {2 * FEWEST_DIFFERENCES} values or more; there are {int(np.isfinite(z).sum())}")
    lags, V = variogram(z)
    white, coloured, correlation = _fitted(lags, V)
    factor = tail_factor(z) ** 2
    white = max(white, SMALLEST_WHITE * (white + coloured))
    return ColouredNoise(white * factor, coloured * factor, correlation)


def variogram(z):
    """Return lags (m,) [epochs] and the variogram (m,) [m^2] of values z (T,), as far as there are four times as many values as the lag.

    >>> lags, V = variogram(np.tile([0.0, 1.0], 50))
    >>> lags[:4].tolist(), (V[:4] * 2 * MEDIAN_OF_SQUARE).round(9).tolist()
    ([1, 2, 3, 4], [1.0, 0.0, 1.0, 0.0])
    """
    squares = [(h, (z[h:] - z[:-h]) ** 2) for h in LAGS if len(z) >= 4 * h + FEWEST_DIFFERENCES]
    squares = [(h, square[np.isfinite(square)]) for h, square in squares]
    found = [(h, np.median(square) / MEDIAN_OF_SQUARE / 2) for h, square in squares if len(square) >= FEWEST_DIFFERENCES]
    lags, V = zip(*found, strict=True) if found else ((1,), (np.nanvar(z),))
    return np.array(lags), np.array(V)


def tail_factor(z):
    """Return how many times larger than a normal law of the same median the tail of the differences of z (T,) is; from 1 to 3."""
    factors = [1.0]
    for h in (1, 2, 4):
        size = np.abs(z[h:] - z[:-h])
        size = size[np.isfinite(size)]
        if len(size) >= 2 * FEWEST_DIFFERENCES and np.median(size) > 0:
            beyond = max(TAIL, FEWEST_IN_TAIL / len(size))
            factors.append(np.quantile(size, 1 - beyond) / ndtri(1 - beyond / 2) / (np.median(size) / MEDIAN_OF_SIZE))
    return min(max(factors), LARGEST_FACTOR)


def _fitted(lags, V):
    """Return white, coloured and correlation whose variogram is nearest to V, each lag by its relative error."""
    weight = 1 / np.maximum(V, np.finfo(float).tiny)
    fits = [_fitted_parts(1 - np.exp(-lags / tau), V, weight) for tau in CORRELATION_TIMES]
    best = int(np.argmin([misfit for _, _, misfit in fits]))
    return float(fits[best][0]), float(fits[best][1]), float(CORRELATION_TIMES[best])


def _fitted_parts(shape, V, weight):
    """Return w, c >= 0 that minimise the weighted |w + c shape - V|, and that misfit."""
    A, y = np.column_stack([weight, shape * weight]), V * weight
    if len(V) > 1:
        both, *_ = np.linalg.lstsq(A, y)
        if (both >= 0).all():
            return both[0], both[1], np.sum((A @ both - y) ** 2)
    alone = [max(a @ y / (a @ a), 0.0) for a in A.T]
    misfits = [np.sum((a * part - y) ** 2) for a, part in zip(A.T, alone, strict=True)]
    return (alone[0], 0.0, misfits[0]) if misfits[0] <= misfits[1] else (0.0, alone[1], misfits[1])
