"""Pictures of one satellite's signal: code against carrier, carrier against carrier, range rates, and what the equation leaves."""

import numpy as np
from matplotlib.ticker import MaxNLocator

from gnsslab.figures.kept import Scene, new_figure, styled

# Colours of Okabe and Ito (2008); the marker tells code (dots) and carrier (line) apart as well.
CODE = {"color": "#0072B2", "marker": ".", "markersize": 4, "linestyle": ""}
CARRIER = {"color": "#B03000", "linewidth": 1.2}
IONOSPHERE = {"color": "#111111", "linewidth": 1.2, "linestyle": "--"}
PLACED = {"color": "#888888", "linewidth": 1.2, "linestyle": ":"}
FOUND = {"color": "#A03070", "marker": "v", "markersize": 9, "linestyle": ""}
METRES = (0.5, 1, 2, 5, 10, 20, 50, 100, 1000)  # half widths an axis snaps to
MILLIMETRES = (10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10_000, 100_000)
RATES = (0.5, 1, 2, 5, 10, 20, 100, 1000)  # [m/s]
LEFT = (2, 20, 200, 2000, 20_000, 200_000, 2_000_000)  # [m]
MM = 1e-3


def plot_signal(track, figure=None):
    """Draw one satellite's Track: code minus carrier above the carrier alone, range rates above what the equation leaves."""
    with styled():
        figure = figure if figure is not None else new_figure(880, 420)
        for build, part in zip((build_signal, build_rates), figure.subfigures(1, 2, width_ratios=(1.3, 1)), strict=True):
            build(part).show(track)
    return figure


def build_signal(figure):
    """Lay out code minus carrier [m] above the carrier alone [mm]; show(track) fills them in."""
    upper, lower = _stacked(figure, 0.12, "code minus carrier, and the carrier [m]", "the carrier alone, enlarged [mm]")
    (code,) = upper.plot([], [], label="code - carrier", **CODE)
    (thin,) = upper.plot([], [], label="carrier alone", **CARRIER)
    (twice,) = upper.plot([], [], label="twice the ionosphere", **IONOSPHERE)
    (found,) = upper.plot([], [], label="slip found", transform=upper.get_xaxis_transform(), **FOUND)
    (fine,) = lower.plot([], [], **CARRIER)
    placed = [axes.plot([], [], transform=axes.get_xaxis_transform(), **PLACED)[0] for axes in (upper, lower)]
    figure.legend(handles=[code, thin, twice, found], **_legend_place())

    def show(track):
        code.set_data(track.seconds, track.code_minus_carrier)
        thin.set_data(track.seconds, track.carrier)
        fine.set_data(track.seconds, track.carrier / MM)
        twice.set_data(track.seconds, track.ionosphere_twice)
        found.set_data(track.seconds[track.found], np.full(track.found.sum(), 0.95))
        for line in placed:
            line.set_data(*_upright(track))
        return (
            _snapped(upper, METRES, track.code_minus_carrier),
            _snapped(lower, MILLIMETRES, track.carrier / MM),
            _time_axis((upper, lower), track),
        )

    return Scene((twice, code, thin, found, fine, *placed), show)


def build_rates(figure):
    """Lay out range rates of code and carrier less the Doppler's above what the equation leaves of the carrier; show(track) fills them in."""
    upper, lower = _stacked(figure, 0.17, "range rate less the Doppler's [m/s]", "carrier less its equation [m]")
    (code,) = upper.plot([], [], label="by the code", **CODE)
    (carrier,) = upper.plot([], [], label="by the carrier", **CARRIER)
    (left,) = lower.plot([], [], color="#007A5A", linewidth=1.6)
    figure.legend(handles=[code, carrier], **_legend_place())

    def show(track):
        code.set_data(track.seconds, track.code_rate)
        carrier.set_data(track.seconds, track.carrier_rate)
        left.set_data(track.seconds, track.left)
        return _snapped(upper, RATES, track.code_rate, 0.9), _snapped(lower, LEFT, track.left), _time_axis((upper, lower), track)

    return Scene((code, carrier, left), show)


def describe_signal(track):
    """Return the picture in words, for those who cannot see it."""
    text = f"{track.satellite} at {np.degrees(track.elevation):.0f} degrees over {len(track.time)} epochs: code minus carrier scatters by"
    text += f" {track.sigma_code:.2f} metres,"
    text += f" the carrier alone by {track.sigma_carrier / MM:.1f} millimetres." if np.isfinite(track.sigma_carrier) else " one carrier only."
    if track.placed >= 0:
        word = "finds" if track.found[track.placed] else "misses"
        text += f" A slip at {track.seconds[track.placed]:.0f} s moves code minus carrier by {track.step:.2f} metres; the engine {word} it."
    return text + f" The equation leaves {_reach(track.left):.3g} metres at most."


def _stacked(figure, left, name_above, name_below):
    """Return two axes, one above the other, each under its name, with one time below."""
    upper = figure.add_axes((left, 0.54, 0.96 - left, 0.335))
    lower = figure.add_axes((left, 0.115, 0.96 - left, 0.335), sharex=upper)
    for axes, name in ((upper, name_above), (lower, name_below)):
        axes.set_title(name, loc="left", fontsize=9, color="#555555", pad=4)
    upper.tick_params(labelbottom=False)
    lower.xaxis.set_major_locator(MaxNLocator(6))
    return upper, lower


def _legend_place():
    place = {"loc": "upper right", "ncols": 4, "bbox_to_anchor": (0.99, 1.0), "fontsize": 9}
    return place | {"handletextpad": 0.3, "columnspacing": 1.0, "handlelength": 1.4}


def _upright(track):
    """Return a line from foot to top where the slip was placed, empty without."""
    return ([], []) if track.placed < 0 else ([track.seconds[track.placed]] * 2, [0, 1])


def _snapped(axes, half_widths, values, share=1.0):
    """Set the axis about zero to the first half width that holds that share of the values; return it."""
    reach = _reach(values, share)
    half = next((half for half in half_widths if half >= 1.1 * reach), float(1.1 * reach))
    axes.set_ylim(-half, half)
    return half


def _reach(values, share=1.0):
    known = np.abs(values[np.isfinite(values)])
    return float(np.quantile(known, share)) if known.size else 0.0


def _time_axis(pair, track):
    """Set limits and label of the time axis; return both."""
    last = float(track.seconds[-1]) if len(track.seconds) > 1 else 1.0
    label = f"seconds since {str(track.time[0].astype('datetime64[s]'))[11:]} (GPS time)"
    pair[0].set_xlim(-0.01 * last, 1.01 * last)
    pair[1].set_xlabel(label)
    return last, label
