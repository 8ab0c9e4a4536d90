"""Pictures of a covariance: two matrices as heat maps with their numbers, the ratios, and the cloud of baselines."""

import numpy as np
from matplotlib import colormaps
from matplotlib.collections import PolyCollection
from matplotlib.patches import Ellipse
from matplotlib.ticker import FixedFormatter, FixedLocator, MaxNLocator, NullFormatter, NullLocator

from gnsslab.figures.ellipses import CHI_SQUARE_95, set_ellipse
from gnsslab.figures.kept import Scene, new_figure, styled
from gnsslab.figures.numbers import NumberPaths

BLUES = colormaps["Blues"]
RIGHT_COLOR, WRONG_COLOR, CLAIM_COLOR, BEST_COLOR = "#0072B2", "#D98200", "#111111", "#777777"
BINS = np.geomspace(1.0, 100.0, 33)  # of ratios; what is beyond stands in the last one
HALF_WIDTHS = (5, 10, 20, 30, 50, 75, 100, 200, 500, 1000, 10_000)  # [mm]
MM = 1e-3


def plot_correlation(result, figure=None):
    """Draw both pictures of a CorrelationResult side by side; return the Figure."""
    with styled():
        figure = figure if figure is not None else new_figure(840, 480)
        pattern, cloud = figure.subfigures(1, 2, width_ratios=(1.35, 1))
        for build, part in ((build_pattern, pattern), (build_cloud, cloud)):
            build(part).show(result)
    return figure


def build_pattern(figure):
    """Lay out the covariance that the noise shows beside the one the solver believes, and below them the ratios; show(result) fills them in."""
    titles = ("what the noise does", "what the solver believes")
    matrices = [_Matrix(figure.add_axes((left, 0.475, 0.475, 0.47)), title) for left, title in zip((0.015, 0.51), titles, strict=True)]
    ratios = _Ratios(figure.add_axes((0.11, 0.105, 0.83, 0.245)))

    def show(result):
        most = max(float(np.max(result.sampled)), 1e-12)
        for matrix, Q in zip(matrices, (result.sampled, result.believed), strict=True):
            matrix.show(Q, most)
        return ratios.show(result)

    return Scene(tuple(artist for part in (*matrices, ratios) for artist in part.moving), show)


def build_cloud(figure):
    """Lay out the baselines of all epochs and the ellipse that the solver claims; show(result) fills them in."""
    cloud = _Cloud(figure.add_axes((0.17, 0.13, 0.78, 0.74)))
    return Scene(cloud.moving, cloud.show)


class _Matrix:
    """One heat map with its numbers."""

    def __init__(self, axes, title):
        axes.set_title(title, fontsize=10)
        axes.set(aspect="equal", xlim=(0, 1), ylim=(0, 1), autoscale_on=False)
        axes.axis("off")
        self.cells = axes.add_collection(PolyCollection([], linewidths=0, antialiased=False))
        self.numbers = NumberPaths(axes)

    @property
    def moving(self):
        """The artists that change with every result, lowest first."""
        return (self.cells, *self.numbers.moving)

    def show(self, Q, most):
        """Fill in a matrix (n, n); `most` is the value of the darkest blue."""
        n = len(Q)
        shade = np.sqrt(np.clip(Q / most, 0, 1)).ravel()
        row, column = np.divmod(np.arange(n * n), n)
        corners = np.array([[0, 0], [1, 0], [1, 1], [0, 1]]) / n
        lower_left = np.column_stack([column, n - 1 - row]) / n
        self.cells.set_verts(lower_left[:, np.newaxis] + corners)
        self.cells.set_facecolor(BLUES(0.85 * shade))
        self.numbers.show([_cell(value) for value in Q.ravel()], lower_left + 0.5 / n, shade > 0.75, min(0.045, 0.27 / n))


class _Ratios:
    """How often which ratio comes out; right integers below, wrong ones on top, and the same for a solver that respects the correlation."""

    def __init__(self, axes):
        self.axes = axes
        axes.set_xscale("log")
        axes.set_xlim(BINS[0], BINS[-1])
        axes.set_xlabel("ratio: second best over best")
        axes.xaxis.set_major_locator(FixedLocator([1, 2, 3, 5, 10, 20, 50, 100]))
        axes.xaxis.set_major_formatter(FixedFormatter(["1", "2", "3", "5", "10", "20", "50", "100+"]))
        axes.xaxis.set_minor_locator(NullLocator())
        axes.xaxis.set_minor_formatter(NullFormatter())
        axes.set_ylabel("share of epochs [%]")
        axes.yaxis.set_major_locator(MaxNLocator(5))
        (self.wrong,) = axes.fill(*_steps(np.zeros(len(BINS) - 1)), color=WRONG_COLOR, label="wrong integers")
        (self.right,) = axes.fill(*_steps(np.zeros(len(BINS) - 1)), color=RIGHT_COLOR, label="right integers")
        (self.best,) = axes.plot([], [], color=BEST_COLOR, linewidth=1.4, label="were correlation respected")
        (self.threshold,) = axes.plot([], [], "--", color=CLAIM_COLOR, linewidth=1.2, label="believed from here on")
        axes.legend(
            handles=[self.right, self.wrong, self.best, self.threshold], loc="lower left", ncols=2, bbox_to_anchor=(-0.03, 1.0), fontsize=9,
            handlelength=1.4, columnspacing=1.2, labelspacing=0.2,
        )  # fmt: skip

    @property
    def moving(self):
        """The artists that change with every result, lowest first."""
        return (self.wrong, self.right, self.best, self.threshold)

    def show(self, result):
        """Fill in the shares; return the limit, which is the frame."""
        total, right, best = (_shares(*one) for one in ((result.solved,), (result.solved, result.solved.is_right), (result.best,)))
        self.wrong.set_xy(np.column_stack(_steps(total)))
        self.right.set_xy(np.column_stack(_steps(right)))
        self.best.set_data(*_steps(best))
        self.threshold.set_data([result.solved.threshold] * 2, [0, 100])
        top = next(limit for limit in (10, 20, 40, 70, 105) if limit >= 1.05 * max(total.max(), best.max()))
        self.axes.set_ylim(0, top)
        return top


class _Cloud:
    """Baselines of all epochs, with the right integers, seen from the south; the ellipse is what the solver claims."""

    def __init__(self, axes):
        self.axes = axes
        axes.set_xlabel("east [mm]")
        axes.set_ylabel("up [mm]", labelpad=1)
        axes.set_title("fixed baselines,\nand the 95 % that the solver claims", fontsize=9.5)
        axes.xaxis.set_major_locator(MaxNLocator(4, symmetric=True))
        axes.yaxis.set_major_locator(MaxNLocator(5, symmetric=True))
        (self.dots,) = axes.plot([], [], "o", color=RIGHT_COLOR, markersize=2, alpha=0.6)
        self.claim = axes.add_patch(Ellipse((0, 0), 1, 1, fill=False, edgecolor=CLAIM_COLOR, linewidth=1.6))

    @property
    def moving(self):
        """The artists that change with every result, lowest first."""
        return (self.dots, self.claim)

    def show(self, result):
        """Fill in the baselines; return the limit, which is the frame."""
        plane = [0, 2]  # east and up
        middle = np.median(result.solved.baseline, axis=0)
        dots = (result.solved.baseline - middle)[:, plane] / MM
        self.dots.set_data(*dots.T)
        claimed = CHI_SQUARE_95 * result.solved.Q_baseline[np.ix_(plane, plane)] / MM**2
        set_ellipse(self.claim, (0, 0), claimed)
        reach = 1.05 * max(np.quantile(np.abs(dots), 0.998), np.sqrt(np.diag(claimed).max()))
        half = next(limit for limit in HALF_WIDTHS if limit >= min(reach, HALF_WIDTHS[-1]))
        self.axes.set_xlim(-half, half)
        self.axes.set_ylim(-half, half)
        return half


def describe_correlation(result):
    """Return the pictures in words, for those who cannot see them."""
    sampled, believed = (f"{np.mean(np.diag(Q)):.3g} on the diagonal and {_beside(Q):.3g} beside it" for Q in (result.sampled, result.believed))
    solved, best = result.solved, result.best
    return (
        f"Two covariance matrices of {len(result.believed)} double differences, in units of one reading's variance, on average {sampled} "
        f"as the noise has it, {believed} as the solver believes. Below, the ratios of {len(solved.ratio)} epochs: "
        f"{np.mean(solved.is_right):.0%} have the right integers, the median ratio is {np.median(solved.ratio):.2f}; were the correlation "
        f"respected it would be {np.median(best.ratio):.2f}. Beside them the cloud of baselines with the ellipse that the solver claims."
    )


def _cell(value):
    """Return a number of a matrix in two digits, or in as many as its whole part has.

    >>> _cell(4.0), _cell(1.98), _cell(666.67), _cell(-0.04)
    ('4.0', '2.0', '667', '0.0')
    """
    return f"{value:.0f}" if abs(value) >= 9.95 else f"{round(value, 1) + 0.0:.1f}"


def _beside(Q):
    """Return the mean of what stands beside the diagonal."""
    n = len(Q)
    return float((Q.sum() - np.trace(Q)) / (n * (n - 1)))


def _shares(solved, chosen=None):
    """Return the share of epochs [%] in each bin of ratios; of the chosen ones where they are given."""
    ratio = np.clip(solved.ratio if chosen is None else solved.ratio[chosen], BINS[0], BINS[-1])
    return 100 * np.histogram(ratio, BINS)[0] / len(solved.ratio)


def _steps(shares):
    """Return the outline of a histogram, x and y."""
    return np.repeat(BINS, 2), np.concatenate([[0.0], np.repeat(shares, 2), [0.0]])
