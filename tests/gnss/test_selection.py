"""Selecting epochs: which stay, and that no cycle slip is lost."""

import numpy as np
import pytest

from gnsslab.gnss.observations import SLIP, ObservationHeader, Observations, SystemTable
from gnsslab.gnss.selection import in_span, keep_epochs, on_grid

START = np.datetime64("2024-06-24T08:20:00", "ns")
SECOND = np.timedelta64(1_000_000_000, "ns")
TIME = START + np.arange(6) * SECOND


def two_satellites(slips):
    """G01 at six epochs and G02 at the last three; `slips` is a list of (epoch, number)."""
    rows = [(epoch, number) for epoch in range(6) for number in (1, 2) if number == 1 or epoch >= 3]
    epoch, number = np.array(rows).T
    lli = np.array([[0, SLIP if row in slips else 0] for row in rows], dtype=np.uint8)
    value = np.array([[20e6 + 10 * e + n, 1e8 + 10 * e + n] for e, n in rows])
    table = SystemTable("G", ("C1C", "L1C"), epoch.astype(np.int32), number.astype(np.int16), value, lli, np.zeros_like(lli))
    return Observations(TIME, {"G": table}, ObservationHeader(), np.zeros(6, dtype=bool))


def flags(observations):
    table = observations.tables["G"]
    return {(int(e), int(n)): int(flag) for e, n, flag in zip(table.epoch, table.number, table.lli[:, 1], strict=True)}


def test_rows_follow_their_epochs():
    kept = keep_epochs(two_satellites([]), [True, False, False, True, False, True])
    assert kept.time.tolist() == TIME[[0, 3, 5]].tolist()
    table = kept.tables["G"]
    assert list(zip(table.epoch.tolist(), table.number.tolist(), strict=True)) == [(0, 1), (1, 1), (1, 2), (2, 1), (2, 2)]
    assert table.value[:, 0].tolist() == [20e6 + 1, 20e6 + 31, 20e6 + 32, 20e6 + 51, 20e6 + 52]


def test_a_slip_at_a_left_out_epoch_reaches_the_next_kept_one():
    kept = keep_epochs(two_satellites([(2, 1), (4, 2)]), [True, False, False, True, False, True])
    assert flags(kept) == {(0, 1): 0, (1, 1): SLIP, (1, 2): 0, (2, 1): 0, (2, 2): SLIP}


def test_a_power_failure_is_carried_too():
    observations = two_satellites([])
    observations.power_failure[4] = True
    assert keep_epochs(observations, [True, False, False, True, False, True]).power_failure.tolist() == [False, False, True]


def test_what_was_given_stays_as_it_was():
    observations = two_satellites([(2, 1)])
    before = observations.tables["G"].lli.copy()
    keep_epochs(observations, [True, False, False, True, False, True])
    assert (observations.tables["G"].lli == before).all()


@pytest.mark.parametrize(("offset_ms", "every", "kept"), [(0, 2, [0, 2, 4]), (1, 3, [0, 3]), (-1, 3, [0, 3])])
def test_grid_forgives_the_receivers_clock(offset_ms, every, kept):
    time = TIME + np.timedelta64(offset_ms, "ms")
    assert np.flatnonzero(on_grid(time, START, every)).tolist() == kept


def test_span_includes_both_ends():
    assert np.flatnonzero(in_span(TIME, START + 2 * SECOND, START + 4 * SECOND)).tolist() == [2, 3, 4]
    assert in_span(TIME).all()
