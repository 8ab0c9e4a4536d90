"""Pictures of an alarm above a village: what it saw and when it went off, and false alarms against lag for all kinds of alarm."""

import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.patches import Patch
from matplotlib.ticker import FixedLocator, FuncFormatter, MaxNLocator, MultipleLocator, NullLocator

from gnsslab.figures.kept import Scene, new_figure, styled

CM = 1e-2
RAW = {"color": "#8C8C8C", "marker": "o", "linestyle": "", "markeredgewidth": 0, "label": "solutions"}
BEYOND = {"color": "#D55E00", "marker": "^", "linestyle": "", "markersize": 5, "markeredgewidth": 0, "label": "further out"}
OUTLIER = {"color": "#D98200", "marker": "x", "linestyle": "", "markersize": 5, "markeredgewidth": 1.4, "label": "not believed"}
LINE = {"color": "#0072B2", "linewidth": 1.5, "label": "alarm's line"}
BAND = {"facecolor": "#56B4E9", "alpha": 0.45, "edgecolor": "none", "label": "2 sigma"}
TRUTH = {"color": "#111111", "linewidth": 1.5, "label": "truth"}
THRESHOLD = {"color": "#A03070", "linewidth": 1.5, "linestyle": "--", "label": "threshold"}
MOVED = {"color": "#111111", "linewidth": 1.4, "linestyle": ":", "label": "it moves"}
KNOWN = {"color": "#009E73", "linewidth": 1.8, "linestyle": (0, (4, 2)), "label": "you know"}
FALSE_ALARM = {"facecolor": "#F6C3A4", "edgecolor": "#D55E00", "hatch": "xxxx", "linewidth": 1.0, "label": "false alarm"}
RIGHT_ALARM = {"facecolor": "#B5E3D3", "edgecolor": "#009E73", "hatch": "////", "linewidth": 1.0, "label": "alarm"}
ABOUT = (-40, 120)  # epochs in the lower panel, about the motion
STRIP = 0.07  # of the height of a panel, for alarms
EDGE = 0.96  # of the height of a panel: where what is further out stands
ROOM = 1.3  # times what must be seen
SMALLEST = 4.0  # [cm] the least height of a panel
NARROWEST = 1 / 250  # of the width of a panel: an alarm of one epoch can be seen

KIND_MARKS = {"raw": ("o", "#6E6E6E", ":"), "average": ("s", "#D98200", "--"), "joint": ("^", "#A03070", "-."), "monitor": ("D", "#0072B2", "-")}
MOST_FALSE, MISSED, LATEST = 110.0, 4000.0, 1500.0  # a day; where what was missed stands; lags that are drawn [min]
FALSE_TICKS, LAG_TICKS = (0, 1, 3, 10, 30, 100), (0, 1, 3, 10, 30, 100, 300, 1000)


def plot_slope_alarm(result, figure=None):
    """Draw both pictures of an AlarmResult side by side; return the Figure."""
    with styled():
        figure = figure if figure is not None else new_figure(820, 470)
        left, right = figure.subfigures(1, 2, width_ratios=(450, 370))
        for build, part in ((build_slope, left), (build_trade_off, right)):
            build(part).show(result)
    return figure


def build_slope(figure):
    """Lay out the whole series and the time about the motion; show(result) fills in solutions, the line, the truth and alarms."""
    whole, near = _Panel(figure.add_axes((0.115, 0.53, 0.855, 0.315)), 1.6), _Panel(figure.add_axes((0.115, 0.09, 0.855, 0.35)), 3.2)
    handles = [whole.raw, whole.outlier, whole.beyond, whole.line, Patch(**BAND), whole.truth, whole.threshold, whole.moved, whole.known,
               Patch(**FALSE_ALARM), Patch(**RIGHT_ALARM)]  # fmt: skip
    figure.legend(handles=handles, loc="upper center", ncols=4, bbox_to_anchor=(0.53, 1.005), fontsize=9, markerscale=1.6, handlelength=1.7,
                  columnspacing=1.1, labelspacing=0.2, handletextpad=0.5)  # fmt: skip

    def show(result):
        high = _height(result)
        whole.show(result, result.x, slice(None), high)
        part, x, label = _about(result)
        near.show(result, x, part, high)
        whole.axes.set_xlabel(f"{result.clock.long}, all {len(result.x)} epochs", labelpad=1)
        near.axes.set_xlabel(label, labelpad=1)
        whole.axes.set_xlim(0, result.x[-1])
        near.axes.set_xlim(x[0], x[-1])
        whole.axes.xaxis.set_major_locator(MultipleLocator(3) if 12 <= result.x[-1] <= 30 else MaxNLocator(8))
        return high, label, len(x), float(result.x[-1]), float(x[0]), float(x[-1])

    return Scene((*whole.moving, *near.moving), show)


class _Panel:
    """Distance from the reference over time [cm], and alarms at the foot."""

    def __init__(self, axes, dot):
        self.axes = axes
        axes.set_ylabel("moved on the level [cm]", labelpad=2, fontsize=9.5)
        axes.yaxis.set_major_locator(MaxNLocator(6, integer=True))
        self.band = axes.add_collection(PolyCollection([], **BAND))
        (self.raw,) = axes.plot([], [], markersize=dot, **RAW)
        (self.outlier,) = axes.plot([], [], **OUTLIER)
        (self.beyond,) = axes.plot([], [], **BEYOND)
        (self.truth,) = axes.plot([], [], drawstyle="steps-post", **TRUTH)
        (self.line,) = axes.plot([], [], **LINE)
        (self.threshold,) = axes.plot([], [], **THRESHOLD)
        (self.moved,) = axes.plot([], [], **MOVED)
        (self.known,) = axes.plot([], [], **KNOWN)
        self.strips = [axes.add_collection(PolyCollection([], **style)) for style in (FALSE_ALARM, RIGHT_ALARM)]

    @property
    def moving(self):
        """The artists that change with every result, lowest first."""
        return (self.band, self.raw, self.outlier, self.truth, self.threshold, self.moved, self.line, self.known, *self.strips, self.beyond)

    def show(self, result, x, part, high):
        """Fill in the epochs of a part, x their times, up to `high` [cm]."""
        self.axes.set_ylim(-STRIP * high, high)
        raw, line, sigma = (values[part] / CM for values in (result.raw, result.line.distance, result.line.sigma))
        is_outlier = result.line.is_outlier[part]
        self.raw.set_data(x[~is_outlier], raw[~is_outlier])
        self.outlier.set_data(x[is_outlier], raw[is_outlier])
        self.line.set_data(*((x, line) if result.settings["alarm"] != "raw" else ([], [])))
        self.truth.set_data(x, result.truth[part] / CM)
        self.threshold.set_data([x[0], x[-1]], [result.settings["threshold"]] * 2)
        self.band.set_verts(_band(x, line, sigma))
        for artist, epoch in ((self.moved, result.at), (self.known, result.known)):
            place = _place(result, x, part, epoch)
            artist.set_data([place] * 2 if place is not None else [], [0, high] if place is not None else [])
        for strip, is_alarm in zip(self.strips, _alarms(result), strict=True):
            strip.set_verts(_strips(x, is_alarm[part], high))
        beyond = x[raw > high]
        self.beyond.set_data(beyond, np.full(len(beyond), EDGE * high))


def _height(result):
    """Return the height [cm] of the panels: all but solutions far off can be seen."""
    line = 0.0 if result.settings["alarm"] == "raw" else result.line.distance.max() / CM
    truth = result.truth.max() / CM if np.isfinite(result.truth).any() else np.percentile(result.raw, 99.5) / CM
    shown = max(line, truth, np.percentile(result.raw, 98) / CM)
    return float(np.ceil(ROOM * max(SMALLEST, result.settings["threshold"], shown)))


def _about(result):
    """Return the epochs of the lower panel, their times, and its label: about the motion, else about the first false alarm or the middle."""
    T, alarms = len(result.x), np.flatnonzero(result.alarm)
    centre, what = (result.at, "the motion") if result.at is not None else (alarms[0], "the alarm") if len(alarms) else (T // 2, "the middle")
    first, last = max(centre + ABOUT[0], 0), min(centre + max(ABOUT[1], _to_known(result)), T - 1)
    part = slice(first, last + 1)
    scale = result.clock.long_seconds / result.clock.short_seconds
    return part, scale * (result.x[part] - result.x[centre]), f"{_spelt(result.clock.short)} from {what} on"


def _to_known(result):
    """Return how many epochs to show for the alarm to be in the panel, as far as that makes sense."""
    epochs = 0 if result.known is None else result.known - result.at
    return int(1.2 * epochs) if epochs < 10 * ABOUT[1] else 0


def _spelt(unit):
    return {"min": "minutes"}.get(unit, unit)


def _place(result, x, part, epoch):
    """Return where an epoch stands in a panel; None where it is not in it."""
    if epoch is None or not part.indices(len(result.x))[0] <= epoch < part.indices(len(result.x))[1]:
        return None
    return x[epoch - part.indices(len(result.x))[0]]


def _band(x, line, sigma):
    """Return the polygon two sigma about the line; none where the method tells no sigma."""
    known = np.isfinite(sigma) & np.isfinite(line)
    if not known.any():
        return []
    x, low, high = x[known], np.maximum(line - 2 * sigma, 0.0)[known], (line + 2 * sigma)[known]
    return [np.column_stack([np.concatenate([x, x[::-1]]), np.concatenate([low, high[::-1]])])]


def _alarms(result):
    """Return false and right alarms (T,): right ones from the motion on."""
    after = np.arange(len(result.x)) >= (result.at if result.at is not None else len(result.x))
    return result.alarm & ~after, result.alarm & after


def _strips(x, is_alarm, high):
    """Return a rectangle at the foot for each stretch of alarms."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], is_alarm.astype(int), [0]])))
    low, least = -STRIP * high, NARROWEST * (x[-1] - x[0])
    spans = [(x[a], max(x[b - 1], x[a] + least)) for a, b in edges.reshape(-1, 2)]
    return [[(a, low), (b, low), (b, 0), (a, 0)] for a, b in spans]


def build_trade_off(figure):
    """Lay out false alarms against lag; show(result) fills in a curve for each kind of alarm, and where the student stands on his."""
    axes = figure.add_axes((0.195, 0.115, 0.775, 0.70))
    curves = {name: axes.plot([], [], marker=mark, color=color, linestyle=dash, markersize=5, linewidth=1.3)[0]
              for name, (mark, color, dash) in KIND_MARKS.items()}  # fmt: skip
    (here,) = axes.plot([], [], "o", markersize=15, markerfacecolor="none", markeredgecolor="#111111", markeredgewidth=2.2, clip_on=False)
    corner = axes.text(0.02, 0.02, "", transform=axes.transAxes, fontsize=9, color="#00704F", fontweight="bold", va="bottom")
    axes.set_xscale("symlog", linthresh=1, linscale=0.5)
    axes.xaxis.set_major_locator(FixedLocator(FALSE_TICKS))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.set_xlim(-0.35, MOST_FALSE)
    legend = figure.legend(handles=[*curves.values(), here], labels=["raw solutions", "moving average", "paper's joint filter", "monitor", "you"],
                           loc="upper left", ncols=2, bbox_to_anchor=(0.08, 1.005), fontsize=9, handlelength=2.4, columnspacing=1.2,
                           labelspacing=0.3, markerscale=0.9)  # fmt: skip
    legend.legend_handles[-1].set_markersize(10)

    def show(result):
        for name, curve in curves.items():
            found = result.curves[name]
            curve.set_data(np.minimum(found.false / result.periods, MOST_FALSE), _heights(result, found))
        here.set_data(*_where(result))
        corner.set_text("quiet and quick" if result.at is not None else "quiet and watchful")
        return _label(axes, result)

    return Scene((*curves.values(), here, corner), show)


def _heights(result, curve):
    """Return what the curve is drawn against (n,): lags, or thresholds where nothing moves."""
    if result.at is None:
        return result.thresholds
    return np.where(np.isfinite(curve.lag), np.minimum(curve.lag, LATEST), MISSED)


def _where(result):
    """Return where the student stands."""
    height = result.settings["threshold"] if result.at is None else min(result.lag, LATEST) if result.known is not None else MISSED
    return [min(result.false / result.periods, MOST_FALSE)], [height]


def _label(axes, result):
    """Label the axes for a series in which something moves, or nothing does; return what is the frame."""
    axes.set_xlabel(f"false alarms a {result.clock.per}, nothing moving", labelpad=2)
    if result.at is None:
        axes.set_yscale("linear")
        axes.set_ylim(0, 15.6)
        axes.yaxis.set_major_locator(MultipleLocator(3))
        axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axes.set_ylabel("threshold [cm]", labelpad=2)
    else:
        axes.set_yscale("symlog", linthresh=1, linscale=0.5)
        axes.set_ylim(-1.0, 1.6 * MISSED)
        axes.yaxis.set_major_locator(FixedLocator((*LAG_TICKS, MISSED)))
        axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: "missed" if value == MISSED else f"{value:g}"))
        axes.set_ylabel(f"lag [{result.clock.short}]", labelpad=0)
    axes.yaxis.set_minor_locator(NullLocator())
    return result.clock.per, result.at is None


def describe_slope_alarm(result):
    """Return the pictures in words, for those who cannot see them."""
    kind = result.curve.label
    moves = "nothing moves" if result.at is None else f"the ground moves after {result.x[result.at]:.4g} {result.clock.long}"
    known = "" if result.at is None else f" The alarm {_known_words(result)}."
    others = ", ".join(f"{curve.label} {_best_words(result, curve)}" for curve in result.curves.values())
    return (
        f"Distance from the reference over {len(result.x)} epochs, {moves}. The alarm looks at the {kind}, its threshold is "
        f"{result.settings['threshold']:g} cm.{known} False alarms in all the time without motion: {result.false}. "
        f"At their best without a false alarm: {others}."
    )


def _known_words(result):
    return "never goes off after it" if result.known is None else f"goes off {result.lag:.4g} {result.clock.short} later"


def _best_words(result, curve):
    """Return how good a kind is at thresholds that give no false alarm."""
    quiet = curve.false == 0
    if result.at is None:
        return f"from a threshold of {result.thresholds[quiet][0]:g} cm on" if quiet.any() else "has none"
    lags = curve.lag[quiet & np.isfinite(curve.lag)]
    return f"after {lags.min():.4g} {result.clock.short}" if len(lags) else "misses it"
