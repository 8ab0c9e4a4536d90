"""The rule by which a number of a paper is said to be reproduced or not; every verdict of a report comes from here."""

from typing import NamedTuple

import numpy as np

TOLERANCE = 0.25
FACTOR = 2.0
RULE = (
    "Reproduced: the median over the seeds is within 25 % of the paper's value (of the nearer end where the paper gives a range), or the paper's "
    "value lies within the middle half of the seeds. Near: within a factor of 2. Otherwise: not reproduced. "
    "A claim is put as a number too; it holds where the median is within 25 % of that number or range, else it does not hold."
)
_NEVER = 1e300  # later than all else, and still a number, so that quartiles can be taken


class Item(NamedTuple):
    """One stated number of a paper, or a claim put as a number, and where ours is found."""

    item: str
    quantity: str
    unit: str
    paper_value: float | tuple[float, float]  # or a range; its upper end may be infinite
    source: str  # where the value stands
    key: str  # of our numbers
    cause: str = ""  # why it is not reproduced, where it is not
    is_claim: bool = False


def judged(paper, item, values):
    """Return the line of a report, a dict ready for JSON, of an Item and our values (seeds,), NaN where a seed has none."""
    finite = np.asarray(values, dtype=float)
    finite = finite[np.isfinite(finite)]
    words = verdict(item.paper_value, finite, item.is_claim)
    return {
        "paper": paper, "item": item.item, "quantity": item.quantity, "unit": item.unit,
        "paper_value": _plain(item.paper_value), "source": item.source,
        "ours_mean": _number(np.mean, finite), "ours_sd": _number(_sd, finite), "ours_median": _number(np.median, finite),
        "ours_quartiles": [_number(lambda v, p=p: np.percentile(v, p), finite) for p in (25, 75)],
        "seeds": len(finite), "verdict": words, "cause": "" if words in GOOD else item.cause,
    }  # fmt: skip


def measured(paper, item, quantity, unit, values):
    """Return the line of a number of ours that no paper states: the same dict without a paper's value. NaN says never: later than all others."""
    values = np.asarray(values, dtype=float)
    finite = values[np.isfinite(values)]
    quartiles = np.percentile(np.where(np.isnan(values), _NEVER, values), [25, 50, 75])
    q1, median, q3 = (float(each) if each < _NEVER / 100 else None for each in quartiles)
    return {
        "paper": paper, "item": item, "quantity": quantity, "unit": unit, "paper_value": None, "source": "",
        "ours_mean": _number(np.mean, finite), "ours_sd": _number(_sd, finite), "ours_median": median, "ours_quartiles": [q1, q3],
        "seeds": len(values), "verdict": NOT_STATED, "cause": "",
    }  # fmt: skip


def verdict(paper_value, values, is_claim=False):
    """Return what the RULE says of our values (seeds,) beside a paper's, which is a number or a range (low, high).

    >>> verdict(0.5, np.array([0.4, 0.41, 0.42])), verdict(0.5, np.array([0.3])), verdict((2.0, 3.0), np.array([0.9]))
    ('reproduced', 'near', 'not reproduced')
    """
    low, high = paper_value if isinstance(paper_value, tuple) else (paper_value, paper_value)
    if not len(values):
        return DOES_NOT_HOLD if is_claim else NOT_REPRODUCED
    q1, median, q3 = np.percentile(values, [25, 50, 75])
    is_within = low - TOLERANCE * abs(low) <= median <= high + TOLERANCE * abs(high)
    if is_claim:
        return HOLDS if is_within else DOES_NOT_HOLD
    is_reproduced = is_within or (q1 <= high and q3 >= low)
    nearest = np.clip(median, low, high)
    is_near = nearest * median > 0 and 1 / FACTOR <= median / nearest <= FACTOR
    return REPRODUCED if is_reproduced else NEAR if is_near else NOT_REPRODUCED


REPRODUCED, NEAR, NOT_REPRODUCED, HOLDS, DOES_NOT_HOLD = "reproduced", "near", "not reproduced", "holds", "does not hold"
NOT_STATED = "not stated"  # by the paper
GOOD = (REPRODUCED, HOLDS)


def _plain(value):
    """Return a number, or a range as a list with None for an open end: JSON knows no infinity."""
    return [end if np.isfinite(end) else None for end in value] if isinstance(value, tuple) else value


def _number(measure, values):
    return float(measure(values)) if len(values) else None


def _sd(values):
    return np.std(values, ddof=1) if len(values) > 1 else 0.0
