"""Tables that paper B has not: all its methods by the truth, and with steps of many sizes."""

import numpy as np

from gnsslab.reproduce.paper_b_formulas import CM
from gnsslab.reproduce.paper_b_items import NAMES
from gnsslab.reproduce.paper_b_steps import ALLOWED, LATEST, PAUSE, START, sizes_cm
from gnsslab.reproduce.papers import Column, Table

_AHEAD = "Moving average, wavelet and EEMD look ahead: nobody has their level at the epoch itself."
_OWN = " ".join((
    f"A level without an alarm of its own is watched by a threshold: the smallest distance from the true place with at most {ALLOWED:g} false alarm",
    f"a series on other draws. The first {START} epochs do not count; an alarm is another one after {PAUSE} epochs without.",
    "The monitor, the filter of gnsslab monitor, finds steps itself; its alarm is for steps of 2 cm or more.",
    f"Missed: no alarm within {LATEST} epochs. none: in half of the draws or more there was none.",
))  # fmt: skip
_STILL = {
    "fixed": Column("RMSE about own mean", "cm"),
    "bias": Column("bias of the length", "cm"),
    "length": Column("RMSE of the length", "cm"),
    "position": Column("RMSE of the position", "cm"),
}
_OVERVIEW = {
    "false alarms": Column("false alarms a series", "", is_share=True),
    "alarm {}": Column("lag of the alarm", "epochs"),
    "missed {}": Column("missed", "%", is_share=True),
    "lag 50 {}": Column("level to 50 %", "epochs"),
    "lag 90 {}": Column("to 90 %", "epochs"),
    "lag 99 {}": Column("to 99 %", "epochs"),
    "rmse still": Column("RMSE of the position, no step", "cm"),
    "rmse {}": Column("with the step", "cm"),
    "rmse after {}": Column(f"in {LATEST} epochs after it", "cm"),
}
_BY_SIZE = {
    "alarm": (Column("lag of the alarm", "epochs"), _OWN),
    "missed": (Column("missed", "%", is_share=True), _OWN),
    "lag 50": (Column("level to 50 %", "epochs"), _AHEAD),
    "lag 90": (Column("level to 90 %", "epochs"), _AHEAD),
    "rmse after": (Column(f"RMSE of the position in {LATEST} epochs after the step", "cm"), _AHEAD),
}


def still_table(numbers):
    """Return the Table of the series at rest: the paper's criterion beside those of the truth."""
    words = f"The paper's criterion first, then what the truth says of length and position. {_AHEAD}"
    rows = {title: tuple(numbers[f"{key} {name}"] for key in _STILL) for name, title in NAMES.items()}
    return Table("At rest, by the truth", words, tuple(_STILL.values()), rows)


def overview_table(scenario, judged, size):
    """Return the Table of one size [cm] of step: alarm, level and errors of all methods."""
    keys = [key.format(size) for key in _OVERVIEW]
    rows = {NAMES.get(name, name): (_threshold(judged, name), *(found[key] for key in keys)) for name, found in judged.numbers.items()}
    columns = (Column("threshold", "cm"), *_OVERVIEW.values())
    return Table(f"A step of {size} cm in {scenario.system.preset}", f"{_OWN} {_AHEAD}", columns, rows)


def size_tables(scenario, judged):
    """Return a Table for each quantity, with a column for each size of step."""
    sizes = sizes_cm(scenario)
    return tuple(
        Table(
            f"Steps in {scenario.system.preset}: {column.quantity}",
            words,
            tuple(column._replace(quantity=f"{size} cm") for size in sizes),
            {NAMES.get(name, name): tuple(found[f"{key} {size}"] for size in sizes) for name, found in judged.numbers.items()},
        )
        for key, (column, words) in _BY_SIZE.items()
    )


def _threshold(judged, name):
    """Return the threshold [cm] of a method, NaN of one that tells steps by a test."""
    return np.array([judged.thresholds.get(name, np.nan) / CM])
