"""Paper B's figures 1 to 4, made again from one draw of its two series, and what it does not show: the answers of all methods to a step."""

import numpy as np

from gnsslab.figures.kept import new_figure, png_bytes, styled
from gnsslab.systems.criteria import lengths

WIDTH, PANEL, TITLE, TICKS = 460, 104, 26, 20  # [CSS px], so that a phone need not shrink it much
CM = 0.01  # [m]
NAMES = {"raw": "raw", "joint": "joint", "adjustment": "adjustment alone", "robust Kalman": "robust Kalman alone",
         "moving average": "moving average", "wavelet": "wavelet", "EEMD": "EEMD-wavelet"}  # fmt: skip
COLOURS = {"raw": "#707070", "joint": "#0072B2", "adjustment": "#C07000", "robust Kalman": "#00805C",
           "moving average": "#A03070", "wavelet": "#2A8FC0", "EEMD": "#8A6A00"}  # fmt: skip
OTHERS = ("#111111", "#C07000", "#00805C", "#A03070", "#8A6A00")  # of methods that are not the paper's
DASHES = ("-", "--", ":", "-.", (0, (5, 1, 1, 1, 1, 1)), (0, (1, 1)))
BEFORE = 20  # epochs before a step in an answer to it
BEYOND, AROUND = 8.0, 120  # [cm] from the mean that a panel shows; epochs before and after a step
TRUTH = {"color": "#111111", "linewidth": 0.9, "linestyle": "--"}
LETTERS = "abcde"


def paper_b_figures(fixed, step, responses):
    """Return title, words and PNG of each figure.

    `fixed` and `step` have `drawn` (series, truth_enu) and `outputs`, positions (T, 3) [m] by name; `responses` by name and size [cm]
    the share of a step that is in a level, from BEFORE epochs before it on.
    """
    with styled():
        drawn = (_denoised(fixed), _ablated(fixed), _tracked(step), _means(step), _answers(responses, "3.6"), _answers(responses, "10"))
        return tuple((title, words, _png(figure)) for title, words, figure in drawn)


def _denoised(fixed):
    names = ("raw", "moving average", "wavelet", "EEMD", "joint")
    return "Figure 1: length of the baseline at rest, denoised", _scatter_words(fixed, names), _panels(fixed, names)


def _ablated(fixed):
    names = ("raw", "adjustment", "robust Kalman", "joint")
    return "Figure 2: the joint method and its two halves", _scatter_words(fixed, names), _panels(fixed, names)


def _panels(fixed, names):
    """Return a figure with the length after each of these methods, minus the true one."""
    figure, frames = _stack(len(names), TITLE, "epoch, every 15 s")
    for axes in frames[:-1]:
        axes.tick_params(labelbottom=False)
    truth = lengths(fixed.drawn.truth_enu)
    for axes, name in zip(frames, names, strict=True):
        axes.plot((lengths(fixed.outputs[name]) - truth) / CM, color=COLOURS[name], linewidth=0.7)
        axes.axhline(0.0, **TRUTH)
        axes.set(ylim=(-BEYOND, BEYOND), xlim=(0, len(truth)))
        _entitle(axes, f"{NAMES[name]}: length minus true [cm]")
    return figure


def _scatter_words(fixed, names):
    spread = ", ".join(f"{NAMES[name]} {np.std(lengths(fixed.outputs[name])) / CM:.2f}" for name in names)
    return f"Standard deviation [cm] in this draw: {spread}. Dashed: the truth. Gross errors beyond {BEYOND:.0f} cm lie outside."


def _tracked(step):
    figure, frames = _stack(3, TITLE + TICKS, "epoch since the step, every 1 s")
    first, change = _first(step), (lengths(step.drawn.truth_enu) - lengths(step.drawn.truth_enu[:1])) / CM
    near = slice(first - AROUND, first + AROUND)
    for axes, name, where in zip(frames, ("raw", "joint", "joint"), (slice(None), slice(None), near), strict=True):
        epochs = (np.arange(len(change)) - first)[where]
        axes.plot(epochs, _change(step, name)[where], color=COLOURS[name], linewidth=0.5 if where != near else 1.2)
        axes.plot(epochs, change[where], **TRUTH)
        axes.set(ylim=(-BEYOND, BEYOND + 3.6), xlim=(epochs[0], epochs[-1]))
        _entitle(axes, f"{NAMES[name]}: length minus that at first [cm]")
    frames[2].set_ylim(-3, 7)
    words = (
        f"63 857 epochs and, in (c), the {2 * AROUND} around the step: at once half of it is in the adjusted length, and the joint "
        "method takes about 50 epochs to nine tenths. In (b) nobody sees that."
    )
    return "Figure 3: a move of 3.6 cm, raw and joint", words, figure


def _means(step):
    figure = new_figure(WIDTH, 250)
    axes = figure.add_axes((0.125, 0.2, 0.85, 0.68))
    first, change = _first(step), _change(step, "joint")
    means = change[:first].mean(), change[first:].mean()
    axes.plot(change, color=COLOURS["joint"], linewidth=0.4, alpha=0.6)
    axes.plot([0, first], [means[0]] * 2, color="#111111", linewidth=2)
    axes.plot([first, len(change)], [means[1]] * 2, color="#111111", linewidth=2)
    axes.set(xlim=(0, len(change)), ylim=(-4, 8), xlabel="epoch, every 1 s")
    _entitle(axes, "joint: length minus that at first, and its means [cm]", "")
    true_step = np.ptp(lengths(step.drawn.truth_enu)) / CM
    off = 10 * (means[1] - means[0] - true_step)
    words = f"The means differ by {means[1] - means[0]:.3f} cm, the truth by {true_step:.3f} cm: {off:+.1f} mm. Another draw, another millimetre."
    return "Figure 4: the step of the means", words, figure


def _answers(responses, size):
    """Draw the paper's methods, and below them the joint one again beside those that tell a step from an outlier."""
    figure = new_figure(WIDTH, 500)
    papers = {name: by_size[size] for name, by_size in responses.items() if name in NAMES}
    tests = {name: by_size[size] for name, by_size in responses.items() if name not in NAMES}
    panels = ((0.57, papers), (0.085, {"joint": papers["joint"]} | tests))
    colours = COLOURS | dict(zip(tests, OTHERS, strict=False))
    for bottom, shares in panels:
        _draw_shares(figure.add_axes((0.125, bottom, 0.84, 0.385)), shares, colours)
        _entitle(figure.axes[-1], f"share of {size} cm that is in the level [%]")
    figure.axes[-1].set_xlabel("epochs since the step")
    late = ", ".join(f"{NAMES.get(name, name)} {_reached(share)}" for name, share in (papers | tests).items())
    words = f"Median over the draws, each with and without the step in the same noise. Epochs to 90 %: {late}."
    return f"Beyond the paper: answers to a step of {size} cm", words, figure


def _draw_shares(axes, shares, colours):
    for dash, (name, share) in zip(DASHES, shares.items(), strict=False):
        shown = share[: BEFORE + AROUND]
        axes.plot(np.arange(len(shown)) - BEFORE, 100 * shown, color=colours[name], linestyle=dash, label=NAMES.get(name, name), linewidth=1.6)
    axes.set(ylim=(-8, 128), xlim=(-BEFORE, AROUND))
    axes.legend(loc="lower right", fontsize=9, frameon=True, framealpha=0.85, edgecolor="none")


def _reached(share):
    reached = np.flatnonzero(share[BEFORE:] >= 0.9)
    return str(reached[0]) if len(reached) else "never"


def _first(step):
    """Return the first epoch after the step."""
    truth = lengths(step.drawn.truth_enu)
    return int(np.argmax(np.abs(np.diff(truth)))) + 1


def _change(step, name):
    """Return the length (T,) [cm] of an output minus the true one before the step."""
    return (lengths(step.outputs[name]) - lengths(step.drawn.truth_enu[:1])) / CM


def _stack(count, gap, xlabel):
    """Return a figure with that many panels one above the other, gaps of so many CSS px between, and their axes."""
    inner = PANEL - TITLE
    height = (inner + gap) * count + 46
    figure = new_figure(WIDTH, height)
    bottoms = [(46 + (inner + gap) * (count - 1 - row)) / height for row in range(count)]
    frames = [figure.add_axes((0.125, bottom, 0.85, inner / height)) for bottom in bottoms]
    frames[-1].set_xlabel(xlabel)
    return figure, frames


def _entitle(axes, words, letter=None):
    letter = f"({LETTERS[axes.figure.axes.index(axes)]}) " if letter is None else letter
    axes.set_title(letter + words, fontsize=10, loc="left", pad=3)


def _png(figure):
    figure.canvas.draw()
    return png_bytes(figure.canvas)
