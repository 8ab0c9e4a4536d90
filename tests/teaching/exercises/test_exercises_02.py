"""Exercises of lesson 02, worked out by a second route."""

import itertools
import math
from fractions import Fraction

import numpy as np
import pytest

from gnsslab.gnss.correlation import double_difference_covariance
from gnsslab.gnss.differences import difference_operator, grouped_difference_operator
from gnsslab.gnss.signals import SPEED_OF_LIGHT
from gnsslab.systems.printed_differences import doubled_covariance_as_printed, unsquared_covariance_as_printed
from gnsslab.teaching.exercises.lesson_02 import PREDICTION, QUESTIONS

ASKED = {question.name: question for question in QUESTIONS}
DRAWS = 200_000


def answer(name):
    """Return what a second route must give: the answer, to the digits written down."""
    return pytest.approx(ASKED[name].answer, rel=2e-6)


def mistakes(name):
    """Return the values of the usual mistakes of a question."""
    return [mistake.value for mistake in ASKED[name].mistakes]


def drawn(rng, sigma, reference):
    """Return double differences (DRAWS, m - 1) of noise of the given sigmas (m,), loops in place of the operator."""
    reading = rng.standard_normal((DRAWS, 2, len(sigma))) * sigma
    single = reading[:, 1] - reading[:, 0]
    return np.column_stack([single[:, s] - single[:, reference] for s in range(len(sigma)) if s != reference])


def correlation(Q):
    """Return the correlation coefficient of the first two."""
    return Q[0, 1] / math.sqrt(Q[0, 0] * Q[1, 1])


def test_sigma_of_a_double_difference_by_drawing_and_by_the_library(rng):
    sigma = np.full(3, 3.0)
    assert drawn(rng, sigma, 0)[:, 0].std() == pytest.approx(6.0, rel=4 / math.sqrt(2 * DRAWS))
    assert math.sqrt(double_difference_covariance(sigma, 0)[0, 0]) == answer("sigma-of-a-double-difference")


def test_mistakes_of_the_sigma():
    assert mistakes("sigma-of-a-double-difference") == pytest.approx([4 * 3.0**2, 4 * 3.0, math.sqrt(2) * 3.0, 3.0], rel=1e-4)


@pytest.mark.parametrize(
    ("name", "sigma"), [("correlation-of-two-differences", (3.0, 3.0, 3.0)), ("correlation-with-a-poor-reference", (6.0, 3.0, 3.0))]
)
def test_correlations_by_drawing_and_by_the_library(rng, name, sigma):
    """A correlation coefficient of N draws is good to (1 - rho^2) / sqrt N."""
    rho = ASKED[name].answer
    counted = np.corrcoef(drawn(rng, np.array(sigma), 0), rowvar=False)[0, 1]
    assert counted == pytest.approx(rho, abs=4 * (1 - rho**2) / math.sqrt(DRAWS))
    assert correlation(double_difference_covariance(np.array(sigma), 0)) == answer(name)


def test_correlations_in_exact_fractions():
    poor = Fraction(6) ** 2 / (Fraction(6) ** 2 + Fraction(3) ** 2)
    assert [Fraction(2, 4), poor] == [Fraction(1, 2), Fraction(4, 5)]
    assert float(poor) == answer("correlation-with-a-poor-reference")


def test_mistakes_of_the_correlations():
    assert mistakes("correlation-of-two-differences") == pytest.approx([0.0, 2.0, 1 / 4, math.sqrt(1 / 2)], rel=1e-4)
    unsquared = correlation(unsquared_covariance_as_printed(np.array([6.0, 3.0, 3.0]), 0))
    assert mistakes("correlation-with-a-poor-reference") == pytest.approx([0.5, unsquared, 1 - 0.8], rel=1e-4)


def test_millisecond_of_the_rover_by_moving_the_satellites():
    """Second route: distances at two moments a millisecond apart, differenced."""
    later, earlier = ({s: 2.2e7 + rate * t for s, rate in (("s", 450.0), ("ref", -250.0))} for t in (1e-3, 0.0))
    wrong = (later["s"] - later["ref"]) - (earlier["s"] - earlier["ref"])
    assert wrong == pytest.approx(ASKED["millisecond-of-the-rover"].answer, abs=1e-6)
    assert ASKED["millisecond-of-the-rover"].answer > 3 * 0.1903  # "more than three wavelengths"


def test_mistakes_of_the_millisecond():
    assert mistakes("millisecond-of-the-rover") == pytest.approx([(450 - 250) * 1e-3, 450e-3, 700.0, SPEED_OF_LIGHT * 1e-3])


def test_how_many_double_differences_is_a_rank():
    """All differences of pairs within a system, however many: their rank is what is independent."""
    system = "GGGGGGEEEEE"
    pairs = [(i, j) for i, j in itertools.combinations(range(11), 2) if system[i] == system[j]]
    every = np.zeros((len(pairs), 11))
    for row, (i, j) in enumerate(pairs):
        every[row, i], every[row, j] = 1, -1
    assert np.linalg.matrix_rank(every) == ASKED["how-many-double-differences"].answer
    assert len(grouped_difference_operator(np.array(list(system)), np.arange(11.0))) == ASKED["how-many-double-differences"].answer
    assert mistakes("how-many-double-differences") == [11, len(difference_operator(11, 0)), len(pairs)]


def test_two_v_by_drawing_and_by_the_library(rng):
    V = rng.standard_normal((DRAWS, 2))
    counted = np.std(2 * V[:, 0]) / np.std(V[:, 1] - V[:, 0])
    assert counted == pytest.approx(math.sqrt(2), rel=4 * math.sqrt(1 / DRAWS))
    printed, right = (build(np.ones(4), 0) for build in (doubled_covariance_as_printed, double_difference_covariance))
    assert math.sqrt(printed[0, 0] / right[0, 0]) == answer("two-v")
    assert mistakes("two-v") == pytest.approx([2.0, 4.0, 1 / math.sqrt(2), 1.0], rel=1e-4)


def test_solution_of_two_v_tells_the_labs_promises():
    from gnsslab.labs.correlation import correlation_lab

    lab = correlation_lab()
    promised = [round(100 * lab.run(belief=belief).solved.promised) for belief in ("doubled", "respected")]
    assert f"{promised[0]} instead of {promised[1]} %" in ASKED["two-v"].solution


def test_prediction_is_what_the_lab_shows():
    from gnsslab.labs.cancelling import cancelling_lab

    left = cancelling_lab().run().levels.double
    assert 0.001 < np.sqrt(np.mean(left**2)) < 0.010
    assert PREDICTION.answer == "millimetres"
