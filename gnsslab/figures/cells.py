"""Pictures of integers: the plane of two ambiguities with an estimator's cells, and the search as a tree."""

import itertools

import numpy as np
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.lines import Line2D
from matplotlib.patches import Ellipse, Polygon
from matplotlib.ticker import MaxNLocator

from gnsslab.core.integers.tree import Outcome
from gnsslab.figures.kept import Scene, new_figure, styled
from gnsslab.figures.numbers import NumberPaths

# Colours of Okabe and Ito (2008), dark enough on white; each estimator's mark has the form of its cell.
MARKS = {
    "rounding": {"color": "#B86E00", "marker": "s", "markersize": 17},
    "bootstrapping": {"color": "#A03070", "marker": "D", "markersize": 11.5},
    "least squares": {"color": "#0072B2", "marker": "h", "markersize": 10},
}
RIGHT_COLOR, WRONG_COLOR, DARK, GREY = "#0072B2", "#C05000", "#111111", "#777777"
TINTS = ("#eef1f4", "#dde4ea", "#f7f1e3")
EDGE = "#9aa5ae"
HALF_WIDTHS = (3.6, 4.6, 6.6, 9.6)  # [cycles]
CHI_SQUARE_95 = 5.991  # of two degrees of freedom
SUBSCRIPTS = "\N{SUBSCRIPT ONE}\N{SUBSCRIPT TWO}\N{SUBSCRIPT THREE}"
MINUS = "\N{MINUS SIGN}"

TREE_WIDTH, TREE_HEIGHT = 400, 480  # [CSS px], the units of the tree's picture
TREE_LEFT, TREE_RIGHT, ROOT_Y, BOTTOM_Y = 38, 392, 408, 92  # [CSS px]
MOST_NODES = 80


def plot_cells(result, figure=None):
    """Draw both pictures of a CellsResult side by side; return the Figure."""
    with styled():
        figure = figure if figure is not None else new_figure(410 + TREE_WIDTH, TREE_HEIGHT)
        plane, tree = figure.subfigures(1, 2, width_ratios=(410, TREE_WIDTH))
        for build, part in ((build_plane, plane), (build_tree, tree)):
            build(part).show(result)
    return figure


def build_plane(figure):
    """Lay out the plane of two ambiguities; show(result) fills in cells, float point, ellipses and answers."""
    plane = _Plane(figure.add_axes((0.125, 0.1, 0.86, 0.735)))
    figure.legend(handles=plane.legend, loc="upper left", bbox_to_anchor=(0.07, 1.005), ncols=2, fontsize=9, columnspacing=1.2, labelspacing=0.25)
    return Scene(plane.moving, plane.show)


def build_tree(figure):
    """Lay out the search tree; show(result) draws the nodes up to the one asked for."""
    tree = _Tree(figure.add_axes((0, 0, 1, 1)))
    return Scene(tree.moving, tree.show)


class _Plane:
    """Cells, integers, the float point with its ellipses, and the answers."""

    def __init__(self, axes):
        self.axes = axes
        axes.set(aspect="equal", adjustable="box", axisbelow=False)
        axes.grid(visible=False)
        self.cells = axes.add_collection(PolyCollection([], edgecolors=EDGE, linewidths=0.6))
        self.answer_cell, self.true_cell = (axes.add_patch(Polygon(np.zeros((1, 2)), closed=True)) for _ in range(2))
        self.true_cell.set(fill=False, edgecolor=DARK, linewidth=1.6, linestyle=(0, (4, 2)))
        (self.integers,) = axes.plot([], [], ".", color=GREY, markersize=3.5)
        (self.wrong,) = axes.plot([], [], "x", color=WRONG_COLOR, markersize=3.2, markeredgewidth=0.8)
        (self.right,) = axes.plot([], [], "o", color=RIGHT_COLOR, markersize=2.4)
        self.words = [axes.text(x, 0.015, text, transform=axes.transAxes, color=color, fontsize=9.5, fontweight="bold", backgroundcolor="#ffffffcc")
                      for x, text, color in ((0.02, "\N{BLACK CIRCLE} right", RIGHT_COLOR), (0.22, "\N{MULTIPLICATION SIGN} wrong", WRONG_COLOR))]  # fmt: skip
        self.before, self.ellipse, self.touching = (axes.add_patch(Ellipse((0, 0), 1, 1, fill=False)) for _ in range(3))
        self.before.set(edgecolor=GREY, linewidth=1.2, linestyle=":")
        self.ellipse.set(edgecolor=DARK, linewidth=1.3, linestyle="--")
        self.touching.set(edgecolor=MARKS["least squares"]["color"], linewidth=1.5)
        (self.step,) = axes.plot([], [], "-", color=GREY, linewidth=1.2, marker="+", markersize=9, markevery=[0])
        (self.true,) = axes.plot([], [], "*", color=DARK, markersize=7, linestyle="", label="true integers")
        self.answers = {
            name: axes.plot([], [], fillstyle="none", linestyle="", markeredgewidth=2, label=name, **mark)[0] for name, mark in MARKS.items()
        }
        (self.halo,) = axes.plot([], [], "+", color="white", markersize=16, markeredgewidth=4.5)
        (self.cross,) = axes.plot([], [], "+", color=DARK, markersize=14, markeredgewidth=2.2)

    @property
    def legend(self):
        """What the marks mean."""
        marks = [Line2D([], [], fillstyle="none", linestyle="", markeredgewidth=2, label=f"answer of {name}", color=mark["color"],
                        marker=mark["marker"], markersize=7.5) for name, mark in MARKS.items()]  # fmt: skip
        cross = Line2D([], [], color=DARK, marker="+", markersize=9, markeredgewidth=2, linestyle="--", linewidth=1.2, label="float, 95 % ellipse")
        touching = Line2D([], [], color=MARKS["least squares"]["color"], linewidth=1.5, label="grown to the nearest")
        return [*marks, self.true, cross, touching]

    @property
    def moving(self):
        """The artists that change with every result, lowest first."""
        return (self.cells, self.answer_cell, self.integers, self.wrong, self.right, self.true_cell, self.before, self.step, self.ellipse, self.touching,
                self.true, *self.answers.values(), self.halo, self.cross, *self.words)  # fmt: skip

    def show(self, result):
        """Fill in everything; return limits and labels, which are the frame."""
        plane = result.plane
        middle, half = _window(result)
        self._show_cells(result, middle, half)
        self._show_draws(result)
        self._show_float(result)
        self.true.set_data([0], [0])
        self.true.set_alpha(1.0 if plane.third in (None, 0) else 0.35)
        for answer in result.answers:
            mark = self.answers[answer.name]
            mark.set_data(*answer.integers[:2, np.newaxis])
            mark.set_alpha(1.0 if plane.third is None or answer.integers[2] == plane.third else 0.35)
        return self._frame(result, middle, half)

    def _frame(self, result, middle, half):
        labels = [_combination(result.space, k) for k in range(2)]
        title = _title(result)
        self.axes.set_xlim(middle[0] - half, middle[0] + half)
        self.axes.set_ylim(middle[1] - half, middle[1] + half)
        for axis, label in zip((self.axes.xaxis, self.axes.yaxis), labels, strict=True):
            axis.set_label_text(label, fontsize=10)
            axis.set_major_locator(MaxNLocator(8, integer=True))
        self.axes.set_title(title, fontsize=9.5, loc="left", pad=4)
        return *middle, half, *labels, title

    def _show_cells(self, result, middle, half):
        corners, chosen = result.plane.corners, result.settings["estimator"]
        integers = _integers_around(middle, half + np.abs(corners).max(axis=0))
        self.cells.set_verts(integers[:, np.newaxis] + corners)
        self.cells.set_facecolor([TINTS[k] for k in _tints(integers, corners)])
        answer = next(answer for answer in result.answers if answer.name == chosen)
        self.answer_cell.set_xy(answer.integers[:2] + corners)
        self.answer_cell.set(facecolor=MARKS[chosen]["color"], alpha=0.4)
        self.true_cell.set_xy(corners)
        self.true_cell.set_visible(result.plane.third in (None, 0))
        self.integers.set_data(*_integers_around(middle, (half, half)).T)

    def _show_draws(self, result):
        plane, shown = result.plane, result.settings["draws"]
        for dots, chosen in ((self.right, plane.dots_right), (self.wrong, ~plane.dots_right)):
            dots.set_data(*(plane.dots[chosen].T if shown else np.zeros((2, 0))))
        for word in self.words:
            word.set_visible(shown)

    def _show_float(self, result):
        plane = result.plane
        for mark in (self.halo, self.cross):
            mark.set_data(*plane.centre[:, np.newaxis])
        _set_ellipse(self.ellipse, plane.centre, CHI_SQUARE_95 * plane.Q)
        self.touching.set_visible(plane.touching is not None)
        _set_ellipse(self.touching, plane.centre, (plane.touching or 0.0) * plane.Q)
        moved = plane.third is not None and not np.array_equal(plane.centre, result.x_hat[:2])
        self.step.set_data(*(np.array([result.x_hat[:2], plane.centre]).T if moved else np.zeros((2, 0))))
        self.before.set_visible(moved)
        _set_ellipse(self.before, result.x_hat[:2], CHI_SQUARE_95 * result.space.Q[:2, :2])


def _window(result):
    """Return the middle (2,) and half the width of the part of the plane that shows the true integers, the float point and all answers."""
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
    """Return a number of a tint (k,) for each cell, such that neighbours differ where three tints suffice."""
    towards = np.rint(corners + np.roll(corners, -1, axis=0))  # a neighbour's middle lies twice as far as that of the edge between
    best = max(itertools.product(range(3), repeat=2), key=lambda pq: np.sum((towards @ pq) % 3 != 0))
    return ((integers @ best) % 3).astype(int)


def _set_ellipse(ellipse, centre, Q):
    """Give an ellipse patch the form x' Q^-1 x = 1 about a centre, Q (2, 2)."""
    variances, directions = np.linalg.eigh(Q)
    width, height = 2 * np.sqrt(np.maximum(variances, 0))
    ellipse.set(center=tuple(centre), width=width, height=height, angle=np.degrees(np.arctan2(directions[1, 0], directions[0, 0])))


def _combination(space, k):
    """Return what stands along an axis: "a₁ [cycles]", or "z₁ = 3 a₂ − 2 a₁ [cycles]"."""
    name = space.letter + SUBSCRIPTS[k]
    if space.letter == "a":
        return f"{name} [cycles]"
    terms = "".join(_term(factor, f"a{SUBSCRIPTS[i]}") for i, factor in enumerate(space.Z[:, k]) if factor != 0)
    return f"{name} = {terms.removeprefix(' + ').strip()} [cycles]"


def _term(factor, name):
    size = "" if abs(factor) == 1 else f"{abs(factor)} "
    return f" {MINUS if factor < 0 else '+'} {size}{name}"


def _title(result):
    """Return what is said above the plane: which integer the third one was taken for."""
    third, name = result.plane.third, f"{result.space.letter}{SUBSCRIPTS[2]}"
    if third is None:
        return ""
    if result.settings["estimator"] == "rounding":
        return f"{name} is rounded to {_whole(third)}; the others do not hear of it"
    return f"given {name} = {_whole(third)}: float point and ellipse move and shrink"


class _Tree:
    """Nodes level by level, the last ambiguity at the top; the nodes of one parent from the smallest integer to the largest."""

    def __init__(self, axes):
        axes.set(xlim=(0, TREE_WIDTH), ylim=(0, TREE_HEIGHT))
        axes.axis("off")
        self.head, self.below_head = (axes.text(12, y, "", fontsize=size, va="top") for y, size in ((472, 10.5), (452, 9.5)))
        self.levels = [axes.text(8, 0, "", fontsize=11, va="center") for _ in range(3)]
        self.edges = axes.add_collection(LineCollection([], colors="#b5bcc2", linewidths=1.0))
        self.path = axes.add_collection(LineCollection([], colors=RIGHT_COLOR, linewidths=2.6))
        self.nodes = {outcome: axes.plot([], [], "o", markeredgewidth=1.3, **style)[0] for outcome, style in NODE_STYLE.items()}
        self.strikes = axes.add_collection(LineCollection([], colors=WRONG_COLOR, linewidths=1.3))
        (self.now,) = axes.plot([], [], "o", fillstyle="none", color=DARK, markeredgewidth=2)
        self.integers, self.values = NumberPaths(axes), NumberPaths(axes)
        self.ranks = [axes.text(0, 0, text, fontsize=9, ha="center", va="top", fontweight="bold", color=RIGHT_COLOR) for text in ("best", "2nd")]
        axes.legend(
            handles=[Line2D([], [], marker="o", linestyle="", markersize=8, markeredgewidth=1.3, label=label, **NODE_STYLE[outcome])
                     for outcome, label in NODE_LABELS.items()],
            loc="lower center", ncols=3, fontsize=9, bbox_to_anchor=(0.5, -0.005), handletextpad=0.2, columnspacing=1.0,
        )  # fmt: skip

    @property
    def moving(self):
        """The artists that change with every result, lowest first."""
        return (self.edges, self.path, *self.nodes.values(), self.strikes, self.now, *self.integers.moving, *self.values.moving, *self.ranks,
                *self.levels, self.head, self.below_head)  # fmt: skip

    def show(self, result):
        """Draw the nodes up to the one asked for; the frame never changes."""
        nodes = result.tree.nodes[:MOST_NODES]
        layout, shown = _Layout(nodes, len(result.x_hat)), nodes[: result.nodes_shown]
        self._show_words(result, shown)
        self._show_levels(result, layout)
        self._show_nodes(shown, layout)
        self._show_texts(shown, layout)
        self._show_best(shown, layout)
        return ()

    def _show_words(self, result, shown):
        head, below = _words_on_step(result, shown)
        self.head.set_text(head)
        self.below_head.set_text(below)

    def _show_levels(self, result, layout):
        for text in self.levels:
            text.set_text("")
        for k, text in zip(range(layout.levels), self.levels, strict=False):
            text.set_text(f"{result.space.letter}{SUBSCRIPTS[k]}")
            text.set_y(layout.row_y(k))

    def _show_nodes(self, shown, layout):
        places, r = layout.places[: len(shown)], layout.radius
        self.edges.set_segments([[layout.places_of_parent(node), place] for node, place in zip(shown, places, strict=True)])
        outcomes = np.array([node.outcome for node in shown])
        for outcome, dots in self.nodes.items():
            dots.set_data(*places[outcomes == outcome].T)
            dots.set_markersize(1.5 * r)  # [points], 0.75 of a CSS px
        slash = 0.95 * r * np.array([[-1, -1], [1, 1]])
        self.strikes.set_segments(places[outcomes == Outcome.CUT][:, np.newaxis] + slash)
        self.now.set_data(*places[-1:].T)
        self.now.set_markersize(1.5 * r + 4)

    def _show_texts(self, shown, layout):
        texts = [(_whole(node.integer), place, node.outcome == Outcome.CANDIDATE) for node, place in zip(shown, layout.places, strict=False)
                 if layout.spacing[node.level] >= 11]  # fmt: skip
        self.integers.show(
            [text for text, *_ in texts], [place for _, place, _ in texts], np.array([light for *_, light in texts], dtype=bool), layout.digits
        )
        values = layout.values_of(shown)
        self.values.show([text for text, _ in values], [place for _, place in values], np.zeros(len(values), dtype=bool), 7)

    def _show_best(self, shown, layout):
        found = sorted((node.norm, k) for k, node in enumerate(shown) if node.outcome == Outcome.CANDIDATE)[:2]
        for rank, text in enumerate(self.ranks):
            text.set_visible(rank < len(found))
            if rank < len(found):
                x, y = layout.places[found[rank][1]]
                text.set_position((x, y - layout.radius - (14 if layout.has_norms else 3) - 11 * rank))
        self.path.set_segments(layout.path_to(found[0][1]) if found else [])


NODE_STYLE = {
    Outcome.DOWN: {"markerfacecolor": "white", "markeredgecolor": "#444444"},
    Outcome.CANDIDATE: {"markerfacecolor": RIGHT_COLOR, "markeredgecolor": RIGHT_COLOR},
    Outcome.CUT: {"markerfacecolor": "#f6e3d4", "markeredgecolor": WRONG_COLOR},
}
NODE_LABELS = {Outcome.DOWN: "goes on below", Outcome.CANDIDATE: "a candidate", Outcome.CUT: "too far: cut"}


class _Layout:
    """Where the nodes of a tree stand: leaves side by side, each parent above the middle of its children."""

    def __init__(self, nodes, levels):
        self.nodes, self.levels = nodes, levels
        children = {}
        for k, node in enumerate(nodes):
            children.setdefault(node.parent, []).append(k)
        self._children = {parent: sorted(ks, key=lambda k: nodes[k].integer) for parent, ks in children.items()}
        columns = np.empty(len(nodes))
        leaves = self._place(-1, columns, 0)
        self.width = min((TREE_RIGHT - TREE_LEFT) / leaves, 60)
        self.places = np.column_stack([TREE_LEFT + (columns + 0.5) * self.width, [self.row_y(node.level) for node in nodes]])
        self.places[:, 0] += (TREE_RIGHT - TREE_LEFT - leaves * self.width) / 2
        self.spacing = [self._spacing_of(level) for level in range(levels)]
        self.radius = float(np.clip(0.43 * self.width, 2.5, 11))

    def row_y(self, level):
        """Return the height of a level."""
        return BOTTOM_Y + level * (ROOT_Y - BOTTOM_Y) / self.levels

    def places_of_parent(self, node):
        """Return where a node's branch begins."""
        return self.places[node.parent] if node.parent >= 0 else self._root

    def path_to(self, k):
        """Return the branches (segments) from the root to a node."""
        segments = []
        while k >= 0:
            segments.append([self.places_of_parent(self.nodes[k]), self.places[k]])
            k = self.nodes[k].parent
        return segments

    @property
    def has_norms(self):
        """True where there is room for a norm below each leaf."""
        return self.width >= 24

    @property
    def digits(self):
        """Height of the digits in the nodes."""
        return float(np.clip(self.radius * 0.85, 5.5, 8.5))

    def values_of(self, shown):
        """Return texts with their places: the float value below each node that goes on, the squared norm below each that does not."""
        return [(_decimal(number), place - (0, self.radius + 8)) for number, place, room in self._numbers_below(shown) if room >= 24]

    def _numbers_below(self, shown):
        """Yield each number that belongs below a node, the node's place, and the room there is."""
        for k, (node, place) in enumerate(zip(shown, self.places, strict=False)):
            if node.outcome != Outcome.DOWN:
                yield node.norm, place, self.width
            elif k in self._children:
                yield self.nodes[self._children[k][0]].value, place, self.spacing[node.level]

    @property
    def _root(self):
        return np.array([self.places[self._children[-1], 0].mean(), ROOT_Y])

    def _place(self, parent, columns, leaves):
        """Give all nodes below a parent their columns, `leaves` taken already; return how many are taken now."""
        for k in self._children[parent]:
            if k not in self._children:
                columns[k], leaves = leaves, leaves + 1
                continue
            leaves = self._place(k, columns, leaves)
            columns[k] = np.mean(columns[self._children[k]])
        return leaves

    def _spacing_of(self, level):
        """Return the least distance of two neighbours at a level."""
        x = np.sort([place[0] for node, place in zip(self.nodes, self.places, strict=True) if node.level == level])
        return float(np.min(np.diff(x))) if len(x) > 1 else TREE_WIDTH


def _words_on_step(result, shown):
    """Return two lines on the last node shown, or on the outcome where the search is over."""
    total, node = len(result.tree.nodes), shown[-1]
    if len(shown) == total:
        (best, second), (norm, next_norm) = result.tree.candidates, result.tree.norms
        return f"All {total} steps: best {_vector(best)} at {norm:.2f}", f"second best {_vector(second)} at {next_norm:.2f}; nothing nearer is left"
    name = f"{result.space.letter}{SUBSCRIPTS[node.level]}"
    bound = f"bound {node.bound:.2f}" if np.isfinite(node.bound) else "no bound yet"
    return (
        f"Step {len(shown)} of {total}: {name} = {_whole(node.integer)} for {_decimal(node.value)}",
        f"squared norm {node.norm:.2f}, {bound}: {NODE_LABELS[node.outcome]}",
    )


def _whole(integer):
    return f"{integer}".replace("-", MINUS)


def _decimal(number):
    """Return a number in two decimals.

    >>> _decimal(-0.001), _decimal(1.5)
    ('0.00', '1.50')
    """
    return f"{round(number, 2) + 0.0:.2f}".replace("-", MINUS)


def _vector(integers):
    """Return integers as a vector is written by hand."""
    return "(" + ", ".join(map(_whole, integers)) + ")"


def describe_cells(result):
    """Return the pictures in words, for those who cannot see them."""
    chosen = result.settings["estimator"]
    space = "as they stand" if result.space.letter == "a" else "after decorrelation"
    answers = ", ".join(f"{answer.name} says {_vector(answer.integers)}" for answer in result.answers)
    third = "" if result.plane.third is None else f" The plane is that of the first two, with {_whole(result.plane.third)} for the third."
    long, wide = (np.sqrt(value) for value in np.linalg.eigvalsh(result.plane.Q)[::-1])
    return (
        f"The plane of the ambiguities {space}, in cycles from the true integers, covered by the cells of {chosen}; all cells have the area 1.{third} "
        f"The float point is at {', '.join(map(_decimal, result.plane.centre))}, with an ellipse {long / wide:.1f} times as long as it is wide. "
        f"Of the float point {answers}; true is {_vector(0 * result.x_hat.astype(int))}. "
        f"Beside it the search tree: {result.nodes_shown} of {len(result.tree.nodes)} nodes are shown, and {_ends(result)}."
    )


def _ends(result):
    """Return how many of the nodes shown went on, were candidates, and were cut."""
    outcomes = [node.outcome for node in result.tree.nodes[: result.nodes_shown]]
    return ", ".join(
        f"{outcomes.count(outcome)} {words}"
        for outcome, words in ((Outcome.DOWN, "go on below"), (Outcome.CANDIDATE, "are candidates"), (Outcome.CUT, "are cut"))
    )
