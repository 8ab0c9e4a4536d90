"""A monitored series as a table, and what was found in it as lines of text."""

import numpy as np

from gnsslab.cli.tables import texts
from gnsslab.gnss.series_files.gathering import counted
from gnsslab.gnss.times import iso_text, seconds_between, usual_step
from gnsslab.systems.monitoring import Flag

COLUMNS = (
    "time,east_m,north_m,up_m,east_filtered_m,north_filtered_m,up_filtered_m,sigma_east_m,sigma_north_m,sigma_up_m,flag,alarm"  # of the filtered
)
PIECE = 50_000  # rows made into text at a time
DECIMALS = 5  # 0.01 mm: what daily solutions are printed with
SHOWN = 20  # steps and alarms told; all are in the table
AXES = ("east", "north", "up")
LONGER = 1.5  # usual intervals: where the next epoch comes later, epochs are missing


def write_monitored_csv(path, monitored):
    """Write one row for each epoch; the sigmas are those of the filtered positions."""
    with open(path, "w", encoding="utf-8", newline="\n") as file:
        file.write(COLUMNS + "\n")
        for begin in range(0, len(monitored.time), PIECE):
            file.writelines(_lines(monitored, slice(begin, begin + PIECE)))


def summary(monitored):
    """Return what was found: epochs, gaps, outliers, each step with its size, each stretch of alarm."""
    return [
        f"{counted(len(monitored.time), 'epoch')}: {_flags(monitored)}",
        *_missing(monitored.time),
        *_steps(monitored.steps),
        *_alarms(monitored),
    ]


def _lines(monitored, piece):
    time = np.datetime_as_string(monitored.time[piece] + np.timedelta64(500_000, "ns"), unit="ms")
    values = np.round(np.concatenate([monitored.enu[piece], monitored.level[piece], monitored.sigma[piece]], axis=1), DECIMALS) + 0.0  # no -0
    names = {flag.value: flag.name.lower() for flag in Flag}
    flags = [names[flag] for flag in monitored.flag[piece].tolist()]
    columns = [time.tolist(), *(texts(column.tolist(), DECIMALS) for column in values.T), flags, _zero_or_one(monitored.alarm[piece])]
    return [",".join(row) + "\n" for row in zip(*columns, strict=True)]


def _zero_or_one(alarm):
    return ["1" if each else "0" for each in alarm.tolist()]


def _flags(monitored):
    counts = {flag: int((monitored.flag == flag).sum()) for flag in Flag}
    return f"{counted(counts[Flag.OUTLIER], 'outlier')}, {counted(len(monitored.steps), 'step')}, {counts[Flag.GAP]} without solution"


def _missing(time):
    """Say where rows are missing, by the usual interval."""
    if len(time) < 3:
        return []
    after = seconds_between(time[1:], time[:-1])
    usual = usual_step(time)
    missing = np.flatnonzero(after > LONGER * usual)
    if not len(missing):
        return []
    longest = missing[np.argmax(after[missing])]
    return [f"usual interval {usual:g} s; {counted(len(missing), 'longer one')}, the longest {after[longest]:g} s from {iso_text(time[longest])}"]


def _steps(steps):
    """Tell the steps in order of time; of many, the largest."""
    if len(steps) <= SHOWN:
        return [_step(step) for step in steps]
    largest = sorted(steps, key=lambda step: -np.linalg.norm(step.size))[:SHOWN]
    return [f"the largest {SHOWN} of them:", *(_step(step) for step in sorted(largest, key=lambda step: step.first))]


def _step(step):
    sizes = (f"{axis} {1e3 * size:+.1f} mm (sigma {1e3 * sigma:.1f})" for axis, size, sigma in zip(AXES, step.size, step.sigma, strict=True))
    return f"step at {iso_text(step.time)}: {', '.join(sizes)}; found {counted(step.found - step.first, 'epoch')} later"


def _alarms(monitored):
    edges = np.diff(np.concatenate([[0], monitored.alarm.astype(int), [0]]))
    spans = zip(np.flatnonzero(edges == 1), np.flatnonzero(edges == -1) - 1, strict=True)
    lines = [f"alarm from {iso_text(monitored.time[a])} to {iso_text(monitored.time[b])} ({counted(b - a + 1, 'epoch')})" for a, b in spans]
    more = [f"and {len(lines) - SHOWN} alarms more, in the table"] if len(lines) > SHOWN else []
    return [*lines[:SHOWN], *more] or ["no alarm"]
