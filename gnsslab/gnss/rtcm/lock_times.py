"""Lock times: how long a phase has been tracked without a slip, as MSM says it, and what follows for slips.

The indicator stands for a range of times, shortest <= lock time < longest: DF402 (MSM4, MSM5; RTCM 10403.3 table 3.5-74)
has ranges that double, DF407 (MSM6, MSM7; table 3.5-75) ranges of 1 ms that double every 32 steps.
"""

import numpy as np

_LAST, _LAST_EXTENDED = 15, 704  # from here on the range has no end; what is above 704 is reserved


def lock_range(indicator):
    """Return the shortest and the longest lock time [ms] that DF402 can stand for: 2^(i + 4), 2^(i + 5).

    >>> [bound.tolist() for bound in lock_range([0, 1, 2, 15])]
    [[0.0, 32.0, 64.0, 524288.0], [32.0, 64.0, 128.0, inf]]
    """
    indicator = np.asarray(indicator, dtype=float)
    shortest = np.where(indicator > 0, 2.0 ** (indicator + 4), 0.0)
    return shortest, np.where(indicator < _LAST, 2.0 ** (indicator + 5), np.inf)


def extended_lock_range(indicator):
    """Return the shortest and the longest lock time [ms] that DF407 can stand for; a reserved indicator says nothing: 0, inf.

    >>> [bound.tolist() for bound in extended_lock_range([63, 64, 96, 704, 800])]
    [[63.0, 64.0, 128.0, 67108864.0, 0.0], [64.0, 66.0, 132.0, inf, inf]]
    """
    indicator = np.asarray(indicator, dtype=np.int64)
    doublings = np.maximum(indicator // 32 - 1, 0)
    shortest = 2.0**doublings * (indicator - 32 * doublings)
    longest = np.where(indicator < _LAST_EXTENDED, shortest + 2.0**doublings, np.inf)
    return np.where(indicator <= _LAST_EXTENDED, shortest, 0.0), longest


def has_slipped(shortest_before, longest_now, elapsed):
    """Return whether a lock was lost for certain between two epochs: longest_now <= shortest_before + elapsed.

    Without a slip the lock time has grown by the time elapsed [ms]; where even the longest time that the second indicator
    can stand for is not as long, lock was lost on the way. A smaller indicator always says so.

    >>> bool(has_slipped(64.0, 64.0, 15.0)), bool(has_slipped(64.0, 128.0, 15.0))
    (True, False)
    """
    return longest_now <= shortest_before + elapsed
