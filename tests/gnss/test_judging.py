"""Judging: which epochs are believed, by counts on drawn integers; what residuals say of the noise."""

from types import SimpleNamespace

import numpy as np
import pytest

from gnsslab.core.integers import integer_least_squares
from gnsslab.gnss.judging import ODDS, believed_by_odds, believed_by_ratio, ratio_threshold, variance_factor

N, n = 20_000, 5
SIGMAS = 4.5  # of a binomial count: seven in a million by chance
GOOD = {"misfit": 2.0, "freedom": 2.0, "cost": 5.0, "ratio": 4.2, "integers": 5}


def outcome(**changes):
    """Return the part of an Outcome that is judged: one epoch, or as many as the values given."""
    values = {name: np.atleast_1d(value) for name, value in (GOOD | changes).items()}
    return SimpleNamespace(**dict(zip(values, np.broadcast_arrays(*values.values()), strict=True)))


def drawn(rng, factor=1.0):
    """Return the Outcome of N drawn float vectors whose sigmas are so many times those assumed, and which are fixed rightly."""
    A = rng.standard_normal((n, n))
    Q = A @ A.T
    Q *= 0.05 / np.linalg.det(Q) ** (1 / n)  # nine vectors in ten are right
    solution = integer_least_squares(factor * rng.multivariate_normal(np.zeros(n), Q, N), Q)
    return outcome(cost=solution.norms[:, 0], ratio=solution.ratio, integers=n), ~solution.best.any(axis=-1)


def test_odds_are_kept_where_the_noise_is_as_assumed(rng):
    """A second best a thousand times less likely, and further ones: of those believed a few in a thousand may be wrong."""
    found, is_right = drawn(rng)
    believed = believed_by_odds(found, found.integers)
    wrong, allowed = np.sum(believed & ~is_right), 2 / ODDS * believed.sum()
    assert 0.2 < is_right.mean() < 0.95, "else there is nothing to judge"
    assert believed.sum() > 0.03 * N
    assert wrong <= allowed + SIGMAS * np.sqrt(allowed)


def test_worse_noise_than_assumed_does_not_make_believers(rng):
    """Twice the sigma: odds as assumed would be wrong more often than they say; divided by the median of s1 / n they are few."""
    found, is_right = drawn(rng, factor=2.0)
    believed = believed_by_odds(found, found.integers)
    careless = found.cost * (found.ratio - 1) >= 2 * np.log(ODDS)
    assert np.sum(careless & ~is_right) > 2 * np.sum(believed & ~is_right)


@pytest.mark.parametrize("judge", [lambda one: believed_by_ratio(one, one.integers, 16.0), lambda one: believed_by_odds(one, one.integers)])
def test_a_good_epoch_is_believed_and_one_bad_thing_is_enough_against_it(judge):
    """n = 5: ratio 1 + 16 / 5 = 4.2; odds exp((21 - 5) / 2) = 2981. Residuals of three sigma are the worst."""
    assert judge(outcome()).tolist() == [True]
    assert not judge(outcome(misfit=9 * 3.0 + 0.01)).any()
    assert judge(outcome(misfit=9 * 3.0)).all()
    assert not judge(outcome(ratio=1.5)).any()
    assert not judge(outcome(ratio=0.0)).any()


def test_odds_by_hand():
    """13.816 = 2 ln 1000 between the norms; where s1 / n is usually 2 twice as much is asked, below one no less."""
    for cost, asked in ((5.0, 13.816), (1.0, 13.816), (10.0, 27.631)):
        for difference, believed in ((asked - 0.01, False), (asked + 0.01, True)):
            found = outcome(cost=cost, ratio=1 + difference / cost)
            assert believed_by_odds(found, found.integers).tolist() == [believed]
    far = outcome(cost=9 * 6.0 + 0.1, ratio=20.0)
    assert not believed_by_odds(far, far.integers).any(), "float values too far from any integers"


def test_the_usual_epoch_sets_the_level():
    """Nine epochs of s1 / n = 1 and one of 4, 20 between the norms: the median asks 13.8 of all; the other way about it asks 55 of all."""
    for cost, believed in (([5.0] * 9 + [20.0], True), ([20.0] * 9 + [5.0], False)):
        found = outcome(cost=np.array(cost), ratio=1 + 20.0 / np.array(cost))
        assert (believed_by_odds(found, found.integers) == believed).all()


def test_epochs_without_integers_are_never_believed():
    nothing = outcome(ratio=0.0, cost=0.0, integers=0, misfit=0.0, freedom=0.0)
    assert not believed_by_odds(nothing, nothing.integers).any()
    assert not believed_by_ratio(nothing, nothing.integers, 16.0).any()


def test_the_ratio_asked_falls_with_the_number_of_integers():
    asked = ratio_threshold(np.arange(1, 100))
    assert (np.diff(asked) <= 0).all()
    assert asked.min() == 1.5
    assert ratio_threshold(np.array([0])).tolist() == [17.0]


@pytest.mark.parametrize("factor", [0.25, 1.0, 4.0])
def test_residuals_tell_the_variance(rng, factor):
    """A sum of k chi-squares has the variance 2 k; thirty count for what was assumed."""
    freedom = rng.integers(1, 9, 500)
    found = outcome(misfit=factor * rng.chisquare(freedom), freedom=freedom)
    k = freedom.sum()
    assert variance_factor(found, np.ones(500, bool)) == pytest.approx((30 + k * factor) / (30 + k), abs=SIGMAS * factor * np.sqrt(2 / k))
    assert variance_factor(found, np.zeros(500, bool)) == 1.0
    assert abs(variance_factor(found, np.arange(500) == 0) - 1) < 1.0, "a single epoch changes little"
