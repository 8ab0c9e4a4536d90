"""Lab of lesson 03: conditional standard deviations before and after decorrelation, and what the search pays for them."""

import time
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from scipy.special import erf

from gnsslab.core.integers import adop, decorrelate, ltdl, search_kernel
from gnsslab.core.jit import kernel_input
from gnsslab.core.mixed_model import solve_float
from gnsslab.gnss.short_baseline import short_baseline_model
from gnsslab.gnss.signals import wavelength
from gnsslab.labs.controls import Choice, Slider, Switch
from gnsslab.labs.lab import Drawing, Goal, Lab, Preset, Readout, standing
from gnsslab.labs.skies import open_sky
from gnsslab.simulate.receivers import white_factor

MM = 1e-3
GAP = "\N{NO-BREAK SPACE}"  # between a value and its unit
SEARCHES = 10  # epochs searched at each setting
NODE_LIMIT = 500_000  # of one search: ten that hit it take a tenth of a second compiled, four seconds uncompiled
N_BEST = 2  # candidates, as for a ratio
ELEVEN_UP = "2024-06-24T08:20:00"  # eleven GPS satellites above five degrees: up to thirty ambiguities
BANDS = "125"  # of GPS

CONTROLS = (
    Slider("sats", "Satellites", 5, 11, 1, 8, help="Of GPS, spread from the highest to the lowest above the mask."),
    Choice("bands", "Frequencies", {"L1": 1, "L1+L2": 2, "L1+L2+L5": 3}, 1, help="Each brings an ambiguity for every satellite but one."),
    Switch("decorrelated", "Decorrelation", True, help="Off: the search works on the double differences as they are."),
    Slider("code", "Code noise", 0.1, 1, 0.05, 0.3, "m", help="Of one reading of one receiver, at the zenith. It sets the first three."),
    Slider("carrier", "Carrier noise", 1, 10, 0.5, 3, "mm", help="Of one reading of one receiver, at the zenith. It sets the others."),
    Slider("together", "Epochs together", 1, 60, 1, 1, help="Their mean is solved; the satellites stand still."),
    Slider("lowest", "Elevation mask", 5, 30, 5, 5, "deg", help="Satellites below are left out.", more=True),
    Slider("draw", "Seed", 1, 100, 1, 1, help="Another seed is another draw of the noise: the spectrum stays, the nodes change.", more=True),
)  # fmt: skip

PRESETS = (
    Preset("seven", "Seven ambiguities", {},
           "Orange: three large ones, then a fall by a factor of twenty. Blue: all alike, near the dotted line. "
           "Thirteen thousand nodes against thirty."),
    Preset("fourteen", "Fourteen", {"bands": 2},
           "A second frequency: still only three are large, for there are three coordinates. All the others are small from the start."),
    Preset("thirty", "Thirty", {"sats": 11, "bands": 3},
           "Without decorrelation most of the searches do not end. With it the search goes nearly straight down: two nodes for each ambiguity."),
    Preset("without", "Decorrelation off", {"decorrelated": False},
           "What you have without it: three large steps first, of which the search must try thousands of combinations."),
    Preset("sixty", "Sixty epochs", {"together": 60},
           "All sigmas are eight times smaller, before and after. The fall after the third one is as steep as before."),
    Preset("poor-code", "Code noise 1 m", {"code": 1, "carrier": 1},
           "Poor code and good carrier: the fall becomes a cliff, and without decorrelation most searches are stopped at half a million nodes."),
)  # fmt: skip


class Searched(NamedTuple):
    """Searches of all epochs in one set of ambiguities."""

    sigma: np.ndarray  # (n,) [cycles], conditional, in the order in which the search fixes them
    nodes: np.ndarray  # (SEARCHES,) int, of NODE_LIMIT at most
    seconds: float  # one search, on average, factors included

    @property
    def stopped(self):
        """How many searches the limit ended."""
        return int(np.sum(self.nodes >= NODE_LIMIT))

    @property
    def chance(self):
        """Probability that rounding one after the other, the search's first way down, is right."""
        return float(np.prod(erf(1 / (np.sqrt(8) * self.sigma))))


@dataclass(frozen=True, eq=False)
class SpectrumResult:
    """What the search meets before and after decorrelation."""

    settings: dict  # of the controls, all of them
    before: Searched | None = None
    after: Searched | None = None  # None where decorrelation is off
    adop: float = 0.0  # [cycles]
    satellites: tuple[str, ...] = ()
    node_limit: int = NODE_LIMIT
    problem: str = ""
    note: str = ""

    @property
    def n(self):
        """Number of ambiguities."""
        return len(self.before.sigma)


def compute(**settings):
    """Return the SpectrumResult of checked settings."""
    sky = open_sky("G", settings["lowest"], ELEVEN_UP)
    if len(sky.names) < settings["sats"]:
        note = f"No more than {len(sky.names)} satellites stand above the mask, so {len(sky.names)} are used."
        return _solve(settings, sky, note)
    return _solve(settings, sky.spread(settings["sats"]), "")


def _solve(settings, sky, note):
    a_hat, Q_a = _float_ambiguities(settings, sky)
    before = _search(a_hat, lambda: (np.eye(len(Q_a)), *ltdl(Q_a)))
    after = _search(a_hat, lambda: decorrelate(Q_a)) if settings["decorrelated"] else None
    return SpectrumResult(settings, before, after, adop=float(adop(Q_a)), satellites=sky.names, note=note)


def _float_ambiguities(settings, sky):
    """Return float ambiguities (SEARCHES, n) about true ones of zero, and their covariance (n, n) [cycles^2]."""
    growth = white_factor(sky.elevation)
    wavelengths = [wavelength("G", band) for band in BANDS[: settings["bands"]]]
    A, B, Q_y = short_baseline_model(sky.u, wavelengths, settings["code"] * growth, settings["carrier"] * MM * growth, settings["together"])
    y = _draws(settings["draw"], len(Q_y)) @ np.linalg.cholesky(Q_y).T
    solution = solve_float(y, A, B, Q_y)
    return solution.a_hat, solution.Q_a


@lru_cache(16)
def _draws(seed, k):
    """Return unit noise (SEARCHES, k), the same at every noise level."""
    return np.random.default_rng(seed).standard_normal((SEARCHES, k))


def _search(a_hat, factors):
    """Search all float ambiguities z = Z' a with Z, L, d from `factors()`, and take the time."""
    _compile()
    started = time.perf_counter()
    Z, L, d = factors()
    ready = kernel_input(L), kernel_input(d)
    nodes = [search_kernel(kernel_input(z_hat), *ready, N_BEST, NODE_LIMIT)[2] for z_hat in a_hat @ Z]
    seconds = (time.perf_counter() - started) / len(a_hat)
    return Searched(np.sqrt(d[::-1]), np.array(nodes, dtype=np.int64), seconds)


@lru_cache(1)
def _compile():
    """Run each kernel once, so that the first measured time has no compiler in it."""
    _, L, d = decorrelate(np.eye(2))
    search_kernel(kernel_input(np.zeros(2)), kernel_input(L), kernel_input(d), N_BEST, NODE_LIMIT)


def spectrum_lab():
    """Return a fresh lab."""
    return Lab(
        name="spectrum", title="What the search meets", controls=CONTROLS, presets=PRESETS, goals=GOALS,
        compute=compute, figure=figure, drawings=drawings, describe=describe, readouts=readouts, table=table,
    )  # fmt: skip


def figure(result):
    """Return the whole picture as one matplotlib Figure."""
    from gnsslab.figures.spectrum import plot_spectrum

    return plot_spectrum(result)


def drawings():
    """Return the two pictures of the lab."""
    from gnsslab.figures.spectrum import build_nodes, build_spectrum

    return Drawing("spectrum", build_spectrum, 460, 400), Drawing("nodes", build_nodes, 350, 360, presented=True)


def describe(result):
    """Return the pictures in words."""
    from gnsslab.figures.spectrum import describe_spectrum

    return result.problem or describe_spectrum(result)


def readouts(result):
    """Return nodes, time and the success rate of bootstrapping, as searched and without decorrelation; and ADOP."""
    before, used = result.before, result.after or result.before
    without = result.after is not None
    return [
        Readout("Nodes", _thousands(np.median(used.nodes)), "", _beside(without, _thousands(np.median(before.nodes)), before.stopped)),
        Readout("Time", *_readable(used.seconds), f"a search, here and now{_without(without, GAP.join(_readable(before.seconds)))}"),
        Readout("Bootstrapping", f"{100 * used.chance:.1f}", "%", f"success rate{_without(without, f'{100 * before.chance:.1f} %')}"),
        Readout("ADOP", f"{result.adop:.3f}", "cycles", f"of {result.n} ambiguities, before and after"),
    ]


def _without(is_shown, words):
    return f"; without decorrelation {words}" if is_shown else ""


def _beside(is_shown, median, stopped):
    ended = f", {stopped} of {SEARCHES} stopped at {_thousands(NODE_LIMIT)}" if stopped else ""
    return f"median of {SEARCHES} epochs{_without(is_shown, median)}{ended}"


def _thousands(count):
    r"""Return a count with thin gaps that no line breaks at.

    >>> _thousands(1234567.0)
    '1\u202f234\u202f567'
    """
    return f"{count:,.0f}".replace(",", "\N{NARROW NO-BREAK SPACE}")


def _readable(seconds):
    """Return a short time as value and unit.

    >>> _readable(0.00123), _readable(7.2e-6)
    (('1.2', 'ms'), ('7.2', 'µs'))
    """
    scale, unit = (1e3, "ms") if seconds >= 1e-3 else (1e6, "µs")
    value = seconds * scale
    return f"{value:.1f}" if value < 10 else f"{value:.0f}", unit


def table(result):
    """Return the spectrum as columns; NaN after decorrelation where that is off."""
    after = result.after.sigma if result.after is not None else np.full(result.n, np.nan)
    return {"order_of_fixing": np.arange(1, result.n + 1), "sigma_before_cycles": result.before.sigma, "sigma_after_cycles": after}


def _judge_straight(result):
    used = result.settings
    by_rule = used["decorrelated"] and used["bands"] == 1 and used["code"] >= 0.3 and used["carrier"] >= 3
    most = int(result.after.nodes.max()) if by_rule else int(result.before.nodes.max())
    straight = 2 * result.n + 1
    return by_rule and most <= straight, standing(f"{_thousands(most)} nodes at the worst epoch, straight down would be {straight}", by_rule)


GOALS = (
    Goal("straight", "One frequency, noise as at the start or worse, decorrelation on: let the search go straight down at every epoch, two nodes "
         "for each ambiguity and one to end.", _judge_straight),
)  # fmt: skip
