"""Filters that should stand gross errors and follow a step, compared: run `python tests/benchmarks/step_following.py [seeds]`.

Presets b-step (its own step taken out) and b-fixed, steps of 2 to 15 cm at the middle epoch. Each method has a few candidate settings; of these is
taken, for each preset by itself, the one that finds a 3.6 cm step (b-fixed: 5 cm) soonest in the median on seeds 0 to n - 1, at one false alarm a
series or fewer; where none has so few, the one with fewest. It is judged on seeds 100 to 100 + n - 1. n is 30, and took an hour of one core.

Found means: a step test's own step, or, for the paper's two filters, a level farther from the true place than a threshold. Lags count epochs
after the step; one later than 240 is a miss. The rest of a stepped run is as of the still one: only LEARNT epochs before a step to AFTER
epochs after it are filtered again. RMSE: of the distance from the truth, a whole series, step included.
The rivals learn the noise from the first half of a series, 4096 epochs at most; the monitor as it goes; the paper's have q and r.
"""

import argparse
from dataclasses import replace
from functools import partial

import numpy as np

from gnsslab.simulate import find_series_preset, simulate_series, with_shifts
from gnsslab.systems.criteria import count_alarms, lag, step_response, threshold_alarm
from gnsslab.systems.deformation import B_STEP, joint, robust_kalman
from gnsslab.systems.monitoring import MonitorSettings, monitor
from gnsslab.systems.step_followers import Followed, adaptive_follower, change_point_follower, cusum_follower, multi_process_follower

DIRECTION = np.array([-2.0, -3.0, 0.0]) / 13**0.5
SIZES = (0.02, 0.036, 0.05, 0.07, 0.10, 0.15)  # [m]
JUDGED_BY = {"b-step": 0.036, "b-fixed": 0.05}  # [m] the step that settings are chosen for
START, PAUSE, LATEST = 60, 30, 240  # epochs: without alarms at first, between two alarms, to a miss
LEARNT, AFTER = 16_384, 1500  # epochs
ALLOWED, JUDGES = 1.0, 100
CM = 0.01  # [m]


def monitored(series, **settings):
    """Return the Followed of the monitoring filter."""
    found = monitor(series, MonitorSettings(**settings))
    is_step = np.zeros(len(series), dtype=bool)
    is_step[[step.found for step in found.steps]] = True
    return Followed(found.level, is_step)


def with_alarm(method, threshold, series):
    """Return the Followed of one of the paper's filters whose alarm is a threshold; the place is the mean of the first epochs."""
    level = method(series, B_STEP)
    return Followed(level, threshold_alarm(level, np.median(series.enu[:1000], axis=0), threshold))


def candidates():
    """Return for each method its candidate settings: name -> settings -> a function (series) -> Followed."""
    return {
        "joint, threshold": {f"{h:g}": partial(with_alarm, joint, h) for h in np.arange(0.025, 0.061, 0.0025)},
        "robust KF, threshold": {f"{h:g}": partial(with_alarm, robust_kalman, h) for h in np.arange(0.025, 0.081, 0.005)},
        "adaptive robust KF": _grid(adaptive_follower, agreeing=(6, 12, 24), c0=(3.0, 4.0), c1=(4.25, 4.5, 5.0, 5.5)),
        "multi-process": _grid(multi_process_follower, width=(1.0, 2.0, 4.0), chance=(1e-2, 1e-3, 1e-4), sure=(0.2, 0.5, 0.9)),
        "change points": _grid(change_point_follower, chance=(1e-2, 3e-3), sure=(0.8, 0.9, 0.95, 0.98, 0.99), memory=(300.0, 600.0)),
        "CUSUM": _grid(cusum_follower, drift=(0.25, 0.5, 0.75), limit=(4.0, 6.0, 10.0, 15.0)),
        "monitor": _grid(monitored, threshold=(8.0, 10.0, 12.0), window=(64, 128)),
    }


def _grid(method, **choices):
    grid = [{}]
    for name, values in choices.items():
        grid = [{**settings, name: value} for settings in grid for value in values]
    return {" ".join(f"{name} {value:g}" for name, value in settings.items()): partial(method, **settings) for settings in grid}


def still(preset, seed):
    """Return a simulated series in which nothing moves."""
    return simulate_series(with_shifts(find_series_preset(preset)), np.random.default_rng(seed))


def judge(method, preset, seeds, sizes):
    """Return false alarms (n,), RMSE [cm] (n,) of still series, and for each size lags to 50, 90, 99 %, alarm lag, RMSE [cm] (n, 5)."""
    rows = [_one_series(method, still(preset, seed), sizes) for seed in seeds]
    false_alarms, rmse, steps = (np.array(each, dtype=float) for each in zip(*rows, strict=True))
    return false_alarms, rmse, dict(zip(sizes, np.moveaxis(steps, 1, 0), strict=True))


def _one_series(method, simulated, sizes):
    T = len(simulated.series)
    quiet = method(simulated.series)
    square = np.sum((quiet.level - simulated.truth_enu) ** 2, axis=1)
    part = slice(max(0, T // 2 - LEARNT), min(T, T // 2 + AFTER))
    first, cut = T // 2 - part.start, simulated.series.at(part)
    before = method(cut)
    steps = []
    for size in sizes:
        move = np.where(np.arange(len(cut)) < first, 0.0, size)[:, None] * DIRECTION
        answer = method(replace(cut, enu=cut.enu + move))
        moved = square.copy()
        moved[T // 2 : part.stop] = np.sum((answer.level - simulated.truth_enu[part] - move) ** 2, axis=1)[first:]
        response = step_response(answer.level, before.level, size * DIRECTION)
        found = count_alarms(answer.is_step & ~before.is_step, first).lag
        steps.append([*(lag(response, first, share) for share in (0.5, 0.9, 0.99)), found if found <= LATEST else np.nan, _root_mean(moved)])
    return count_alarms(quiet.is_step[START:], quiet=PAUSE).false_alarms, _root_mean(square), steps


def _root_mean(square):
    return np.sqrt(np.mean(square)) / CM


def median(lags):
    """Return the median of lags (n, ...) over the first axis, a miss being later than all."""
    found = np.median(np.where(np.isnan(lags), np.inf, lags), axis=0)
    return np.where(np.isfinite(found), found, np.nan)


def chosen(settings, preset, seeds):
    """Return the name of the settings that the rule takes."""
    size, best = JUDGED_BY[preset], {}
    for name, method in settings.items():
        false_alarms, _, steps = judge(method, preset, seeds, (size,))
        excess = max(0.0, false_alarms.mean() - ALLOWED)
        late = np.where(np.isnan(steps[size][:, 3]), 2 * LATEST, steps[size][:, 3])
        best[name] = excess, np.median(late), late.mean()  # the mean where medians are equal
    return min(best, key=best.get)


def report(name, settings, false_alarms, rmse, steps):
    """Print a block of the table."""
    print(f"\n{name} ({settings}): {false_alarms.mean():.2f} false alarms a series, RMSE still {rmse.mean():.2f} cm")
    for size, numbers in steps.items():
        lags = "/".join(f"{value:.0f}" for value in median(numbers[:, :3]))
        missed = np.isnan(numbers[:, 3]).sum()
        print(
            f"  {size / CM:4.1f} cm: level {lags:>14} epochs, found after {median(numbers[:, 3]):4.0f}, "
            f"missed {missed:2d} of {len(numbers)}, RMSE {numbers[:, 4].mean():.2f} cm",
            flush=True,
        )


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("seeds", type=int, nargs="?", default=30, help="how many series choose, and as many judge")
    parser.add_argument("--preset", choices=list(JUDGED_BY), action="append", help="one of them only")
    parser.add_argument("--method", action="append", help="one of them only, by name")
    parser.add_argument("--choosing", type=int, help="how many series choose the settings; without it, as many as judge")
    options = parser.parse_args()
    for preset in options.preset or JUDGED_BY:
        print(f"\n== {preset}, {options.seeds} series")
        for name, settings in candidates().items():
            if not options.method or name in options.method:
                best = chosen(settings, preset, range(options.choosing or options.seeds))
                report(name, best, *judge(settings[best], preset, range(JUDGES, JUDGES + options.seeds), SIZES))


if __name__ == "__main__":
    main()
