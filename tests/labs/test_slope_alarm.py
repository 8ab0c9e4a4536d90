"""Lab of the alarm above a village: what counts as an alarm, the paper's filter at a metre, presets' numbers, goals, own files."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gnsslab.gnss.series import series_of_numbers
from gnsslab.labs import slope_data
from gnsslab.labs.alarm_kinds import KINDS, held_for, wake_ups
from gnsslab.labs.campaigns import FileReader
from gnsslab.labs.slope_alarm import THRESHOLDS, good_thresholds, slope_alarm_lab
from gnsslab.labs.slope_data import BURSTS, CM, DOWNHILL, Motion, WrongFixes, true_motion, with_motion, with_wrong_fixes
from gnsslab.simulate import find_series_preset, simulate_series

MM = 1e-3
HARD = {"burst_length": 10}


@pytest.fixture(scope="module")
def lab():
    """A lab of this module's own."""
    return slope_alarm_lab()


def at(lab, name):
    """Return the result of a preset."""
    return lab.run(**lab.preset(name).settings)


# --- alarms


@given(st.lists(st.booleans(), max_size=60), st.integers(1, 9))
def test_wake_ups_are_counted_as_one_by_one(on, again):
    count, last = 0, None
    for k, is_on in enumerate(on):
        if is_on and (last is None or k - last >= again):
            count, last = count + 1, k
    assert wake_ups(np.array(on, dtype=bool), again) == count


@given(st.lists(st.floats(0, 9), min_size=1, max_size=40), st.integers(1, 12), st.floats(0, 9))
def test_an_alarm_waits_for_so_many_in_a_row(distance, wait, threshold):
    held = held_for(np.array(distance), wait) > threshold
    for k in range(wait - 1, len(distance)):
        assert held[k] == all(value > threshold for value in distance[k - wait + 1 : k + 1])


def test_a_higher_threshold_never_has_more_false_alarms_nor_less_lag(lab):
    for curve in lab.run().curves.values():
        assert (np.diff(curve.false) <= 0).all()
        lags = np.where(np.isfinite(curve.lag), curve.lag, np.inf)
        assert (lags[1:] >= lags[:-1]).all()
        assert curve.false[0] > curve.false[-1]


@pytest.mark.parametrize("kind", KINDS)
def test_curves_are_what_the_lab_itself_finds_at_each_threshold(lab, kind):
    settings = {"alarm": kind, "wait": 6}
    curve = lab.run(**settings).curve
    for index in (2, 8, 14, 40):
        result = lab.run(**settings, threshold=float(THRESHOLDS[index]))
        assert result.false == curve.false[index]
        assert result.lag == pytest.approx(curve.lag[index], abs=1e-6, nan_ok=True)


def test_what_is_known_at_an_epoch_knows_nothing_of_later_ones(lab):
    """Before the motion the lines with and without it are the same: all kinds of alarm can be used while it happens."""
    for kind in KINDS:
        moved, still = (lab.run(alarm=kind, wait=6, step=step) for step in (3.6, 0))
        np.testing.assert_allclose(moved.line.score[: moved.at], still.line.score[: moved.at], rtol=0, atol=1e-6 * MM)


# --- what is put in


def test_motion_and_wrong_fixes_are_as_said():
    series = simulate_series(find_series_preset("b-fixed"), np.random.default_rng(1)).series
    motion = Motion(1000, 5 * CM, 1 * CM)
    moved = with_motion(series, motion)
    along = (moved.enu - series.enu) @ DOWNHILL
    np.testing.assert_allclose(along[[0, 999, 1000, 1240]], [0, 0, 5 * CM, 6 * CM], atol=1e-12)  # 240 epochs of 15 s are an hour
    np.testing.assert_allclose(along, true_motion(series.time, motion), atol=1e-12)
    wrong = with_wrong_fixes(series, WrongFixes(4, 20 * CM, 1))
    off = np.linalg.norm(wrong.enu - series.enu, axis=1)
    assert np.allclose(off[off > 0], 20 * CM) or (off > 0).sum() < BURSTS * 4  # two bursts may fall on each other
    assert off[len(series) // 8] == pytest.approx(20 * CM)
    assert 0 < (off > 0).sum() <= BURSTS * 4


# --- presets and goals


def test_presets_say_what_happens(lab):
    assert (at(lab, "restless").false, at(lab, "restless").lag) == (55, 0)
    assert at(lab, "quiet-night").false == 0
    assert lab.run(**lab.preset("quiet-night").settings | {"threshold": 3}).false == 45
    three = at(lab, "wrong-fix-at-three")
    assert three.x[np.argmax(three.alarm)] == pytest.approx(3.0, abs=0.001)
    assert three.false > 1
    assert (at(lab, "patience").false, round(at(lab, "patience").lag, 6)) == (0, 2.25)
    assert at(lab, "longer-bursts").false > 1
    missed = at(lab, "threshold-too-high")
    assert missed.false == 0
    assert missed.known is None
    late = at(lab, "late-average")
    assert (round(late.lag, 6), round(late.excursion / CM, 1)) == (43.5, 1.6)
    locked = at(lab, "locked-out")
    assert locked.lag > 30
    assert locked.line.is_outlier[locked.at + 10 : locked.at + 90].all()


def test_presets_of_the_monitor_say_what_happens(lab):
    patient, hasty, slide = (at(lab, name) for name in ("watchman", "hasty-watchman", "slow-slide"))
    assert patient.false == 0
    assert patient.excursion < 4 * CM
    assert np.isfinite(patient.lag)
    assert hasty.false >= 3
    assert hasty.excursion > 15 * CM
    assert 50 < slide.lag < 150  # minutes: 2.5 cm take 150


def test_goal_of_the_simulated_day_can_be_reached(lab):
    goal, settings = lab.goal("caught"), {"wait": 11, "threshold": 2.75} | HARD
    assert goal.judge(lab.run(**settings))[0]
    for broken in ({"noise": 45}, {"wrong_fixes": False}, {"burst_length": 9}, {"step": 4}, {"wait": 10}, {"threshold": 4}):
        assert not goal.judge(lab.run(**settings | broken))[0]


def test_goal_of_the_real_day_can_be_reached(lab, slope_day):
    goal, settings = lab.goal("real"), {"data": "slope", "step": 5, "wait": 11, "threshold": 2} | HARD
    assert goal.judge(lab.run(**settings))[0]
    assert not goal.judge(lab.run(**settings | {"wait": 1}))[0]
    assert not goal.judge(lab.run(**settings | {"step": 0}))[0]
    untouched = at(lab, "real-day")
    assert untouched.false == 0
    assert not untouched.alarm.any()


def test_thresholds_that_do_are_those_without_false_alarm_and_in_time(lab):
    result = lab.run(wait=10)
    words = {readout.label: readout.value for readout in lab.readouts(result)}["Thresholds that do"]
    first, last = (float(value) for value in words.split(" to "))
    for threshold, does in ((first, True), (last, True), (first - 0.25, False), (last + 0.25, False)):
        moved = lab.run(wait=10, threshold=threshold)
        assert (moved.false == 0 and moved.lag <= 30) == does
    assert good_thresholds(result.curve, moves=True).sum() == 1 + (last - first) / 0.25


# --- real data


def test_the_papers_filter_sleeps_through_an_earthquake_of_a_metre(lab, dataset):
    dataset("geonet-tohoku-neu")
    asleep, awake = at(lab, "tohoku-asleep"), at(lab, "tohoku-awake")
    assert asleep.known is None
    assert np.hypot(0.893, 0.521) == pytest.approx(np.median(asleep.raw[asleep.at + 1 : asleep.at + 8]), abs=0.05)  # the registry's step
    assert asleep.line.is_outlier[asleep.at + 1 :].all()
    assert awake.lag < 10  # days
    assert asleep.false == awake.false == 0
    creeping = at(lab, "creeping-plate")
    assert creeping.false > 0
    assert creeping.at == np.searchsorted(creeping.x, (np.datetime64("2011-03-11") - np.datetime64("2005-07-29")).astype(float) / 365.25 - 1e-6)


def test_the_slope_is_solved_once_and_kept(dataset, tmp_path, monkeypatch):
    dataset("beidou-slope")
    series = series_of_numbers(np.datetime64("2024-01-01", "ns") + np.arange(3) * np.timedelta64(15, "s"), np.zeros((3, 3)))
    solved = []
    monkeypatch.setattr(slope_data, "cache_folder", lambda: tmp_path)
    monkeypatch.setattr(slope_data, "solve_relative", lambda *files, **options: solved.append(options))
    monkeypatch.setattr(slope_data, "series_of", lambda solution: series)
    monkeypatch.setattr(FileReader, "data_set", lambda self, name: (None, None, None))
    first, again = slope_data.solved_slope(FileReader()), slope_data.solved_slope(FileReader())
    assert len(solved) == 1
    for name in slope_data.ARRAYS:
        np.testing.assert_array_equal(getattr(first, name), getattr(again, name))
    (kept,) = (tmp_path / slope_data.SLOPE).iterdir()
    kept.write_bytes(kept.read_bytes()[:100])  # half a file, from a full disk
    slope_data.solved_slope(FileReader())
    assert len(solved) == 2


def test_own_file_is_read_and_a_long_one_cut(lab, tmp_path, rng, monkeypatch):
    lines = ["time,east_m,north_m,up_m", *(f"2024-01-01T{k // 60:02}:{k % 60:02}:00,{e:.4f},{n:.4f},{u:.4f}" for k, (e, n, u) in enumerate(
        0.002 * rng.standard_normal((1200, 3))))]  # fmt: skip
    path = tmp_path / "mine.csv"
    path.write_text("\n".join(lines))
    result = lab.run(data="mine", file=path, wait=10, threshold=2)
    assert (len(result.raw), result.false) == (1200, 0)
    assert result.lag == pytest.approx(9)  # ten epochs of a minute
    monkeypatch.setattr(slope_data, "LONGEST", 500)
    path.write_text("\n".join([*lines, ""]) + "\n")
    cut = lab.run(data="mine", file=path)
    assert len(cut.raw) == 500
    assert "first 500 of 1200" in cut.note
    path.write_text("\n".join(lines[:20]))
    assert "32 or more" in lab.run(data="mine", file=path).problem
