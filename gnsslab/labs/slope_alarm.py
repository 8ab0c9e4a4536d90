"""Lab of lesson 08: you watch a slope above a village. When do you sound the alarm, and when do you let people sleep?"""

from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from gnsslab.gnss.times import seconds_between, usual_step
from gnsslab.labs.alarm_kinds import KINDS, Line, Lines, first_epochs, wake_ups
from gnsslab.labs.campaigns import no_answer
from gnsslab.labs.controls import Choice, FileOrPath, Slider, Switch
from gnsslab.labs.lab import Drawing, Goal, Lab, Preset, Readout, standing
from gnsslab.labs.slope_data import CM, STATIONS, Motion, SlopeData, WrongFixes, true_motion

THRESHOLDS = np.arange(0.5, 15.25, 0.25)  # [cm] of the trade-off
SOON = 30.0  # minutes (days, where positions are daily) after which an alarm comes too late
KEPT = 64
OWN, SIMULATED = "mine", "simulated"

CONTROLS = (
    Choice("data", "Data", {"simulated day": SIMULATED, "real slope, 24 h": "slope", "Tohoku 2011, J188": "J188", "Tohoku 2011, USUD": "USUD",
           "my file": OWN}, SIMULATED, help="The slope is solved by our own BeiDou RTK: the first time that takes a while."),
    Choice("alarm", "The alarm looks at", {kind.label: name for name, kind in KINDS.items()}, "raw", help="Its distance from where it was."),
    Switch("wrong_fixes", "Wrong fixes", True, help="Five bursts of solutions with wrong integers, the first at three in the morning."),
    Slider("threshold", "Threshold", 0.5, 15, 0.25, 3, "cm", help="The alarm goes off where the line is farther away, east and north together."),
    Slider("wait", "Wait", 1, 40, 1, 1, "epochs", help="So many must be beyond the threshold. The monitor: so many before it believes a step."),
    Slider("step", "Step", 0, 20, 0.2, 3.6, "cm", help="The ground moves downhill, at once; 0: not at all."),
    Slider("slide", "Slide", 0, 5, 0.2, 0, "cm/h", help="From the same moment on the ground slides downhill.", more=True),
    Slider("moves_at", "It moves at", 25, 95, 1, 70, "% of the data", help="70 % of a day is 16:48.", more=True),
    Slider("average", "Moving average", 2, 240, 2, 30, "epochs", help="Of the latest epochs: nobody has later ones.", more=True),
    Slider("burst_length", "Bursts last", 1, 40, 1, 4, "epochs", help="A wrong fix comes seldom alone.", more=True),
    Slider("burst_size", "Wrong by", 5, 50, 1, 20, "cm", help="One wrong integer is a wavelength, about 20 cm.", more=True),
    Slider("noise", "Noise", 20, 120, 5, 50, "%", help="Of the paper's: 1.1 cm white and 1.9 cm that lasts for two minutes.", more=True),
    Slider("gross", "Gross errors", 0, 4, 0.1, 0.3, "%", help="Share of the epochs with one; its sigma is 13 cm on each axis.", more=True),
    Slider("seed", "Seed", 1, 100, 1, 1, help="Another seed is another draw of errors and of wrong fixes.", more=True),
    FileOrPath("file", "My series", help="A table of time, east, north, up, or RTKLIB's .pos."),
)  # fmt: skip
IN_SIMULATION = ("noise", "gross")
OF_WRONG_FIXES = ("burst_length", "burst_size")
OF_MOTION = ("step", "slide", "moves_at")

QUIET = {"wrong_fixes": False}
PRESETS = (
    Preset("restless", "The first alarm", {},
           "A step of 3.6 cm, known at once: this alarm goes off all day long, 55 times when nothing moves, and nobody listens to it."),
    Preset("quiet-night", "A quiet night", {"threshold": 6, "step": 0, "gross": 0} | QUIET,
           "Nothing moves, no solution is wrong: at 6 cm everybody sleeps. Go down to 3 cm, and the same night has 45 alarms."),
    Preset("wrong-fix-at-three", "Wrong fix at three", {"threshold": 6, "step": 0, "gross": 0},
           "At three in the morning four solutions are 20 cm off. One is enough to wake the village, and more bursts follow."),
    Preset("patience", "Ten in a row", {"wait": 10, "threshold": 2.75},
           "Ten solutions in a row must be beyond 2.75 cm. Gross errors and bursts of four pass, and the step is known after 2.25 minutes."),
    Preset("longer-bursts", "Longer bursts", {"wait": 10, "threshold": 2.75, "burst_length": 12},
           "The wrong fixes now last twelve epochs, longer than you wait: they wake the village again. Patience must outlast them."),
    Preset("threshold-too-high", "Threshold too high", {"alarm": "joint", "wait": 10, "threshold": 5},
           "A calm filter and 5 cm: no false alarm, and no true one. Beyond the size of the step every threshold misses it."),
    Preset("late-average", "A late average", {"alarm": "average", "average": 240, "threshold": 2.5},
           "An average over an hour is calm, 1.6 cm at most, and knows of the step 43.5 minutes later."),
    Preset("locked-out", "Locked out", {"alarm": "joint", "step": 20, "threshold": 12},
           "20 cm at once, and the paper's filter rejects every solution for half an hour: the larger the step, the surer it is an outlier."),
    Preset("watchman", "The monitor", {"alarm": "monitor", "wait": 10},
           "The monitor waits ten epochs before it believes in a step: five bursts of wrong fixes do not bend its line."),
    Preset("hasty-watchman", "A hasty monitor", {"alarm": "monitor", "wait": 3},
           "After three epochs a burst of four looks like a step of 20 cm: the line jumps there and back."),
    Preset("slow-slide", "1 cm an hour", {"alarm": "monitor", "wait": 10, "threshold": 2.5, "step": 0, "slide": 1},
           "A slide has no moment at which it begins: the alarm comes when the threshold is reached, an hour or two later."),
    Preset("real-day", "Real slope, untouched", {"data": "slope", "alarm": "monitor", "wait": 10, "threshold": 2, "step": 0} | QUIET,
           "24 hours on a mountain, solved by our own BeiDou RTK: no alarm. It is calmer than the simulated day; see what noise would be like it."),
    Preset("real-step", "Real slope, 5 cm", {"data": "slope", "threshold": 2, "step": 5},
           "The same day with a step of 5 cm and wrong fixes put in. The alarm looks at raw solutions: make it quiet, and keep it quick."),
    Preset("tohoku-asleep", "Asleep on 11 March", {"data": "J188", "alarm": "joint", "threshold": 10} | QUIET,
           "The ground moved by a metre, and the paper's filter took every day after it for an outlier, for seven years."),
    Preset("tohoku-awake", "J188, the monitor", {"data": "J188", "alarm": "monitor", "wait": 3, "threshold": 10} | QUIET,
           "The same metre: the monitor knows it within days, and follows the slow motion of the years after."),
    Preset("creeping-plate", "USUD, creeping", {"data": "USUD", "wait": 3, "threshold": 4} | QUIET,
           "Here it was 24 cm. But the plate itself creeps: 4 cm are reached years before, again and again. Decide whether that is a false alarm."),
)  # fmt: skip


class Clock(NamedTuple):
    """Units of time that suit a series."""

    long: str  # of the whole series
    long_seconds: float
    short: str  # of lags
    short_seconds: float
    per: str  # false alarms are counted per this
    per_seconds: float


HOURS = Clock("hours", 3600.0, "min", 60.0, "day", 86_400.0)
YEARS = Clock("years", 365.25 * 86_400.0, "days", 86_400.0, "year", 365.25 * 86_400.0)
COARSE = 3600.0  # [s] between epochs, from which years suit


class Span:
    """The time of a series (T,), when its ground moves (`at`, None: never), and how many first epochs without that motion there are."""

    def __init__(self, time, at, quiet, clock):
        self.at, self.quiet, self.clock = at, quiet, clock
        self.seconds = seconds_between(time, time[0])

    @property
    def periods(self):
        """The time without motion, in the clock's days or years."""
        return float(self.seconds[self.quiet - 1] / self.clock.per_seconds)


class Curve(NamedTuple):
    """What a kind of alarm does at each of THRESHOLDS."""

    label: str
    false: np.ndarray  # (n,) false alarms in all the time without motion
    lag: np.ndarray  # (n,) in the short unit; NaN: missed, or nothing to miss


@dataclass(frozen=True, eq=False)
class AlarmResult:
    """A series of T epochs, the line that the alarm looks at, and what comes of it."""

    settings: dict  # of the controls, all of them
    clock: Clock = HOURS
    seconds: np.ndarray | None = None  # (T,) since the start
    raw: np.ndarray | None = None  # (T,) [m] distance of the solutions from the reference, on the level
    truth: np.ndarray | None = None  # (T,) [m] true distance, NaN where nobody knows
    line: Line | None = None  # of the kind chosen
    alarm: np.ndarray | None = None  # (T,) bool
    at: int | None = None  # epoch at which the ground moves; None: it does not
    false: int = 0  # alarms in all the time without motion
    periods: float = 1.0  # how much time that is, in the clock's days or years
    excursion: float = 0.0  # [m] the largest distance of the line while nothing moves
    thresholds: np.ndarray | None = None  # (n,) [cm] of the curves
    curves: dict | None = None  # Curve by name of KINDS
    problem: str = ""
    note: str = ""

    @property
    def known(self):
        """The epoch at which the motion is known; None where it never is, or where nothing moves."""
        after = np.flatnonzero(self.alarm[self.at :]) if self.at is not None else ()
        return self.at + int(after[0]) if len(after) else None

    @property
    def lag(self):
        """Time from motion to alarm in the clock's short unit; NaN where there is none."""
        return np.nan if self.known is None else float(self.seconds[self.known] - self.seconds[self.at]) / self.clock.short_seconds

    @property
    def x(self):
        """Time (T,) since the start in the clock's long unit."""
        return self.seconds / self.clock.long_seconds

    @property
    def curve(self):
        """The Curve of the kind chosen."""
        return self.curves[self.settings["alarm"]]


class AlarmEngine:
    """From settings to a result; series and lines of one lab are kept."""

    def __init__(self):
        self._data, self._lines, self._curve = SlopeData(), Lines(), lru_cache(KEPT)(_curve)

    def compute(self, **settings):
        """Return the AlarmResult of checked settings; what a reader or a filter refuses becomes a sentence."""
        try:
            return self._result(settings)
        except ValueError as refusal:
            return AlarmResult(settings, problem=no_answer(str(refusal).rstrip(".")))

    def _result(self, settings):
        measured = self._data.measured(settings)
        still, moved, motion = self._series(measured, settings)
        clock = YEARS if usual_step(moved.time) >= COARSE else HOURS
        at = motion.at if motion else measured.quake
        span = Span(moved.time, at, measured.quake or len(moved), clock)
        lines = {name: (self._lines.line(still, name, settings), self._lines.line(moved, name, settings)) for name in KINDS}
        before, line = lines[settings["alarm"]]
        return AlarmResult(
            settings=settings,
            clock=clock,
            seconds=span.seconds,
            raw=lines["raw"][1].distance,
            truth=_truth(moved, motion, measured),
            line=line,
            alarm=line.score > settings["threshold"] * CM,
            at=at,
            false=wake_ups(before.score[: span.quiet] > settings["threshold"] * CM),
            periods=span.periods,
            excursion=float(before.distance[first_epochs(len(moved)) : span.quiet].max()),
            thresholds=THRESHOLDS,
            curves={name: self._curve(KINDS[name].label, *both, span) for name, both in lines.items()},
            note=measured.note,
        )

    def _series(self, measured, settings):
        """Return the series as it is when nothing is made to move, as it is when something is, and the Motion or None."""
        still = measured.series
        if settings["wrong_fixes"]:
            still = self._data.with_wrong_fixes(still, WrongFixes(settings["burst_length"], settings["burst_size"] * CM, settings["seed"]))
        if measured.quake is not None or not (settings["step"] or settings["slide"]):
            return still, still, None
        motion = Motion(len(still) * settings["moves_at"] // 100, settings["step"] * CM, settings["slide"] * CM)
        return still, self._data.with_motion(still, motion), motion


def _truth(series, motion, measured):
    """Return the true distance (T,) [m], NaN where nobody knows."""
    if measured.quake is not None:
        return np.full(len(series), np.nan)
    return true_motion(series.time, motion) if motion else np.zeros(len(series))


def _curve(label, before, after, span):
    """Return the Curve of a kind whose Line is `before` where nothing moves and `after` where something does."""
    false = [wake_ups(before.score[: span.quiet] > threshold * CM) for threshold in THRESHOLDS]
    return Curve(label, np.array(false), _lags(after.score, span))


def _lags(score, span):
    """Return the lag (n,) at each of THRESHOLDS, in the clock's short unit."""
    if span.at is None:
        return np.full(len(THRESHOLDS), np.nan)
    highest = np.maximum.accumulate(score[span.at :])
    first = np.searchsorted(highest, THRESHOLDS * CM, side="right")
    seconds = np.append(span.seconds[span.at :] - span.seconds[span.at], np.nan)
    return seconds[first] / span.clock.short_seconds


def slope_alarm_lab():
    """Return a fresh lab with caches of its own."""
    return Lab(
        name="slope-alarm", title="Wake the village?", controls=CONTROLS, presets=PRESETS, goals=GOALS, compute=AlarmEngine().compute,
        figure=figure, drawings=drawings, describe=describe, readouts=readouts, table=table, steering=("data", "alarm", "wrong_fixes"),
        blocked=blocked,
    )  # fmt: skip


def blocked(settings):
    """Return for each control without effect the reason why."""
    reasons = {} if settings["data"] == OWN else {"file": 'no effect: choose "my file" first'}
    if settings["data"] != SIMULATED:
        reasons |= dict.fromkeys(IN_SIMULATION, "no effect: real data are as they are")
    if settings["data"] in STATIONS:
        reasons |= dict.fromkeys(OF_MOTION, "no effect: here the ground moved by itself")
    if not settings["wrong_fixes"]:
        reasons |= dict.fromkeys(OF_WRONG_FIXES, "no effect: no wrong fixes are put in")
        reasons |= {} if settings["data"] == SIMULATED else {"seed": "no effect: nothing is drawn at random"}
    for kind in KINDS.values():
        reasons |= {} if kind is KINDS[settings["alarm"]] else dict.fromkeys(kind.uses, "no effect: the alarm looks at something else")
    return reasons


def figure(result):
    """Return the whole picture as one matplotlib Figure."""
    from gnsslab.figures.slope_alarm import plot_slope_alarm

    return plot_slope_alarm(result)


def drawings():
    """Return the two pictures of the lab."""
    from gnsslab.figures.slope_alarm import build_slope, build_trade_off

    return Drawing("slope", build_slope, 450, 470), Drawing("trade-off", build_trade_off, 370, 470, presented=True)


def describe(result):
    """Return the pictures in words."""
    from gnsslab.figures.slope_alarm import describe_slope_alarm

    return describe_slope_alarm(result)


def readouts(result):
    """Return false alarms, the lag, how far the line strays while nothing moves, and the thresholds that would do."""
    per = f"in the {result.clock.per}" if 0.99 < result.periods < 1.01 else f"{result.false / result.periods:.1f} a {result.clock.per}"
    return [
        Readout("False alarms", f"{result.false}", "", f"{per}, nothing moving"),
        Readout("Lag", *_lag_words(result)),
        Readout("Strays by", f"{result.excursion / CM:.1f}", "cm", "at most, nothing moving"),
        Readout("Thresholds that do", *_good_words(result)),
    ]


def _lag_words(result):
    """Return value, unit and note of the lag."""
    if result.at is None:
        return "nothing moves", "", ""
    if result.known is None:
        return "missed", "", "no alarm after the motion"
    return f"{result.lag:.4g}", result.clock.short, f"{result.known - result.at} epochs after the first one"


def _good_words(result):
    """Return value, unit and note of the thresholds without a false alarm and with a lag below SOON."""
    good = THRESHOLDS[good_thresholds(result.curve, result.at is not None)]
    note = "quiet" + (f", and known in {SOON:g} {result.clock.short}" if result.at is not None else "")
    if not len(good):
        return "none", "", note
    return (f"{good[0]:g}" if len(good) == 1 else f"{good[0]:g} to {good[-1]:g}"), "cm", note


def good_thresholds(curve, moves):
    """Return which of THRESHOLDS (n,) give no false alarm, and where something moves an alarm in time."""
    return (curve.false == 0) & (curve.lag <= SOON if moves else True)


def table(result):
    """Return what is in the first picture as columns."""
    line = result.line
    return {
        f"time_{result.clock.long}": result.x, "raw_m": result.raw, "line_m": line.distance, "sigma_m": line.sigma, "true_m": result.truth,
        "outlier": line.is_outlier.astype(int), "alarm": result.alarm.astype(int),
    }  # fmt: skip


def _judge_caught(result):
    used = result.settings
    by_rule = used["data"] == SIMULATED and used["wrong_fixes"] and 0 < used["step"] <= 3.6 and used["slide"] == 0 and _as_hard(used)
    return bool(by_rule and _is_good(result, SOON)), standing(_where(result), by_rule)


def _judge_real(result):
    used = result.settings
    by_rule = used["data"] == "slope" and used["wrong_fixes"] and 0 < used["step"] <= 5 and used["slide"] == 0 and _as_hard(used)
    return bool(by_rule and _is_good(result, 5.0)), standing(_where(result), by_rule)


def _as_hard(used):
    return used["noise"] >= 50 and used["gross"] >= 0.3 and used["burst_length"] >= 10 and used["burst_size"] >= 20


def _is_good(result, limit):
    return not result.problem and result.false == 0 and result.lag <= limit


def _where(result):
    if result.problem:
        return "there is no answer"
    lag, unit, _ = _lag_words(result)
    return f"{result.false} false alarm{'s' * (result.false != 1)}, {f'known after {lag} {unit}' if unit else lag}"


GOALS = (
    Goal("caught", "On the simulated day, noise and gross errors as at first or worse, wrong fixes of 20 cm or more in bursts of ten epochs or more: "
         "know of a step of 3.6 cm or less within 30 minutes, and do not wake the village once without reason.", _judge_caught),
    Goal("real", "On the real slope, with such wrong fixes: no alarm in its 24 hours, and a step of 5 cm or less known within 5 minutes.",
         _judge_real),
)  # fmt: skip
