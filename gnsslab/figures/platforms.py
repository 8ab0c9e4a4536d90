"""Pictures of two antennas on the move: heading, pitch and heading rate against the truth, and the way from above."""

import numpy as np
from matplotlib.ticker import MaxNLocator

from gnsslab.figures.kept import Scene, new_figure, styled

FIXED, FLOAT = 2, 1
FIXED_COLOR, FLOAT_COLOR, TRUTH_COLOR, NONE_COLOR = "#0072B2", "#D98200", "#111111", "#A03070"
DOTS = {"linestyle": "", "markersize": 3}
LIMITS = (0.5, 1, 2, 5, 10, 20, 45, 90, 180)  # [deg] of an axis of errors, half
RATES = (2, 5, 10, 20, 50, 100, 200)  # [deg/s]
REACHES = (1, 5, 20, 50, 100, 150, 200, 300, 500, 1000, 2000, 5000)  # [m], half the width of the map
_NEARLY_ALL = 0.98  # of the errors are in sight


def plot_platforms(result, figure=None):
    """Draw both pictures of a PlatformsResult side by side; return the Figure."""
    with styled():
        figure = figure if figure is not None else new_figure(900, 520)
        left, right = figure.subfigures(1, 2, width_ratios=(1.5, 1))
        for build, part in ((build_angles, left), (build_track, right)):
            build(part).show(result)
    return figure


def build_angles(figure):
    """Lay out heading error, pitch error and heading rate over time; show(result) fills them in."""
    axes = figure.subplots(3, 1, sharex=True, gridspec_kw={"left": 0.14, "right": 0.97, "top": 0.93, "bottom": 0.1, "hspace": 0.16})
    heading, pitch = (_Errors(part, label) for part, label in zip(axes, ("heading error [deg]", "pitch error [deg]"), strict=False))
    rate = _Rate(axes[2])
    figure.legend(handles=[heading.fixed, heading.float, heading.band, rate.truth], loc="upper center", ncols=4, fontsize=9, columnspacing=1.2)

    def show(result):
        axes[2].set_xlim(0, max(1.0, result.seconds[-1]) if result.attitude is not None else 1.0)
        return axes[2].get_xlim(), *(part.show(result, *values) for part, values in zip((heading, pitch, rate), _series(result), strict=True))

    return Scene((*heading.moving, *pitch.moving, *rate.moving), show)


def build_track(figure):
    """Lay out the way from above; show(result) fills it in."""
    track = _Track(figure.add_axes((0.21, 0.12, 0.75, 0.74)))
    figure.legend(handles=track.named, loc="upper center", ncols=2, fontsize=9, handlelength=1.2)
    return Scene(track.moving, track.show)


def describe_platforms(result):
    """Return the pictures in words."""
    if result.attitude is None:
        return "No pictures: there is no answer."
    fixed = result.is_fixed
    lost = int((result.attitude.status < FLOAT).sum())
    typical = np.degrees(np.nanmedian(np.abs(result.heading_error[fixed if fixed.any() else ...]))) if len(fixed) > lost else np.nan
    return (
        f"Heading error, pitch error and heading rate over {len(fixed)} seconds: {int(fixed.sum())} fixed, {lost} without a solution, half of the "
        f"best headings within {typical:.2f} deg of the truth. Beside them the way from above, "
        f"{np.ptp(result.journey.track, axis=0).max():.0f} m across, coloured by what was solved."
    )


def _series(result):
    """Return for each of the three panels what it shows: errors and sigma [deg], rate and the true one [deg/s]."""
    if result.attitude is None:
        return ((None, None),) * 3
    attitude, rate = result.attitude, result.rate
    return (
        (np.degrees(result.heading_error), np.degrees(attitude.sigma_heading)),
        (np.degrees(result.pitch_error), np.degrees(attitude.sigma_pitch)),
        (np.degrees(rate.rate), np.degrees(result.true_rate)),
    )


class _Errors:
    """One angle's errors, fixed and float, with two sigma of the fixed ones."""

    def __init__(self, axes, label):
        self.axes = axes
        axes.set_ylabel(label)
        axes.yaxis.set_major_locator(MaxNLocator(5, symmetric=True))
        self.band = axes.fill_between([0, 1], [0, 0], [0, 0], step="mid", color=FIXED_COLOR, alpha=0.18, linewidth=0, label="2 sigma")
        (self.float,) = axes.plot([], [], "^", color=FLOAT_COLOR, label="float", **DOTS)
        (self.fixed,) = axes.plot([], [], "o", color=FIXED_COLOR, label="fixed", **DOTS)
        self.beyond = axes.text(0.99, 0.04, "", transform=axes.transAxes, ha="right", fontsize=8.5, color="#444444")

    @property
    def moving(self):
        """The artists that change with every result, lowest first."""
        return (self.band, self.float, self.fixed, self.beyond)

    def show(self, result, error, sigma):
        """Fill in one angle; return the limit, which is the frame."""
        if error is None:
            return _cleared(self.moving)
        status, seconds = result.attitude.status, result.seconds
        self.fixed.set_data(seconds[status == FIXED], error[status == FIXED])
        self.float.set_data(seconds[status == FLOAT], error[status == FLOAT])
        twice = np.where(status == FIXED, 2 * sigma, np.nan)
        self.band.set_data(seconds, -twice, twice)
        half = _limit(np.abs(error[np.isfinite(error)]), LIMITS)
        outside = int((np.abs(error) > half).sum())
        self.beyond.set_text(f"{outside} beyond" if outside else "")
        self.axes.set_ylim(-half, half)
        return half


class _Rate:
    """The heading rate, and the true one."""

    def __init__(self, axes):
        self.axes = axes
        axes.set_ylabel("heading rate [deg/s]")
        axes.set_xlabel("seconds")
        axes.yaxis.set_major_locator(MaxNLocator(5, symmetric=True))
        (self.measured,) = axes.plot([], [], "o", color=FIXED_COLOR, **DOTS)
        (self.truth,) = axes.plot([], [], color=TRUTH_COLOR, linewidth=1, label="true rate")

    @property
    def moving(self):
        """The artists that change with every result, lowest first."""
        return (self.measured, self.truth)

    def show(self, result, rate, truth):
        """Fill in the rates; return the limit, which is the frame."""
        if rate is None:
            return _cleared(self.moving)
        solved = np.isfinite(rate)
        self.measured.set_data(result.seconds[solved], rate[solved])
        self.truth.set_data(result.seconds, truth)
        half = _limit(np.abs(np.append(rate[solved], truth[np.isfinite(truth)])), RATES)
        self.axes.set_ylim(-half, half)
        return half


class _Track:
    """The master's way from above, by status."""

    def __init__(self, axes):
        self.axes = axes
        axes.set(aspect="equal", xlabel="east [m]", ylabel="north [m]")
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_major_locator(MaxNLocator(5))
        (self.way,) = axes.plot([], [], color="#bbbbbb", linewidth=1)
        (self.fixed,) = axes.plot([], [], "o", color=FIXED_COLOR, label="fixed", **DOTS)
        (self.float,) = axes.plot([], [], "^", color=FLOAT_COLOR, label="float", **DOTS)
        (self.lost,) = axes.plot([], [], "x", color=NONE_COLOR, label="no solution", linestyle="", markersize=5)
        (self.start,) = axes.plot([], [], "s", color=TRUTH_COLOR, markerfacecolor="none", markersize=8, linestyle="", label="start")
        self.named = [self.fixed, self.float, self.lost, self.start]

    @property
    def moving(self):
        """The artists that change with every result, lowest first."""
        return (self.way, self.lost, self.float, self.fixed, self.start)

    def show(self, result):
        """Fill in the way; return its middle and reach, which are the frame."""
        if result.attitude is None:
            return _cleared(self.moving)
        track, status = result.journey.track, result.attitude.status
        self.way.set_data(*track.T)
        for marks, chosen in ((self.fixed, status == FIXED), (self.float, status == FLOAT), (self.lost, status < FLOAT)):
            marks.set_data(*track[chosen].T)
        self.start.set_data(*track[:1].T)
        middle = (track.min(axis=0) + track.max(axis=0)) / 2
        half = _limit(np.abs(track - middle), REACHES, share=1.0)
        self.axes.set_xlim(middle[0] - half, middle[0] + half)
        self.axes.set_ylim(middle[1] - half, middle[1] + half)
        return *middle, half


def _limit(sizes, limits, share=_NEARLY_ALL):
    """Return the first of the limits that holds nearly all sizes with some room."""
    reach = np.quantile(sizes, share) * 1.1 if sizes.size else 0.0
    return next((limit for limit in limits if limit >= reach), limits[-1])


def _cleared(artists):
    """Empty the artists of a result without an answer; return the frame."""
    for artist in artists:
        if hasattr(artist, "set_text"):
            artist.set_text("")
        elif hasattr(artist, "get_xdata"):
            artist.set_data([], [])
        else:
            artist.set_data([0, 1], [0, 0], [0, 0])
    return None
