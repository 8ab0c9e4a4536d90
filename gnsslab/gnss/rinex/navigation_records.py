"""From the lines of a navigation file to its data sets, for each of the three generations of the format."""

import re
from collections import Counter
from typing import NamedTuple

from gnsslab.gnss.rinex.errors import RinexError, quoted
from gnsslab.gnss.rinex.navigation_fields import FIELD_WIDTH, LINES, epoch, number, numbers
from gnsslab.gnss.rinex.navigation_header import is_klobuchar
from gnsslab.gnss.signals import SYSTEM_NAMES, USED_SYSTEMS

_MESSAGES_4 = {"G": ("LNAV",), "J": ("LNAV",), "E": ("INAV", "FNAV"), "C": ("D1", "D2")}
_KLOBUCHAR_4 = {"G": "LNAV", "J": "LNAV", "C": "D1D2"}  # the satellite's number may be missing here: the model is the system's
_NAME_AND_TIME = 22  # columns that both take, in RINEX 2; one more since
_NO_ORBIT_4 = ("ION", "STO", "EOP")  # other ionosphere models, time offsets, Earth rotation: of no use here


class Record(NamedTuple):
    """One data set as it stands in the file."""

    satellite: str
    lines: list
    line: int  # number of its first line
    indent: int  # columns before the first number of a continuation line: 3 in RINEX 2, 4 since


class Body(NamedTuple):
    """What follows the header."""

    records: list
    ionosphere: dict
    warnings: list


def read_body(lines, header, path):
    """Return the `Body` of a file: its complete data sets of the systems used here; the others are counted, in words."""
    groups, begun = _without_begun(_groups(lines, header, path))
    read = {2: _body_2, 3: _body_3, 4: _body_4}[int(header.version)]
    records, ionosphere, skipped = read(groups, header, path)
    whole, cut = _without_cut(records, lines, path)
    said = [f"{count} {name} {'data set is' if count == 1 else 'data sets are'} not used here" for name, count in skipped.items()]
    return Body(whole, ionosphere, said + cut + begun)


def epoch_of(record, path):
    """Return the time of clock [ns since 1970], in the time scale of the satellite's system."""
    text = record.lines[0][record.indent : record.indent + FIELD_WIDTH]
    try:
        return epoch(text)
    except ValueError:
        raise RinexError(path, f"expected year month day hour minute second, found {quoted(text)}", line=record.line) from None


def values_of(record, path):
    """Return the numbers of a data set: three of the first line, four of each that follows; blank fields are zero."""
    try:
        return numbers(_joined(record))
    except ValueError:
        raise _bad_field(record, path) from None


def is_blank(record, place):
    """Return whether a field of a data set is not written."""
    return not _field(record, place)[2].strip()


def _groups(lines, header, path):
    """Return (number of the first line, lines) of each group: a line that begins something, and those that continue it."""
    width = 2 if header.version < 3 else 1
    body = lines[header.length :]
    if header.version < 4:
        starts = [k for k, line in enumerate(body) if line[:width].strip()]
    else:
        starts = [k for k, line in enumerate(body) if line[:1] == ">"]
    first = starts[0] if starts else len(body)
    _require_blank(body[:first], "a satellite or a record that begins with >", header.length + 1, path)
    ends = [*starts[1:], len(body)]
    return [(header.length + start + 1, body[start:end]) for start, end in zip(starts, ends, strict=False)]


def _without_begun(groups):
    """Return the groups but for a last one that is cut off before its numbers, or is an ION record without line end."""
    if not groups:
        return [], []
    row, lines = groups[-1]
    is_cut = lines[-1].strip() != ""  # a whole file ends with a line end, behind which there is nothing
    is_begun = len(lines) <= 2 and len(lines[-1]) < _NAME_AND_TIME
    if is_cut and (is_begun or lines[0].startswith("> ION")):
        return groups[:-1], [f"line {row}: the record that begins here is cut off and is left out"]
    return groups, []


def _require_blank(lines, expected, first, path):
    for row, line in enumerate(lines, start=first):
        if line.strip():
            raise RinexError(path, f"expected {expected}, found {quoted(line)}", line=row)


def _body_2(groups, header, path):
    if header.system not in USED_SYSTEMS:
        return [], {}, Counter({SYSTEM_NAMES[header.system]: len(groups)} if groups else {})
    records = []
    for row, lines in groups:
        text = lines[0][:2].strip()
        if not (text.isascii() and text.isdigit() and int(text)):
            raise RinexError(path, f"expected a satellite number in columns 1-2, found {quoted(lines[0])}", line=row)
        records.append(Record(f"{header.system}{int(text):02d}", lines, row, indent=3))
    return records, {}, Counter()


def _body_3(groups, header, path):
    records, skipped = [], Counter()
    for row, lines in groups:
        satellite = _satellite(lines[0][:3], path, row)
        if satellite[0] in USED_SYSTEMS:
            records.append(Record(satellite, lines, row, indent=4))
        else:
            skipped[SYSTEM_NAMES[satellite[0]]] += 1
    return records, {}, skipped


def _body_4(groups, header, path):
    records, ionosphere, skipped = [], {}, Counter()
    for row, (marker, *lines) in groups:
        kind, message = marker[2:5], marker[10:14].strip()
        if kind == "EPH":
            record = Record(_satellite(marker[6:9], path, row), lines, row + 1, indent=4)
            if message in _MESSAGES_4.get(record.satellite[0], ()):
                records.append(_of_same_satellite(record, path))
            else:
                skipped[f"{SYSTEM_NAMES[record.satellite[0]]} {message}"] += 1
        elif kind == "ION" and message == _KLOBUCHAR_4.get(marker[6:7]) and marker[6] not in ionosphere:
            ionosphere.update(_klobuchar(Record(marker[6], lines, row + 1, indent=4), path))
        elif kind not in _NO_ORBIT_4:
            raise RinexError(path, f"expected > EPH, ION, STO or EOP, found {quoted(marker)}", line=row)
    return records, ionosphere, skipped


def _of_same_satellite(record, path):
    """Return the record; RinexError where its own first line names another satellite than the line before it."""
    found = record.lines[0][:3] if record.lines else record.satellite
    if found.strip() and _satellite(found, path, record.line) != record.satellite:
        raise RinexError(path, f"expected {record.satellite} as the line before says, found {quoted(found)}", line=record.line)
    return record


def _klobuchar(record, path):
    """Return {system letter: coefficients} of an ION record: alpha 0-2 behind the time, alpha 3, beta 0-2, and beta 3."""
    values = values_of(record, path)[:8] if len(record.lines) >= 3 else []
    return {record.satellite: values} if is_klobuchar(values) else {}


def _satellite(text, path, row):
    name = text[:1] + text[1:].replace(" ", "0")
    if re.fullmatch("[A-Z][0-9]{2}", name) and name[0] in SYSTEM_NAMES and name[1:] != "00":
        return name
    expected = f"a satellite (one of {' '.join(SYSTEM_NAMES)} and a number, as G05)"
    raise RinexError(path, f"expected {expected}, found {quoted(text)}", line=row)


def _without_cut(records, lines, path):
    """Return the complete records, and what is to be said of the others."""
    whole, said = [], []
    for record in records:
        _require_blank(record.lines[LINES:], "a satellite, as eight lines make a data set", record.line + LINES, path)
        if len(record.lines) < LINES or _is_cut_inside(record, lines[-1]):
            said.append(f"line {record.line}: the data set of {record.satellite} is cut off and is left out")
        else:
            whole.append(record)
    return whole, said


def _is_cut_inside(record, last_line):
    """Return whether the file stops inside a number of the record: it ends without a line end, and not behind a field."""
    return record.lines[-1] is last_line and (len(last_line.rstrip()) - record.indent) % FIELD_WIDTH != 0 and last_line.strip() != ""


def _joined(record):
    first, *rest = record.lines[:LINES]
    start = record.indent + FIELD_WIDTH
    fields = [first[start : start + 3 * FIELD_WIDTH].ljust(3 * FIELD_WIDTH)]
    fields += [line[record.indent : record.indent + 4 * FIELD_WIDTH].ljust(4 * FIELD_WIDTH) for line in rest]
    return "".join(fields)


def _field(record, place):
    """Return line number, first column (from zero) and text of a field of a data set."""
    below, across = divmod(place + 1, 4)
    start = record.indent + FIELD_WIDTH * across
    return record.line + below, start, record.lines[below][start : start + FIELD_WIDTH]


def _bad_field(record, path):
    """Return the error that names the first field of a data set that is no number."""
    for place in range(len(_joined(record)) // FIELD_WIDTH):
        row, start, text = _field(record, place)
        try:
            number(text)
        except ValueError:
            problem = f"expected a number in columns {start + 1}-{start + FIELD_WIDTH}, found {quoted(text.strip())}"
            return RinexError(path, problem, line=row)
    raise AssertionError("a data set without a bad field was called bad")
