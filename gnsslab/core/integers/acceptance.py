"""Acceptance tests: is the best integer vector so much better than the second that it may be trusted?

A test keeps the fix or goes back to the float solution. It never makes a fix better; it moves shares between three
outcomes: fixed and right, fixed and wrong (failure), float. A threshold alone says nothing about these shares: they
depend on the model (its covariance Q). The fixed failure rate test asks the other way round: how often may a fix be
wrong, of all cases? A simulation of the model at hand answers with the threshold.
"""

import math
from typing import NamedTuple

import numpy as np

from gnsslab.core.integers.decorrelation import checked_problem, ltdl
from gnsslab.core.integers.simulation import simulate_fixes, wilson_interval


def ratio_test(norms, threshold):
    """Return True (...) where the second best integer vector is so many times farther off than the best.

    |a_hat - a_2|^2 / |a_hat - a_1|^2 >= c

    norms: (..., 2 or more) squared distances, best first, as of an IntegerSolution; threshold: c >= 1. This is RTKLIB's
    way round; the LAMBDA toolbox's mu is 1 / c. An infinite norm (a search cut short) is never accepted. Raises
    ValueError for a threshold below 1, which would accept everything.
    Source: Euler and Schaffrin (1991), IAG Symposia 107:285-295; Teunissen and Verhagen (2009), Survey Review 41:138-151.

    >>> ratio_test([[1.0, 2.9], [1.0, 3.1]], 3.0).tolist()
    [False, True]
    """
    best, second = _two_norms(norms)
    if not threshold >= 1:
        raise ValueError(f"the ratio is second / best, so its threshold must be 1 or more, not {threshold:g} (of best / second take the inverse)")
    return np.isfinite(second) & (second >= threshold * best)


def difference_test(norms, threshold):
    """Return True (...) where the squared distances of the two best integer vectors differ by the threshold or more.

    |a_hat - a_2|^2 - |a_hat - a_1|^2 >= c

    norms: (..., 2 or more), best first; c >= 0. Under normal noise the best is then exp(c / 2) times as likely as the second.
    Raises ValueError for a negative threshold.
    Source: Tiberius and de Jonge (1995), DSNS-95, paper 30.

    >>> difference_test([[1.0, 9.0], [1.0, 14.0]], 12.0).tolist()
    [False, True]
    """
    best, second = _two_norms(norms)
    _check_not_negative(threshold)
    return np.isfinite(second) & (second - best >= threshold)


def projector_test(a_hat, Q, candidates, threshold):
    """Return True (...) where the float ambiguities have not moved far from the best towards the second best.

    (a_2 - a_1)' Q^-1 (a_hat - a_1) / |a_2 - a_1|_Q <= c

    The left side is a length in sigmas, from 0 to half of the way |a_2 - a_1|_Q, where the two change places. a_hat:
    (..., n) [cycles]; Q: (n, n) [cycles^2]; candidates: (..., 2 or more, n), best first; c >= 0. Two equal candidates (a search
    cut short) are never accepted. Raises ValueError for a negative threshold, where Q is no covariance matrix, or where
    shapes do not fit.
    Source: Han (1997), J. Geodesy 71:351-361; Verhagen and Teunissen (2006), J. Guidance, Control, and Dynamics 29:981-991.

    >>> candidates = [[0, 0], [1, 0]]
    >>> [bool(projector_test([x, 0.4], 0.04 * np.eye(2), candidates, 1.5)) for x in (0.2, 0.4)]      # 1 and 2 sigma
    [True, False]
    """
    (a_hat, Q), candidates = checked_problem(a_hat, Q), np.asarray(candidates, dtype=np.float64)
    _check_not_negative(threshold)
    if candidates.ndim < 2 or candidates.shape[-1] != len(Q) or candidates.shape[-2] < 2:
        raise ValueError(f"candidates must be (..., 2 or more, {len(Q)}), the best and the second best; they have shape {candidates.shape}.")
    L, d = ltdl(Q)
    a_1, a_2 = candidates[..., 0, :], candidates[..., 1, :]
    moved, way = (np.linalg.solve(L.T, x[..., None])[..., 0] / np.sqrt(d) for x in (a_hat - a_1, a_2 - a_1))  # in sigmas
    length = np.linalg.norm(way, axis=-1)
    return (length > 0) & (np.vecdot(way, moved) <= threshold * length)


class RatioThreshold(NamedTuple):
    """A threshold of the ratio test, and what it does with simulated fixes of the model it was made for."""

    ratio: float  # accept where second / best is this or more
    failure_rate: float  # fixed and wrong, of all samples
    fix_rate: float  # fixed, of all samples
    success_rate: float  # of least squares without a test
    samples: int
    interval: tuple  # of the ratio, 95 %: simulated again, the threshold would mostly lie in here

    @property
    def mu(self):
        """The threshold the other way round, as in TU Delft's LAMBDA: accept where best / second <= mu."""
        return 1.0 / self.ratio

    @property
    def sigma(self):
        """Standard deviation of the counted failure rate."""
        low, high = wilson_interval(self.failure_rate * self.samples, self.samples, 1.0)
        return (high - low) / 2.0

    def __repr__(self):
        rates = f"fixed {self.fix_rate:.1%}, failed {self.failure_rate:.2%} +- {self.sigma:.2%} of {self.samples} samples"
        return f"RatioThreshold: {self.ratio:.3g} ({self.interval[0]:.3g} to {self.interval[1]:.3g}); {rates}"


def failure_rate_threshold(Q, failure_rate, rng, samples=100_000):
    """Find the smallest threshold of the ratio test with which no more than failure_rate of all cases are fixed and wrong.

    min c >= 1:  P(ratio >= c and a_1 wrong) <= P_f

    Found by simulation of float ambiguities with covariance Q (n, n) [cycles^2], normal and without bias; where least
    squares alone fails as rarely as that, the threshold is 1: accept outright. Returns a RatioThreshold.
    Raises ValueError where less than one failure is to be expected: then nothing could be counted.
    Source: Teunissen and Verhagen (2009), Survey Review 41:138-151; Verhagen and Teunissen (2013), GPS Solutions 17:535-548.

    >>> failure_rate_threshold([[0.0004]], 0.001, np.random.default_rng(1), samples=10_000).ratio      # half a cycle is 25 sigma
    1.0
    """
    check_countable(failure_rate, samples)
    fixes = simulate_fixes(Q, rng, samples)
    return threshold_of_fixes(fixes.ratio, fixes.is_right, failure_rate)


def threshold_of_fixes(ratio, is_right, failure_rate):
    """Return the RatioThreshold of fixes whose truth is known: ratio (N,), is_right (N,) bool.

    The step of `failure_rate_threshold` after the simulation, for those who have one already. Raises ValueError where
    the two do not fit, or a ratio is below 1 or NaN.

    >>> round(threshold_of_fixes([1.1, 1.5, 3.0, 4.0], [False, False, True, True], 0.25).ratio, 9)      # one of four may fail
    1.1
    """
    ratio, is_right = np.asarray(ratio, dtype=np.float64), np.asarray(is_right, dtype=bool)
    if ratio.ndim != 1 or ratio.shape != is_right.shape or not np.all(ratio >= 1):
        shapes = f"{ratio.shape} and {is_right.shape}"
        raise ValueError(f"ratio (N,) must hold second / best, 1 or more, of each fix in is_right (N,); they have shapes {shapes}.")
    ratio = np.where(np.isinf(ratio), 0.0, ratio)  # a search cut short proves nothing: never accepted, as in `ratio_test`
    samples = len(ratio)
    check_countable(failure_rate, samples)
    wrong = np.sort(ratio[~is_right])[::-1]
    allowed = math.floor(failure_rate * samples + 1e-9)  # 0.29 * 100 is a little less than 29
    c = _above_all_but(wrong, allowed)
    spread = 2.0 * math.sqrt(allowed)  # of a count of rare cases
    return RatioThreshold(
        ratio=c,
        failure_rate=float(np.mean(~is_right & (ratio >= c))),
        fix_rate=float(np.mean(ratio >= c)),
        success_rate=float(np.mean(is_right)),
        samples=samples,
        interval=(_above_all_but(wrong, allowed + spread), _above_all_but(wrong, max(allowed - spread, 0.0))),
    )


def _above_all_but(wrong, count):
    """Return the smallest threshold that `count` of the wrong ratios (descending) reach, 1 where there are no more."""
    count = math.floor(count)
    return 1.0 if count >= len(wrong) else max(float(np.nextafter(wrong[count], math.inf)), 1.0)


def _two_norms(norms):
    norms = np.asarray(norms, dtype=np.float64)
    if norms.ndim == 0 or norms.shape[-1] < 2:
        raise ValueError(f"norms must have the best and the second best in its last axis (n_best=2 or more); it has shape {norms.shape}.")
    return norms[..., 0], norms[..., 1]


def _check_not_negative(threshold):
    if not threshold >= 0:
        raise ValueError(f"the threshold must be 0 or more; it is {threshold:g}")


def check_countable(failure_rate, samples):
    """Say where a failure rate is none, or so small that in so many samples there is nothing to count."""
    if not 0 < failure_rate < 1:
        raise ValueError(f"failure_rate is a share of all cases, more than 0 and less than 1; it is {failure_rate:g}")
    if failure_rate * samples < 1:
        raise ValueError(f"{samples} samples hold less than one failure at a rate of {failure_rate:g}: use {math.ceil(10 / failure_rate)} or more")
