"""Columns of text as GPS time: calendar dates, week and time of week, decimal years, modified Julian dates, seconds."""

import re

import numpy as np

from gnsslab.gnss.rinex.errors import quoted
from gnsslab.gnss.series_files.lines import SeriesError
from gnsslab.gnss.series_files.numbers import is_missing, numbers
from gnsslab.gnss.times import GPS_EPOCH, gps_from_utc, gps_time

JST_AHEAD_OF_UTC = np.timedelta64(9, "h")
YEARS = "1950", "2199"  # outside, a label of 64 bits in nanoseconds may wrap around, and no one has measured
MJD_ZERO = np.datetime64("1858-11-17", "ns")
UNIX_ZERO = np.datetime64("1970-01-01", "ns")
MJD_RANGE = 40_000, 70_000  # 1968 to 2050
UNIX_LEAST = 1e9  # [s], 2001-09-09; seconds of a day, a week or a log are fewer
DAY = 86_400.0

_CALENDAR = re.compile(r"(\d{4})-(\d{1,2})-(\d{1,2})(?:[ T]+(\d{1,2}):(\d{1,2})(?::(\d{1,2})(\.\d*)?)?)?")
_ZONE = re.compile(r"(?:Z|([+-])(\d\d):?(\d\d))$")


def calendar(columns, lines, path):
    """Return GPS time labels of dates like 2024-06-24T08:20:00.5 or 2024/06/24 08:20:00.5, one column or date and time in two.

    A `Z` or an offset like +09:00 at the end says that it is UTC or a zone's time: converted with leap seconds.
    """
    texts = columns[0] if len(columns) == 1 else [f"{day.strip()} {clock.strip()}" for day, clock in zip(*columns, strict=True)]
    texts = [text.strip().replace("/", "-") for text in texts]
    return _calendar_with_zone(texts, lines, path)


def week_and_seconds(columns, lines, path):
    """Return GPS time labels of week numbers and times of week [s]."""
    week, tow = (numbers(column, lines, path, name) for column, name in zip(columns, ("week", "time of week"), strict=True))
    given = np.isfinite(week) & np.isfinite(tow)
    week, tow = np.where(given, week, 0), np.where(given, tow, 0.0)
    wrong = np.flatnonzero((week != np.floor(week)) | (week < 0) | (week > 9999) | (tow < 0) | (tow > 604_800))
    if len(wrong):
        found = f"{columns[0][wrong[0]].strip()} {columns[1][wrong[0]].strip()}"
        raise SeriesError(path, f"expected a GPS week and seconds from 0 to 604800, found {found}", lines[wrong[0]])
    return _where_given(given, gps_time(week.astype(np.int64), tow))


def decimal_years(columns, lines, path):
    """Return GPS time labels of years like 2011.1890: the fraction is that of the year, of 365 or 366 days; rounded to 1 ms."""
    values = numbers(columns[0], lines, path, "decimal year")
    given, values = _within(values, (float(YEARS[0]), float(YEARS[1])), "a year like 2011.189", columns[0], lines, path)
    whole = np.floor(values).astype(np.int64)
    begin, end = ((whole - 1970 + k).astype("datetime64[Y]").astype("datetime64[ms]") for k in (0, 1))
    passed = np.round((values - whole) * (end - begin).astype(np.int64)).astype("timedelta64[ms]")
    return _where_given(given, (begin + passed).astype("datetime64[ns]"))


def modified_julian_dates(columns, lines, path):
    """Return GPS time labels of modified Julian dates [d], rounded to 1 ms."""
    values = numbers(columns[0], lines, path, "MJD")
    given, values = _within(values, (20_000, 90_000), "a modified Julian date like 55631.5", columns[0], lines, path)
    return _where_given(given, MJD_ZERO + np.round(values * DAY * 1e3).astype(np.int64).astype("timedelta64[ms]"))


def seconds_from_gps_epoch(columns, lines, path):
    """Return labels of seconds counted from 1980-01-06T00:00:00, the epoch of GPS time, rounded to 1 us."""
    return _seconds_after(GPS_EPOCH, columns, lines, path)


def unix_seconds(columns, lines, path):
    """Return GPS time labels of Unix seconds (UTC, from 1970-01-01), rounded to 1 us."""
    return gps_from_utc(_seconds_after(UNIX_ZERO, columns, lines, path))


def to_gps_time(time, scale):
    """Return GPS time of labels in GPST, UTC or JST (UTC + 9 h).

    >>> print(to_gps_time(np.datetime64("2024-06-24T17:19:42"), "JST"))
    2024-06-24T08:20:00.000000000
    """
    if scale == "GPST":
        return time
    return gps_from_utc(time - JST_AHEAD_OF_UTC if scale == "JST" else time)


# what --columns may name, with the words for a note
CLOCKS = {
    "calendar": (calendar, "dates"),
    "week_tow": (week_and_seconds, "GPS week and seconds of the week"),
    "decimal_year": (decimal_years, "decimal years"),
    "mjd": (modified_julian_dates, "modified Julian dates"),
    "seconds": (seconds_from_gps_epoch, "seconds, counted from 1980-01-06, the epoch of GPS time"),
    "unix": (unix_seconds, "Unix seconds"),
}


def guess_clock(text):
    """Return the name in CLOCKS of what a single field of time looks like; None for what looks like no time.

    >>> [guess_clock(text) for text in ("2024/06/24 08:20:00", "55631.5", "2011.189", "120.0", "1400000000")]
    ['calendar', 'mjd', 'decimal_year', 'seconds', 'unix']
    """
    if re.match(r"\s*\d{4}[-/]", text):
        return "calendar"
    if re.fullmatch(r"\s*(19|20)\d{6}\s*", text):  # 20240624: neither a date as it is read here nor seconds
        return None
    try:
        value = float(text)
    except ValueError:
        return None
    if MJD_RANGE[0] <= value < MJD_RANGE[1]:
        return "mjd"
    if float(YEARS[0]) <= value < float(YEARS[1]) and value != int(value):
        return "decimal_year"
    return "unix" if value >= UNIX_LEAST else "seconds"


def _calendar_with_zone(texts, lines, path):
    marks = {text[10:].strip("0123456789:. T") for text in texts}
    if marks <= {""}:
        return _naive(texts, lines, path)
    zone = _ZONE.search(texts[0])
    suffix = zone[0] if zone else ""
    odd = next((k for k, text in enumerate(texts) if not suffix or not text.endswith(suffix)), None)
    if odd is not None:
        raise _no_date(texts[odd], lines[odd], path, " with the same time zone in every row" if suffix else "")
    utc = _naive([text.removesuffix(suffix) for text in texts], lines, path) - _offset(zone)
    return gps_from_utc(utc)


def _offset(zone):
    sign, hours, minutes = zone.groups()
    if sign is None:
        return np.timedelta64(0, "m")
    return np.timedelta64(int(f"{sign}1") * (60 * int(hours) + int(minutes)), "m")


def _naive(texts, lines, path):
    """Return labels of dates without a zone: all at once where they are written in full, else one by one."""
    try:
        if YEARS[0] <= min(text[:4] for text in texts) and max(text[:4] for text in texts) <= YEARS[1]:
            return np.array(texts, dtype="datetime64[ns]")
    except ValueError:
        pass
    return np.array([_one_date(text, line, path) for text, line in zip(texts, lines, strict=True)], dtype="datetime64[ns]")


def _one_date(text, line, path):
    if is_missing(text):
        return np.datetime64("NaT", "ns")
    found = _CALENDAR.fullmatch(text)
    if not found or not YEARS[0] <= found[1] <= YEARS[1]:
        raise _no_date(text, line, path)
    year, month, day, hour, minute, second = (int(part or 0) for part in found.groups()[:6])
    try:
        return np.datetime64(f"{year:04d}-{month:02d}-{day:02d}T{hour:02d}:{minute:02d}:{second:02d}{found[7] or '.0'}", "ns")
    except ValueError:  # a month 13
        raise _no_date(text, line, path) from None


def _no_date(text, line, path, more=""):
    return SeriesError(path, f"expected a date like 2024-06-24T08:20:00 or 2024/06/24 08:20:00{more}, found {quoted(text)}", line)


def _within(values, limits, what, texts, lines, path):
    """Return where a time is given, and the values, a lawful one where none is; raise SeriesError where one lies outside the limits."""
    given = np.isfinite(values)
    wrong = np.flatnonzero(given & ~((values >= limits[0]) & (values < limits[1])))
    if len(wrong):
        raise SeriesError(path, f"expected {what}, found {quoted(texts[wrong[0]].strip())}", lines[wrong[0]])
    return given, np.where(given, values, limits[0])


def _seconds_after(origin, columns, lines, path):
    values = numbers(columns[0], lines, path, "seconds")
    given, values = _within(values, (-4e9, 4e9), "seconds", columns[0], lines, path)
    return _where_given(given, origin + np.round(values * 1e6).astype(np.int64).astype("timedelta64[us]"))


def _where_given(given, time):
    return np.where(given, time, np.datetime64("NaT", "ns"))
