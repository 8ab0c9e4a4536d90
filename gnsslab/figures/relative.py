"""Picture of a relative solution: east, north and up against time."""

import numpy as np

from gnsslab.figures.attitude import STATUS_STYLE
from gnsslab.figures.kept import new_figure, styled
from gnsslab.gnss.times import iso_text, seconds_between

BAND_COLOR = "#8FBEE0"


def plot_relative(relative):
    """Draw east, north and up [m] from base to rover with their one-sigma bands against time; return the Figure.

    Colour and marker tell fixed and float apart, a cross at the foot marks an epoch without solution.
    """
    with styled():
        figure = new_figure(880, 620)
        panels = figure.subplots(3, 1, sharex=True, gridspec_kw={"left": 0.12, "right": 0.98, "bottom": 0.09, "top": 0.94, "hspace": 0.12})
        seconds = seconds_between(relative.time, relative.time[0])
        for k, (axes, name) in enumerate(zip(panels, ("east", "north", "up"), strict=True)):
            _panel(axes, seconds, relative.baseline_enu[:, k], np.sqrt(relative.Q_enu[:, k, k]), relative.status)
            axes.set_ylabel(f"{name} [m]")
        panels[-1].set_xlabel(f"seconds since {iso_text(relative.time[0])} (GPS time)")
        panels[0].legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=4, fontsize=9)
    return figure


def _panel(axes, seconds, value, sigma, status):
    axes.ticklabel_format(useOffset=False)
    axes.fill_between(seconds, value - sigma, value + sigma, color=BAND_COLOR, alpha=0.5, linewidth=0, label="1 sigma")
    for kind, style in STATUS_STYLE.items():
        chosen = status == kind
        if kind:
            axes.plot(seconds[chosen], value[chosen], linestyle="", **style)
        elif chosen.any():
            axes.plot(seconds[chosen], np.full(chosen.sum(), 0.05), linestyle="", transform=axes.get_xaxis_transform(), **style)
