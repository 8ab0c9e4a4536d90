"""Lab of lesson 05: paper A's figures 4 to 8, live. One campaign, solved direct, with the length, and with length and position correction."""

from dataclasses import dataclass, replace

import numpy as np

from gnsslab.labs.controls import Choice, Slider, Switch
from gnsslab.labs.filter_modes import CM, MM, MODES, SETTLED, FilterModes, Scene, rms
from gnsslab.labs.lab import Drawing, Goal, Lab, Preset, Readout, standing
from gnsslab.systems.dual_antenna import A_STATIC

AS_PRINTED = {"none": "none", "(6) pitch": "6", "(16) length row": "16", "(25) prediction": "25", "(31) residual": "31",
              "(33) heading sigma": "33", "(34) pitch sigma": "34"}  # fmt: skip
SHORT = {"direct": "direct", "length": "length", "position": "with (29)"}
VELOCITY_NOISE = (0, 0.5, 2, 3, 10, 30, 100, 1000)  # [cm/s per sqrt(s)]
LENGTHS = (0.3, 0.5, 1.167, 2, 3, 5)  # [m], the paper's among them
LENGTH_SIGMA = (2, 5, 10, 20, 50, 200)  # [mm]

CONTROLS = (
    Choice("scene", "Scene", {"at rest": "static", "turntable": "turntable"}, "static", help="Low-cost receivers, one frequency, GPS and BeiDou."),
    Choice("printed", "Formula as printed", AS_PRINTED, "none", help="One equation of the paper with its misprint, all others mended."),
    Choice("length_sigma", "Sigma of the length", {f"{mm} mm": mm for mm in LENGTH_SIGMA}, 5, help="How well the filter obeys the length."),
    Choice("velocity_noise", "Velocity noise", {f"{cm:g} cm/s": cm for cm in VELOCITY_NOISE}, 2,
           help="How much the baseline's velocity may change in a second; direct has no such rule."),
    Slider("multipath", "Carrier multipath", 0, 12, 0.5, 4.5, "mm", help="At the zenith; it wanders within a minute. White noise adds 3 mm."),
    Choice("length", "Baseline length", {f"{m:g} m": m for m in LENGTHS}, 1.167, help="Distance of the two antennas; the filters know it."),
    Choice("mode", "Numbers of", {words: name for name, words in SHORT.items()}, "length",
           help="Whose errors are read out, and whose sigma is the band.", more=True),
    Slider("pitch", "Pitch", 0, 40, 5, 0, "deg", help="How far the baseline is tilted.", more=True),
    Switch("hold", "Hold integers", True, help="Five fixes in a row, and the integers are written into the filter.", more=True),
    Slider("ratio", "Ratio threshold", 1, 10, 0.5, 3, help="Second best over best squared norm, from which integers are believed.", more=True),
    Slider("rate", "Turning rate", 0, 30, 1, 6, "deg/s", help="Of the turntable, after 50 s at rest.", more=True),
    Slider("missing", "Master epochs missing", 0, 5, 1, 1, help="From second 218 on; the last one before serves instead.", more=True),
    Slider("late", "Rover later by", 0, 1000, 50, 0, "ms", help="How much later than the master it measures, in true time.", more=True),
    Slider("doppler", "Doppler noise", 0, 20, 1, 5, "cm/s", help="Of one reading; the master's velocity in (29) comes from it.", more=True),
    Slider("seed", "Seed", 1, 100, 1, 22, help="Another seed is another draw of the noise.", more=True),
)  # fmt: skip
TURNTABLE_ONLY = {
    "rate": "no effect: at rest nothing turns; choose the turntable",
    "missing": "no effect: only the turntable's recording has a gap",
    "late": "no effect: at rest it hardly matters when a receiver measures; choose the turntable",
    "doppler": "no effect: at rest, with receivers that measure together, (29) shifts nothing",
}

PRESETS = (
    Preset("paper-static", "Paper: at rest", {},
           "Lock is lost at 300 s and 500 s: direct is off by 78 and 40 deg. With the length no error of heading reaches 1 deg."),
    Preset("paper-turntable", "Paper: turntable", {"scene": "turntable", "mode": "position"},
           "The master has no epoch at 218 s: without (29) the heading, not the pitch, is off by 2.9 deg. The green line passes."),
    Preset("row-as-printed", "Row as printed", {"printed": "16"},
           "The length scatters by 5.5 mm, not 1.2. But no jump comes back at 300 s or 500 s: it was not the row that removed them."),
    Preset("no-dynamics", "No dynamics", {"velocity_noise": 1000},
           "Row and hold are as before, but the velocity may change by 10 m/s in a second: at 300 s the heading is off by 69 deg again."),
    Preset("no-hold", "Nothing held", {"hold": False},
           "The integers are not written into the filter: after the loss of lock at 300 s the heading jumps by 10 deg, row or no row."),
    Preset("steep", "Printed pitch", {"printed": "6", "pitch": 20},
           "The baseline rises by 20 deg, and (6) as printed makes 21.34 of it: all pitch errors of the filters lie about 1.34 deg too high."),
    Preset("claimed-heading", "Printed sigma", {"printed": "33"},
           "(33) as printed claims a sigma of 2.2 deg where the heading is good to 0.26: compare the band with the dots."),
    Preset("too-sure", "Printed prediction", {"printed": "25"},
           "(25) as printed claims 0.02 deg, and the errors are eight times as large. At rest it even looks better."),
    Preset("no-range", "Printed residual", {"printed": "31"},
           "(30) and (31) as printed leave out the geometric range: the baseline is that of no antenna, and hardly an epoch is fixed."),
    Preset("mirror-street", "Heavy multipath", {"multipath": 12},
           "Up to 8 mm the errors just grow. At 12 mm no epoch is fixed, and the length cannot help: the heading is off by 15 deg rms."),
    Preset("five-metres", "Five metres", {"length": 5},
           "The same millimetres on a longer lever: heading to 0.06 deg, pitch to 0.22."),
    Preset("worse-than-nothing", "A bad velocity", {"scene": "turntable", "mode": "position", "seed": 35},
           "With (29) the heading is off by 5.2 deg at 218 s, without it by 2.6: the shift is as good as the Doppler's velocity."),
    Preset("half-a-second", "Half a second late", {"scene": "turntable", "mode": "position", "late": 500},
           "Without (29) the heading is 1.5 deg off all the time it turns. With it the mean is right, but the Doppler's noise comes in."),
    Preset("left-behind", "Left behind", {"scene": "turntable", "rate": 20, "velocity_noise": 0.5},
           "The filter believes that the baseline cannot turn so fast, and lags: 5.8 deg rms. The length cannot tell where it points."),
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class ThreeFiltersResult:
    """One campaign of T epochs and its three solutions."""

    settings: dict  # of the controls, all of them
    seconds: np.ndarray  # (T,) [s] since the start
    truth: np.ndarray  # (T, 3) [m] east, north, up, at the rover's instants
    lost: tuple  # [s], when lock is lost
    missing: np.ndarray  # (k,) [s], when the master has no epoch
    solutions: dict  # Solution by name of MODES
    problem: str = ""
    note: str = ""

    @property
    def chosen(self):
        """The Solution whose numbers are read out."""
        return self.solutions[self.settings["mode"]]

    @property
    def settled(self):
        """Which epochs count, (T,) bool."""
        return self.seconds >= SETTLED


class ThreeFiltersEngine:
    """From settings to a result, on campaigns and runs that one lab instance keeps."""

    def __init__(self):
        self._modes = FilterModes()

    def compute(self, **settings):
        """Return the ThreeFiltersResult of checked settings."""
        used = settings | (_AT_REST if settings["scene"] == "static" else {})
        scene = Scene(used["scene"], used["length"], used["pitch"], used["rate"], used["missing"], used["late"] * MM)
        campaign = self._modes.campaign(scene, used["multipath"] * MM, used["doppler"] * CM, used["seed"])
        solutions = self._modes.solve(campaign, used["velocity_noise"] * CM, _filter_settings(used), used["printed"])
        result = ThreeFiltersResult(settings, campaign.seconds, campaign.truth, campaign.lost, campaign.missing, solutions)
        return replace(result, note=_note(result))


_AT_REST = {"rate": 0, "missing": 0, "late": 0, "doppler": 5}


def _filter_settings(used):
    """Return the FilterSettings; printed, (16) takes the length for its sigma."""
    printed, calibrated = used["printed"], A_STATIC.filter
    return replace(
        calibrated,
        length=used["length"],
        length_sigma=used["length"] if printed == "16" else used["length_sigma"] * MM,
        ratio=used["ratio"],
        hold_after=calibrated.hold_after if used["hold"] else 0,
        printed_prediction=printed == "25",
        printed_residual=printed == "31",
    )


def _note(result):
    """Return one sentence where a printed formula goes unseen; any other would take the place of a preset's sentence."""
    used = result.settings
    if used["printed"] in ("6", "34") and used["pitch"] == 0:
        return f"At a pitch of zero ({used['printed']}) as printed is nearly right: tilt the baseline, under more."
    return ""


def three_filters_lab():
    """Return a fresh lab with caches of its own."""
    return Lab(
        name="three-filters", title="Three filters", controls=CONTROLS, presets=PRESETS, goals=GOALS,
        compute=ThreeFiltersEngine().compute, figure=figure, drawings=drawings, describe=describe, readouts=readouts, table=table,
        steering=("scene", "printed"), blocked=blocked,
    )  # fmt: skip


def blocked(settings):
    """Return for each control without effect the reason why."""
    reasons = dict(TURNTABLE_ONLY) if settings["scene"] == "static" else {}
    if settings["printed"] == "16":
        reasons["length_sigma"] = "no effect: (16) as printed takes the length itself for its sigma"
    return reasons


def figure(result):
    """Return the whole picture as one matplotlib Figure."""
    from gnsslab.figures.three_filters import plot_three_filters

    return plot_three_filters(result)


def drawings():
    """Return the two pictures of the lab."""
    from gnsslab.figures.three_filters import build_errors, build_plan

    return Drawing("errors", build_errors, 450, 510), Drawing("plan", build_plan, 340, 380)


def describe(result):
    """Return the pictures in words."""
    from gnsslab.figures.three_filters import describe_three_filters

    return describe_three_filters(result)


def readouts(result):
    """Return the errors of the mode chosen, those of the others beside them, how long it was fixed, and what it claims."""
    chosen = result.chosen
    return [
        _of_modes(result, "Heading error", heading_rms, "deg", "rms"),
        _of_modes(result, "Pitch error", pitch_rms, "deg", "rms"),
        _largest(result),
        _of_modes(result, "Length scatter", length_scatter, "mm", ""),
        _fixed(result),
        Readout("Claimed sigma", _number(_typical(result, chosen.sigma_heading)), "deg", _claim_words(result)),
    ]


def heading_rms(result, mode):
    """Return the heading error's rms [deg] once settled."""
    return rms(result.solutions[mode].heading_error[result.settled])


def pitch_rms(result, mode):
    """Return the pitch error's rms [deg] once settled."""
    return rms(result.solutions[mode].pitch_error[result.settled])


def largest_heading_error(result, mode):
    """Return the largest heading error [deg] once settled and when it was [s]; NaN without any."""
    error = np.where(result.settled, np.abs(result.solutions[mode].heading_error), np.nan)
    if not np.isfinite(error).any():
        return float("nan"), 0.0
    worst = int(np.nanargmax(error))
    return float(error[worst]), float(result.seconds[worst])


def length_scatter(result, mode):
    """Return the standard deviation [mm] of the length once settled."""
    length = result.solutions[mode].length[result.settled]
    return float(np.std(length)) / MM


def fixed_percent(result, mode):
    """Return the share of fixed epochs [%], of all."""
    return 100 * float(np.mean(result.solutions[mode].is_fixed))


def _of_modes(result, label, measure, unit, what):
    """Return a Readout of one measure for the mode chosen, with the other modes in its note."""
    others = _others(result, lambda mode: _number(measure(result, mode)))
    return Readout(label, _number(measure(result, result.settings["mode"])), unit, f"{what}; {others}" if what else others)


def _others(result, words):
    """Return the modes that are not chosen, each with its words."""
    return ", ".join(f"{SHORT[mode]} {words(mode)}" for mode in MODES if mode != result.settings["mode"])


def _largest(result):
    value, second = largest_heading_error(result, result.settings["mode"])
    others = _others(result, lambda mode: _number(largest_heading_error(result, mode)[0]))
    return Readout("Largest heading error", _number(value), "deg", f"at {second:.0f} s; {others}" if np.isfinite(value) else others)


def _fixed(result):
    mode = result.settings["mode"]
    fixed = result.solutions[mode].is_fixed
    first = f"first at {result.seconds[np.argmax(fixed)]:.0f} s" if fixed.any() else "never"
    return Readout(
        "Fixed", f"{fixed_percent(result, mode):.1f}", "%", f"{first}; {_others(result, lambda other: f'{fixed_percent(result, other):.1f}')}"
    )


def _claim_words(result):
    """Return whose formula the claim is by, and that of pitch."""
    by = {"33": "of heading, by (33) as printed", "34": "of heading; of pitch, by (34) as printed:"}.get(result.settings["printed"], "of heading")
    pitch = _number(_typical(result, result.chosen.sigma_pitch))
    return f"{by} {pitch}" if by.endswith(":") else f"{by}; of pitch: {pitch}"


def _typical(result, sigma):
    """Return the median of the finite ones once settled, NaN without any."""
    sigma = sigma[result.settled & np.isfinite(sigma)]
    return float(np.median(sigma)) if sigma.size else float("nan")


def _number(value):
    if not np.isfinite(value):
        return "none"
    return f"{value:.2f}" if value < 10 else f"{value:.1f}" if value < 100 else f"{value:.0f}"


def table(result):
    """Return what is in the pictures as columns."""
    east, north, up = result.truth.T
    columns = {"time_s": result.seconds, "true_east_m": east, "true_north_m": north, "true_up_m": up}
    for mode, found in result.solutions.items():
        columns |= {f"{mode}_{axis}_m": values for axis, values in zip(("east", "north", "up"), found.baseline.T, strict=True)}
        columns |= {f"{mode}_heading_error_deg": found.heading_error, f"{mode}_pitch_error_deg": found.pitch_error}
        columns |= {f"{mode}_length_m": found.length, f"{mode}_is_fixed": found.is_fixed}
    return columns


def _judge_sharp(result):
    used, error = result.settings, heading_rms(result, "length")
    by_rule = used["scene"] == "static" and used["multipath"] >= 4.5 and used["length"] <= 3 and used["printed"] == "none"
    return by_rule and error < 0.1, standing(f"{error:.3f} deg with the length", by_rule)


def _judge_lag(result):
    used, error = result.settings, heading_rms(result, "length")
    in_step = used["missing"] == 0 and used["late"] == 0
    by_rule = used["scene"] == "turntable" and used["rate"] >= 20 and in_step and used["printed"] == "none"
    return by_rule and error < 0.4, standing(f"{_number(error)} deg with the length", by_rule)


GOALS = (
    Goal("sharp", "At rest, nothing misprinted, carrier multipath of 4.5 mm or more, a baseline of 3 m or less: bring the heading error with the "
         "length below 0.1 deg rms.", _judge_sharp),
    Goal("lag", "Turntable at 20 deg/s or more, no epoch missing, receivers in step, nothing misprinted: bring the heading error with the length "
         "below 0.4 deg rms.", _judge_lag),
)  # fmt: skip
