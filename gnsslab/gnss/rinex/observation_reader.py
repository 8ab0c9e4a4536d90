"""Reading RINEX observation files, versions 2 to 4: every system, every signal, every flag.

All lines of one system are cut out of the file together and their fields converted by array operations; only what is
out of the ordinary (events, odd layouts, cut-off ends) is looked at line by line.
Sources: RINEX 2.11 (Gurtner and Estey 2007), RINEX 3.04 (IGS/RTCM-SC104 2018), RINEX 4.00 (IGS 2021).
"""

from typing import NamedTuple

import numpy as np

from gnsslab.gnss.observations import HALF_CYCLE, Observations, SystemTable
from gnsslab.gnss.rinex.epoch_times import epoch_times
from gnsslab.gnss.rinex.epochs import CYCLE_SLIPS, POWER_FAILURE, Version2, Version3, find_epochs
from gnsslab.gnss.rinex.errors import RinexError, quoted
from gnsslab.gnss.rinex.fields import WIDTH, parse_fields
from gnsslab.gnss.rinex.headers import HeaderState, check_types, take_header_line, take_version
from gnsslab.gnss.rinex.lines import Lines
from gnsslab.gnss.rinex.text import read_text
from gnsslab.gnss.signals import SYSTEM_NAMES

_END_OF_HEADER = "END OF HEADER"
_LETTERS = "".join(SYSTEM_NAMES)
_SYSTEM_OF_BYTE = np.full(256, len(_LETTERS), dtype=np.uint8)  # byte -> place in _LETTERS
for _place, _letter in enumerate(_LETTERS):
    _SYSTEM_OF_BYTE[[ord(_letter), ord(_letter.lower())]] = _place


class Rows(NamedTuple):
    """One satellite at one epoch each, in the order of the file."""

    epoch: np.ndarray  # (k,) place among the epoch lines
    index: np.ndarray  # (k,) place within the epoch
    system: np.ndarray  # (k,) place in _LETTERS
    number: np.ndarray  # (k,)


def read_rinex_obs(path):
    """Return all observations in a RINEX file of version 2, 3 or 4; plain, .gz, .Z, .bz2, .zip or Hatanaka-compressed.

    Codes are those of RINEX 3.04 whatever the version (module `codes` says how), times are GPS time, values are as
    written: phase shifts are not applied, scale factors are undone. Code and phase of 0.0 mean missing, as the format
    says. A last epoch that is cut off is left out and said in `.warnings`; anything else that is broken raises
    RinexError with file and line.
    """
    content, complaints = read_text(path)
    state, first = _read_header(content, path)
    header = state.record()
    lines = Lines(content, str(path))
    grammar = (Version2 if state.version < 3 else Version3)(lines, state, first)
    epochs = find_epochs(lines, state, grammar, first)
    time, failed, tables, notes = _all_tables(lines, state, epochs, grammar, header.time_scale)
    return Observations(
        time=time, tables=tables, header=header, power_failure=failed, source=str(path),
        events=(*epochs.events, *_slip_words(lines, state, epochs, grammar)), warnings=(*complaints, *epochs.warnings, *notes),
    )  # fmt: skip


def _read_header(content, path):
    """Return the state behind the header and the index of the first line of data."""
    if b"\0" in content:
        raise RinexError(path, "expected a text file, found a binary one")
    state, line = HeaderState(str(path)), 0
    for line, text in enumerate(_split(content), start=1):
        if line == 1:
            take_version(state, text)
        elif take_header_line(state, text, line) == _END_OF_HEADER:
            check_types(state, line)
            return state, line
        elif text.startswith("> ") and state.version >= 3 and not text[60:].strip():
            raise RinexError(path, f"expected {_END_OF_HEADER!r} before the first epoch, found {quoted(text)}", line)
    raise RinexError(path, f"expected {_END_OF_HEADER!r}, found the end of the file", line)


def _split(content):
    start = 0
    while start < len(content):
        stop = content.find(b"\n", start)
        stop = len(content) if stop < 0 else stop
        yield content[start:stop].decode("latin-1")
        start = stop + 1


def _all_tables(lines, state, epochs, grammar, scale):
    """Return time, power failures, tables by system and notes on what was set aside."""
    observed = [at for at, flag in enumerate(epochs.flag) if flag != CYCLE_SLIPS]
    line = np.array(epochs.line, dtype=np.int64)
    tag = epoch_times(lines, line, grammar.year_width, scale)
    notes = _clock_note(lines, line, grammar)
    time, epoch_of_line, order_notes = _in_order(tag[observed], line[observed])
    failed = np.zeros(len(time), dtype=bool)
    is_failure = np.array(epochs.flag, dtype=np.int64)[observed] == POWER_FAILURE
    failed[epoch_of_line[is_failure]] = True
    rows = _rows(lines, state, epochs, grammar, observed)
    tables = {}
    for place in np.unique(rows.system):
        table, doubled = _table(lines, epochs, grammar, _selected(rows, rows.system == place), observed, epoch_of_line)
        tables[table.system] = table
        notes += doubled
    return time, failed, tables, (*order_notes, *notes)


def _in_order(tag, line):
    """Return the times in increasing order, each once, the place of each epoch line among them, and notes."""
    step = np.diff(tag).astype(np.int64)
    if (step > 0).all():
        return tag, np.arange(len(tag)), []
    time, place = np.unique(tag, return_inverse=True)
    back, doubled = np.flatnonzero(step < 0), len(tag) - len(time)
    notes = []
    if len(back):
        where = f"line {line[back[0] + 1] + 1}: this epoch is earlier than the one before it"
        notes.append(f"{where} ({len(back)} such in all); the epochs were put in order of time")
    if doubled:
        same = np.flatnonzero(np.bincount(place)[place] > 1)
        where = f"line {line[same[1]] + 1}: an epoch of this time stands elsewhere in the file too"
        notes.append(f"{where} ({doubled} such in all); epochs of the same time were joined")
    return time, place, notes


def _clock_note(lines, line, grammar):
    first, width = grammar.clock_columns
    given = (lines.blank_cut(line, first, width) != ord(" ")).any(axis=1)
    return [f"receiver clock offsets stand in {given.sum()} epoch lines; they were not applied"] if given.any() else []


def _rows(lines, state, epochs, grammar, chosen):
    """Return the satellites of the chosen epoch lines, in the order of the file."""
    count = np.array(epochs.count, dtype=np.int64)[chosen]
    epoch = np.repeat(np.arange(len(chosen)), count)
    index = np.arange(len(epoch)) - np.repeat(np.cumsum(count) - count, count)
    at = np.array(epochs.line, dtype=np.int64)[chosen][epoch]
    line, column = grammar.satellite_columns(at, index, count[epoch])
    return _named(Rows(epoch, index, *_names(lines, state, line, column)), lines, line, column)


def _names(lines, state, line, column):
    """Return the place of the system letter and the number of satellites named at lines and columns; 0 where unreadable."""
    name = lines.cut(line, column, 3)
    default = "G" if state.system == "M" and state.version < 3 else state.system
    letter = np.where(name[:, 0] == ord(" "), np.uint8(ord(default)), name[:, 0])
    digit = name[:, 1:] - np.uint8(ord("0"))
    is_digit, is_blank = digit < 10, name[:, 1:] == ord(" ")
    digit = np.where(is_digit, digit, 0).astype(np.int16)
    number = np.where(is_digit[:, 1], 10 * digit[:, 0] + digit[:, 1], digit[:, 0])
    is_good = (is_digit | is_blank).all(axis=1) & (lines.length[line] >= column + 2 + is_digit[:, 1])
    return _SYSTEM_OF_BYTE[letter], np.where(is_good, number, 0).astype(np.int16)


def _named(rows, lines, line, column):
    """Return the rows; raise RinexError at the first whose satellite cannot be read."""
    bad = np.flatnonzero((rows.system == len(_LETTERS)) | (rows.number == 0))
    if len(bad):
        at, first = line[bad[0]], int(column[bad[0]])
        name = lines.text(at)[first : first + 3]
        hint = f"systems are {', '.join(_LETTERS)}"
        raise RinexError(lines.file, f"expected a satellite such as G05 ({hint}), found {quoted(name)}", int(at) + 1)
    return rows


def _selected(rows, which):
    return Rows(*(column[which] for column in rows))


def _table(lines, epochs, grammar, rows, observed, epoch_of_line):
    """Return the table of one system, and notes on rows that stood in the file twice."""
    system = _LETTERS[rows.system[0]]
    codes, value, lli, ssi = _measurements(lines, epochs, grammar, rows, observed, system)
    epoch = epoch_of_line[rows.epoch].astype(np.int32)
    key = epoch.astype(np.int64) * 1000 + rows.number
    if (np.diff(key) > 0).all():
        return SystemTable(system, codes, epoch, rows.number, value, lli, ssi), []
    _, first = np.unique(key, return_index=True)  # sorted, and of equal keys the first in the file
    table = SystemTable(system, codes, epoch[first], rows.number[first], value[first], lli[first], ssi[first])
    return table, _doubled_note(lines, epochs, rows, observed, system, first)


def _doubled_note(lines, epochs, rows, observed, system, first):
    if len(first) == len(rows.epoch):
        return []
    left = np.setdiff1d(np.arange(len(rows.epoch)), first)
    line = epochs.line[observed[rows.epoch[left[0]]]] + 1
    name = f"{system}{rows.number[left[0]]:02d}"
    return [f"epoch of line {line}: {name} is given twice ({len(left)} such in {system} in all); the first was kept"]


def _measurements(lines, epochs, grammar, rows, observed, system):
    """Return codes, value, lli and ssi of the rows of one system, whatever layouts they were written in."""
    layout_of_row = np.array(epochs.layout)[observed][rows.epoch]
    used = np.unique(layout_of_row)
    codes = tuple(dict.fromkeys(code for at in used for code in epochs.layouts[at].codes.get(system, ())))
    if len(used) == 1:
        return codes, *_of_layout(lines, epochs, grammar, rows, observed, system, used[0])
    shape = len(rows.epoch), len(codes)
    value, lli, ssi = np.full(shape, np.nan), np.zeros(shape, np.uint8), np.zeros(shape, np.uint8)
    for at in used:
        which = np.flatnonzero(layout_of_row == at)
        columns = [codes.index(code) for code in epochs.layouts[at].codes.get(system, ())]
        part = _of_layout(lines, epochs, grammar, _selected(rows, which), observed, system, at)
        for whole, piece in zip((value, lli, ssi), part, strict=True):
            whole[np.ix_(which, columns)] = piece
    return codes, value, lli, ssi


def _of_layout(lines, epochs, grammar, rows, observed, system, at):
    """Return value, lli and ssi of rows that were all written in one layout."""
    layout = epochs.layouts[at]
    fields = _cut_fields(lines, epochs, grammar, rows, observed, system, layout)
    codes = layout.codes[system]
    value, lli = fields.value, fields.lli
    is_range = np.array([code[0] in "CL" for code in codes], dtype=bool)
    value[(value == 0) & is_range] = np.nan
    for column, code in enumerate(codes):
        factor = layout.factors.get(system, {}).get(code, layout.factors.get(system, {}).get("", 1.0))
        if factor != 1.0:
            value[:, column] /= factor
    _mark_half_cycles(layout, system, rows.number, codes, value, lli)
    return value, lli, fields.ssi


def _mark_half_cycles(layout, system, number, codes, value, lli):
    """Turn round the half-cycle bit where the header says that phases come from squaring (RINEX 2 wavelength factor 2)."""
    for satellite, bands in layout.is_half.items():
        named = [f"{system}{one:02d}" in layout.is_half for one in number]
        is_meant = np.array([f"{system}{one:02d}" == satellite for one in number]) if satellite else ~np.array(named)
        for column, code in enumerate(codes):
            if code[0] == "L" and code[1] in bands:
                lli[is_meant & np.isfinite(value[:, column]), column] ^= HALF_CYCLE


def _cut_fields(lines, epochs, grammar, rows, observed, system, layout):
    """Return the fields of rows of one layout; raise RinexError at the first field that is none."""
    line = np.array(epochs.line, dtype=np.int64)[observed][rows.epoch]
    count = np.array(epochs.count, dtype=np.int64)[observed][rows.epoch]
    if system not in layout.codes:
        at = int(grammar.satellite_columns(line[:1], rows.index[:1], count[:1])[0][0])
        name = f"{system}{rows.number[0]:02d}"
        raise RinexError(lines.file, f"the header lists no observation types of system {system}, found {name}", at + 1)
    types = len(layout.codes[system])
    lines_of_row, first, each = grammar.field_lines(line, rows.index, count, types)
    words = lines.cut(lines_of_row, first, WIDTH * each).reshape(len(line), -1, WIDTH)
    room = lines.length[lines_of_row][..., None] - first - WIDTH * np.arange(each)
    room = np.clip(room, 0, WIDTH).reshape(len(line), -1)
    _refuse_surplus(lines, lines_of_row, first, each, types)
    fields = parse_fields(np.ascontiguousarray(words[:, :types]).view("<u8"), room[:, :types])
    if len(fields.strange):
        _raise_strange(lines, lines_of_row, fields.strange[0], first, each, layout.codes[system])
    return fields


def _refuse_surplus(lines, lines_of_row, first, each, types):
    """Raise RinexError where something stands behind the last column that a line may have."""
    for at in range(lines_of_row.shape[1]):
        width = first + WIDTH * min(each, types - each * at)
        for line in lines_of_row[lines.length[lines_of_row[:, at]] > width, at]:
            if surplus := lines.text(line)[width:].strip():
                problem = f"expected {types} observations of 16 columns as the header says, found {quoted(surplus)} behind them"
                raise RinexError(lines.file, problem, int(line) + 1)


def _raise_strange(lines, lines_of_row, at, first, each, codes):
    row, column = at
    line = int(lines_of_row[row, column // each])
    start = first + WIDTH * (column % each)
    found = lines.text(line)[start : start + WIDTH]
    place = f"columns {start + 1} to {start + WIDTH}"
    raise RinexError(lines.file, f"expected a number and flags ({codes[column]}) in {place}, found {quoted(found)}", line + 1)


def _slip_words(lines, state, epochs, grammar):
    """Name the cycle slips in records of flag 6: the receiver found and repaired them, so nothing is flagged."""
    chosen = [at for at, flag in enumerate(epochs.flag) if flag == CYCLE_SLIPS]
    if not chosen:
        return ()
    rows = _rows(lines, state, epochs, grammar, chosen)
    return tuple(_slips_of_row(lines, epochs, grammar, _selected(rows, slice(at, at + 1)), chosen) for at in range(len(rows.epoch)))


def _slips_of_row(lines, epochs, grammar, row, chosen):
    system = _LETTERS[row.system[0]]
    layout = epochs.layouts[epochs.layout[chosen[row.epoch[0]]]]
    value = _cut_fields(lines, epochs, grammar, row, chosen, system, layout).value[0]
    slips = [f"{code} {slip:g}" for code, slip in zip(layout.codes[system], value, strict=True) if np.isfinite(slip) and slip]
    where = f"line {epochs.line[chosen[row.epoch[0]]] + 1}: cycle slips of {system}{row.number[0]:02d}"
    return f"{where}, repaired by the receiver: {', '.join(slips) or 'none'}"
