"""Pictures of a filter's health: innovations, NIS, errors and fixes over time; how often which NIS, and how soon the first fix."""

import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.patches import Polygon
from matplotlib.ticker import FixedLocator, FuncFormatter, MaxNLocator, NullLocator

from gnsslab.figures.kept import Scene, new_figure, styled

CARRIER, CODE, WRONG_COLOR, DARK, FAINT, BAND = "#0072B2", "#C86400", "#D55E00", "#111111", "#9AA7B0", "#8FBEE0"
FLOAT_COLOR, FIXED_COLOR, HELD_COLOR = "#E4E4E4", "#8FBEE0", "#0072B2"
USE_STYLES = {
    "no length": {"color": "#777777", "linestyle": "-", "linewidth": 4},
    "row": {"color": "#C86400", "linestyle": "--", "linewidth": 2.0},
    "search": {"color": "#0072B2", "linestyle": "-", "linewidth": 2.0},
}
MILLIMETRES = (10, 20, 30, 50, 100, 200, 300, 500, 1000)  # half heights of the innovations' axis
DEGREES = (0.5, 1, 2, 5, 10, 30, 90, 180)  # of the heading's
KNOWN = 0.15  # [m], sigma above which an innovation tells nothing: its ambiguity was just opened
LEAST_NIS, MOST_NIS = 0.3, 3000.0
NIS_TICKS = (1, 3, 10, 30, 100, 300, 1000)
EPOCHS = (20, 50, 105)  # [%], heights of the axis of shares
SPAN = 120  # [s], of the axis of first fixes
BINS = np.geomspace(LEAST_NIS, MOST_NIS, 61)


def plot_health(result, figure=None):
    """Draw both pictures of a HealthResult side by side; return the Figure."""
    with styled():
        figure = figure if figure is not None else new_figure(860, 560)
        left, right = figure.subfigures(1, 2, width_ratios=(500, 360))
        for build, part in ((build_over_time, left), (build_shares, right)):
            build(part).show(result)
    return figure


def build_over_time(figure):
    """Lay out innovations, NIS, the error of heading and the strip of fixes, one below the other; show(result) fills them in."""
    boxes = ((0.135, 0.745, 0.84, 0.205), (0.135, 0.455, 0.84, 0.225), (0.135, 0.185, 0.84, 0.205), (0.135, 0.085, 0.84, 0.04))
    axes = [figure.add_axes(box) for box in boxes]
    for panel in axes[:3]:
        panel.tick_params(labelbottom=False)
        panel.xaxis.set_major_locator(MaxNLocator(7))
    parts = [kind(panel) for kind, panel in zip((_Innovations, _Nis, _Heading, _Strip), axes, strict=True)]

    def show(result):
        last = float(result.health.seconds[-1])
        for panel in axes:
            panel.set_xlim(-0.01 * last, 1.02 * last)
        return last, *(part.show(result.health) for part in parts)

    return Scene(tuple(artist for part in parts for artist in part.moving), show)


def build_shares(figure):
    """Lay out how often which NIS comes, and the first fixes of many starts; show(result) fills them in."""
    spread = _Spread(figure.add_axes((0.16, 0.615, 0.79, 0.30)))
    starts = _FirstFixes(figure.add_axes((0.16, 0.105, 0.79, 0.325)))

    def show(result):
        starts.show(result.starts)
        return spread.show(result.health)

    return Scene((*spread.moving, *starts.moving), show)


class _Innovations:
    """Carrier innovations of all pairs, faint, and of one with the band in which it should lie."""

    def __init__(self, axes):
        self.axes = axes
        axes.set_ylabel("innovation [mm]", labelpad=1)
        axes.yaxis.set_major_locator(MaxNLocator(5, symmetric=True))
        self.band = axes.add_patch(Polygon([(0.0, 0.0)], facecolor=BAND, alpha=0.55, linewidth=0))
        (self.all,) = axes.plot([], [], color=FAINT, linewidth=0.4)
        (self.one,) = axes.plot([], [], color=CARRIER, linewidth=0.9)
        self.title = axes.text(0.0, 1.04, "", transform=axes.transAxes, fontsize=9.5)

    @property
    def moving(self):
        """The artists that change with every result, lowest first."""
        return (self.band, self.all, self.one, self.title)

    def show(self, health):
        """Fill in the innovations; return half the axis' height [mm]."""
        one, sigma = 1e3 * health.watched, 1e3 * health.watched_sigma
        half = _enough(np.max(np.abs(one[health.watched_sigma < KNOWN]), initial=0.0), 3 * np.median(sigma), MILLIMETRES)
        self.band.set_xy(_outline(health.seconds, np.maximum(-2 * sigma, -2 * half), np.minimum(2 * sigma, 2 * half)))
        self.one.set_data(health.seconds, np.clip(one, -2 * half, 2 * half))
        self.all.set_data(*_one_line(health.seconds, np.clip(1e3 * health.innovation, -2 * half, 2 * half)))
        self.title.set_text(f"carrier innovations: {health.pair} with its 2 sigma, the others faint")
        self.axes.set_ylim(-half, half)
        return half


class _Nis:
    """NIS of carriers and codes, each epoch and in the running mean, with the bounds of both."""

    def __init__(self, axes):
        axes.set(yscale="log", ylim=(LEAST_NIS, MOST_NIS), ylabel="NIS")
        axes.yaxis.set_major_locator(FixedLocator(NIS_TICKS))
        axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axes.yaxis.set_minor_locator(NullLocator())
        self.single = axes.add_patch(Polygon([(0.0, 1.0)], facecolor="#E6E6E6", linewidth=0, label="95 % of epochs"))
        self.mean = axes.add_patch(Polygon([(0.0, 1.0)], facecolor="#B9B9B9", linewidth=0, label="95 % of means"))
        self.dots = [axes.plot([], [], ".", color=color, alpha=0.45, markersize=2, markeredgewidth=0)[0] for color in (CODE, CARRIER)]
        styles = ({"color": CODE, "linestyle": "--", "label": "codes"}, {"color": CARRIER, "linestyle": "-", "label": "carriers"})
        self.means = [axes.plot([], [], linewidth=1.9, **style)[0] for style in styles]
        axes.legend(
            handles=[*self.means[::-1], self.mean, self.single], loc="lower left", bbox_to_anchor=(-0.02, 0.97), ncols=4, fontsize=9.5,
            handlelength=1.6, handletextpad=0.4, columnspacing=0.7,
        )  # fmt: skip

    @property
    def moving(self):
        """The artists that change with every result, lowest first."""
        return (self.single, self.mean, *self.dots, *self.means)

    def show(self, health):
        """Fill in both NIS and their bounds; the frame never changes."""
        self.single.set_xy(_outline(health.seconds, *health.epoch_bounds))
        self.mean.set_xy(_outline(health.seconds, *health.running_bounds))
        for dots, line, nis in zip(self.dots, self.means, (health.nis_code, health.nis_phase), strict=True):
            dots.set_data(health.seconds, _within(nis))
            seconds, mean = health.running(nis)
            line.set_data(seconds, _within(mean))


class _Heading:
    """The error of heading with the band of two sigma around zero."""

    def __init__(self, axes):
        self.axes = axes
        axes.set_ylabel("heading error [deg]", fontsize=9, labelpad=1)
        axes.yaxis.set_major_locator(MaxNLocator(5, symmetric=True))
        self.band = axes.add_patch(Polygon([(0.0, 0.0)], facecolor=BAND, alpha=0.55, linewidth=0))
        (self.inside,) = axes.plot([], [], ".", color=CARRIER, markersize=2.2)
        (self.outside,) = axes.plot([], [], "^", color=WRONG_COLOR, markersize=3.2)
        self.title = axes.text(0.0, 1.04, "", transform=axes.transAxes, fontsize=9.5)

    @property
    def moving(self):
        """The artists that change with every result, lowest first."""
        return (self.band, self.inside, self.outside, self.title)

    def show(self, health):
        """Fill in the errors; return half the axis' height [deg]."""
        error, sigma = health.error[:, 0], health.sigma[:, 0]
        half = _enough(np.quantile(np.abs(error[health.is_settled]), 0.98), 3 * np.median(sigma), DEGREES)
        self.band.set_xy(_outline(health.seconds, -np.minimum(2 * sigma, 2 * half), np.minimum(2 * sigma, 2 * half)))
        is_inside = np.abs(error) < 2 * sigma
        for dots, chosen in ((self.inside, is_inside), (self.outside, ~is_inside)):
            dots.set_data(health.seconds[chosen], np.clip(error[chosen], -0.98 * half, 0.98 * half))
        self.title.set_text(f"heading: {100 * health.inside[0]:.0f} % within its 2 sigma, from 100 s on; outside: triangles")
        self.axes.set_ylim(-half, half)
        return half


class _Strip:
    """Which epochs are float, fixed, held, and wrong."""

    def __init__(self, axes):
        axes.set(ylim=(0, 1), xlabel="seconds since the start")
        axes.grid(False)
        axes.yaxis.set_major_locator(FixedLocator([]))
        axes.xaxis.set_major_locator(MaxNLocator(7))
        styles = (("float", FLOAT_COLOR, None), ("fixed", FIXED_COLOR, None), ("held", HELD_COLOR, None), ("wrong", WRONG_COLOR, "//////"))
        self.parts = [
            axes.add_collection(PolyCollection([], facecolor=color, edgecolor="white", hatch=hatch, linewidths=0, label=label))
            for label, color, hatch in styles
        ]
        axes.legend(
            handles=self.parts, loc="lower left", bbox_to_anchor=(-0.02, 0.7), ncols=4, fontsize=9.5, handlelength=1.2, handletextpad=0.4,
            columnspacing=1.2,
        )  # fmt: skip

    @property
    def moving(self):
        """The artists that change with every result, lowest first."""
        return tuple(self.parts)

    def show(self, health):
        """Fill in the states; the frame never changes."""
        chosen = (np.ones(len(health.seconds), bool), health.is_fixed, health.is_held, health.is_wrong)
        for part, where, (low, high) in zip(self.parts, chosen, ((0, 1), (0, 1), (0, 1), (0, 0.55)), strict=True):
            part.set_verts([[(a, low), (a, high), (b, high), (b, low)] for a, b in _spans(health.seconds, where)])


class _Spread:
    """How often which NIS comes, beside chi-square's promise, and the gate."""

    def __init__(self, axes):
        self.axes = axes
        axes.set(xscale="log", xlim=(LEAST_NIS, MOST_NIS), xlabel="NIS of one epoch", ylabel="epochs [%]")
        axes.xaxis.set_major_locator(FixedLocator(NIS_TICKS))
        axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axes.xaxis.set_minor_locator(NullLocator())
        self.carrier = axes.add_collection(PolyCollection([], facecolor=CARRIER, alpha=0.55, linewidths=0, label="carriers"))
        (self.code,) = axes.plot([], [], color=CODE, linestyle="--", linewidth=1.6, label="codes")
        (self.promised,) = axes.plot([], [], color=DARK, linewidth=1.3, label="promised")
        (self.gate,) = axes.plot([], [], ":", color=DARK, linewidth=1.6, label="gate, 99.9 %")
        axes.legend(
            handles=[self.carrier, self.code, self.promised, self.gate], loc="lower left", bbox_to_anchor=(-0.14, 1.0), ncols=2, fontsize=9.5,
            handlelength=2.0, columnspacing=1.2, labelspacing=0.25,
        )  # fmt: skip

    @property
    def moving(self):
        """The artists that change with every result, lowest first."""
        return (self.carrier, self.code, self.promised, self.gate)

    def show(self, health):
        """Fill in the shares of the settled epochs; return the axis' height [%]."""
        settled = health.is_settled
        carrier, code = (_histogram(nis[settled]) for nis in (health.nis_phase, health.nis_code))
        self.carrier.set_verts([np.column_stack([np.repeat(BINS, 2), np.concatenate([[0], np.repeat(carrier, 2), [0]])])])
        self.code.set_data(np.repeat(BINS, 2), np.concatenate([[0], np.repeat(code, 2), [0]]))
        self.promised.set_data(np.sqrt(BINS[1:] * BINS[:-1]), 100 * health.promised(BINS))
        top = _enough(carrier.max(), code.max(), EPOCHS)
        self.gate.set_data([health.mean(health.gate)] * 2, [0, top])
        self.axes.set_ylim(0, top)
        return top


class _FirstFixes:
    """The share of many starts that are fixed, against the seconds since each."""

    def __init__(self, axes):
        axes.set(xlim=(0, SPAN), ylim=(0, 103), xlabel="seconds since a cold start", ylabel="fixed by then [%]")
        axes.yaxis.labelpad = 1
        self.lines = [axes.plot([], [], label=name, **style)[0] for name, style in USE_STYLES.items()]
        self.wrong = [axes.plot([], [], "x", color=style["color"], markersize=7, markeredgewidth=2)[0] for style in USE_STYLES.values()]
        self.words = axes.text(0.5, 0.5, "", transform=axes.transAxes, ha="center", va="center", fontsize=9.5)
        axes.set_title("first fixes, by use of the length", fontsize=10, loc="left", pad=20)
        axes.legend(
            handles=self.lines, loc="lower left", bbox_to_anchor=(-0.14, 0.98), ncols=3, fontsize=9.5, handlelength=2.2, columnspacing=1.2,
        )  # fmt: skip

    @property
    def moving(self):
        """The artists that change with every result, lowest first."""
        return (*self.lines, *self.wrong, self.words)

    def show(self, starts):
        """Fill in the starts, or say how to get them; a cross is a first fix that was wrong."""
        self.words.set_text('switch "Many starts" on:\ntwenty starts, about a second' if starts is None else "")
        for k, (line, wrong) in enumerate(zip(self.lines, self.wrong, strict=True)):
            first, is_wrong = (starts.first[k], starts.is_wrong[k]) if starts is not None else (np.zeros(0, int), np.zeros(0, bool))
            order = np.argsort(first[first >= 0], kind="stable")
            seconds, share = first[first >= 0][order], 100 * (1 + np.arange(len(order))) / len(first)
            line.set_data(*_staircase(seconds, share) if starts is not None else ((), ()))
            bad = is_wrong[first >= 0][order]
            wrong.set_data(seconds[bad], share[bad])


def describe_health(result):
    """Return the pictures in words, for those who cannot see them."""
    health = result.health
    low, high = health.mean_bounds
    words = (
        f"Of {len(health.seconds)} epochs: carrier innovations with the band they should lie in, {health.pair} before the others. "
        f"Their NIS, {health.mean(health.nis_phase):.1f} in the mean where {low:.1f} to {high:.1f} is right, and that of the codes, "
        f"{health.mean(health.nis_code):.1f}. The error of heading, {100 * health.inside[0]:.1f} % of it within two sigma where "
        f"95.4 % is promised. {100 * health.share(health.is_fixed):.1f} % of the epochs are fixed, "
        f"{100 * health.share(health.is_held):.1f} % held, {100 * health.share(health.is_wrong):.1f} % wrong, counted from 100 s on. "
        f"Beside it, how often which NIS comes: a gate at 99.9 % would reject {health.rejected(health.nis_phase)} epochs by their carriers "
        f"and {health.rejected(health.nis_code)} by their codes."
    )
    return words if result.starts is None else f"{words} {_starts_in_words(result.starts)}"


def _starts_in_words(starts):
    found = (
        f"{name}: {np.sum((first >= 0) & (first <= 10))} fixed within 10 s, {np.sum(first >= 0)} within {SPAN} s, {is_wrong.sum()} wrong"
        for name, first, is_wrong in zip(starts.uses, starts.first, starts.is_wrong, strict=True)
    )
    return f"Of {starts.first.shape[1]} cold starts, by use of the length: {'; '.join(found)}."


def _enough(least, wanted, steps):
    """Return the first of the steps that holds both numbers, or the last one."""
    return next((step for step in steps if step >= max(least, wanted)), steps[-1])


def _within(nis):
    return np.clip(nis, LEAST_NIS, MOST_NIS)


def _outline(x, low, high):
    return np.column_stack([np.concatenate([x, x[::-1]]), np.concatenate([low, high[::-1]])])


def _one_line(x, values):
    """Return the coordinates of one line that runs through all columns of values (T, d), with a break between them."""
    broken = np.vstack([values, np.full(values.shape[1], np.nan)])
    return np.tile(np.append(x, np.nan), values.shape[1]), broken.T.ravel()


def _spans(seconds, chosen):
    """Return the (start, end) [s] of each run of chosen epochs, an epoch wide at least."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], chosen, [False]]).astype(int)))
    step = float(np.median(np.diff(seconds)))
    return [(seconds[a] - step / 2, seconds[b - 1] + step / 2) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def _histogram(nis):
    """Return the shares [%] of epochs in BINS, what is beyond in the last ones."""
    return 100 * np.histogram(np.clip(nis, BINS[0], 0.999 * BINS[-1]), BINS)[0] / len(nis)


def _staircase(seconds, share):
    """Return the corners of a cumulative share from 0 s to the end of the span."""
    x = np.concatenate([[0], np.repeat(seconds, 2), [SPAN]])
    y = np.concatenate([[0, 0], np.repeat(share, 2)]) if len(share) else np.zeros(2)
    return x, y
