"""Judging: at which epochs the integers that a filter found are believed, and what its residuals say of the noise assumed.

Each verb takes the Outcome of `ambiguity_filter`.
"""

import numpy as np

ODDS = 1000.0  # of the best integers against the second best, at which the best are believed
_WORST_FIT = 9.0  # carriers with the right integers fit each other within three times their assumed sigma, also those of cheap antennas
_PRIOR_FREEDOM = 30.0  # epochs of a few satellites: three to ten


def ratio_threshold(n, acceptance=16.0):
    """Return the least ratio of second best to best squared norm at which the best of n integers is believed: max(1.5, 1 + c / n).

    The posterior odds of best against second best are exp((s2 - s1) / 2). With the noise level judged by s1 / n itself this
    asks (s2 - s1) / (s1 / n) >= c, odds of e^8 = 3000 at c = 16: a ratio of 3 at n = 8 as usual, 5 at n = 4, less where many
    integers agree. Close to the thresholds fitted to fixed failure rates in RTKLIB demo5 (1.7 at 20, 1.4 at 30 for a nominal 3).

    >>> ratio_threshold(np.array([4, 8, 64])).tolist()
    [5.0, 3.0, 1.5]
    """
    return np.maximum(1.5, 1.0 + acceptance / np.maximum(n, 1))


def believed_by_ratio(outcome, integers, acceptance):
    """Return at which epochs (T,) the ratio speaks for the best of so many integers, and the carriers fit each other."""
    return (outcome.ratio >= ratio_threshold(integers, acceptance)) & (outcome.misfit <= _WORST_FIT * (outcome.freedom + 1))


def believed_by_odds(outcome, integers):
    """Return at which epochs (T,) the odds speak for the best of so many integers, and float values and carriers fit them.

    odds = exp((s2 - s1) / 2 s^2) >= 1000,    s^2 = max(1, median of s1 / n over the run):  for filters whose noise is known. A filter
    that has seen more than single epochs is often too sure of itself, and s^2 says by how much.
    """
    first, second = outcome.cost, outcome.cost * outcome.ratio
    searched = outcome.ratio > 0
    level = max(1.0, float(np.median(first[searched] / integers[searched]))) if searched.any() else 1.0
    fits = (first <= _WORST_FIT * (integers + 1)) & (outcome.misfit <= _WORST_FIT * (outcome.freedom + 1))
    return searched & fits & (second - first >= 2 * np.log(ODDS) * level)


def variance_factor(outcome, is_fixed):
    """Return the factor by which the assumed variances are to be multiplied, judged by the carrier residuals of all fixed epochs.

    (nu + sum of misfits) / (nu + sum of their expectations), with nu = 30 for what was assumed beforehand, so that a single
    epoch changes little (variance component estimation with one component, with a prior).
    """
    expected = outcome.freedom[is_fixed].sum()
    return (_PRIOR_FREEDOM + outcome.misfit[is_fixed].sum()) / (_PRIOR_FREEDOM + expected)
