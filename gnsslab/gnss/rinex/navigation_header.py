"""The header of a navigation file: version and kind, ionosphere coefficients, leap seconds."""

from typing import NamedTuple

import numpy as np

from gnsslab.gnss.rinex.errors import RinexError, quoted
from gnsslab.gnss.rinex.navigation_fields import number
from gnsslab.gnss.signals import SYSTEM_NAMES

KLOBUCHAR_LIMIT = 1e10  # coefficients reach 1e7; what is larger is damage
_OTHER_KINDS = {"O": "an observation file", "M": "a meteorological file", "C": "a clock file", "I": "an ionosphere map"}
_RINEX_2_SYSTEMS = {"N": "G", "G": "R", "H": "S", "L": "E", "E": "E", "J": "J"}
_IONOSPHERE_NAMES = {"GPS": "G", "QZS": "J", "BDS": "C"}
_BDT_BEHIND_GPS = 14  # [s]


class Header(NamedTuple):
    """What the header says that matters to orbits."""

    version: float
    system: str  # the letter of the one system of a RINEX 2 file
    length: int  # lines
    ionosphere: dict  # system letter: Klobuchar's eight coefficients
    leap_seconds: int | None  # GPS time minus UTC
    warnings: list


def read_header(lines, path):
    """Return the `Header` of a file's lines; RinexError where it is of another kind, or has no end."""
    version, system = _version_and_system(lines[0], path)
    end = next((row for row, line in enumerate(lines) if line[60:].strip() == "END OF HEADER"), None)
    if end is None:
        raise RinexError(path, "expected a line END OF HEADER, found none; the header is cut off")
    labelled = [(row, line[60:80].strip(), line) for row, line in enumerate(lines[:end], start=1)]
    ionosphere, warnings = _ionosphere(labelled, system, path)
    return Header(version, system, end + 1, ionosphere, _leap_seconds(labelled, path), warnings)


def _version_and_system(line, path):
    if line[60:].strip() != "RINEX VERSION / TYPE":
        raise RinexError(path, f"expected a RINEX header with RINEX VERSION / TYPE, found {quoted(line)}", line=1)
    kind = line[20:21].upper()
    if kind in _OTHER_KINDS:
        problem = f"expected a navigation file, found {_OTHER_KINDS[kind]} (type {kind}); give the broadcast navigation file"
        raise RinexError(path, problem, line=1)
    version = _number_in(line, 0, 9, path, 1)
    if not 2 <= version < 5:
        raise RinexError(path, f"expected RINEX version 2, 3 or 4, found {quoted(line[:9].strip())}", line=1)
    if kind != "N" and (version >= 3 or kind not in _RINEX_2_SYSTEMS):
        raise RinexError(path, f"expected a navigation file (type N), found type {quoted(line[20:40])}", line=1)
    return version, _RINEX_2_SYSTEMS[kind]


def _number_in(line, start, end, path, row):
    try:
        return number(line[start:end])
    except ValueError:
        problem = f"expected a number in columns {start + 1}-{end}, found {quoted(line[start:end])}"
        raise RinexError(path, problem, line=row) from None


def _ionosphere(labelled, system, path):
    """Return Klobuchar coefficients by system, and what is to be said of those that cannot serve; the first of a kind count."""
    halves = {}
    for row, label, line in labelled:
        key, start = _half(label, line, system)
        if key:
            halves.setdefault(key, [_number_in(line, start + 12 * k, start + 12 * k + 12, path, row) for k in range(4)])
    eights = {name: halves.get((name, "A"), []) + halves.get((name, "B"), []) for name in dict.fromkeys(name for name, _ in halves)}
    usable = {name: np.array(eight) for name, eight in eights.items() if is_klobuchar(eight)}
    useless = [name for name in eights if name not in usable]
    return usable, [f"the ionosphere coefficients of {SYSTEM_NAMES[name]} are incomplete or meaningless and are left out" for name in useless]


def is_klobuchar(eight):
    """Return whether numbers are eight coefficients that can have been broadcast; all zero stands for none received."""
    return len(eight) == 8 and any(eight) and max(map(abs, eight)) < KLOBUCHAR_LIMIT


def _half(label, line, system):
    """Return (system, A or B) and the column where the numbers begin, or (None, 0) for another line."""
    if label in ("ION ALPHA", "ION BETA") and system in _IONOSPHERE_NAMES.values():  # Galileo's are of another model
        return (system, label[4]), 2
    if label == "IONOSPHERIC CORR" and line[:3] in _IONOSPHERE_NAMES:
        return (_IONOSPHERE_NAMES[line[:3]], line[3:4]), 5
    return None, 0


def _leap_seconds(labelled, path):
    for row, label, line in labelled:
        if label == "LEAP SECONDS":
            seconds = int(np.clip(_number_in(line, 0, 6, path, row), -999, 999))
            return seconds + _BDT_BEHIND_GPS if line[24:27] == "BDS" else seconds
    return None
