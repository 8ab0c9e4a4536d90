"""Pictures of float and fixed positions in one plane, with a window that magnifies the middle, and of the share of right integers."""

import numpy as np
from matplotlib.patches import ConnectionPatch, Ellipse
from matplotlib.ticker import FixedFormatter, FixedLocator, MaxNLocator, NullLocator

from gnsslab.figures.kept import Scene, new_figure, styled

# Colours of Okabe and Ito (2008); the marks tell the same: rings, crosses, dots.
FLOAT = {"color": "#1468A8", "marker": "o", "markersize": 3, "linestyle": "", "alpha": 0.4, "markeredgewidth": 0}
WRONG = {"color": "#C04A00", "marker": "x", "markersize": 6, "linestyle": "", "markeredgewidth": 1.3}
RIGHT = {"color": "#007A5A", "marker": "o", "markersize": 3, "linestyle": "", "alpha": 0.6, "markeredgewidth": 0}
CLAIM = {"fill": False, "edgecolor": "#111111", "linewidth": 1.6}
METRES = (0.1, 0.2, 0.5, 1, 2, 3, 5, 8, 12, 20)  # half heights of the plane
MILLIMETRES = (2, 5, 10, 20, 30, 50, 80, 120, 200, 500, 1000)  # half widths of the window
WIDE = 1.5  # of the plane, width over height
CHI_SQUARE_95 = 5.991  # of two degrees of freedom
TICKS = (1, 2, 5, 10, 20, 60)
MM = 1e-3


def plot_centimetres(result, figure=None):
    """Draw both pictures of a CentimetresResult side by side; return the Figure."""
    with styled():
        figure = figure if figure is not None else new_figure(840, 540)
        plane, span = figure.subfigures(1, 2, width_ratios=(1.25, 1))
        for build, part in ((build_plane, plane), (build_span, span)):
            build(part).show(result)
    return figure


def build_plane(figure):
    """Lay out the plane of float and fixed positions, and the window above it; show(result) fills them in."""
    plane, window = _Plane(figure.add_axes((0.13, 0.095, 0.83, 0.83 / WIDE * 460 / 540))), _Window(figure.add_axes((0.63, 0.64, 0.34, 0.29)))
    _beams(figure, plane.axes, window.axes)
    figure.legend(
        handles=[plane.floats, plane.wrong, plane.right, plane.claim], loc="upper left", bbox_to_anchor=(0.0, 1.0), fontsize=9.5,
        handletextpad=0.5, labelspacing=0.6, handlelength=1.5,
    )  # fmt: skip

    def show(result):
        return plane.show(result), window.show(result)

    return Scene((*plane.moving, *window.moving), show)


def build_span(figure):
    """Lay out the promised share of right integers over the epochs used together, and the counted one; show(result) fills them in."""
    axes = figure.add_axes((0.15, 0.13, 0.8, 0.66))
    axes.set(xlim=(0.93, 66), ylim=(-2, 104), xscale="log", xlabel="epochs together", ylabel="right integers [%]")
    axes.xaxis.set_major_locator(FixedLocator(TICKS))
    axes.xaxis.set_major_formatter(FixedFormatter([str(tick) for tick in TICKS]))
    axes.xaxis.set_minor_locator(NullLocator())
    (promised,) = axes.plot([], [], "-", color="#111111", linewidth=1.6, label="promised")
    (bar,) = axes.plot([], [], "-", color=RIGHT["color"], linewidth=2.5)
    (counted,) = axes.plot([], [], "o", color=RIGHT["color"], markersize=8, label="counted, with two sigma")
    axes.legend(handles=[promised, counted], loc="lower left", bbox_to_anchor=(-0.06, 1.0), ncols=1, fontsize=9.5)

    def show(result):
        promised.set_data(result.span, 100 * result.promised_over_span)
        share, T, epochs = np.mean(result.is_right), len(result.is_right), result.settings["epochs"]
        reach = 200 * np.sqrt(share * (1 - share) / T)
        counted.set_data([epochs], [100 * share])
        bar.set_data([epochs, epochs], [100 * share - reach, 100 * share + reach])
        return 0

    return Scene((promised, bar, counted), show)


class _Plane:
    """Float positions, wrong fixes and the right ones, seen from above, in metres."""

    def __init__(self, axes):
        self.axes = axes
        axes.set(xlabel="east [m]", ylabel="north [m]", aspect="equal")
        axes.xaxis.set_major_locator(MaxNLocator(6, symmetric=True))
        axes.yaxis.set_major_locator(MaxNLocator(5, symmetric=True))
        (self.floats,) = axes.plot([], [], label="float", **FLOAT)
        (self.wrong,) = axes.plot([], [], label="fixed, wrong integers", **WRONG)
        (self.right,) = axes.plot([], [], label="fixed, right integers", **RIGHT | {"markersize": 6, "alpha": 1.0})
        self.claim = axes.add_patch(Ellipse((0, 0), 1, 1, label="95 % that the solver claims", **CLAIM))

    @property
    def moving(self):
        """The artists that change with every result, lowest first."""
        return (self.floats, self.wrong, self.claim, self.right)

    def show(self, result):
        """Fill in the positions; return the limit, which is the frame."""
        fixed = result.fixed_enu[:, :2]
        self.floats.set_data(*result.float_enu[:, :2].T)
        self.wrong.set_data(*fixed[~result.is_right].T)
        self.right.set_data(*fixed[result.is_right].T)
        _set_ellipse(self.claim, result.Q_float)
        half = _first_that_holds(METRES, 1.05 * _reach(result.float_enu[:, :2] / [WIDE, 1], result.Q_float))
        self.axes.set_xlim(-WIDE * half, WIDE * half)
        self.axes.set_ylim(-half, half)
        return half


class _Window:
    """The middle of the plane, in millimetres."""

    def __init__(self, axes):
        self.axes = axes
        axes.set_title("the middle, magnified [mm]", fontsize=9.5)
        axes.set(aspect="equal")
        for side in axes.spines.values():
            side.set(visible=True, edgecolor="#666666")
        axes.xaxis.set_major_locator(MaxNLocator(4, symmetric=True))
        axes.yaxis.set_major_locator(MaxNLocator(4, symmetric=True))
        (self.right,) = axes.plot([], [], **RIGHT)
        (self.wrong,) = axes.plot([], [], **WRONG)
        self.claim = axes.add_patch(Ellipse((0, 0), 1, 1, **CLAIM))

    @property
    def moving(self):
        """The artists that change with every result, lowest first."""
        return (self.right, self.wrong, self.claim)

    def show(self, result):
        """Fill in the positions; return the limit, which is the frame."""
        fixed = result.fixed_enu[:, :2] / MM
        self.right.set_data(*fixed[result.is_right].T)
        self.wrong.set_data(*fixed[~result.is_right].T)
        _set_ellipse(self.claim, result.Q_fixed / MM**2)
        half = _first_that_holds(MILLIMETRES, 1.05 * _reach(fixed[result.is_right], result.Q_fixed / MM**2))
        self.axes.set_xlim(-half, half)
        self.axes.set_ylim(-half, half)
        return half


def _beams(figure, plane, window):
    """Draw beams from the middle of the plane to the window."""
    for corner in ((0, 0), (1, 0)):
        figure.add_artist(ConnectionPatch((0.0, 0.0), corner, plane.transData, window.transAxes, color="#999999", linewidth=0.8, linestyle="--"))


def _first_that_holds(limits, reach):
    return next((limit for limit in limits if limit >= reach), limits[-1])


def _reach(points, Q):
    """Return how far nearly all points (T, 2) and the 95 % ellipse of Q reach along an axis."""
    claimed = np.sqrt(CHI_SQUARE_95 * np.diag(Q)[:2].max())
    return max(float(np.quantile(np.abs(points), 0.998)), claimed) if len(points) else claimed


def _set_ellipse(patch, Q):
    """Give a patch the 95 % ellipse of the first two coordinates of Q."""
    variances, directions = np.linalg.eigh(CHI_SQUARE_95 * Q[:2, :2])
    width, height = 2 * np.sqrt(variances)
    patch.set(width=width, height=height, angle=np.degrees(np.arctan2(directions[1, 0], directions[0, 0])))


def describe_centimetres(result):
    """Return the pictures in words, for those who cannot see them."""
    share = np.mean(result.is_right)
    text = (
        f"{len(result.is_right)} positions on the map about the true one. The float cloud has an rms of "
        f"{_rms(result.float_enu):.2f} metres. {share:.1%} have the right integers"
    )
    text += f" and lie within millimetres of the middle, with an rms of {_rms(result.fixed_enu[result.is_right]) / MM:.1f}." if share else "."
    if share < 1:
        text += f" The others, drawn as crosses, lie {np.median(np.hypot(*result.fixed_enu[~result.is_right, :2].T)):.1f} metres off in the median."
    first, last = 100 * result.promised_over_span[[0, -1]]
    return text + f" The curve beside them promises {first:.0f} % at one epoch and {last:.0f} % at sixty."


def _rms(enu):
    return np.sqrt(np.mean(np.sum(enu[:, :2] ** 2, axis=1)))
