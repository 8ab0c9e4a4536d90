"""Lab of lesson 05: is a filter's own opinion of itself true? Its innovations, its sigmas and the truth beside them."""

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from scipy.special import chdtr, chdtri

from gnsslab.core.rotations import heading_pitch_of, within_half_turn
from gnsslab.gnss.preparation import prepare_moving
from gnsslab.labs.campaigns import no_answer
from gnsslab.labs.controls import Choice, Slider, Switch
from gnsslab.labs.lab import Drawing, Goal, Lab, Preset, Readout, standing
from gnsslab.simulate import draw, find_preset, idealise, observe_drawn, prepare_geometry
from gnsslab.simulate.events import Slip
from gnsslab.systems.constrained_filter import run_filter, steady_path
from gnsslab.systems.dual_antenna import A_STATIC, A_TURNTABLE, angle_sigmas
from gnsslab.systems.length_row import LengthUse

MM = 1e-3  # [m]
KEPT = 4
SYSTEMS = {"rest": A_STATIC, "turning": A_TURNTABLE}
PAPER_CARRIER, PAPER_CODE = 8.1, 2.4  # [mm], [m] of one reading at the zenith, as the systems above have it
SETTLED = 100  # epoch from which shares and means are taken, as the numbers of the paper are
WINDOW = 20  # epochs of the running mean
FALSE_ALARM = 0.001  # of the gate
WRONG = 0.1  # [m], a fixed baseline further than this from the truth is wrong: four sigma of multipath upwards, half a cycle
STARTS, START_SPAN = 20, 120.0  # runs from cold, and how long each lasts [s]
NEVER = -1  # epoch of the first fix of a run without one
USES = {"no length": LengthUse.NOWHERE, "row": LengthUse.GUARDED_ROW, "search": LengthUse.SEARCH}  # compared in the starts

CONTROLS = (
    Choice("motion", "The antennas", {"at rest, 650 s": "rest", "turntable, 300 s": "turning"}, "rest",
           help="Paper A's two trials. At rest lock is lost at 300 and 500 s; turning, at 150 s."),
    Slider("carrier_sigma", "Carrier sigma assumed", 1, 16, 0.1, PAPER_CARRIER, "mm",
           help="Of one reading at the zenith, as the filter believes it. True: 3 mm of white noise, and the multipath."),
    Slider("multipath", "True carrier multipath", 0, 12, 0.5, 4.5, "mm", help="Of one reading at the zenith. It wanders, it is not white."),
    Slider("velocity_noise", "Velocity noise q_v", 1, 100, 1, 20, "mm/s/√s",
           help="How fast the filter lets the baseline's velocity change; a third of it vertically."),
    Choice("hold_after", "Hold the integers", {"never": 0, "after 1 fix": 1, "after 5 fixes": 5, "after 20 fixes": 20}, 5,
           help="Fixes in a row, after which the integers are written into the filter."),
    Switch("many_starts", "Many starts", False, help="Twenty runs of two minutes from cold, with three uses of the length: takes about a second."),
    Slider("code_sigma", "Code sigma assumed", 0.2, 4, 0.1, PAPER_CODE, "m", help="True: 0.7 m white, 0.4 m multipath.", more=True),
    Slider("multipath_time", "Multipath lasts", 1, 300, 1, 60, "s", help="Correlation time of the true carrier multipath.", more=True),
    Slider("slip_at", "Slip nobody flags, at", 0, 290, 10, 0, "s", help="One cycle on the satellite drawn alone; the receiver says nothing. 0: none.",
           more=True),
    Slider("hold_sigma", "Sigma of held integers", 0.5, 30, 0.5, 3, "% of a cycle", help="How firmly they are held.", more=True),
    Slider("ratio", "Ratio to fix", 1, 10, 0.5, 3, help="Second best over best squared norm; 1 believes everything.", more=True),
    Choice("length_use", "The known length",
           {"not used": LengthUse.NOWHERE, "row, when safe": LengthUse.GUARDED_ROW, "row, always": LengthUse.ROW, "in the search": LengthUse.SEARCH},
           LengthUse.GUARDED_ROW, help="Where the 1.167 m go.", more=True),
    Slider("seed", "Seed", 1, 100, 1, 1, help="Another seed is another draw of the noise.", more=True),
)  # fmt: skip

PRESETS = (
    Preset("health-paper", "As in paper A", {},
           "The blue mean of the carriers' NIS runs at less than half of what it should be: the filter expects worse carriers than it gets."),
    Preset("health-white", "White noise, and told so", {"multipath": 0, "carrier_sigma": 2.9, "code_sigma": 0.8, "velocity_noise": 1},
           "No multipath, true sigmas: NIS runs inside its bounds, and 97 % of the headings lie within two sigma. What it says is true."),
    Preset("health-small", "Too sure", {"carrier_sigma": 1.5},
           "Carriers believed to 1.5 mm: NIS is seven times too high, the first fix takes two minutes, and two of three errors leave the band."),
    Preset("health-lasting", "Averaged, and deceived", {"velocity_noise": 1, "seed": 2},
           "NIS is less than half of what it should be, so the sigmas look too large; yet the heading leaves its band for a minute and a half."),
    Preset("health-lag", "Lag in the turn", {"motion": "turning", "velocity_noise": 1},
           "The model hardly lets the velocity change, and the table turns: innovations swing, the heading lags 2 deg, and its sigma is 0.3 deg."),
    Preset("health-gate", "RTKLIB's noise settings", {"carrier_sigma": 4.2, "code_sigma": 0.4},
           "Codes believed to 0.4 m: a gate that spares 99.9 % of good epochs would reject five of six, and every one of them is good."),
    Preset("health-no-hold", "Without the hold", {"hold_after": 0, "seed": 5},
           "At 228 s the ratio falls below 3, and nothing leads it back: a quarter is fixed, and the float heading leaves its band."),
    Preset("health-held-wrong", "Held, and wrong", {"hold_after": 1, "ratio": 1, "seed": 3},
           "The first guess is believed and held. Every epoch counts as fixed, every one is wrong; only innovations and NIS tell."),
    Preset("health-slip", "A slip nobody flags", {"slip_at": 200},
           "One cycle at 200 s: the innovation jumps by 190 mm and stays high; the held integer turns the heading by a degree until lock is lost."),
    Preset("health-starts", "Time to first fix", {"many_starts": True},
           "Twenty starts from cold: with the length in the search most are fixed in the first second; as a row it helps nobody to start."),
)  # fmt: skip


class Health(NamedTuple):
    """What a filter says of itself at T epochs, with d double differences, and how wrong it is."""

    seconds: np.ndarray  # (T,) [s] since the start
    innovation: np.ndarray  # (T, d) [m], of the carriers
    watched: np.ndarray  # (T,) [m], the innovation of the satellite watched
    watched_sigma: np.ndarray  # (T,) [m], as the filter expects it
    pair: str  # the satellites it is the difference of
    nis_phase: np.ndarray  # (T,)
    nis_code: np.ndarray  # (T,)
    freedom: np.ndarray  # (T,) what both are if the filter is right, in the mean
    error: np.ndarray  # (T, 2) [deg], heading and pitch, in excess
    sigma: np.ndarray  # (T, 2) [deg], as the filter says
    is_fixed: np.ndarray  # (T,) bool
    is_held: np.ndarray  # (T,) bool
    is_wrong: np.ndarray  # (T,) bool, fixed, and off by more than WRONG

    @property
    def inside(self):
        """Shares (2,) of the settled epochs whose heading, pitch is within two sigma of the truth."""
        return np.mean(np.abs(self.error) < 2 * self.sigma, axis=0, where=self.is_settled[:, None])

    @property
    def rms(self):
        """Errors (2,) [deg] of heading and pitch over the settled epochs."""
        return np.sqrt(np.mean(self.error**2, axis=0, where=self.is_settled[:, None]))

    @property
    def is_settled(self):
        """Epochs (T,) bool that count."""
        return np.arange(len(self.seconds)) >= SETTLED

    def share(self, chosen):
        """Return the share of the settled epochs that are chosen (T,) bool."""
        return float(np.mean(chosen[self.is_settled]))

    def mean(self, nis):
        """Return the mean of a NIS (T,) over the settled epochs."""
        return float(np.mean(nis[self.is_settled]))

    @property
    def mean_bounds(self):
        """Bounds (2,) within which that mean lies 95 times of 100, when all is well."""
        return nis_bounds(self.mean(self.freedom), int(self.is_settled.sum()))

    @property
    def epoch_bounds(self):
        """Bounds (2, T) of the NIS of single epochs."""
        return nis_bounds(self.freedom, 1)

    @property
    def running_bounds(self):
        """Bounds (2, T) of the running mean, were its epochs independent."""
        return nis_bounds(self.freedom, WINDOW)

    def running(self, nis):
        """Return the seconds (T - WINDOW + 1,) at which WINDOW epochs end, and the means of a NIS (T,) over them."""
        return self.seconds[WINDOW - 1 :], np.convolve(nis, np.full(WINDOW, 1 / WINDOW), mode="valid")

    def promised(self, edges):
        """Return the shares of epochs whose NIS should lie between edges (k + 1,): those of chi-square."""
        return np.diff(chdtr(self.mean(self.freedom), edges))

    @property
    def gate(self):
        """What a NIS exceeds once in a thousand times, when all is well (T,)."""
        return chdtri(self.freedom, FALSE_ALARM)

    def rejected(self, nis):
        """Return how many settled epochs a gate would reject by a NIS (T,)."""
        return int(np.sum((nis > self.gate) & self.is_settled))


class Starts(NamedTuple):
    """Runs from cold, for each use of the length."""

    uses: tuple[str, ...]
    first: np.ndarray  # (uses, STARTS) int, epoch of the first fix, NEVER without
    is_wrong: np.ndarray  # (uses, STARTS) bool, it was wrong

    def middle(self, use):
        """Return the median first fix [s] of a use, infinity where most have none."""
        return float(np.median(np.where(self.first[use] == NEVER, np.inf, self.first[use])))


@dataclass(frozen=True, eq=False)
class HealthResult:
    """One run, what it says of itself, and perhaps many starts."""

    settings: dict  # of the controls, all of them
    health: Health | None = None  # None where there is a problem
    starts: Starts | None = None  # None where nobody asked
    problem: str = ""
    note: str = ""


class HealthEngine:
    """The draws and runs of one lab instance, kept between moves: a move of the filter's controls prepares nothing anew."""

    def __init__(self):
        self._ideal = lru_cache(KEPT)(_ideal)
        self._trial = lru_cache(KEPT)(self._prepare)
        self._from_cold = lru_cache(KEPT)(self._prepare_starts)
        self._starts = lru_cache(2 * KEPT)(self._start)

    def compute(self, **settings):
        """Return the HealthResult of checked settings; what the filter refuses becomes a sentence."""
        try:
            situation, belief = _situation(settings), _belief(settings)
            health = _health(self._trial(*situation, settings["slip_at"], settings["seed"]), belief, settings["length_use"])
            starts = self._starts(situation, belief, settings["seed"]) if settings["many_starts"] else None
            return HealthResult(settings, health, starts)
        except ValueError as refusal:
            return HealthResult(settings, problem=no_answer(refusal))

    def _prepare(self, motion, multipath, multipath_time, slip_at, seed):
        return _trial(self._ideal(motion, slip_at, None), motion, multipath, multipath_time, seed)

    def _prepare_starts(self, motion, multipath, multipath_time, seed):
        ideal = self._ideal(motion, 0, START_SPAN)
        return [_trial(ideal, motion, multipath, multipath_time, (seed, k)) for k in range(STARTS)]

    def _start(self, situation, belief, seed):
        runs = [[_first_fix(cold, belief, use) for cold in self._from_cold(*situation, seed)] for use in USES.values()]
        first, is_wrong = np.moveaxis(np.array(runs), -1, 0)
        return Starts(tuple(USES), first, is_wrong.astype(bool))


class Trial(NamedTuple):
    """One draw, ready for the filter."""

    prepared: object  # Prepared
    truth: np.ndarray  # (T, 3) [m], the true baselines
    watched: str  # the satellite whose carrier is drawn alone, and slips


class Belief(NamedTuple):
    """What the filter is told, but for the use of the length."""

    system: object  # PublishedSystem with the filter's settings
    velocity_noise: tuple  # (3,) [m/s per sqrt(s)] east, north, up
    carrier: float  # factors on the paper's sigmas
    code: float


def _situation(settings):
    """Return what is true: motion, carrier multipath [m] and its correlation time [s]."""
    return settings["motion"], settings["multipath"] * MM, settings["multipath_time"]


def _belief(settings):
    system, q = SYSTEMS[settings["motion"]], settings["velocity_noise"] * MM
    told = replace(system.filter, ratio=settings["ratio"], hold_after=settings["hold_after"], hold_sigma=settings["hold_sigma"] / 100)
    return Belief(replace(system, filter=told), (q, q, q / 3), settings["carrier_sigma"] / PAPER_CARRIER, settings["code_sigma"] / PAPER_CODE)


def _ideal(motion, slip_at, span):
    """Return the Geometry of a trial and its ideal measurements; a `span` [s] cuts it short, before anything happens."""
    preset = find_preset(SYSTEMS[motion].preset)
    if span is not None:
        preset = replace(preset, duration=span, events=())
    geometry = prepare_geometry(preset)
    if slip_at:
        slip = Slip(slip_at, antennas=(1,), satellites=(_watched(geometry),), cycles=1, is_flagged=False)
        geometry = replace(geometry, preset=replace(preset, events=(*preset.events, slip)))
    return geometry, idealise(geometry)


def _watched(geometry):
    """Return the name of the second highest GPS satellite: the highest one is the reference."""
    height = dict(zip(geometry.tracks.satellites, geometry.elevation[0, 0], strict=True))
    return sorted((name for name in height if name[0] == "G"), key=height.get)[-2]


def _trial(ideal, motion, multipath, multipath_time, seed):
    """Return the Trial of one draw."""
    geometry, ideals = ideal
    noise = replace(geometry.preset.noise, carrier_multipath=multipath, carrier_multipath_time=multipath_time)
    simulation = observe_drawn(geometry, ideals, draw(geometry, np.random.default_rng(seed)), noise)
    prepared = prepare_moving(*simulation.observations, simulation.ephemerides, SYSTEMS[motion].settings)
    return Trial(prepared, simulation.truth.baselines_enu[0][prepared.model.pair.epoch], _watched(geometry))


def _run(prepared, belief, use):
    """Return the FilterRun under a Belief: the paper's sigmas, all larger or smaller by one factor, which the preparation need not know."""
    model = prepared.model
    told = replace(model, sigma_phase=model.sigma_phase * belief.carrier, sigma_code=model.sigma_code * belief.code)
    prepared = prepared._replace(model=told)
    return run_filter(prepared, steady_path(prepared, belief.velocity_noise), replace(belief.system.filter, length_use=use))


def _first_fix(trial, belief, use):
    """Return the epoch of a run's first fix, NEVER without one, and whether it was wrong."""
    run = _run(trial.prepared, belief, use)
    if run.first_fix is None:
        return NEVER, False
    return run.first_fix, np.linalg.norm(run.baseline_fixed[run.first_fix] - trial.truth[run.first_fix]) > WRONG


def _health(trial, belief, use):
    """Return the Health of a run."""
    run, pair = _run(trial.prepared, belief, use), trial.prepared.model.pair
    measured = np.isfinite(run.innovation).any(axis=0)
    names = [pair.satellites[k] for k in pair.satellite]
    channel = names.index(trial.watched)
    reference = next(name for name, is_measured in zip(names, measured, strict=True) if not is_measured and name[0] == trial.watched[0])
    return Health(
        seconds=(pair.time - pair.time[0]) / np.timedelta64(1, "s"),
        innovation=run.innovation[:, measured],
        watched=run.innovation[:, channel],
        watched_sigma=run.innovation_sigma[:, channel],
        pair=f"{trial.watched} - {reference}",
        nis_phase=run.nis_phase,
        nis_code=run.nis_code,
        freedom=run.freedom,
        error=np.degrees(_angle_errors(run.baseline, trial.truth)),
        sigma=np.degrees(np.stack(angle_sigmas(run.baseline, run.Q), axis=-1)),
        is_fixed=run.is_fixed,
        is_held=run.is_held,
        is_wrong=run.is_fixed & (np.linalg.norm(run.baseline - trial.truth, axis=-1) > WRONG),
    )


def _angle_errors(baseline, truth):
    """Return the errors (T, 2) [rad] of heading and pitch, those of heading within half a turn."""
    heading, pitch = np.array(heading_pitch_of(baseline)) - heading_pitch_of(truth)
    return np.stack([within_half_turn(heading), pitch], axis=-1)


def nis_bounds(freedom, count):
    """Return the bounds (2, ...) within which the mean of `count` NIS of chi-square with `freedom` lies in 95 of 100 cases.

    The sum of independent ones is chi-square with count x freedom (Bar-Shalom, Li and Kirubarajan 2001, section 5.4.2).

    >>> nis_bounds(13, 20).round(2).tolist()
    [10.86, 15.33]
    """
    return np.array([chdtri(count * np.asarray(freedom), tail) / count for tail in (0.975, 0.025)])


def filter_health_lab():
    """Return a fresh lab with caches of its own."""
    return Lab(
        name="filter-health", title="Does the filter know itself?", controls=CONTROLS, presets=PRESETS, goals=GOALS,
        compute=HealthEngine().compute, figure=figure, drawings=drawings, describe=describe, readouts=readouts, table=table,
        steering=("motion", "hold_after"), blocked=blocked,
    )  # fmt: skip


def blocked(settings):
    """Return for each control without effect on what was chosen the reason why."""
    return {} if settings["hold_after"] else {"hold_sigma": "no effect: the integers are never held"}


def figure(result):
    """Return the whole picture as one matplotlib Figure."""
    from gnsslab.figures.filter_health import plot_health

    return plot_health(result)


def drawings():
    """Return the two pictures of the lab."""
    from gnsslab.figures.filter_health import build_over_time, build_shares

    return Drawing("over time", build_over_time, 500, 560), Drawing("shares", build_shares, 360, 480)


def describe(result):
    """Return the pictures in words."""
    from gnsslab.figures.filter_health import describe_health

    return result.problem or describe_health(result)


def readouts(result):
    """Return what the filter says of itself beside what is so."""
    if result.problem:
        return []
    health = result.health
    (low, high), freedom = health.mean_bounds, health.mean(health.freedom)
    return [
        Readout("NIS of the carriers", f"{health.mean(health.nis_phase):.1f}", "", f"of {freedom:.0f}; {low:.1f} to {high:.1f} when all is well"),
        Readout("NIS of the codes", f"{health.mean(health.nis_code):.1f}", "", f"of {freedom:.0f} too"),
        Readout(
            "Heading within 2 sigma", f"{100 * health.inside[0]:.1f}", "%", f"promised 95.4 %; rms {health.rms[0]:.2f} deg, said {_said(health):.2f}"
        ),
        Readout(
            "Fixed", f"{100 * health.share(health.is_fixed):.1f}", "%",
            f"{100 * health.share(health.is_wrong):.1f} % wrong, {100 * health.share(health.is_held):.1f} % held",
        ),
        Readout(
            "A 99.9 % gate rejects", f"{health.rejected(health.nis_phase)} + {health.rejected(health.nis_code)}", "",
            f"epochs of {int(health.is_settled.sum())}, by carriers + by codes",
        ),
        _first_readout(result),
    ]  # fmt: skip


def _said(health):
    """Return the sigma of heading [deg] that the filter says, in the median."""
    return float(np.median(health.sigma[health.is_settled, 0]))


def _first_readout(result):
    """Return the readout of the first fix: of the run shown, and of the many starts."""
    fixed = result.health.is_fixed
    value, unit = (f"{result.health.seconds[np.argmax(fixed)]:.0f}", "s") if fixed.any() else ("none", "")
    if result.starts is None:
        return Readout("First fix", value, unit, "of this run")
    middles = ", ".join(f"{name} {_seconds_text(result.starts.middle(k))}" for k, name in enumerate(result.starts.uses))
    return Readout("First fix", value, unit, f"of this run; half of {STARTS} starts: {middles}")


def _seconds_text(seconds):
    return f"{seconds:.0f} s" if np.isfinite(seconds) else "none"


def table(result):
    """Return what is in the picture as columns."""
    health = result.health
    return {
        "seconds": health.seconds,
        f"innovation_{health.pair.replace(' ', '')}_mm": health.watched / MM,
        "its_sigma_mm": health.watched_sigma / MM,
        "nis_carriers": health.nis_phase,
        "nis_codes": health.nis_code,
        "freedom": health.freedom,
        "heading_error_deg": health.error[:, 0],
        "sigma_heading_deg": health.sigma[:, 0],
        "pitch_error_deg": health.error[:, 1],
        "sigma_pitch_deg": health.sigma[:, 1],
        "is_fixed": health.is_fixed,
        "is_held": health.is_held,
        "is_wrong": health.is_wrong,
    }


def _judge_band(result):
    if result.problem:
        return False, "The rules ask for a run that has an answer."
    used, health = result.settings, result.health
    fixed = 100 * health.share(health.is_fixed)
    by_rule = used["multipath"] >= 4.5 and used["multipath_time"] >= 60
    reached = _is_as_promised(health) and fixed >= 90
    return by_rule and reached, standing(f"{100 * health.inside[0]:.1f} % within two sigma, {fixed:.1f} % fixed", by_rule)


def _judge_both(result):
    if result.problem:
        return False, "The rules ask for a run that has an answer."
    health = result.health
    mean, (low, high) = health.mean(health.nis_phase), health.mean_bounds
    words = f"NIS {mean:.1f} where {low:.1f} to {high:.1f} is right, {100 * health.inside[0]:.1f} % within two sigma"
    by_rule = result.settings["multipath"] >= 4.5
    return by_rule and bool(low <= mean <= high) and _is_as_promised(health), standing(words, by_rule)


def _is_as_promised(health):
    """Return whether 92 to 98 % of the headings lie within two sigma."""
    return bool(abs(health.inside[0] - 0.95) <= 0.03)


GOALS = (
    Goal("health-band", "True multipath of 4.5 mm or more that lasts 60 s or more: bring the share of headings within two sigma to 95 +- 3 %, with "
         "90 % of the epochs fixed.", _judge_band),
    Goal("health-both", "True multipath of 4.5 mm or more: bring the mean NIS of the carriers into its bounds and, at the same setting, the share of "
         "headings within two sigma to 95 +- 3 %. Change what is true, too.", _judge_both),
)  # fmt: skip
