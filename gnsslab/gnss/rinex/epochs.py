"""Epochs: which lines of a file belong to which epoch. RINEX 2 and RINEX 3 differ here and in few other places."""

import re
from dataclasses import dataclass, field

import numpy as np

from gnsslab.gnss.rinex.errors import RinexError, quoted
from gnsslab.gnss.rinex.headers import check_types, take_header_line

OBSERVED, POWER_FAILURE, CYCLE_SLIPS = 0, 1, 6  # epoch flags followed by satellites; 2 to 5 are followed by header lines
_EPOCH_OF_VERSION_2 = re.compile(r" [ \d]\d( [ \d]\d){4}[ \d]{2}\d\.\d{7}  \d[ \d]{2}\d")
_EVENTS = {2: "the antenna starts to move", 3: "a new site is occupied", 4: "header lines", 5: "an external event"}


def is_epoch_of_version_2(text):
    """Tell whether a line looks like an epoch line of RINEX 2: nothing marks it but where its numbers stand."""
    return _EPOCH_OF_VERSION_2.match(text) is not None


@dataclass
class Epochs:
    """Epoch lines that are followed by satellites, and what else was met on the way."""

    line: list = field(default_factory=list)  # index of the epoch line
    flag: list = field(default_factory=list)
    count: list = field(default_factory=list)  # satellites
    layout: list = field(default_factory=list)  # index into layouts
    layouts: list = field(default_factory=list)
    events: list = field(default_factory=list)  # words
    warnings: list = field(default_factory=list)  # words

    def with_flags(self, wanted):
        """Return the epochs whose flag is among those wanted."""
        at = [place for place, flag in enumerate(self.flag) if flag in wanted]
        chosen = ([column[place] for place in at] for column in (self.line, self.flag, self.count, self.layout))
        return Epochs(*chosen, layouts=self.layouts)


def find_epochs(lines, state, grammar, first):
    """Return all epochs from line index `first` on; the state goes along with header lines inside the file."""
    epochs = Epochs(layouts=[state.layout()])
    line = first
    while (line := _next_record(lines, epochs, line)) < len(lines):
        line = grammar.take_regular(epochs, line) or _take_one(lines, state, epochs, grammar, line)
    return epochs


def _next_record(lines, epochs, line):
    """Return the next line that is neither blank nor a comment standing between the epochs."""
    while line < len(lines) and not (text := lines.text(line).strip()).startswith(">"):
        if text.endswith("COMMENT"):
            epochs.events.append(f"line {line + 1}: comment {quoted(text[:-7], 60)}")
        elif text:
            break
        line += 1
    return line


def _take_one(lines, state, epochs, grammar, line):
    """Take the epoch or event that starts at a line; return the line behind it."""
    try:
        flag, count = grammar.head(line)
    except RinexError:
        if line == len(lines) - 1 and not lines.has_last_newline:
            return _leave_out(lines, epochs, line)
        raise
    end = line + 1 + (count if flag in _EVENTS else grammar.lines_of(count))
    grammar.check_inside(line, min(end, len(lines)), count)
    if end > len(lines) or (end == len(lines) and grammar.is_cut(line, flag)):
        return _leave_out(lines, epochs, line)
    if flag in _EVENTS:
        _take_event(lines, state, epochs, line, end, flag)
    else:
        _take_observed(epochs, [line], [flag], [count])
    return end


def _take_observed(epochs, line, flag, count):
    epochs.line += line
    epochs.flag += flag
    epochs.count += count
    epochs.layout += [len(epochs.layouts) - 1] * len(line)


def _leave_out(lines, epochs, line):
    epochs.warnings.append(f"line {line + 1}: the file ends inside this epoch; it was left out")
    return len(lines)


def _take_event(lines, state, epochs, line, end, flag):
    """Name an event, take the header lines that go with it and open a new layout where they change the columns."""
    words = [f"line {line + 1}: {_EVENTS[flag]}"]
    state.current, state.factor = "", ()
    for at in range(line + 1, end):
        text = lines.text(at)
        label = take_header_line(state, text, at + 1)
        words.append(f"{label} {quoted(text[:60].strip(), 60)}")
    check_types(state, line + 1)
    epochs.events.append("; ".join(words))
    if (layout := state.layout()) != epochs.layouts[-1]:
        epochs.layouts.append(layout)


def _whole_number(file, line, text, what):
    if not (text.strip().isascii() and text.strip().isdigit()):
        raise RinexError(file, f"expected {what}, found {quoted(text.strip())}", line + 1)
    return int(text)


def _checked_head(lines, line, flag, count):
    flag = _whole_number(lines.file, line, flag.strip() or "0", "an epoch flag from 0 to 6")
    if flag > CYCLE_SLIPS:
        raise RinexError(lines.file, f"expected an epoch flag from 0 to 6, found {flag}", line + 1)
    if flag in _EVENTS and not count.strip():
        return flag, 0
    return flag, _whole_number(lines.file, line, count, "the number of satellites")


class Version3:
    """Epochs of RINEX 3 and 4: each begins with a line that starts with ">", each satellite has one line."""

    def __init__(self, lines, state, first):
        self.lines = lines
        self.mark = self._marks(first)
        self.flag, self.count, is_regular = self._heads()
        self.stop = np.append(np.flatnonzero(~is_regular), len(self.mark))  # epochs to be looked at one by one

    def _marks(self, first):
        """Return the lines that start with ">" and hold nothing where header labels stand (event records may)."""
        start = self.lines.start
        mark = np.flatnonzero(self.lines.bytes[start] == ord(">"))
        mark = mark[mark >= first]
        is_long = np.flatnonzero(self.lines.length[mark] > 60)
        labelled = [at for at in is_long if self.lines.text(mark[at])[60:80].strip()]
        return np.delete(mark, labelled)

    def _heads(self):
        """Return flag and count of all epoch lines in the standard layout, and which epochs need no second look."""
        columns = self.lines.blank_cut(self.mark, 21, 20)
        digits = columns[:, 10:14] - np.uint8(ord("0"))  # flag, hundreds, tens, ones
        is_digit = digits < 10
        flag, hundreds, tens, ones = np.where(is_digit, digits, 0).T.astype(np.int64)
        count = 100 * hundreds + 10 * tens + ones
        is_filled = is_digit | (columns[:, 10:14] == ord(" "))
        standard = (columns[:, 0] == ord(".")) & is_digit[:, 0] & is_digit[:, 3] & is_filled.all(axis=1)
        standard &= (columns[:, 14:] == ord(" ")).all(axis=1) & (is_digit[:, 2] | ~is_digit[:, 1])
        following = np.append(self.mark[1:], -1)  # the last epoch is always looked at: it may be cut off
        return flag, count, standard & (flag <= POWER_FAILURE) & (self.mark + 1 + count == following)

    def take_regular(self, epochs, line):
        """Take the run of epochs without anything special from a line on; return the line behind, None if there is none."""
        at = np.searchsorted(self.mark, line)
        stop = self.stop[np.searchsorted(self.stop, at)]
        if at == stop or self.mark[at] != line:
            return None
        _take_observed(epochs, self.mark[at:stop].tolist(), self.flag[at:stop].tolist(), self.count[at:stop].tolist())
        return int(self.mark[stop - 1] + 1 + self.count[stop - 1])

    def head(self, line):
        """Return flag and number of satellites (or header lines) of an epoch line."""
        text = self.lines.text(line)
        if not text.startswith(">"):
            hint = "does the epoch before announce too few satellites?"
            raise RinexError(self.lines.file, f"expected an epoch line starting with '>', found {quoted(text)}; {hint}", line + 1)
        if text[21:22] == "." or not text[1:29].strip():
            return _checked_head(self.lines, line, text[29:32], text[32:35])
        words = text[1:].split()
        if len(words) < 8:
            raise RinexError(self.lines.file, f"expected '> year month day hour minute second flag number', found {quoted(text)}", line + 1)
        return _checked_head(self.lines, line, words[6], words[7])

    def lines_of(self, count):
        """Return the number of lines behind the epoch line for so many satellites."""
        return count

    def check_inside(self, line, end, count):
        """Raise where another epoch starts before all announced lines of this one are there."""
        at = np.searchsorted(self.mark, line, side="right")
        if at < len(self.mark) and self.mark[at] < end:
            found = self.mark[at] - line - 1
            raise RinexError(self.lines.file, f"expected {count} lines in this epoch as it announces, found {found}", line + 1)

    def is_cut(self, line, flag):
        """Tell whether the last line of the file stops inside a field, or sooner than that satellite's line before it.

        Asked only of the last epoch. A file that ends with a line end is whole.
        """
        last = len(self.lines) - 1
        if self.lines.has_last_newline or last == line:
            return False
        text = self.lines.text(last)
        if len(text) < 3 or 0 < (len(text) - 3) % 16 < 14:
            return True
        before = (self.lines.text(at) for at in range(line - 1, max(line - 2000, 0), -1))
        earlier = next((other for other in before if other.startswith(text[:3])), "")
        return len(text.rstrip()) < len(earlier.rstrip())

    def satellite_columns(self, epoch_line, index):
        """Return line and column of the names of satellites: `index` counts them within their epoch."""
        return epoch_line + 1 + index, np.zeros_like(index)

    def field_lines(self, rows, types):
        """Return the lines (k, 1) with the fields of satellites, the column of the first and how many are in a line."""
        return (rows.line + 1 + rows.index)[:, None], 3, max(types, 1)

    year_width, clock_columns = 4, (41, 15)


class Version2:
    """Epochs of RINEX 2: satellites are named in the epoch line, twelve a line; five fields a line follow for each."""

    def __init__(self, lines, state, first):
        self.lines, self.state, self.before = lines, state, None

    def take_regular(self, epochs, line):
        """Nothing marks an epoch line in RINEX 2, so each is found from the one before."""
        return None

    def head(self, line):
        """Return flag and number of satellites (or header lines) of an epoch line."""
        text = self.lines.text(line)
        if text[18:19] != "." and text[:26].strip():
            self._refuse_epochs_inside(self.before, line)
            hint = "does the epoch before announce another number of satellites than follow?"
            raise RinexError(self.lines.file, f"expected an epoch line, found {quoted(text)}; {hint}", line + 1)
        return _checked_head(self.lines, line, text[26:29], text[29:32])

    def lines_of(self, count):
        """Return the number of lines behind the (first) epoch line for so many satellites."""
        return max(count - 1, 0) // 12 + count * self._lines_a_satellite(len(self.state.types[""]))

    def check_inside(self, line, end, count):
        """Raise where the file's last lines, wanted by this epoch, hold another epoch.

        Elsewhere a wrong number is noticed at the line that should be an epoch line.
        """
        self.before = line
        if end == len(self.lines):
            self._refuse_epochs_inside(line, end)

    def _refuse_epochs_inside(self, line, end):
        if line is None:
            return
        for at in range(line + 1, end):
            if is_epoch_of_version_2(self.lines.text(at)):
                problem = f"expected more lines in this epoch, as the satellites it announces need, found an epoch in line {at + 1}"
                raise RinexError(self.lines.file, problem, line + 1)

    def is_cut(self, line, flag):
        """Tell whether the last line of the file stops inside a field; a file that ends with a line end is whole."""
        last = len(self.lines) - 1
        return not self.lines.has_last_newline and last > line and 0 < int(self.lines.length[last]) % 16 < 14

    def satellite_columns(self, epoch_line, index):
        """Return line and column of the names of satellites: `index` counts them within their epoch."""
        return epoch_line + index // 12, 32 + 3 * (index % 12)

    def field_lines(self, rows, types):
        """Return the lines (k, l) with the fields of satellites, the column of the first and how many are in a line."""
        each = self._lines_a_satellite(types)
        first = rows.line + 1 + (rows.count - 1) // 12 + rows.index * each
        return first[:, None] + np.arange(each), 0, 5

    @staticmethod
    def _lines_a_satellite(types):
        return (types + 4) // 5

    year_width, clock_columns = 2, (68, 12)
