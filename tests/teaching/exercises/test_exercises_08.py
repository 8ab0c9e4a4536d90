"""Exercises of lesson 08, worked out by a second route."""

import math
from dataclasses import replace
from statistics import NormalDist

import numpy as np
import pytest
from scipy.optimize import brentq

from gnsslab.core.least_squares import least_squares
from gnsslab.core.random_walk import random_walk_filter
from gnsslab.core.robust import igg3, igg3_weight
from gnsslab.simulate import find_series_preset, simulate_series
from gnsslab.simulate.series import gauss_markov
from gnsslab.systems.criteria import lag, step_response
from gnsslab.systems.deformation import B_FIXED, filtered, joint, robust_kalman
from gnsslab.systems.printed_deformation import normal_matrix_as_printed
from gnsslab.systems.window_adjustment import adjust_by_condition
from gnsslab.teaching.exercises.lesson_08 import PREDICTION, QUESTIONS

ASKED = {question.name: question for question in QUESTIONS}
DRAWS = 400_000
Q_WALK, R = 0.48, 9.9  # [cm^2] of the walk an epoch and of a measurement
SETTLED = 400  # epochs after which the filter's variance no longer changes


def answer(name, rel=1e-3):
    """Return what a second route must give: the answer, to the digits written down."""
    return pytest.approx(ASKED[name].answer, rel=rel)


def mistakes(name, rel=1e-3):
    """Return what the values of the usual mistakes of a question must be."""
    return pytest.approx([mistake.value for mistake in ASKED[name].mistakes], rel=rel)


def beyond(sigmas):
    """Return how often a standard normal number is farther from zero."""
    return 2 * NormalDist().cdf(-sigmas)


def step_of(size, weight=None):
    """Return the filter's run over a step without noise, from its first epoch on; lengths in cm."""
    z = np.zeros((SETTLED + 300, 1))
    z[SETTLED:] = size
    run = random_walk_filter(z, Q_WALK, R, weight)
    return run.level[SETTLED:, 0], run.weight[SETTLED:, 0], run.innovation_sigma[SETTLED:, 0]


def test_two_numbers_by_least_squares_and_by_condition():
    solved = least_squares(np.ones((2, 1)), np.array([120.0, 124.0]), [1.5, 3.0])
    assert solved.x[0] == answer("two-numbers-that-disagree", 1e-9)
    assert math.sqrt(solved.Q[0, 0]) == answer("sigma-of-both-together", 1e-6)
    by_condition = adjust_by_condition([120.0], [[1.5**2]], [124.0], [[3.0**2]])
    assert by_condition.position[0] == answer("two-numbers-that-disagree", 1e-9)


def test_mistakes_of_two_numbers():
    by_sigma = (120 / 1.5 + 124 / 3) / (1 / 1.5 + 1 / 3)
    assert [122, by_sigma, 0.2 * 120 + 0.8 * 124, 124] == mistakes("two-numbers-that-disagree", 1e-6)
    difference = math.hypot(1.5, 3.0)
    assert [1.5**2 * 0.8, difference, difference / 2, 1 / (1 / 1.5 + 1 / 3)] == mistakes("sigma-of-both-together")


def test_sigma_of_both_by_drawing(rng):
    old, new = rng.standard_normal((2, DRAWS)) * [[1.5], [3.0]]
    assert np.std(0.8 * old + 0.2 * new) == answer("sigma-of-both-together", 4 / math.sqrt(2 * DRAWS))


def test_rank_by_singular_values_and_by_a_shift(rng):
    spread = rng.standard_normal((2, 3, 3))
    N = normal_matrix_as_printed(*(S @ S.T + np.eye(3) for S in spread))
    sizes = np.linalg.svd(N, compute_uv=False)
    assert np.sum(sizes > 1e-12 * sizes[0]) == ASKED["rank-of-the-normal-matrix"].answer
    np.testing.assert_allclose(N @ np.tile([1.0, 0, 0], 2), 0, atol=1e-12 * sizes[0])  # both by a metre to the east


def test_weight_of_a_doubtful_epoch():
    assert 1 / igg3_weight(1.5, 1.0, 2.0) == answer("what-is-left-of-a-doubtful-epoch", 1e-9)
    plain = 1 / (1 / 1.5 * 0.5)
    assert [1 / 6, math.sqrt(6), plain, 1 / 0.5**2, 1.5] == mistakes("what-is-left-of-a-doubtful-epoch")
    assert beyond(1.5) == pytest.approx(0.13, abs=0.005)


def test_good_epochs_thrown_out_by_drawing(rng):
    weights = igg3_weight(rng.standard_normal(DRAWS), 1.0, 2.5)
    for share, expected in ((weights == 0, beyond(2.5)), (weights < 1, beyond(1))):
        assert np.mean(share) == pytest.approx(expected, abs=4 * math.sqrt(expected * (1 - expected) / DRAWS))
    assert 100 * beyond(2.5) == answer("good-epochs-thrown-out", 1e-5)
    assert [50 * beyond(2.5), 100 * beyond(2), 100 - 100 * beyond(2.5), beyond(2.5)] == mistakes("good-epochs-thrown-out")
    assert (1 / beyond(2.5), 1 / beyond(2)) == pytest.approx((81, 22), abs=0.5)
    assert beyond(2) / find_series_preset(B_FIXED.preset).noise.gross_share == pytest.approx(14, abs=0.5)


def test_gain_by_running_the_filter():
    run = random_walk_filter(np.zeros((SETTLED, 1)), Q_WALK, R)
    P = run.variance[-2, 0] + Q_WALK
    assert answer("gain-when-all-has-settled", 1e-5) == P / (P + R)
    after = run.variance[-1, 0]
    wrong = [Q_WALK / (Q_WALK + R), after / (after + R), 1 - P / (P + R), math.sqrt(Q_WALK / R)]
    assert wrong == mistakes("gain-when-all-has-settled")
    assert (P, after) == pytest.approx((2.433, 1.953), abs=0.0005)


def test_words_about_a_smaller_gain(rng):
    """A hundred times less walk: a third of the scatter, and nine times as slow."""
    noise = math.sqrt(R) * rng.standard_normal((100_000, 1))
    scatter = [np.std(random_walk_filter(noise, q, R).level[2000:]) for q in (Q_WALK, Q_WALK / 100)]
    assert scatter[1] / scatter[0] == pytest.approx(1 / 3, abs=0.05)
    gains = [(q + math.sqrt(q * q + 4 * q * R)) / 2 for q in (Q_WALK, Q_WALK / 100)]
    gains = [P / (P + R) for P in gains]
    assert gains[1] == pytest.approx(0.022, abs=0.0005)
    assert gains[0] / gains[1] == pytest.approx(9, abs=0.1)


def test_small_step_by_running_the_filter():
    level, *_ = step_of(1.0)
    assert 1 + np.argmax(level >= 0.9) == ASKED["a-small-step-through-the-filter"].answer
    assert level[9] == pytest.approx(0.889, abs=0.0005)
    assert 1 + np.argmax(level >= 0.5) == 4
    assert level[0] == pytest.approx(0.2, abs=0.005)  # "a fifth"


def test_lag_of_the_joint_method_in_the_papers_noise(rng):
    series = simulate_series(find_series_preset(B_FIXED.preset), rng).series
    step = np.array([0.036, 0, 0])
    moved = replace(series, enu=series.enu + (np.arange(len(series)) >= 1000)[:, None] * step)
    alone, together = (lag(step_response(way(moved, B_FIXED), way(series, B_FIXED), step), 1000, 0.9) for way in (robust_kalman, joint))
    assert 3 < together / alone < 7  # "about five times as long"


def test_step_too_large_by_trying():
    """Second route: the size at which the run's weight of the first epoch becomes zero."""

    def excess(size, k1):
        _, _, sigma = step_of(size, igg3(1, k1))
        return size / sigma[0] - k1

    milder, papers = (brentq(excess, 3, 15, args=(k1,)) for k1 in (3, 2))
    assert milder == answer("a-step-too-large", 1e-5)
    assert papers == pytest.approx(7.0, abs=0.05)
    assert step_of(milder - 0.01, igg3(1.5, 3))[1][0] > 0
    assert step_of(milder + 0.01, igg3(1.5, 3))[1][0] == 0
    S = (milder / 3) ** 2
    assert [3 * math.sqrt(R), papers, milder / 2, 3 * S, 3 * math.sqrt(S - Q_WALK)] == mistakes("a-step-too-large")


def test_blindness_by_running_the_filter():
    rejected = {size: int(np.argmax(step_of(size, igg3(1, 2))[1] > 0)) for size in (10, 12, 15)}
    assert rejected[12] == ASKED["how-long-it-stays-blind"].answer
    assert (rejected[10], rejected[15]) == (27, 92)
    assert rejected[12] * 15 > 12 * 60  # seconds
    S = 2.433 + Q_WALK * np.arange(400) + R
    one_sigma, without_r = np.argmax(np.sqrt(S) > 12), np.argmax(2 * np.sqrt(S - R) > 12)
    assert [49, one_sigma, rejected[15], without_r] == mistakes("how-long-it-stays-blind")


def test_two_methods_by_ratios():
    assert answer("two-methods-against-one", 1e-5) == 100 - 100 * 1.00 / 1.40
    gains = {scatter: 100 * (1 - scatter / 2.37) for scatter in (1.00, 1.40)}
    assert [57.6 - 40.9, 40, gains[1.00] - gains[1.40], gains[1.00]] == mistakes("two-methods-against-one")


def test_alarms_of_a_quiet_day_by_drawing(rng):
    days = 200
    counted = np.sum(np.abs(rng.standard_normal((days, 5760))) > 3) / days
    expected = ASKED["alarms-of-a-quiet-day"].answer
    assert counted == pytest.approx(expected, abs=4 * math.sqrt(expected / days))
    assert 5760 * beyond(3) == answer("alarms-of-a-quiet-day", 1e-5)
    assert [5760 * beyond(3) / 2, 5760 * beyond(4), beyond(3), 86_400 * beyond(3)] == mistakes("alarms-of-a-quiet-day")
    assert 30 * 5760 * beyond(4.53) == pytest.approx(1, abs=0.03)
    assert pytest.approx(1.5, abs=0.02) == 4.53 / 3


def test_epochs_that_must_agree_by_counting():
    offs = 3.6 / (2.0 / np.sqrt(np.arange(1, 30)))
    assert 1 + np.argmax(offs >= 5) == ASKED["how-many-epochs-must-agree"].answer
    assert mistakes("how-many-epochs-must-agree") == [5 * 2 / 3.6, 1, 5, 3]
    assert offs[[0, 2, 4]] == pytest.approx([1.8, 3.1, 4.0], abs=0.03)
    assert 5760 * beyond(1.8) == pytest.approx(400, abs=20)


def test_minute_of_reflections_by_drawing_and_by_a_double_sum(rng):
    apart = np.abs(np.subtract.outer(np.arange(60), np.arange(60)))
    exact = math.sqrt(np.mean(np.exp(-apart / 110)))
    assert exact == answer("a-minute-of-reflections", 1e-5)
    minutes = gauss_markov(60 * 60_000, 1.0, 110.0, rng).reshape(-1, 60, 3)[::5].mean(axis=1)  # every fifth minute: nearly independent
    assert np.std(minutes) == answer("a-minute-of-reflections", 4 / math.sqrt(minutes.size))
    assert [1 / math.sqrt(60), exact**2, 1, math.exp(-60 / 110)] == mistakes("a-minute-of-reflections")
    assert 1 - exact == pytest.approx(0.08, abs=0.005)
    assert exact / (1 / math.sqrt(60)) == pytest.approx(7, abs=0.2)
    halved = brentq(lambda x: 2 / x**2 * (x - 1 + math.exp(-x)) - 0.25, 1, 20) * 110 / 60
    assert halved == pytest.approx(12.5, abs=0.1)  # minutes
    assert abs(math.sqrt(2 / (60 / 110) ** 2 * (60 / 110 - 1 + math.exp(-60 / 110))) - exact) < ASKED["a-minute-of-reflections"].tolerance / 10


def test_length_that_looks_away_by_two_positions():
    baseline, moved = 1.2 * np.array([3, -2]) / math.sqrt(13), np.array([-0.02, -0.03])
    change = np.linalg.norm(baseline + moved) - np.linalg.norm(baseline)
    assert 1e3 * change == answer("a-length-that-looks-away", 1e-5)
    step = 1e3 * np.linalg.norm(moved)
    assert [step, step**2 / 1200, 100 * change, 50] == mistakes("a-length-that-looks-away")
    along = 1.2 * np.array([-2, -3]) / math.sqrt(13)
    assert np.linalg.norm(along + moved) - 1.2 == pytest.approx(np.linalg.norm(moved))


def test_prediction_is_what_the_filter_shows():
    """Half of 3.6 cm to the south is followed long before half of 15 cm, in the paper's noise."""
    waits = np.array([[_half_followed(seed, size) for size in (0.036, 0.15)] for seed in range(5)])
    assert (waits[:, 0] < waits[:, 1]).all()
    small, large = np.median(waits, axis=0)
    assert large > 10 * small
    assert PREDICTION.answer == "a jump of 3.6 cm"


def _half_followed(seed, size):
    """Return after how many epochs the paper's robust filter has followed half of a step."""
    still = simulate_series(find_series_preset(B_FIXED.preset), np.random.default_rng(seed)).series.enu
    step = np.array([0.0, -size, 0.0])
    moved = still + (np.arange(len(still)) >= 1000)[:, None] * step
    return lag(step_response(filtered(moved, B_FIXED), filtered(still, B_FIXED), step), 1000, 0.5)
