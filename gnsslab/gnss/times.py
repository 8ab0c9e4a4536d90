"""Time: GPS time as `datetime64[ns]` labels, week and time of week for arithmetic.

One float of GPS seconds would be too coarse (spacing 2.4e-7 s = 71 m of light), so a label is an integer count of
nanoseconds and every difference is taken between labels before it becomes a float.
"""

import numpy as np

GPS_EPOCH = np.datetime64("1980-01-06T00:00:00", "ns")
SECONDS_PER_WEEK = 604_800
NANOSECOND = np.timedelta64(1, "ns")
BDT_BEHIND_GPS = np.timedelta64(14, "s")  # GPST = BDT + 14 s (BeiDou ICD: BDT started aligned to UTC of 2006-01-01)
BDT_WEEK_ZERO = 1356  # GPS week in which BDT week 0 begins

# UTC dates from which GPST - UTC has grown by one second (IERS Bulletin C).
_LEAP_DATES = np.array(
    """
    1981-07-01 1982-07-01 1983-07-01 1985-07-01 1988-01-01 1990-01-01 1991-01-01 1992-07-01 1993-07-01
    1994-07-01 1996-01-01 1997-07-01 1999-01-01 2006-01-01 2009-01-01 2012-07-01 2015-07-01 2017-01-01
    """.split(),  # noqa: SIM905
    dtype="datetime64[ns]",
)


def gps_time(week, tow):
    """Return the GPS time label of a week number and a time of week [s]: t = epoch + week * 7 d + tow.

    >>> print(gps_time(1400, 86400.0))
    2006-11-06T00:00:00.000000000
    """
    whole = np.floor(tow).astype(np.int64)
    fraction_ns = np.round((np.asarray(tow) - whole) * 1e9).astype(np.int64)
    nanoseconds = (np.asarray(week, dtype=np.int64) * SECONDS_PER_WEEK + whole) * 1_000_000_000 + fraction_ns
    return GPS_EPOCH + nanoseconds.astype("timedelta64[ns]")


def week_and_tow(time):
    """Return week number (int) and time of week [s] of GPS time labels.

    >>> week, tow = week_and_tow(np.datetime64("2006-11-06T00:00:00.5"))
    >>> int(week), float(tow)
    (1400, 86400.5)
    """
    nanoseconds = (np.asarray(time, dtype="datetime64[ns]") - GPS_EPOCH).astype(np.int64)
    week, rest = np.divmod(nanoseconds, SECONDS_PER_WEEK * 1_000_000_000)
    return week, rest / 1e9  # a division is exact for whole seconds, a product with 1e-9 is not


def seconds_between(later, earlier):
    """Return later - earlier [s] as float, exact to the nanosecond for spans up to 100 days.

    >>> float(seconds_between(np.datetime64("2024-01-01T00:00:01"), np.datetime64("2024-01-01")))
    1.0
    """
    difference = np.asarray(later, dtype="datetime64[ns]") - np.asarray(earlier, dtype="datetime64[ns]")
    return difference / NANOSECOND / 1e9


def usual_step(time):
    """Return the usual spacing of labels [s], the median, and 1 s where there are fewer than two.

    >>> usual_step(np.array(["2024-01-01T00:00:00", "2024-01-01T00:00:30"], "M8[ns]"))
    30.0
    """
    return float(np.median(seconds_between(time[1:], time[:-1]))) if len(time) > 1 else 1.0


def add_seconds(time, seconds):
    """Return time labels moved by seconds (float, rounded to the nanosecond).

    >>> print(add_seconds(np.datetime64("2024-01-01T00:00:00"), 0.25))
    2024-01-01T00:00:00.250000000
    """
    nanoseconds = np.round(np.asarray(seconds) * 1e9).astype("timedelta64[ns]")
    return np.asarray(time, dtype="datetime64[ns]") + nanoseconds


def leap_seconds(utc):
    """Return GPST - UTC [s] at UTC labels (IERS Bulletin C; 18 s since 2017-01-01).

    >>> int(leap_seconds(np.datetime64("2017-01-01"))), int(leap_seconds(np.datetime64("2016-12-31")))
    (18, 17)
    """
    return np.searchsorted(_LEAP_DATES, np.asarray(utc, dtype="datetime64[ns]"), side="right")


def gps_from_utc(utc):
    """Return GPS time of UTC labels.

    >>> print(gps_from_utc(np.datetime64("2005-12-31T23:59:47")))
    2006-01-01T00:00:00.000000000
    """
    utc = np.asarray(utc, dtype="datetime64[ns]")
    return utc + leap_seconds(utc).astype("timedelta64[s]")


def gps_from_scale(time, scale):
    """Return GPS time of labels in a RINEX time scale: GPS, GAL, QZS, IRN (all GPS time to tens of ns), BDT or GLO (UTC).

    >>> print(gps_from_scale(np.datetime64("2024-01-01T00:00:00"), "BDT"))
    2024-01-01T00:00:14.000000000
    """
    time = np.asarray(time, dtype="datetime64[ns]")
    if scale in ("GPS", "GAL", "QZS", "IRN"):
        return time
    if scale == "BDT":
        return time + BDT_BEHIND_GPS
    if scale in ("GLO", "UTC"):
        return gps_from_utc(time)
    raise ValueError(f"unknown time scale {scale!r}: expected GPS, GAL, QZS, IRN, BDT, GLO or UTC")


def iso_text(time):
    """Return `YYYY-MM-DDTHH:MM:SS.sss` of one GPS time label, rounded to the millisecond, as in every table we write.

    >>> iso_text(np.datetime64("2024-06-24T08:20:00.9996"))
    '2024-06-24T08:20:01.000'
    """
    rounded = np.datetime64(time, "ns") + np.timedelta64(500_000, "ns")
    return str(rounded.astype("datetime64[ms]"))
