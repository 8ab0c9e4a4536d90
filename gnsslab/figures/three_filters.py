"""Pictures of paper A's three solutions: errors of heading, pitch and length over time, and the baseline from above."""

import numpy as np
from matplotlib.lines import Line2D
from matplotlib.patches import Polygon
from matplotlib.ticker import FixedFormatter, FixedLocator, MaxNLocator, NullLocator

from gnsslab.figures.kept import Scene, new_figure, styled

STYLES = {
    "direct": {"label": "direct", "color": "#D98200", "marker": "^", "markersize": 3.6, "linestyle": ""},
    "length": {"label": "+ length", "color": "#0072B2", "marker": "o", "markersize": 3.2, "linestyle": ""},
    "position": {"label": "+ length + (29)", "color": "#00805C", "linewidth": 1.1},
}
SHORT = {"direct": "direct", "length": "+ length", "position": "+ (29)"}
BAND_COLOR, LOST_COLOR, MISSING_COLOR, TRUTH_COLOR = "#BFD9EC", "#777777", "#A03070", "#111111"
EVEN_ANGLE, EVEN_LENGTH = 1.0, 10.0  # [deg], [mm], within which a scale is even; beyond, each step is tenfold
HALF_WIDTHS = (0.01, 0.02, 0.03, 0.05, 0.1, 0.2, 0.5, 1, 2, 5)  # [m], of the plan at rest
METRES_FROM = 0.5  # [m], half width
MM = 1e-3


def plot_three_filters(result, figure=None):
    """Draw both pictures of a ThreeFiltersResult side by side; return the Figure."""
    with styled():
        figure = figure if figure is not None else new_figure(800, 510)
        errors, plan = figure.subfigures(1, 2, width_ratios=(460, 340))
        for build, part in ((build_errors, errors), (build_plan, plan)):
            build(part).show(result)
    return figure


def build_errors(figure):
    """Lay out three panels of errors against time and a strip of what is not fixed; show(result) fills them in."""
    frames = [figure.add_axes((0.155, bottom, 0.81, 0.225)) for bottom in (0.665, 0.415, 0.165)]
    angles = [_Panel(frames[0], "heading error [deg]", EVEN_ANGLE, 180), _Panel(frames[1], "pitch error [deg]", EVEN_ANGLE, 90)]
    lengths, strip = _Panel(frames[2], "length error [mm]", EVEN_LENGTH, 5000), _Strip(figure.add_axes((0.155, 0.075, 0.81, 0.07)))
    panels = (*angles, lengths)
    for panel in panels:
        panel.axes.tick_params(labelbottom=False)
    _legend(figure, panels[0])
    figure.text(0.965, 0.897, "even scale between the grey lines, tenfold steps beyond", fontsize=8.5, color="#555555", ha="right", va="bottom")

    def show(result):
        chosen = result.chosen
        for panel, name, sigma in zip(panels, ("heading_error", "pitch_error", None), (chosen.sigma_heading, chosen.sigma_pitch, None), strict=True):
            errors = {mode: (found.length - result.settings["length"]) / MM if name is None else getattr(found, name)
                      for mode, found in result.solutions.items()}  # fmt: skip
            panel.show(result, errors, sigma)
        strip.show(result)
        return float(result.seconds[-1]), result.lost, tuple(result.missing)

    return Scene(tuple(artist for part in (*panels, strip) for artist in part.moving), show)


class _Panel:
    """One error against time by all modes, with the claimed sigma about zero; even near zero and tenfold steps beyond."""

    def __init__(self, axes, label, even, most):
        self.axes = axes
        axes.set_ylabel(label, fontsize=9.5, labelpad=1)
        axes.set_yscale("symlog", linthresh=even, linscale=1.6)
        axes.set_ylim(-most, most)
        _set_ticks(axes, even, most)
        axes.xaxis.set_major_locator(MaxNLocator(7))
        for edge in (-even, even):
            axes.axhline(edge, color="#BBBBBB", linewidth=0.8)
        self.lost, self.missing = (axes.plot([], [], transform=axes.get_xaxis_transform(), **style)[0] for style in _EVENTS)
        self.band = axes.add_patch(Polygon([(0.0, 0.0)], facecolor=BAND_COLOR, linewidth=0, label="claimed sigma"))
        self.truth = axes.axhline(0, color=TRUTH_COLOR, linewidth=1)
        self.marks = {mode: axes.plot([], [], **style)[0] for mode, style in STYLES.items()}

    @property
    def moving(self):
        """The artists that change with every result, lowest first."""
        return (self.band, self.lost, self.missing, self.truth, *self.marks.values())

    def show(self, result, errors, sigma):
        """Fill in the errors (T,) of each mode and the sigma (T,), if any."""
        _show_events(self, result)
        for mode, marks in self.marks.items():
            marks.set_data(result.seconds, errors[mode])
        known = np.isfinite(sigma) if sigma is not None else np.zeros(0, bool)
        self.band.set_visible(bool(known.any()))
        if known.any():
            self.band.set_xy(_outline(result.seconds[known], sigma[known]))


class _Strip:
    """Below the panels: one row for each mode, with a bar where its epoch is not fixed."""

    def __init__(self, axes):
        self.axes = axes
        self.rows = dict(zip(STYLES, (2, 1, 0), strict=True))
        axes.set_ylim(-0.6, 2.6)
        axes.set_yticks(list(self.rows.values()), [SHORT[mode] for mode in self.rows], fontsize=8)
        axes.tick_params(left=False)
        axes.grid(False, axis="y")
        axes.xaxis.set_major_locator(MaxNLocator(7))
        axes.set_xlabel("seconds since the start; bars: not fixed", labelpad=1)
        self.bars = {mode: axes.plot([], [], color=style["color"], linewidth=5, solid_capstyle="butt")[0] for mode, style in STYLES.items()}

    @property
    def moving(self):
        """The artists that change with every result, lowest first."""
        return tuple(self.bars.values())

    def show(self, result):
        """Draw the bars."""
        _set_span(self.axes, result)
        for mode, bar in self.bars.items():
            first, last = _spans(result.seconds, ~result.solutions[mode].is_fixed)
            ends = np.stack([first - 0.5, last + 0.5, np.full(len(first), np.nan)], axis=-1)
            bar.set_data(np.ravel(ends), np.full(ends.size, self.rows[mode]))


_EVENTS = (
    {"label": "lock lost", "color": LOST_COLOR, "linestyle": "--", "linewidth": 1.1},
    {"label": "master missing", "color": MISSING_COLOR, "linestyle": ":", "linewidth": 1.6},
)


def _legend(figure, panel):
    handles = [*panel.marks.values(), panel.band, panel.lost, panel.missing]
    figure.legend(
        handles=handles, loc="upper center", ncols=3, bbox_to_anchor=(0.54, 1.005), fontsize=9, markerscale=1.8,
        handlelength=1.6, columnspacing=1.4, labelspacing=0.25,
    )  # fmt: skip


def _set_ticks(axes, even, most):
    """Label zero and powers of ten on both sides, and nothing between."""
    powers = even * 10.0 ** np.arange(int(np.log10(most / even)) + 1)
    places = np.concatenate([-powers[::-1], [0.0], powers])
    axes.yaxis.set_major_locator(FixedLocator(places))
    axes.yaxis.set_major_formatter(FixedFormatter([f"{place:g}" for place in places]))
    axes.yaxis.set_minor_locator(NullLocator())


def _set_span(axes, result):
    last = float(result.seconds[-1])
    axes.set_xlim(-0.01 * last, 1.01 * last)


def _show_events(panel, result):
    """Draw upright lines where lock is lost and where the master has no epoch."""
    _set_span(panel.axes, result)
    for lines, places in ((panel.lost, result.lost), (panel.missing, result.missing)):
        lines.set_data(np.repeat(places, 3), np.tile([0.0, 1.0, np.nan], len(places)))


def _outline(seconds, sigma):
    """Return the corners (2 T, 2) of the area from -sigma to sigma."""
    return np.column_stack([np.append(seconds, seconds[::-1]), np.append(sigma, -sigma[::-1])])


def _spans(seconds, chosen):
    """Return the first and last second of each run of chosen epochs."""
    steps = np.diff(chosen.astype(int), prepend=0, append=0)
    return seconds[np.flatnonzero(steps > 0)], seconds[np.flatnonzero(steps < 0) - 1]


PLAN_STYLES = STYLES | {
    "length": STYLES["length"] | {"markersize": 5},
    "position": {"label": "+ length + (29)", "color": "#5FD3AE", "marker": "D", "markersize": 2.2, "linestyle": ""},
}


def build_plan(figure):
    """Lay out the baseline from above; show(result) fills it in: about its true end in millimetres, or all around in metres."""
    axes = figure.add_axes((0.185, 0.12, 0.79, 0.72))
    axes.set_aspect("equal")
    axes.xaxis.set_major_locator(MaxNLocator(5, symmetric=True))
    axes.yaxis.set_major_locator(MaxNLocator(5, symmetric=True))
    (circle,) = axes.plot([], [], color="#999999", linewidth=1.2, label="true length")
    marks = {mode: axes.plot([], [], **style)[0] for mode, style in PLAN_STYLES.items()}
    (truth,) = axes.plot([], [], "x", color=TRUTH_COLOR, markersize=10, markeredgewidth=2, label="truth")
    (stale,) = axes.plot([], [], "o", color=MISSING_COLOR, markerfacecolor="none", markersize=12, markeredgewidth=1.6, linestyle="", label="missing")
    outside = axes.text(0.01, 1.01, "", transform=axes.transAxes, fontsize=8.5, color="#555555", va="bottom")
    handles = [*marks.values(), Line2D([], [], color="#999999", label="true length")]
    figure.legend(handles=handles, loc="upper center", ncols=2, bbox_to_anchor=(0.54, 1.005), fontsize=9, markerscale=1.4, handlelength=1.4,
                  labelspacing=0.25, columnspacing=1.4)  # fmt: skip

    def show(result):
        origin, unit, half = _view(result)
        places = {mode: (found.baseline[:, :2] - origin) / unit for mode, found in result.solutions.items()}
        for mode, dots in marks.items():
            dots.set_data(*places[mode].T)
        circle.set_data(*_level_circle(result, origin, unit).T)
        truth.set_data(*((result.truth[:1, :2] - origin) / unit).T if _at_rest(result) else ([], []))
        is_stale = np.isin(result.seconds, result.missing)
        stale.set_data(*places["length"][is_stale].T)
        outside.set_text(_outside_words(places, half))
        axes.set_xlim(-half, half)
        axes.set_ylim(-half, half)
        where = f"{'of the truth ' if _at_rest(result) else ''}[{'mm' if unit == MM else 'm'}]"
        axes.set_xlabel(f"east {where}", labelpad=1)
        axes.set_ylabel(f"north {where}", labelpad=0)
        return half, where

    return Scene((circle, marks["direct"], stale, marks["length"], marks["position"], truth, outside), show)


def _view(result):
    """Return the origin (2,) [m], the unit [m] and the half width of the plan in it: all around, or about the truth where that rests."""
    if not _at_rest(result):
        return np.zeros(2), 1.0, 1.25 * result.settings["length"]
    origin = result.truth[0, :2]
    off = np.linalg.norm(result.chosen.baseline[:, :2] - origin, axis=-1)[result.settled]
    reach = 1.2 * np.quantile(off[np.isfinite(off)], 0.98) if np.isfinite(off).any() else HALF_WIDTHS[-1]
    half = next((width for width in HALF_WIDTHS if width >= reach), HALF_WIDTHS[-1])
    unit = 1.0 if half >= METRES_FROM else MM
    return origin, unit, half / unit


def _at_rest(result):
    return np.ptp(result.truth[:, 0]) == 0


def _level_circle(result, origin, unit):
    """Return the circle (k, 2) on which the antenna stands if length and pitch are true; near the truth only, and finely, in millimetres."""
    span = np.pi if unit == 1.0 else 0.5
    angle = np.arctan2(*origin) + np.linspace(-span, span, 361)
    radius = np.linalg.norm(result.truth[0, :2])
    return (radius * np.column_stack([np.sin(angle), np.cos(angle)]) - origin) / unit


def _outside_words(places, half):
    """Return how many dots lie beyond the frame, by mode; nothing where none does."""
    beyond = {mode: int(np.sum(np.abs(place).max(axis=-1) > half)) for mode, place in places.items()}
    words = ", ".join(f"{SHORT[mode]} {count}" for mode, count in beyond.items() if count)
    return f"further out: {words}" if words else ""


def describe_three_filters(result):
    """Return the pictures in words, for those who cannot see them."""
    events = [f"lock is lost at {' and '.join(f'{second:g}' for second in result.lost)} s"]
    if len(result.missing):
        events.append(f"the master's epochs are missing from {result.missing[0]:g} to {result.missing[-1]:g} s")
    modes = "; ".join(_mode_words(result, mode) for mode in result.solutions)
    return (
        f"Errors of heading, pitch and length over {len(result.seconds)} epochs, and the baseline from above; {', '.join(events)}. "
        f"Largest errors once settled: {modes}."
    )


def _mode_words(result, mode):
    found = result.solutions[mode]
    largest = [np.max(np.abs(error[result.settled & np.isfinite(error)]), initial=-1.0) for error in (found.heading_error, found.pitch_error)]
    if min(largest) < 0:
        return f"{STYLES[mode]['label']} has no answer"
    return f"{STYLES[mode]['label']} {largest[0]:.1f} degrees of heading and {largest[1]:.1f} of pitch"
