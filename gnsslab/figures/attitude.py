"""Pictures of an attitude: heading and pitch against time, and the baseline seen from above."""

import numpy as np
from matplotlib.patches import Circle, Polygon
from matplotlib.ticker import FixedLocator, MaxNLocator

from gnsslab.figures.kept import Scene, new_figure, styled
from gnsslab.gnss.times import seconds_between

# Colours of Okabe and Ito (2008), told apart by all common kinds of colour blindness; the marker tells it again.
FIXED, FLOAT, NONE = 2, 1, 0
STATUS_STYLE = {
    FLOAT: {"label": "float", "color": "#D98200", "marker": "^", "markersize": 4.5},
    FIXED: {"label": "fixed", "color": "#0072B2", "marker": "o", "markersize": 3.2},
    NONE: {"label": "none", "color": "#A03070", "marker": "x", "markersize": 6, "markeredgewidth": 1.6},
}
BAND_COLOR = "#8FBEE0"
TRUTH_COLOR = "#111111"
HALF_WIDTHS = (0.5, 1, 2, 5, 10, 20, 45, 90, 180)  # [deg], the scales an angle axis snaps to
RADII = (0.5, 0.75, 1, 1.5, 2, 3, 5, 7.5, 10, 15, 20, 30, 50, 100, 200, 500, 1000, 2000, 5000, 10_000)  # [m]


def plot_attitude(attitude, truth=None, figure=None):
    """Draw heading and pitch with their one-sigma bands against time, and the baseline from above; return the Figure.

    truth: optional record with heading and pitch [rad], scalars or (T,), drawn dashed. Colour and marker tell fixed,
    float and none apart.
    """
    with styled():
        figure = figure if figure is not None else new_figure(880, 460)
        time_panels, compass = figure.subfigures(1, 2, width_ratios=(1.5, 1))
        for build, part in ((build_angles, time_panels), (build_compass, compass)):
            build(part).show((attitude, truth))
    return figure


def build_angles(figure):
    """Lay out heading above pitch against time; show((attitude, truth)) fills them in."""
    heading_axes = figure.add_axes((0.145, 0.55, 0.83, 0.36))
    pitch_axes = figure.add_axes((0.145, 0.115, 0.83, 0.36), sharex=heading_axes)
    heading = AnglePanel(heading_axes, "heading [deg]", (0, 360))
    pitch = AnglePanel(pitch_axes, "pitch [deg]", (-90, 90))
    heading_axes.tick_params(labelbottom=False)

    def show(result):
        attitude, truth = result
        shown = _shown(attitude, truth)
        _legend(figure, heading, shown)
        seconds = seconds_between(attitude.time, attitude.time[0]) if len(attitude.time) else np.zeros(0)
        label = f"seconds since {_clock(attitude.time)} (GPS time)"
        pitch_axes.set_xlabel(label)
        return (
            label,
            shown,
            heading.show(seconds, attitude.heading, attitude.sigma_heading, attitude.status, truth and truth.heading),
            pitch.show(seconds, attitude.pitch, attitude.sigma_pitch, attitude.status, truth and truth.pitch),
        )

    return Scene(heading.moving + pitch.moving, show)


class AnglePanel:
    """One angle against time with its sigma band, markers by status, and the truth where it is known."""

    def __init__(self, axes, label, whole):
        self.axes = axes
        self.whole = whole  # (2,) [deg], all that the angle can be
        axes.set_ylabel(label)
        axes.xaxis.set_major_locator(MaxNLocator(6))
        # not fill_between: a single polygon is drawn three times as fast
        self.band = axes.add_patch(Polygon([(0.0, 0.0)], facecolor=BAND_COLOR, alpha=0.5, linewidth=0, label="1 sigma"))
        (self.truth,) = axes.plot([], [], "--", color=TRUTH_COLOR, linewidth=1.4, label="truth")
        self.dots = {status: axes.plot([], [], linestyle="", **style)[0] for status, style in STATUS_STYLE.items()}
        self.dots[NONE].set_transform(axes.get_xaxis_transform())  # no angle to show: a cross at the foot

    @property
    def moving(self):
        """The artists that change with every result, lowest first."""
        return (self.band, self.truth, *self.dots.values())

    def show(self, seconds, angle, sigma, status, truth):
        """Fill in the angles [rad]; return the limits, which are the frame."""
        angle, sigma = np.degrees(angle), np.degrees(sigma)
        truth = np.full(len(seconds), np.nan) if truth is None else np.degrees(np.broadcast_to(truth, len(seconds)))
        center, half = self._show_scale(*_scale(angle, status, truth))
        angle, truth = _near(angle, center), _near(truth, center)
        solved = np.isfinite(angle)
        self.band.set_xy(_outline(seconds[solved], (angle - sigma)[solved], (angle + sigma)[solved]))
        self.truth.set_data(seconds, truth)
        for kind, dots in self.dots.items():
            chosen = status == kind
            dots.set_data(seconds[chosen], np.full(chosen.sum(), 0.05) if kind == NONE else angle[chosen])
        last = float(seconds[-1]) if len(seconds) > 1 else 1.0
        self.axes.set_xlim(-0.01 * last, 1.01 * last)
        return center, half, last

    def _show_scale(self, center, half):
        """Set the axis to center and half width [deg], or to the whole range with round ticks where that is less; return what was set."""
        low, high = self.whole
        if half < (high - low) / 2:
            self.axes.yaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 2.5, 5, 10]))
        else:
            center, half = (low + high) / 2, (high - low) / 2
            self.axes.yaxis.set_major_locator(FixedLocator(np.linspace(low, high, 5)))
        self.axes.set_ylim(center - half, center + half)
        return center, half


def build_compass(figure):
    """Lay out the plan view: north up, master antenna in the middle, the rover where each epoch puts it."""
    axes = figure.add_axes((0.02, 0.06, 0.96, 0.86))
    axes.set_aspect("equal")
    axes.axis("off")
    axes.set_xlim(-1.28, 1.28)
    axes.set_ylim(-1.28, 1.28)
    ring_labels = _compass_card(axes)
    (truth,) = axes.plot([], [], "--", color=TRUTH_COLOR, linewidth=1.2)
    (needle,) = axes.plot([], [], color="#B03000", linewidth=2.4, solid_capstyle="round")
    (tip,) = axes.plot([], [], linestyle="", markersize=13, color="#B03000")
    dots = {kind: axes.plot([], [], linestyle="", **STATUS_STYLE[kind])[0] for kind in (FLOAT, FIXED)}
    (master,) = axes.plot([0], [0], "s", color=TRUTH_COLOR, markersize=6)
    outside = axes.text(-1.27, -1.27, "", fontsize=8, color="#666666", ha="left", va="bottom")

    def show(result):
        attitude, known = result
        radius = _radius(attitude)
        outside.set_text(_outside(attitude, radius))
        for kind, marks in dots.items():
            marks.set_data(*_plan(attitude.baseline_enu[attitude.status == kind], radius))
        end = _typical(attitude) / radius
        needle.set_data([0, end[0]], [0, end[1]])
        tip.set_data(end[:1], end[1:2])
        tip.set_marker((3, 0, -np.degrees(np.arctan2(end[0], end[1]))) if np.isfinite(end).all() else "")
        truth.set_data(*_direction(known))
        for ring, fraction in zip(ring_labels, (0.5, 1.0), strict=True):
            ring.set_text(f"{fraction * radius:g} m")
        return radius

    return Scene((truth, dots[FLOAT], needle, tip, dots[FIXED], master, outside), show)


def describe_attitude(attitude, truth=None):
    """Return the picture in words, for those who cannot see it.

    Says how many epochs were fixed, float or without a solution, and where the baseline points.
    """
    total = len(attitude.status)
    if total == 0:
        return "No epochs to show."
    counts = [f"{np.sum(attitude.status == kind)} {STATUS_STYLE[kind]['label']}" for kind in (FIXED, FLOAT, NONE)]
    text = f"Heading and pitch over {total} epochs ({', '.join(counts)}), and the baseline seen from above."
    east, north = _typical(attitude)
    if not np.isfinite(east):
        return text + " No epoch has a solution."
    best = attitude.status == attitude.status.max()
    text += (
        f" The needle points to {np.degrees(np.arctan2(east, north)) % 360:.1f} degrees;"
        f" pitch {np.degrees(np.median(attitude.pitch[best])):.1f} degrees,"
        f" one sigma of heading {np.degrees(np.median(attitude.sigma_heading[best])):.2f} degrees."
    )
    return text if truth is None else text + f" Truth: {np.degrees(np.ravel(truth.heading)[0]) % 360:.1f} degrees."


def _shown(attitude, truth):
    """Return the labels of what there is to see, most trusted first."""
    statuses = [STATUS_STYLE[kind]["label"] for kind in (FIXED, FLOAT, NONE) if (attitude.status == kind).any()]
    return (*statuses, *(["1 sigma"] if np.isfinite(attitude.heading).any() else []), *(["truth"] if truth is not None else []))


def _legend(figure, panel, shown):
    """Put the legend in one row above the panels: what is shown, and nothing else."""
    handles = {handle.get_label(): handle for handle in panel.moving}
    for old in list(figure.legends):
        old.remove()
    figure.legend(
        handles=[handles[label] for label in shown], loc="upper right", ncols=5, bbox_to_anchor=(0.99, 1.0), fontsize=9,
        handletextpad=0.3, columnspacing=1.0, handlelength=1.4, frameon=False,
    )  # fmt: skip


def _clock(time):
    """Return the first epoch as HH:MM:SS."""
    return str(time[0].astype("datetime64[s]"))[11:] if len(time) else "start"


def _near(angle, center):
    """Return angles [deg] moved by whole turns to within half a turn of the center."""
    return center + (angle - center + 180) % 360 - 180


def _outline(x, low, high):
    """Return the corners (2 T, 2) of the area between two curves: along the lower one, back along the upper one."""
    return np.stack([np.append(x, x[::-1]), np.append(low, high[::-1])], axis=-1)


def _scale(angle, status, truth):
    """Return center and half width [deg] of an axis that holds nearly all angles and the truth, both snapped."""
    best = angle[(status == np.max(status, initial=NONE)) & np.isfinite(angle)]
    if best.size == 0:
        return 0.0, 180.0
    middle = np.median(_near(best, best[0]))
    seen = np.concatenate([angle[np.isfinite(angle)], truth[np.isfinite(truth)]])
    reach = np.quantile(np.abs(_near(seen, middle) - middle), 0.98)
    half = next((h for h in HALF_WIDTHS if h >= 1.25 * reach), HALF_WIDTHS[-1])
    return float(np.round(middle / (half / 2)) * (half / 2)), float(half)


def _compass_card(axes):
    """Draw rings, ticks and the letters of the compass; return the texts of the rings' radii."""
    for radius, width in ((1.0, 1.2), (0.5, 0.8)):
        axes.add_patch(Circle((0, 0), radius, fill=False, edgecolor="#999999", linewidth=width))
    for bearing in range(0, 360, 10):
        inner = 0.93 if bearing % 30 == 0 else 0.97
        east, north = np.sin(np.radians(bearing)), np.cos(np.radians(bearing))
        axes.plot([inner * east, east], [inner * north, north], color="#777777", linewidth=1)
    for bearing, text in ((0, "N"), (90, "E"), (180, "S"), (270, "W")):
        axes.text(
            1.13 * np.sin(np.radians(bearing)), 1.13 * np.cos(np.radians(bearing)), text,
            ha="center", va="center", fontsize=13, fontweight="bold", color="#B03000" if text == "N" else "#333333",
        )  # fmt: skip
    return [axes.text(0.03, -r + 0.03, "", fontsize=8, color="#666666", va="bottom") for r in (0.5, 1.0)]


def _typical(attitude):
    """Return the median east and north [m] of the best epochs, NaN where no epoch has a solution."""
    best = (attitude.status == np.max(attitude.status, initial=NONE)) & np.isfinite(attitude.heading)
    return np.median(attitude.baseline_enu[best, :2], axis=0) if best.any() else np.full(2, np.nan)


def _radius(attitude):
    """Return the radius of the card [m]: room for the needle, and for most epochs as long as the needle stays in sight."""
    horizontal = np.hypot(*attitude.baseline_enu[:, :2].T)
    horizontal = horizontal[np.isfinite(horizontal)]
    if horizontal.size == 0:
        return RADII[0]
    needle = np.hypot(*_typical(attitude))
    reach = np.clip(1.1 * np.quantile(horizontal, 0.9), 1.15 * needle, 2.5 * needle)
    return next((radius for radius in RADII if radius >= reach), float(reach))


def _plan(baseline_enu, radius):
    """Return east and north on the card, without those that fall outside it."""
    east, north = baseline_enu[:, :2].T / radius
    inside = np.hypot(east, north) <= 1.0
    return east[inside], north[inside]


def _outside(attitude, radius):
    """Return how many epochs lie beyond the card, in words; nothing where all are on it."""
    beyond = int(np.sum(np.hypot(*attitude.baseline_enu[:, :2].T) > radius))
    return f"{beyond} more lie further out" if beyond else ""


def _direction(truth):
    """Return a line from the middle to the rim along the true heading, empty where it is not known or not one value."""
    if truth is None or (np.ndim(truth.heading) > 0 and np.ptp(truth.heading) > 0):
        return [], []
    heading = np.ravel(truth.heading)[0]
    return [0, np.sin(heading)], [0, np.cos(heading)]
