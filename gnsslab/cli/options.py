"""What several commands take: the options, declared once, and one plain sentence for each value that makes no sense."""

import math
import re
from typing import Annotated, NamedTuple

import typer

Master = Annotated[str, typer.Argument(metavar="MASTER", hidden=True)]
Base = Annotated[str, typer.Argument(metavar="BASE", hidden=True)]
Rover = Annotated[str, typer.Argument(metavar="ROVER", hidden=True)]
Navigation = Annotated[list[str], typer.Argument(metavar="NAV", hidden=True)]
MaskDeg = Annotated[float, typer.Option("--mask-deg", metavar="DEG", show_default=False, help="Elevation mask [15].")]
Systems = Annotated[str, typer.Option("--systems", metavar="GECJ", show_default=False, help="GPS, Galileo, BeiDou, QZSS [GECJ].")]
Frequencies = Annotated[int | None, typer.Option("--frequencies", metavar="N", show_default=False, help="First N bands of each system [2].")]
Signals = Annotated[str | None, typer.Option("--signals", metavar="C2I,C6I", show_default=False, help="These signals instead of N bands.")]
SingleEpoch = Annotated[bool, typer.Option("--single-epoch", help="Each epoch by itself, no filter.")]
Start = Annotated[str | None, typer.Option("--from", metavar="TIME", show_default=False, help="First epoch, 2024-06-24T08:20:00.")]
End = Annotated[str | None, typer.Option("--to", metavar="TIME", show_default=False, help="Last epoch (GPS time).")]
Every = Annotated[float | None, typer.Option("--every", metavar="S", show_default=False, help="One epoch every S seconds.")]
Plot = Annotated[str | None, typer.Option("--plot", metavar="OUT.png", show_default=False, help="A picture of it (png, svg, pdf).")]

_ISO = re.compile(r"\d{4}-\d\d-\d\d([T ]\d\d:\d\d(:\d\d(\.\d{1,9})?)?)?")
_SIGNAL = re.compile(r"[CL]\d[A-Z]")


class Span(NamedTuple):
    """Which epochs: from start to end, both included, one every so many seconds; None leaves it open."""

    start: object = None  # datetime64[ns], GPS time
    end: object = None
    every: float | None = None  # [s]


def solver_options(systems, frequencies, signals, mask_deg, single_epoch):
    """Return the options that the solvers take, checked, as a dict."""
    return {
        "systems": checked_systems(systems),
        **_bands(frequencies, signals),
        "mask_deg": within("--mask-deg", mask_deg, 0.0, 90.0, "degrees"),
        "single_epoch": single_epoch,
    }


def _bands(frequencies, signals):
    if signals is None:
        return {"frequencies": 2 if frequencies is None else int(within("--frequencies", frequencies, 1, 3, "bands"))}
    if frequencies is not None:
        raise ValueError("--frequencies and --signals exclude each other: give one of them")
    return {"signals": checked_signals(signals)}


def checked_systems(text):
    """Return the letters of the systems to use, each once; raise ValueError for one that is not used here."""
    from gnsslab.gnss.signals import SYSTEM_NAMES, USED_SYSTEMS

    letters = "".join(dict.fromkeys(text.upper()))
    for letter in letters:
        if letter not in SYSTEM_NAMES:
            raise ValueError(f"--systems {text}: {letter!r} is no system; expected letters of {USED_SYSTEMS} (GPS, Galileo, BeiDou, QZSS)")
        if letter not in USED_SYSTEMS:
            raise ValueError(f"--systems {text}: {SYSTEM_NAMES[letter]} is read, not used; leave {letter} out")
    if not letters:
        raise ValueError(f"--systems is empty: expected letters of {USED_SYSTEMS} (GPS, Galileo, BeiDou, QZSS)")
    return letters


def checked_signals(text):
    """Return the signals of a list like "C2I,C6I" as a tuple.

    >>> checked_signals("C2I, C6I")
    ('C2I', 'C6I')
    """
    signals = tuple(part.strip() for part in text.upper().split(","))
    for signal in signals:
        if not _SIGNAL.fullmatch(signal):
            raise ValueError(f"--signals {text}: {signal!r} is no signal; expected RINEX 3 names like C1C,C2W or C2I,C6I")
    return signals


def checked_span(start, end, every):
    """Return the `Span` of --from, --to and --every."""
    span = Span(checked_time("--from", start), checked_time("--to", end), None if every is None else positive("--every", every, "seconds"))
    if span.start is not None and span.end is not None and span.start > span.end:
        raise ValueError(f"--from {start} lies after --to {end}: exchange them")
    return span


def checked_time(option, text):
    """Return a GPS time label of ISO text, None for None; raise ValueError for anything else."""
    if text is None:
        return None
    import numpy as np

    try:
        if _ISO.fullmatch(text):
            return np.datetime64(text.replace(" ", "T"), "ns")
    except ValueError:  # a month 13
        pass
    raise ValueError(f"{option} {text}: expected a GPS time like 2024-06-24T08:20:00")


def positive(option, value, unit):
    """Return the value; raise ValueError where it is not above zero and finite."""
    if not 0 < value < math.inf:
        raise ValueError(f"{option} {value:g}: expected {unit} above zero")
    return value


def within(option, value, low, high, unit):
    """Return the value; raise ValueError where it lies outside low to high."""
    if not low <= value <= high:
        raise ValueError(f"{option} {value:g}: expected {unit} from {low:g} to {high:g}")
    return value


def finite(option, value, unit):
    """Return the value; raise ValueError where it is not a finite number."""
    if not math.isfinite(value):
        raise ValueError(f"{option} {value:g}: expected {unit}, a finite number")
    return value
