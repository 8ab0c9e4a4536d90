"""Pictures of conditional standard deviations before and after decorrelation, and of the nodes that searches visit."""

import numpy as np
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter

from gnsslab.figures.kept import Scene, new_figure, styled

# Colours of Okabe and Ito (2008); marks and dashes tell the same.
BEFORE = {"color": "#C86400", "marker": "o", "linestyle": "--", "linewidth": 1.4, "markersize": 6, "label": "before decorrelation"}
AFTER = {"color": "#0072B2", "marker": "s", "linestyle": "-", "linewidth": 1.8, "markersize": 5, "label": "after"}
LEVEL = {"color": "#111111", "linestyle": ":", "linewidth": 1.6}
CYCLES = (0.003, 0.01, 0.03, 0.1, 0.3, 1, 3, 10, 30, 100, 300)  # where the axis may end


def plot_spectrum(result, figure=None):
    """Draw both pictures of a SpectrumResult side by side; return the Figure."""
    with styled():
        figure = figure if figure is not None else new_figure(880, 400)
        spectrum, nodes = figure.subfigures(1, 2, width_ratios=(1.4, 1))
        for build, part in ((build_spectrum, spectrum), (build_nodes, nodes)):
            build(part).show(result)
    return figure


def build_spectrum(figure):
    """Lay out conditional standard deviations in the order of fixing, before and after; show(result) fills them in."""
    axes = figure.add_axes((0.145, 0.13, 0.83, 0.69))
    axes.set(yscale="log", xlabel="in the order in which the search fixes them", ylabel="conditional sigma [cycles]")
    axes.xaxis.set_major_locator(MaxNLocator(9, integer=True))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.yaxis.set_minor_formatter(NullFormatter())
    (before,) = axes.plot([], [], **BEFORE)
    (after,) = axes.plot([], [], **AFTER)
    (level,) = axes.plot([], [], label="ADOP, the mean of both", **LEVEL)
    axes.legend(handles=[before, after, level], loc="lower left", bbox_to_anchor=(-0.08, 1.0), ncols=2, fontsize=9.5, columnspacing=1.4)

    def show(result):
        order = np.arange(1, result.n + 1)
        before.set_data(order, result.before.sigma)
        after.set_data(*((order, result.after.sigma) if result.after is not None else ([], [])))
        level.set_data([0.5, result.n + 0.5], [result.adop] * 2)
        lowest, highest = _limits(result)
        axes.set_xlim(0.5, result.n + 0.5)
        axes.set_ylim(lowest, highest)
        return result.n, lowest, highest

    return Scene((level, before, after), show)


def build_nodes(figure):
    """Lay out the nodes that each epoch's search visits, before and after decorrelation; show(result) fills them in."""
    axes = figure.add_axes((0.16, 0.13, 0.8, 0.66))
    axes.set(yscale="log", xlabel="epoch", ylabel="nodes visited", ylim=(5, 2e6))
    axes.xaxis.set_major_locator(MaxNLocator(10, integer=True))
    axes.yaxis.set_major_locator(LogLocator(10, numticks=8))
    axes.yaxis.set_minor_formatter(NullFormatter())
    (limit,) = axes.plot([], [], label="stopped here", color="#777777", linestyle="--", linewidth=1.2)
    (straight,) = axes.plot([], [], label="straight down", **LEVEL)
    (before,) = axes.plot([], [], **BEFORE | {"linestyle": ""})
    (after,) = axes.plot([], [], **AFTER | {"linestyle": ""})
    axes.legend(
        handles=[before, after, limit, straight], loc="lower left", bbox_to_anchor=(-0.18, 1.0), ncols=2, fontsize=9.5, handletextpad=0.4,
        columnspacing=1.0, labelspacing=0.3,
    )  # fmt: skip

    def show(result):
        epoch = np.arange(1, len(result.before.nodes) + 1)
        ends = [0.4, len(epoch) + 0.6]
        limit.set_data(ends, [result.node_limit] * 2)
        straight.set_data(ends, [2 * result.n + 1] * 2)
        before.set_data(epoch, result.before.nodes)
        after.set_data(*((epoch, result.after.nodes) if result.after is not None else ([], [])))
        axes.set_xlim(*ends)
        return len(epoch)

    return Scene((limit, straight, before, after), show)


def describe_spectrum(result):
    """Return the pictures in words, for those who cannot see them."""
    text = (
        f"{result.n} conditional standard deviations in the order of fixing. Before decorrelation the first three are "
        f"{_listed(result.before.sigma[:3])} cycles and the others {_span(result.before.sigma[3:])}; "
    )
    text += f"after it all are {_span(result.after.sigma)}. " if result.after is not None else "decorrelation is off. "
    text += f"ADOP is {result.adop:.3f} cycles. A search visits {np.median(result.before.nodes):.0f} nodes in the median before"
    return text + (f", {np.median(result.after.nodes):.0f} after decorrelation." if result.after is not None else " decorrelation.")


def _limits(result):
    """Return the first limits that hold both spectra."""
    sigmas = result.before.sigma if result.after is None else np.concatenate([result.before.sigma, result.after.sigma])
    lowest = max((limit for limit in CYCLES if limit <= sigmas.min()), default=sigmas.min())
    return lowest, min((limit for limit in CYCLES if limit >= sigmas.max()), default=sigmas.max())


def _listed(values):
    return ", ".join(f"{value:.2g}" for value in values)


def _span(values):
    """Return from where to where values go, in words.

    >>> _span(np.array([0.25, 0.5, 0.125]))
    '0.12 to 0.5'
    """
    return f"{values.min():.2g} to {values.max():.2g}"
