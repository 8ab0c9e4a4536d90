"""The lines of a file as positions in one buffer of bytes, so that many lines are cut out by one array operation."""

import numpy as np

_NEWLINE, _BLANK = 10, 32


class Lines:
    """The lines of a text: where each starts and how long it is. Lines are counted from 0 here, from 1 in messages."""

    def __init__(self, content, file, spare=20_000):
        self.file = file
        self.has_last_newline = content.endswith(b"\n")
        self.content = content if self.has_last_newline else content + b"\n"
        self.spare = spare  # blanks behind the text: a row of up to so many columns may be cut out anywhere
        self.bytes = np.frombuffer(self.content + b" " * spare, dtype=np.uint8)
        end = np.flatnonzero(self.bytes[: len(self.content)] == _NEWLINE)
        self.start = np.concatenate([[0], end[:-1] + 1])
        self.length = end - self.start

    def __len__(self):
        return len(self.start)

    def text(self, line):
        """Return one line as a string."""
        start = int(self.start[line])
        return self.content[start : start + int(self.length[line])].decode("latin-1")

    def cut(self, line, first, width):
        """Return columns first to first + width of lines (...,): (..., width) uint8, with what follows shorter lines."""
        places = np.ndarray((len(self.bytes) - width + 1,), dtype=f"V{width}", buffer=self.bytes, strides=(1,))
        at = np.minimum(self.start[line] + first, len(places) - 1)
        return places[at].view(np.uint8).reshape(*at.shape, width)

    def blank_cut(self, line, first, width):
        """Return the same with blanks where lines are shorter."""
        columns = self.cut(line, first, width)
        beyond = np.arange(first, first + width) >= self.length[line][..., None]
        return np.where(beyond, np.uint8(_BLANK), columns)

    def is_blank(self, line):
        """Tell whether one line has nothing but blanks."""
        return not self.text(line).strip()
