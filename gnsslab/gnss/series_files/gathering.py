"""From the rows of a table, as they stand in it, to a Series; every row that is not one of its epochs is accounted for in words."""

from typing import NamedTuple

import numpy as np

from gnsslab.gnss.relative import Status
from gnsslab.gnss.series import Series
from gnsslab.gnss.times import iso_text

NOT_STATED = -1  # status of a row in a table without such a column


class Rows(NamedTuple):
    """Rows of a table in the order of the file; NaT and NaN where a field is empty."""

    time: np.ndarray  # (N,) datetime64[ns], GPS time
    enu: np.ndarray  # (N, 3) [m]
    sigma: np.ndarray  # (N, 3) [m]
    status: np.ndarray  # (N,) int8 of Status, or NOT_STATED
    ratio: np.ndarray  # (N,)

    def at(self, indices):
        """Return some of the rows."""
        return Rows(*(column[indices] for column in self))


NO_ROWS = Rows(np.zeros(0, "M8[ns]"), np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0, np.int8), np.zeros(0))


def joined(pieces):
    """Return the Rows of pieces of a table, one after the other."""
    return Rows(*map(np.concatenate, zip(*pieces, strict=True)))


def gathered(rows):
    """Return the Series of a table's Rows, and in words what became of rows that could not stand as they were."""
    total, notes = len(rows.time), []
    for mend in (_with_time, _with_position, _with_lawful_sigma, _in_order, _one_a_time):
        rows, said = mend(rows)
        notes += said
    if len(rows.time) < total:
        notes.append(f"{total} rows give {len(rows.time)} epochs")
    return Series(*rows), notes


def counted(number, what):
    """Return a number of things in words.

    >>> counted(1, "row"), counted(3, "row")
    ('1 row', '3 rows')
    """
    return f"{number} {what}{'' if number == 1 else 's'}"


def _with_time(rows):
    has_time = ~np.isnat(rows.time)
    lacking = int((~has_time).sum())
    return (rows.at(has_time), [f"{counted(lacking, 'row')} without a time left out"]) if lacking else (rows, [])


def _with_position(rows):
    """Make position and status agree: a row has three finite numbers and a solution, or neither."""
    finite, empty = np.isfinite(rows.enu).all(axis=1), np.isnan(rows.enu).all(axis=1)
    denied = rows.status == Status.NONE
    is_solved = finite & ~denied
    status = np.where(rows.status == NOT_STATED, Status.FIXED, rows.status)
    mended = rows._replace(
        enu=np.where(is_solved[:, None], rows.enu, np.nan),
        status=np.where(is_solved, status, Status.NONE).astype(np.int8),
    )
    infinite = np.isinf(rows.enu).any(axis=1)
    return mended, _said(
        (empty & ~denied, "without east, north and up kept as epochs without solution"),
        (~finite & ~empty & ~infinite, "with only one or two of east, north and up kept as epochs without solution"),
        (infinite, "with a position that is not finite kept as epochs without solution"),
        (finite & denied, "with a position but status none kept as epochs without solution"),
    )


def _with_lawful_sigma(rows):
    """Take a standard deviation that is zero, negative or infinite as not stated: a filter would divide by it."""
    unlawful = (rows.sigma <= 0) | np.isinf(rows.sigma)
    sigma = np.where(unlawful, np.nan, rows.sigma)
    return rows._replace(sigma=sigma), _said((unlawful.any(axis=1), "with a standard deviation of zero, below or infinite: taken as not stated"))


def _in_order(rows):
    """Sort by time; rows of one time keep their order, the best status first."""
    backward = np.flatnonzero(rows.time[1:] < rows.time[:-1])
    repeated = (rows.time[1:] == rows.time[:-1]).any()
    if not len(backward) and not repeated:
        return rows, []
    order = np.lexsort((-rows.status, rows.time))
    if not len(backward):
        return rows.at(order), []
    first = iso_text(rows.time[backward[0] + 1])
    return rows.at(order), [f"times go backward at {counted(len(backward), 'place')}, first to {first}: sorted"]


def _one_a_time(rows):
    """Keep one row of each time: the fixed one, else the float one, among equals the first in the file."""
    is_first = np.append(True, rows.time[1:] != rows.time[:-1])
    if is_first.all():
        return rows, []
    kept = np.flatnonzero(is_first)[np.cumsum(is_first) - 1]
    same = np.all((rows.enu == rows.enu[kept]) | np.isnan(rows.enu) & np.isnan(rows.enu[kept]), axis=1) & (rows.status == rows.status[kept])
    return rows.at(is_first), _said(
        (~is_first & same, "repeating another left out"),
        (~is_first & ~same, "at the time of another row, but with another position or status, left out: the fixed or else the first one is kept"),
    )


def _said(*cases):
    return [f"{counted(int(where.sum()), 'row')} {what}" for where, what in cases if where.any()]
