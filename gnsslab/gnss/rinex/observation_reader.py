"""Reading RINEX observation files, versions 2 to 4: every system, every signal, every flag.

All lines of one system are cut out of the file together and their fields converted by array operations; only what is
out of the ordinary (events, odd layouts, cut-off ends) is looked at line by line.
Sources: RINEX 2.11 (Gurtner and Estey 2007), RINEX 3.04 (IGS/RTCM-SC104 2018), RINEX 4.00 (IGS 2021).
"""

import numpy as np

from gnsslab.gnss.observations import Observations, SystemTable
from gnsslab.gnss.rinex.epoch_times import epoch_times
from gnsslab.gnss.rinex.epochs import CYCLE_SLIPS, OBSERVED, POWER_FAILURE, find_epochs
from gnsslab.gnss.rinex.errors import RinexError, quoted
from gnsslab.gnss.rinex.grammar import Version2, Version3, is_epoch_of_version_2
from gnsslab.gnss.rinex.headers import HeaderState, check_types, take_header_line, take_version
from gnsslab.gnss.rinex.lines import Lines
from gnsslab.gnss.rinex.rows import LETTERS, find_rows, measurements, raw_fields
from gnsslab.gnss.rinex.text import read_text

_END_OF_HEADER = "END OF HEADER"
_UNPRINTABLE = bytes([*range(9), *range(127, 256)])


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
    slips = _slips_in_words(lines, state, epochs.with_flags((CYCLE_SLIPS,)), grammar)
    observed = epochs.with_flags((OBSERVED, POWER_FAILURE))
    time, place, time_notes = _times(lines, observed, grammar, header.time_scale)
    tables, row_notes = _tables(lines, state, observed, grammar, place)
    return Observations(
        time=time,
        tables=tables,
        header=header,
        power_failure=_power_failures(observed, place, len(time)),
        events=(*epochs.events, *slips),
        warnings=(*complaints, *epochs.warnings, *time_notes, *row_notes),
        source=str(path),
    )


def _read_header(content, path):
    """Return the state behind the header and the index of the first line of data."""
    if b"\0" in content or any(byte in _UNPRINTABLE for byte in content[:20]):
        raise RinexError(path, "expected a text file, found a binary one", 1)
    state, line = HeaderState(str(path)), 0
    for line, text in enumerate(_split(content), start=1):
        if line == 1:
            take_version(state, text)
        elif take_header_line(state, text, line) == _END_OF_HEADER:
            check_types(state, line)
            return state, line
        elif _starts_epoch(state, text):
            raise RinexError(path, f"expected {_END_OF_HEADER!r} before the first epoch, found {quoted(text)}", line)
    raise RinexError(path, f"expected {_END_OF_HEADER!r}, found the end of the file", line)


def _starts_epoch(state, text):
    if state.version < 3:
        return is_epoch_of_version_2(text)
    return text.startswith("> ") and not text[60:].strip()


def _split(content):
    start = 0
    while start < len(content):
        stop = content.find(b"\n", start)
        stop = len(content) if stop < 0 else stop
        yield content[start:stop].decode("latin-1")
        start = stop + 1


def _times(lines, observed, grammar, scale):
    """Return the times in increasing order, each once, the place of each epoch line among them, and notes."""
    line = np.array(observed.line, dtype=np.int64)
    tag = epoch_times(lines, line, grammar.year_width, scale)
    notes = _clock_note(lines, line, grammar)
    step = np.diff(tag).astype(np.int64)
    if (step > 0).all():
        return tag, np.arange(len(tag)), notes
    time, place = np.unique(tag, return_inverse=True)
    return time, place, [*notes, *_backward_note(line, step), *_repeated_note(line, place)]


def _clock_note(lines, line, grammar):
    first, width = grammar.clock_columns
    given = (lines.blank_cut(line, first, width) != ord(" ")).any(axis=1).sum()
    return [f"receiver clock offsets stand in {given} epoch lines; they were not applied"] if given else []


def _backward_note(line, step):
    back = np.flatnonzero(step < 0)
    if not len(back):
        return []
    what = f"line {line[back[0] + 1] + 1}: this epoch is earlier than the one before it"
    return [f"{what} ({len(back)} such in all); the epochs were put in order of time"]


def _repeated_note(line, place):
    first = np.unique(place, return_index=True)[1]
    repeated = np.setdiff1d(np.arange(len(place)), first)
    if not len(repeated):
        return []
    what = f"line {line[repeated[0]] + 1}: an epoch of this time stands in the file already"
    return [f"{what} ({len(repeated)} such in all); epochs of the same time were joined"]


def _power_failures(observed, place, epochs):
    failed = np.zeros(epochs, dtype=bool)
    failed[place[np.array(observed.flag, dtype=np.int64) == POWER_FAILURE]] = True
    return failed


def _tables(lines, state, observed, grammar, place):
    """Return the table of each system and notes on what stood in the file twice."""
    rows = find_rows(lines, state, observed, grammar)
    tables, notes = {}, []
    for system in np.unique(rows.system):
        of_system = rows.pick(rows.system == system)
        table, note = _table(lines, grammar, observed.layouts, of_system, place[of_system.epoch].astype(np.int32))
        tables[table.system] = table
        notes += note
    return tables, notes


def _table(lines, grammar, layouts, rows, epoch):
    """Return the table of one system, sorted by epoch and satellite, and a note on rows given twice."""
    system = LETTERS[rows.system[0]]
    codes, value, lli, ssi = measurements(lines, grammar, layouts, rows)
    key = epoch.astype(np.int64) * 1000 + rows.number
    if (np.diff(key) > 0).all():
        return SystemTable(system, codes, epoch, rows.number, value, lli, ssi), []
    first = np.unique(key, return_index=True)[1]  # in order, and of equal keys the first in the file
    table = SystemTable(system, codes, epoch[first], rows.number[first], value[first], lli[first], ssi[first])
    return table, _twice_note(rows, np.setdiff1d(np.arange(len(key)), first))


def _twice_note(rows, left):
    if not len(left):
        return []
    what = f"epoch of line {rows.line[left[0]] + 1}: {rows.name(left[0])} is given a second time at this time"
    return [f"{what} ({len(left)} such rows of {LETTERS[rows.system[0]]} in all); the first was kept"]


def _slips_in_words(lines, state, slips, grammar):
    """Name the cycle slips in records of flag 6: the receiver found and repaired them, so no phase is flagged."""
    rows = find_rows(lines, state, slips, grammar)
    return tuple(_slip_in_words(lines, slips, grammar, rows.pick(slice(at, at + 1))) for at in range(len(rows.line)))


def _slip_in_words(lines, slips, grammar, row):
    layout = slips.layouts[row.layout[0]]
    value = raw_fields(lines, grammar, layout, row)[0][0]
    codes = layout.codes[LETTERS[row.system[0]]]
    cycles = [f"{code} {slip:g}" for code, slip in zip(codes, value, strict=True) if np.isfinite(slip) and slip]
    what = f"line {row.line[0] + 1}: cycle slips of {row.name(0)} found and repaired by the receiver"
    return f"{what}: {', '.join(cycles) or 'none'}"
