"""Lab of lesson 04: one epoch, the distance between the antennas known, and four ways to use it."""

from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from scipy.special import chdtrc

from gnsslab.core.integers import SimulatedRate, fix_with_length, integer_least_squares, success_rate
from gnsslab.core.mixed_model import FloatSolution, given_integers, solve_float, use_length
from gnsslab.gnss.short_baseline import short_baseline_model
from gnsslab.gnss.signals import wavelength
from gnsslab.labs.controls import Choice, Slider
from gnsslab.labs.lab import Drawing, Goal, Lab, Preset, Readout, standing

CM, MM = 1e-2, 1e-3
KEPT = 8
SHOWN = 24  # integer vectors on the map
KEPT_VECTORS = 24  # of each epoch where the length is not in the search; what the others would claim is known in the mean
FEW, MANY = 4, 24  # on the sphere: few mostly share all the likelihood
OPEN = 0.002  # share of the likelihood at which the last of the few is not the last that counts
BELIEVED = 3.0  # ratio from which receivers commonly believe

# The first six are those of example 3 of the LAMBDA 4.0 toolbox (TU Delft, 2024); three more fill the gap in the north.
AZIMUTH = np.array([-3.03455, -1.38122, 1.6432, -2.34691, 1.23127, 2.55581, 0.10, -0.60, 0.55])  # [rad]
ELEVATION = np.array([1.18626, 0.91469, 0.27365, 0.20587, 1.07728, 0.63915, 0.40, 0.85, 0.20])  # [rad]

METHODS = {"without": "no length", "row": "row", "twice": "row and search", "scaled": "search, scaled", "search": "search"}

CONTROLS = (
    Choice("method", "Length goes into", {"nothing": "without", "the float solution, as a row": "row", "row and search: twice": "twice",
           "the search, by scaling": "scaled", "the search, exactly": "search"}, "search", help="What the map shows; all are counted."),
    Slider("length", "Distance of the antennas", 0.3, 5, 0.1, 1, "m", help="The true one."),
    Slider("length_error", "You enter too much by", -10, 10, 0.5, 0, "cm", help="Error of the length that you type in."),
    Slider("satellites", "Satellites", 4, 9, 1, 6, help="Of GPS, one carrier (L1), one epoch."),
    Slider("code_noise", "Code noise", 0.05, 0.5, 0.05, 0.2, "m", help="One reading of one receiver; low satellites are noisier."),
    Slider("epoch", "Epoch on the map", 1, 100, 1, 18, help="Another epoch, another draw of the noise."),
    Slider("carrier_noise", "Carrier noise", 1, 10, 0.5, 2, "mm", help="One reading of one receiver.", more=True),
    Slider("row_sigma", "Sigma of the row", 0.5, 50, 0.5, 0.5, "cm", help="How well the float solution is told to obey its row.", more=True),
    Choice("direction", "Directions", {"any": "any", "as set": "set"}, "any", help="Another one each epoch, or one for all.", more=True),
    Slider("heading", "Heading", 0, 359, 1, 30, "deg", help="From the first antenna to the second, clockwise from north.", more=True),
    Slider("pitch", "Pitch", -80, 80, 5, 0, "deg", help="Up from the horizon.", more=True),
    Slider("epochs", "Epochs counted", 100, 2000, 100, 400, help="More of them, shorter error bars.", more=True),
    Slider("seed", "Seed", 1, 100, 1, 1, help="Another seed is another draw of all the noise.", more=True),
)  # fmt: skip
NOT_COUNTED = ("method", "epoch")  # they choose what is shown of one count

PRESETS = (
    Preset("one-epoch", "One epoch", {},
           "Many integer vectors fit the codes, and few of their baselines are 1 m long: the right ones go from 31.5 % to 96 %."),
    Preset("without-length", "No length", {"method": "without"},
           "The float baseline is off by nearly a metre, and the nearest integers are wrong in two epochs of three."),
    Preset("length-row", "As a row", {"method": "row"},
           "The row pulls the float baseline onto the circle at the wrong place: 11 % are right, fewer than with no length, and it claims 84 %."),
    Preset("length-twice", "Used twice", {"method": "twice"},
           "Row and search both use the length: it claims 98.5 %, and 22 % are right."),
    Preset("short-baseline", "30 cm", {"length": 0.3},
           "The shorter the baseline, the smaller the sphere: the search is right at 98.5 %, and the row is as bad as before."),
    Preset("long-baseline", "5 m, as a row", {"length": 5, "method": "row"},
           "A larger sphere is flatter, so the row does better: 41 % are right. But it claims twice as much."),
    Preset("length-off", "5 cm wrong", {"length_error": 5},
           "A wrong length in the search: not one epoch is right, and it still claims 87 %."),
    Preset("scaled-length", "1 cm wrong, scaled", {"length_error": 1, "method": "scaled", "epochs": 2000},
           "The nearest point of the sphere gives way most where the baseline is least certain, upwards. Scaling cannot: 77 % right, not 82 %."),
    Preset("hard-direction", "A bad direction", {"direction": "set", "heading": 120},
           "Here some wrong vectors have nearly the right length: 89 % are right. Set the heading to 150 deg under more, and all are."),
    Preset("nine-satellites", "Nine satellites", {"satellites": 9},
           "Enough satellites find the integers without the length; the row still spoils it."),
)  # fmt: skip


class Fixes(NamedTuple):
    """What one method made of N epochs; the true integers are zero."""

    integers: np.ndarray  # (N, n), the best
    baseline: np.ndarray  # (N, 3) [m]
    norms: np.ndarray  # (N, k), what the best k vectors cost, ascending
    rest: np.ndarray | float = 0.0  # (N,), likelihood of all other vectors in units of the best one's

    @property
    def is_right(self):
        """Which epochs have the true integers, (N,) bool."""
        return ~self.integers.any(axis=-1)

    @property
    def claim(self):
        """The probability (N,) that the method itself gives to its best integers: their likelihood's share of that of all vectors."""
        return 1.0 / (likelihoods(self.norms).sum(axis=-1) + self.rest)

    @property
    def right(self):
        """How often the integers are true, counted."""
        return SimulatedRate(int(self.is_right.sum()), len(self.is_right))

    @property
    def claimed(self):
        """How often the method itself expects that."""
        return float(np.mean(self.claim))

    @property
    def is_believed(self):
        """Which epochs pass a ratio test at 3, (N,) bool."""
        return self.norms[:, 1] >= BELIEVED * self.norms[:, 0]


class Counted(NamedTuple):
    """N epochs solved by all methods."""

    truth: np.ndarray  # (N, 3) [m] east, north, up
    free: FloatSolution  # without the length
    tied: FloatSolution  # with the row
    fixes: dict  # Fixes of each of METHODS
    promised: float  # success rate of the solution without the length, by its covariance


class Shown(NamedTuple):
    """One epoch on the map: the SHOWN nearest integer vectors, and last the one that the method chooses."""

    truth: np.ndarray  # (3,) [m]
    b_hat: np.ndarray  # (3,) [m], float baseline of the method
    Q_b: np.ndarray  # (3, 3) [m^2]
    baselines: np.ndarray  # (SHOWN + 1, 3) [m], b(a) of each
    sigma_length: np.ndarray  # (SHOWN + 1,) [m], of the length of each
    distances: np.ndarray  # (SHOWN + 1,) squared distances of the integers from the float ones
    answer: np.ndarray  # (3,) [m], baseline that the method gives out
    answer_without: np.ndarray  # (3,) [m], and the one without the length
    is_right: bool  # the method is


@dataclass(frozen=True, eq=False)
class KnownLengthResult:
    """All epochs counted, and one of them to look at."""

    settings: dict  # of the controls, all of them
    entered: float  # [m], the length that the methods were given
    counted: Counted
    shown: Shown
    problem: str = ""
    note: str = ""

    @property
    def fixes(self):
        """The Fixes of the method chosen."""
        return self.counted.fixes[self.settings["method"]]


class KnownLengthEngine:
    """The counts of one lab instance, kept between moves."""

    def __init__(self):
        self._count = lru_cache(KEPT)(_count)
        self._noise = lru_cache(KEPT)(_noise)

    def compute(self, **settings):
        """Return the KnownLengthResult of checked settings."""
        noise = self._noise(settings["seed"], settings["epochs"], settings["satellites"])
        counted = self._count(noise, tuple((name, value) for name, value in settings.items() if name not in NOT_COUNTED))
        return KnownLengthResult(settings, _entered(settings), counted, _shown(counted, settings))


class Noise:
    """Errors of N epochs in units of their sigmas, and directions; one object is one draw, so that counts of it can be kept."""

    def __init__(self, measurements, directions):
        self.measurements, self.directions = measurements, directions  # (N, k), (N, 3) of length 1


def _noise(seed, epochs, satellites):
    """Return the Noise of a seed; more epochs begin with the same ones."""
    first, second = np.random.default_rng(seed).spawn(2)
    directions = second.standard_normal((epochs, 3))
    return Noise(first.standard_normal((epochs, 2 * (satellites - 1))), directions / np.linalg.norm(directions, axis=1, keepdims=True))


def _entered(settings):
    return settings["length"] + settings["length_error"] * CM


def _count(noise, items):
    """Return the Counted epochs of a Noise and of the settings' items."""
    settings = dict(items)
    truth = settings["length"] * (noise.directions if settings["direction"] == "any" else np.tile(_direction(settings), (len(noise.directions), 1)))
    model = _model(settings)
    y = truth @ model.B.T + noise.measurements @ np.linalg.cholesky(model.Q_y).T  # the true integers are zero: others would only shift all
    free, entered = solve_float(y, *model), _entered(settings)
    tied = use_length(free, entered, settings["row_sigma"] * CM)
    exact = _search(free, entered)
    fixes = {
        "without": _nearest(free),
        "row": _nearest(tied),
        "twice": _on_sphere(_search(tied._replace(length_used=False), entered)),  # else it would be refused
        "scaled": _scaled(free, exact, entered),
        "search": _on_sphere(exact),
    }
    return Counted(truth, free, tied, fixes, float(success_rate(free.Q_a)))


def _direction(settings):
    heading, pitch = np.radians([settings["heading"], settings["pitch"]])
    return np.array([np.sin(heading) * np.cos(pitch), np.cos(heading) * np.cos(pitch), np.sin(pitch)])


def _model(settings):
    """Return the MixedModel of one epoch of L1; sigmas fall with elevation as in the toolbox's example: s / (0.2 + sin E)."""
    azimuth, elevation = AZIMUTH[: settings["satellites"]], ELEVATION[: settings["satellites"]]
    u = np.column_stack([np.cos(elevation) * np.sin(azimuth), np.cos(elevation) * np.cos(azimuth), np.sin(elevation)])
    growth = 1 / (0.2 + np.sin(elevation))
    return short_baseline_model(u, [wavelength("G", "1")], settings["code_noise"] * growth, settings["carrier_noise"] * MM * growth)


def likelihoods(norms):
    """Return exp(-norm / 2) of vectors (..., k), in units of the best one's."""
    return np.exp((norms[..., :1] - norms) / 2)


def _nearest(solution):
    """Return the Fixes by integer least squares."""
    found = integer_least_squares(solution.a_hat, solution.Q_a, KEPT_VECTORS)
    return Fixes(found.best, given_integers(solution, found.best)[0], found.norms, _likelihood_beyond(found.norms, solution.Q_a))


def _likelihood_beyond(norms, Q):
    """Return the likelihood (N,) of the vectors farther than the last of norms (N, k), in units of the best one's.

    There is one in each unit of volume, so their sum is near an integral: (2 pi)^(n/2) |Q|^(1/2) P(chi^2_n > last norm).
    """
    n = Q.shape[-1]
    log_whole = n / 2 * np.log(2 * np.pi) + np.linalg.slogdet(Q)[1] / 2
    return np.exp(log_whole + norms[:, 0] / 2) * chdtrc(n, norms[:, -1])


def _search(solution, length):
    """Return the ConstrainedSolution with FEW vectors, and MANY for the epochs whose likelihood these do not exhaust."""
    found = fix_with_length(solution, length, FEW)
    share = likelihoods(found.norms)
    is_open = share[:, -1] > OPEN * share.sum(axis=1)
    more = MANY - FEW
    candidates, baselines = (np.pad(each, ((0, 0), (0, more), (0, 0)), mode="edge") for each in (found.candidates, found.baselines))
    norms = np.pad(found.norms, ((0, 0), (0, more)), constant_values=np.inf)
    if is_open.any():
        again = fix_with_length(_epochs(solution, is_open), length, MANY)
        candidates[is_open], norms[is_open], baselines[is_open] = again.candidates, again.norms, again.baselines
    return found._replace(candidates=candidates, norms=norms, baselines=baselines)


def _on_sphere(found):
    """Return the Fixes of a ConstrainedSolution."""
    return Fixes(found.best, found.baselines[:, 0], found.norms)


def _scaled(solution, exact, length):
    """Return the Fixes of one who scales each b(a) to the length, instead of looking for the nearest point of the sphere.

    Scaling never costs less than the nearest point, so the vectors that cost least exactly are those to try.
    """
    b, Q_b = given_integers(_each(solution), exact.candidates)
    on_sphere = b * (length / np.linalg.norm(b, axis=-1, keepdims=True))
    nearest = exact.norms - _squared(exact.baselines - b, Q_b)
    norms = nearest + _squared(on_sphere - b, Q_b)
    order = np.argsort(norms, axis=-1)
    candidates, on_sphere = (np.take_along_axis(each, order[..., None], axis=1) for each in (exact.candidates, on_sphere))
    return Fixes(candidates[:, 0], on_sphere[:, 0], np.take_along_axis(norms, order, axis=-1))


def _squared(e, Q):
    """Return e' Q^-1 e of vectors e (..., p) with one Q (p, p)."""
    return np.vecdot(e, np.linalg.solve(Q, e[..., None])[..., 0])


def _each(solution):
    """Return a FloatSolution (N, ...) that takes several integer vectors for each epoch (N, k, n)."""
    return solution._replace(a_hat=solution.a_hat[:, None], b_hat=solution.b_hat[:, None])


def _shown(counted, settings):
    """Return the Shown epoch of a method."""
    index, fixes = settings["epoch"] - 1, counted.fixes[settings["method"]]
    tied = settings["method"] in ("row", "twice")
    one = _epochs(counted.tied if tied else counted.free, index)
    vectors = np.vstack([integer_least_squares(one.a_hat, one.Q_a, SHOWN).candidates, fixes.integers[index]])
    baselines, Q_b = given_integers(one, vectors)
    h = baselines / np.linalg.norm(baselines, axis=-1, keepdims=True)
    return Shown(
        truth=counted.truth[index], b_hat=one.b_hat, Q_b=one.Q_b, baselines=baselines, sigma_length=np.sqrt(np.vecdot(h, h @ Q_b)),
        distances=_squared(one.a_hat - vectors, one.Q_a), answer=fixes.baseline[index],
        answer_without=counted.fixes["without"].baseline[index], is_right=bool(fixes.is_right[index]),
    )  # fmt: skip


def _epochs(solution, chosen):
    """Return the FloatSolution of some of the N epochs: an index, or (N,) bool."""
    covariances = (Q[chosen] if Q.ndim == 3 else Q for Q in solution[2:5])
    return FloatSolution(solution.a_hat[chosen], solution.b_hat[chosen], *covariances, solution.length_used)


def known_length_lab():
    """Return a fresh lab with caches of its own."""
    return Lab(
        name="known-length", title="The known length", controls=CONTROLS, presets=PRESETS, goals=GOALS,
        compute=KnownLengthEngine().compute, figure=figure, drawings=drawings, describe=describe, readouts=readouts, table=table,
        steering=("direction",), blocked=blocked,
    )  # fmt: skip


def blocked(settings):
    """Return for each control without effect the reason why."""
    return dict.fromkeys(("heading", "pitch"), "no effect: each epoch has a direction of its own") if settings["direction"] == "any" else {}


def figure(result):
    """Return the whole picture as one matplotlib Figure."""
    from gnsslab.figures.known_length import plot_known_length

    return plot_known_length(result)


def drawings():
    """Return the two pictures of the lab."""
    from gnsslab.figures.known_length import build_map, build_shares

    return Drawing("map", build_map, 440, 480), Drawing("shares", build_shares, 380, 480, presented=True)


def describe(result):
    """Return the pictures in words."""
    from gnsslab.figures.known_length import describe_known_length

    return describe_known_length(result)


def readouts(result):
    """Return the share of right integers, what the method claims, how wrong its believed ones are, and the epoch on the map."""
    fixes, plain = result.fixes, result.counted.fixes["without"]
    right = fixes.right
    return [
        Readout(
            "Right integers",
            f"{100 * right.rate:.1f}",
            "%",
            f"± {100 * right.sigma:.1f} % in {right.samples} epochs; no length: {100 * plain.right.rate:.1f} %",
        ),
        Readout("Claimed", f"{100 * fixes.claimed:.1f}", "%", _claim_words(fixes)),
        _believed(fixes),
        _epoch(result.shown),
    ]


def _claim_words(fixes):
    """Return how the claim compares with the count."""
    too_much = fixes.claimed - fixes.right.rate
    if abs(too_much) <= 3 * fixes.right.sigma:
        return "by the method itself, and the count agrees"
    return f"by the method itself: {100 * abs(too_much):.0f} percentage points too {'much' if too_much > 0 else 'little'}"


def _believed(fixes):
    believed = fixes.is_believed
    wrong = f"{100 * np.mean(~fixes.is_right[believed]):.1f} % of these are wrong" if believed.any() else "none to be wrong"
    return Readout("Ratio 3 or more", f"{100 * np.mean(believed):.1f}", "%", f"of the epochs; {wrong}")


def _epoch(shown):
    off, off_without = (_length_words(np.linalg.norm(answer - shown.truth)) for answer in (shown.answer, shown.answer_without))
    return Readout("This epoch", "right" if shown.is_right else "wrong", "", f"baseline off by {off}; with no length by {off_without}")


def _length_words(metres):
    return f"{metres:.2f} m" if metres >= 0.1 else f"{metres / MM:.0f} mm"


def table(result):
    """Return what each epoch gave, by each method, as columns."""
    east, north, up = result.counted.truth.T
    columns = {"epoch": 1 + np.arange(len(east)), "east_m": east, "north_m": north, "up_m": up}
    for name, fixes in result.counted.fixes.items():
        columns |= {f"{name}_is_right": fixes.is_right, f"{name}_claim": fixes.claim, f"{name}_ratio": fixes.norms[:, 1] / fixes.norms[:, 0]}
    return columns


def _judge_five(result):
    used, right = result.settings, 100 * result.counted.fixes["search"].right.rate
    by_rule = used["satellites"] == 5 and used["code_noise"] >= 0.2 and used["length"] >= 1 and used["direction"] == "any"
    return by_rule and right >= 85, standing(f"{right:.1f} % right by search", by_rule)


def _judge_honest(result):
    used, row = result.settings, result.counted.fixes["row"]
    right, claimed, plain = (100 * share for share in (row.right.rate, row.claimed, result.counted.fixes["without"].right.rate))
    by_rule = used["length"] <= 1 and used["length_error"] == 0 and used["satellites"] == 6 and used["code_noise"] >= 0.2
    reached = claimed - right <= 3 and right - plain >= 8
    return by_rule and reached, standing(f"{right:.1f} % right as a row, {claimed:.1f} % claimed, {plain:.1f} % right with no length", by_rule)


GOALS = (
    Goal("five", "Five satellites, a metre or more, any direction, code noise of 0.2 m or more: get 85 % right by the search.", _judge_five),
    Goal("honest", "Six satellites, 1 m or less, code noise of 0.2 m or more, the right length entered: make the row honest. It claims at most "
         "3 percentage points more than it gets right, and gets 8 points more right than no length. The control is under more.", _judge_honest),
)  # fmt: skip
