"""Lab of lesson 00: which way is north? Two antennas, their observations, heading and pitch."""

from dataclasses import dataclass

import numpy as np

from gnsslab.labs.controls import Choice, FileOrPath, Slider, Switch
from gnsslab.labs.lab import Drawing, Lab, Preset, Readout
from gnsslab.labs.standin import stand_in_attitude, stand_in_truth

FIXED = 2

CONTROLS = (
    Choice(
        "data", "Data", {"simulated": "simulated", "real roof": "real", "my files": "mine"}, "simulated",
        help="Simulated receivers, two real ones on a roof (matrtklib-static), or your own RINEX files.",
    ),
    Slider("mask_deg", "Elevation mask", 5, 60, 5, 15, "deg", help="Satellites lower than this are not used."),
    Choice(
        "systems", "Systems", {"all": "GECJ", "GPS + Galileo": "GE", "GPS": "G", "Galileo": "E", "BeiDou": "C"}, "GECJ",
        help="Whose satellites are used.",
    ),
    Choice("frequencies", "Frequencies", {"one": 1, "two": 2, "three": 3}, 1, help="Carriers used of each satellite."),
    Switch("single_epoch", "Each second alone", True, help="On: no memory. Off: a filter carries the ambiguities on."),
    Slider("carrier_noise", "Carrier noise", 1, 10, 0.5, 3, "mm", help="Of one receiver, one satellite, at the zenith."),
    Slider("length", "Baseline length", 0.3, 5, 0.1, 1.2, "m", help="Distance between the two antennas."),
    Slider("code_noise", "Code noise", 0.1, 1.5, 0.1, 0.4, "m", help="Of one pseudorange at the zenith.", more=True),
    Switch("known_length", "Use the known length", False, more=True, help="Tell the engine the length, to 5 mm."),
    Slider("seed", "Seed", 1, 100, 1, 1, help="Another seed, another draw of the noise.", more=True),
    FileOrPath("master_file", "Master observations"),
    FileOrPath("rover_file", "Rover observations"),
    FileOrPath("navigation_file", "Broadcast navigation"),
)  # fmt: skip
FILES = ("master_file", "rover_file", "navigation_file")
SIMULATION_ONLY = ("carrier_noise", "length", "code_noise", "seed")

PRESETS = (
    Preset("good", "Good antennas", {"carrier_noise": 3, "code_noise": 0.4},
           "Every second is fixed, and the heading holds still to a few tenths of a degree."),
    Preset("cheap", "Cheap antennas", {"carrier_noise": 6, "code_noise": 1.2},
           "Orange triangles: seconds in which the integers were not found. One second alone is no longer enough."),
    Preset("memory", "Cheap, with memory", {"carrier_noise": 6, "code_noise": 1.2, "single_epoch": False},
           "The same noise, but a filter carries the integers on: the triangles are gone after the first seconds."),
    Preset("short", "Arm's length", {"length": 0.3},
           "The same millimetres on a shorter lever: the heading scatters four times as much."),
    Preset("city", "City street", {"mask_deg": 50, "systems": "G"},
           "High walls and one system: too few satellites, and whole stretches without an answer."),
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class NorthResult:
    """An attitude, the truth where it is known, and what to say."""

    attitude: object  # Attitude, None where there is a problem
    truth: object = None  # record with heading, pitch [rad], length [m], None where not known
    problem: str = ""  # one sentence where there is no attitude
    note: str = ""  # one sentence beside the picture


def north_lab():
    """Return a fresh lab with caches of its own."""
    return Lab(
        name="north", title="Which way is north?", controls=CONTROLS, presets=PRESETS,
        compute=NorthEngine().compute, figure=figure, drawings=drawings, describe=describe, readouts=readouts,
        steering=("data",), blocked=blocked,
    )  # fmt: skip


class NorthEngine:
    """The data of one lab instance, kept between moves, and the way from settings to a result."""

    def compute(self, **settings):
        """Return the NorthResult of checked settings; what the engine refuses becomes a sentence."""
        return NorthResult(stand_in_attitude(settings), stand_in_truth(settings))


def blocked(settings):
    """Return for each control without effect on the chosen data the reason why."""
    reasons = {}
    if settings["data"] != "simulated":
        reasons |= dict.fromkeys(SIMULATION_ONLY, "fixed by the real data")
    if settings["data"] != "mine":
        reasons |= dict.fromkeys(FILES, 'choose "my files" first')
    return reasons


def figure(result):
    """Return the whole picture as one matplotlib Figure."""
    from gnsslab.figures.attitude import plot_attitude

    return plot_attitude(result.attitude, result.truth)


def drawings():
    """Return the two pictures of the lab."""
    from gnsslab.figures.attitude import build_angles, build_compass

    return (
        Drawing("angles", lambda part: _of_result(build_angles(part)), 500, 420),
        Drawing("compass", lambda part: _of_result(build_compass(part)), 340, 340),
    )


def _of_result(scene):
    from gnsslab.figures.kept import Scene

    return Scene(scene.moving, lambda result: scene.show((result.attitude, result.truth)))


def describe(result):
    """Return the picture in words."""
    from gnsslab.figures.attitude import describe_attitude

    return describe_attitude(result.attitude, result.truth)


def readouts(result):
    """Return heading, pitch, share of fixed epochs and length."""
    if result.problem:
        return []
    attitude = result.attitude
    best = (attitude.status == attitude.status.max()) & np.isfinite(attitude.heading)
    fixed = f"{100 * np.mean(attitude.status == FIXED):.1f}"
    if not best.any():
        return [Readout("Heading", "none"), Readout("Fixed", fixed, "%"), Readout("Length", "none")]
    east, north = np.median(attitude.baseline_enu[best, :2], axis=0)
    heading = np.degrees(np.arctan2(east, north)) % 360
    return [
        Readout("Heading", f"{heading:.2f}", "deg", f"scatter {_scatter(attitude.heading[best]):.2f} deg"),
        Readout("Pitch", f"{np.degrees(np.median(attitude.pitch[best])):.2f}", "deg",
                f"scatter {_scatter(attitude.pitch[best]):.2f} deg"),
        Readout("Fixed", fixed, "%", f"of {len(attitude.status)} seconds"),
        Readout("Length", f"{np.median(attitude.length[best]):.3f}", "m", f"scatter {1e3 * np.std(attitude.length[best]):.1f} mm"),
    ]  # fmt: skip


def _scatter(angle):
    """Return the standard deviation [deg] of angles [rad] about their mean direction."""
    mean = np.angle(np.mean(np.exp(1j * angle)))
    return float(np.degrees(np.sqrt(np.mean(np.angle(np.exp(1j * (angle - mean))) ** 2))))
