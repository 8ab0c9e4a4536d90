"""Header lines of observation files: what the columns mean, and what the file says about the station."""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from gnsslab.gnss.observations import ObservationHeader
from gnsslab.gnss.rinex.codes import columns_of_version
from gnsslab.gnss.rinex.errors import RinexError, quoted
from gnsslab.gnss.signals import SYSTEM_NAMES

SCALE_OF_SYSTEM = {"G": "GPS", "R": "GLO", "E": "GAL", "J": "QZS", "C": "BDT", "I": "IRN", "S": "GPS", "M": "GPS"}
_SCALES = {"GPS", "GLO", "GAL", "QZS", "BDT", "IRN", "UTC"}
_OTHER_KINDS = {
    "N": "navigation", "G": "GLONASS navigation", "H": "SBAS navigation", "E": "Galileo navigation",
    "L": "Galileo navigation", "J": "QZSS navigation", "M": "meteorological", "C": "clock", "S": "summary",
}  # fmt: skip


class Layout(NamedTuple):
    """What the observation lines hold from some line of the file on."""

    codes: dict  # system letter -> observation codes in RINEX 3 names; RINEX 2: all systems the file may hold
    factors: dict  # system letter -> {code: number by which its values were multiplied}
    is_half: dict  # satellite or "" (all others) -> bands whose phase has half cycles (RINEX 2, squaring receivers)


@dataclass
class HeaderState:
    """Everything known from the header lines read so far; grows while a file is read."""

    file: str
    version: float = 0.0
    system: str = "G"  # system letter of the file, M for mixed
    types: dict = field(default_factory=dict)  # system letter ("" in RINEX 2) -> observation types as written
    announced: dict = field(default_factory=dict)  # the same -> (number of types, line that says so)
    current: str = ""  # system whose type list may be continued on the next line
    factors: dict = field(default_factory=dict)
    factor: tuple = ()  # (system, factor) whose code list may be continued on the next line
    is_half: dict = field(default_factory=dict)
    scale: str = ""
    station: dict = field(default_factory=dict)  # fields of ObservationHeader
    glonass: dict = field(default_factory=dict)

    def layout(self):
        """Return what the observation lines hold from here on."""
        if self.version < 3:
            codes = {system: columns_of_version(system, self.types.get("", ()), self.version) for system in SYSTEM_NAMES}
        else:
            codes = {system: columns_of_version(system, types, self.version) for system, types in self.types.items()}
        return Layout(codes, {system: dict(codes) for system, codes in self.factors.items()}, dict(self.is_half))

    def record(self):
        """Return what the file says about the station."""
        return ObservationHeader(version=self.version, time_scale=self.time_scale(), glonass_channels=dict(self.glonass), **self.station)

    def time_scale(self):
        """Return the time scale of the epochs: as written, else that of the file's system."""
        return self.scale or SCALE_OF_SYSTEM[self.system]


def take_header_line(state, text, line):
    """Take one header line into the state; a label nobody here needs is passed over."""
    label = _label(text)
    if label in _READERS:
        _READERS[label](state, text[:60].ljust(60), line)
    return label


def take_version(state, text, line=1):
    """Take the first line of the file: version, kind of file, system."""
    if _label(text) != "RINEX VERSION / TYPE":
        raise RinexError(state.file, f"expected 'RINEX VERSION / TYPE' in columns 61 to 80, found {quoted(text)}", line)
    state.version = _number(state, (text[:20].split() or [""])[0], line, "a version number")
    _require_known_version(state, line)
    _require_observations(state, text, line)
    system = (text[40:41].strip() or "G").upper()
    if system not in SCALE_OF_SYSTEM:
        known = ", ".join(SCALE_OF_SYSTEM)
        raise RinexError(state.file, f"unknown satellite system {system!r} in column 41: expected one of {known}", line)
    state.system = system


def check_types(state, line):
    """Raise RinexError where a list of observation types is missing or not as long as announced."""
    if not state.types:
        label = "# / TYPES OF OBSERV" if state.version < 3 else "SYS / # / OBS TYPES"
        raise RinexError(state.file, f"expected a header line {label!r}, found none", line)
    for system, (number, where) in state.announced.items():
        found = len(state.types[system])
        if number == 0 and state.version < 3:
            raise RinexError(state.file, "expected at least one observation type, found 0", where)
        twice = next((kind for kind in state.types[system] if state.types[system].count(kind) > 1), None)
        if twice:
            raise RinexError(state.file, f"expected each observation type once, found {twice} twice", where)
        if found != number:
            raise RinexError(state.file, f"expected {number} observation types as announced, found {found}", where)


def _label(text):
    label = " ".join(text[60:].upper().split())
    if label in _READERS or label in _LABELS:
        return label
    line = " ".join(text.upper().split())
    return next((known for known in (*_READERS, *_LABELS) if line.endswith(known)), label)


def _require_known_version(state, line):
    if not 2 <= state.version < 5:
        raise RinexError(state.file, f"expected RINEX version 2, 3 or 4, found {state.version:g}", line)


def _require_observations(state, text, line):
    kind = (text[:20].split()[1:] or [text[20:40].strip() or " "])[0][0].upper()
    if kind == "O":
        return
    if kind in _OTHER_KINDS:
        what = f"this is a {_OTHER_KINDS[kind]} file; name the observation file here"
        raise RinexError(state.file, f"expected observation data, found {quoted(text[20:40].strip())}: {what}", line)
    raise RinexError(state.file, f"expected 'OBSERVATION DATA' in columns 21 to 36, found {quoted(text[9:40].strip())}", line)


def _number(state, text, line, what="a number"):
    try:
        value = float(text)
    except ValueError:
        value = np.nan
    if not np.isfinite(value) or "_" in text:
        raise RinexError(state.file, f"expected {what}, found {quoted(text.strip())}", line)
    return value


def _integer(state, text, line, what="a whole number"):
    if not (text.strip().lstrip("+-").isascii() and text.strip().lstrip("+-").isdigit()):
        raise RinexError(state.file, f"expected {what}, found {quoted(text.strip())}", line)
    try:
        return int(text)
    except ValueError:
        raise RinexError(state.file, f"expected {what}, found {quoted(text.strip())}", line) from None


def _system(state, letter, line):
    if letter.upper() not in SYSTEM_NAMES:
        known = ", ".join(SYSTEM_NAMES)
        raise RinexError(state.file, f"unknown satellite system {letter!r}: expected one of {known}", line)
    return letter.upper()


def _take_types3(state, text, line):
    words = text[1:].split()
    if text[0] != " ":
        state.current = _system(state, text[0], line)
        number = _integer(state, words[0] if words else "", line, "the number of observation types")
        state.announced[state.current] = number, line
        state.types[state.current], words = (), words[1:]
    elif not state.current:
        raise RinexError(state.file, f"expected a satellite system in column 1, found {quoted(text)}", line)
    state.types[state.current] += tuple(_type(state, word, line) for word in words)


def _take_types2(state, text, line):
    words = text.split()
    if text[:6].strip():
        number = _integer(state, words.pop(0), line, "the number of observation types")
        state.announced[""] = number, line
        state.types[""] = ()
    elif "" not in state.types:
        raise RinexError(state.file, f"expected the number of observation types, found {quoted(text)}", line)
    state.types[""] += tuple(_type(state, word, line) for word in words)


def _type(state, word, line):
    if not (2 <= len(word) <= 3 and word.isascii() and word.isalnum() and word[0].isalpha()):
        raise RinexError(state.file, f"expected an observation type such as C1C or L2, found {quoted(word)}", line)
    return word.upper()


def _take_factors(state, text, line):
    words = text[1:].split()
    if text[0] != " ":
        factor = _number(state, words[0] if words else "", line, "a scale factor")
        if factor <= 0:
            raise RinexError(state.file, f"expected a positive scale factor, found {words[0]}", line)
        state.factor = _system(state, text[0], line), factor
        words = words[1:]
        words = words[1:] if words and words[0].isdigit() else words  # number of codes: not needed
        if not words:
            state.factors[state.factor[0]] = {"": factor}  # all codes of the system
    elif not state.factor:
        raise RinexError(state.file, f"expected a satellite system in column 1, found {quoted(text)}", line)
    system, factor = state.factor
    named = columns_of_version(system, tuple(_type(state, word, line) for word in words), state.version)
    state.factors.setdefault(system, {}).update(dict.fromkeys(named, factor))


def _take_wavelengths(state, text, line):
    bands = "".join(band for band, factor in zip("12", text.split(), strict=False) if factor == "2")
    satellites = [text[at : at + 6].strip().upper().replace(" ", "0") for at in range(18, 60, 6)]
    satellites = [name for name in satellites if name]
    if not satellites:
        state.is_half.clear()
    state.is_half.update(dict.fromkeys(satellites or [""], bands))


def _take_first_time(state, text, line):
    scale = text[43:].strip().upper().replace("BDS", "BDT")
    scale = scale.split()[-1] if scale.split() else ""
    if scale in _SCALES:
        state.scale = scale
    elif scale and scale[0].isalpha():
        known = ", ".join(sorted(_SCALES))
        raise RinexError(state.file, f"unknown time scale {quoted(scale)}: expected one of {known}", line)


def _take_position(state, text, line):
    position = _three_numbers(state, text, line)
    if position is not None:
        state.station["position_ecef"] = position if position.any() else None  # zeros: not known


def _take_delta(state, text, line):
    delta_hen = _three_numbers(state, text, line)
    if delta_hen is not None:
        state.station["antenna_delta_enu"] = delta_hen[[1, 2, 0]]


def _three_numbers(state, text, line):
    words = text.split()
    if not words:
        return None
    if len(words) < 3:
        raise RinexError(state.file, f"expected three numbers, found {quoted(text)}", line)
    return np.array([_number(state, word, line) for word in words[:3]])


def _take_interval(state, text, line):
    words = text.split()
    interval = _number(state, words[0], line) if words else 0.0
    state.station["interval"] = interval if interval > 0 else None


def _take_glonass(state, text, line):
    words = text[3:].replace("R ", "R0").split()
    for name, channel in zip(words[::2], words[1::2], strict=False):
        state.glonass[name.upper()] = _integer(state, channel, line, "a GLONASS frequency channel")


def _take_words(name, columns):
    def take(state, text, line):
        state.station[name] = text[columns].strip()

    return take


_READERS = {
    "SYS / # / OBS TYPES": _take_types3,
    "# / TYPES OF OBSERV": _take_types2,
    "SYS / SCALE FACTOR": _take_factors,
    "WAVELENGTH FACT L1/2": _take_wavelengths,
    "TIME OF FIRST OBS": _take_first_time,
    "APPROX POSITION XYZ": _take_position,
    "ANTENNA: DELTA H/E/N": _take_delta,
    "INTERVAL": _take_interval,
    "GLONASS SLOT / FRQ #": _take_glonass,
    "MARKER NAME": _take_words("marker", slice(0, 60)),
    "REC # / TYPE / VERS": _take_words("receiver", slice(20, 40)),
    "ANT # / TYPE": _take_words("antenna", slice(20, 40)),
}
_LABELS = ("RINEX VERSION / TYPE", "END OF HEADER", "COMMENT")
