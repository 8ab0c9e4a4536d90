"""Times against published dates, Python's own calendar, and round trips."""

import json
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gnsslab.gnss.times import (
    SECONDS_PER_WEEK,
    add_seconds,
    gps_from_scale,
    gps_from_utc,
    gps_time,
    iso_text,
    leap_seconds,
    seconds_between,
    week_and_tow,
)

REFERENCE = json.loads((Path(__file__).parents[1] / "reference" / "satellites.json").read_text())["time"]
NANOSECOND = 1e-9

labels = st.integers(0, 3_000_000_000 * 10**9).map(lambda ns: np.datetime64("1980-01-06", "ns") + np.timedelta64(ns, "ns"))


@pytest.mark.parametrize("row", [row for row in REFERENCE["rows"] if "week" in row], ids=lambda row: row["gpst"])
def test_published_weeks(row):
    assert gps_time(row["week"], row["tow"]) == np.datetime64(row["gpst"])
    week, tow = week_and_tow(np.datetime64(row["gpst"]))
    assert (week, tow) == (row["week"], row["tow"])


@pytest.mark.parametrize("row", REFERENCE["rows"][3:], ids=lambda row: row["gpst"])
def test_published_leap_seconds(row):
    assert gps_from_utc(np.datetime64(row["utc"])) == np.datetime64(row["gpst"])


def test_published_row_that_lies_in_a_leap_second():
    """GPS time 1992-07-01 00:00:07 was 23:59:60 UTC, which RTKLIB writes as 00:00:00: no label stands for it, and it stays free."""
    in_the_leap_second = np.datetime64(REFERENCE["rows"][2]["gpst"])
    midnight = np.datetime64(REFERENCE["rows"][2]["utc"])
    assert gps_from_utc(midnight - np.timedelta64(1, "s")) + np.timedelta64(1, "s") == in_the_leap_second
    assert gps_from_utc(midnight) - np.timedelta64(1, "s") == in_the_leap_second


def test_todays_leap_seconds_and_beidou_time():
    assert leap_seconds(np.datetime64("2024-06-24")) == REFERENCE["gpst_minus_utc_s_since_2017"]
    behind = seconds_between(np.datetime64("2024-06-24"), gps_from_scale(np.datetime64("2024-06-24"), "BDT"))
    assert behind == REFERENCE["bdt_minus_gpst_s"]


@given(st.integers(0, 4000), st.integers(0, SECONDS_PER_WEEK - 1))
def test_week_and_second_are_those_of_pythons_calendar(week, tow):
    expected = datetime(1980, 1, 6) + timedelta(weeks=week, seconds=tow)
    assert gps_time(week, float(tow)) == np.datetime64(expected)


@given(labels)
def test_week_and_tow_and_back(label):
    week, tow = week_and_tow(label)
    assert 0 <= tow <= SECONDS_PER_WEEK
    assert gps_time(week, tow) == label


@given(st.integers(0, 4000), st.integers(0, SECONDS_PER_WEEK - 1))
def test_whole_seconds_stay_whole(week, tow):
    assert week_and_tow(gps_time(week, float(tow)))[1] == tow


@given(labels, st.integers(-(10**15), 10**15))
def test_difference_undoes_addition_to_the_nanosecond(label, nanoseconds):
    """Up to 1e6 s (12 days) a float of seconds holds nanoseconds."""
    later = add_seconds(label, nanoseconds * 1e-9)
    assert (later - label).astype(int) == nanoseconds
    assert seconds_between(later, label) == pytest.approx(nanoseconds * 1e-9, abs=NANOSECOND / 8)


@given(labels)
def test_leap_seconds_grow_by_at_most_one_a_step_and_gps_time_never_goes_back(label):
    second = np.timedelta64(1, "s")
    assert leap_seconds(label + second) - leap_seconds(label) in (0, 1)
    assert gps_from_utc(label + second) > gps_from_utc(label)


@pytest.mark.parametrize(("scale", "ahead"), [("GPS", 0), ("GAL", 0), ("QZS", 0), ("IRN", 0), ("BDT", 14), ("GLO", 18), ("UTC", 18)])
def test_time_scales(scale, ahead):
    label = np.array(["2024-06-24T08:20:00", "2024-06-24T08:20:01"], dtype="datetime64[ns]")
    assert seconds_between(gps_from_scale(label, scale), label).tolist() == [ahead, ahead]


def test_an_unknown_time_scale_is_named():
    with pytest.raises(ValueError, match="unknown time scale 'TAI': expected GPS"):
        gps_from_scale(np.datetime64("2024-06-24"), "TAI")


@given(labels)
def test_text_is_within_half_a_millisecond(label):
    text = iso_text(label)
    assert len(text) == 23
    assert abs((np.datetime64(text, "ns") - label).astype(int)) <= 500_000
