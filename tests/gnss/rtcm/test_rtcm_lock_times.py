"""Lock times: the tables of the standard, and slips against a receiver whose lock is known."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from gnsslab.gnss.rtcm.lock_times import extended_lock_range, has_slipped, lock_range

# RTCM 10403.3, table 3.5-75: indicators from, to; the shortest lock time is a * i - b [ms]
EXTENDED = [
    (0, 63, 1, 0), (64, 95, 2, 64), (96, 127, 4, 256), (128, 159, 8, 768), (160, 191, 16, 2048), (192, 223, 32, 5120),
    (224, 255, 64, 12288), (256, 287, 128, 28672), (288, 319, 256, 65536), (320, 351, 512, 147456), (352, 383, 1024, 327680),
    (384, 415, 2048, 720896), (416, 447, 4096, 1572864), (448, 479, 8192, 3407872), (480, 511, 16384, 7340032),
    (512, 543, 32768, 15728640), (544, 575, 65536, 33554432), (576, 607, 131072, 71303168), (608, 639, 262144, 150994944),
    (640, 671, 524288, 318767104), (672, 703, 1048576, 671088640), (704, 704, 2097152, 1409286144),
]  # fmt: skip


def test_extended_ranges_are_those_of_the_standard():
    for first, last, a, b in EXTENDED:
        indicator = np.arange(first, last + 1)
        assert np.array_equal(extended_lock_range(indicator)[0], a * indicator - b)


def test_ranges_leave_no_gap():
    for shortest, longest in (lock_range(np.arange(16)), extended_lock_range(np.arange(705))):
        assert np.array_equal(longest[:-1], shortest[1:])
        assert shortest[0] == 0
        assert longest[-1] == np.inf


def test_reserved_indicators_say_nothing():
    shortest, longest = extended_lock_range([705, 1023])
    assert not has_slipped(shortest, longest, 1e9).any()


@settings(max_examples=200, deadline=None)
@given(
    lock=st.floats(0, 1e7),
    elapsed=st.integers(1, 200_000),
    lost=st.one_of(st.none(), st.floats(0, 1)),
    extended=st.booleans(),
)
def test_no_slip_is_invented_and_a_smaller_indicator_is_one(lock, elapsed, lost, extended):
    """A receiver that kept lock, or lost it at a share `lost` of the time between two epochs."""
    later = lock + elapsed if lost is None else elapsed * (1 - lost)
    ranges = extended_lock_range(np.arange(705)) if extended else lock_range(np.arange(16))
    before, now = (np.searchsorted(ranges[0], time, side="right") - 1 for time in (lock, later))
    found = has_slipped(ranges[0][before], ranges[1][now], elapsed)
    if lost is None:
        assert not found
    elif now < before:
        assert found


def test_a_loss_that_the_indicator_alone_does_not_show():
    """8.2 to 16.4 s of lock now as 15 s before: it cannot have been kept."""
    shortest, longest = lock_range(9)
    assert has_slipped(shortest, longest, 15_000)
    assert not has_slipped(shortest, longest, 8_000)
