"""Exercises of lesson 04, worked out by a second route."""

import math
from statistics import NormalDist

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import binom, multivariate_normal

from gnsslab.core.integers import adop, best_integer_equivariant, ratio_test, success_rate
from gnsslab.core.integers.success import adop_success_rate
from gnsslab.teaching.exercises.lesson_04 import PREDICTION, QUESTIONS

ASKED = {question.name: question for question in QUESTIONS}
NORMAL = NormalDist()
DRAWS = 400_000


def answer(name, rel=1e-3):
    """Return what a second route must give: the answer, to the digits written down."""
    return pytest.approx(ASKED[name].answer, rel=rel)


def mistakes(name):
    """Return the values of the usual mistakes of a question."""
    return [mistake.value for mistake in ASKED[name].mistakes]


def test_success_rate_of_one_by_an_integral_a_count_and_the_library(rng):
    inside, _ = quad(lambda x: math.exp(-(x**2) / 2 / 0.25**2) / (0.25 * math.sqrt(2 * math.pi)), -0.5, 0.5)
    counted = np.mean(np.rint(0.25 * rng.standard_normal(DRAWS)) == 0)
    assert 100 * inside == answer("success-rate-of-one")
    assert counted == pytest.approx(inside, abs=4 * math.sqrt(inside * (1 - inside) / DRAWS))
    assert 100 * float(success_rate([[0.25**2]])) == answer("success-rate-of-one")


def test_words_about_other_sigmas_of_one():
    assert 100 * float(success_rate([[0.04]])) == pytest.approx(98.8, abs=0.05)
    assert 2 * NORMAL.cdf(-5) < 1e-6
    assert mistakes("success-rate-of-one") == pytest.approx(
        [100 * NORMAL.cdf(2), 100 * (2 * NORMAL.cdf(1) - 1), 100 * (2 * NORMAL.cdf(4) - 1), 0.9545], rel=1e-4
    )


def test_adop_and_many_by_a_product_and_by_uncorrelated_ambiguities():
    rate = 1.0
    for _ in range(20):
        rate *= NORMAL.cdf(2.5) - NORMAL.cdf(-2.5)
    Q = 0.2**2 * np.eye(20)
    assert float(adop(Q)) == pytest.approx(0.2)
    assert 100 * rate == answer("adop-and-many")
    assert 100 * float(success_rate(Q)) == answer("adop-and-many")
    assert 100 * float(adop_success_rate(0.2, 20)) == answer("adop-and-many")


def test_mistakes_and_words_of_adop():
    one = 2 * NORMAL.cdf(2.5) - 1
    assert mistakes("adop-and-many") == pytest.approx([100 * one, 100 - 2000 * (1 - one), 100 * NORMAL.cdf(2.5) ** 20], rel=1e-4)
    assert (round(100 * one**28), round(100 * one**5)) == (70, 94)


def test_mu_turned_round_believes_the_same_fixes(rng):
    norms = np.sort(rng.chisquare(4, (DRAWS, 2)), axis=1)
    best, second = norms.T
    np.testing.assert_array_equal(best / second <= 0.43, second / best >= 1 / 0.43)
    np.testing.assert_array_equal(ratio_test(norms, 1 / 0.43), best / second <= 0.43)
    assert answer("mu-turned-round") == 1 / 0.43
    assert (second / best >= 0.43).all()  # "believes everything"
    assert mistakes("mu-turned-round") == pytest.approx([0.43, 1 - 0.43, 1 / 0.43**2], rel=1e-3)


def test_failures_a_day_by_counting_seconds():
    seconds = sum(1 for _ in range(24) for _ in range(60) for _ in range(60))
    assert float(binom(seconds, 0.001).mean()) == answer("failures-a-day")
    assert mistakes("failures-a-day") == pytest.approx([seconds / 100, 3600 / 1000, seconds, 0.001])


def test_error_of_a_count_by_counting_many_times(rng):
    counts = rng.binomial(3000, 0.316, 100_000) / 3000
    assert 100 * counts.std() == answer("error-of-a-count", rel=4 / math.sqrt(2 * 100_000))
    assert 100 * float(binom(3000, 0.316).std()) / 3000 == answer("error-of-a-count")
    one = math.sqrt(0.316 * 0.684)
    assert mistakes("error-of-a-count") == pytest.approx(
        [one / math.sqrt(3000), 100 * one, 100 * math.sqrt(0.316 / 3000), 100 / math.sqrt(3000)], rel=1e-2
    )
    assert 100 * one / math.sqrt(1000) == pytest.approx(1.5, abs=0.05)


def test_odds_by_two_densities():
    """Second route: a float value at those two squared distances from two integers, and the density of each."""
    Q = np.diag([1.0, 1.0])
    densities = [multivariate_normal([math.sqrt(q), 0.0], Q).pdf([0.0, 0.0]) for q in (0.010, 0.104)]
    assert densities[0] / densities[1] == answer("odds-of-a-ratio-of-ten")
    assert mistakes("odds-of-a-ratio-of-ten") == pytest.approx([10.0, math.exp(0.094), math.sqrt(10), densities[1] / densities[0]], rel=2e-3)


def test_odds_are_those_of_the_scene(dataset):
    dataset("matrtklib-static")
    from gnsslab.labs.fewer_satellites import fewer_satellites_lab

    norms = fewer_satellites_lab().run(satellites=5).stage.norms[24]
    np.testing.assert_allclose(norms, [0.010, 0.104], atol=0.0005)


def test_wrong_of_those_believed_are_counted_in_the_first_lab():
    from gnsslab.labs.trust import trust_lab

    result = trust_lab().run(satellites=5)
    wrong = ~result.is_right[result.is_accepted]
    assert 100 * np.mean(wrong) == pytest.approx(ASKED["wrong-of-those-believed"].answer, abs=ASKED["wrong-of-those-believed"].tolerance)
    assert [round(100 * share, 1) for share in (result.chosen.shares.fixed, result.chosen.shares.fixed_wrong)] == [15.5, 14.4]
    assert mistakes("wrong-of-those-believed") == pytest.approx([14.4, 100 * 1.1 / 15.5, 15.5 - 14.4], rel=1e-2)


def test_best_equivariant_of_one_by_drawing(rng):
    """Second route: of all true integers that could have given this float value, each as often as it does, the mean."""
    truth = rng.integers(-5, 6, 2_000_000)
    near = truth[np.abs(truth + 0.3 * rng.standard_normal(len(truth)) - 0.4) < 0.02]
    assert near.mean() == pytest.approx(ASKED["best-equivariant-of-one"].answer, abs=4 * near.std() / math.sqrt(len(near)) + 0.001)
    assert float(best_integer_equivariant([0.4], [[0.09]]).a[0]) == answer("best-equivariant-of-one")


def test_mistakes_of_best_equivariant():
    half = [math.exp(-(x**2) / 0.09) for x in (0.4, 0.6)]
    assert mistakes("best-equivariant-of-one") == pytest.approx(
        [0.0, 0.4, half[1] / sum(half), 1 - ASKED["best-equivariant-of-one"].answer], rel=1e-3
    )


def test_prediction_is_what_the_real_data_show(dataset):
    dataset("matrtklib-static")
    from gnsslab.labs.fewer_satellites import fewer_satellites_lab

    result = fewer_satellites_lab().run(satellites=5)
    fixed, failed = (int(which.sum()) for which in (result.outcomes.fixed, result.outcomes.failed))
    assert (len(result.off), fixed + failed, failed) == (101, 13, 8)
    assert PREDICTION.answer == "eight"
