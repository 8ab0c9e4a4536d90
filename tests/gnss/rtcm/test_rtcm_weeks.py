"""Weeks: from ephemerides, else from the user, else from the file's date; over the end of a week, in every time scale."""

import os
from datetime import UTC, datetime

import numpy as np
import pytest
from rtcm_encoder import ephemeris, msm

from gnsslab.gnss.rtcm import read_rtcm
from gnsslab.gnss.times import gps_time

DAY = 86_400_000  # [ms]
ORBIT = {"sqrt_a": 5153 << 19}
AT_3, ONE = {3: {"whole": 70}}, {(3, 2): {"cn0": 40}}


def observed(system, clock):
    return msm(system, 4, clock, AT_3, ONE)


def epochs(log):
    return [str(time)[:23] for time in log.observations.time]


def test_beidou_counts_14_s_behind_and_names_its_week(read):
    log = read(ephemeris(1042, ORBIT | {"number": 3, "week": 1068, "toe": 489_600 // 8, "toc": 489_600 // 8}), observed("C", 489_601_000), start=None)
    assert epochs(log) == ["2026-06-26T16:00:15.000"]  # as RTKLIB dates the same week and time of week
    assert log.warnings == ()


@pytest.mark.parametrize(("message", "system", "unit"), [(1019, "G", 16), (1045, "E", 60), (1044, "J", 16)])
def test_other_ephemerides_name_it_too(read, message, system, unit):
    """GPS week 2424 is 1400 in Galileo's own count, and 376 in ten bits."""
    week = 1400 if system == "E" else 376
    made = ephemeris(message, ORBIT | {"number": 3, "week": week, "toe": 489_600 // unit, "toc": 489_600 // unit})
    log = read(made, observed(system, 489_615_000), start=None)
    assert epochs(log) == ["2026-06-26T16:00:15.000"]


@pytest.mark.parametrize(("year", "week"), [(2006, 1381), (2026, 2405)])
def test_ten_bits_of_week_are_resolved_by_the_day_or_the_date_of_the_file(tmp_path, year, week):
    path = tmp_path / "made.rtcm3"
    path.write_bytes(ephemeris(1019, ORBIT | {"number": 3, "week": week % 1024, "toe": 6, "toc": 6}) + observed("G", 1000))
    expected = gps_time(week, 1.0)
    os.utime(path, (0, datetime(year, 12, 31, tzinfo=UTC).timestamp()))  # copied within the year
    assert read_rtcm(path).observations.time[0] == expected
    assert read_rtcm(path, start=str(expected)[:10]).observations.time[0] == expected
    os.utime(path, (0, datetime(year + 15, 1, 1, tzinfo=UTC).timestamp()))  # 15 years later it is still the last such week
    assert read_rtcm(path).observations.time[0] == expected


def test_the_end_of_a_week_is_passed(read):
    clocks = [604_799_000, 0, 1000]
    log = read(*(observed("G", clock) for clock in clocks), start="2026-06-27")
    assert epochs(log) == ["2026-06-27T23:59:59.000", "2026-06-28T00:00:00.000", "2026-06-28T00:00:01.000"]
    beidou = read(*(observed("C", (clock - 14_000) % (7 * DAY)) for clock in clocks), start="2026-06-27")
    assert epochs(beidou) == epochs(log)


@pytest.mark.parametrize("week", [2424, 2425])
def test_at_the_end_of_a_week_the_majority_of_ephemerides_decides(read, week):
    """An ephemeris for the next week's first hour may name the week it was sent in, or the one it is for."""
    usual = [ephemeris(1019, ORBIT | {"number": k, "week": 2424 % 1024, "toe": 597_600 // 16, "toc": 597_600 // 16}) for k in (1, 2, 3)]
    early = ephemeris(1019, ORBIT | {"number": 4, "week": week % 1024, "toe": 0, "toc": 0})
    log = read(observed("G", 604_000_000), early, *usual, start=None)
    assert epochs(log) == ["2026-06-27T23:46:40.000"]
    assert [str(toe)[:19] for toe in log.ephemerides.toe] == ["2026-06-27T22:00:00"] * 3 + ["2026-06-28T00:00:00"]


@pytest.mark.parametrize("day", ["2026-06-25", "2026-06-26", "2026-06-28"])
def test_any_near_day_serves(read, day):
    assert epochs(read(observed("G", 489_615_000), start=day)) == ["2026-06-26T16:00:15.000"]


def test_without_anything_the_date_of_the_file_serves_and_is_said(tmp_path):
    path = tmp_path / "made.rtcm3"
    path.write_bytes(observed("G", 489_615_000) + observed("G", 489_616_000))
    os.utime(path, (0, datetime(2026, 6, 30, tzinfo=UTC).timestamp()))
    log = read_rtcm(path)
    assert epochs(log)[0] == "2026-06-26T16:00:15.000"
    assert log.warnings == (
        "no message says in which week the log was recorded; the date of the file serves (2026-06-30): where that is wrong, give --start",
    )


def test_a_day_that_contradicts_the_ephemerides_is_said(read):
    made = ephemeris(1042, ORBIT | {"number": 3, "week": 1068, "toe": 489_600 // 8, "toc": 489_600 // 8})
    log = read(made, observed("C", 489_601_000), start="2020-01-01")
    assert epochs(log) == ["2026-06-26T16:00:15.000"]
    assert log.warnings == ("the ephemerides in the log say that it begins on 2026-06-26; --start 2020-01-01 was not used",)


@pytest.mark.parametrize("day_of_week", [5, 7])
def test_glonass_time_of_day_joins_the_others(read, day_of_week):
    """16:00:15 GPS time is 15:59:57 UTC and 18:59:57 in GLONASS time; 21:00:10 GPS time is past midnight there."""
    clock = lambda hours, minutes, seconds: day_of_week << 27 | (hours * 3600 + minutes * 60 + seconds) * 1000  # noqa: E731
    log = read(observed("G", 489_615_000), observed("R", clock(18, 59, 57)), observed("G", 507_610_000), observed("R", clock(23, 59, 52)))
    assert epochs(log) == ["2026-06-26T16:00:15.000", "2026-06-26T21:00:10.000"]
    alone = read(observed("R", clock(23, 59, 52)), observed("R", clock(0, 0, 2)), start="2026-06-26")
    assert epochs(alone) == ["2026-06-26T21:00:10.000", "2026-06-26T21:00:20.000"]


def test_a_log_of_ephemerides_alone_dates_them_by_their_own_week(read):
    log = read(ephemeris(1019, ORBIT | {"number": 3, "week": 2424 % 1024, "toe": 489_600 // 16, "toc": 489_600 // 16}), start=None)
    assert str(log.ephemerides.toe[0])[:19] == "2026-06-26T16:00:00"
    assert np.isnat(log.ephemerides.transmission[0])
    assert len(log.observations.time) == 0
