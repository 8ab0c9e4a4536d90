"""Fewer epochs of one receiver: a span of time, one epoch in so many; cycle slips in between are kept."""

from dataclasses import replace

import numpy as np

from gnsslab.gnss.observations import SLIP
from gnsslab.gnss.times import add_seconds, seconds_between

CLOCK_OFFSET = 0.01  # [s]: receivers' tags may stray this far from the full epoch (usually below 1 ms)


def in_span(time, start=None, end=None):
    """Return which of the labels (T,) lie from start to end, both included; None leaves that side open."""
    inside = np.ones(len(time), dtype=bool)
    if start is not None:
        inside &= time >= start - _tolerance()
    if end is not None:
        inside &= time <= end + _tolerance()
    return inside


def on_grid(time, origin, every):
    """Return which of the labels (T,) lie on the grid `origin + k * every` [s], to within the receivers' clock offsets.

    >>> on_grid(np.array(["2024-01-01T00:00:00", "2024-01-01T00:00:15"], "M8[ns]"), np.datetime64("2024-01-01"), 30.0).tolist()
    [True, False]
    """
    steps = seconds_between(time, origin) / every
    return np.abs(steps - np.round(steps)) * every <= min(CLOCK_OFFSET, every / 4)


def keep_epochs(observations, keep):
    """Return the observations at the epochs marked in `keep` (T,).

    A cycle slip flagged at an epoch that is left out is carried to the satellite's next epoch that stays.
    """
    keep = np.asarray(keep, dtype=bool)
    tables = {system: _kept_rows(table, keep) for system, table in observations.tables.items()}
    return replace(
        observations,
        time=observations.time[keep],
        tables={system: table for system, table in tables.items() if len(table.epoch)},
        power_failure=_carried(observations.power_failure, keep),
    )


def _tolerance():
    return add_seconds(np.datetime64(0, "ns"), CLOCK_OFFSET) - np.datetime64(0, "ns")


def _carried(flag, keep):
    """Return the flags (T,) of the kept epochs, each true where any epoch since the kept one before it had it."""
    count = np.cumsum(flag)[keep]
    return np.diff(count, prepend=0) > 0


def _kept_rows(table, keep):
    slips = _slips_since_kept(table, keep)
    rows = keep[table.epoch]
    return replace(
        table,
        epoch=(np.cumsum(keep) - 1)[table.epoch[rows]].astype(table.epoch.dtype),
        number=table.number[rows],
        value=table.value[rows],
        lli=np.where(slips[rows], table.lli[rows] | SLIP, table.lli[rows]).astype(np.uint8),
        ssi=table.ssi[rows],
    )


def _slips_since_kept(table, keep):
    """Return (k, n): whether the satellite slipped at this row or at a left-out row since its last kept one."""
    slips = (table.lli & SLIP).astype(bool)
    for number in np.unique(table.number):
        rows = np.flatnonzero(table.number == number)
        kept = rows[keep[table.epoch[rows]]]
        count = np.cumsum(slips[rows], axis=0)[keep[table.epoch[rows]]]
        slips[kept] = np.diff(count, axis=0, prepend=np.zeros((1, slips.shape[1]), dtype=count.dtype)) > 0
    return slips
