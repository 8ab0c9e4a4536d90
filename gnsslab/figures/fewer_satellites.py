"""Pictures of satellites taken away: what became of the epochs at each number, and the epochs of one number."""

import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.patches import Rectangle
from matplotlib.ticker import FixedFormatter, FixedLocator, MaxNLocator, NullFormatter

from gnsslab.figures.kept import Scene, new_figure, styled

RIGHT_COLOR, WRONG_COLOR, PROMISE_COLOR = "#0072B2", "#D98200", "#111111"
# From the bottom of a bar to its top: the two right ones below, so that their sum can be read.
OUTCOMES = {
    "fixed": ("fixed, right", {"facecolor": RIGHT_COLOR, "edgecolor": RIGHT_COLOR}),
    "right_rejected": ("rejected, right", {"facecolor": "#C3DEEF", "edgecolor": RIGHT_COLOR, "hatch": "////"}),
    "wrong_rejected": ("rejected, wrong", {"facecolor": "#F8E3C4", "edgecolor": WRONG_COLOR, "hatch": "...."}),
    "failed": ("fixed, wrong", {"facecolor": WRONG_COLOR, "edgecolor": WRONG_COLOR}),
}
MARKS = {
    "fixed": {"marker": "o", "color": RIGHT_COLOR},
    "right_rejected": {"marker": "o", "color": RIGHT_COLOR, "markerfacecolor": "none"},
    "wrong_rejected": {"marker": "^", "color": WRONG_COLOR, "markerfacecolor": "none"},
    "failed": {"marker": "^", "color": WRONG_COLOR},
}
WIDTH = 0.74  # of a bar
LOWEST, HIGHEST = 6e-4, 1000.0  # [m], ends of what is shown
TICKS = {1e-3: "1 mm", 1e-2: "1 cm", 1e-1: "10 cm", 1e0: "1 m", 1e1: "10 m", 1e2: "100 m", 1e3: "1 km"}


def plot_fewer(result, figure=None):
    """Draw both pictures of a FewerResult side by side; return the Figure."""
    with styled():
        figure = figure if figure is not None else new_figure(840, 420)
        left, right = figure.subfigures(1, 2, width_ratios=(1.16, 1))
        for build, part in ((build_stages, left), (build_epochs, right)):
            build(part).show(result)
    return figure


def build_stages(figure):
    """Lay out one bar for each number of satellites; show(result) fills them in."""
    bars = _Bars(figure.add_axes((0.125, 0.155, 0.85, 0.70)))
    figure.legend(handles=bars.named, loc="upper left", ncols=3, fontsize=9, handlelength=1.4, handletextpad=0.5, columnspacing=1.2, labelspacing=0.4)
    return Scene(bars.moving, bars.show)


def build_epochs(figure):
    """Lay out the errors of the epochs with the chosen number of satellites; show(result) fills them in."""
    errors = _Errors(figure.add_axes((0.165, 0.125, 0.81, 0.695)))
    return Scene(errors.moving, errors.show)


class _Bars:
    """Shares of the outcomes, all satellites on the left, four on the right."""

    def __init__(self, axes):
        self.axes = axes
        axes.set_ylim(0, 105)
        axes.set_ylabel("share of epochs [%]")
        axes.set_xlabel("satellites left, and the one that went last")
        axes.grid(False, axis="x")
        self.parts = {
            name: axes.add_collection(PolyCollection([], label=label, linewidths=0.5, **style)) for name, (label, style) in OUTCOMES.items()
        }
        diamond = {"color": "white", "markeredgecolor": PROMISE_COLOR, "markeredgewidth": 1.6, "markersize": 8, "clip_on": False}
        (self.promises,) = axes.plot([], [], "D", label="promised right", **diamond)
        self.chosen = axes.add_patch(Rectangle((0, 0), 1, 1, fill=False, edgecolor="#111111", linewidth=2.2, label="shown beside"))
        self.named = [*self.parts.values(), self.promises, self.chosen]

    @property
    def moving(self):
        """The artists that change with every result, lowest first."""
        return (*self.parts.values(), self.chosen, self.promises)

    def show(self, result):
        """Fill in all stages; return their names, which are the frame."""
        shares = 100 * np.array([[getattr(one, name) for name in OUTCOMES] for one in result.shares])  # (stages, outcomes)
        tops = np.cumsum(shares, axis=1)
        for part, top, height in zip(self.parts.values(), tops.T, shares.T, strict=True):
            part.set_verts([_bar(x, high - tall, high) for x, (high, tall) in enumerate(zip(top, height, strict=True)) if tall > 0])
        self.promises.set_data(np.arange(len(shares)), 100 * np.array(result.promised))
        self.chosen.set_bounds(result.chosen - WIDTH / 2 - 0.06, -1, WIDTH + 0.12, 102.5)
        return self._label(result)

    def _label(self, result):
        names = tuple(f"{len(stage.satellites)}\n{'' if not stage.gone else '- ' + stage.gone}" for stage in result.stages)
        self.axes.xaxis.set_major_locator(FixedLocator(range(len(names))))
        self.axes.xaxis.set_major_formatter(FixedFormatter(names))
        self.axes.set_xlim(-0.6, len(names) - 0.4)
        return names


class _Errors:
    """How far the position of each epoch is from the known one: the fixed one where it is believed, else the float one."""

    def __init__(self, axes):
        self.axes = axes
        axes.set_yscale("log")
        axes.set_ylim(0.8 * LOWEST, 40 * HIGHEST)  # room for the legend
        axes.yaxis.set_major_locator(FixedLocator(list(TICKS)))
        axes.yaxis.set_major_formatter(FixedFormatter(list(TICKS.values())))
        axes.yaxis.set_minor_formatter(NullFormatter())
        axes.xaxis.set_major_locator(MaxNLocator(5, integer=True))
        axes.set_xlabel("epoch")
        self.title = axes.set_title("", fontsize=9.5, loc="left")
        self.marks = {name: axes.plot([], [], linestyle="", markersize=4.5, label=OUTCOMES[name][0], **style)[0] for name, style in MARKS.items()}
        axes.legend(loc="upper left", ncols=2, fontsize=8.5, handletextpad=0.1, columnspacing=0.8, borderpad=0.1)

    @property
    def moving(self):
        """The artists that change with every result, lowest first."""
        return (self.title, *self.marks.values())

    def show(self, result):
        """Fill in the epochs; return their number, which is the frame."""
        epoch, error = 1 + np.arange(len(result.off)), np.clip(result.off, LOWEST, HIGHEST)
        for name, marks in self.marks.items():
            chosen = getattr(result.outcomes, name)
            marks.set_data(epoch[chosen], error[chosen])
        count = len(result.stage.satellites)
        self.title.set_text(f"error of the position, {count} satellites:\nfixed where accepted, float where rejected")
        self.axes.set_xlim(0, len(epoch) + 1)
        return len(epoch)


def describe_fewer(result):
    """Return the pictures in words, for those who cannot see them."""
    parts = "; ".join(
        f"{len(stage.satellites)} satellites: {100 * shares.right:.0f} % right, {100 * shares.fixed:.0f} % fixed and right, "
        f"{100 * shares.failed:.0f} % fixed wrong, promised {100 * promised:.0f} %"
        for stage, shares, promised in zip(result.stages, result.shares, result.promised, strict=True)
    )
    return (
        f"Bars of what became of {len(result.off)} epochs, each solved alone, as satellites go. {parts}. Beside them the error of each "
        f"epoch's position with {len(result.stage.satellites)} satellites, {np.median(result.off):.3f} m in the median."
    )


def _bar(x, low, high):
    left, right = x - WIDTH / 2, x + WIDTH / 2
    return [(left, low), (right, low), (right, high), (left, high)]
