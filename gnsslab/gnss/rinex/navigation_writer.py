"""Writing broadcast navigation files, RINEX 3.04 (tables A2, A5, A8, A10 and A14)."""

from datetime import UTC, datetime

import numpy as np

import gnsslab
from gnsslab.gnss.rinex.navigation_fields import CLOCK_ISSUE_COLUMN, COLUMNS, FIELDS
from gnsslab.gnss.rinex.observation_writer import write_whole
from gnsslab.gnss.times import BDT_BEHIND_GPS, BDT_WEEK_ZERO, SECONDS_PER_WEEK, week_and_tow

_UNKNOWN_TRANSMISSION = 0.9999e9  # as RINEX writes a time of transmission that is not known
_NO_PREDICTION = {"G": 8192.0, "J": 8192.0, "C": 8192.0, "E": -1.0}  # accuracy fields that promise nothing
_IONOSPHERE_NAMES = {"G": "GPS", "J": "QZS", "C": "BDS"}


def write_rinex_nav(path, ephemerides):
    """Write an `Ephemerides` as a RINEX 3.04 navigation file, whole or not at all; a name ending in .gz is compressed.

    Numbers keep 13 significant digits, as the format has them; ionosphere coefficients keep 5. Fields that `Ephemerides`
    does not hold (codes on L2, fit interval) are zero or blank. Raises ValueError where toc is no whole second, RinexError
    where the file cannot be written.
    """
    lines = [*_header_lines(ephemerides), *_data_lines(ephemerides)]
    write_whole(path, ("\n".join(lines) + "\n").encode("ascii"))


def _header_lines(ephemerides):
    now = datetime.now(UTC).strftime("%Y%m%d %H%M%S UTC")
    yield _labelled("     3.04           N: GNSS NAV DATA    M: MIXED", "RINEX VERSION / TYPE")
    yield _labelled(f"{f'gnsslab {gnsslab.__version__}':<20}{'':<20}{now}", "PGM / RUN BY / DATE")
    for system, coefficients in ephemerides.ionosphere.items():
        for half, four in (("A", coefficients[:4]), ("B", coefficients[4:])):
            numbers = "".join(f"{_writable(value):12.4E}" for value in four)
            yield _labelled(f"{_IONOSPHERE_NAMES[system]}{half} {numbers}", "IONOSPHERIC CORR")
    if ephemerides.leap_seconds is not None:
        yield _labelled(f"{ephemerides.leap_seconds:6d}", "LEAP SECONDS")
    yield _labelled("", "END OF HEADER")


def _labelled(text, label):
    return f"{text:<60}{label:<20}"


def _data_lines(ephemerides):
    to_own_scale = np.where(_letters(ephemerides) == "C", BDT_BEHIND_GPS, np.timedelta64(0, "s"))
    toc = ephemerides.toc - to_own_scale
    _require_whole_seconds(ephemerides.satellite, toc)
    dates = [text.translate(_DATE_MARKS) for text in np.datetime_as_string(toc, unit="s")]
    for satellite, date, values in zip(ephemerides.satellite, dates, _table(ephemerides, to_own_scale).tolist(), strict=True):
        fields = [f"{value:19.12E}" for value in values]
        yield f"{satellite} {date}" + "".join(fields[:3])
        for k in range(3, 27, 4):
            yield "    " + "".join(fields[k : k + 4])
        yield "    " + "".join(fields[27:29] if satellite[0] == "C" else fields[27:28])


_DATE_MARKS = str.maketrans("-T:", "   ")


def _require_whole_seconds(satellite, toc):
    is_broken = toc != toc.astype("datetime64[s]")
    if is_broken.any():
        k = np.argmax(is_broken)
        raise ValueError(f"expected toc in whole seconds, as RINEX 3 writes it; that of {satellite[k]} is {toc[k]}")


def _table(ephemerides, to_own_scale):
    """Return the 31 numbers (k, 31) of each data set, in the order in which they stand in the file."""
    eph, letters = ephemerides, _letters(ephemerides)
    week, toe = week_and_tow(eph.toe - to_own_scale)
    is_said = ~np.isnat(eph.transmission)
    sent = np.where(is_said, eph.transmission, eph.toe) - to_own_scale
    sent_week, sent_tow = week_and_tow(sent)
    derived = {
        "toe": toe,
        "week": week - np.where(letters == "C", BDT_WEEK_ZERO, 0),
        "transmission": np.where(is_said, sent_tow + (sent_week - week) * SECONDS_PER_WEEK, _UNKNOWN_TRANSMISSION),
        "accuracy": np.where(np.isnan(eph.accuracy), [_NO_PREDICTION[letter] for letter in letters], eph.accuracy),
        "delay_1": eph.group_delay[:, 0],
        "delay_2": eph.group_delay[:, 1],
    }
    table = np.zeros((len(letters), FIELDS))
    for name, place in COLUMNS.items():
        table[:, place] = derived[name] if name in derived else getattr(eph, name, 0.0)
    rows = np.arange(len(letters))
    table[rows, np.array([CLOCK_ISSUE_COLUMN[letter] for letter in letters], dtype=int)] = eph.clock_issue
    return _writable(table)


def _writable(values):
    """Return values with those nearer to zero than 1e-99 as zero: a third digit of the exponent has no place."""
    return np.where(np.abs(values) < 1e-99, 0.0, values)


def _letters(ephemerides):
    return ephemerides.satellite.astype("<U1")
