"""Rows: one satellite at one epoch each, as named in the file, and the measurements that go with them."""

from typing import NamedTuple

import numpy as np

from gnsslab.gnss.observations import HALF_CYCLE
from gnsslab.gnss.rinex.errors import RinexError, quoted
from gnsslab.gnss.rinex.fields import WIDTH, parse_fields
from gnsslab.gnss.signals import SYSTEM_NAMES

LETTERS = "".join(SYSTEM_NAMES)
_SYSTEM_OF_BYTE = np.full(256, len(LETTERS), dtype=np.uint8)  # byte -> place in LETTERS
for _place, _letter in enumerate(LETTERS):
    _SYSTEM_OF_BYTE[[ord(_letter), ord(_letter.lower())]] = _place

_FIELDS_AT_ONCE = 20_000  # so that what is in work (10 arrays of 8 bytes a field) stays in the processor's cache


class Rows(NamedTuple):
    """k rows in the order of the file."""

    epoch: np.ndarray  # (k,) place among the epoch lines
    line: np.ndarray  # (k,) index of the epoch line
    index: np.ndarray  # (k,) place of the satellite within the epoch
    count: np.ndarray  # (k,) satellites of the epoch
    layout: np.ndarray  # (k,) index into Epochs.layouts
    system: np.ndarray  # (k,) place in LETTERS
    number: np.ndarray  # (k,) int16

    def pick(self, which):
        """Return the rows that an index, a mask or a slice picks."""
        return Rows(*(column[which] for column in self))

    def name(self, at):
        """Return the name of a satellite: "G05"."""
        return f"{LETTERS[self.system[at]]}{self.number[at]:02d}"


def find_rows(lines, state, epochs, grammar):
    """Return the rows of all epochs; raise RinexError at the first satellite that cannot be read."""
    count = np.array(epochs.count, dtype=np.int64)
    epoch = np.repeat(np.arange(len(count)), count)
    index = np.arange(len(epoch)) - np.repeat(np.cumsum(count) - count, count)
    at, layout = np.array(epochs.line, dtype=np.int64)[epoch], np.array(epochs.layout, dtype=np.int64)[epoch]
    line, column = grammar.satellite_columns(at, index)
    system, number = _names(lines, state, line, column)
    _require_names(lines, line, column, (system < len(LETTERS)) & (number > 0))
    return Rows(epoch, at, index, count[epoch], layout, system, number)


def _names(lines, state, line, column):
    """Return the places of the system letters and the numbers of satellites named at lines and columns; 0 where unreadable."""
    name = lines.cut(line, column, 3)
    default = "G" if state.system == "M" and state.version < 3 else state.system
    letter = np.where(name[:, 0] == ord(" "), np.uint8(ord(default)), name[:, 0])
    digit = name[:, 1:] - np.uint8(ord("0"))
    is_digit, is_blank = digit < 10, name[:, 1:] == ord(" ")
    digit = np.where(is_digit, digit, 0).astype(np.int16)
    number = np.where(is_digit[:, 1], 10 * digit[:, 0] + digit[:, 1], digit[:, 0])
    is_good = (is_digit | is_blank).all(axis=1) & (lines.length[line] >= column + 2 + is_digit[:, 1])
    return _SYSTEM_OF_BYTE[letter], np.where(is_good, number, 0).astype(np.int16)


def _require_names(lines, line, column, is_good):
    if is_good.all():
        return
    bad = np.argmin(is_good)
    at, first = int(line[bad]), int(column[bad])
    name = lines.text(at)[first : first + 3]
    hint = f"systems are {', '.join(LETTERS)}"
    raise RinexError(lines.file, f"expected a satellite such as G05 ({hint}), found {quoted(name)}", at + 1)


def measurements(lines, grammar, layouts, rows):
    """Return codes (n,), value, lli and ssi (k, n) of rows of one system, whatever layouts they were written in."""
    system = LETTERS[rows.system[0]]
    used = np.unique(rows.layout)
    if len(used) == 1:
        return layouts[used[0]].codes.get(system, ()), *_of_layout(lines, grammar, layouts[used[0]], rows)
    codes = tuple(dict.fromkeys(code for at in used for code in layouts[at].codes.get(system, ())))
    shape = len(rows.line), len(codes)
    whole = np.full(shape, np.nan), np.zeros(shape, np.uint8), np.zeros(shape, np.uint8)
    for at in used:
        which = np.flatnonzero(rows.layout == at)
        part = _of_layout(lines, grammar, layouts[at], rows.pick(which))
        columns = [codes.index(code) for code in layouts[at].codes[system]]
        for array, piece in zip(whole, part, strict=True):
            array[np.ix_(which, columns)] = piece
    return codes, *whole


def _of_layout(lines, grammar, layout, rows):
    """Return value, lli and ssi of rows that were all written in one layout."""
    value, lli, ssi = raw_fields(lines, grammar, layout, rows)
    system = LETTERS[rows.system[0]]
    codes, factors = layout.codes[system], layout.factors.get(system, {})
    is_range = np.array([code[0] in "CL" for code in codes], dtype=bool)
    value[(value == 0) & is_range] = np.nan  # RINEX: missing observations are blank or 0.0; a Doppler may be zero
    for column, code in enumerate(codes):
        factor = factors.get(code, factors.get("", 1.0))
        if factor != 1.0:
            value[:, column] /= factor
    _mark_half_cycles(layout.is_half, rows, codes, value, lli)
    return value, lli, ssi


def _mark_half_cycles(is_half, rows, codes, value, lli):
    """Turn round the half-cycle bit where the header says that phases come from squaring (RINEX 2 wavelength factor 2)."""
    if not any(is_half.values()):
        return
    bands = [is_half.get(rows.name(at), is_half.get("", "")) for at in range(len(rows.line))]
    for column, code in enumerate(codes):
        if code[0] == "L":
            is_squared = np.array([code[1] in of_row for of_row in bands])
            lli[is_squared & np.isfinite(value[:, column]), column] ^= HALF_CYCLE


def raw_fields(lines, grammar, layout, rows):
    """Return value, lli and ssi (k, n) as they stand in the file; raise RinexError at the first field that is none."""
    system = LETTERS[rows.system[0]]
    if system not in layout.codes:
        at = int(grammar.satellite_columns(rows.line[:1], rows.index[:1])[0][0])
        raise RinexError(lines.file, f"the header lists no observation types of system {system}, found {rows.name(0)}", at + 1)
    codes = layout.codes[system]
    shape = len(rows.line), len(codes)
    value, lli, ssi = np.empty(shape), np.empty(shape, np.uint8), np.empty(shape, np.uint8)
    step = max(_FIELDS_AT_ONCE // max(len(codes), 1), 1)
    for start in range(0, len(rows.line), step):
        part = slice(start, start + step)
        value[part], lli[part], ssi[part] = _fields_of(lines, grammar, rows.pick(part), codes)
    return value, lli, ssi


def _fields_of(lines, grammar, rows, codes):
    at, first, each = grammar.field_lines(rows, len(codes))  # (k, l): lines of each row, `each` fields from column `first`
    words = lines.cut(at, first, WIDTH * each).reshape(len(at), -1, WIDTH)[:, : len(codes)]
    room = lines.length[at][..., None] - first - WIDTH * np.arange(each)
    room = np.clip(room, 0, WIDTH).reshape(len(at), -1)[:, : len(codes)]
    _refuse_surplus(lines, at, first, each, len(codes))
    fields = parse_fields(np.ascontiguousarray(words).view("<u8"), room)
    if len(fields.strange):
        row, column = fields.strange[0]
        _raise_strange(lines, int(at[row, column // each]), first + WIDTH * (column % each), codes[column])
    return fields[:3]


def _refuse_surplus(lines, at, first, each, types):
    """Raise RinexError where something stands behind the last column that a line may have."""
    for part in range(at.shape[1]):
        width = first + WIDTH * min(each, types - each * part)
        for line in at[lines.length[at[:, part]] > width, part]:
            if surplus := lines.text(line)[width:].strip():
                problem = f"expected {types} observations of 16 columns as the header says, found {quoted(surplus)} behind them"
                raise RinexError(lines.file, problem, int(line) + 1)


def _raise_strange(lines, line, start, code):
    found = lines.text(line)[start : start + WIDTH]
    place = f"columns {start + 1} to {start + WIDTH}"
    raise RinexError(lines.file, f"expected a number and flags ({code}) in {place}, found {quoted(found)}", line + 1)
