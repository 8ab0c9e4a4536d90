"""Pictures of differences: how large each level's residuals are, on one axis in powers of ten, and the noise of each on one scale."""

import numpy as np
from matplotlib.ticker import FixedFormatter, FixedLocator, LogLocator, MaxNLocator, NullFormatter

from gnsslab.figures.kept import Scene, new_figure, styled

LEVELS = ("undifferenced", "single difference", "double difference")
# Colours of Okabe and Ito (2008), dark enough on white; the marker tells them apart again.
LEVEL_STYLE = (
    {"color": "#0072B2", "marker": "o", "markersize": 2.2},
    {"color": "#C87800", "marker": "^", "markersize": 2.6},
    {"color": "#A03070", "marker": "s", "markersize": 2.2},
)
SMALLEST, LARGEST = 1e-5, 1e7  # [m], ends of the axis in powers of ten
TICKS = {1e-5: "0.01 mm", 1e-3: "1 mm", 1e-1: "10 cm", 1e1: "10 m", 1e3: "1 km", 1e5: "100 km"}
HALF_WIDTHS = tuple(step * 10.0**power for power in range(-3, 6) for step in (1, 2, 5))  # [m]


def plot_cancelling(result, figure=None):
    """Draw both pictures of a CancellingResult side by side; return the Figure."""
    with styled():
        figure = figure if figure is not None else new_figure(880, 420)
        sizes, grains = figure.subfigures(1, 2, width_ratios=(1.2, 1))
        for build, part in ((build_sizes, sizes), (build_grains, grains)):
            build(part).show(result)
    return figure


def build_sizes(figure):
    """Lay out the sizes of all residuals against time, an axis in powers of ten; show(result) fills them in."""
    axes = figure.add_axes((0.165, 0.115, 0.80, 0.775))
    axes.set_yscale("log")
    axes.set_ylim(SMALLEST, LARGEST)
    axes.yaxis.set_major_locator(FixedLocator(list(TICKS)))
    axes.yaxis.set_major_formatter(FixedFormatter(list(TICKS.values())))
    axes.yaxis.set_minor_locator(LogLocator(subs=(1.0,), numticks=20))
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.xaxis.set_major_locator(MaxNLocator(6))
    axes.set_xlabel("seconds since the first epoch")
    dots = [axes.plot([], [], linestyle="", label=name, **style)[0] for name, style in zip(LEVELS, LEVEL_STYLE, strict=True)]
    (wave,) = axes.plot([], [], "--", color="#444444", linewidth=1)
    words = axes.text(0.99, 0.0, "", transform=axes.get_yaxis_transform(), ha="right", va="bottom", fontsize=8.5, color="#444444")
    figure.legend(handles=dots, loc="upper center", ncols=3, fontsize=9, markerscale=2.4, handletextpad=0.1, columnspacing=1.0)
    axes.set_title("size of measured minus geometric", fontsize=9, loc="left", pad=3)

    def show(result):
        last = _show_span(axes, result)
        for marks, level in zip(dots, result.levels, strict=True):
            marks.set_data(np.tile(result.seconds, len(level)), np.maximum(np.abs(level).ravel(), SMALLEST * 1.2))
        wave.set_data([-last, 2 * last] if result.wavelength else [], [result.wavelength] * 2 if result.wavelength else [])
        words.set_text(f"one wavelength, {100 * result.wavelength:.0f} cm" if result.wavelength else "")
        words.set_y(1.15 * max(result.wavelength, SMALLEST))
        return last

    return Scene((*dots, wave, words), show)


def build_grains(figure):
    """Lay out three strips, a level each, with what is left of it when a smooth curve is taken off; show(result) fills them in."""
    strips = [figure.add_axes((0.17, bottom, 0.785, 0.225)) for bottom in (0.68, 0.3975, 0.115)]
    panels = [_strip(axes, name, style) for axes, name, style in zip(strips, LEVELS, LEVEL_STYLE, strict=True)]
    for axes in strips[:-1]:
        axes.tick_params(labelbottom=False)
    strips[-1].set_xlabel("seconds since the first epoch")

    def show(result):
        unit, scale, half = _scale(result.grains[-1][0])
        for axes in strips:
            last = _show_span(axes, result)
            axes.set_ylim(-half / scale, half / scale)
            axes.set_ylabel(f"noise [{unit}]")
        for (dots, edges, words), (sigma, rest), name in zip(panels, result.grains, LEVELS, strict=True):
            dots.set_data(np.tile(result.seconds, len(rest)), rest.ravel() / scale)
            for edge, sign in zip(edges, (1, -1), strict=True):
                edge.set_data([-last, 2 * last], [sign * sigma / scale] * 2)
            words.set_text(_grain_words(name, sigma, result.grains[0][0], half))
        return last, half

    return Scene(tuple(artist for dots, edges, words in panels for artist in (dots, *edges, words)), show)


def describe_cancelling(result):
    """Return both pictures in words, for those who cannot see them."""
    satellite, reference = result.names
    sizes = "; ".join(f"{name} {length_words(typical_size(level))}" for name, level in zip(LEVELS, result.levels, strict=True))
    noises = ", ".join(length_words(sigma) for sigma, _ in result.grains)
    return (
        f"Measured minus geometric of {satellite} and the reference {reference} over {len(result.seconds)} epochs, on an axis in powers of ten. "
        f"Typical sizes: {sizes}. Beside it the noise of the three levels on one scale: {noises}."
    )


def typical_size(level):
    """Return the root mean square [m] of a level's residuals."""
    return float(np.sqrt(np.nanmean(np.square(level))))


def length_words(metres):
    """Return a length in a unit that gives it one to three digits before the point.

    >>> length_words(102_239.4), length_words(0.0056), length_words(0.71)
    ('102 km', '5.6 mm', '0.71 m')
    """
    unit, scale = ("km", 1e3) if metres >= 1e3 else ("m", 1.0) if metres >= 0.1 else ("mm", 1e-3)
    value = metres / scale
    return f"{value:.{0 if value >= 100 else 1 if value >= 10 or unit == 'mm' else 2}f} {unit}"


def _strip(axes, name, style):
    """Lay out one strip; return its dots, the lines of plus and minus one sigma, and the words."""
    axes.yaxis.set_major_locator(MaxNLocator(4, symmetric=True))
    axes.xaxis.set_major_locator(MaxNLocator(6))
    (dots,) = axes.plot([], [], linestyle="", **style)
    edges = [axes.plot([], [], "--", color="#111111", linewidth=1)[0] for _ in range(2)]
    words = axes.text(0.0, 1.03, name, transform=axes.transAxes, fontsize=9, va="bottom")
    return dots, edges, words


def _grain_words(name, sigma, first, half):
    if sigma > half:
        return f"{name}: {length_words(sigma)}, far off this scale"
    grown = f", {sigma / first:.2f} times" if first <= half and name != LEVELS[0] else ""
    return f"{name}: 1 sigma = {length_words(sigma)}{grown}"


def _scale(sigma):
    """Return the unit of a strip's axis, the unit in metres, and half the axis [m]: room for three sigma."""
    half = next((width for width in HALF_WIDTHS if width >= 3 * sigma), HALF_WIDTHS[-1])
    return ("m", 1.0, half) if half >= 0.2 else ("mm", 1e-3, half)


def _show_span(axes, result):
    last = max(float(result.seconds[-1]), 1.0)
    axes.set_xlim(-0.01 * last, 1.01 * last)
    return last
