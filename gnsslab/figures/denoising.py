"""Pictures of one series and its filters: the length of the baseline over time, and the error of each method beside the paper's."""

import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.patches import Patch, Rectangle
from matplotlib.ticker import MaxNLocator, MultipleLocator

from gnsslab.figures.kept import Scene, new_figure, styled

RAW_COLOR, CHOSEN_COLOR, TRUTH_COLOR, MEAN_COLOR, LAG_COLOR = "#8C8C8C", "#0072B2", "#111111", "#D98200", "#A03070"
CM = 1e-2
MINUTES = (-15.0, 60.0)  # of the lower panel, about the middle of the series
MARGINS = (10.0, 6.0)  # [cm] that the upper and the lower panel show below the truth and above it
WIDEST = (3.2, 4.5, 6, 8, 12)  # [cm], ends of the scale of errors
AT_ONCE = {"facecolor": CHOSEN_COLOR, "edgecolor": CHOSEN_COLOR}
LATER = {"facecolor": "#C3DEEF", "edgecolor": CHOSEN_COLOR, "hatch": "////"}
SHOWN = {"facecolor": "none", "edgecolor": MEAN_COLOR, "linewidth": 1.8, "clip_on": False}
ROWS = 10
BAR = 0.62  # of a row
EDGE = 1.265  # of the numbers at the right, in widths of the axes


def plot_denoising(result, figure=None):
    """Draw both pictures of a DenoisingResult side by side; return the Figure."""
    with styled():
        figure = figure if figure is not None else new_figure(820, 470)
        left, right = figure.subfigures(1, 2, width_ratios=(450, 370))
        for build, part in ((build_series, left), (build_ranking, right)):
            build(part).show(result)
    return figure


def build_series(figure):
    """Lay out the whole series and an hour about its middle; show(result) fills in solutions, truth and the method chosen."""
    whole, middle = _Panel(figure.add_axes((0.13, 0.54, 0.845, 0.35)), 2.0), _Panel(figure.add_axes((0.13, 0.09, 0.845, 0.36)), 3.4)
    whole.axes.xaxis.set_major_locator(MultipleLocator(1))
    whole.axes.set_xlabel("hours, all epochs", labelpad=1)
    middle.axes.set_xlim(*MINUTES)
    middle.axes.xaxis.set_major_locator(MultipleLocator(10))
    middle.axes.set_xlabel("minutes from the middle of the series", labelpad=1)
    handles = [whole.raw, whole.truth, whole.chosen, whole.mean, middle.lag]
    figure.legend(handles=handles, loc="upper center", ncols=3, bbox_to_anchor=(0.54, 1.005), fontsize=9, markerscale=2, handlelength=1.8,
                  columnspacing=1.4, labelspacing=0.25)  # fmt: skip

    def show(result):
        minutes = 60 * (result.hours - result.hours[result.step_at])
        near = (minutes >= MINUTES[0]) & (minutes <= MINUTES[1])
        whole.show(result, result.hours, slice(None), MARGINS[0])
        middle.show(result, minutes, near, MARGINS[1])
        middle.show_lag(result)
        whole.axes.set_xlim(0, result.hours[-1])
        return result.settings["step"]

    return Scene((*whole.moving, *middle.moving), show)


class _Panel:
    """The length of the baseline over time [cm], counted from the true one before the step."""

    def __init__(self, axes, dot):
        self.axes = axes
        axes.set_ylabel("length - 120 cm [cm]", labelpad=1)
        axes.yaxis.set_major_locator(MaxNLocator(6, integer=True))
        (self.raw,) = axes.plot([], [], "o", color=RAW_COLOR, markersize=dot, markeredgewidth=0, label="raw solutions")
        (self.truth,) = axes.plot([], [], color=TRUTH_COLOR, linewidth=1.4, drawstyle="steps-post", label="truth")
        (self.mean,) = axes.plot([], [], color=MEAN_COLOR, linewidth=1.6, linestyle="--", label="its own mean")
        (self.chosen,) = axes.plot([], [], color=CHOSEN_COLOR, linewidth=1.5, label="method shown")
        (self.lag,) = axes.plot([], [], color=LAG_COLOR, linewidth=1.6, linestyle=":", label="90 % of step")
        self.outside = axes.text(0.995, 0.985, "", transform=axes.transAxes, fontsize=8.5, color="#444444", ha="right", va="top")

    @property
    def moving(self):
        """The artists that change with every result, lowest first."""
        return self.raw, self.truth, self.mean, self.lag, self.chosen, self.outside

    def show(self, result, x, part, margin):
        """Fill in the epochs of a part, `margin` [cm] about all that is true."""
        low, high = -margin, margin + result.settings["step"]
        raw, chosen, truth = ((values - result.truth[0]) / CM for values in (result.lengths["raw"], result.lengths[result.chosen], result.truth))
        for line, values in ((self.raw, raw), (self.chosen, chosen), (self.truth, truth)):
            line.set_data(x[part], values[part])
        is_counted = result.settings["criterion"] == "mean"
        self.mean.set_data(*(([x[0], x[-1]], [chosen.mean()] * 2) if is_counted else ([], [])))
        beyond = int(np.sum((raw[part] < low) | (raw[part] > high)))
        self.outside.set_text(f"{beyond} raw further out" if beyond else "")
        self.axes.set_ylim(low, high)

    def show_lag(self, result):
        """Draw an upright line where 90 % of the step is reached; none where it never is."""
        epochs = result.lags.get(result.chosen, np.nan)
        places = np.repeat(epochs * 60 * result.hours[1], 2) if np.isfinite(epochs) else []
        self.lag.set_data(places, self.axes.get_ylim() if len(places) else [])


def build_ranking(figure):
    """Lay out one row for each method; show(result) fills in bars, their numbers and lags."""
    ranking = _Ranking(figure.add_axes((0.325, 0.10, 0.525, 0.76)))
    figure.legend(handles=ranking.named, loc="upper left", ncols=2, bbox_to_anchor=(0.0, 1.005), fontsize=9, handlelength=1.6, columnspacing=1.2,
                  labelspacing=0.3)  # fmt: skip
    return Scene(ranking.moving, ranking.show)


class _Ranking:
    """Bars of the errors of all methods, in the paper's order, and diamonds at the paper's own."""

    def __init__(self, axes):
        self.axes = axes
        axes.set_ylim(0.45 - ROWS, 0.55)
        axes.tick_params(left=False, axis="y", labelsize=9.5)
        axes.grid(False, axis="y")
        self.border = axes.axhline(0, color="#BBBBBB", linewidth=0.8)
        self.shown = axes.add_patch(Rectangle((-0.605, 0), 1.615, 0.92, transform=axes.get_yaxis_transform(), **SHOWN))
        self.bars = [axes.add_collection(PolyCollection([], linewidths=0.7, **style)) for style in (AT_ONCE, LATER)]
        (self.paper,) = axes.plot([], [], "D", color="white", markeredgecolor="#111111", markeredgewidth=1.6, markersize=7)
        self.errors = [axes.text(0, -row, "", fontsize=9.5, va="center_baseline") for row in range(ROWS)]
        place = {"transform": axes.get_yaxis_transform(), "va": "center_baseline", "ha": "right", "fontsize": 9.5}
        self.column = [axes.text(EDGE, -row, "", **place) for row in range(ROWS)]
        self.title = axes.text(EDGE, 0.62, "", **place | {"va": "bottom", "fontsize": 8.5, "color": "#444444"})
        self.paper.set_label("printed in the paper")
        self.named = [Patch(label="known at once", **AT_ONCE), Patch(label="needs later epochs", **LATER), self.paper,
                      Patch(label="method shown", **SHOWN)]  # fmt: skip

    @property
    def moving(self):
        """The artists that change with every result, lowest first."""
        return (self.border, self.shown, *self.bars, self.paper, *self.errors, *self.column, self.title)

    def show(self, result):
        """Fill in all rows; return the scale and the criterion, which are the frame."""
        errors, height = result.counted, {name: -row for row, name in enumerate(result.rows)}
        later = {name for name in errors if result.rows[name].is_later}
        for bars, names in zip(self.bars, (errors.keys() - later, later), strict=True):
            bars.set_verts([_bar(height[name], errors[name]) for name in sorted(names)])
        self.shown.set_y(height[result.chosen] - 0.46)
        printed = {name: row.printed for name, row in result.rows.items() if row.printed}
        self.paper.set_data(list(printed.values()), [height[name] for name in printed])
        self.border.set_ydata([0.5 - len(printed)] * 2)
        end = next((end for end in WIDEST if max(errors.values()) < 0.85 * end), WIDEST[-1])
        self._write_errors(result, end)
        self._write_column(result, printed)
        return self._label(result, end)

    def _write_errors(self, result, end):
        """Write errors right of bar and diamond."""
        for (name, row), text in zip(result.rows.items(), self.errors, strict=True):
            error = result.counted.get(name)
            text.set_x(max(error or 0.0, row.printed + 0.03 * end if row.printed else 0.0) + 0.025 * end)
            text.set_text("if shown" if error is None else f"{error:.2f}")

    def _write_column(self, result, printed):
        """Write lags at the edge; without a step what the paper prints."""
        lags = result.lags
        words = {name: _lag_words(late) for name, late in lags.items()} if lags else {name: f"{value:.2f}" for name, value in printed.items()}
        for name, text in zip(result.rows, self.column, strict=True):
            text.set_text(words.get(name, ""))
        self.title.set_text("lag to 90 %,\nepochs" if lags else "paper [cm],\nown mean")

    def _label(self, result, end):
        about = "the series' own mean" if result.settings["criterion"] == "mean" else "the known truth"
        self.axes.set_yticks(range(0, -ROWS, -1), [row.label for row in result.rows.values()])
        self.axes.set_xlim(0, end)
        self.axes.set_xlabel(f"RMSE about {about} [cm]", labelpad=2)
        return end, about


def describe_denoising(result):
    """Return the pictures in words, for those who cannot see them."""
    used, chosen = result.settings, result.rows[result.chosen].label
    step = f"a step of {used['step']:g} cm in the middle" if used["step"] else "nothing moves"
    about = "its own mean" if used["criterion"] == "mean" else "the known truth"
    errors = ", ".join(f"{result.rows[name].label} {error:.2f}" for name, error in result.counted.items())
    late = f" Epochs until {chosen} has 90 % of the step: {_lag_words(result.lags[result.chosen])}." if result.chosen in result.lags else ""
    return (
        f"The length of a baseline over {len(result.truth)} epochs, {step}: raw solutions as dots, {chosen} as a line through them. "
        f"Beside it the RMSE of each method about {about}, in centimetres: {errors}.{late}"
    )


def _lag_words(epochs):
    return f"{epochs:.0f}" if np.isfinite(epochs) else "never"


def _bar(row, length):
    return [(0, row - BAR / 2), (length, row - BAR / 2), (length, row + BAR / 2), (0, row + BAR / 2)]
