"""Exercises of lesson 03, worked out by a second route."""

import itertools
import math
from fractions import Fraction
from statistics import NormalDist

import numpy as np
import pytest

from gnsslab.core.integers import adop, decorrelate, integer_bootstrapping, integer_rounding, ltdl, success_rate
from gnsslab.gnss.signals import wavelength
from gnsslab.teaching.exercises.lesson_03 import PREDICTION, QUESTIONS

ASKED = {question.name: question for question in QUESTIONS}
Q = np.array([[0.7, 0.4], [0.4, 0.5]])
A_HAT = np.array([5.2, 2.6])


def answer(name):
    """Return what a second route must give: the answer, to the digits written down."""
    return pytest.approx(ASKED[name].answer, rel=2e-5)


def mistakes(name):
    """Return the values of the usual mistakes of a question."""
    return [mistake.value for mistake in ASKED[name].mistakes]


def test_half_a_metre_in_cycles():
    assert 0.5 / wavelength("G", "1") == pytest.approx(ASKED["half-a-metre-in-cycles"].answer, abs=1e-3)
    counted, left = divmod(Fraction(50), Fraction("19.03"))  # whole waves laid end to end, in centimetres
    assert float(counted + left / Fraction("19.03")) == pytest.approx(ASKED["half-a-metre-in-cycles"].answer, abs=1e-3)
    assert mistakes("half-a-metre-in-cycles") == pytest.approx([0.5 * 0.1903, 0.1903 / 0.5, 50 / 1.903, math.ceil(2.627)], rel=1e-3)


def test_integers_in_a_box_by_counting_a_smaller_one():
    """Counted one by one for three ambiguities; the rule then holds for seven."""
    sides = [k for k in range(-20, 21) if abs(k) <= 3 * 5]
    assert sum(1 for _ in itertools.product(sides, repeat=3)) == len(sides) ** 3
    assert len(sides) ** 7 / 1e9 == pytest.approx(ASKED["integers-in-a-box"].answer, abs=0.01)
    assert mistakes("integers-in-a-box") == pytest.approx([30**7 / 1e9, 15**7 / 1e9, 31 * 7, 11**7 / 1e9], rel=1e-3)
    assert "27\\,512\\,614\\,111" in ASKED["integers-in-a-box"].solution
    assert 31**7 == 27_512_614_111
    assert round(31**7 / 1e8 / 60) == 5  # "five minutes"


def test_success_of_one_by_drawing_and_by_the_library(rng):
    N, share = 200_000, ASKED["success-of-one"].answer / 100
    counted = np.mean(np.rint(0.2 * rng.standard_normal(N)) == 0)
    assert counted == pytest.approx(share, abs=4 * math.sqrt(share * (1 - share) / N))
    assert 100 * float(success_rate([[0.04]])) == answer("success-of-one")
    assert round(100 * share**10) == 88  # "88 % is left"


def test_mistakes_of_success_of_one():
    normal = NormalDist()
    one_sided, variance, one_sigma, whole = (
        normal.cdf(0.5 / 0.2),
        2 * normal.cdf(0.5 / math.sqrt(0.2)) - 1,
        2 * normal.cdf(1) - 1,
        2 * normal.cdf(5) - 1,
    )
    assert mistakes("success-of-one") == pytest.approx([100 * one_sided, 100 * variance, 100 * one_sigma, 100 * whole], rel=1e-4)


def test_bootstrapping_by_hand_is_regression(rng):
    """Second route: the mean of the first among draws whose second came out 0.4 above."""
    draws = rng.multivariate_normal([5.2, 2.6], Q, 400_000)
    near = np.abs(draws[:, 1] - 3) < 0.02
    spread = math.sqrt(0.7 - 0.4**2 / 0.5)
    assert draws[near, 0].mean() == pytest.approx(ASKED["bootstrapping-by-hand"].answer, abs=4 * spread / math.sqrt(near.sum()))
    assert 5.2 + ltdl(Q).L[1, 0] * (3 - 2.6) == answer("bootstrapping-by-hand")
    assert integer_bootstrapping(A_HAT, Q).tolist() == [6, 3]  # "bootstrapping says 6, where rounding said 5"
    assert integer_rounding(A_HAT).tolist() == [5, 3]


def test_mistakes_of_bootstrapping():
    expected = [5.2, 5.2 - 0.8 * 0.4, 5.2 + 0.4 * 0.4, 5.2 + 0.4 / 0.7 * 0.4, 5.2 + 0.8 * (2 - 2.6)]
    assert mistakes("bootstrapping-by-hand") == pytest.approx(expected, rel=1e-5)


def test_determinant_after_decorrelation_in_exact_fractions():
    v1, v2, c = Fraction("0.7"), Fraction("0.5"), Fraction("0.4")
    new = (v1 + v2 - 2 * c, v2, c - v2)
    assert new == (Fraction("0.4"), Fraction("0.5"), Fraction("-0.1"))
    assert float(new[0] * new[1] - new[2] ** 2) == answer("determinant-after-decorrelation")
    assert float(np.prod(decorrelate(Q).d)) == answer("determinant-after-decorrelation")
    products = [v1 * v2, v1 * v2 + c**2, new[0] * new[1], (v1 * v2 - c**2) ** 2]
    assert mistakes("determinant-after-decorrelation") == pytest.approx([float(product) for product in products])


def test_adop_of_four():
    sigma = [16, 4, 0.05, 0.02]
    assert float(adop(np.diag(np.square(sigma)))) == answer("adop-of-four")
    assert math.exp(sum(map(math.log, sigma)) / 4) == answer("adop-of-four")
    product = math.prod(sigma)
    assert mistakes("adop-of-four") == pytest.approx([sum(sigma) / 4, product, product ** (1 / 8), product ** (1 / 2)], rel=1e-4)


def test_epochs_for_adop_by_trying(rng):
    root = rng.standard_normal((6, 6))
    Q_one = root @ root.T + 0.1 * np.eye(6)
    Q_one *= (0.36 / float(adop(Q_one))) ** 2
    enough = next(epochs for epochs in range(1, 100) if float(adop(Q_one / epochs)) <= 0.12 * (1 + 1e-9))
    assert enough == ASKED["epochs-for-adop"].answer
    assert mistakes("epochs-for-adop") == pytest.approx([0.36 / 0.12, (0.36 / 0.12) ** 4, math.sqrt(0.36 / 0.12)], rel=1e-4)


def test_prediction_is_what_the_lab_shows():
    from gnsslab.labs.centimetres import centimetres_lab

    result = centimetres_lab().run()
    sharper = np.std(result.float_enu[result.is_right]) / np.std(result.fixed_enu[result.is_right])
    assert sharper == pytest.approx(100, rel=0.1)
    assert PREDICTION.answer == "a hundred times"
    assert np.sqrt(np.trace(result.Q_float[:2, :2])) == pytest.approx(0.75, abs=0.02)  # "good to 75 cm"
