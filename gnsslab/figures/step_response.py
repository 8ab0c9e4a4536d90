"""Pictures of how filters follow a step: the series about it, the share of it that has come through, and the lag at steps of all sizes."""

import numpy as np

from gnsslab.figures.kept import Scene, new_figure, styled

RAW_COLOR, SHOWN_COLOR, BESIDE_COLOR, TRUTH_COLOR, REJECTED_COLOR = "#8C8C8C", "#0072B2", "#D98200", "#111111", "#A03070"
NEAR = (-40, 160)  # epochs since the step
MARGIN = 7.0  # [cm] above and below all that is true
ANSWER = (-10, 160)  # epochs since the step
LATEST = 125  # epochs, later ones are drawn here
LAG_TICKS = (0, 1, 5, 10, 20, 50, 100)
SHARES = (50, 90, 99)  # [%]
SHOWN = {"color": SHOWN_COLOR, "linewidth": 2.0}
FINE = 0.8  # lines of thousands of epochs
BESIDE = {"color": BESIDE_COLOR, "linewidth": 2.0, "linestyle": (0, (4, 1.6))}


def plot_step_response(result, figure=None):
    """Draw both pictures of a StepResult side by side; return the Figure."""
    with styled():
        figure = figure if figure is not None else new_figure(820, 470)
        left, right = figure.subfigures(1, 2, width_ratios=(450, 370))
        for build, part in ((build_series, left), (build_response, right)):
            build(part).show(result)
    return figure


def build_series(figure):
    """Lay out the series about the step; show(result) fills in solutions, truth and both filters."""
    series = _Series(figure.add_axes((0.115, 0.105, 0.86, 0.755)))
    handles = [series.raw, series.truth, series.rejected, series.shown, series.beside, series.found]  # the fourth and fifth get their filters' names
    legend = figure.legend(handles=handles, loc="upper left", ncols=2, bbox_to_anchor=(0.09, 1.005), fontsize=9.5, handlelength=2.2,
                           columnspacing=1.6, labelspacing=0.25)  # fmt: skip

    def show(result):
        for line, track in ((3, result.shown), (4, result.beside)):
            legend.get_texts()[line].set_text(track.label)
        return series.show(result), result.shown.label, result.beside.label

    return Scene(series.moving, show)


class _Series:
    """What is looked at over time [cm], counted from where the point was."""

    def __init__(self, axes):
        self.axes = axes
        (self.every,) = axes.plot([], [], color="#BBBBBB", linewidth=0.6)
        (self.raw,) = axes.plot([], [], "o", color=RAW_COLOR, markersize=4, markeredgewidth=0, label="raw solutions")
        (self.rejected,) = axes.plot([], [], "x", color=REJECTED_COLOR, markersize=7, markeredgewidth=1.7, label="rejected")
        (self.beside,) = axes.plot([], [], **BESIDE, label="beside it")
        (self.shown,) = axes.plot([], [], **SHOWN, label="filter")
        (self.truth,) = axes.plot([], [], color=TRUTH_COLOR, linewidth=1.4, drawstyle="steps-post", label="truth")
        (self.found,) = axes.plot([], [], "v", color=TRUTH_COLOR, markersize=9, markeredgecolor="white", label="step found")
        self.outside = axes.text(0.995, 0.99, "", transform=axes.transAxes, fontsize=9, color="#444444", ha="right", va="top")
        self.outside.set_bbox({"facecolor": "white", "alpha": 0.8, "edgecolor": "none", "pad": 1})

    @property
    def moving(self):
        """The artists that change with every result, lowest first."""
        return self.every, self.raw, self.rejected, self.beside, self.shown, self.truth, self.found, self.outside

    def show(self, result):
        """Fill in all epochs, or those near the step; return what the axes say."""
        is_near = result.settings["view"] == "near"
        limits = NEAR if is_near else (result.epochs[0], result.epochs[-1])
        part = (result.epochs >= limits[0]) & (result.epochs <= limits[1])
        x, raw, low, high = result.epochs[part], result.raw[part], -MARGIN, MARGIN + max(result.size, 0.0)
        self.raw.set_data(*((x, raw) if is_near else ([], [])))
        self.every.set_data(*(([], []) if is_near else (x, raw)))
        for line, values in ((self.truth, result.truth), (self.shown, result.shown.drawn), (self.beside, result.beside.drawn)):
            line.set_data(x, values[part])
        for line in (self.shown, self.beside):
            line.set_linewidth(SHOWN["linewidth"] if is_near else FINE)
        is_rejected = result.shown.is_rejected[part] if is_near and result.shown.is_rejected is not None else np.zeros(len(x), dtype=bool)
        self.rejected.set_data(x[is_rejected], raw[is_rejected])
        self._mark_found(result, is_near)
        beyond = int(np.sum((raw < low) | (raw > high)))
        self.outside.set_text(f"{beyond} raw further out" if beyond else "")
        return self._label(result, limits, (low, high))

    def _mark_found(self, result, is_near):
        """Mark on each line the epoch at which its filter knew of the step."""
        places = [(track.found, track.drawn) for track in (result.shown, result.beside) if is_near and np.isfinite(track.found)]
        first = result.epochs[0]
        self.found.set_data([found for found, _ in places], [line[int(found) - first] for found, line in places])

    def _label(self, result, limits, heights):
        looked_at = "length - 120 cm [cm]" if result.settings["seen"] == "length" else "position along the step [cm]"
        self.axes.set_xlim(*limits)
        self.axes.set_ylim(*heights)
        self.axes.set_xlabel(f"epochs since the step{'' if result.settings['view'] == 'near' else ', all of them'}", labelpad=1)
        self.axes.set_ylabel(looked_at, labelpad=1)
        return *limits, *heights, looked_at


def build_response(figure):
    """Lay out the share of the step over time, and the lag over its size; show(result) fills in both filters."""
    answer, sizes = _Answer(figure.add_axes((0.15, 0.585, 0.82, 0.36))), _Sizes(figure.add_axes((0.15, 0.105, 0.82, 0.335)))

    def show(result):
        answer.show(result)
        return sizes.show(result)

    return Scene((*answer.moving, *sizes.moving), show)


class _Answer:
    """The share of the step that is in the level [%], over epochs."""

    def __init__(self, axes):
        axes.set_xlim(*ANSWER)
        axes.set_ylim(-12, 128)
        axes.set_yticks((0, *SHARES[:2], 100), ["0", "50", "90", "100"], fontsize=9)
        axes.set_xlabel("epochs since the step", labelpad=1)
        axes.set_ylabel("of the step [%]", labelpad=1)
        (self.raw,) = axes.plot([], [], color=TRUTH_COLOR, linewidth=1.2, drawstyle="steps-post")
        (self.beside,) = axes.plot([], [], **BESIDE)
        (self.shown,) = axes.plot([], [], **SHOWN)
        (self.reached,) = axes.plot([], [], "o", color="white", markeredgecolor=SHOWN_COLOR, markeredgewidth=1.8, markersize=6)
        place = {"transform": axes.transAxes, "fontsize": 9.5, "ha": "right", "va": "center"}
        self.title = axes.text(0.99, 0.44, "", color="#444444", **place)
        self.words = [axes.text(0.99, height, "", color=color, **place) for height, color in ((0.33, SHOWN_COLOR), (0.22, "#A06000"))]

    @property
    def moving(self):
        """The artists that change with every result, lowest first."""
        return self.raw, self.beside, self.shown, self.reached, self.title, *self.words

    def show(self, result):
        """Fill in both responses, the solutions' own, and what is read off them."""
        part = (result.about >= ANSWER[0]) & (result.about <= ANSWER[1])
        x, lasts = result.about[part], result.settings["lasts"] or np.inf
        self.raw.set_data(x, 100.0 * ((x >= 0) & (x < lasts)))
        for line, track in ((self.shown, result.shown), (self.beside, result.beside)):
            line.set_data(x, 100 * track.response[part])
        reached = [(late, share) for late, share in zip(result.shown.lags, SHARES, strict=True) if result.is_for_good and np.isfinite(late)]
        self.reached.set_data([late for late, _ in reached], [share for _, share in reached])
        self.title.set_text(_title(result))
        for text, track in zip(self.words, (result.shown, result.beside), strict=True):
            text.set_text(f"{track.label}: {_read_off(result, track)}" if result.settings["step"] else "")


def _title(result):
    if result.settings["step"] == 0:
        return "no step"
    return "epochs to 50, 90, 99 %" if result.is_for_good else "moved by at most"


def _read_off(result, track):
    if not result.is_for_good:
        return f"{track.most:.2f} cm"
    return ", ".join(f"{late:.0f}" if np.isfinite(late) else "never" for late in track.lags)


class _Sizes:
    """Lag to half of the step over its size; where the ground stays, by how much the level moves at most."""

    def __init__(self, axes):
        self.axes = axes
        axes.set_xlim(0, 15.4)
        axes.set_xticks(range(0, 16, 3))
        (self.beside,) = axes.plot([], [], **BESIDE)
        (self.shown,) = axes.plot([], [], **SHOWN)
        (self.beside_now,) = axes.plot([], [], "s", color=BESIDE_COLOR, markersize=8, markeredgecolor="white", clip_on=False)
        (self.shown_now,) = axes.plot([], [], "o", color=SHOWN_COLOR, markersize=8, markeredgecolor="white", clip_on=False)

    @property
    def moving(self):
        """The artists that change with every result, lowest first."""
        return self.beside, self.shown, self.beside_now, self.shown_now

    def show(self, result):
        """Fill in curves where there are any, and both filters at the step chosen."""
        size = result.settings["step"]
        for line, now, track in ((self.shown, self.shown_now, result.shown), (self.beside, self.beside_now, result.beside)):
            curve = track.curve is not None
            line.set_data(result.sizes if curve else [], _within(result, track.curve) if curve else [])
            value = track.lags[0] if result.is_for_good else track.most
            now.set_data(*(([size], _within(result, [value])) if size else ([], [])))
        return self._label(result)

    def _label(self, result):
        if result.is_for_good:
            self.axes.set_yscale("function", functions=(_root, np.square))
            self.axes.set_yticks((*LAG_TICKS, LATEST), [*map(str, LAG_TICKS), "late"])
            self.axes.set_ylim(0, LATEST)
            self.axes.set_ylabel("epochs to half", labelpad=1)
            self.axes.set_xlabel("size of the step [cm]", labelpad=1)
        else:
            self.axes.set_yscale("linear")
            self.axes.set_yticks(range(0, 16, 3))
            self.axes.set_ylim(0, 15.4)
            self.axes.set_ylabel("moved by at most [cm]", labelpad=1)
            self.axes.set_xlabel("size of the error [cm]", labelpad=1)
        return result.is_for_good


def _root(value):
    return np.sqrt(np.maximum(value, 0.0))


def _within(result, values):
    """Return values as they are drawn: what is late or never reached at the upper edge."""
    highest = LATEST if result.is_for_good else 15.4
    return np.minimum(np.nan_to_num(values, nan=highest), highest)


def describe_step_response(result):
    """Return the pictures in words, for those who cannot see them."""
    used = result.settings
    what = f"a step of {used['step']:g} cm" if result.is_for_good else f"solutions that are {used['step']:g} cm off for {used['lasts']} epochs"
    told = f"Raw solutions over {len(result.truth)} epochs with {what}, and two filters as lines: {result.shown.label} and {result.beside.label}. "
    if used["step"] == 0:
        return told + "Nothing moves."
    words = "epochs to 50, 90 and 99 % of the step" if result.is_for_good else "the level is moved by at most"
    return told + "; ".join(f"{track.label}: {words}: {_read_off(result, track)}" for track in (result.shown, result.beside)) + "."
