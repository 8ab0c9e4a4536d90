"""A table over many subsets of satellites: how often each way to use a known length fixes right, fixes wrong, and does not fix.

One set of six satellites may be lucky; all 84 sixes of nine are not.
"""

from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import combinations

import numpy as np

from gnsslab.core.integers import SimulatedRate
from gnsslab.gnss.known_length import cautious
from gnsslab.labs.degraded_pairs import at_rover, keep_satellites, prepare_pair
from gnsslab.labs.length_runs import run_engine, run_form
from gnsslab.systems.constrained_filter import FilterSettings
from gnsslab.systems.length_row import RowState


@dataclass(frozen=True)
class Mode:
    """One way to use the length, or not to."""

    name: str
    memory: str  # "single", "direct" or "filter", of length_runs
    form: str  # of length_runs.FORMS; "engine-alone" is the engine without the length
    corrected: bool = True  # baselines at the rover's instants: the position correction of paper A, equation 29


# The paper's three modes are filters; those above solve each epoch alone.
MODES = (
    Mode("each epoch alone", "single", "nowhere"),
    Mode("each epoch alone, guarded row", "single", "guarded"),
    Mode("each epoch alone, second-order row", "single", "second"),
    Mode("each epoch alone, search (C-LAMBDA)", "single", "search"),
    Mode("each epoch alone, our engine without length", "single", "engine-alone"),
    Mode("each epoch alone, our engine", "single", "engine"),
    Mode("direct", "direct", "nowhere", corrected=False),
    Mode("with the row", "filter", "guarded", corrected=False),
    Mode("with row and position correction", "filter", "guarded"),
    Mode("filter, no length", "filter", "nowhere"),
    Mode("filter, second-order row", "filter", "second"),
    Mode("filter, search (C-LAMBDA)", "filter", "search"),
    Mode("filter, our engine without length", "filter", "engine-alone"),
    Mode("filter, our engine", "filter", "engine"),
)


@dataclass(frozen=True, eq=False)
class Pooled:
    """What one mode made of all epochs of all subsets."""

    mode: Mode
    right: SimulatedRate
    wrong: SimulatedRate
    dropped: float  # share of the epochs at which a row was dropped


def length_table(known, modes=MODES, *, satellites=6, among=9, most=None, length_error=0.0, progress=None):
    """Return a Pooled row for each Mode over the subsets of so many satellites of a KnownPair, among its highest ones.

    `most` subsets at most, spread evenly over all (None: all of them); `length_error` [m] is added to the length that is entered.
    `progress(done, total)` is called after each subset of each mode. Ratio 3, hold after five fixes, as paper A's filter.
    """
    prepared = lru_cache(_prepared)
    settings = FilterSettings(length=known.length + length_error)
    rows = []
    for number, mode in enumerate(modes):
        whole = prepared(known, mode.memory == "single", mode.corrected, mode.form == "engine")
        chosen = subsets_of(whole.order[:among], satellites, most)
        counts = np.zeros(4, int)
        for done, kept in enumerate(chosen, number * len(chosen) + 1):
            counts += _counts(_run(keep_satellites(whole, kept), known.baseline, mode, settings))
            if progress:
                progress(done, len(modes) * len(chosen))
        rows.append(_pooled(mode, *counts.tolist()))
    return rows


def subsets_of(indices, count, most=None):
    """Return the subsets of `count` of the indices, all of them or `most`, spread evenly.

    >>> subsets_of([0, 1, 2, 3], 2, 3)
    [(0, 1), (0, 3), (1, 3)]
    """
    every = list(combinations(indices, count))
    if not every:
        raise ValueError(f"a subset of {count} satellites needs as many, and there are {len(indices)}")
    step = max(1.0, len(every) / most) if most else 1.0
    return [every[int(place)] for place in np.arange(0, len(every), step)]


def columns(rows):
    """Return a table's rows as columns: shares and their 95 % intervals in per cent.

    The interval takes epochs for independent trials, which those of single epochs nearly are and those of a filter are not.
    """
    return {
        "mode": [row.mode.name for row in rows],
        "epochs": [row.right.samples for row in rows],
        "right_percent": [100 * row.right.rate for row in rows],
        "right_95": [tuple(100 * end for end in row.right.interval) for row in rows],
        "wrong_percent": [100 * row.wrong.rate for row in rows],
        "wrong_95": [tuple(100 * end for end in row.wrong.interval) for row in rows],
        "row_dropped_percent": [100 * row.dropped for row in rows],
    }


def _prepared(known, single, corrected, cautiously):
    """Return the PreparedPair of a mode; the engine with a length is cautious about what is news."""
    settings = replace(known.settings, systems="G", single_epoch=single)
    pair = prepare_pair(known, replace(settings, noise=cautious(settings.noise)) if cautiously else settings)
    return at_rover(pair) if corrected else pair


def _run(pair, baseline, mode, settings):
    return run_engine(pair, baseline) if mode.form == "engine-alone" else run_form(pair, baseline, mode.form, mode.memory, settings)


def _counts(run):
    """Return how many epochs there are, how many are right, wrong, and without the row that there should be."""
    return np.array([len(run.off), run.is_right.sum(), run.is_wrong.sum(), (run.row_state == RowState.DROPPED).sum()])


def _pooled(mode, epochs, right, wrong, dropped):
    return Pooled(mode, SimulatedRate(right, epochs), SimulatedRate(wrong, epochs), dropped / epochs)
