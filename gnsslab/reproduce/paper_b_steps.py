"""Beyond paper B: inserted steps, judged by the truth. How wrong a level is, how late it follows, and what an alarm makes of it.

A method gives a level and an alarm at each epoch of a series. Those that only smooth get the plainest alarm there is: the level is farther
from the true place than a threshold, the smallest one with at most one false alarm a series. It is chosen on other draws of the noise than
those that judge. Each step is put into the very noise that is filtered without it too, so that the difference is the answer to the step.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from gnsslab.reproduce.paper_b_formulas import CM, MOVED
from gnsslab.reproduce.paper_b_runs import draw
from gnsslab.systems.criteria import count_alarms, lag, rmse_about_truth, step_response, threshold_alarm
from gnsslab.systems.deformation import METHODS, PublishedSeries
from gnsslab.systems.monitoring import MonitorSettings, monitor

DIRECTION = np.array([*MOVED, 0.0]) / np.linalg.norm(MOVED)
START = 60  # epochs that alarms are given to settle
PAUSE = 30  # epochs without an alarm after which the next one is another
LATEST = 240  # epochs after a step; an alarm that comes later has missed it
BEFORE = 20  # epochs before a step that are kept of an answer to it
ALLOWED = 1.0  # false alarms a series, the mean over the draws
FINENESS = 0.001  # [m] of a threshold
JUDGES = 100  # the draws that judge are those that choose, plus this number


class Answer(NamedTuple):
    """What a method makes of a series."""

    level: np.ndarray  # (T, 3) [m]
    is_alarm: np.ndarray  # (T,) bool


class Scenario(NamedTuple):
    """A series at rest in which steps of some sizes are put at one epoch."""

    system: PublishedSeries
    first: int  # the first epoch after the step
    sizes: tuple[float, ...]  # [m]


class Judgement(NamedTuple):
    """What came of all methods in a Scenario, by their names."""

    thresholds: dict  # [m], of those that have one
    numbers: dict  # of dicts: key -> (seeds,)
    responses: dict  # of dicts: size [cm] -> the median share (BEFORE + LATEST,) of the step that is in the level


def judge(scenario, seeds, report=lambda: None):
    """Return the Judgement on the seeds that come JUDGES later than these, which choose the thresholds; report() is called for each draw."""
    methods, thresholds = with_thresholds(levels(scenario.system), scenario.system.preset, seeds, report)
    found = judged_steps(methods | step_tests(), scenario, [seed + JUDGES for seed in seeds], report)
    responses = {name: {size: np.median(found[name].pop(f"response {size}"), axis=0) for size in sizes_cm(scenario)} for name in found}
    return Judgement(thresholds, found, responses)


def sizes_cm(scenario):
    """Return the sizes as keys and tables name them."""
    return [f"{size / CM:g}" for size in scenario.sizes]


def levels(system):
    """Return the smoothing methods of paper B by name: a function (series) -> level (T, 3) [m] each."""
    return {"raw": lambda series: series.enu} | {name: _set_up(method, system) for name, method in METHODS.items()}


def step_tests():
    """Return the methods that tell a step from an outlier, by name: a function (series, place) -> Answer each, with an alarm of its own."""
    return {
        "Monitor": _monitored,
    }


def _monitored(series, place):
    found = monitor(series)
    return Answer(found.level, rings(found, MonitorSettings().alarm))


def rings(monitored, size):
    """Return where (T,) a bell rings: when an alarm of a Monitored goes on, and for each step of `size` [m] or more, be the alarm on or not.

    An alarm stays on while the point is displaced. Were the step before a false one, nobody would hear of the next.
    """
    is_ring = np.diff(monitored.alarm, prepend=False) & monitored.alarm
    is_ring[[step.found for step in monitored.steps if np.hypot(*step.size[:2]) >= size]] = True
    return is_ring


def _set_up(method, system):
    return lambda series: method(series, system)


def with_thresholds(smoothers, preset, seeds, report=lambda: None):
    """Return the smoothing methods, each with the alarm of its `smallest_threshold` on these seeds, and the thresholds."""
    distances = {name: [] for name in smoothers}
    for seed in seeds:
        drawn = _still(preset, seed)
        for name, smoother in smoothers.items():
            offset = smoother(drawn.series) - drawn.truth_enu
            distances[name].append(np.hypot(offset[START:, 0], offset[START:, 1]))
        report()
    thresholds = {name: smallest_threshold(each) for name, each in distances.items()}
    return {name: _watched(smoother, thresholds[name]) for name, smoother in smoothers.items()}, thresholds


def smallest_threshold(distances):
    """Return the threshold [m], to FINENESS, down to which distances (T,) of still series pass it ALLOWED times a series or less.

    It comes from above: far below, a level that is past the threshold all the time would be one alarm only.

    >>> float(smallest_threshold([np.repeat([0.0, 0.0305, 0.0, 0.0205, 0.0], 100)]))
    0.021
    """
    highest = int(np.ceil(max(each.max() for each in distances) / FINENESS))
    for threshold in range(highest, 0, -1):
        if np.mean([count_alarms(each > (threshold - 1) * FINENESS, quiet=PAUSE).false_alarms for each in distances]) > ALLOWED:
            return threshold * FINENESS
    return FINENESS


def _watched(smoother, threshold):
    """Return a method: the smoother, and an alarm where its level is past the threshold from where the antenna was at first."""

    def method(series, place):
        level = smoother(series)
        return Answer(level, threshold_alarm(level, place, threshold))

    return method


def judged_steps(methods, scenario, seeds, report=lambda: None):
    """Return the numbers (seeds,) of each method by name and key: of the still series, and for each size in cm."""
    found = {name: [] for name in methods}
    for seed in seeds:
        for name, numbers in _one_draw(methods, scenario, seed):
            found[name].append(numbers)
        report()
    return {name: {key: np.array([each[key] for each in numbers]) for key in numbers[0]} for name, numbers in found.items()}


def _one_draw(methods, scenario, seed):
    still = _still(scenario.system.preset, seed)
    place = still.truth_enu[0]
    for name, method in methods.items():
        quiet = method(still.series, place)
        numbers = _still_numbers(quiet, still.truth_enu)
        for size in scenario.sizes:
            move = np.where(np.arange(len(still.truth_enu)) < scenario.first, 0.0, size)[:, None] * DIRECTION
            answer = method(replace(still.series, enu=still.series.enu + move), place)
            found = _step_numbers(answer, quiet, still.truth_enu + move, scenario.first, size)
            numbers |= {f"{key} {size / CM:g}": value for key, value in found.items()}
        yield name, numbers


def _still_numbers(quiet, truth):
    return {
        "false alarms": float(count_alarms(quiet.is_alarm[START:], quiet=PAUSE).false_alarms),
        "rmse still": rmse_about_truth(quiet.level, truth) / CM,
    }


def _step_numbers(answer, quiet, truth, first, size):
    """Return lag of alarm and of level [epochs], and errors about the truth [cm]: of all epochs, and of LATEST after the step."""
    response = step_response(answer.level, quiet.level, size * DIRECTION)
    alarm = count_alarms(answer.is_alarm & ~quiet.is_alarm, first).lag  # one that rings anyway tells nothing
    after = slice(first, first + LATEST)
    return {
        "alarm": alarm if alarm <= LATEST else np.nan,
        "missed": 100.0 * (not alarm <= LATEST),
        "rmse": rmse_about_truth(answer.level, truth) / CM,
        "rmse after": rmse_about_truth(answer.level[after], truth[after]) / CM,
        "response": response[first - BEFORE : first + LATEST],
    } | {f"lag {100 * share:.0f}": lag(response, first, share) for share in (0.5, 0.9, 0.99)}


def _still(preset, seed):
    """Return a draw of a preset with its own steps taken out: nothing moves."""
    drawn = draw(preset, seed)
    moved = drawn.truth_enu - drawn.truth_enu[0]
    return replace(drawn, series=replace(drawn.series, enu=drawn.series.enu - moved), truth_enu=drawn.truth_enu - moved)
