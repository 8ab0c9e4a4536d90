"""Lab of lesson 00: heading, pitch and their sigma by the formulas of paper A, as printed and as corrected."""

from dataclasses import dataclass

import numpy as np

from gnsslab.core.rotations import heading_pitch_of, rotation_from_heading_pitch_roll, within_half_turn
from gnsslab.labs.controls import Choice, Slider
from gnsslab.labs.lab import Drawing, Goal, Lab, Preset, Readout, standing
from gnsslab.systems.dual_antenna import angle_sigmas
from gnsslab.systems.printed_attitude import heading_as_printed, pitch_as_printed, sigma_heading_as_printed, sigma_pitch_as_printed

MM = 1e-3  # [m]
POINTS = 2000  # of each curve, and drawn beams: a sigma counted from so many is good to 1.6 %
STEEPEST = 80.0  # [deg]

CONTROLS = (
    Choice("formula", "Formula", {"as printed": "printed", "corrected": "corrected"}, "printed",
           help="Equations (5), (6), (33) and (34) of the paper."),
    Slider("heading_deg", "True heading", 0, 360, 5, 120, "deg", help="Where the beam really points."),
    Slider("pitch_deg", "True pitch", -STEEPEST, STEEPEST, 1, 20, "deg", help="How steep it really is."),
    Slider("length", "Baseline length", 0.3, 5, 0.1, 1.2, "m", help="From the first antenna to the second."),
    Slider("sigma_n", "Sigma north", 1, 20, 1, 9, "mm", help="Of the beam's far end, to the north."),
    Slider("sigma_e", "Sigma east", 1, 20, 1, 6, "mm", help="To the east.", more=True),
    Slider("sigma_u", "Sigma up", 1, 40, 1, 16, "mm", help="Upwards.", more=True),
    Slider("seed", "Seed", 1, 100, 1, 1, help="Another seed is another draw of the beams.", more=True),
)  # fmt: skip

PRESETS = (
    Preset("misprint", "As printed", {},
           "A beam to the south-east comes out half a turn off, and 1.3 deg too steep. Now set Formula to corrected."),
    Preset("level", "Level roof", {"heading_deg": 35, "pitch_deg": 2},
           "Northward and nearly level: both printed angles are right to a thousandth of a degree. So nobody noticed."),
    Preset("south", "Southward", {"heading_deg": 200, "pitch_deg": 0},
           "Level, but to the south: the quotient of two minus signs is plus, and the arrow points to the north."),
    Preset("steep", "Steep mast", {"heading_deg": 35, "pitch_deg": 40},
           "The arcsin of a tangent: 40 deg become 57. Each degree more now costs several."),
    Preset("none", "Too steep", {"heading_deg": 35, "pitch_deg": 50},
           "Above 45 deg the tangent exceeds one, and there is no arcsin: the printed formula has no answer."),
    Preset("sigma", "East or west", {"heading_deg": 90, "pitch_deg": 0, "sigma_n": 4},
           "The printed sigma forgets a square: for 0.004 m it takes the root, 0.063 m, and is sixteen times too large."),
    Preset("mended", "All corrected", {"formula": "corrected"},
           "Both errors lie on zero, and the dashed lines hold two thirds of the drawn beams: that is what a sigma says."),
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class Formulas:
    """What one set of formulas says of a beam; NaN where it has no answer."""

    heading: float  # [rad]
    pitch: float  # [rad]
    sigma_heading: float  # [rad]
    sigma_pitch: float  # [rad]
    heading_errors: np.ndarray  # (POINTS,) [deg], at all headings
    pitch_errors: np.ndarray  # (POINTS,) [deg], at all pitches


@dataclass(frozen=True, eq=False)
class PrintedAnglesResult:
    """A beam as it is, what both sets of formulas say of it, and how beams with its errors really scatter."""

    settings: dict  # of the controls, all of them
    printed: Formulas
    corrected: Formulas
    headings_deg: np.ndarray  # (POINTS,), 0 to 360
    pitches_deg: np.ndarray  # (POINTS,), -80 to 80
    drawn_heading: np.ndarray  # (POINTS,) [deg], of drawn beams, less the true one
    drawn_pitch: np.ndarray  # (POINTS,) [deg]
    problem: str = ""
    note: str = ""

    @property
    def chosen(self):
        """The formulas that the control asks for."""
        return getattr(self, self.settings["formula"])

    @property
    def heading_error(self):
        """Of the chosen formula [deg], -90 to 270."""
        return _turn(np.degrees(self.chosen.heading) - self.settings["heading_deg"])

    @property
    def pitch_error(self):
        """Of the chosen formula [deg], NaN where it has no answer."""
        return float(np.degrees(self.chosen.pitch) - self.settings["pitch_deg"])


def printed_angles_lab():
    """Return a fresh lab."""
    return Lab(
        name="printed", title="Find the printed error", controls=CONTROLS, presets=PRESETS, goals=GOALS, compute=compute,
        figure=figure, drawings=drawings, describe=describe, readouts=readouts, table=table,
    )  # fmt: skip


def compute(**settings):
    """Return the PrintedAnglesResult of checked settings."""
    heading, pitch, length = np.radians(settings["heading_deg"]), np.radians(settings["pitch_deg"]), settings["length"]
    sigma_enu = MM * np.array([settings["sigma_e"], settings["sigma_n"], settings["sigma_u"]])
    beam = _beam(heading, pitch, length)
    headings, pitches = np.linspace(0, 360, POINTS), np.linspace(-STEEPEST, STEEPEST, POINTS)
    drawn = heading_pitch_of(beam + sigma_enu * np.random.default_rng(settings["seed"]).standard_normal((POINTS, 3)))
    printed_sigmas = (formula(heading, pitch, length, sigma_enu) for formula in (sigma_heading_as_printed, sigma_pitch_as_printed))
    return PrintedAnglesResult(
        settings,
        _formulas(_as_printed, beam, printed_sigmas, headings, pitches),
        _formulas(heading_pitch_of, beam, angle_sigmas(beam, np.diag(sigma_enu**2)), headings, pitches),
        headings,
        pitches,
        drawn_heading=np.degrees(within_half_turn(drawn.heading - heading)),
        drawn_pitch=np.degrees(drawn.pitch - pitch),
    )


def _beam(heading, pitch, length=1.0):
    """Return baselines (..., 3) ENU [m] of two angles (...) [rad]."""
    return length * rotation_from_heading_pitch_roll(heading, pitch)[..., :, 1]


def _as_printed(baseline_enu):
    return heading_as_printed(baseline_enu), pitch_as_printed(baseline_enu)


def _formulas(angles_of, beam, sigmas, headings_deg, pitches_deg):
    """Return what a function from baselines to angles says of the beam, and its errors along both curves."""
    at_headings, _ = angles_of(_beam(np.radians(headings_deg), 0.0))
    _, at_pitches = angles_of(_beam(0.0, np.radians(pitches_deg)))
    return Formulas(*map(float, (*angles_of(beam), *sigmas)), _turn(np.degrees(at_headings) - headings_deg), np.degrees(at_pitches) - pitches_deg)


def _turn(difference_deg):
    """Return differences of angles [deg] in [-90, 270): half a turn is always plus."""
    return (difference_deg + 90) % 360 - 90


def figure(result):
    """Return the whole picture as one matplotlib Figure."""
    from gnsslab.figures.printed_angles import plot_printed_angles

    return plot_printed_angles(result)


def drawings():
    """Return the two pictures of the lab."""
    from gnsslab.figures.printed_angles import build_errors, build_scatter

    return Drawing("errors", build_errors, 500, 400), Drawing("scatter", build_scatter, 350, 400)


def describe(result):
    """Return the pictures in words."""
    from gnsslab.figures.printed_angles import describe_printed_angles

    return describe_printed_angles(result)


def readouts(result):
    """Return both angles and both sigmas by the chosen formula, each with what is true."""
    used, chosen = result.settings, result.chosen
    return [
        _angle("Heading", np.degrees(chosen.heading) % 360, f"truth {used['heading_deg']:g} deg"),
        _angle("Pitch", np.degrees(chosen.pitch), f"truth {used['pitch_deg']:g} deg"),
        _angle("Sigma of heading", np.degrees(chosen.sigma_heading), f"drawn beams: {np.std(result.drawn_heading):.2f} deg"),
        _angle("Sigma of pitch", np.degrees(chosen.sigma_pitch), f"drawn beams: {np.std(result.drawn_pitch):.2f} deg"),
    ]


def _angle(label, value, note):
    return Readout(label, f"{value:.2f}", "deg", note) if np.isfinite(value) else Readout(label, "none", "", note)


def table(result):
    """Return what is in the pictures as columns: the errors along both curves, and the drawn beams."""
    return {
        "true_heading_deg": result.headings_deg,
        "heading_error_printed_deg": result.printed.heading_errors,
        "heading_error_corrected_deg": result.corrected.heading_errors,
        "true_pitch_deg": result.pitches_deg,
        "pitch_error_printed_deg": result.printed.pitch_errors,
        "pitch_error_corrected_deg": result.corrected.pitch_errors,
        "drawn_heading_error_deg": result.drawn_heading,
        "drawn_pitch_error_deg": result.drawn_pitch,
    }


def _judge_unnoticed(result):
    used, heading, pitch = result.settings, abs(result.heading_error), abs(result.pitch_error)
    by_rule = used["formula"] == "printed" and used["pitch_deg"] >= 3
    now = f"heading off by {heading:.3f} deg, " + (f"pitch by {pitch:.3f} deg" if np.isfinite(pitch) else "no pitch")
    return by_rule and max(heading, pitch) < 0.01, standing(now, by_rule)


GOALS = (
    Goal("unnoticed", "As printed, with a pitch of 3 deg or more: find a beam of which both angles come out right to 0.01 deg.", _judge_unnoticed),
)  # fmt: skip
