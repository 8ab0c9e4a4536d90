"""Lab of lesson 08: paper B's figures 3 and 4, and steps of all sizes. How late does a filter follow, and what does a gross error do to it?"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from gnsslab.labs.controls import Choice, Slider
from gnsslab.labs.lab import Drawing, Goal, Lab, Preset, Readout, standing
from gnsslab.labs.step_methods import AFTER, BASELINE, BEFORE, CM, DIRECTIONS, IGG3, METHODS, START, STEP_AT, Move, Scene, StepSeries, levels_of_steps
from gnsslab.systems.criteria import lag, lengths, rmse_about_truth, step_response
from gnsslab.systems.monitoring import MonitorSettings

SHARES = (0.5, 0.9, 0.99)
ROUNDING = 1e-9  # so that 27/30 of a step is 90 %
SIZES = np.arange(0.5, 15.25, 0.5)  # [cm] of the steps whose lag is drawn
Q = (0.01, 0.05, 0.1, 0.2, 0.48, 1, 2, 5, 20)  # [cm^2 an epoch], the calibrated one among them
COUNTED = 120  # epochs from the step on, of which those rejected are counted
LATER = 30  # epochs
LASTS = {"for good": 0, "1 epoch": 1, "2 epochs": 2, "3 epochs": 3, "10 epochs": 10}
FILTERS = {one.label: name for name, one in METHODS.items() if name != "raw"}
KEPT = 64

CONTROLS = (
    Choice("method", "Filter", FILTERS, "joint", help="Drawn as a full line. The last four are from the literature, with settings of their own."),
    Choice("beside", "Beside it", {"raw solutions": "raw"} | FILTERS, "monitor", help="Drawn as a dashed line."),
    Choice("noise", "Noise", {"hardly any": "none", "the platform's, 1 s": "b-step", "the building's, 15 s": "b-fixed"}, "b-step",
           help="Hardly any: 0.1 mm. The platform's 2.2 cm are nearly white; half of the building's last for minutes."),
    Slider("step", "Step", 0, 15, 0.1, 3.6, "cm", help="By how much all solutions are moved, from one epoch to the next."),
    Choice("q", "Random walk q", {f"{q:g} cm\u00b2": q for q in Q}, 0.48, help="By how much a level may walk in an epoch, beside r = 9.9 cm\u00b2."),
    Choice("thresholds", "IGG III: k0, k1", {name: name for name in IGG3}, "1, 2",
           help="In sigmas: full weight up to k0, none from k1 on. none: a plain Kalman filter."),
    Slider("evidence", "Monitor's evidence", 4, 40, 0.5, MonitorSettings().threshold,
           help="Gain in log likelihood from which on it believes in a step."),
    Choice("lasts", "It stays", LASTS, 0, help="For good: the ground moved. Else those solutions are wrong, and it did not."),
    Choice("view", "Drawn", {"near the step": "near", "all epochs": "all"}, "near",
           help="The paper draws all 63 857 epochs. There the monitor takes a second.", more=True),
    Choice("direction", "It goes", {"along the baseline": "along", "south": "south", "across": "across"}, "along",
           help="South is one axis of the filters; along the baseline, south-west, is two.", more=True),
    Choice("seen", "Looked at", {"position": "position", "length of the baseline": "length"}, "position",
           help="The position along the step, or the length, as in the paper.", more=True),
    Slider("window", "Window of the adjustment", 2, 120, 1, 30, "epochs", help="How many epochs before this one are averaged.", more=True),
    Choice("holds", "Window holds", {"adjusted": "adjusted", "raw": "raw"}, "adjusted", help="The paper does not say which.", more=True),
    Slider("patience", "Monitor's window", 8, 128, 8, MonitorSettings().window, "epochs",
           help="A step is found within so many, or taken for a slow change.", more=True),
    Slider("gross", "Gross errors", 0, 4, 0.1, 0.2, "%", help="Share of the epochs with one; its sigma is 13 cm on each axis.", more=True),
    Slider("later", "Step later by", 0, 600, 10, 0, "epochs", help="0: the platform's at epoch 30 350, the building's at 1128.", more=True),
    Slider("seed", "Seed", 1, 100, 1, 1, help="Another seed is another draw of the errors.", more=True),
)  # fmt: skip

CALM = {"noise": "none", "direction": "south", "method": "kalman", "beside": "joint"}
PRESETS = (
    Preset("near-the-step", "Near the step", {},
           "3.6 cm in 2 cm of noise. The joint method has half of it after 11 epochs, and 90 % after 51: look for the white points."),
    Preset("paper-figures", "Paper: figures 3, 4", {"view": "all", "seen": "length", "beside": "kalman"},
           "63 857 epochs: here nobody sees a lag. The means differ by 3.50 cm, 1.0 mm off the truth. The paper has 0.3 mm: try other seeds."),
    Preset("as-fast-as-raw", "As fast as raw?", {"noise": "none", "beside": "raw"},
           "Hardly any noise, so that only the filter is left: 10, 51 and 107 epochs. 'As fast as the raw baseline' it is not."),
    Preset("just-accepted", "7 cm", CALM | {"step": 7},
           "One axis, and a gate at k1 times the innovation's sigma: 7.0 cm. Just accepted, with hardly any weight: half after 12 epochs, not 3."),
    Preset("shut-out", "8 cm", CALM | {"step": 8},
           "8 epochs are rejected before P has grown enough, and half is there after 20: the larger the step, the later it is followed."),
    Preset("ten-rejected", "10 cm", CALM | {"step": 10},
           "27 epochs rejected, half after 38. The joint method escapes: its adjustment lets half of the step through first."),
    Preset("fifteen-rejected", "15 cm", CALM | {"step": 15},
           "92 rejected, half after 104. Now the joint method is locked out too: at 15 s an epoch, for 25 minutes in which a slope comes down."),
    Preset("wide-gate", "A wide gate", CALM | {"step": 10, "thresholds": "2.5, 6"},
           "k0 = 2.5, k1 = 6: the same 10 cm are followed as 1 cm would be, half after 3 epochs. It has a price: the next preset."),
    Preset("price-of-the-gate", "Its price", CALM | {"step": 10, "thresholds": "2.5, 6", "lasts": 1},
           "One solution is 10 cm wrong: the level moves by 1.49 cm. With k0 = 1, k1 = 2 it does not move at all."),
    Preset("walks-faster", "Large q", {"q": 5, "beside": "kalman"},
           "q ten times as large: the Kalman filter alone has 90 % after 3 epochs, the joint method after 47. Its window is to blame, not q."),
    Preset("ten-found", "Monitor, 10 cm", {"method": "monitor", "beside": "kalman", "step": 10},
           "Known at the third epoch. Two more are all the monitor waits for before it believes that this is no gross error."),
    Preset("fifteen-found", "Monitor, 15 cm", {"method": "monitor", "beside": "kalman", "step": 15},
           "The larger the step, the clearer: again the third epoch, while the robust Kalman filter rejects it for dozens."),
    Preset("one-wrong", "One wrong", {"method": "monitor", "beside": "joint", "step": 10, "lasts": 1},
           "One solution 10 cm wrong: the monitor clips it, and moves by millimetres. Below: by how much the other moves, whatever the error."),
    Preset("two-wrong", "Two wrong", {"method": "monitor", "beside": "joint", "step": 10, "lasts": 2},
           "Two in a row, wrong by the same: clipped both, and no step is believed yet."),
    Preset("three-wrong", "Three wrong", {"method": "monitor", "beside": "joint", "step": 10, "lasts": 3},
           "Three in a row look like a step: the monitor goes there, and comes back as fast. Who follows within three epochs is fooled by three."),
    Preset("hidden-in-noise", "In lasting errors", {"method": "monitor", "beside": "joint", "noise": "b-fixed"},
           "Errors that last for minutes hide 3.6 cm: the monitor is no faster than its calm mean, 90 % after some 80 epochs of 15 s."),
    Preset("blind-length", "Across the baseline", {"direction": "across", "seen": "length"},
           "3.6 cm across: the length changes by 0.05 cm. No filter finds what is not measured; look at the position."),
    Preset("from-the-literature", "Change points", {"method": "points", "beside": "monitor", "step": 10},
           "Bayesian change points: every epoch may have been the step, each with its own filter. Compare all four on small steps too."),
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class Track:
    """What one filter makes of T epochs drawn, and of R epochs about the step."""

    label: str
    drawn: np.ndarray  # (T,) [cm] counted from where the point was
    is_rejected: np.ndarray | None  # (T,) bool; None: the filter does not say
    found: float  # epochs from the step on until it was found, NaN where it was not
    response: np.ndarray  # (R,) share of the step that is in the level; NaN without a step
    lags: tuple  # epochs to SHARES; NaN where they are not reached
    most: float  # [cm] by how much the level moved at most because of the step
    left: float  # [cm] the same, LATER epochs after the solutions moved
    rejected: int | None  # of the first COUNTED epochs from the step on
    curve: np.ndarray | None  # (S,) lag to half [epochs], or `most` [cm] where the ground stays, of SIZES; None: takes too long
    moved: float  # [cm] mean of all epochs from the step on, less that of all before
    rmse: float  # [cm] about the truth


@dataclass(frozen=True, eq=False)
class StepResult:
    """T epochs drawn, R epochs about the step, two filters."""

    settings: dict  # of the controls, all of them
    epochs: np.ndarray  # (T,) since the step
    truth: np.ndarray  # (T,) [cm] counted from where the point was
    raw: np.ndarray  # (T,) [cm]
    about: np.ndarray  # (R,) epochs since the step
    sizes: np.ndarray  # (S,) [cm] of the tracks' curves
    shown: Track
    beside: Track
    raw_rmse: float  # [cm] about the truth
    size: float  # [cm] by which the step changes what is looked at
    problem: str = ""
    note: str = ""

    @property
    def is_for_good(self):
        """The ground moved; else solutions were wrong for a while."""
        return self.settings["lasts"] == 0


class StepEngine:
    """From settings to a result, on series that one lab instance keeps."""

    def __init__(self):
        self._series = StepSeries()
        self._curve = lru_cache(KEPT)(self._lag_by_size)

    def compute(self, **settings):
        """Return the StepResult of checked settings."""
        scene = Scene(settings["noise"], settings["gross"] if settings["noise"] != "none" else 0.0, settings["seed"])
        move = Move(settings["step"], settings["direction"], settings["lasts"], STEP_AT[scene.noise] + settings["later"])
        total = len(self._series.still(scene))
        near = max(0, move.at - BEFORE), min(total, move.at + AFTER)
        part = near if settings["view"] == "near" else (0, total)
        ground = move if move.lasts == 0 else move._replace(step=0)
        truth = _seen(BASELINE + ground._replace(at=move.at - part[0]).of(part[1] - part[0]), settings)
        case = _Case(self._series, self._curve, settings, scene, move, near, part, truth)
        raw = case.drawn("raw")
        return StepResult(
            settings=settings,
            epochs=np.arange(*part) - move.at,
            truth=truth,
            raw=raw,
            about=np.arange(*near) - move.at,
            sizes=SIZES,
            shown=case.track(settings["method"]),
            beside=case.track(settings["beside"]),
            raw_rmse=rmse_about_truth(raw, truth),
            size=float(_seen(BASELINE + move.enu, settings)),
        )

    def _lag_by_size(self, scene, move, seen, name, used):
        """Return lags to half of steps of SIZES (S,) [epochs]; where they do not stay by how much the level moves at most [cm]."""
        first = max(0, move.at - START)
        series = self._series.still(scene).at(slice(first, move.at + AFTER))
        move = move._replace(at=move.at - first)
        still, *stepped = levels_of_steps(series, move, (0, *SIZES), name, dict(used))
        return np.array([_one_of_curve(level, still, move._replace(step=size), {"seen": seen}) for level, size in zip(stepped, SIZES, strict=True)])


@dataclass(frozen=True, eq=False)
class _Case:
    """All that the tracks of a result have in common."""

    series: StepSeries
    curve: object
    settings: dict
    scene: Scene
    move: Move
    near: tuple  # first and last epoch about the step
    part: tuple  # the same of what is drawn
    truth: np.ndarray  # (T,) [cm]

    def drawn(self, name):
        """Return the filtered series as it is drawn (T,) [cm]."""
        return _seen(self._answer(name, self.move, self.part).level, self.settings)

    def track(self, name):
        """Return the Track of a method."""
        drawn, moved, still = (self._answer(name, *where) for where in ((self.move, self.part), (self.move, self.near), (self._nothing, self.near)))
        at, line, size = self.move.at - self.near[0], _seen(drawn.level, self.settings), self.move.step
        change = _seen(moved.level, self.settings) - _seen(still.level, self.settings)
        response = step_response(change[:, None], 0 * change[:, None], [size]) if size else np.full(len(change), np.nan)
        found, first = moved.found[moved.found >= at], self.move.at - self.part[0]
        return Track(
            label=METHODS[name].label,
            drawn=line,
            is_rejected=drawn.is_rejected,
            found=float(found[0] - at) if len(found) and size else np.nan,
            response=response,
            lags=tuple(lag(response, at, share - ROUNDING) for share in SHARES),
            most=float(np.abs(change).max()),
            left=float(abs(change[min(at + LATER, len(change) - 1)])),
            rejected=None if moved.is_rejected is None else int(moved.is_rejected[at : at + COUNTED].sum()),
            curve=self._curve_of(name),
            moved=line[first:].mean() - line[:first].mean(),
            rmse=rmse_about_truth(line, self.truth),
        )

    @property
    def _nothing(self):
        return self.move._replace(step=0, lasts=0)

    def _answer(self, name, move, part):
        return self.series.answer(self.scene, move, part, name, self.settings)

    def _curve_of(self, name):
        if METHODS[name].level is None:
            return None
        used = tuple((used, self.settings[used]) for used in METHODS[name].uses)
        return self.curve(self.scene, self.move._replace(step=0), self.settings["seen"], name, used)


def _seen(positions, settings):
    """Return what is looked at of positions (T, 3) [m], (T,) [cm] counted from where the point was."""
    if settings["seen"] == "length":
        return (lengths(positions) - lengths(BASELINE)) / CM
    return (positions - BASELINE) @ DIRECTIONS[settings["direction"]] / CM


def _one_of_curve(level, still, move, settings):
    settings = settings | {"direction": move.direction}
    change = _seen(level, settings) - _seen(still, settings)
    return lag(change / move.step, move.at, SHARES[0] - ROUNDING) if move.lasts == 0 else np.abs(change).max()


def step_response_lab():
    """Return a fresh lab with caches of its own."""
    return Lab(
        name="step-response", title="How late does it follow?", controls=CONTROLS, presets=PRESETS, goals=GOALS, compute=StepEngine().compute,
        figure=figure, drawings=drawings, describe=describe, readouts=readouts, table=table, steering=("method", "beside", "noise"), blocked=blocked,
    )  # fmt: skip


def blocked(settings):
    """Return for each control without effect on the filters chosen the reason why."""
    chosen = {used for name in (settings["method"], settings["beside"]) for used in METHODS[name].uses}
    reasons = {
        control: f"no effect: {whose} is not chosen"
        for whose, controls in OF_FILTERS.items()
        for control in controls
        if not chosen.intersection(controls)
    }
    return reasons | ({"gross": "no effect: with hardly any noise no solution is wrong"} if settings["noise"] == "none" else {})


OF_FILTERS = {
    "a Kalman filter of the paper": ("q", "thresholds"),
    "the adjustment or the joint method": ("window", "holds"),
    "the monitor": ("evidence", "patience"),
}


def figure(result):
    """Return the whole picture as one matplotlib Figure."""
    from gnsslab.figures.step_response import plot_step_response

    return plot_step_response(result)


def drawings():
    """Return the two pictures of the lab."""
    from gnsslab.figures.step_response import build_response, build_series

    return Drawing("series", build_series, 450, 470), Drawing("response", build_response, 370, 470, presented=True)


def describe(result):
    """Return the pictures in words."""
    from gnsslab.figures.step_response import describe_step_response

    return describe_step_response(result)


def readouts(result):
    """Return how late the filter shown is, what it rejects, the step of its means and its error; the one beside it in the notes."""
    first, second = _lags(result) if result.is_for_good else _of_errors(result)
    return [
        first,
        second,
        Readout("Rejected", *_rejected(result.shown), _noted(result, _rejected, f"of the first {COUNTED}")),
        Readout("Means differ by", f"{result.shown.moved:.2f}", "cm", _off_words(result)),
        Readout("RMSE, known truth", f"{result.shown.rmse:.2f}", "cm", _error_note(result)),
    ]


def _off_words(result):
    true = result.size if result.is_for_good else 0.0
    return f"{10 * abs(result.shown.moved - true):.1f} mm off, {len(result.truth)} epochs"


def _lags(result):
    """Return the readouts of a step of the ground."""
    return tuple(Readout(f"Lag to {100 * share:.0f} %", *_lag(result, result.shown, n), _lag_note(result, n)) for n, share in enumerate(SHARES[:2]))


def _lag(result, track, n):
    if result.settings["step"] == 0:
        return "no step", ""
    return (f"{track.lags[n]:.0f}", "epochs") if np.isfinite(track.lags[n]) else ("never", "")


def _lag_note(result, n):
    return _noted(result, lambda track: _lag(result, track, n), "" if n else _found_words(result.shown))


def _found_words(track):
    return f"found after {track.found:.0f}" if np.isfinite(track.found) else ""


def _of_errors(result):
    """Return the readouts of solutions that are wrong for a while."""
    return (
        Readout("Moved by at most", f"{result.shown.most:.2f}", "cm", _noted(result, lambda track: (f"{track.most:.2f}", ""))),
        Readout(f"{LATER} epochs later", f"{result.shown.left:.2f}", "cm", _noted(result, lambda track: (f"{track.left:.2f}", ""))),
    )


def _rejected(track):
    return ("not told", "") if track.rejected is None else (f"{track.rejected}", "epochs")


def _error_note(result):
    return _noted(result, lambda track: (f"{track.rmse:.2f}", ""), "" if result.settings["beside"] == "raw" else f"raw {result.raw_rmse:.2f}")


def _noted(result, words, first=""):
    """Return what there is to say, and what the filter beside has."""
    return ", ".join(part for part in (first, f"{result.beside.label} {words(result.beside)[0]}") if part)


def table(result):
    """Return what is in the first picture as columns."""
    return {
        "epochs_since_step": result.epochs,
        "truth_cm": result.truth,
        "raw_cm": result.raw,
        f"{result.settings['method']}_cm": result.shown.drawn,
        f"beside_{result.settings['beside']}_cm": result.beside.drawn,
    }


def _judge_follow(result):
    used, shown = result.settings, result.shown
    by_rule = result.is_for_good and used["step"] >= 10 and used["view"] == "near" and _as_noisy(used)
    return bool(by_rule and shown.lags[0] <= 5 and shown.rmse < 1.2), standing(_followed(shown, 0), by_rule)


def _judge_catch(result):
    used, shown = result.settings, result.shown
    by_rule = result.is_for_good and 0 < used["step"] <= 3.6 and used["view"] == "near" and _as_noisy(used)
    return bool(by_rule and shown.lags[1] <= 15 and shown.rmse < 1.2), standing(_followed(shown, 1), by_rule)


def _judge_lock(result):
    used, rejected = result.settings, result.shown.rejected
    by_rule = used["method"] == "joint" and result.is_for_good and 0 < used["step"] <= 13
    return bool(by_rule and rejected > 100), standing(f"{'none' if rejected is None else rejected} of {COUNTED} rejected", by_rule)


def _judge_lucky(result):
    used, off = result.settings, 10 * abs(result.shown.moved - result.size)
    by_rule = used["method"] == "joint" and used["view"] == "all" and result.is_for_good and used["step"] == 3.6 and _as_noisy(used)
    return bool(by_rule and off <= 0.3), standing(f"{off:.1f} mm off", by_rule)


def _as_noisy(used):
    """Return whether errors are no milder than the platform's, and positions are looked at."""
    return used["noise"] != "none" and used["gross"] >= 0.2 and used["seen"] == "position"


def _followed(track, n):
    share, late = 100 * SHARES[n], track.lags[n]
    words = f"{share:.0f} % after {late:.0f} epochs" if np.isfinite(late) else f"{share:.0f} % not reached"
    return f"{words}, RMSE {track.rmse:.2f} cm"


GOALS = (
    Goal("follow-ten", "Near the step, with noise, 0.2 % of gross errors or more, the position looked at: follow half of a step of 10 cm or more "
         "within 5 epochs, with an RMSE about the truth below 1.20 cm.", _judge_follow),
    Goal("catch-small", "The same, and a step of 3.6 cm at most: 90 % of it within 15 epochs, RMSE below 1.20 cm.", _judge_catch),
    Goal("lock-joint", f"Lock the joint method out: a step of 13 cm or less, and more than 100 of the {COUNTED} epochs after it rejected.",
         _judge_lock),
    Goal("lucky", "The paper's 0.3 mm: the joint method, 3.6 cm, all epochs drawn, the position looked at, and the means right to 0.3 mm. "
         "Which of the controls has a say in it?", _judge_lucky),
)  # fmt: skip
