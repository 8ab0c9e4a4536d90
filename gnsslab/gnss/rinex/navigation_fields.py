"""The numbers of a navigation file: how they are written, where each quantity stands, which are those of an orbit."""

import re
from datetime import datetime

from gnsslab.gnss.times import SECONDS_PER_WEEK

# Place of each quantity in a data set: three on the first line, then four a line (RINEX 3.04 tables A5, A8, A10 and A14).
COLUMNS = {
    "af0": 0, "af1": 1, "af2": 2, "issue": 3, "crs": 4, "delta_n": 5, "m0": 6, "cuc": 7, "e": 8, "cus": 9, "sqrt_a": 10,
    "toe": 11, "cic": 12, "omega0": 13, "cis": 14, "i0": 15, "crc": 16, "omega": 17, "omega_dot": 18, "idot": 19,
    "data_sources": 20, "week": 21, "accuracy": 23, "health": 24, "delay_1": 25, "delay_2": 26, "transmission": 27, "aodc": 28,
}  # fmt: skip
CLOCK_ISSUE_COLUMN = {"G": 26, "J": 26, "E": 20, "C": 28}  # IODC, data sources, AODC
FIELD_WIDTH = 19
LINES = 8  # of a data set
FIELDS = 3 + 4 * (LINES - 1)

_NUMERIC = re.compile(r"[0-9+\-.EeDd ]*")
_EXPONENT = str.maketrans("Dd", "EE")


def number(text):
    """Return the number a field stands for; D, d and e serve as exponent letters, blank is zero, anything else raises.

    >>> number(" 1.5D+01"), number("   ")
    (15.0, 0.0)
    """
    if not _NUMERIC.fullmatch(text):
        raise ValueError(text)
    return float(text.translate(_EXPONENT)) if text.strip() else 0.0


def numbers(text):
    """Return the numbers of fields of 19 columns that stand in one text.

    >>> numbers("-1.774230040610D-04" + 19 * " ")
    [-0.000177423004061, 0.0]
    """
    if not _NUMERIC.fullmatch(text):
        raise ValueError(text)
    text = text.translate(_EXPONENT)
    fields = [text[k : k + FIELD_WIDTH] for k in range(0, len(text), FIELD_WIDTH)]
    return [0.0 if field.isspace() else float(field) for field in fields]


_UNIX_EPOCH = datetime(1970, 1, 1)


def epoch(text):
    """Return nanoseconds since 1970 of "year month day hour minute second"; two digits of year are 1980 to 2079.

    >>> epoch("70  1  1  0  0  0.0") == epoch("2070 01 01 00 00 00")
    True
    """
    if not re.fullmatch("[0-9. ]*", text):
        raise ValueError(text)
    *whole, second = text.split()
    year, month, day, hour, minute = (int(part) for part in whole)
    if year < 100:
        year += 1900 if year >= 80 else 2000
    if not (1980 <= year < 2080 and 0 <= float(second) <= 60):
        raise ValueError(text)
    since = datetime(year, month, day, hour, minute) - _UNIX_EPOCH
    return (since.days * 86_400 + since.seconds) * 10**9 + round(float(second) * 1e9)


def is_orbit(values):
    """Return whether 31 numbers are those of a navigation satellite: any other orbit or clock is damage or a placeholder.

    The roots of the semi-major axes lie between 5050 (GLONASS) and 6494 sqrt m (geostationary); e reaches 0.17 (E14, E18).
    """
    sqrt_a, e, toe = (values[COLUMNS[name]] for name in ("sqrt_a", "e", "toe"))
    is_clock = abs(values[0]) < 1 and abs(values[1]) < 1e-3 and abs(values[2]) < 1e-6  # [s], [s/s], [s/s^2]
    is_ellipse = 4500 < sqrt_a < 7500 and 0 <= e < 0.5
    return is_clock and is_ellipse and 0 <= toe < SECONDS_PER_WEEK and max(map(abs, values)) < 1e10
