"""Times of epoch lines: all at once where they stand in the standard columns, one by one where they do not."""

import re

import numpy as np

from gnsslab.gnss.rinex.errors import RinexError, quoted
from gnsslab.gnss.times import gps_from_scale

_ENDS = np.array([0, 3, 6, 9, 12])  # columns of the last digit of year, month, day, hour, minute after the year's end
_SECONDS = re.compile(r"(\d{1,2})(?:\.(\d*))?")
_YEARS = range(1980, 2200)


def epoch_times(lines, at, year_width, scale):
    """Return the GPS time (E,) of epoch lines `at`; years have 2 digits (RINEX 2) or 4, the scale is that of the file."""
    parts, fraction_ns, is_standard = _standard_parts(lines, at, year_width)
    for odd in np.flatnonzero(~is_standard):
        parts[odd], fraction_ns[odd] = _odd_parts(lines, at[odd], year_width)
    if year_width == 2:
        parts[:, 0] += np.where(parts[:, 0] < 80, 2000, 1900)
    minute, is_valid = _minutes(parts)
    if not is_valid.all():
        _raise_no_time(lines, at[np.argmin(is_valid)], year_width)
    seconds_ns = parts[:, 5] * 1_000_000_000 + fraction_ns
    return gps_from_scale(minute, scale) + seconds_ns.astype("timedelta64[ns]")


def _standard_parts(lines, at, year_width):
    """Return year to second (E, 6), the fraction of a second [ns], and which lines have them in the standard columns."""
    first = 2 if year_width == 4 else 1
    columns = lines.blank_cut(at, first, year_width + 23)
    digit = columns - np.uint8(ord("0"))
    is_digit, is_blank = digit < 10, columns == ord(" ")
    digit = np.where(is_digit, digit, 0).astype(np.int64)
    ones = year_width - 1 + np.array([0, 3, 6, 9, 12, 15])
    point, tenths = year_width + 15, np.arange(year_width + 16, year_width + 23)
    parts = digit[:, ones] + 10 * digit[:, ones - 1]
    if year_width == 4:
        parts[:, 0] += 100 * digit[:, 1] + 1000 * digit[:, 0]
    good = is_digit[:, ones].all(axis=1) & (is_digit | is_blank)[:, ones - 1].all(axis=1) & is_digit[:, : year_width - 2].all(axis=1)
    good &= is_blank[:, ones[:5] + 1].all(axis=1) & (columns[:, point] == ord(".")) & is_digit[:, tenths].all(axis=1)
    return parts, digit[:, tenths] @ 10 ** np.arange(8, 1, -1), good


def _odd_parts(lines, line, year_width):
    text = lines.text(line)[1 : 1 + 28] if year_width == 4 else lines.text(line)[:26]
    words = text.split()[:6]
    seconds = _SECONDS.fullmatch(words[5]) if len(words) == 6 and text.isascii() else None
    if seconds is None or not all(word.isdigit() and len(word) <= 4 for word in words[:5]):
        _raise_no_time(lines, line, year_width)
    return [*map(int, words[:5]), int(seconds[1])], int(f"{seconds[2] or '':0<9.9}")


def _minutes(parts):
    """Return the labels of the minutes and whether year, month, day, hour, minute and second are possible."""
    year, month, day, hour, minute, second = parts.T
    is_valid = (year >= _YEARS.start) & (year < _YEARS.stop) & (month >= 1) & (month <= 12)
    months = np.where(is_valid, (year - 1970) * 12 + month - 1, 120)
    first = months.astype("datetime64[M]").astype("datetime64[D]")
    after = (months + 1).astype("datetime64[M]").astype("datetime64[D]")
    is_valid &= (day >= 1) & (day <= (after - first).astype(np.int64)) & (hour < 24) & (minute < 60) & (second <= 60)
    minutes = np.where(is_valid, (day - 1) * 1440 + hour * 60 + minute, 0)
    return first.astype("datetime64[ns]") + minutes.astype("timedelta64[m]"), is_valid


def _raise_no_time(lines, line, year_width):
    text = lines.text(line)[1:29] if year_width == 4 else lines.text(line)[:26]
    raise RinexError(lines.file, f"expected year month day hour minute second, found {quoted(text.strip())}", int(line) + 1)
