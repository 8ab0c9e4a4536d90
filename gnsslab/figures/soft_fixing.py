"""Pictures of five ways to treat float ambiguities: errors of the baseline, how many can be fixed, and the staircase of a single one."""

import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.ticker import FixedFormatter, FixedLocator, LogLocator, MaxNLocator, NullFormatter

from gnsslab.figures.kept import Scene, new_figure, styled

# Colours of Okabe and Ito (2008), dark enough on white; dashes and marks tell the lines apart again.
STYLE = {  # in the order of drawing: where lines coincide the lower ones are wider
    "soft": {"color": "#007A5A", "linestyle": "-", "linewidth": 4.2, "marker": "v", "markersize": 10},
    "fixed": {"color": "#0072B2", "linestyle": "-", "linewidth": 1.9, "marker": "s", "markersize": 7},
    "partial": {"color": "#D98200", "linestyle": (0, (7, 3)), "linewidth": 1.9, "marker": "^", "markersize": 7},
    "tested": {"color": "#A03070", "linestyle": (0, (7, 2, 1.5, 2)), "linewidth": 1.7, "marker": "D", "markersize": 5.5},
    "float": {"color": "#444444", "linestyle": (0, (1.5, 1.5)), "linewidth": 1.7, "marker": "o", "markersize": 5},
}
NAMES = {"float": "float", "tested": "fixed if the ratio says so", "fixed": "always fixed", "partial": "partly fixed", "soft": "best equivariant"}
TICKS = {1e-3: "1 mm", 1e-2: "1 cm", 1e-1: "10 cm", 1e0: "1 m", 1e1: "10 m"}
SMALLEST, LARGEST = 1e-3, 20.0  # [m]
LEAST_RISK = 1e-6
MOST_BARS = 18
LEFT_COLOR, EDGE_COLOR = "#BBBBBB", "#111111"


def plot_soft_fixing(result, figure=None):
    """Draw both pictures of a SoftResult side by side; return the Figure."""
    with styled():
        figure = figure if figure is not None else new_figure(900, 540)
        errors, single = figure.subfigures(1, 2, width_ratios=(1.5, 1))
        for build, part in ((build_errors, errors), (build_single, single)):
            build(part).show(result)
    return figure


def build_errors(figure):
    """Lay out the shares of errors, the staircase of one ambiguity and the risks of a partial fix; show(result) fills them in."""
    parts = (
        _Shares(figure.add_axes((0.13, 0.50, 0.84, 0.36)), figure),
        _Staircase(figure.add_axes((0.13, 0.095, 0.325, 0.27))),
        _Risks(figure.add_axes((0.645, 0.095, 0.325, 0.27))),
    )

    def show(result):
        return tuple(part.show(result) for part in parts)

    return Scene(tuple(artist for part in parts for artist in part.moving), show)


def build_single(figure):
    """Lay out the rms error of one ambiguity against its sigma; show(result) marks the sigma chosen."""
    single = _Single(figure.add_axes((0.165, 0.145, 0.80, 0.745)))
    return Scene(single.moving, single.show)


class _Shares:
    """For each way the share of epochs whose baseline is off by less than what the axis says; a mark where the rms is."""

    def __init__(self, axes, figure):
        self.axes = axes
        axes.set_xscale("log")
        axes.set_xlim(SMALLEST, LARGEST)
        axes.set_ylim(0, 101)
        axes.xaxis.set_major_locator(FixedLocator(list(TICKS)))
        axes.xaxis.set_major_formatter(FixedFormatter(list(TICKS.values())))
        axes.xaxis.set_minor_locator(LogLocator(subs=range(2, 10), numticks=60))
        axes.xaxis.set_minor_formatter(NullFormatter())
        axes.yaxis.set_major_locator(FixedLocator([0, 25, 50, 75, 100]))
        axes.set_xlabel("error of the baseline is less than; marks at the rms", labelpad=1)
        axes.set_ylabel("share of epochs [%]", labelpad=2)
        self.lines, self.marks = {}, {}
        for way, style in STYLE.items():
            (self.lines[way],) = axes.plot([], [], **_line(way))
            (self.marks[way],) = axes.plot([], [], **(style | {"linestyle": ""}), markeredgecolor="white", clip_on=False)
        legend = [axes.plot([], [], label=name, **STYLE[way])[0] for way, name in NAMES.items()]
        figure.legend(
            handles=legend, loc="upper left", bbox_to_anchor=(0.0, 1.0), ncols=2, fontsize=9.5, handlelength=3.2, columnspacing=1.2, labelspacing=0.25
        )

    @property
    def moving(self):
        """The artists that change with every result, lowest first."""
        return (*self.lines.values(), *self.marks.values())

    def show(self, result):
        for way, errors in result.errors.items():
            ordered = np.clip(np.sort(errors), SMALLEST / 2, 2 * LARGEST)
            share = 100 * np.arange(1, len(ordered) + 1) / len(ordered)
            self.lines[way].set_data(ordered, share)
            rms = np.clip(result.rms[way], SMALLEST, LARGEST)
            self.marks[way].set_data([rms], [np.interp(rms, ordered, share)])
        return 0


class _Staircase:
    """One ambiguity: its float value, and what the three estimators make of it."""

    def __init__(self, axes):
        axes.set(xlim=(-1.5, 1.5), ylim=(-1.5, 1.5))
        axes.set_xlabel("float ambiguity [cycles]", labelpad=1)
        axes.set_ylabel("estimate", labelpad=0)
        axes.xaxis.set_major_locator(FixedLocator([-1, 0, 1]))
        axes.yaxis.set_major_locator(FixedLocator([-1, 0, 1]))
        (self.soft,) = axes.plot([], [], **_line("soft"))
        self.steps = axes.plot([-1.5, -0.5, np.nan, -0.5, 0.5, np.nan, 0.5, 1.5], [-1, -1, np.nan, 0, 0, np.nan, 1, 1], **_line("fixed"))
        self.ramp = axes.plot([-1.5, 1.5], [-1.5, 1.5], **_line("float"))
        self.words = axes.text(0.0, 1.03, "", transform=axes.transAxes, fontsize=9, va="bottom")

    @property
    def moving(self):
        """The artists that change with every result, lowest first."""
        return (self.soft, *self.steps, *self.ramp, self.words)

    def show(self, result):
        self.soft.set_data(result.single.float_values, result.single.soft)
        self.words.set_text(f"one ambiguity, sigma {result.settings['sigma']:.2f}")
        return 0


class _Risks:
    """How probable it is that any is wrong where 1, 2, ... n ambiguities are fixed; the number chosen in colour."""

    def __init__(self, axes):
        self.axes = axes
        axes.set_yscale("log")
        axes.set_ylim(LEAST_RISK, 1)
        axes.yaxis.set_major_locator(FixedLocator([1e-6, 1e-4, 1e-2, 1]))
        axes.yaxis.set_major_formatter(FixedFormatter(["0.0001 %", "0.01 %", "1 %", "100 %"]))
        axes.yaxis.set_minor_locator(FixedLocator([]))
        axes.xaxis.set_major_locator(MaxNLocator(6, integer=True))
        axes.set_xlabel("how many are fixed", labelpad=1)
        axes.tick_params(axis="y", pad=1)
        self.bars = axes.add_collection(PolyCollection([], linewidths=0))
        (self.accepted,) = axes.plot([], [], "--", color=EDGE_COLOR, linewidth=1.2)
        self.words = axes.text(0.0, 1.03, "", transform=axes.transAxes, fontsize=9, va="bottom")

    @property
    def moving(self):
        """The artists that change with every result, lowest first."""
        return (self.bars, self.accepted, self.words)

    def show(self, result):
        n = len(result.risks)
        heights = np.clip(result.risks, LEAST_RISK * 1.25, 1)
        self.bars.set_verts([[(k - 0.4, LEAST_RISK), (k - 0.4, top), (k + 0.4, top), (k + 0.4, LEAST_RISK)] for k, top in enumerate(heights, 1)])
        self.bars.set_facecolor([STYLE["partial"]["color"] if k == result.fixed else LEFT_COLOR for k in range(1, n + 1)])
        self.accepted.set_data([0, MOST_BARS + 1], [result.settings["risk"]] * 2)
        self.words.set_text(f"risk: {result.fixed} of {n} fixed")
        self.axes.set_xlim(0.4, n + 0.6)
        return n


class _Single:
    """One ambiguity: the rms error of rounding and of the best equivariant estimate in units of sigma, which is that of float."""

    def __init__(self, axes):
        axes.set(xlim=(0, 0.8), ylim=(0, 1.32))
        axes.set_xlabel("sigma of the float ambiguity [cycles]")
        axes.set_ylabel("rms error / sigma", labelpad=2)
        self.lines = {way: axes.plot([], [], **_line(way))[0] for way in ("soft", "fixed", "float")}
        self.marks = {way: axes.plot([], [], **(STYLE[way] | {"linestyle": ""}), markeredgecolor="white")[0] for way in self.lines}
        axes.set_title("one ambiguity: which way is best?", fontsize=10, loc="left")

    @property
    def moving(self):
        """The artists that change with every result, lowest first."""
        return (*self.lines.values(), *self.marks.values())

    def show(self, result):
        single, sigma = result.single, result.settings["sigma"]
        for way, rms in (("soft", single.rms_soft), ("fixed", single.rms_rounded), ("float", single.sigmas)):
            self.lines[way].set_data(single.sigmas, rms / single.sigmas)
            self.marks[way].set_data([sigma], [np.interp(sigma, single.sigmas, rms / single.sigmas)])
        return 0


def _line(way):
    """Return the style of a way's line without its mark."""
    return STYLE[way] | {"marker": ""}


def describe_soft_fixing(result):
    """Return the pictures in words, for those who cannot see them."""
    rms, sigma, single = result.rms, result.settings["sigma"], result.single
    errors = "; ".join(f"{NAMES[way]} {1000 * rms[way]:.1f} mm" for way in STYLE)
    rounded, soft = (np.interp(sigma, single.sigmas, values) / sigma for values in (single.rms_rounded, single.rms_soft))
    return (
        f"Shares of {len(result.is_right)} epochs whose baseline is off by less than the axis says, from a millimetre to ten metres. "
        f"Root mean squares: {errors}. Below, the stairs of one ambiguity of sigma {sigma:.2f} cycles: float a line, rounding steps, the best "
        f"equivariant estimate a smooth curve between them. Beside it the risk of fixing ever more of {len(result.risks)} ambiguities: "
        f"{result.fixed} are fixed. The second picture: rounding has {rounded:.2f} and the best equivariant estimate {soft:.2f} of the float error."
    )
