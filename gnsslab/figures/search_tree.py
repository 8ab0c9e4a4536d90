"""The search for the nearest integers as a tree, node by node."""

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D

from gnsslab.core.integers.tree import Outcome
from gnsslab.figures.integer_words import MINUS, decimal, indexed, vector, whole
from gnsslab.figures.kept import Scene
from gnsslab.figures.numbers import NumberPaths

MOST_NODES = 80  # that can be told apart
WIDTH, HEIGHT = 400, 480  # [CSS px], the picture's units; those below as well
LEFT, RIGHT, ROOT_Y, BOTTOM_Y = 38, 392, 412, 92
LARGEST_RADIUS, WIDEST_COLUMN = 11, 60
NUMBER_WIDTH, NUMBER_HEIGHT = 27, 7  # of a number below a node, with what must be free beside it
DIGIT_WIDTH = 0.8  # of the digit's height
BEST_COLOR, CUT_COLOR, DARK = "#0072B2", "#C05000", "#111111"
NODE_STYLE = {
    Outcome.DOWN: {"markerfacecolor": "white", "markeredgecolor": "#444444"},
    Outcome.CANDIDATE: {"markerfacecolor": BEST_COLOR, "markeredgecolor": BEST_COLOR},
    Outcome.CUT: {"markerfacecolor": "#f6e3d4", "markeredgecolor": CUT_COLOR},
}
NODE_WORDS = {Outcome.DOWN: "goes on below", Outcome.CANDIDATE: "a candidate", Outcome.CUT: "too far, cut"}
KEY = "below a node: float value of the next; below an end: squared norm"


def build_tree(figure):
    """Lay out the search tree; show(result) draws the nodes up to the one asked for."""
    tree = _Tree(figure.add_axes((0, 0, 1, 1)))
    return Scene(tree.moving, tree.show)


def describe_tree(result):
    """Return the tree in words."""
    outcomes = [node.outcome for node in result.tree.nodes[: result.nodes_shown]]
    words = ((Outcome.DOWN, "go on below"), (Outcome.CANDIDATE, "are candidates"), (Outcome.CUT, "are cut"))
    return (
        f"Beside it the search tree, of {len(result.tree.nodes)} nodes. The first {len(outcomes)} are shown: "
        + ", ".join(f"{outcomes.count(outcome)} {what}" for outcome, what in words)
        + f". {'; '.join(_words_on_step(result, result.tree.nodes[: result.nodes_shown]))}."
    )


class _Tree:
    """Nodes level by level, the last ambiguity at the top; the children of a node from the smallest integer to the largest."""

    def __init__(self, axes):
        axes.set(xlim=(0, WIDTH), ylim=(0, HEIGHT))
        axes.axis("off")
        self.head, self.below_head = (axes.text(12, y, "", fontsize=size, va="top") for y, size in ((472, 10.5), (452, 9.5)))
        self.levels = [axes.text(8, 0, "", fontsize=11, va="center") for _ in range(3)]
        self.edges = axes.add_collection(LineCollection([], colors="#b5bcc2", linewidths=1.0))
        self.path = axes.add_collection(LineCollection([], colors=BEST_COLOR, linewidths=2.6))
        self.strikes = axes.add_collection(LineCollection([], colors=CUT_COLOR, linewidths=1.6))
        self.nodes = {key: axes.plot([], [], "o", markeredgewidth=1.3, label=NODE_WORDS[key], **style)[0] for key, style in NODE_STYLE.items()}
        (self.now,) = axes.plot([], [], "o", fillstyle="none", color=DARK, markeredgewidth=2)
        self.integers, self.numbers = NumberPaths(axes), NumberPaths(axes)
        self.ranks = [axes.text(0, 0, text, fontsize=9, ha="center", va="top", fontweight="bold", color=BEST_COLOR) for text in ("best", "2nd")]
        axes.text(WIDTH / 2, 36, KEY, fontsize=8.5, ha="center", color="#444444")
        marks = [Line2D([], [], marker="o", linestyle="", markersize=8, label=NODE_WORDS[key], **style) for key, style in NODE_STYLE.items()]
        axes.legend(handles=marks, loc="lower center", ncols=3, fontsize=9, bbox_to_anchor=(0.5, -0.005), handletextpad=0.2, columnspacing=1.0)

    @property
    def moving(self):
        """The artists that change with every result, lowest first."""
        lines = (self.edges, self.path, self.strikes)
        texts = (*self.integers.moving, *self.numbers.moving, *self.ranks, *self.levels, self.head, self.below_head)
        return (*lines, *self.nodes.values(), self.now, *texts)

    def show(self, result):
        """Draw the nodes up to the one asked for; the frame never changes."""
        layout = _Layout(result.tree.nodes[:MOST_NODES], len(result.x_hat))
        shown = result.tree.nodes[: result.nodes_shown]
        for text, words in zip((self.head, self.below_head), _words_on_step(result, shown), strict=True):
            text.set_text(words)
        self._show_levels(result, layout)
        self._show_nodes(shown, layout)
        self._show_numbers(shown, layout)
        self._show_best(shown, layout)
        return ()

    def _show_levels(self, result, layout):
        for k, text in enumerate(self.levels):
            text.set_text(indexed(result.space.letter, k) if k < layout.levels else "")
            text.set_y(layout.row_y(k))

    def _show_nodes(self, shown, layout):
        places, outcomes = layout.places[: len(shown)], np.array([node.outcome for node in shown])
        self.edges.set_segments([[layout.start_of(k), places[k]] for k in range(len(shown))])
        self.strikes.set_segments([layout.strike(k) for k in np.flatnonzero(outcomes == Outcome.CUT)])
        for outcome, dots in self.nodes.items():
            dots.set_data(*places[outcomes == outcome].T)
            dots.set_markersize(_points(2 * layout.radius))
        self.now.set_data(*places[-1:].T)
        self.now.set_markersize(_points(2 * layout.radius + 5))

    def _show_numbers(self, shown, layout):
        labelled = [k for k, node in enumerate(shown) if layout.room[k] >= DIGIT_WIDTH * layout.digits * len(whole(node.integer)) + 1]
        is_light = np.array([shown[k].outcome == Outcome.CANDIDATE for k in labelled], dtype=bool)
        self.integers.show([whole(shown[k].integer) for k in labelled], layout.places[labelled], is_light, layout.digits)
        below = list(layout.numbers_below(len(shown)))
        self.numbers.show([_short(number) for number, _ in below], [place for _, place in below], np.zeros(len(below), dtype=bool), NUMBER_HEIGHT)

    def _show_best(self, shown, layout):
        found = sorted((node.norm, k) for k, node in enumerate(shown) if node.outcome == Outcome.CANDIDATE)[:2]
        self.path.set_segments(layout.path_to(found[0][1]) if found else [])
        for rank, text in enumerate(self.ranks):
            text.set_visible(rank < len(found))
            if rank < len(found):
                x, y = layout.places[found[rank][1]]
                text.set_position((x, y - layout.below(0) - 2 - (0 if layout.has_room(0) else 11 * rank)))


class _Layout:
    """Where the nodes of a tree stand: ends side by side, each parent above the middle of its children."""

    def __init__(self, nodes, levels):
        self.nodes, self.levels = nodes, levels
        self._children = _children_of(nodes)
        columns = np.empty(len(nodes))
        ends = self._place(-1, columns, 0)
        self.width = min((RIGHT - LEFT) / ends, WIDEST_COLUMN)
        self.radius = float(np.clip(0.43 * self.width, 2.5, LARGEST_RADIUS))
        x = (LEFT + RIGHT) / 2 + (columns + 0.5 - ends / 2) * self.width
        self.places = np.column_stack([x, [self.row_y(node.level) for node in nodes]])
        self.root = np.array([self.places[self._children[-1], 0].mean(), ROOT_Y + self.radius])
        self.room = self._distances_of_neighbours()
        self.spacing = [min(room for node, room in zip(nodes, self.room, strict=True) if node.level == level) for level in range(levels)]

    def row_y(self, level):
        """Return the height of a level."""
        return BOTTOM_Y + level * (ROOT_Y - BOTTOM_Y) / self.levels

    def has_room(self, level):
        """Return whether numbers fit below the nodes of a level."""
        return self.spacing[level] >= NUMBER_WIDTH

    def below(self, level):
        """Return how far below the middle of a node the node and its number end."""
        return self.radius + (5 + NUMBER_HEIGHT if self.has_room(level) else 0)

    def start_of(self, k):
        """Return where the branch to node k begins: below its parent and the number there."""
        parent = self.nodes[k].parent
        if parent < 0:
            return self.root - (0, self.radius + 5 + NUMBER_HEIGHT)
        return self.places[parent] - (0, self.below(self.nodes[parent].level))

    def strike(self, k):
        """Return the stroke (2, 2) across the branch to node k, just above the node."""
        along = self.start_of(k) - self.places[k]
        along = along / np.hypot(*along)
        return self.places[k] + along * (self.radius + 6) + np.outer([-5, 5], [-along[1], along[0]])

    def path_to(self, k):
        """Return the branches from the root to node k."""
        branches = []
        while k >= 0:
            branches.append([self.start_of(k), self.places[k]])
            k = self.nodes[k].parent
        return branches

    @property
    def digits(self):
        """Height of the digits in the nodes."""
        return float(np.clip(self.radius * 0.9, 6.0, 8.5))

    def numbers_below(self, count):
        """Yield each number below the root and the first `count` nodes, and its place: below a parent a float value, below an end its norm."""
        drop = np.array([0, self.radius + 5 + NUMBER_HEIGHT / 2 - 1])
        yield self.nodes[0].value, self.root - drop
        for k, node in enumerate(self.nodes[:count]):
            if self.has_room(node.level):
                is_parent = k in self._children
                yield self.nodes[self._children[k][0]].value if is_parent else node.norm, self.places[k] - drop

    def _place(self, parent, columns, ends):
        """Give all nodes below a parent their columns, `ends` of which are taken; return how many are taken then."""
        for k in self._children[parent]:
            if k in self._children:
                ends = self._place(k, columns, ends)
                columns[k] = np.mean(columns[self._children[k]])
            else:
                columns[k], ends = ends, ends + 1
        return ends

    def _distances_of_neighbours(self):
        """Return how far each node (k,) is from the nearest other at its level."""
        apart = np.abs(self.places[:, 0] - self.places[:, :1])  # (k, k)
        level = self.places[:, 1]
        is_neighbour = (level == level[:, np.newaxis]) & ~np.eye(len(level), dtype=bool)
        return np.min(np.where(is_neighbour, apart, WIDTH), axis=1)


def _children_of(nodes):
    """Return the children of each node that has any, and of the root, -1, from the smallest integer to the largest."""
    children = {}
    for k, node in enumerate(nodes):
        children.setdefault(node.parent, []).append(k)
    return {parent: sorted(below, key=lambda k: nodes[k].integer) for parent, below in children.items()}


def _points(pixels):
    """Return a size in points of 1/72 inch, CSS px being 1/96."""
    return 0.75 * pixels


def _short(number):
    """Return a number in four places at most, or in as many as its whole part has.

    >>> _short(1.234), _short(23.45), _short(233.58)
    ('1.23', '23.4', '234')
    """
    return decimal(number) if abs(number) < 10 else whole(round(number)) if abs(number) >= 100 else f"{number:.1f}".replace("-", MINUS)


def _words_on_step(result, shown):
    """Return two lines on the last node shown, or on the outcome where the search is over."""
    total, node = len(result.tree.nodes), shown[-1]
    if len(shown) == total:
        (best, second), (norm, next_norm) = result.tree.candidates, result.tree.norms
        return (
            f"All {total} steps: best {vector(best)} at {decimal(norm)}",
            f"second best {vector(second)} at {decimal(next_norm)}; nothing else is nearer",
        )
    bound = f"bound {decimal(node.bound)}" if np.isfinite(node.bound) else "no bound yet"
    return (
        f"Step {len(shown)} of {total}: {indexed(result.space.letter, node.level)} = {whole(node.integer)} for {decimal(node.value)}",
        f"squared norm {decimal(node.norm)}, {bound}: {NODE_WORDS[node.outcome]}",
    )
