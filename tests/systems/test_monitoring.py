"""The monitoring filter: what it finds and what it leaves alone, against the paper's joint method on the same series."""

from functools import cache

import numpy as np
import pytest

from gnsslab.gnss.relative import Status
from gnsslab.gnss.series import Series, series_of_numbers
from gnsslab.simulate import Shift, find_series_preset, simulate_series, with_shifts
from gnsslab.systems.criteria import lag, rmse_about_truth, step_response
from gnsslab.systems.deformation import B_FIXED, joint
from gnsslab.systems.monitoring import Flag, MonitorSettings, held, monitor, usable

STEP_AT = 1128
DIRECTION = np.array([-2.0, -3.0, 0.0]) / 13**0.5  # that of the paper's step


@cache
def simulated(seed, size=0.0):
    """Return the paper's fixed baseline with a step of that size [m] in its middle."""
    return simulate_series(with_shifts(find_series_preset("b-fixed"), Shift(STEP_AT, STEP_AT, tuple(size * DIRECTION))), np.random.default_rng(seed))


@cache
def monitored(seed, size=0.0):
    return monitor(simulated(seed, size).series)


def median_lags(of, size, seeds):
    """Return the median lags to 50, 90 and 99 % of a step [epochs] of a method over seeds."""
    answers = [step_response(of(seed, size), of(seed, 0.0), size * DIRECTION) for seed in seeds]
    return [float(np.median([lag(answer, STEP_AT, share) for answer in answers])) for share in (0.5, 0.9, 0.99)]


@pytest.mark.parametrize("size", [0.10, 0.15])
def test_a_large_step_is_found_at_its_third_epoch(size):
    for seed in range(100, 106):
        first = next(step for step in monitored(seed, size).steps if step.found >= STEP_AT)
        assert first.found == STEP_AT + 2
        assert abs(first.first - STEP_AT) <= 1
        assert np.abs(first.size - size * DIRECTION).max() < 4 * first.sigma.max()
        assert monitored(seed, size).alarm[STEP_AT + 2]


def test_it_beats_the_joint_method_on_small_and_large_steps():
    """Calmer about the truth and sooner, at 2, 3.6 and 10 cm; the false alarms are the next test's."""
    seeds = range(100, 106)
    for size in (0.02, 0.036, 0.10):
        ours = [rmse_about_truth(monitored(seed, size).level, simulated(seed, size).truth_enu) for seed in seeds]
        theirs = [rmse_about_truth(joint(simulated(seed, size).series, B_FIXED), simulated(seed, size).truth_enu) for seed in seeds]
        assert np.mean(ours) < np.mean(theirs)
        ours = median_lags(lambda seed, step: monitored(seed, step).level, size, seeds)
        theirs = median_lags(lambda seed, step: joint(simulated(seed, step).series, B_FIXED), size, seeds)
        assert all(a <= b for a, b in zip(ours, theirs, strict=True)), (size, ours, theirs)


def test_where_nothing_moves_false_alarms_are_rare():
    assert sum(monitored(seed).alarms for seed in range(100, 112)) <= 12  # one a series or fewer


def test_sigma_says_how_large_the_errors_are():
    error = [(monitored(seed).level - simulated(seed).truth_enu)[200:] / monitored(seed).sigma[200:] for seed in range(100, 106)]
    assert 0.6 < np.mean(np.square(error)) < 1.4  # some hundred independent parts; the noise is learnt to some 15 %


def test_knows_nothing_of_later_epochs():
    whole = simulated(100, 0.1).series
    part, all_ = monitor(whole.at(slice(0, 1500))), monitored(100, 0.1)
    same = slice(0, 960)  # blocks of equal noise end at 60, 120, 240, 480, 960 solutions; the last one of the part is shorter
    assert part.level[same] == pytest.approx(all_.level[same], abs=1e-12)
    assert (part.flag[same] == all_.flag[same]).all()


def test_place_of_the_origin_does_not_matter():
    series = simulated(101, 0.1).series
    far = np.array([1000.0, -2000.0, 50.0])
    moved = monitor(Series(series.time, series.enu + far, series.sigma, series.status, series.ratio))
    assert moved.level - far == pytest.approx(monitored(101, 0.1).level, abs=1e-8)
    assert (moved.flag == monitored(101, 0.1).flag).all()


def test_float_and_doubtful_solutions_are_not_used_but_told(rng):
    enu = 0.003 * rng.standard_normal((300, 3))
    status, ratio = np.full(300, Status.FIXED, np.int8), np.full(300, 50.0)
    status[100:110], enu[100:110] = Status.FLOAT, 0.5
    ratio[200:210], enu[200:210] = 3.0, 0.3
    status[250:255], enu[250:255] = Status.NONE, np.nan
    time = np.datetime64("2026-01-01", "ns") + np.arange(300) * np.timedelta64(15_000_000_000, "ns")
    series = Series(time, enu, np.full((300, 3), np.nan), status, ratio)
    assert (~usable(series, 0.1)).sum() == 25
    found = monitor(series)
    assert (found.flag[100:110] == Flag.OUTLIER).all()
    assert (found.flag[200:210] == Flag.OUTLIER).all()
    assert (found.flag[250:255] == Flag.GAP).all()
    assert not found.steps
    assert not found.alarms
    assert np.abs(found.level[60:]).max() < 0.01


def test_before_the_first_solution_there_is_no_level(rng):
    enu = 0.01 * rng.standard_normal((200, 3))
    enu[:5] = np.nan
    found = monitor(series_of_numbers(np.datetime64("2026-01-01", "ns") + np.arange(200) * np.timedelta64(1_000_000_000, "ns"), enu))
    assert np.isnan(found.level[:5]).all()
    assert np.isfinite(found.level[5:]).all()
    assert (found.flag[:5] == Flag.GAP).all()


def test_too_few_solutions_and_odd_settings_are_refused_in_words():
    series = simulated(100).series
    with pytest.raises(ValueError, match="16 solutions or more to learn their noise from; the series has 15"):
        monitor(series.at(slice(0, 15)))
    with pytest.raises(ValueError, match="monitor setting memory must be a number above zero; it is 0"):
        MonitorSettings(memory=0)
    with pytest.raises(ValueError, match="the window of 2 epochs must hold the 3 epochs"):
        MonitorSettings(window=2)


def test_held_is_on_until_it_goes_off():
    assert held(np.array([False, True, False, False]), np.array([True, False, False, True])).tolist() == [False, True, True, False]
    assert not held(np.zeros(3, bool), np.ones(3, bool)).any()
