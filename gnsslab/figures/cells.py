"""The plane of two ambiguities: integers, an estimator's cells, the float point with its ellipse, and the answers."""

import itertools

import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.lines import Line2D
from matplotlib.patches import Ellipse, Polygon
from matplotlib.ticker import MaxNLocator

from gnsslab.figures.integer_words import combination, decimal, indexed, vector, whole
from gnsslab.figures.kept import Scene, new_figure, styled
from gnsslab.figures.search_tree import build_tree, describe_tree

# Colours of Okabe and Ito (2008), dark enough on white; each estimator's mark has the form of its cell.
MARKS = {
    "rounding": {"color": "#B86E00", "marker": "s", "markersize": 17},
    "bootstrapping": {"color": "#A03070", "marker": "D", "markersize": 11.5},
    "least squares": {"color": "#0072B2", "marker": "h", "markersize": 10},
}
HOLLOW = {"fillstyle": "none", "linestyle": "", "markeredgewidth": 2}
RIGHT_COLOR, WRONG_COLOR, DARK, GREY, EDGE = "#0072B2", "#C05000", "#111111", "#777777", "#9aa5ae"
TINTS = ("#eef1f4", "#dde4ea", "#f7f1e3")
FAINT = 0.35  # of what belongs to another plane
HALF_WIDTHS = (2.6, 3.6, 4.6, 6.6, 9.6)  # [cycles]
ROOM_FOR_WORD = 0.6  # [cycles]
CHI_SQUARE_95 = 5.991  # of two degrees of freedom


def plot_cells(result, figure=None):
    """Draw both pictures of a CellsResult side by side; return the Figure."""
    with styled():
        figure = figure if figure is not None else new_figure(810, 480)
        plane, tree = figure.subfigures(1, 2, width_ratios=(410, 400))
        for build, part in ((build_plane, plane), (build_tree, tree)):
            build(part).show(result)
    return figure


def build_plane(figure):
    """Lay out the plane of two ambiguities; show(result) fills in cells, float point, ellipses and answers."""
    plane = _Plane(figure.add_axes((0.125, 0.1, 0.86, 0.735)))
    figure.legend(handles=_legend(), loc="upper left", bbox_to_anchor=(0.07, 1.005), ncols=2, fontsize=9, columnspacing=1.2, labelspacing=0.25)
    return Scene(plane.moving, plane.show)


def describe_cells(result):
    """Return the pictures in words, for those who cannot see them."""
    plane, space = result.plane, "as they stand" if result.space.letter == "a" else "after decorrelation"
    answers = ", ".join(f"{answer.name} says {vector(answer.integers)}" for answer in result.answers)
    third = "" if plane.third is None else f" It is the plane of the first two, with {whole(plane.third)} for the third."
    wide, long = np.sqrt(np.linalg.eigvalsh(plane.Q))
    return (
        f"The plane of the ambiguities {space}, in cycles from the true integers, covered by the cells of {result.settings['estimator']}, each of "
        f"area 1.{third} The float point is at {', '.join(map(decimal, plane.centre))}, its ellipse {long / wide:.1f} times as long as wide. "
        f"Of it {answers}; true is {vector(np.zeros(len(result.x_hat), dtype=int))}. {describe_tree(result)}"
    )


def _legend():
    """Return what the marks mean."""
    blue = MARKS["least squares"]["color"]
    return [
        *(Line2D([], [], **HOLLOW, **mark | {"markersize": 7.5}, label=f"answer of {name}") for name, mark in MARKS.items()),
        Line2D([], [], color=DARK, marker="*", markersize=7, linestyle="", label="true integers"),
        Line2D([], [], color=DARK, marker="+", markersize=9, markeredgewidth=2, linestyle="--", linewidth=1.2, label="float, 95 % ellipse"),
        Line2D([], [], color=blue, linewidth=1.5, label="grown to the nearest"),
    ]


class _Plane:
    """Cells, integers, draws, the float point with its ellipses, and the answers."""

    def __init__(self, axes):
        self.axes = axes
        axes.set(aspect="equal", adjustable="box", axisbelow=False)
        axes.grid(visible=False)
        self._prepare_cells(axes)
        self._prepare_draws(axes)
        self._prepare_float(axes)
        (self.true,) = axes.plot([0], [0], "*", color=DARK, markersize=7)
        self.answers = {name: axes.plot([], [], **HOLLOW, **mark)[0] for name, mark in MARKS.items()}

    def _prepare_cells(self, axes):
        self.cells = axes.add_collection(PolyCollection([], edgecolors=EDGE, linewidths=0.6))
        self.answer_cell, self.true_cell = (axes.add_patch(Polygon(np.zeros((1, 2)), closed=True)) for _ in range(2))
        self.answer_cell.set_alpha(0.4)
        self.true_cell.set(fill=False, edgecolor=DARK, linewidth=1.3)
        (self.integers,) = axes.plot([], [], ".", color=GREY, markersize=3.5)

    def _prepare_draws(self, axes):
        (self.wrong,) = axes.plot([], [], "x", color=WRONG_COLOR, markersize=2.8, markeredgewidth=0.8)
        (self.right,) = axes.plot([], [], "o", color=RIGHT_COLOR, markersize=1.8)
        style = {"transform": axes.transAxes, "fontweight": "bold", "backgroundcolor": "#ffffffcc"}
        self.words = (
            axes.text(0.02, 0.015, "\N{BLACK CIRCLE} right", color=RIGHT_COLOR, **style),
            axes.text(0.22, 0.015, "\N{MULTIPLICATION SIGN} wrong", color=WRONG_COLOR, **style),
        )

    def _prepare_float(self, axes):
        self.before, self.ellipse, self.touching = (axes.add_patch(Ellipse((0, 0), 1, 1, fill=False)) for _ in range(3))
        self.before.set(edgecolor=GREY, linewidth=1.2, linestyle=":")
        self.ellipse.set(edgecolor=DARK, linewidth=1.3, linestyle="--")
        self.touching.set(label="grown", edgecolor=MARKS["least squares"]["color"], linewidth=1.5)
        (self.step,) = axes.plot([], [], "-", color=GREY, linewidth=1.2, marker="+", markersize=9, markevery=[0])
        self.word_before = axes.text(0, 0, "", fontsize=9, color="#555555", va="center", clip_on=True)
        (self.halo,) = axes.plot([], [], "+", color="white", markersize=16, markeredgewidth=4.5)
        (self.cross,) = axes.plot([], [], "+", color=DARK, markersize=14, markeredgewidth=2.2)

    @property
    def moving(self):
        """The artists that change with every result, lowest first."""
        ellipses = (self.before, self.step, self.ellipse, self.touching, self.word_before)
        marks = (self.true, *self.answers.values(), self.halo, self.cross)
        return (self.cells, self.answer_cell, self.integers, self.wrong, self.right, self.true_cell, *ellipses, *marks, *self.words)

    def show(self, result):
        """Fill in everything; return limits and labels, which are the frame."""
        middle, half = _window(result)
        self._show_cells(result, middle, half)
        self._show_draws(result)
        self._show_float(result)
        self._show_answers(result)
        return self._frame(result, middle, half)

    def _show_cells(self, result, middle, half):
        plane, chosen = result.plane, result.settings["estimator"]
        integers = _integers_around(middle, half + np.abs(plane.corners).max(axis=0))
        self.cells.set_verts(integers[:, np.newaxis] + plane.corners)
        self.cells.set_facecolor([TINTS[k] for k in _tints(integers, plane.corners)])
        answer = next(answer for answer in result.answers if answer.name == chosen)
        self.answer_cell.set_xy(answer.integers[:2] + plane.corners)
        self.answer_cell.set_facecolor(MARKS[chosen]["color"])
        self.true_cell.set_xy(plane.corners)
        self.true_cell.set_visible(plane.third in (None, 0))
        self.integers.set_data(*_integers_around(middle, (half, half)).T)

    def _show_draws(self, result):
        plane, is_shown = result.plane, result.settings["draws"]
        for dots, chosen in ((self.right, plane.dots_right), (self.wrong, ~plane.dots_right)):
            dots.set_data(*plane.dots[chosen & is_shown].T)
        for word in self.words:
            word.set_visible(is_shown)

    def _show_float(self, result):
        plane, before = result.plane, result.x_hat[:2]
        for mark in (self.halo, self.cross):
            mark.set_data(*plane.centre[:, np.newaxis])
        _set_ellipse(self.ellipse, plane.centre, CHI_SQUARE_95 * plane.Q)
        _set_ellipse(self.touching, plane.centre, (plane.touching or 0.0) * plane.Q)
        _set_ellipse(self.before, before, CHI_SQUARE_95 * result.space.Q[:2, :2])
        has_moved = not np.array_equal(plane.centre, before)
        self.touching.set_visible(plane.touching is not None)
        self.step.set_data(*np.array([before, plane.centre]).T)
        self.word_before.set_position(before)
        self.word_before.set_text(" before" if np.hypot(*(plane.centre - before)) > ROOM_FOR_WORD else "")
        for mark in (self.before, self.step, self.word_before):
            mark.set_visible(has_moved)

    def _show_answers(self, result):
        third = result.plane.third
        self.true.set_alpha(1.0 if third in (None, 0) else FAINT)
        for answer in result.answers:
            mark = self.answers[answer.name]
            mark.set_data(*answer.integers[:2, np.newaxis])
            mark.set_alpha(1.0 if third is None or answer.integers[2] == third else FAINT)

    def _frame(self, result, middle, half):
        labels, title = [_label(result.space, k) for k in range(2)], _title(result)
        self.axes.set_xlim(middle[0] - half, middle[0] + half)
        self.axes.set_ylim(middle[1] - half, middle[1] + half)
        for axis, label in zip((self.axes.xaxis, self.axes.yaxis), labels, strict=True):
            axis.set_label_text(label, fontsize=10)
            axis.set_major_locator(MaxNLocator(8, integer=True))
        self.axes.set_title(title, fontsize=9.5, loc="left", pad=4)
        return *middle, half, *labels, title


def _window(result):
    """Return the middle (2,) and half the width of the part of the plane that shows true integers, float point and answers."""
    inside = np.array([result.plane.centre, result.x_hat[:2], *(answer.integers[:2] for answer in result.answers)])
    reach = np.abs(inside).max() + 0.5
    if reach <= HALF_WIDTHS[-1]:
        return np.zeros(2), next(half for half in HALF_WIDTHS if half >= reach)
    return np.rint(result.plane.centre), HALF_WIDTHS[1]


def _integers_around(middle, reach):
    """Return all integer points (k, 2) within reach (2,) of the middle."""
    sides = [np.arange(np.ceil(m - r), np.floor(m + r) + 1) for m, r in zip(middle, reach, strict=True)]
    return np.array(list(itertools.product(*sides)))


def _tints(integers, corners):
    """Return the number of a tint (k,) for each cell, such that neighbours differ."""
    towards = np.rint(corners + np.roll(corners, -1, axis=0))  # the middle of a neighbour is twice as far as that of the edge between
    best = max(itertools.product(range(3), repeat=2), key=lambda factors: np.sum((towards @ factors) % 3 != 0))
    return ((integers @ best) % 3).astype(int)


def _set_ellipse(ellipse, centre, Q):
    """Give an ellipse patch the form x' Q^-1 x = 1 about a centre, Q (2, 2)."""
    variances, directions = np.linalg.eigh(Q)
    width, height = 2 * np.sqrt(np.maximum(variances, 0))
    ellipse.set(center=tuple(centre), width=width, height=height, angle=np.degrees(np.arctan2(directions[1, 0], directions[0, 0])))


def _label(space, k):
    """Return what stands along axis k: the ambiguity, or the combination of ambiguities that it is."""
    name = indexed(space.letter, k)
    return f"{name} [cycles]" if space.letter == "a" else f"{name} = {combination(space.Z[:, k], 'a')} [cycles]"


def _title(result):
    """Return what is said above the plane: whose cells these are and, of three ambiguities, what the third was taken for."""
    third, cells = result.plane.third, f"cells of {result.settings['estimator']}"
    if third is None:
        return cells
    is_heard = "given" if result.settings["estimator"] != "rounding" else "which pays no heed to"
    return f"{cells}, {is_heard} {indexed(result.space.letter, 2)} = {whole(third)}"
