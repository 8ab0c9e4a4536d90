"""Pictures of a known length: the baselines that integer vectors give, on a map with the sphere, and how often each method is right."""

import numpy as np
from matplotlib.patches import Circle, Ellipse
from matplotlib.ticker import MaxNLocator

from gnsslab.figures.ellipses import CHI_SQUARE_95, set_ellipse
from gnsslab.figures.kept import Scene, new_figure, styled

RIGHT_COLOR, NEAREST_COLOR, CLAIM_COLOR, FLOAT_COLOR, SPHERE_COLOR = "#0072B2", "#D98200", "#111111", "#A03070", "#777777"
HALF_WIDTHS = (0.5, 0.8, 1.2, 1.6, 2.0, 2.5, 3.0, 4.0, 5.0, 6.5, 8.0, 12.0)  # [m]
FITS = 3.0  # sigma: a baseline whose length is that near the known one fits it
NEAREST = {"linestyle": "", "marker": "s", "color": NEAREST_COLOR, "markerfacecolor": "none", "markersize": 12, "markeredgewidth": 2}
CHOSEN = {"linestyle": "", "marker": "o", "color": RIGHT_COLOR, "markerfacecolor": "none", "markersize": 16, "markeredgewidth": 2.2}
FITTING = {"linestyle": "", "marker": "o", "color": "#111111", "markersize": 4.5}
OTHER = {"linestyle": "", "marker": "o", "color": "#888888", "markerfacecolor": "none", "markersize": 4}
NAMES = {"without": "no length", "row": "row", "twice": "row +\nsearch", "scaled": "search,\nscaled", "search": "search"}


def plot_known_length(result, figure=None):
    """Draw both pictures of a KnownLengthResult side by side; return the Figure."""
    with styled():
        figure = figure if figure is not None else new_figure(840, 480)
        left, right = figure.subfigures(1, 2, width_ratios=(1.16, 1))
        for build, part in ((build_map, left), (build_shares, right)):
            build(part).show(result)
    return figure


def build_map(figure):
    """Lay out the map of candidate baselines, east and north; show(result) fills it in."""
    part = _Map(figure.add_axes((0.135, 0.09, 0.83, 0.795)))
    figure.legend(
        handles=part.named,
        loc="upper left",
        ncols=3,
        fontsize=9,
        markerscale=0.75,
        handlelength=1.3,
        handletextpad=0.7,
        columnspacing=1.2,
        labelspacing=0.4,
    )
    return Scene(part.moving, part.show)


def build_shares(figure):
    """Lay out the lengths of the candidates against how well they fit, and below them the shares counted; show(result) fills them in."""
    parts = _Lengths(figure.add_axes((0.19, 0.66, 0.76, 0.275))), _Shares(figure.add_axes((0.19, 0.095, 0.76, 0.405)))
    return Scene(tuple(artist for part in parts for artist in part.moving), lambda result: tuple(part.show(result) for part in parts))


class _Map:
    """Candidate baselines from above, with the float one, its ellipse, and the outline of the sphere."""

    def __init__(self, axes):
        self.axes = axes
        axes.set(aspect="equal", xlabel="east [m]", autoscale_on=False)
        axes.set_ylabel("north [m]", labelpad=1)
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_major_locator(MaxNLocator(5, symmetric=True))
        self.sphere = axes.add_patch(Circle((0, 0), 1, facecolor="#f1f1f1", edgecolor=SPHERE_COLOR, linewidth=1.4, label="sphere"))
        self.ellipse = axes.add_patch(Ellipse((0, 0), 1, 1, fill=False, edgecolor=FLOAT_COLOR, linestyle="--", linewidth=1.4))
        (self.float,) = axes.plot([], [], "P", color=FLOAT_COLOR, markersize=8, label="float, 95 %")
        (self.misfits,) = axes.plot([], [], label="another length", **OTHER)
        (self.fits,) = axes.plot([], [], label="the length fits", **FITTING)
        (self.nearest,) = axes.plot(
            [], [], "s", color=NEAREST_COLOR, markerfacecolor="none", markersize=12, markeredgewidth=2, label="nearest integers"
        )
        (self.chosen,) = axes.plot([], [], label="chosen", **CHOSEN)
        (self.truth,) = axes.plot([], [], "x", color="#009E73", markersize=10, markeredgewidth=2.4, label="truth")
        self.named = [self.truth, self.float, self.nearest, self.chosen, self.fits, self.misfits]

    @property
    def moving(self):
        """The artists that change with every result, lowest first."""
        return (self.sphere, self.ellipse, self.misfits, self.fits, self.float, self.truth, self.nearest, self.chosen)

    def show(self, result):
        """Fill in one epoch; return the limit, which is the frame."""
        shown = result.shown
        fits = fits_length(shown, result.entered)
        for marks, places in (
            (self.float, shown.b_hat[None]), (self.misfits, shown.baselines[~fits]), (self.fits, shown.baselines[fits]),
            (self.nearest, shown.baselines[:1]), (self.chosen, shown.baselines[-1:]), (self.truth, shown.truth[None]),
        ):  # fmt: skip
            marks.set_data(places[:, 0], places[:, 1])
        self.sphere.set_radius(result.entered)
        set_ellipse(self.ellipse, shown.b_hat[:2], CHI_SQUARE_95 * shown.Q_b[:2, :2])
        return self._set_limits(result)

    def _set_limits(self, result):
        shown = result.shown
        marked = np.abs([*shown.baselines[[0, 1, 2, 3, 4, 5, -1]], shown.b_hat, shown.truth])[:, :2].max()
        half = next((width for width in HALF_WIDTHS if width >= 1.1 * max(marked, result.entered)), HALF_WIDTHS[-1])
        self.axes.set_xlim(-half, half)
        self.axes.set_ylim(-half, half)
        return half


class _Lengths:
    """How far each candidate's integers are from the float ones, and how long its baseline would be."""

    def __init__(self, axes):
        self.axes = axes
        axes.set_title("the same vectors: fit and length", fontsize=9.5)
        axes.set_ylabel("length [m]", labelpad=1)
        axes.set_xlabel("squared distance from the float ones", labelpad=1)
        axes.xaxis.set_major_locator(MaxNLocator(6))
        axes.yaxis.set_major_locator(MaxNLocator(4))
        self.known = axes.axhline(1, color=SPHERE_COLOR, linewidth=1.4)
        (self.misfits,) = axes.plot([], [], **OTHER)
        (self.fits,) = axes.plot([], [], **FITTING)
        (self.nearest,) = axes.plot([], [], **NEAREST)
        (self.chosen,) = axes.plot([], [], **CHOSEN)

    @property
    def moving(self):
        """The artists that change with every result, lowest first."""
        return (self.known, self.misfits, self.fits, self.nearest, self.chosen)

    def show(self, result):
        """Fill in one epoch; return the limits, which are the frame."""
        shown, fits = result.shown, fits_length(result.shown, result.entered)
        length = np.linalg.norm(shown.baselines, axis=-1)
        self.known.set_ydata([result.entered] * 2)
        for marks, chosen in ((self.misfits, ~fits), (self.fits, fits), (self.nearest, slice(0, 1)), (self.chosen, slice(-1, None))):
            marks.set_data(shown.distances[chosen], length[chosen])
        right, top = (_round_up(1.08 * values.max()) for values in (shown.distances, np.append(length, result.entered)))
        self.axes.set_xlim(0, right)
        self.axes.set_ylim(0, top)
        return right, top


class _Shares:
    """How often each method is right, with the error of the count, and how often it claims to be."""

    def __init__(self, axes):
        self.axes = axes
        self.rows = len(NAMES) - 1 - np.arange(len(NAMES))  # the first on top
        axes.set_yticks(self.rows, list(NAMES.values()), fontsize=9)
        axes.set_ylim(-0.55, len(NAMES) - 0.45)
        axes.set_xlim(0, 103)
        axes.set_xlabel("epochs with the right integers [%]")
        axes.grid(False, axis="y")
        self.bars = axes.barh(self.rows, np.zeros(len(NAMES)), height=0.62, color=RIGHT_COLOR)
        (self.errors,) = axes.plot([], [], color="#444444", linewidth=2, label="error of the count, 95 %")
        diamond = {"color": "white", "markeredgecolor": CLAIM_COLOR, "markeredgewidth": 1.6, "markersize": 8}
        (self.claims,) = axes.plot([], [], "D", label="claimed", **diamond)
        self.numbers = [axes.text(0, row, "", va="center", fontsize=9) for row in self.rows]
        axes.legend(handles=[self.claims, self.errors], loc="lower left", ncols=2, bbox_to_anchor=(-0.25, 1.0), handlelength=1.2, columnspacing=1.2)

    @property
    def moving(self):
        """The artists that change with every result, lowest first."""
        return (*self.bars, self.errors, self.claims, *self.numbers)

    def show(self, result):
        """Fill in the shares."""
        fixes = [result.counted.fixes[name] for name in NAMES]
        shares = [100 * one.right.rate for one in fixes]
        for bar, share, name in zip(self.bars, shares, NAMES, strict=True):
            bar.set(width=share, alpha=1.0 if name == result.settings["method"] else 0.4)
        ends = [(100 * low, 100 * high, np.nan) for low, high in (one.right.interval for one in fixes)]
        self.errors.set_data(np.ravel(ends), np.repeat(self.rows, 3))
        self.claims.set_data([100 * one.claimed for one in fixes], self.rows)
        for number, share, one in zip(self.numbers, shares, fixes, strict=True):
            inside, chosen = share > 25, one is result.fixes
            number.set(text=f"{share:.1f} %", x=3 if inside else 100 * one.right.interval[1] + 2, color="white" if inside and chosen else "#222222")


def fits_length(shown, length):
    """Return which of the integer vectors shown have a baseline of that length, within three sigma of it, bool."""
    return np.abs(np.linalg.norm(shown.baselines, axis=-1) - length) <= FITS * shown.sigma_length


def describe_known_length(result):
    """Return the pictures in words, for those who cannot see them."""
    shown = result.shown
    fits = int(fits_length(shown, result.entered)[:-1].sum())
    fitting = f"{fits} of them {'has' if fits == 1 else 'have'} that length"
    shares = ", ".join(
        f"{name.replace(chr(10), ' ')} {100 * result.counted.fixes[key].right.rate:.0f} % and claims {100 * result.counted.fixes[key].claimed:.0f} %"
        for key, name in NAMES.items()
    )
    return (
        f"A map of the baselines that the {len(shown.baselines) - 1} integer vectors nearest to the float solution give, with the circle of the "
        f"length entered, {result.entered:.3f} m; {fitting}. The ones chosen are {'right' if shown.is_right else 'wrong'}. "
        f"Beside it, counted over {len(result.counted.truth)} epochs, how often each method is right: {shares}."
    )


def _round_up(value):
    """Return the next of 1, 1.5, 2, 3, 5, 7 times a power of ten, so that axes hold still under small changes."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(next(step * power for step in (1, 1.5, 2, 3, 5, 7, 10) if step * power >= value * (1 - 1e-12)))
