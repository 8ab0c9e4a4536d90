"""Picture of a monitored series: east, north and up against time, with what the filter made of each epoch."""

from typing import NamedTuple

import numpy as np
from matplotlib.dates import AutoDateLocator, ConciseDateFormatter, date2num

from gnsslab.figures.kept import new_figure, styled
from gnsslab.systems.monitoring import Flag

DRAWN_ONE_BY_ONE = 20_000  # epochs; more cover each other and take long to draw
STRETCHES = 1500  # of a longer series, each drawn from its lowest to its highest value: a panel is some 1500 pixels wide on a projector
LABEL_ROOM = 0.14  # of the width of a panel: sizes nearer to each other would overlap
ROOM = 0.08  # of the height of a panel, above and below
RAW = {"color": "#8A94A0", "marker": ".", "markersize": 3.2, "linestyle": "", "label": "epochs"}
RANGE = {"color": "#8A94A0", "alpha": 0.6, "linewidth": 0.5, "label": "epochs, lowest to highest"}
OUTLIER = {"color": "#D55E00", "marker": "x", "markersize": 6, "markeredgewidth": 1.6, "linestyle": "", "label": "outlier"}
BEYOND = {"color": "#D55E00", "markersize": 6, "linestyle": ""}
LEVEL = {"color": "#0072B2", "linewidth": 1.8, "label": "filtered"}
BAND = {"color": "#56B4E9", "alpha": 0.45, "linewidth": 0, "label": "1 sigma"}
STEP = {"color": "#111111", "linestyle": (0, (5, 3)), "linewidth": 1.4}
SMALL_STEP = {"color": "#111111", "linestyle": (0, (2, 4)), "linewidth": 0.7, "alpha": 0.7}
PATCH = {"facecolor": "white", "edgecolor": "none", "alpha": 0.85, "pad": 1}  # behind a size, where lines of smaller steps pass
ALARM = {"facecolor": "#F0E442", "edgecolor": "#A03070", "hatch": "////", "linewidth": 0.8, "label": "alarm"}


class Scale(NamedTuple):
    """The unit of a panel."""

    name: str
    metres: float


def plot_monitored(monitored):
    """Draw east, north and up of a Monitored series: epochs, outliers, filtered line with its sigma, steps with their sizes, alarms.

    A series of more than 20 000 epochs is drawn from the lowest to the highest value in each of 1500 stretches, and the picture says so.
    Outliers beyond the frame stand as triangles at its edge.
    """
    with styled():
        figure = new_figure(960, 700)
        panels = figure.subplots(3, 1, sharex=True, gridspec_kw={"left": 0.09, "right": 0.98, "bottom": 0.09, "top": 0.9, "hspace": 0.1})
        days = date2num(monitored.time)
        for axis, (panel, name) in enumerate(zip(panels, ("east", "north", "up"), strict=True)):
            _panel(panel, days, monitored, axis, name)
        _time_axis(panels[-1])
        _legend(figure, panels)
        _say_thinned(figure, len(days))
    return figure


def stretch_of(T):
    """Return the number of the stretch of each of T epochs, 0 and up: every epoch its own where they are drawn one by one."""
    return np.arange(T) if T <= DRAWN_ONE_BY_ONE else np.arange(T) * STRETCHES // T


def lowest_and_highest(values):
    """Return the lowest and the highest value in each stretch, NaN where it has none, and the first index of each stretch.

    >>> lowest_and_highest(np.tile([0.0, 3.0, np.nan, -1.0], 7500))[1][:3].tolist()
    [3.0, 3.0, 3.0]
    """
    begin = np.flatnonzero(np.diff(stretch_of(len(values)), prepend=-1))
    if not len(begin):
        return values, values, begin
    return np.fmin.reduceat(values, begin), np.fmax.reduceat(values, begin), begin


def _panel(panel, days, monitored, axis, name):
    value, level, sigma = monitored.enu[:, axis], monitored.level[:, axis], monitored.sigma[:, axis]
    is_outlier = monitored.flag == Flag.OUTLIER
    low, high = _limits(value[~is_outlier], level)
    scale = _scale(high - low)
    panel.set_ylabel(f"{name} [{scale.name}]")
    panel.set_ylim(low / scale.metres, high / scale.metres)
    _dots(panel, days[~is_outlier], value[~is_outlier] / scale.metres)
    _line(panel, days, level / scale.metres, sigma / scale.metres)
    _outliers(panel, days[is_outlier], value[is_outlier] / scale.metres)
    _steps(panel, days, monitored.steps, axis, scale)
    _alarms(panel, days, monitored.alarm)


def _limits(value, level):
    """Return the lowest and highest [m] of all that must be seen, with some room; outliers need not be."""
    shown = np.concatenate([value[np.isfinite(value)], level[np.isfinite(level)]])
    low, high = (float(shown.min()), float(shown.max())) if len(shown) else (0.0, 0.0)
    room = ROOM * max(high - low, 0.001)
    return low - room, high + 2 * room  # above stand the sizes of steps


def _scale(height):
    return Scale("mm", 1e-3) if height < 0.2 else Scale("cm", 1e-2) if height < 5 else Scale("m", 1.0)


def _dots(panel, days, value):
    if len(days) <= DRAWN_ONE_BY_ONE:
        panel.plot(days, value, **RAW)
        return
    low, high, begin = lowest_and_highest(value)
    panel.fill_between(days[begin], low, high, **RANGE)


def _line(panel, days, level, sigma):
    """Draw the filtered line, of a long series up and down between its lowest and highest values, and the band about it."""
    low, high, begin = lowest_and_highest(level)
    panel.fill_between(days[begin], low - sigma[begin], high + sigma[begin], **BAND)
    if len(begin) == len(level):
        panel.plot(days, level, **LEVEL)
    else:
        panel.plot(np.repeat(days[begin], 2), np.stack([low, high], axis=-1).ravel(), **LEVEL | {"linewidth": 0.8})


def _outliers(panel, days, value):
    low, high = panel.get_ylim()
    for within, marker, place in ((value > high, "^", 0.97), (value < low, "v", 0.03)):
        edge = _one_a_pixel(days[within])
        panel.plot(edge, np.full(len(edge), place), transform=panel.get_xaxis_transform(), marker=marker, **BEYOND)
    inside = (value >= low) & (value <= high)
    panel.plot(days[inside], value[inside], **OUTLIER if len(value) else OUTLIER | {"label": None})


def _one_a_pixel(days):
    """Return some of increasing days, at most one a pixel of a panel."""
    return days if len(days) < 2 else days[np.unique(((days - days[0]) / (days[-1] - days[0]) * STRETCHES).astype(int), return_index=True)[1]]


def _steps(panel, days, steps, axis, scale):
    """Draw a line at each step; the largest that do not crowd each other are bold and carry their size."""
    labelled = labelled_steps(steps, days)
    for step in steps:
        if step not in labelled:
            panel.axvline(days[step.first], **SMALL_STEP)
    for k, step in enumerate(labelled):
        panel.axvline(days[step.first], label="step" if k == 0 else None, **STEP)
        late = days[step.first] > days[0] + (1 - LABEL_ROOM) * (days[-1] - days[0])
        place = {"x": days[step.first], "y": 0.97, "ha": "right" if late else "left", "va": "top", "fontsize": 10, "fontweight": "bold"}
        panel.text(bbox=PATCH, s=f" {step.size[axis] / scale.metres:+.1f} {scale.name} ", transform=panel.get_xaxis_transform(), **place)


def labelled_steps(steps, days):
    """Return the largest steps that stand far enough from each other for their sizes to be written; the largest first."""
    chosen, room = [], LABEL_ROOM * (days[-1] - days[0])
    for step in sorted(steps, key=lambda step: -np.linalg.norm(step.size)):
        if all(abs(days[step.first] - days[other.first]) >= room for other in chosen):
            chosen.append(step)
    return chosen


def _alarms(panel, days, alarm):
    """Draw a hatched strip at the foot of the panel wherever there is an alarm."""
    begin, end = alarm_spans(alarm)
    spans = [(days[a], days[b] - days[a]) for a, b in zip(begin, end, strict=True)]
    if spans:
        low, high = panel.get_ylim()
        panel.broken_barh(spans, (low, 0.04 * (high - low)), **ALARM)


def alarm_spans(alarm):
    """Return first and last index of each run of alarms (T,) bool.

    >>> [ends.tolist() for ends in alarm_spans(np.array([False, True, True, False, True]))]
    [[1, 4], [2, 4]]
    """
    edges = np.diff(np.concatenate([[0], np.asarray(alarm, dtype=int), [0]]))
    return np.flatnonzero(edges == 1), np.flatnonzero(edges == -1) - 1


def _time_axis(panel):
    locator = AutoDateLocator(minticks=4, maxticks=9)
    panel.xaxis.set_major_locator(locator)
    panel.xaxis.set_major_formatter(ConciseDateFormatter(locator))
    panel.set_xlabel("GPS time")


def _legend(figure, panels):
    shown = {}
    for panel in panels:
        for artist, label in zip(*panel.get_legend_handles_labels(), strict=True):
            shown.setdefault(label, artist)
    figure.legend(shown.values(), shown.keys(), loc="upper right", ncols=6, fontsize=10, bbox_to_anchor=(0.99, 0.995))


def _say_thinned(figure, T):
    if T > DRAWN_ONE_BY_ONE:
        words = f"{T} epochs, drawn from the lowest to the highest value in each of {STRETCHES} stretches"
        figure.text(0.09, 0.915, words, fontsize=9, ha="left", va="bottom", color="#444444")
