"""Epochs: which lines of a file belong to which epoch, and the header lines that stand between epochs."""

from dataclasses import dataclass, field

from gnsslab.gnss.rinex.errors import RinexError, quoted
from gnsslab.gnss.rinex.headers import check_types, take_header_line

OBSERVED, POWER_FAILURE, CYCLE_SLIPS = 0, 1, 6  # epoch flags followed by satellites; 2 to 5 are followed by header lines
EVENTS = {2: "the antenna starts to move", 3: "a new site is occupied", 4: "header lines", 5: "an external event"}


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
        run = grammar.regular_run(line)
        if len(run.line):
            _take_observed(epochs, *(column.tolist() for column in run[:3]))
        line = run.end if len(run.line) else _take_one(lines, state, epochs, grammar, line)
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
    end = line + 1 + (count if flag in EVENTS else grammar.lines_of(count))
    grammar.check_inside(line, min(end, len(lines)), count)
    if end > len(lines) or (end == len(lines) and grammar.is_cut(line)):
        return _leave_out(lines, epochs, line)
    if flag in EVENTS:
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
    words = [f"line {line + 1}: {EVENTS[flag]}"]
    state.current, state.factor = "", ()
    for at in range(line + 1, end):
        text = lines.text(at)
        label = take_header_line(state, text, at + 1)
        words.append(f"{label} {quoted(text[:60].strip(), 60)}")
    check_types(state, line + 1)
    epochs.events.append("; ".join(words))
    if (layout := state.layout()) != epochs.layouts[-1]:
        epochs.layouts.append(layout)
