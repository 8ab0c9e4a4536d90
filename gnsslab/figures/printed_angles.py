"""Pictures of formulas as printed and as corrected: the error of both angles, and the sigma against beams that were drawn."""

import numpy as np
from matplotlib.ticker import FixedLocator, MaxNLocator

from gnsslab.figures.kept import Scene, new_figure, styled

# Colours of Okabe and Ito (2008); the line's style tells them apart again.
FORMULA_STYLE = {
    "printed": {"color": "#C84A00", "linestyle": "-", "linewidth": 2.2},
    "corrected": {"color": "#0072B2", "linestyle": "-", "linewidth": 2.2},
}
WORDS = {"printed": "as printed", "corrected": "corrected"}
BARS_COLOR = "#8FBEE0"
MARK = {"marker": "o", "markersize": 9, "markeredgecolor": "#111111", "markeredgewidth": 1.4, "linestyle": ""}
STEEPEST_PRINTED = 45.0  # [deg], where the printed pitch ends
PITCH_ERRORS = 30.0  # [deg], height of the pitch panel: the error at 43.6 deg
HALF_WIDTHS = (0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 45, 90, 180)  # [deg], the scales an axis snaps to
RIGHT = 1e-6  # [deg], a smaller error is the rounding of a computer
BINS = 41  # odd: one in the middle


def plot_printed_angles(result, figure=None):
    """Draw both pictures of a result of the lab "printed" side by side; return the Figure."""
    with styled():
        figure = figure if figure is not None else new_figure(880, 400)
        errors, scatter = figure.subfigures(1, 2, width_ratios=(1.26, 1))
        for build, part in ((build_errors, errors), (build_scatter, scatter)):
            build(part).show(result)
    return figure


def build_errors(figure):
    """Lay out the error of heading above that of pitch, each against its true angle; show(result) fills them in."""
    heading = ErrorPanel(figure.add_axes((0.135, 0.59, 0.825, 0.325)), "heading", (0, 360), (-40, 220))
    pitch = ErrorPanel(figure.add_axes((0.135, 0.115, 0.825, 0.325)), "pitch", (-80, 80), (-PITCH_ERRORS, PITCH_ERRORS))
    heading.axes.xaxis.set_major_locator(FixedLocator(range(0, 361, 45)))
    heading.axes.yaxis.set_major_locator(FixedLocator((0, 90, 180)))
    for side in (-1, 1):
        pitch.axes.axvspan(side * STEEPEST_PRINTED, side * 80, color="#eeeeee", linewidth=0)
        pitch.axes.text(side * 62.5, 0, "no printed\nanswer", ha="center", va="center", fontsize=8.5, color="#666666")

    def show(result):
        formula, used = result.settings["formula"], result.settings
        heading.show(formula, result.headings_deg, result.chosen.heading_errors, used["heading_deg"], result.heading_error)
        pitch.show(formula, result.pitches_deg, result.chosen.pitch_errors, used["pitch_deg"], result.pitch_error)
        return None

    return Scene((*heading.moving, *pitch.moving), show)


class ErrorPanel:
    """The error of one angle at all its true values, by the chosen formula, and where the beam is now."""

    def __init__(self, axes, angle, span, limits):
        self.axes = axes
        axes.set_xlim(*span)
        axes.set_ylim(*limits)
        axes.set_xlabel(f"true {angle} [deg]", labelpad=1)
        axes.set_ylabel("error [deg]")
        axes.xaxis.set_major_locator(MaxNLocator(9))
        axes.axhline(0, color="#999999", linewidth=1)
        (self.now,) = axes.plot([], [], ":", color="#444444", linewidth=1.2)
        (self.curve,) = axes.plot([], [])
        (self.mark,) = axes.plot([], [], **MARK)
        self.words = axes.text(0.0, 1.03, "", transform=axes.transAxes, fontsize=9.5, va="bottom")
        self.angle = angle

    @property
    def moving(self):
        """The artists that change with every result, lowest first."""
        return (self.now, self.curve, self.mark, self.words)

    def show(self, formula, angles, errors, angle, error):
        """Fill in the curve of a formula, and the true angle and error [deg] of the beam; NaN: no answer."""
        low, high = self.axes.get_ylim()
        self.curve.set(**FORMULA_STYLE[formula])
        self.curve.set_data(angles, np.where(np.abs(np.diff(errors, prepend=errors[0])) > 90, np.nan, errors))
        self.now.set_data([angle, angle], [low, high])
        self.mark.set_data([angle], [np.clip(error, low, high)])
        self.mark.set_markerfacecolor(FORMULA_STYLE[formula]["color"])
        self.words.set_text(f"{self.angle} {WORDS[formula]}: {_error_words(error)}")


def build_scatter(figure):
    """Lay out how drawn beams scatter in heading and in pitch, with the sigma that the chosen formula promises; show(result) fills them in."""
    heading = ScatterPanel(figure.add_axes((0.05, 0.59, 0.91, 0.325)), "heading")
    pitch = ScatterPanel(figure.add_axes((0.05, 0.115, 0.91, 0.325)), "pitch")

    def show(result):
        formula, chosen = result.settings["formula"], result.chosen
        return (
            heading.show(formula, result.drawn_heading, np.degrees(chosen.sigma_heading)),
            pitch.show(formula, result.drawn_pitch, np.degrees(chosen.sigma_pitch)),
        )

    return Scene((*heading.moving, *pitch.moving), show)


class ScatterPanel:
    """How often a drawn beam misses one angle by how much, and plus and minus the promised sigma."""

    def __init__(self, axes, angle):
        self.axes, self.angle = axes, angle
        axes.set_ylim(0, 1.12)
        axes.yaxis.set_visible(False)
        axes.spines["left"].set_visible(False)
        axes.xaxis.set_major_locator(MaxNLocator(7, symmetric=True))
        axes.set_xlabel(f"drawn {angle} less the true one [deg]", labelpad=1)
        self.bars = axes.fill_between([0.0], [0.0], [0.0], color=BARS_COLOR, linewidth=0)
        self.edges = [axes.plot([], [], dashes=(5, 3))[0] for _ in range(2)]
        self.words = axes.text(0.0, 1.03, "", transform=axes.transAxes, fontsize=9, va="bottom")

    @property
    def moving(self):
        """The artists that change with every result, lowest first."""
        return (self.bars, *self.edges, self.words)

    def show(self, formula, drawn, sigma):
        """Fill in the drawn errors (N,) and the promised sigma, all [deg]; return the half width of the axis, which is the frame."""
        half = next((half for half in HALF_WIDTHS if half >= max(3.5 * np.std(drawn), 1.25 * sigma)), HALF_WIDTHS[-1])
        self.axes.set_xlim(-half, half)
        self.bars.set_data(*_steps(drawn))
        for edge, side in zip(self.edges, (-1, 1), strict=True):
            edge.set(color=FORMULA_STYLE[formula]["color"], linewidth=2)
            edge.set_data([side * sigma] * 2, [0, 1.05])
        self.words.set_text(f"{self.angle}: sigma {WORDS[formula]} {sigma:.2f} deg, drawn {np.std(drawn):.2f} deg")
        return half


def describe_printed_angles(result):
    """Return both pictures in words, for those who cannot see them."""
    used, chosen = result.settings, result.chosen
    sigma_heading, sigma_pitch = np.degrees(chosen.sigma_heading), np.degrees(chosen.sigma_pitch)
    return (
        f"The formulas {WORDS[used['formula']]}, for a beam of heading {used['heading_deg']:g} and pitch {used['pitch_deg']:g} degrees. "
        f"Heading: {_error_words(result.heading_error)}; pitch: {_error_words(result.pitch_error)}. "
        f"Beside it how drawn beams scatter: {np.std(result.drawn_heading):.2f} degrees in heading where the formula says {sigma_heading:.2f}, "
        f"{np.std(result.drawn_pitch):.2f} degrees in pitch where it says {sigma_pitch:.2f}."
    )


def _error_words(error):
    """Return what is to be said of an error [deg]; NaN: no answer.

    >>> _error_words(1.344), _error_words(-1e-14), _error_words(float("nan"))
    ('off by +1.34 deg', 'right', 'no answer')
    """
    if not np.isfinite(error):
        return "no answer"
    return f"off by {error:+.3g} deg" if abs(error) >= RIGHT else "right"


def _steps(drawn):
    """Return the outline of a histogram as fill_between takes it: x, bottom and top, the highest bar 1."""
    reach = 4 * np.std(drawn)
    counts, edges = np.histogram(drawn, BINS, (-reach, reach))
    top = np.repeat(counts / counts.max(), 2)
    return np.repeat(edges, 2)[1:-1], np.zeros(len(top)), top
