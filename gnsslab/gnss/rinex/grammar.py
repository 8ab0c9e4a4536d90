"""How epochs are written: RINEX 2 and RINEX 3 differ here and in few other places.

Both find most epochs at once: epoch lines in the standard layout that are followed, after as many lines as they
announce, by the next one. The others are looked at one by one.
"""

import re
from typing import NamedTuple

import numpy as np

from gnsslab.gnss.rinex.epochs import CYCLE_SLIPS, EVENTS, POWER_FAILURE
from gnsslab.gnss.rinex.errors import RinexError, quoted

_EPOCH_OF_VERSION_2 = re.compile(r" [ \d]\d( [ \d]\d){4}[ \d]{2}\d\.\d{7}  \d[ \d]{2}\d")


class Run(NamedTuple):
    """Epochs one behind the other with nothing special about them."""

    line: np.ndarray  # (e,) index of the epoch line
    flag: np.ndarray  # (e,)
    count: np.ndarray  # (e,) satellites
    end: int  # index of the line behind them


def is_epoch_of_version_2(text):
    """Tell whether a line looks like an epoch line of RINEX 2: nothing marks it but where its numbers stand."""
    return _EPOCH_OF_VERSION_2.match(text) is not None


class _Grammar:
    """What both versions share; `mark` are the lines that look like epoch lines."""

    point_column = 0  # of the point in the seconds: flag and number of satellites stand 10 to 13 columns behind

    def __init__(self, lines, state, mark):
        self.lines, self.state, self.mark = lines, state, mark
        self.flag, self.count, self.is_standard = self._heads()
        self.types = None  # number of observation types for which `stop` holds
        self.stop = None

    def _heads(self):
        """Return flag and count of all epoch lines and which have them in the standard layout."""
        columns = self.lines.blank_cut(self.mark, self.point_column, 15)
        digits = columns[:, 10:14] - np.uint8(ord("0"))  # flag, hundreds, tens, ones
        is_digit, is_blank = digits < 10, columns == ord(" ")
        flag, hundreds, tens, ones = np.where(is_digit, digits, 0).T.astype(np.int64)
        good = (columns[:, 0] == ord(".")) & is_blank[:, 8:10].all(axis=1) & is_digit[:, 0] & is_digit[:, 3]
        good &= (is_digit | is_blank[:, 10:14]).all(axis=1) & (is_digit[:, 2] | ~is_digit[:, 1])
        return flag, 100 * hundreds + 10 * tens + ones, good & self._is_closed(columns[:, 14]) & (flag <= POWER_FAILURE)

    def regular_run(self, line):
        """Return the run of epochs that starts at a line, up to the next one that needs a second look."""
        if self.types != self._types():
            self.types = self._types()
            following = np.append(self.mark[1:], -1)  # the last epoch is always looked at: it may be cut off
            is_regular = self.is_standard & (self.mark + 1 + self.lines_of(self.count) == following[: len(self.mark)])
            self.stop = np.append(np.flatnonzero(~is_regular), len(self.mark))
        first = np.searchsorted(self.mark, line)
        stop = self.stop[np.searchsorted(self.stop, first)] if first < len(self.mark) and self.mark[first] == line else first
        end = int(self.mark[stop]) if stop < len(self.mark) else line
        return Run(self.mark[first:stop], self.flag[first:stop], self.count[first:stop], end)


class Version3(_Grammar):
    """Epochs of RINEX 3 and 4: each begins with a line that starts with ">", each satellite has one line."""

    point_column, year_width, clock_columns = 21, 4, (41, 15)

    def __init__(self, lines, state, first):
        mark = np.flatnonzero(lines.bytes[lines.start] == ord(">"))
        mark = mark[mark >= first]
        is_long = np.flatnonzero(lines.length[mark] > 60)  # lines of event records may start with ">" and have a label
        super().__init__(lines, state, np.delete(mark, [at for at in is_long if lines.text(mark[at])[60:80].strip()]))

    def _types(self):
        return 1  # the lines of an epoch do not depend on it

    def _is_closed(self, behind):
        return behind == ord(" ")

    def head(self, line):
        """Return flag and number of satellites (or header lines) of an epoch line."""
        text = self.lines.text(line)
        if not text.startswith(">"):
            hint = "does the epoch before announce too few satellites?"
            raise RinexError(self.lines.file, f"expected an epoch line starting with '>', found {quoted(text)}; {hint}", line + 1)
        if (text[21:22] == "." and not text[35:36].strip()) or not text[1:29].strip():
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

    def is_cut(self, line):
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


class Version2(_Grammar):
    """Epochs of RINEX 2: satellites are named in the epoch line, twelve a line; five fields a line follow for each."""

    point_column, year_width, clock_columns = 18, 2, (68, 12)

    def __init__(self, lines, state, first):
        has_point = (lines.bytes[lines.start + 18] == ord(".")) & (lines.length > 18)
        mark = np.flatnonzero(has_point & (lines.bytes[lines.start] == ord(" ")))
        super().__init__(lines, state, mark[mark >= first])

    def _types(self):
        return len(self.state.types[""])

    def _is_closed(self, behind):
        return np.ones(len(behind), dtype=bool)  # the first satellite follows without a blank

    def head(self, line):
        """Return flag and number of satellites (or header lines) of an epoch line."""
        text = self.lines.text(line)
        if text[18:19] != "." and text[:26].strip():
            self._refuse_epochs_inside(self._epoch_before(line), line)
            hint = "does the epoch before announce another number of satellites than follow?"
            raise RinexError(self.lines.file, f"expected an epoch line, found {quoted(text)}; {hint}", line + 1)
        return _checked_head(self.lines, line, text[26:29], text[29:32])

    def lines_of(self, count):
        """Return the number of lines behind the (first) epoch line for so many satellites."""
        return np.maximum(count - 1, 0) // 12 + count * self._lines_a_satellite(self._types())

    def check_inside(self, line, end, count):
        """Raise where the file's last lines, wanted by this epoch, hold another epoch.

        Elsewhere a wrong number is noticed at the line that should be an epoch line.
        """
        if end == len(self.lines):
            self._refuse_epochs_inside(line, end)

    def _epoch_before(self, line):
        """Return the epoch line whose lines end just before a line; the line itself where there is none."""
        is_last = (self.mark < line) & (self.mark + 1 + self.lines_of(self.count) == line)
        return int(self.mark[np.argmax(is_last)]) if is_last.any() else line

    def _refuse_epochs_inside(self, line, end):
        for at in range(line + 1, end):
            if is_epoch_of_version_2(self.lines.text(at)):
                problem = f"expected more lines in this epoch, as the satellites it announces need, found an epoch in line {at + 1}"
                raise RinexError(self.lines.file, problem, line + 1)

    def is_cut(self, line):
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


def _whole_number(file, line, text, what):
    if not (text.strip().isascii() and text.strip().isdigit()):
        raise RinexError(file, f"expected {what}, found {quoted(text.strip())}", line + 1)
    return int(text.strip())


def _checked_head(lines, line, flag, count):
    flag = _whole_number(lines.file, line, flag.strip() or "0", "an epoch flag from 0 to 6")
    if flag > CYCLE_SLIPS:
        raise RinexError(lines.file, f"expected an epoch flag from 0 to 6, found {flag}", line + 1)
    if flag in EVENTS and not count.strip():
        return flag, 0
    return flag, _whole_number(lines.file, line, count, "the number of satellites")
