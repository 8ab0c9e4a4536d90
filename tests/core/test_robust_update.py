"""Kalman update with the equivalent covariance: the textbook's at full weight, nothing at none, and what lies between."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gnsslab.core.robust import Weight, danish, huber, igg3, tukey
from gnsslab.core.robust_update import robust_update

SEEDS = st.integers(0, 2**32 - 1)
SIZES = st.integers(1, 6)


def positive_definite(rng, n):
    A = rng.standard_normal((n, n))
    return A @ A.T / n + 0.1 * np.eye(n)


def problem(seed, n, k, gross=0.0):
    """Return x, P, H, R, z of a measurement that the model holds for, but for one gross error in all components."""
    rng = np.random.default_rng(seed)
    P, H, R = positive_definite(rng, n), rng.standard_normal((k, n)), positive_definite(rng, k)
    z = H @ rng.multivariate_normal(np.zeros(n), P) + rng.multivariate_normal(np.zeros(k), R)
    return np.zeros(n), P, H, R, z + gross * rng.standard_normal(k)


def textbook(x, P, H, R, z):
    """Return x and P after the update in information form, with inverses."""
    W = np.linalg.inv(R)
    P_new = np.linalg.inv(np.linalg.inv(P) + H.T @ W @ H)
    return x + P_new @ H.T @ W @ (z - H @ x), P_new


@settings(deadline=None)
@given(seed=SEEDS, n=SIZES, k=SIZES)
def test_at_full_weight_it_is_the_kalman_update(seed, n, k):
    given_ = problem(seed, n, k)
    done = robust_update(*given_, Weight())
    for ours, theirs in zip((done.x, done.P), textbook(*given_), strict=True):
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-8)
    assert (done.weight == 1).all()


@settings(deadline=None)
@given(seed=SEEDS, n=SIZES, k=SIZES, weight=st.sampled_from([igg3(1, 2), tukey(3.0), huber(1.345), danish(2.0)]))
def test_it_is_the_update_with_the_equivalent_covariance_of_what_is_left(seed, n, k, weight):
    x, P, H, R, z = problem(seed, n, k, gross=3.0)
    done = robust_update(x, P, H, R, z, weight)
    v = (z - H @ x) / np.sqrt(np.diag(H @ P @ H.T + R))
    np.testing.assert_allclose(done.weight, weight(v))
    left = done.weight > 1e-6
    if (left == (done.weight > 0)).all():  # 1 / eta within what an inverse bears
        R_bar = (R / np.sqrt(np.outer(done.weight, done.weight) + (1 - np.outer(left, left))))[np.ix_(left, left)]
        expected = textbook(x, P, H[left], R_bar, z[left]) if left.any() else (x, P)
        np.testing.assert_allclose(done.x, expected[0], rtol=0, atol=1e-7)
        np.testing.assert_allclose(done.P, expected[1], rtol=0, atol=1e-7)
    assert (done.P == done.P.T).all()
    assert np.linalg.eigvalsh(done.P)[0] > 0
    assert np.linalg.eigvalsh(P - done.P)[0] > -1e-9  # no measurement makes it worse


@settings(deadline=None)
@given(seed=SEEDS, n=SIZES, k=st.integers(2, 6), bad=st.integers(0, 5), value=st.sampled_from([np.nan, 1e6, -1e6]))
def test_a_wild_or_missing_measurement_is_as_if_it_were_not_there(seed, n, k, bad, value):
    x, P, H, R, z = problem(seed, n, k)
    bad, kept = bad % k, np.arange(k) != bad % k
    z[bad] = value
    with_it = robust_update(x, P, H, R, z, igg3(8, 9))
    without = robust_update(x, P, H[kept], R[np.ix_(kept, kept)], z[kept], igg3(8, 9))
    assert with_it.weight[bad] == 0
    np.testing.assert_array_equal(with_it.x, without.x)
    np.testing.assert_array_equal(with_it.P, without.P)


def test_rejected_altogether_the_state_stays():
    done = robust_update([1.0, 2.0], np.eye(2), np.eye(2), np.eye(2), [900.0, np.nan], igg3(1, 2))
    assert (done.x.tolist(), done.P.tolist()) == ([1.0, 2.0], [[1.0, 0.0], [0.0, 1.0]])


def test_a_hair_of_weight_tells_of_the_other_errors_through_their_correlation():
    """eta near 0 is not the same as 0: the correlation of 0.8 stays, and the other measurement counts as one of variance 1 - 0.8^2."""
    R = [[1.0, 0.8], [0.8, 1.0]]

    def variance(eta):
        return robust_update([0.0], [[1.0]], [[1.0], [1.0]], R, [0.0, 0.0], lambda v: np.array([1.0, eta])).P[0, 0]

    assert variance(0.0) == pytest.approx(1 / (1 + 1))
    assert variance(1e-12) == pytest.approx(1 / (1 + 1 / (1 - 0.8**2)), rel=1e-5)


def test_positive_however_sharp_the_measurement():
    done = robust_update(np.zeros(2), 1e6 * np.eye(2), [[1.0, 1.0]], [[1e-12]], [1.0], huber(1.345))
    assert np.linalg.eigvalsh(done.P)[0] >= 0
    assert done.P[0, 0] == pytest.approx(5e5)


def test_nothing_of_the_callers_is_written():
    given_ = problem(5, 3, 2)
    for array in given_:
        array.flags.writeable = False
    robust_update(*given_, igg3(1, 2))


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"H": np.zeros((3, 3))}, r"expected x \(2,\), P \(2, 2\), H \(2, 2\).*got .*H \(3, 3\)"),
        ({"R": [[1.0, 2.0], [2.0, 1.0]]}, "R, the covariance of the measurements, must be positive definite"),
        ({"R": np.full((2, 2), np.nan)}, "must be positive definite"),
        ({"z": 1.0}, "expected x"),
    ],
)
def test_a_bad_call_is_told_what_was_expected(changed, words):
    arguments = {"x": np.zeros(2), "P": np.eye(2), "H": np.eye(2), "R": np.eye(2), "z": np.zeros(2)} | changed
    with pytest.raises(ValueError, match=words):
        robust_update(**arguments, weight=igg3(1, 2))
