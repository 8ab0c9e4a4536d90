"""Paper A's figures 4 to 8, made again from one draw of its experiments: length, angles, their errors, the turntable, the circle."""

import numpy as np
from matplotlib.ticker import MaxNLocator

from gnsslab.core.rotations import heading_pitch_of
from gnsslab.figures.kept import new_figure, png_bytes, styled

WIDTH = 560  # CSS px; a phone shows it at two thirds of that
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
    axes = figure.add_axes((0.125, 0.19, 0.85, 0.7))
    for mode in ("direct", "length"):
        axes.plot(experiment.seconds, experiment.solutions[mode].length, **STYLES[mode])
    axes.axhline(LENGTH, **TRUTH)
    axes.set(ylim=(1.12, 1.22), ylabel="length [m]", xlabel="epoch [s]")
    _legend(figure, axes)
    band = [np.ptp(experiment.solutions[mode].length[150:300]) * 1e3 for mode in ("direct", "length")]
    words = (
        f"Epochs 150 to 299: within {band[0]:.0f} mm direct, within {band[1]:.0f} mm with the length. Dashed: 1.167 m. Some are outside."
    )
    return "Figure 4: length of the baseline at rest", words, figure


def _angles(experiment):
    rows = [(mode, angle) for mode in ("direct", "length") for angle in (0, 1)]
    figure, frames = _stack(4)
    truth = np.degrees(heading_pitch_of(experiment.truth))
    for axes, (mode, angle) in zip(frames, rows, strict=True):
        values = np.degrees(heading_pitch_of(experiment.solutions[mode].baseline)[angle])
        _draw(axes, experiment, values, mode, truth[angle], ("heading [deg]", "pitch [deg]")[angle])
    words = "Direct, both angles jump after the losses of lock at 300 and 500 s; with the length they stay. The scales differ from panel to panel."
    return "Figure 5: heading and pitch at rest", words, figure


def _errors(experiment):
    rows = [(mode, angle) for angle in (0, 1) for mode in ("direct", "length")]
    figure, frames = _stack(4)
    for axes, (mode, angle) in zip(frames, rows, strict=True):
        solution, name = experiment.solutions[mode], ("heading", "pitch")[angle]
        _draw(axes, experiment, (solution.heading_error, solution.pitch_error)[angle], mode, np.zeros(len(experiment.seconds)), f"{name} error [deg]")
    largest = np.max(np.abs(experiment.solutions["length"].heading_error[experiment.seconds >= 100]))
    words = f"From epoch 100 on, the heading with the length is never more than {largest:.2f} deg off. The scales differ from panel to panel."
    return "Figure 6: errors of heading and pitch at rest", words, figure


def _turntable(experiment):
    figure, frames = _stack(6)
    truth = np.degrees(heading_pitch_of(experiment.truth))
    rows = [(mode, angle) for mode in STYLES for angle in (0, 1)]
    for axes, (mode, angle) in zip(frames, rows, strict=True):
        values = np.degrees(heading_pitch_of(experiment.solutions[mode].baseline)[angle])
        _draw(axes, experiment, values, mode, truth[angle], ("heading [deg]", "pitch [deg]")[angle])
        axes.axvline(218, color="#A03070", linewidth=1, linestyle=":")
    at = int(np.flatnonzero(experiment.seconds == 218)[0])
    off = [experiment.solutions[mode].heading_error[at] for mode in ("length", "position")]
    words = (
        f"Dotted: 218 s, where the master's epoch is missing. The heading there is {off[0]:+.1f} deg off with the length, {off[1]:+.1f} deg with "
        "the position correction too. Direct, both angles are lost after 150 s."
    )
    return "Figure 7: heading and pitch on the turntable", words, figure


def _circle(experiment):
    figure = new_figure(WIDTH, 470)
    axes = figure.add_axes((0.14, 0.12, 0.83, 0.79))
    solution = experiment.solutions["position"]
    for is_fixed, style in ((True, STYLES["length"] | {"label": "fixed"}), (False, STYLES["direct"] | {"label": "float", "markersize": 4.5})):
        axes.plot(*solution.baseline[solution.is_fixed == is_fixed, :2].T, **style)
    around = np.radians(np.arange(361))
    axes.plot(LENGTH * np.sin(around), LENGTH * np.cos(around), **(TRUTH | {"zorder": 0}))
    axes.set(aspect="equal", xlim=(-2.1, 2.1), ylim=(-2.1, 2.1), xlabel="east [m]", ylabel="north [m]")
    _legend(figure, axes)
    words = f"With length and position correction. Points off the circle are float: {np.sum(~solution.is_fixed)} of {len(solution.is_fixed)} epochs."
    return "Figure 8: the baseline on the turntable, from above", words, figure


def _stack(count):
    """Return a figure with that many panels one above the other, and their axes."""
    height = 118 * count + 60
    figure = new_figure(WIDTH, height)
    frames = [figure.add_axes((0.125, (46 + 118 * (count - 1 - row)) / height, 0.85, 92 / height)) for row in range(count)]
    for axes in frames[:-1]:
        axes.tick_params(labelbottom=False)
    frames[-1].set_xlabel("epoch [s]")
    return figure, frames


def _draw(axes, experiment, values, mode, truth, label):
    """Draw one panel: marks of a mode and the truth; the scale is that of all values."""
    axes.plot(experiment.seconds, values, **STYLES[mode])
    axes.plot(experiment.seconds, truth, **TRUTH)
    axes.set_ylabel(label, fontsize=9)
    axes.yaxis.set_major_locator(MaxNLocator(4))
    letter = LETTERS[axes.figure.axes.index(axes)]
    axes.set_title(f"({letter}) {STYLES[mode]['label']}", fontsize=9, loc="left", pad=2)


def _legend(figure, axes):
    figure.legend(*axes.get_legend_handles_labels(), loc="upper center", ncols=3, fontsize=9, markerscale=2)


def _png(figure):
    figure.canvas.draw()
    return png_bytes(figure.canvas)
