"""Lab of lesson 04: between all integers and none. Float, fixed, fixed after a test, partly fixed, and best integer equivariant."""

import math
from dataclasses import dataclass, field
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from gnsslab.core.integers import decorrelate, integer_least_squares, success_rate
from gnsslab.core.integers.acceptance import ratio_test
from gnsslab.core.integers.equivariant import best_integer_equivariant
from gnsslab.core.integers.partial import fix_most_certain, fix_subset, subsets
from gnsslab.core.mixed_model import given_integers, solve_float
from gnsslab.figures.shares import percent
from gnsslab.gnss.short_baseline import short_baseline_model
from gnsslab.gnss.signals import wavelength
from gnsslab.labs.controls import Choice, Slider
from gnsslab.labs.lab import Drawing, Goal, Lab, Preset, Readout, standing
from gnsslab.labs.skies import open_sky
from gnsslab.simulate.receivers import white_factor

MM = 1e-3
EPOCHS = 2000  # a share of them is good to 1.1 %
BEHIND_TREES = 4.0  # times the sigma: a double-differenced carrier is then known to a fifth of a wave
NEGLECTED, MOST_INTEGERS = 0.01, 300  # of the weights of a best equivariant estimate: the rms is the same to three digits
RISKS = {"10 %": 0.1, "3 %": 0.03, "1 %": 0.01, "0.5 %": 0.005, "0.1 %": 0.001, "0.01 %": 0.0001}
STAIRCASE = np.linspace(-1.5, 1.5, 301)  # [cycles], float values of one ambiguity
SIGMAS = np.arange(1, 81) / 100  # [cycles], of one ambiguity

CONTROLS = (
    Slider("satellites", "Satellites", 5, 10, 1, 9, help="Of GPS, the highest ones."),
    Choice("frequencies", "Frequencies", {"one": 1, "two": 2}, 1, help="L1 alone, or L1 and L2."),
    Slider("code_noise", "Code noise", 0.05, 0.6, 0.05, 0.15, "m", help="Of one reading of one receiver, at the zenith."),
    Slider("trees", "Noisy satellites", 0, 3, 1, 0, help="So many of the lowest are four times as noisy, as behind trees."),
    Choice("risk", "Risk of the partial fix", RISKS, 0.005, help="As many are fixed as can be, with no more than this chance that one is wrong."),
    Slider("sigma", "Sigma of one ambiguity", 0.05, 0.8, 0.01, 0.25, "cycles",
           help="Of the stairs, and of the second picture. The baselines do not depend on it."),
    Slider("ratio", "Ratio asked for", 1, 10, 0.1, 3, help="Fixed where it is reached, else float: the usual way.", more=True),
    Choice("subset", "Partly fixed are", {"combinations": "combinations", "single ones": "single"}, "combinations",
           help="The most certain combinations after decorrelation, or ambiguities as they are.", more=True),
    Slider("epochs", "Epochs averaged", 1, 20, 1, 1, help="Of one geometry.", more=True),
    Slider("carrier_noise", "Carrier noise", 1, 10, 0.5, 3, "mm", help="Of one reading of one receiver, at the zenith.", more=True),
    Slider("seed", "Seed", 1, 100, 1, 1, help="Another seed is another draw of the noise.", more=True),
)  # fmt: skip

PRESETS = (
    Preset("soft", "Start", {},
           "98 % of the fixes are right, the others make the rms: the best equivariant has less than always fixing, and a third of the ratio test."),
    Preset("trees", "One noisy satellite", {"satellites": 8, "frequencies": 2, "code_noise": 0.2, "trees": 1},
           "One noisy satellite, and the ratio test rejects nine epochs of ten; fix all combinations but the worst, and you have millimetres."),
    Preset("single", "Single ones", {"satellites": 8, "frequencies": 2, "code_noise": 0.2, "trees": 2, "risk": 0.001, "subset": "single"},
           "Ambiguities as they are: at this risk none can be fixed. Choose combinations under more, and eleven of fourteen can: a centimetre."),
    Preset("five", "Five satellites", {"satellites": 5, "frequencies": 2, "code_noise": 0.2, "risk": 0.005},
           "Too few for all integers at this risk: six combinations of the eight can be fixed, and the float error falls to a third."),
    Preset("left-alone", "Better left alone", {"satellites": 7, "code_noise": 0.3},
           "Always fixing is worse than never fixing; the best equivariant estimate is better than both."),
    Preset("plenty", "Plenty", {"frequencies": 2},
           "Nothing to decide: all ways but float lie on one line, as a single integer vector has all the weight."),
)  # fmt: skip


class SingleAmbiguity(NamedTuple):
    """One ambiguity: its best integer equivariant estimate against its float value, and what rounding and that estimate are worth."""

    float_values: np.ndarray  # (301,) [cycles]
    soft: np.ndarray  # (301,) estimates for the sigma chosen [cycles]
    sigmas: np.ndarray  # (80,) [cycles]
    rms_rounded: np.ndarray  # (80,) errors for each of the sigmas [cycles]
    rms_soft: np.ndarray  # (80,)


@dataclass(frozen=True, eq=False)
class SoftResult:
    """What five ways of treating the same float ambiguities make of the baseline."""

    settings: dict  # of the controls, all of them
    errors: dict = field(default_factory=dict)  # way: (N,) length of the baseline's error [m], in the order of the picture
    is_right: np.ndarray | None = None  # (N,) all integers of the fixed solution are
    is_tested: np.ndarray | None = None  # (N,) and the ratio is reached
    is_partial_right: np.ndarray | None = None  # (N,) all that the partial solution fixes are
    fixed: int = 0  # how many those are
    risks: np.ndarray | None = None  # (n,) chance that any is wrong where 1, 2, ... n are fixed
    single: SingleAmbiguity | None = None
    problem: str = ""
    note: str = ""

    @property
    def rms(self):
        """Root mean square of each way's errors [m]: a dictionary."""
        return {way: float(np.sqrt(np.mean(error**2))) for way, error in self.errors.items()}


def compute(**settings):
    """Return the SoftResult of checked settings."""
    flt = _float_solutions(settings)
    integer = integer_least_squares(flt.a_hat, flt.Q_a)
    is_tested = ratio_test(integer.norms, settings["ratio"])
    partial, risks = _partly_fixed(flt, settings)
    ambiguities = {
        "float": flt.a_hat,
        "tested": np.where(is_tested[:, None], integer.best, flt.a_hat),
        "fixed": integer.best,
        "partial": partial.a,
        "soft": best_integer_equivariant(flt.a_hat, flt.Q_a, neglected=NEGLECTED, most_integers=MOST_INTEGERS).a,
    }
    return SoftResult(
        settings,
        errors={way: np.linalg.norm(given_integers(flt, a)[0], axis=-1) for way, a in ambiguities.items()},  # the true baseline is zero
        is_right=np.all(integer.best == 0, axis=-1),
        is_tested=is_tested,
        is_partial_right=np.all(partial.z == 0, axis=-1),
        fixed=partial.fixed,
        risks=risks,
        single=single_ambiguity(settings["sigma"]),
    )


def _float_solutions(settings):
    """Return the FloatSolution of N epochs of noise; true integers and baseline are zero."""
    m, f = settings["satellites"], settings["frequencies"]
    sky = open_sky("G").first(m)
    growth = white_factor(sky.elevation)
    growth[m - settings["trees"] :] *= BEHIND_TREES
    waves = [wavelength("G", band) for band in ("1", "2")[:f]]
    model = short_baseline_model(sky.u, waves, settings["code_noise"] * growth, settings["carrier_noise"] * MM * growth, settings["epochs"])
    noise = _normal_numbers(settings["seed"])[:, : len(model.Q_y)]
    return solve_float(noise @ np.linalg.cholesky(model.Q_y).T, *model)


@lru_cache(2)
def _normal_numbers(seed):
    """Return standard normal numbers (N, k) for the most measurements there can be: two frequencies, nine double differences, code and carrier."""
    return np.random.default_rng(seed).standard_normal((EPOCHS, 36))


def _partly_fixed(flt, settings):
    """Return the PartialSolution, and the chances (n,) that any is wrong where 1, 2, ... n are fixed."""
    promised = 1 - settings["risk"]
    if settings["subset"] == "single":
        together = [float(success_rate(flt.Q_a[np.ix_(kept, kept)])) for kept in subsets(flt.Q_a)][::-1]
        return fix_subset(flt.a_hat, flt.Q_a, promised), 1 - np.array(together)
    each = [math.erf(1 / math.sqrt(8 * d)) for d in decorrelate(flt.Q_a).d[::-1]]
    return fix_most_certain(flt.a_hat, flt.Q_a, promised), 1 - np.cumprod(each)


def single_ambiguity(sigma):
    """Return what becomes of a single ambiguity of that sigma [cycles]: a SingleAmbiguity.

    >>> single = single_ambiguity(0.25)
    >>> single.soft[200].round(6), single.float_values[200].round(6)      # half-way between two integers
    (np.float64(0.5), np.float64(0.5))
    """
    soft = best_integer_equivariant(STAIRCASE[:, None], [[sigma**2]]).a[:, 0]
    return SingleAmbiguity(STAIRCASE, soft, SIGMAS, *_errors_of_one())


@lru_cache(1)
def _errors_of_one():
    """Return the rms errors [cycles] of one ambiguity at SIGMAS: rounded, and best integer equivariant.

    A rounded one is off by k or more as often as erfc((k - 1/2) / (sqrt 2 sigma)), and the squares are sums of odd numbers.
    """
    rounded = [math.sqrt(sum((2 * k - 1) * math.erfc((k - 0.5) / (math.sqrt(2) * sigma)) for k in range(1, 10))) for sigma in SIGMAS]
    x = np.linspace(-6, 6, 1201)  # float values in sigmas
    weight = np.exp(-(x**2) / 2)
    soft = [best_integer_equivariant(sigma * x[:, None], [[sigma**2]]).a[:, 0] for sigma in SIGMAS]
    return np.array(rounded), np.sqrt(np.array(soft) ** 2 @ (weight / weight.sum()))


def soft_fixing_lab():
    """Return a fresh lab."""
    return Lab(
        name="soft-fixing", title="Not all, not none", controls=CONTROLS, presets=PRESETS, goals=GOALS,
        compute=compute, figure=figure, drawings=drawings, describe=describe, readouts=readouts, table=table,
    )  # fmt: skip


def figure(result):
    """Return the whole picture as one matplotlib Figure."""
    from gnsslab.figures.soft_fixing import plot_soft_fixing

    return plot_soft_fixing(result)


def drawings():
    """Return the two pictures of the lab."""
    from gnsslab.figures.soft_fixing import build_errors, build_single

    return Drawing("errors", build_errors, 440, 500), Drawing("single", build_single, 320, 320)


def describe(result):
    """Return the pictures in words."""
    from gnsslab.figures.soft_fixing import describe_soft_fixing

    return result.problem or describe_soft_fixing(result)


def readouts(result):
    """Return the rms error of the five ways, and what is behind each."""
    right, passed, wrong, partial = (
        f"{percent(float(np.mean(which)))} %"
        for which in (result.is_right, result.is_tested, result.is_tested & ~result.is_right, result.is_partial_right)
    )
    notes = {
        "float": ("Float", "no integer used"),
        "tested": ("Ratio test", f"{passed} pass, {wrong} wrongly"),
        "fixed": ("Always fixed", f"{right} right"),
        "partial": ("Partly fixed", f"{result.fixed} of {len(result.risks)}, {partial} right"),
        "soft": ("Best equivariant", "the least in the long run"),
    }
    return [Readout(label, *_length(result.rms[way]), f"rms; {note}") for way, (label, note) in notes.items()]


def _length(metres):
    """Return a length in three digits, and its unit.

    >>> _length(0.5634), _length(0.00512)
    (('0.56', 'm'), ('5.1', 'mm'))
    """
    return (f"{metres:.2f}", "m") if metres >= 0.1 else (f"{metres / MM:.1f}", "mm")


def table(result):
    """Return the errors of each epoch as columns."""
    flags = {"is_right": result.is_right, "passes_the_test": result.is_tested, "partial_is_right": result.is_partial_right}
    return {"epoch": np.arange(EPOCHS)} | {f"error_{way}_m": error for way, error in result.errors.items()} | flags


def _judge_worse(result):
    rms = result.rms
    shown = f"float {_words(rms['float'])}, always fixed {_words(rms['fixed'])}, best equivariant {_words(rms['soft'])}"
    return rms["fixed"] > rms["float"] > rms["soft"] / 0.9, standing(shown, True)


def _judge_in_the_wood(result):
    used, rms = result.settings, result.rms["partial"]
    by_rule = used["satellites"] <= 8 and used["trees"] == 3 and used["risk"] <= 0.001
    return by_rule and rms < 12 * MM, standing(f"partly fixed to {_words(rms)} with {result.fixed} of {len(result.risks)}", by_rule)


def _words(metres):
    return " ".join(_length(metres))


GOALS = (
    Goal("worse-than-nothing", "Make fixing always worse than not fixing at all, where the best equivariant estimate is still at least 10 % better "
         "than either.", _judge_worse),
    Goal("in-the-wood", "Eight satellites at most, three of them noisy, a risk of 0.1 % or less: get the partial fix below 12 mm.",
         _judge_in_the_wood),
)  # fmt: skip
