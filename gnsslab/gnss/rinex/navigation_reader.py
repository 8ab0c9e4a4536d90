"""Reading broadcast navigation files: RINEX 2.x, 3.0x and 4.0x, as published by the IGS and RTCM.

A data set is a line with satellite, time of clock and three numbers, and seven lines of four numbers, 19 columns each.
Orbits are read of GPS, Galileo, BeiDou (D1, D2) and QZSS; data sets of other systems and messages are counted and said.
"""

import re
from collections import Counter
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import NamedTuple

import numpy as np

from gnsslab.gnss.ephemerides import ARRAY_FIELDS, Ephemerides
from gnsslab.gnss.rinex.errors import RinexError, quoted
from gnsslab.gnss.rinex.text import read_text
from gnsslab.gnss.signals import SYSTEM_NAMES, USED_SYSTEMS
from gnsslab.gnss.times import BDT_BEHIND_GPS, SECONDS_PER_WEEK, add_seconds, week_and_tow


def read_rinex_nav(*paths):
    """Read one or several navigation files into one `Ephemerides`; data sets that are repeated stand in it once.

    Week numbers are not trusted: toe and the time of transmission are taken within half a week of toc. The first
    ionosphere coefficients of a system and the first leap seconds serve. `.warnings` says what was left out, and why.
    Raises RinexError (file, line, expected, found) where a file is no navigation file or a number cannot be read.
    """
    if not paths:
        raise ValueError("expected at least one navigation file, came none; give its name")
    return merge_ephemerides([_read_file(path) for path in paths])


def merge_ephemerides(parts):
    """Return one `Ephemerides` of several: sorted by satellite, toe and time of transmission, repeated data sets dropped."""
    columns = {name: np.concatenate([getattr(part, name) for part in parts]) for name in ARRAY_FIELDS}
    order = np.lexsort((columns["transmission"], columns["toe"], columns["satellite"]))
    columns = {name: column[order] for name, column in columns.items()}
    kept = _first_of_equals(columns)
    ionosphere = {}
    for part in reversed(parts):
        ionosphere.update(part.ionosphere)
    leap_seconds = next((part.leap_seconds for part in parts if part.leap_seconds is not None), None)
    warnings = tuple(warning for part in parts for warning in part.warnings)
    source = ", ".join(part.source for part in parts if part.source)
    return Ephemerides(**{name: column[kept] for name, column in columns.items()},
                       ionosphere=ionosphere, leap_seconds=leap_seconds, warnings=warnings, source=source)  # fmt: skip


def _first_of_equals(columns):
    """Return the rows (sorted) that repeat no earlier one: same satellite, toe, toc, issue, health and Galileo message."""
    is_inav = columns["clock_issue"] & 0b101 > 0  # of Galileo; for the others the clock's issue follows from toc
    is_inav &= columns["satellite"].astype("<U1") == "E"
    names = ("satellite", "toe", "toc", "issue", "health")
    keys = zip(*(columns[name].tolist() for name in names), is_inav.tolist(), strict=True)
    first = {}
    for row, key in enumerate(keys):
        first.setdefault(key, row)
    return np.array(list(first.values()), dtype=int)


class _Header(NamedTuple):
    version: float
    system: str  # the letter of the one system of a RINEX 2 file
    length: int  # lines
    ionosphere: dict
    leap_seconds: int | None
    warnings: list


class _Record(NamedTuple):
    """One data set as it stands: its lines, the number of its first line, and the columns where its numbers begin."""

    satellite: str
    lines: list
    line: int
    year_digits: int

    @property
    def indent(self):
        return 4 if self.year_digits == 4 else 3  # columns before the first number of a continuation line


def _read_file(path):
    text, complaints = read_text(path)
    lines = text.decode("latin-1").split("\n")
    header = _read_header(lines, path)
    groups = _groups(lines, header, path)
    read = {2: _records_2, 3: _records_3, 4: _records_4}[int(header.version)]
    records, ionosphere, skipped = read(groups, header, path)
    records, short = _without_short(records, lines)
    rows = [(record, *_epoch_and_values(record, path)) for record in records]
    rows, odd = _without_odd(rows)
    ephemerides = _ephemerides_of(rows)
    warnings = [*complaints, *header.warnings, *skipped, *short, *odd]
    return replace(
        ephemerides,
        ionosphere={**ionosphere, **header.ionosphere},
        leap_seconds=header.leap_seconds,
        warnings=tuple(f"{Path(path).name}: {warning}" for warning in warnings),
        source=str(path),
    )


# The header -----------------------------------------------------------------------------------------------------------


def _read_header(lines, path):
    version, system = _version_and_system(lines[0], path)
    end = next((number for number, line in enumerate(lines) if line[60:].strip() == "END OF HEADER"), None)
    if end is None:
        raise RinexError(path, "expected a line END OF HEADER, found none; the header is cut off")
    labelled = [(number, line[60:80].strip(), line) for number, line in enumerate(lines[:end], start=1)]
    ionosphere, warnings = _header_ionosphere(labelled, system, path)
    return _Header(version, system, end + 1, ionosphere, _leap_seconds(labelled, path), warnings)


_OTHER_KINDS = {"O": "an observation file", "M": "a meteorological file", "C": "a clock file", "I": "an ionosphere map"}
_RINEX_2_SYSTEMS = {"N": "G", "G": "R", "H": "S", "L": "E", "E": "E", "J": "J"}


def _version_and_system(line, path):
    if line[60:].strip() != "RINEX VERSION / TYPE":
        raise RinexError(path, f"expected a RINEX header with RINEX VERSION / TYPE, found {quoted(line)}", line=1)
    kind = line[20:21].upper()
    if kind in _OTHER_KINDS:
        problem = f"expected a navigation file, found {_OTHER_KINDS[kind]} (type {kind}); give the broadcast navigation file"
        raise RinexError(path, problem, line=1)
    version = _header_number(line, 0, 9, path, 1)
    if not 2 <= version < 5:
        raise RinexError(path, f"expected RINEX version 2, 3 or 4, found {quoted(line[:9].strip())}", line=1)
    if kind != "N" and (version >= 3 or kind not in _RINEX_2_SYSTEMS):
        raise RinexError(path, f"expected a navigation file (type N), found type {quoted(line[20:40])}", line=1)
    return version, _RINEX_2_SYSTEMS[kind]


def _header_number(line, start, end, path, number):
    try:
        return _number(line[start:end])
    except ValueError:
        problem = f"expected a number in columns {start + 1}-{end}, found {quoted(line[start:end])}"
        raise RinexError(path, problem, line=number) from None


_IONOSPHERE_NAMES = {"GPS": "G", "QZS": "J", "BDS": "C"}


def _header_ionosphere(labelled, system, path):
    """Return Klobuchar coefficients by system, and what is to be said of those that cannot serve."""
    halves = {}
    for number, label, line in labelled:
        if label in ("ION ALPHA", "ION BETA"):
            key, start = (system, label[4]), 2
        elif label == "IONOSPHERIC CORR" and line[:3] in _IONOSPHERE_NAMES:
            key, start = (_IONOSPHERE_NAMES[line[:3]], line[3:4]), 5
        else:
            continue
        coefficients = [_header_number(line, start + 12 * k, start + 12 * k + 12, path, number) for k in range(4)]
        halves.setdefault(key, coefficients)
    pairs = {name: (halves.get((name, "A")), halves.get((name, "B"))) for name in dict.fromkeys(name for name, _ in halves)}
    usable = {name: np.array(alpha + beta) for name, (alpha, beta) in pairs.items() if alpha and beta and any(alpha + beta)}
    warnings = [
        f"the {SYSTEM_NAMES[name]} ionosphere coefficients are incomplete or all zero and are left out" for name in pairs if name not in usable
    ]
    return usable, warnings


def _leap_seconds(labelled, path):
    for number, label, line in labelled:
        if label == "LEAP SECONDS":
            return int(np.clip(_header_number(line, 0, 6, path, number), -999, 999))
    return None


# From lines to data sets ----------------------------------------------------------------------------------------------


def _groups(lines, header, path):
    """Return (number of the first line, lines) of each group: a line that begins with something, and those that do not."""
    width = 2 if header.version < 3 else 1
    body = lines[header.length :]
    is_marked = header.version >= 4
    if is_marked:
        starts = [k for k, line in enumerate(body) if line[:1] == ">"]
    else:
        starts = [k for k, line in enumerate(body) if line[:width].strip()]
    first = starts[0] if starts else len(body)
    stray = next((k for k, line in enumerate(body[:first]) if line.strip()), None)
    if stray is not None:
        expected = "a record that begins with >" if is_marked else "a satellite"
        raise RinexError(path, f"expected {expected}, found {quoted(body[stray])}", line=header.length + stray + 1)
    ends = [*starts[1:], len(body)]
    return [(header.length + start + 1, body[start:end]) for start, end in zip(starts, ends, strict=False)]


def _records_2(groups, header, path):
    if header.system not in USED_SYSTEMS:
        return [], {}, _said(Counter({SYSTEM_NAMES[header.system]: len(groups)}))
    records = []
    for line, lines in groups:
        number = lines[0][:2].strip()
        if not (number.isascii() and number.isdigit()):
            raise RinexError(path, f"expected a satellite number in columns 1-2, found {quoted(lines[0])}", line=line)
        records.append(_Record(f"{header.system}{int(number):02d}", lines, line, year_digits=2))
    return records, {}, []


def _records_3(groups, header, path):
    records, skipped = [], Counter()
    for line, lines in groups:
        satellite = _satellite(lines[0][:3], path, line)
        if satellite[0] in USED_SYSTEMS:
            records.append(_Record(satellite, lines, line, year_digits=4))
        else:
            skipped[SYSTEM_NAMES[satellite[0]]] += 1
    return records, {}, _said(skipped)


_MESSAGES_4 = {"G": ("LNAV",), "J": ("LNAV",), "E": ("INAV", "FNAV"), "C": ("D1", "D2")}
_KLOBUCHAR_4 = {"G": "LNAV", "J": "LNAV", "C": "D1D2"}


def _records_4(groups, header, path):
    records, ionosphere, skipped = [], {}, Counter()
    for line, lines in groups:
        kind, satellite, message = lines[0][2:5], _satellite(lines[0][6:9], path, line), lines[0][10:14].strip()
        system = satellite[0]
        if kind == "EPH" and message in _MESSAGES_4.get(system, ()):
            if len(lines) > 1 and lines[1].strip():
                _satellite(lines[1][:3], path, line + 1)
            records.append(_Record(satellite, lines[1:], line + 1, year_digits=4))
        elif kind == "ION" and message == _KLOBUCHAR_4.get(system) and system not in ionosphere:
            ionosphere.update(_klobuchar_record(_Record(satellite, lines[1:], line + 1, year_digits=4), path))
        elif kind == "EPH":
            skipped[f"{SYSTEM_NAMES[system]} {message}"] += 1
    return records, ionosphere, _said(skipped)


def _klobuchar_record(record, path):
    """Return {system letter: coefficients} of an ION record: alpha 0-2 behind the time, alpha 3 and beta 0-2, beta 3."""
    values = _values(record, path)[:8]
    return {record.satellite[0]: np.array(values)} if len(values) == 8 and any(values) else {}


def _satellite(text, path, line):
    text = f"{text[:1]}{text[1:].replace(' ', '0')}"
    if re.fullmatch("[A-Z][0-9]{2}", text) and text[0] in SYSTEM_NAMES and text[1:] != "00":
        return text
    expected = f"a satellite (one of {' '.join(SYSTEM_NAMES)} and a number, as G05)"
    raise RinexError(path, f"expected {expected}, found {quoted(text)}", line=line)


def _said(skipped):
    return [f"{count} data sets of {name} are not used here" for name, count in skipped.items() if count]


_LINES = 8  # of a data set


def _without_short(records, lines):
    """Return the complete records, and what is to be said of the others; the last one counts as cut also inside a number."""
    cut_inside = bool(records) and lines[-1].strip() != "" and (len(lines[-1].rstrip()) - records[-1].indent) % 19 != 0
    whole, said = [], []
    for record in records:
        if len(record.lines) < _LINES or (cut_inside and record is records[-1] and record.lines[-1] is lines[-1]):
            said.append(f"line {record.line}: the data set of {record.satellite} is cut off and is left out")
        else:
            whole.append(record)
    return whole, said


# From text to numbers -------------------------------------------------------------------------------------------------

_NUMERIC = re.compile(r"[0-9+\-.EeDd ]*")
_EXPONENT = str.maketrans("Dd", "EE")


def _number(text):
    """Return the number a field stands for; D, d and e serve as exponent letters, blank is zero, anything else raises.

    >>> _number(" 1.5D+01"), _number("   ")
    (15.0, 0.0)
    """
    if not _NUMERIC.fullmatch(text):
        raise ValueError(text)
    return float(text.translate(_EXPONENT)) if text.strip() else 0.0


def _epoch_and_values(record, path):
    """Return time of clock [ns since 1970, own scale] and the 31 numbers of a data set."""
    first = record.lines[0]
    text = first[3 : 18 + record.indent] if record.year_digits == 2 else first[4:23]
    try:
        nanoseconds = _epoch(text, record.year_digits)
    except ValueError:
        raise RinexError(path, f"expected year month day hour minute second, found {quoted(text)}", line=record.line) from None
    return nanoseconds, _values(record, path)


_UNIX_EPOCH = datetime(1970, 1, 1)


def _epoch(text, year_digits):
    if not re.fullmatch("[0-9. ]*", text):
        raise ValueError(text)
    *whole, second = text.split()
    year, month, day, hour, minute = (int(part) for part in whole)
    if year_digits == 2 and year < 100:
        year += 1900 if year >= 80 else 2000
    if not (1980 <= year < 2080 and 0 <= float(second) <= 60):
        raise ValueError(text)
    since = datetime(year, month, day, hour, minute) - _UNIX_EPOCH
    return (since.days * 86_400 + since.seconds) * 10**9 + round(float(second) * 1e9)


def _values(record, path):
    text = _joined(record)
    try:
        if not _NUMERIC.fullmatch(text):
            raise ValueError
        fields = [text[k : k + 19] for k in range(0, len(text), 19)]
        return [0.0 if field.isspace() else float(field) for field in fields]
    except ValueError:
        raise _bad_field(record, path) from None


def _joined(record):
    """Return the numbers of a data set as one text: three fields of the first line, four of each that follows."""
    first = record.lines[0][19 + record.indent :][:57].ljust(57)
    rest = [line[record.indent :][:76].ljust(76) for line in record.lines[1:_LINES]]
    return "".join([first, *rest]).translate(_EXPONENT)


def _bad_field(record, path):
    text = _joined(record)
    for k in range(len(text) // 19):
        try:
            _number(text[19 * k : 19 * k + 19])
        except ValueError:
            below, across = divmod(k + 1, 4)
            start = record.indent + 19 * across
            found = record.lines[below][start : start + 19]
            problem = f"expected a number in columns {start + 1}-{start + 19}, found {quoted(found.strip())}"
            return RinexError(path, problem, line=record.line + below)
    return RinexError(path, f"expected numbers, found {quoted(record.lines[0])}", line=record.line)


# From numbers to ephemerides ------------------------------------------------------------------------------------------

# Place of each quantity in a data set, first line 0-2, then four a line (RINEX 3.04 tables A5, A8, A10 and A14).
COLUMNS = {
    "af0": 0, "af1": 1, "af2": 2, "issue": 3, "crs": 4, "delta_n": 5, "m0": 6, "cuc": 7, "e": 8, "cus": 9, "sqrt_a": 10,
    "toe": 11, "cic": 12, "omega0": 13, "cis": 14, "i0": 15, "crc": 16, "omega": 17, "omega_dot": 18, "idot": 19,
    "data_sources": 20, "week": 21, "accuracy": 23, "health": 24, "delay_1": 25, "delay_2": 26, "transmission": 27, "aodc": 28,
}  # fmt: skip
CLOCK_ISSUE_COLUMN = {"G": 26, "J": 26, "E": 20, "C": 28}
_PLAIN = "sqrt_a e i0 omega0 omega m0 delta_n idot omega_dot cuc cus crc crs cic cis af0 af1 af2".split()  # taken over as they stand
UNKNOWN_ACCURACY = 6144.0  # [m]: beyond this, the end of URA index 14, and below zero (Galileo) there is no prediction


def _without_odd(rows):
    """Return the rows whose orbit is one of a navigation satellite, and what is to be said of the others."""
    kept, said = [], []
    for row in rows:
        record, _, values = row
        sqrt_a, e, toe = (values[COLUMNS[name]] for name in ("sqrt_a", "e", "toe"))
        is_orbit = 4500 < sqrt_a < 7500 and 0 <= e < 0.5 and 0 <= toe < SECONDS_PER_WEEK and max(map(abs, values)) < 1e10
        if is_orbit:
            kept.append(row)
        else:
            what = f"root of the semi-major axis {sqrt_a:g}, eccentricity {e:g}, toe {toe:g} s"
            said.append(f"line {record.line}: the data set of {record.satellite} is no orbit ({what}) and is left out")
    return kept, said


def _ephemerides_of(rows):
    satellite = np.array([record.satellite for record, _, _ in rows], dtype="<U3")
    toc = np.array([nanoseconds for _, nanoseconds, _ in rows], dtype=np.int64).astype("datetime64[ns]")
    table = np.array([values for _, _, values in rows], dtype=float).reshape(-1, 31)
    column = {name: table[:, k] for name, k in COLUMNS.items()}
    letters = satellite.astype("<U1")
    to_gps = np.where(letters == "C", BDT_BEHIND_GPS, np.timedelta64(0, "s"))
    transmission = within_half_a_week(toc, column["transmission"]) + to_gps
    is_said = (np.abs(column["transmission"]) <= SECONDS_PER_WEEK) & _is_written(rows, COLUMNS["transmission"])
    delays = np.stack([column["delay_1"], np.where(np.isin(letters, ["E", "C"]), column["delay_2"], 0.0)], axis=-1)
    clock_issue = np.select([letters == s for s in USED_SYSTEMS], [table[:, CLOCK_ISSUE_COLUMN[s]] for s in USED_SYSTEMS])
    accuracy = column["accuracy"]
    return Ephemerides(
        satellite=satellite,
        toe=within_half_a_week(toc, column["toe"]) + to_gps,
        toc=toc + to_gps,
        transmission=np.where(is_said, transmission, np.datetime64("NaT", "ns")),
        group_delay=delays,
        issue=_integers(column["issue"]),
        clock_issue=_integers(clock_issue),
        accuracy=np.where((accuracy >= 0) & (accuracy <= UNKNOWN_ACCURACY), accuracy, np.nan),
        health=_integers(column["health"]),
        **{name: column[name].copy() for name in _PLAIN},
    )


def within_half_a_week(time, tow):
    """Return the time label with time of week tow [s] that is nearest to a time label.

    >>> print(within_half_a_week(np.datetime64("2024-06-22T23:59:44"), 0.0))
    2024-06-23T00:00:00.000000000
    """
    ahead = (tow - week_and_tow(time)[1] + SECONDS_PER_WEEK / 2) % SECONDS_PER_WEEK - SECONDS_PER_WEEK / 2
    return add_seconds(time, ahead)


def _is_written(rows, k):
    """Return of which rows field k is not blank."""
    below, across = divmod(k + 1, 4)
    spans = [(record.lines[below], record.indent + 19 * across) for record, _, _ in rows]
    return np.array([line[start : start + 19].strip() != "" for line, start in spans], dtype=bool)


def _integers(values):
    return np.round(values).astype(np.int64)
