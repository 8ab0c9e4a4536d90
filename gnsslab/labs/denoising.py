"""Lab of lesson 08: paper B's tables 1 and 2 and figures 1 and 2, live. One series, ten methods, and two answers to which is best."""

from dataclasses import dataclass

import numpy as np

from gnsslab.labs.controls import Choice, Slider
from gnsslab.labs.denoisers import CM, DENOISERS, DIRECTION, PRESET, STEP_AT, WHOLE_SERIES, DenoisedSeries, Scene, rows, weights
from gnsslab.labs.lab import Drawing, Goal, Lab, Preset, Readout, standing
from gnsslab.systems.criteria import lag, lengths, rmse_about_mean, rmse_about_truth, step_response

SHARE = 0.9 - 1e-9  # of a step, which counts as followed; a little less, so that rounding of 27/30 costs no epoch
Q = (0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.48, 1, 2, 5)  # [cm^2 per epoch], the calibrated one among them
AT_ONCE = ("joint", "adjustment", "kalman")  # usable while it happens, and no copy of the raw series
SLOW = "eemd"  # runs only where it is shown

CONTROLS = (
    Choice("method", "Shown", {one.label: name for name, one in DENOISERS.items() if name != "raw"}, "joint",
           help="EEMD-wavelet takes seconds, all others milliseconds: it is computed only when shown."),
    Choice("criterion", "Errors are counted from", {"the series' own mean": "mean", "the known truth": "truth"}, "mean",
           help="The paper's (22) takes the series' own mean for the true value."),
    Slider("step", "Step", 0, 10, 0.5, 0, "cm", help="The point moves along the baseline, in the middle of the series."),
    Slider("counted", "Window counts as", 1, 30, 1, 1, "epochs",
           help="n: the window's error is that of one epoch over the root of n, so w = 1/(n + 1). The paper's n is 1."),
    Slider("average", "Centred window", 5, 120, 1, 15, "epochs", help="Of the moving average and of Savitzky-Golay; an epoch is 15 s."),
    Choice("q", "Random walk q", {f"{q:g} cm\u00b2": q for q in Q}, 0.48, help="By how much a level may walk in an epoch, beside r = 9.9 cm\u00b2."),
    Slider("window", "Window of the adjustment", 5, 120, 1, 30, "epochs", help="How many epochs before this one are averaged.", more=True),
    Choice("holds", "Window holds", {"adjusted": "adjusted", "raw": "raw"}, "adjusted", help="The paper does not say which.", more=True),
    Slider("correlation", "Errors last", 0.5, 120, 0.5, 7.5, "epochs", help="Correlation time of the coloured errors.", more=True),
    Slider("gross", "Gross errors", 0, 4, 0.08, 0.32, "%", help="Share of the epochs with one; its sigma is 13 cm on each axis.", more=True),
    Choice("thresholds", "IGG III", {"none": "none", "k0 1, k1 2": "paper", "k0 2.5, k1 6": "wide"}, "paper",
           help="Where the robust filter begins to doubt a solution, and where it rejects it.", more=True),
    Slider("seed", "Seed", 1, 100, 1, 21, help="Another seed is another draw of the errors.", more=True),
)  # fmt: skip

PRESETS = (
    Preset("paper-tables", "Paper: tables 1, 2", {},
           "Bars end at the paper's diamonds, all within 0.1 cm: one noise model makes both of its tables."),
    Preset("eemd-wavelet", "EEMD-wavelet", {"method": "eemd"},
           "75 decompositions of the series, seconds of work, and 1.67 cm. The moving average needs a millisecond for 1.52."),
    Preset("long-average", "Half an hour", {"method": "average", "average": 120},
           "A moving average over 120 epochs: 0.61 cm. It wins the paper's table, because nothing moves in it."),
    Preset("nearly-constant", "Nearly constant", {"method": "adjustment", "counted": 30},
           "w = 1/31, the error of a mean of 30: 0.15 cm. A line that hardly moves has hardly any scatter about its own mean."),
    Preset("constant-wins", "A constant wins", {"counted": 30, "window": 120, "step": 5},
           "0.86 cm about its own mean, better than the paper's best. About the truth 2.59, worse than raw: it slept through 5 cm."),
    Preset("honest-count", "Count from the truth", {"counted": 30, "window": 120, "step": 5, "criterion": "truth"},
           "The same line, its errors counted from the truth: from the first place to the last."),
    Preset("half-at-once", "Half at once", {"method": "adjustment", "step": 3, "criterion": "truth"},
           "With w = 1/2 half of a 3 cm step comes at once, and 90 % after 48 epochs, 12 minutes. 'As fast as raw' it is not."),
    Preset("counts-as-thirty", "Counts as 30", {"method": "adjustment", "step": 3, "counted": 30, "criterion": "truth"},
           "The window's error over the root of 30, as for white noise: 90 % of the step after 1000 epochs, four hours."),
    Preset("counts-as-eight", "Counts as 8", {"method": "adjustment", "step": 3, "counted": 8, "criterion": "truth"},
           "Between 1 and 30 the error about the truth has its minimum, 0.61 cm. With a larger step it lies at a smaller number."),
    Preset("raw-window", "A window of raw", {"method": "joint", "step": 3, "holds": "raw"},
           "The window holds solutions as they came: 90 % after 29 epochs, not 52, and 1.19 cm about the truth, not 1.04."),
    Preset("no-weights", "No robust weights", {"method": "kalman", "thresholds": "none"},
           "A plain Kalman filter: 1.61 cm, not 1.53. With so few gross errors IGG III hardly matters."),
    Preset("many-gross", "Many gross errors", {"method": "kalman", "gross": 4},
           "4 % of gross errors: raw goes from 2.36 to 3.28 cm, the robust filter stays at 1.53; without weights 1.73."),
    Preset("long-errors", "Errors that last", {"method": "average", "correlation": 60},
           "Errors last 15 minutes, four windows of 15 epochs: the average takes off 24 %, not 36. It cannot tell them from a motion."),
    Preset("short-errors", "Nearly white", {"method": "average", "correlation": 1},
           "Errors last one epoch: the same 15 epochs take off 65 %. What a filter gains is said by the noise first."),
    Preset("small-q", "Small q", {"method": "kalman", "q": 0.05, "step": 3},
           "q = 0.05: the Kalman filter alone has 1.11 cm about the truth, near the joint method's 1.04, and is faster: 46 epochs."),
    Preset("next-morning", "The next morning", {"method": "smoother", "q": 0.05, "step": 3, "criterion": "truth"},
           "With the whole series at hand the smoother has 0.87 cm and bends before the step. No alarm can wait for it."),
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class DenoisingResult:
    """One series of T epochs, and what the methods make of the length of its baseline."""

    settings: dict  # of the controls, all of them
    hours: np.ndarray  # (T,) since the start
    truth: np.ndarray  # (T,) [m] true length
    lengths: dict  # (T,) [m] by name of DENOISERS
    about_mean: dict  # [cm] RMSE, paper B (22)
    about_truth: dict  # [cm] RMSE
    lags: dict  # [epochs] to 90 % of the step, NaN where it is never reached; empty without a step
    rows: dict  # Row of each method, by name
    step_at: int  # epoch in the middle, that of the step
    weight: float  # w of an epoch in the adjustment, the median
    problem: str = ""
    note: str = ""

    @property
    def counted(self):
        """The RMSE of all methods [cm] by the criterion chosen."""
        return self.about_mean if self.settings["criterion"] == "mean" else self.about_truth

    @property
    def chosen(self):
        """The name of the method shown."""
        return self.settings["method"]


class DenoisingEngine:
    """From settings to a result, on series that one lab instance keeps."""

    def __init__(self):
        self._series = DenoisedSeries()

    def compute(self, **settings):
        """Return the DenoisingResult of checked settings."""
        scene = Scene(settings["step"], settings["correlation"], settings["gross"], settings["seed"])
        campaign = self._series.simulated(scene)
        names = [name for name in DENOISERS if name != SLOW or settings["method"] == SLOW]
        found, truth = {name: lengths(self._series.denoised(scene, name, settings)) for name in names}, lengths(campaign.truth_enu)
        return DenoisingResult(
            settings=settings,
            hours=np.arange(len(truth)) * PRESET.interval / 3600,
            truth=truth,
            lengths=found,
            about_mean={name: rmse_about_mean(values) / CM for name, values in found.items()},
            about_truth={name: rmse_about_truth(values, truth) / CM for name, values in found.items()},
            lags={name: self._lag(scene, name, settings) for name in names if scene.step > 0 and name != SLOW},
            rows=rows(settings),
            step_at=STEP_AT,
            weight=float(np.median(weights(campaign.series, settings))),
        )

    def _lag(self, scene, name, settings):
        """Return the epochs to 90 % of the step, by the same errors with and without it."""
        moved, still = (self._series.denoised(each, name, settings) for each in (scene, scene._replace(step=0)))
        return lag(step_response(moved, still, scene.step * CM * DIRECTION), STEP_AT, SHARE)


def denoising_lab():
    """Return a fresh lab with caches of its own."""
    return Lab(
        name="denoising", title="Which filter is best?", controls=CONTROLS, presets=PRESETS, goals=GOALS, compute=DenoisingEngine().compute,
        figure=figure, drawings=drawings, describe=describe, readouts=readouts, table=table,
    )  # fmt: skip


def figure(result):
    """Return the whole picture as one matplotlib Figure."""
    from gnsslab.figures.denoising import plot_denoising

    return plot_denoising(result)


def drawings():
    """Return the two pictures of the lab."""
    from gnsslab.figures.denoising import build_ranking, build_series

    return Drawing("series", build_series, 450, 470), Drawing("ranking", build_ranking, 370, 470, presented=True)


def describe(result):
    """Return the pictures in words."""
    from gnsslab.figures.denoising import describe_denoising

    return describe_denoising(result)


def readouts(result):
    """Return the errors of the method shown by both criteria, its lag, the weight of the adjustment, and which method is best."""
    return [
        Readout("RMSE, own mean", f"{result.about_mean[result.chosen]:.2f}", "cm", _printed_words(result)),
        Readout("RMSE, known truth", f"{result.about_truth[result.chosen]:.2f}", "cm", f"raw {result.about_truth['raw']:.2f}"),
        Readout("Lag to 90 %", *_lag_words(result), _ahead_words(result)),
        Readout("Weight w", f"{result.weight:.2f}" if result.weight >= 0.1 else f"{result.weight:.3f}", "", "of an epoch beside its window"),
        _best(result),
    ]


def _printed_words(result):
    printed = DENOISERS[result.chosen].printed
    return f"raw {result.about_mean['raw']:.2f}" + (f", paper {printed:.2f}" if printed else "")


def _lag_words(result):
    """Return the lag and its unit."""
    if result.settings["step"] == 0:
        return "no step", ""
    if result.chosen == SLOW:
        return "not counted", ""
    epochs = result.lags[result.chosen]
    return (f"{epochs:.0f}", "epochs") if np.isfinite(epochs) else ("never", "")


def _ahead_words(result):
    ahead = DENOISERS[result.chosen].ahead(result.settings)
    if ahead == WHOLE_SERIES:
        return "needs the whole series"
    return f"needs the {ahead} epochs after" if ahead else "known at once"


def _best(result):
    """Return the method with the smallest error by the criterion chosen."""
    name = min(result.counted, key=result.counted.get)
    return Readout("Smallest", f"{result.counted[name]:.2f}", "cm", f"{DENOISERS[name].label}, about {_from_words(result)}")


def _from_words(result):
    return "its own mean" if result.settings["criterion"] == "mean" else "the truth"


def table(result):
    """Return what is in the first picture as columns."""
    return {"time_h": result.hours, "true_length_m": result.truth} | {f"{name}_length_m": values for name, values in result.lengths.items()}


def _judge_both(result):
    used, name = result.settings, result.chosen
    error, epochs = result.about_truth[name], result.lags.get(name, float("nan"))
    by_rule = used["step"] >= 3 and name in AT_ONCE and _as_noisy(used)
    return bool(by_rule and error < 1.25 and epochs <= 30), standing(f"{error:.2f} cm about the truth, {_followed(epochs)}", by_rule)


def _judge_between(result):
    used, error = result.settings, result.about_truth[result.chosen]
    by_rule = used["step"] >= 5 and result.chosen in AT_ONCE and _as_noisy(used)
    return bool(by_rule and error < 0.85), standing(f"{error:.2f} cm about the truth", by_rule)


def _judge_fooled(result):
    name, by_rule = result.chosen, result.settings["step"] >= 3
    by_mean, by_truth, raw = result.about_mean[name], result.about_truth[name], result.about_truth["raw"]
    words = f"{by_mean:.2f} cm about its own mean, {by_truth:.2f} about the truth, raw {raw:.2f}"
    return bool(by_rule and by_mean < 1.0 and by_truth > raw), standing(words, by_rule)


def _as_noisy(used):
    """Return whether errors are no milder than the paper's."""
    return used["correlation"] >= 7.5 and used["gross"] >= 0.32


def _followed(epochs):
    return f"90 % of the step after {epochs:.0f} epochs" if np.isfinite(epochs) else "90 % of the step not reached"


GOALS = (
    Goal("both", "A step of 3 cm or more, errors that last 7.5 epochs or longer, 0.32 % or more of gross errors. With joint, adjustment or robust "
         "Kalman: bring the RMSE about the truth below 1.25 cm and follow 90 % of the step within 30 epochs.", _judge_both),
    Goal("between", "The same errors and a step of 5 cm or more. With joint, adjustment or robust Kalman: bring the RMSE about the truth below "
         "0.85 cm, however late.", _judge_between),
    Goal("fooled", "Fool the paper's criterion: a step of 3 cm or more, and a method with less than 1.00 cm about its own mean that is worse than "
         "raw about the truth.", _judge_fooled),
)  # fmt: skip
