"""Pictures of a sky: where the satellites stand, and how much their codes err by elevation."""

import numpy as np
from matplotlib.patches import Circle

from gnsslab.figures.kept import Scene, new_figure, styled

# Colours of Okabe and Ito (2008); the marker tells the system again, a hollow one that a satellite is not used.
SYSTEM_STYLE = {
    "G": {"label": "GPS", "color": "#0072B2", "marker": "o"},
    "E": {"label": "Galileo", "color": "#D98200", "marker": "s"},
    "C": {"label": "BeiDou", "color": "#A03070", "marker": "^"},
    "J": {"label": "QZSS", "color": "#007A5A", "marker": "D"},
}
BAND_COLOR = "#8FBEE0"
MASK_COLOR = "#B03000"
MOST_NAMES = 16  # satellites named; of more the names would hide each other
HALF_WIDTHS = (1, 2, 5, 10, 20, 50, 100, 1000, 10_000)  # [m]


def plot_sky(view, figure=None):
    """Draw a View: the residuals by elevation with the promised sigma, and the sky; return the Figure."""
    with styled():
        figure = figure if figure is not None else new_figure(880, 420)
        for build, part in zip((build_residuals, build_sky), figure.subfigures(1, 2, width_ratios=(1.25, 1)), strict=True):
            build(part).show(view)
    return figure


def build_sky(figure):
    """Lay out the sky: zenith in the middle, horizon at the rim, north up, east to the right; show(view) fills it in."""
    axes = figure.add_axes((0.03, 0.02, 0.94, 0.88))
    axes.set_aspect("equal")
    axes.axis("off")
    axes.set_xlim(-1.18, 1.18)
    axes.set_ylim(-1.18, 1.18)
    _sky_card(axes)
    (mask,) = axes.plot([], [], "--", color=MASK_COLOR, linewidth=1.4)
    used = {system: axes.plot([], [], linestyle="", markersize=9, **style)[0] for system, style in SYSTEM_STYLE.items()}
    unused = {system: axes.plot([], [], linestyle="", markersize=8, fillstyle="none", **style)[0] for system, style in SYSTEM_STYLE.items()}
    dop = axes.text(-1.16, -1.12, "", fontsize=9, ha="left", va="bottom")
    names = [axes.text(0, 0, "", fontsize=8, ha="left", va="center", color="#333333") for _ in range(MOST_NAMES)]
    figure.legend(handles=[*used.values(), mask], labels=[*(s["label"] for s in SYSTEM_STYLE.values()), "mask"], **_legend_place(5))

    def show(view):
        east, north = _on_card(view.azimuth[view.shown], view.elevation[view.shown])
        is_used, letters = view.used[view.shown], np.array([name[0] for name in view.names])
        for system in SYSTEM_STYLE:
            for dots, chosen in ((used[system], is_used), (unused[system], ~is_used & np.isfinite(east))):
                dots.set_data(east[chosen & (letters == system)], north[chosen & (letters == system)])
        mask.set_data(*_ring(view.mask))
        dop.set_text(f"HDOP {view.dop[2]:.2f}\nVDOP {view.dop[3]:.2f}")
        _name_satellites(names, view.names, east, north)
        return 0  # the card never changes

    return Scene((mask, *unused.values(), *used.values(), dop, *names), show)


def build_residuals(figure):
    """Lay out the residuals [m] by elevation with the promised sigma; show(view) fills them in."""
    axes = figure.add_axes((0.115, 0.115, 0.855, 0.76))
    axes.set_xlim(0, 90)
    axes.set_xticks(range(0, 91, 15))
    axes.set_xlabel("elevation [deg]")
    axes.set_title("residuals of the code [m]", loc="left", fontsize=9, color="#555555", pad=4)
    band = axes.fill_between([0.0], [0.0], [0.0], color=BAND_COLOR, alpha=0.5, linewidth=1)
    (mask,) = axes.plot([], [], "--", color=MASK_COLOR, linewidth=1.4, transform=axes.get_xaxis_transform())
    dots = {system: axes.plot([], [], linestyle="", markersize=3.5, **style)[0] for system, style in SYSTEM_STYLE.items()}
    figure.legend(handles=[*dots.values(), band, mask], labels=[*(s["label"] for s in SYSTEM_STYLE.values()), "1 sigma", "mask"], **_legend_place(6))

    def show(view):
        letters = np.array([name[0] for name in view.names])
        for system, marks in dots.items():
            marks.set_data(np.degrees(view.elevation[:, letters == system]).ravel(), view.residual[:, letters == system].ravel())
        band.set_data(np.degrees(view.law_elevation), -view.law_sigma, view.law_sigma)
        mask.set_data([np.degrees(view.mask)] * 2, [0, 1])
        reach = np.max(np.abs(view.residual[np.isfinite(view.residual)]), initial=0.0)
        half = next((half for half in HALF_WIDTHS if half >= 1.05 * reach), float(1.05 * reach))
        axes.set_ylim(-half, half)
        return half

    return Scene((band, mask, *dots.values()), show)


def describe_sky(view):
    """Return the picture in words, for those who cannot see it."""
    above, used = int((view.elevation[view.shown] > 0).sum()), int(view.used[view.shown].sum())
    text = f"A sky with {above} satellites above the horizon, {used} of them used above the mask of {np.degrees(view.mask):.0f} degrees;"
    text += f" HDOP {view.dop[2]:.2f}, VDOP {view.dop[3]:.2f}. Residuals by elevation:"
    low, high = (_scatter(view, *limits) for limits in ((0, 30), (30, 90)))
    return text + f" scatter {low} below 30 degrees and {high} above; {100 * view.within:.0f} percent lie within one sigma."


def _scatter(view, lowest, highest):
    """Return the root mean square of the residuals between two elevations [deg], in words."""
    chosen = (np.degrees(view.elevation) >= lowest) & (np.degrees(view.elevation) < highest) & np.isfinite(view.residual)
    return f"{np.sqrt(np.mean(view.residual[chosen] ** 2)):.2f} metres" if chosen.any() else "none"


def _sky_card(axes):
    """Draw rings at 0, 30 and 60 degrees of elevation, the cross and the letters of the compass."""
    for elevation in (0, 30, 60):
        axes.add_patch(Circle((0, 0), 1 - elevation / 90, fill=False, edgecolor="#999999", linewidth=1.2 if elevation == 0 else 0.8))
        axes.text(0.02, 1 - elevation / 90 - 0.02, f"{elevation}°", fontsize=8, color="#666666", va="top")
    for azimuth, text in ((0, "N"), (90, "E"), (180, "S"), (270, "W")):
        east, north = np.sin(np.radians(azimuth)), np.cos(np.radians(azimuth))
        axes.plot([0, east], [0, north], color="#dddddd", linewidth=0.8, zorder=0)
        axes.text(
            1.09 * east, 1.09 * north, text, ha="center", va="center", fontsize=13, fontweight="bold", color="#B03000" if text == "N" else "#333333"
        )


def _on_card(azimuth, elevation):
    """Return east and north on the card, NaN below the horizon."""
    radius = np.where(elevation > 0, 1 - elevation / (np.pi / 2), np.nan)
    return radius * np.sin(azimuth), radius * np.cos(azimuth)


def _ring(elevation):
    turn = np.linspace(0, 2 * np.pi, 73)
    return _on_card(turn, np.full(73, max(elevation, 1e-6)))


def _name_satellites(texts, names, east, north):
    """Write names beside the satellites in sight, none where there are too many."""
    seen = np.flatnonzero(np.isfinite(east))
    for text in texts:
        text.set_text("")
    if len(seen) <= len(texts):
        for text, k in zip(texts, seen, strict=False):
            text.set_position((east[k] + 0.06, north[k]))
            text.set_text(names[k])


def _legend_place(columns):
    place = {"loc": "upper right", "ncols": columns, "bbox_to_anchor": (0.99, 1.0), "fontsize": 9}
    return place | {"handletextpad": 0.2, "columnspacing": 0.8, "handlelength": 1.2}
