"""Rounding and bootstrapping: the nearest integers, conditioning done another way, and what must not change the answer."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from obvious import covariance

from gnsslab.core.integers import decorrelate, integer_bootstrapping, integer_rounding

floats = st.lists(st.floats(-1e9, 1e9), min_size=1, max_size=8)
cases = st.tuples(st.integers(1, 9), st.integers(0, 2**32 - 1), st.floats(0.0, 4.0))  # n, seed, decades of spread


def problem(n, seed, decades):
    rng = np.random.default_rng(seed)
    return rng.uniform(-20.0, 20.0, n), covariance(n, rng, decades), rng


def bootstrap_by_conditioning(a_hat, Q):
    """Round the last; then each one less the conditional mean, by the covariance of all later ones; in the textbook's words."""
    a = np.zeros(len(a_hat))
    for k in range(len(a_hat) - 1, -1, -1):
        later = slice(k + 1, None)
        moved = Q[k, later] @ np.linalg.solve(Q[later, later], a_hat[later] - a[later])
        a[k] = np.rint(a_hat[k] - moved)
    return a


@given(floats)
def test_rounding_is_the_nearest_integer(a_hat):
    a = integer_rounding(a_hat)
    assert a.dtype == np.int64
    assert np.all(np.abs(np.array(a_hat) - a) <= 0.5)


def test_ties_go_up_and_only_ties():
    below, half = np.nextafter(0.5, 0.0), 0.5
    assert integer_rounding([half, -half, 1 + half, -1 - half, 2.0**50 + half]).tolist() == [1, 0, 2, -1, 2**50 + 1]
    assert integer_rounding([below, -below, -1e-300, 1 - 2.0**-53]).tolist() == [0, 0, 0, 1]
    assert integer_bootstrapping([half, -half], np.eye(2)).tolist() == [1, 0]


@settings(deadline=None)
@given(cases)
def test_bootstrapping_equals_conditioning_one_after_the_other(case):
    a_hat, Q, _ = problem(*case)
    assert np.array_equal(integer_bootstrapping(a_hat, Q), bootstrap_by_conditioning(a_hat, Q))


@settings(deadline=None)
@given(cases)
def test_integer_shift_shifts_the_answer(case):
    a_hat, Q, rng = problem(*case)
    a_hat, shift = np.round(a_hat * 64) / 64, rng.integers(-(2**40), 2**40, len(a_hat))  # sums exact in float64, ties among them
    assert np.array_equal(integer_bootstrapping(a_hat + shift, Q), integer_bootstrapping(a_hat, Q) + shift)
    assert np.array_equal(integer_rounding(a_hat + shift), integer_rounding(a_hat) + shift)


def test_without_correlation_bootstrapping_is_rounding(rng):
    a_hat = rng.uniform(-9, 9, (50, 6))
    assert np.array_equal(integer_bootstrapping(a_hat, np.diag([1.0, 2.0, 3.0, 4.0, 5.0, 6.0])), integer_rounding(a_hat))


def test_one_error_moves_the_correlated_one():
    """Both are known to 0.3 cycles, their difference to 0.03: rounding tears them apart, bootstrapping does not."""
    Q = [[0.0909, 0.09], [0.09, 0.09]]
    assert integer_rounding([7.4, 2.6]).tolist() == [7, 3]
    assert integer_bootstrapping([7.4, 2.6], Q).tolist() == [8, 3]  # 7.4 + 0.4


def test_one_covariance_or_a_stack_of_them_equals_one_by_one(rng):
    Q, a_hat = np.array([covariance(4, rng) for _ in range(3)]), rng.uniform(-9, 9, (2, 1, 4))
    Q.flags.writeable = a_hat.flags.writeable = False
    together = integer_bootstrapping(a_hat, Q)
    assert together.shape == (2, 3, 4)
    for i, k in np.ndindex(2, 3):
        assert np.array_equal(together[i, k], integer_bootstrapping(a_hat[i, 0], Q[k]))
    many = integer_bootstrapping(a_hat, Q[0])
    assert many.shape == (2, 1, 4)
    assert np.array_equal(many[:, 0], together[:, 0])
    assert integer_bootstrapping(np.empty((0, 4)), Q[0]).shape == (0, 4)


@pytest.mark.parametrize("n", [1, 60])
def test_true_integers_are_found_through_decorrelation(n, rng):
    basis = np.linalg.qr(rng.standard_normal((n, n)))[0]
    Q = basis @ np.diag(np.geomspace(1e-8, 1e4, n)) @ basis.T  # condition 1e12 for n = 60
    Q = (Q + Q.T) / 2
    truth = rng.integers(-(10**8), 10**8, n)
    a_hat = truth + 0.01 * np.linalg.cholesky(Q) @ rng.standard_normal(n)
    decorrelation = decorrelate(Q)
    z_hat = decorrelation.Z.T @ (a_hat - np.rint(a_hat))  # fractions: 1e8 cycles times the entries of Z would cost digits
    z = integer_bootstrapping(z_hat, decorrelation.Q_z)
    assert np.array_equal(np.rint(a_hat).astype(np.int64) + decorrelation.restore(z), truth)


@pytest.mark.parametrize("function", [integer_rounding, lambda a_hat: integer_bootstrapping(a_hat, np.eye(2))])
@pytest.mark.parametrize(
    ("a_hat", "message"),
    [
        ([np.nan, 0.2], "a_hat contains NaN or infinity: leave out"),
        ([0.1, -np.inf], "a_hat contains NaN or infinity: leave out"),
        ([0.1, -(2.0**51)], r"a_hat is 2\^51 cycles or more"),
    ],
)
def test_what_cannot_be_rounded_is_explained(function, a_hat, message):
    with pytest.raises(ValueError, match=message):
        function(a_hat)


@pytest.mark.parametrize(
    ("a_hat", "Q", "message"),
    [
        ([0.1, 0.2, 0.3], np.eye(2), r"one value for each row of Q, 2, in its last axis; it has shape \(3,\)"),
        (0.5, np.eye(1), r"it has shape \(\)"),
        (np.zeros((3, 2)), np.ones((2, 2, 2)) + np.eye(2), "do not fit: one Q, or one for each a_hat"),
        ([0.1, 0.2], [[1.0, 2.0], [2.0, 1.0]], "Q is not positive definite"),
    ],
)
def test_bad_calls_are_explained(a_hat, Q, message):
    with pytest.raises(ValueError, match=message):
        integer_bootstrapping(a_hat, Q)
