"""Inserted steps: thresholds that keep their promise, answers that count no noise, rows that say what was asked."""

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gnsslab.reproduce.paper_b_steps import (
    ALLOWED,
    DIRECTION,
    PAUSE,
    Answer,
    Scenario,
    judge,
    judged_steps,
    levels,
    rings,
    smallest_threshold,
    step_tests,
)
from gnsslab.systems.criteria import count_alarms
from gnsslab.systems.deformation import B_FIXED

SCENARIO = Scenario(B_FIXED, 1128, (0.036, 0.10))


@given(st.integers(0, 10_000), st.integers(1, 4))
def test_a_threshold_is_the_smallest_that_keeps_to_what_is_allowed(seed, draws):
    distances = list(np.abs(np.random.default_rng(seed).normal(0, 0.01, (draws, 400))))

    def alarms(threshold):
        return np.mean([count_alarms(each > threshold, quiet=PAUSE).false_alarms for each in distances])

    threshold = smallest_threshold(distances)
    assert alarms(threshold) <= ALLOWED
    assert threshold <= 0.0011 or alarms(threshold - 0.001) > ALLOWED


@pytest.fixture(scope="module")
def judged():
    return judge(SCENARIO, range(3))


def test_all_methods_are_judged_on_every_draw(judged):
    assert set(judged.numbers) == set(levels(B_FIXED)) | set(step_tests())
    for found in judged.numbers.values():
        assert {len(values) for values in found.values()} == {3}
        assert {"false alarms", "rmse still", "alarm 3.6", "missed 10", "lag 90 10", "rmse after 3.6"} <= set(found)
    assert set(judged.thresholds) == set(levels(B_FIXED))


def test_raw_solutions_follow_at_once_and_the_joint_method_does_not(judged):
    assert (judged.numbers["raw"]["lag 99 3.6"] == 0).all()
    assert (judged.numbers["joint"]["lag 90 3.6"] > 30).all()
    np.testing.assert_allclose(judged.responses["raw"]["10"], np.repeat([0.0, 1.0], [20, 240]), atol=1e-9)


def test_an_error_that_never_grows_is_seen_as_one(judged):
    """A method that stays at the first place, rings once whatever happens, and again 5 epochs after a step: its numbers can be told beforehand."""

    def frozen(series, place):
        is_alarm = np.zeros(len(series), dtype=bool)
        has_moved = np.linalg.norm(series.enu[1128:].mean(axis=0) - place) > 0.018  # [m], half of the smaller step
        is_alarm[[500, 1140, *([1133] if has_moved else [])]] = True
        return Answer(np.tile(place, (len(series), 1)), is_alarm)

    found = judged_steps({"frozen": frozen}, SCENARIO, [5])["frozen"]
    assert found["rmse still"] == found["missed 10"] == [0.0]
    assert found["rmse after 10"] == pytest.approx([10.0])
    assert found["rmse 10"] == pytest.approx([10 * np.sqrt((2256 - 1128) / 2256)])
    assert found["alarm 3.6"] == [5.0]
    assert found["false alarms"] == [2.0]  # where nothing moves
    assert np.isnan(found["lag 50 10"]).all()


def test_a_bell_rings_for_each_step_and_for_each_alarm():
    alarm = np.array([0, 1, 1, 1, 1, 0, 1], dtype=bool)
    large, small = (SimpleNamespace(found=found, size=np.array([size, 0.0, 0.5])) for found, size in ((3, 0.03), (4, 0.01)))
    assert np.flatnonzero(rings(SimpleNamespace(alarm=alarm, steps=(large, small)), 0.02)).tolist() == [1, 3, 6]


def test_steps_go_where_the_papers_platform_went():
    np.testing.assert_allclose(np.sqrt(13) * DIRECTION, [-2, -3, 0])
