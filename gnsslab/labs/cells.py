"""Lab of lesson 03: two or three ambiguities, the cells of the plane that each estimator takes to the same integers, and the search as a tree."""

from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from gnsslab.core.integers.decorrelation import decorrelate, ltdl
from gnsslab.core.integers.pull_in import bootstrapping_region, chance_inside, corners_of, least_squares_region, rounding_region
from gnsslab.core.integers.rounding import integer_bootstrapping, integer_rounding
from gnsslab.core.integers.search import integer_least_squares
from gnsslab.core.integers.tree import search_tree
from gnsslab.core.mixed_model import solve_float
from gnsslab.figures.integer_words import vector
from gnsslab.gnss.short_baseline import short_baseline_model
from gnsslab.gnss.signals import wavelength
from gnsslab.labs.controls import Choice, Slider, Switch
from gnsslab.labs.lab import Drawing, Goal, Lab, Preset, Readout, standing
from gnsslab.labs.skies import open_sky

MM = 1e-3
DRAWS = 1000  # a counted share is good to 1.6 %
MOST_NODES = 80  # that the picture has room for
KEPT = 8
UNLIKELY = {2: 13.82, 3: 16.27}  # squared norm that one float vector of a thousand exceeds (chi-square of 2 and 3 degrees of freedom)
NORTH = np.array([[0.0], [1.0], [0.0]])
NEEDLE = np.array([[53.4, 38.4], [38.4, 28.0]])  # test example of K. Borre (2002), programs to Strang and Borre: Linear Algebra, Geodesy, and GPS
LGR_12 = np.array([[6.290, 5.978, 0.544], [5.978, 6.292, 2.340], [0.544, 2.340, 6.288]])  # de Jonge and Tiberius (1996), LGR-Series 12
TEXTBOOK = {2: NEEDLE, 3: LGR_12}

ESTIMATORS = ("rounding", "bootstrapping", "least squares")

CONTROLS = (
    Choice("ambiguities", "Ambiguities", {"two": 2, "three": 3}, 2, help="Three: the picture is the plane that is left once the third is chosen."),
    Choice("estimator", "Cells of", {name: name for name in ESTIMATORS}, "least squares",
           help="A cell holds all float points that this estimator takes to the same integers."),
    Switch("decorrelated", "Decorrelated", False, help="The same experiment in the combinations z = Z' a."),
    Slider("float_1", "Float value 1", -4, 4, 0.02, 1.5, "cycles", help="Of the first ambiguity, counted from the true integer."),
    Slider("float_2", "Float value 2", -4, 4, 0.02, 1.1, "cycles", help="Of the second, counted from the true integer."),
    Slider("nodes_shown", "Nodes shown", 1, MOST_NODES, 1, MOST_NODES, help="Steps of the search, from the first on."),
    Slider("float_3", "Float value 3", -4, 4, 0.02, 0.7, "cycles", help="Of the third, counted from the true integer.", more=True),
    Choice("covariance", "Covariance of",
           {"a textbook": "textbook", "three or four satellites": "satellites", "two or three frequencies": "frequencies",
            "no correlation": "independent"}, "textbook",
           help="Satellites, frequencies: the baseline is known but for one coordinate, as on a track to the north.", more=True),
    Slider("epochs", "Epochs averaged", 1, 100, 1, 30, help="Variances shrink as one over it. The textbook's are those of one epoch.", more=True),
    Slider("code_noise", "Code noise", 0.05, 1, 0.05, 0.15, "m", help="Of one reading of one receiver.", more=True),
    Slider("carrier_noise", "Carrier noise", 1, 15, 0.5, 5, "mm", help="Of one reading of one receiver.", more=True),
    Switch("draws", "Draws shown", False, help="Where the float point might have been: a thousand draws about the true integers.", more=True),
    Slider("seed", "Seed", 1, 100, 1, 2, help="Another seed is another thousand draws.", more=True),
)  # fmt: skip
NOISE = ("code_noise", "carrier_noise")

PRESETS = (
    Preset("three-answers", "Start", {},
           "One float point, three answers: the square and the diamond are wrong. Least squares, whose cells lie along the needle, is right."),
    Preset("all-agree", "All agree", {"float_1": 0.38, "float_2": 0.22},
           "Near the true integers all three answers are the same. Choose the cells of each: the cross is in the same one."),
    Preset("bootstrapping-helps", "Bootstrapping helps", {"estimator": "bootstrapping", "float_1": 0.54, "float_2": 0.4},
           "Rounding makes 1 of 0.54. Bootstrapping rounds the second one to 0 first, which brings the first one back to 0."),
    Preset("far-needle", "Far out", {"covariance": "satellites", "epochs": 1, "float_1": 2.58, "float_2": 1.46},
           "Three satellites, one epoch. The cross is three cycles away from the true integers, and still in their cell: the needle is that long."),
    Preset("decorrelated-cells", "Decorrelated", {"decorrelated": True},
           "The same experiment in other integers: the needle is nearly a circle, the cells are about as long as wide, and all three are right."),
    Preset("on-the-edge", "On the edge", {"decorrelated": True, "float_1": 1.64, "float_2": 1.12},
           "The cross lies on the edge of two cells: the integers of both are equally far away, the ratio is 1, and nobody should believe either."),
    Preset("thousand-draws", "A thousand draws", {"draws": True},
           "Blue dots lie in the cell of the true integers, and are right. Change the cells: the dots stay, but fewer are blue."),
    Preset("tree-step-by-step", "Step by step", {"nodes_shown": 3},
           "Move Nodes shown to the right: down to a first candidate, then back up. The bound shrinks, until nothing is left to try."),
    Preset("three-in-the-tree", "Three ambiguities",
           {"ambiguities": 3, "covariance": "satellites", "epochs": 1, "float_1": -0.6, "float_2": -2.6, "float_3": -0.92},
           "Four satellites, one epoch, a needle. The search tries eight integers for the third, and only one of them leads to the answer."),
    Preset("three-decorrelated", "Three, decorrelated",
           {"ambiguities": 3, "covariance": "satellites", "epochs": 1, "float_1": -0.6, "float_2": -2.6, "float_3": -0.92, "decorrelated": True},
           "The same four satellites after decorrelation: the search walks straight down, and the tree is a stem with a few twigs."),
    Preset("wide-lane", "Wide lane",
           {"covariance": "frequencies", "epochs": 1, "code_noise": 0.1, "decorrelated": True, "float_1": 0.66, "float_2": 0.5},
           "Two frequencies of one pair of satellites: decorrelation finds the wide lane, the difference of the two, by itself."),
)  # fmt: skip


class Situation(NamedTuple):
    """The settings on which the covariance depends."""

    ambiguities: int
    covariance: str
    epochs: float
    code_noise: float  # [m]
    carrier_noise: float  # [mm]


class Space(NamedTuple):
    """The ambiguities as they stand, or decorrelated: Q = L' diag(d) L of z = Z' a."""

    letter: str  # "a" or "z"
    Z: np.ndarray  # (n, n) int64, the identity where nothing was decorrelated
    back: np.ndarray  # (n, n) int64, a = back z
    Q: np.ndarray  # (n, n) [cycles^2]
    L: np.ndarray
    d: np.ndarray
    promised: dict[str, float]  # success rate of each estimator


class Answer(NamedTuple):
    """What one estimator says, and how often it is right."""

    name: str
    integers: np.ndarray  # (n,) in the space shown, counted from the true ones
    is_right: bool
    promised: float
    counted: float  # share of the draws


class Plane(NamedTuple):
    """What is left for the first two ambiguities: of three, the third was chosen."""

    third: int | None
    centre: np.ndarray  # (2,) float values, of three given the third [cycles]
    Q: np.ndarray  # (2, 2) their covariance [cycles^2]
    corners: np.ndarray  # (v, 2) of the cell about zero
    touching: float | None  # squared norm, in the plane, of the answer of least squares; None where that lies in another plane
    dots: np.ndarray  # (k, 2) of the draws with the same third
    dots_right: np.ndarray  # (k,)


@dataclass(frozen=True, eq=False)
class CellsResult:
    """One float point: what each estimator makes of it, the plane with its cells, and the search."""

    settings: dict  # of the controls, all of them
    space: Space
    x_hat: np.ndarray  # (n,) float point in the space shown [cycles]
    answers: tuple[Answer, ...]  # in the order of ESTIMATORS
    norms: np.ndarray  # (2,) squared norms of the best two
    candidates: np.ndarray  # (2, n) int64
    plane: Plane
    tree: object  # SearchTree
    nodes_otherwise: int  # nodes of the same search with decorrelation the other way
    problem: str = ""
    note: str = ""

    @property
    def ratio(self):
        """Second best over best squared norm."""
        return self.norms[1] / self.norms[0] if self.norms[0] > 0 else np.inf

    @property
    def nodes_shown(self):
        """Nodes that the picture shows."""
        return min(int(self.settings["nodes_shown"]), len(self.tree.nodes))


class CellsEngine:
    """Covariances and draws of one lab instance, kept between moves, and the way from settings to a result."""

    def __init__(self):
        self._space = lru_cache(KEPT)(_space)
        self._counts = lru_cache(KEPT)(lambda situation, decorrelated, seed: _counts(self._space(situation, decorrelated), seed))

    def compute(self, **settings):
        """Return the CellsResult of checked settings."""
        situation = Situation(*(settings[name] for name in Situation._fields))
        space, other = (self._space(situation, flag) for flag in (settings["decorrelated"], not settings["decorrelated"]))
        a_hat = np.array([settings[f"float_{k + 1}"] for k in range(settings["ambiguities"])])
        x_hat = a_hat @ space.Z
        best = integer_least_squares(x_hat, space.Q)
        drawn = self._counts(situation, settings["decorrelated"], settings["seed"])
        integers = _estimates(x_hat, space)
        answers = tuple(
            Answer(name, integers[name], not integers[name].any(), space.promised[name], np.mean(~drawn.integers[name].any(axis=-1)))
            for name in ESTIMATORS
        )
        return CellsResult(
            settings, space, x_hat, answers, best.norms, best.candidates,
            plane=_plane(settings["estimator"], x_hat, integers, space, drawn),
            tree=search_tree(x_hat, space.L, space.d),
            nodes_otherwise=len(search_tree(a_hat @ other.Z, other.L, other.d).nodes),
            note=_note_of(x_hat, space.Q),
        )  # fmt: skip


def _space(situation, decorrelated):
    """Return the Space of a situation."""
    Q = _covariance(situation)
    if not decorrelated:
        Z = back = np.eye(len(Q), dtype=np.int64)
        return Space("a", Z, back, Q, *ltdl(Q), promised=_promised(Q))
    found = decorrelate(Q)
    Q_z = found.Z.T @ Q @ found.Z
    return Space("z", found.Z, found.inverse.T, Q_z, found.L, found.d, promised=_promised(Q_z))


def _covariance(situation):
    """Return the covariance (n, n) [cycles^2] of the ambiguities."""
    n = situation.ambiguities
    if situation.covariance == "textbook":
        return TEXTBOOK[n] / situation.epochs
    if situation.covariance == "independent":
        return np.eye(n) * np.linalg.det(TEXTBOOK[n]) ** (1 / n) / situation.epochs  # an ellipse of the same volume
    return _track_covariance(*((n + 1, "1") if situation.covariance == "satellites" else (2, "125"[:n])), situation)


def _track_covariance(satellites, bands, situation):
    """Return the covariance of the ambiguities of GPS satellites where only the coordinate to the north is unknown."""
    sky, noise = open_sky("G").spread(satellites), (situation.code_noise, situation.carrier_noise * MM)
    wavelengths = [wavelength("G", band) for band in bands]
    A, B, Q_y = short_baseline_model(sky.u, wavelengths, *([sigma] * satellites for sigma in noise), epochs=situation.epochs)
    return solve_float(np.zeros(len(A)), A, B @ NORTH, Q_y).Q_a


def _promised(Q):
    """Return each estimator's success rate."""
    regions = (rounding_region(len(Q)), bootstrapping_region(ltdl(Q).L), least_squares_region(Q))
    return {name: float(chance_inside(region, Q)) for name, region in zip(ESTIMATORS, regions, strict=True)}


class Drawn(NamedTuple):
    """Float points drawn about the true integers, and what each estimator makes of them."""

    x_hat: np.ndarray  # (DRAWS, n)
    integers: dict[str, np.ndarray]  # (DRAWS, n) of each estimator


def _counts(space, seed):
    """Return the draws of a seed: the same float ambiguities a, whatever space they are shown in."""
    Q_a = space.back @ space.Q @ space.back.T
    white = np.random.default_rng(seed).standard_normal((DRAWS, len(Q_a)))
    x_hat = white @ np.linalg.cholesky(Q_a).T @ space.Z
    return Drawn(x_hat, _estimates(x_hat, space))


def _estimates(x_hat, space):
    """Return the integers (..., n) of each estimator."""
    found = (integer_rounding(x_hat), integer_bootstrapping(x_hat, space.Q), integer_least_squares(x_hat, space.Q, n_best=1).best)
    return dict(zip(ESTIMATORS, found, strict=True))


def _plane(estimator, x_hat, integers, space, drawn):
    """Return the Plane of the first two ambiguities, given the third as the estimator has it."""
    third = int(integers[estimator][2]) if len(x_hat) == 3 else None
    has_third = np.full(DRAWS, True) if third is None else drawn.integers[estimator][:, 2] == third
    learns = third is not None and estimator != "rounding"  # what the third one tells about the other two
    centre, dots = (_given_third(x, third, space) if learns else x[..., :2] for x in (x_hat, drawn.x_hat[has_third]))
    L, d = space.L[:2, :2], space.d[:2]
    Q = L.T @ np.diag(d) @ L if learns else space.Q[:2, :2]
    best = integers["least squares"]
    region = {"rounding": rounding_region(2), "bootstrapping": bootstrapping_region(L), "least squares": least_squares_region(Q)}[estimator]
    in_plane = third is None or (learns and best[2] == third)
    return Plane(
        third, centre, Q, corners_of(region),
        touching=_squared_norm(centre - best[:2], Q) if in_plane else None,
        dots=dots,
        dots_right=~drawn.integers[estimator][has_third].any(axis=-1),
    )  # fmt: skip


def _given_third(x_hat, third, space):
    """Return the first two float values (..., 2) given the third integer."""
    return x_hat[..., :2] + (third - x_hat[..., 2:]) * space.L[2, :2]


def _squared_norm(x, Q):
    return float(x @ np.linalg.solve(Q, x))


def _note_of(x_hat, Q):
    """Return a sentence where the float point is farther from the true integers than noise would bring it."""
    if _squared_norm(x_hat, Q) < UNLIKELY[len(x_hat)]:
        return ""
    return "Noise hardly ever brings the float point so far from the true integers: fewer than one in a thousand lie out here."


def cells_lab():
    """Return a fresh lab with caches of its own."""
    return Lab(
        name="cells", title="Cells of the plane, and the search", controls=CONTROLS, presets=PRESETS, goals=GOALS, compute=CellsEngine().compute,
        figure=figure, drawings=drawings, describe=describe, readouts=readouts, table=table, steering=("ambiguities", "covariance"), blocked=blocked,
    )  # fmt: skip


def blocked(settings):
    """Return for each control without effect the reason why."""
    reasons = {}
    if settings["ambiguities"] == 2:
        reasons["float_3"] = "no effect: there are two ambiguities"
    if settings["covariance"] not in ("satellites", "frequencies"):
        reasons |= dict.fromkeys(NOISE, "no effect: this covariance is given, and not computed from noise")
    return reasons


def figure(result):
    """Return the whole picture as one matplotlib Figure."""
    from gnsslab.figures.cells import plot_cells

    return plot_cells(result)


def drawings():
    """Return the two pictures of the lab."""
    from gnsslab.figures.cells import build_plane
    from gnsslab.figures.search_tree import build_tree

    return Drawing("plane", build_plane, 410, 480), Drawing("tree", build_tree, 400, 480, presented=True)


def describe(result):
    """Return the pictures in words."""
    from gnsslab.figures.cells import describe_cells

    return result.problem or describe_cells(result)


def readouts(result):
    """Return the answer of each estimator and how often it is right, the ratio, and the nodes of the search."""
    best, second = result.norms
    shown = f"{result.nodes_shown} shown; " if result.nodes_shown < len(result.tree.nodes) else ""
    otherwise = "without decorrelation" if result.settings["decorrelated"] else "with decorrelation"
    return [
        *(Readout(answer.name.capitalize(), vector(answer.integers), "", _word_on(answer, result.space)) for answer in result.answers),
        Readout(
            "Ratio", f"{result.ratio:.2f}".replace("inf", "\N{INFINITY}"), "", f"second best over best squared norm: {second:.2f} over {best:.2f}"
        ),
        Readout("Nodes", f"{len(result.tree.nodes)}", "", f"tried in the search; {shown}{result.nodes_otherwise} {otherwise}"),
    ]


def _word_on(answer, space):
    sigma = np.sqrt(answer.promised * (1 - answer.promised) / DRAWS)
    as_a = f", a = {vector(space.back @ answer.integers)}" if space.letter == "z" and not answer.is_right else ""
    counted = f"{100 * answer.counted:.1f} \N{PLUS-MINUS SIGN} {100 * sigma:.1f} %"
    rate = f"success rate {_unbroken(f'{100 * answer.promised:.1f} %')}, counted {_unbroken(counted)}"
    return f"{_word(answer)} here{as_a}; {rate}"


def _unbroken(words):
    return words.replace(" ", "\N{NO-BREAK SPACE}")


def table(result):
    """Return the nodes of the search as columns, in the order in which they were tried."""
    nodes = result.tree.nodes
    return {
        "node": np.arange(1, len(nodes) + 1),
        "below_node": np.array([node.parent + 1 for node in nodes]),
        "ambiguity": np.array([node.level + 1 for node in nodes]),
        "integer": np.array([node.integer for node in nodes]),
        "float_value_cyc": np.array([node.value for node in nodes]),
        "squared_norm": np.array([node.norm for node in nodes]),
        "bound": np.array([node.bound for node in nodes]),
        "outcome": np.array([node.outcome.name.lower() for node in nodes]),
    }


def _judge_luck(result):
    used = result.settings
    by_rule = used["ambiguities"] == 2 and used["covariance"] == "textbook" and not used["decorrelated"]
    rounded, _, best = result.answers
    numbers = f"rounding is {_word(rounded)}, least squares is {_word(best)}"
    return by_rule and rounded.is_right and not best.is_right, standing(numbers, by_rule)


def _judge_bush(result):
    used = result.settings
    by_rule = used["ambiguities"] == 3 and not used["decorrelated"] and not result.note
    nodes, otherwise = len(result.tree.nodes), result.nodes_otherwise
    return by_rule and nodes >= 60 and otherwise <= 8, standing(f"{nodes} nodes, {otherwise} with decorrelation", by_rule)


def _word(answer):
    return "right" if answer.is_right else "wrong"


GOALS = (
    Goal("luck", "Two ambiguities, the textbook's covariance, not decorrelated: find a float point at which rounding is right and least squares is "
         "wrong. Does it lie along the needle, or across?", _judge_luck),
    Goal("bush", "Three ambiguities, not decorrelated, a float point that noise may well bring about: let the search try 60 nodes or more, of which "
         "decorrelation leaves 8 at most.", _judge_bush),
)  # fmt: skip
