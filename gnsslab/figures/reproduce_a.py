"""Paper A's figures 4 to 8, made again from one draw of its experiments: length, angles, their errors, the turntable, the circle."""

from itertools import product

import numpy as np
from matplotlib.ticker import MaxNLocator

from gnsslab.core.rotations import heading_pitch_of
from gnsslab.figures.kept import new_figure, png_bytes, styled

WIDTH, PANEL = 460, 112  # [CSS px], so that a phone need not shrink it much
SETTLED, MISSING = 100, 218  # [s]
ANGLES = ("heading", "pitch")
_SCALES = "Scales differ from panel to panel; the first epochs, without integers, may lie outside."
LENGTH = 1.167  # [m]
STYLES = {
    "direct": {"label": "direct", "color": "#C07000", "marker": "^", "markersize": 2.6, "linestyle": ""},
    "length": {"label": "+ length", "color": "#0072B2", "marker": "o", "markersize": 2.2, "linestyle": ""},
    "position": {"label": "+ length + (29)", "color": "#00805C", "marker": "s", "markersize": 2.2, "linestyle": ""},
}
LETTERS = "abcdef"
TRUTH = {"color": "#111111", "linewidth": 0.9, "linestyle": "--", "label": "truth"}


def figures_4_to_8(at_rest, turning):
    """Return title, words and PNG of each figure of two experiments, each with seconds, truth and solutions."""
    with styled():
        drawn = (_length(at_rest), _angles(at_rest), _errors(at_rest), _turntable(turning), _circle(turning))
        return tuple((title, words, _png(figure)) for title, words, figure in drawn)


def _length(experiment):
    figure = new_figure(WIDTH, 260)
    axes = figure.add_axes((0.15, 0.19, 0.825, 0.7))
    for mode in ("direct", "length"):
        axes.plot(experiment.seconds, experiment.solutions[mode].length, **STYLES[mode])
    axes.axhline(LENGTH, **TRUTH)
    axes.set(ylim=(1.12, 1.22), ylabel="length [m]", xlabel="epoch [s]")
    _legend(figure, axes)
    band = [np.ptp(experiment.solutions[mode].length[150:300]) * 1e3 for mode in ("direct", "length")]
    words = f"Epochs 150 to 299: within {band[0]:.0f} mm direct, within {band[1]:.0f} mm with the length. Dashed: 1.167 m. Some are outside."
    return "Figure 4: length of the baseline at rest", words, figure


def _angles(experiment):
    figure, frames = _stack(4)
    truth = np.degrees(heading_pitch_of(experiment.truth))
    for axes, (mode, angle) in zip(frames, product(("direct", "length"), (0, 1)), strict=True):
        _draw(axes, experiment, _degrees(experiment, mode)[angle], mode, truth[angle], ANGLES[angle])
        _zoom(axes, experiment, _degrees(experiment, mode)[angle])
    jumps = [_largest(experiment, mode, 300, 650) for mode in ("direct", "length")]
    words = (
        f"From 300 s on, when lock is lost first, the heading is up to {jumps[0]:.2g} deg off direct, up to {jumps[1]:.2g} with the length. {_SCALES}"
    )
    return "Figure 5: heading and pitch at rest", words, figure


def _errors(experiment):
    figure, frames = _stack(4)
    for axes, (angle, mode) in zip(frames, product((0, 1), ("direct", "length")), strict=True):
        solution = experiment.solutions[mode]
        error = (solution.heading_error, solution.pitch_error)[angle]
        _draw(axes, experiment, error, mode, np.zeros(len(error)), f"{ANGLES[angle]} error")
        _zoom(axes, experiment, error)
    words = f"From epoch 100 on the heading with the length is never more than {_largest(experiment, 'length', 100, 650):.2f} deg off. {_SCALES}"
    return "Figure 6: errors of heading and pitch at rest", words, figure


def _turntable(experiment):
    figure, frames = _stack(6)
    truth = np.degrees(heading_pitch_of(experiment.truth))
    for axes, (mode, angle) in zip(frames, product(STYLES, (0, 1)), strict=True):
        _draw(axes, experiment, _degrees(experiment, mode)[angle], mode, truth[angle], ANGLES[angle])
        axes.axvline(MISSING, color="#A03070", linewidth=1, linestyle=":")
    at = experiment.seconds == MISSING
    off = [float(experiment.solutions[mode].heading_error[at][0]) for mode in ("length", "position")]
    jumps = [_largest(experiment, mode, 150, 181) for mode in ("direct", "length")]
    words = (
        f"From 150 to 180 s the heading is up to {jumps[0]:.2g} deg off direct, up to {jumps[1]:.2g} with the length. Dotted: 218 s, where the "
        f"master's epoch is missing; the heading there is {off[0]:+.1f} deg off with the length, {off[1]:+.1f} with the position correction too."
    )
    return "Figure 7: heading and pitch on the turntable", words, figure


def _circle(experiment):
    figure = new_figure(WIDTH, 400)
    axes = figure.add_axes((0.14, 0.12, 0.83, 0.79))
    solution = experiment.solutions["position"]
    for is_fixed, style in ((True, STYLES["length"] | {"label": "fixed"}), (False, STYLES["direct"] | {"label": "float", "markersize": 4.5})):
        axes.plot(*solution.baseline[solution.is_fixed == is_fixed, :2].T, **style)
    around = np.radians(np.arange(361))
    axes.plot(LENGTH * np.sin(around), LENGTH * np.cos(around), **(TRUTH | {"zorder": 0}))
    axes.set(aspect="equal", xlim=(-2.1, 2.1), ylim=(-2.1, 2.1), xlabel="east [m]", ylabel="north [m]")
    _legend(figure, axes)
    words = f"With length and position correction; {np.sum(~solution.is_fixed)} of {len(solution.is_fixed)} epochs are float."
    return "Figure 8: the baseline on the turntable, from above", words, figure


def _stack(count):
    """Return a figure with that many panels one above the other, and their axes."""
    height = PANEL * count + 45
    figure = new_figure(WIDTH, height)
    bottoms = [(46 + PANEL * (count - 1 - row)) / height for row in range(count)]
    frames = [figure.add_axes((0.125, bottom, 0.85, (PANEL - 26) / height)) for bottom in bottoms]
    for axes in frames[:-1]:
        axes.tick_params(labelbottom=False)
    frames[-1].set_xlabel("epoch [s]")
    return figure, frames


def _draw(axes, experiment, values, mode, truth, what):
    """Draw one panel: marks of a mode and the truth, in degrees."""
    axes.plot(experiment.seconds, values, **STYLES[mode])
    axes.plot(experiment.seconds, truth, **TRUTH)
    axes.yaxis.set_major_locator(MaxNLocator(4))
    letter = LETTERS[axes.figure.axes.index(axes)]
    axes.set_title(f"({letter}) {what} [deg], {STYLES[mode]['label']}", fontsize=10, loc="left", pad=3)


def _zoom(axes, experiment, values):
    """Set the scale by what comes after the paper's start: the first epochs, float, would hide the rest."""
    settled = values[experiment.seconds >= SETTLED]
    margin = 0.08 * np.ptp(settled) + 0.1
    axes.set_ylim(settled.min() - margin, settled.max() + margin)


def _degrees(experiment, mode):
    """Return heading and pitch (2, T) [deg] of a mode."""
    return np.degrees(heading_pitch_of(experiment.solutions[mode].baseline))


def _largest(experiment, mode, first, end):
    """Return the largest heading error [deg] from one epoch to before another."""
    error = experiment.solutions[mode].heading_error
    return np.max(np.abs(error[(experiment.seconds >= first) & (experiment.seconds < end)]))


def _legend(figure, axes):
    figure.legend(*axes.get_legend_handles_labels(), loc="upper center", ncols=3, fontsize=9, markerscale=2)


def _png(figure):
    figure.canvas.draw()
    return png_bytes(figure.canvas)
