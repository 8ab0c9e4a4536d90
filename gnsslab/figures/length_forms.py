"""Pictures of the forms of a known length: what each made of the same epochs, and one of them over time."""

import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.ticker import FixedFormatter, FixedLocator, MaxNLocator, NullFormatter

from gnsslab.figures.kept import Scene, new_figure, styled
from gnsslab.figures.shares import percent
from gnsslab.systems.length_row import RowState

RIGHT, WRONG, NONE, USED, DROPPED, DARK = "#0072B2", "#D55E00", "#D9D9D9", "#009E73", "#A03070", "#111111"
NAMES = {
    "nowhere": "no length", "guarded": "guarded row", "row": "row always", "iterated": "iterated row", "second": "2nd-order row",
    "search": "search", "engine": "our engine",
}  # fmt: skip
PARTS = {  # of a bar, from left to right
    "right": ("fixed, right", {"facecolor": RIGHT, "edgecolor": RIGHT}),
    "wrong": ("fixed, wrong", {"facecolor": WRONG, "edgecolor": "white", "hatch": "////"}),
    "none": ("not fixed", {"facecolor": "#EFEFEF", "edgecolor": "#BBBBBB"}),
}
HEIGHT = 0.66  # of a bar
PLACES = (1.31, 1.63, 2.0)  # of the columns of numbers, in widths of the bars
LOWEST, HIGHEST = 1e-3, 100.0  # [m], ends of what is shown
TICKS = {1e-3: "1 mm", 1e-2: "1 cm", 1e-1: "10 cm", 1e0: "1 m", 1e1: "10 m", 1e2: "100 m"}
STATES = ("row dropped", "row used", "not fixed", "fixed, wrong", "fixed, right")  # from the bottom


def plot_forms(result, figure=None):
    """Draw both pictures of a LengthFormsResult side by side; return the Figure."""
    with styled():
        figure = figure if figure is not None else new_figure(850, 420)
        left, right = figure.subfigures(1, 2, width_ratios=(430, 420))
        for build, part in ((build_forms, left), (build_run, right)):
            build(part).show(result)
    return figure


def build_forms(figure):
    """Lay out a bar for each form, with its numbers beside it; show(result) fills them in."""
    bars = _Bars(figure.add_axes((0.275, 0.115, 0.355, 0.735)))
    figure.legend(handles=bars.named, loc="upper left", ncols=2, fontsize=9, handlelength=1.5, columnspacing=1.4, labelspacing=0.35)
    return Scene(bars.moving, bars.show)


def build_run(figure):
    """Lay out states, length and error of one form over time; show(result) fills them in."""
    boxes = ((0.225, 0.70, 0.755, 0.225), (0.225, 0.42, 0.755, 0.235), (0.225, 0.115, 0.755, 0.26))
    parts = tuple(part(figure.add_axes(box)) for part, box in zip((_States, _Length, _Error), boxes, strict=True))
    for part in parts[:2]:
        part.axes.tick_params(labelbottom=False)
    return Scene(tuple(artist for part in parts for artist in part.moving), lambda result: tuple(part.show(result) for part in parts))


class _Bars:
    """Shares of the epochs fixed right, fixed wrong and not fixed, and how often the row was dropped."""

    def __init__(self, axes):
        self.rows = dict(zip(NAMES, range(len(NAMES) - 1, -1, -1), strict=True))  # the first on top
        axes.set(xlim=(0, 100), ylim=(-0.55, len(NAMES) - 0.45), xlabel="epochs [%]")
        axes.set_yticks(list(self.rows.values()), list(NAMES.values()), fontsize=9.5)
        axes.tick_params(axis="y", length=0)
        axes.grid(False)
        self.parts = {name: axes.add_collection(PolyCollection([], label=label, linewidths=0.5, **style)) for name, (label, style) in PARTS.items()}
        (self.intervals,) = axes.plot([], [], color=DARK, linewidth=2.2, label="95 % interval", clip_on=False)
        self.chosen = axes.text(-0.76, 0, "▶", transform=axes.get_yaxis_transform(), fontsize=9, va="center", ha="left", color=DARK)
        self.columns = [self._column(axes, place) for place in PLACES]
        for place, text in zip(PLACES, ("right", "wrong", "row\ndropped"), strict=True):
            axes.text(place, len(NAMES) - 0.42, text, transform=axes.get_yaxis_transform(), fontsize=9, ha="right", va="bottom")
        self.named = [*self.parts.values(), self.intervals]

    def _column(self, axes, place):
        beside = {"transform": axes.get_yaxis_transform(), "fontsize": 9.5, "ha": "right", "va": "center"}
        return {name: axes.text(place, row, "", **beside) for name, row in self.rows.items()}

    @property
    def moving(self):
        """The artists that change with every result, lowest first."""
        return (*self.parts.values(), self.intervals, self.chosen, *(text for column in self.columns for text in column.values()))

    def show(self, result):
        """Fill in the shares."""
        shares = {name: (100 * run.right.rate, 100 * run.wrong.rate) for name, run in result.runs.items()}
        ends = {name: (0.0, right, right + wrong, 100.0) for name, (right, wrong) in shares.items()}
        for k, part in enumerate(self.parts.values()):
            part.set_verts([_bar(self.rows[name], *ends[name][k : k + 2]) for name in NAMES if ends[name][k + 1] > ends[name][k]])
        spans = [(100 * low, 100 * high, np.nan) for low, high in (result.runs[name].right.interval for name in NAMES)]
        self.intervals.set_data(np.ravel(spans), np.repeat([self.rows[name] for name in NAMES], 3))
        self.chosen.set_y(self.rows[result.settings["form"]])
        for name, run in result.runs.items():
            texts = (_short(run.right.rate), _short(run.wrong.rate), _row_words(run))
            for column, text in zip(self.columns, texts, strict=True):
                column[name].set_text(text)


class _States:
    """Which epochs are fixed right, fixed wrong or not, and at which the row was used or dropped: each its own line."""

    def __init__(self, axes):
        self.axes = axes
        axes.set(ylim=(-0.6, len(STATES) - 0.4))
        axes.set_yticks(range(len(STATES)), STATES, fontsize=9)
        axes.tick_params(axis="y", length=0)
        axes.grid(False)
        self.title = axes.set_title("", fontsize=10, loc="left", x=-0.27)
        colors = (DROPPED, USED, "#777777", WRONG, RIGHT)
        self.marks = [axes.plot([], [], "|", color=color, markersize=10, markeredgewidth=1.2)[0] for color in colors]

    @property
    def moving(self):
        """The artists that change with every result, lowest first."""
        return (self.title, *self.marks)

    def show(self, result):
        """Fill in the states; return the span, which is the frame."""
        run = result.run
        chosen = (run.row_state == RowState.DROPPED, run.row_state == RowState.USED, ~run.is_fixed, run.is_wrong, run.is_right)
        for height, (marks, at) in enumerate(zip(self.marks, chosen, strict=True)):
            marks.set_data(result.seconds[at], np.full(int(at.sum()), height))
        self.title.set_text(title_of(result))
        return _set_span(self.axes, result)


class _Length:
    """Length of the baseline given out, and the length that was entered."""

    def __init__(self, axes):
        self.axes = axes
        axes.set_ylabel("length [m]", labelpad=4)
        axes.yaxis.set_major_locator(MaxNLocator(4))
        (self.entered,) = axes.plot([], [], color=DARK, linewidth=1.2, linestyle="--")
        (self.line,) = axes.plot([], [], ".", color=USED, markersize=4)

    @property
    def moving(self):
        """The artists that change with every result, lowest first."""
        return (self.line, self.entered)

    def show(self, result):
        """Fill in the lengths; return the limits, which are the frame."""
        top = 2 * np.linalg.norm(result.baseline)
        self.line.set_data(result.seconds, np.minimum(result.run.length, top))
        self.entered.set_data([0, result.seconds[-1]], [result.entered] * 2)
        self.axes.set_ylim(0, top)
        return top, _set_span(self.axes, result)


class _Error:
    """Distance of the baseline given out from the truth."""

    def __init__(self, axes):
        self.axes = axes
        axes.set_yscale("log")
        axes.set_ylim(0.8 * LOWEST, HIGHEST)
        axes.yaxis.set_major_locator(FixedLocator(list(TICKS)))
        axes.yaxis.set_major_formatter(FixedFormatter(list(TICKS.values())))
        axes.yaxis.set_minor_formatter(NullFormatter())
        axes.set_ylabel("error", labelpad=1)
        axes.set_xlabel("time [s]", labelpad=1)
        styles = ({"marker": ".", "color": "#777777"}, {"marker": "^", "color": WRONG}, {"marker": "o", "color": RIGHT})
        self.marks = [axes.plot([], [], linestyle="", markersize=3.5, **style)[0] for style in styles]

    @property
    def moving(self):
        """The artists that change with every result, lowest first."""
        return tuple(self.marks)

    def show(self, result):
        """Fill in the errors; return the span, which is the frame."""
        run, off = result.run, np.clip(result.run.off, LOWEST, HIGHEST)
        for marks, at in zip(self.marks, (~run.is_fixed, run.is_wrong, run.is_right), strict=True):
            marks.set_data(result.seconds[at], off[at])
        return _set_span(self.axes, result)


def title_of(result):
    """Return the name of the form shown, and what became of its row, said aloud."""
    run, name = result.run, NAMES[result.settings["form"]]
    words = _row_words(run)
    return f"{name}: row dropped at {words} of the epochs" if words else f"{name}: no row"


def describe_forms(result):
    """Return the pictures in words, for those who cannot see them."""
    shares = "; ".join(f"{NAMES[name]} {percent(run.right.rate)} % right and {percent(run.wrong.rate)} % wrong" for name, run in result.runs.items())
    run = result.run
    return (
        f"Bars of what {len(run.off)} epochs with {len(result.satellites)} satellites came to: {shares}. "
        f"Over time, {title_of(result)}; the error is {np.median(run.off):.3f} m in the median."
    )


def _row_words(run):
    """Return at which share of the epochs the row was dropped; nothing where there is no row."""
    return _short(run.dropped) if (run.row_state != RowState.NONE).any() else ""


def _short(share):
    """Return a share in per cent with one digit, which is what a column has room for and some hundred epochs can tell."""
    return f"{round(100 * share)} %" if share in (0, 1) else f"{100 * share:.1f} %"


def _set_span(axes, result):
    last = max(float(result.seconds[-1]), 1.0)
    axes.set_xlim(-0.02 * last, 1.02 * last)
    return last


def _bar(row, left, right):
    low, high = row - HEIGHT / 2, row + HEIGHT / 2
    return [(left, low), (right, low), (right, high), (left, high)]
