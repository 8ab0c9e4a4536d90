"""Decorrelation and factors: what they must keep, what must be reached, the way back, and what is refused."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from obvious import covariance

from gnsslab.core.integers import decorrelate, ltdl

cases = st.tuples(st.integers(1, 12), st.integers(0, 2**32 - 1), st.floats(0.0, 6.0))


def matrix_of(n, seed, decades):
    return covariance(n, np.random.default_rng(seed), decades)


def determinant(Z):
    """The determinant of an integer matrix, exactly: Bareiss elimination in Python's integers."""
    A, sign, previous = [[int(x) for x in row] for row in Z], 1, 1
    for k in range(len(A) - 1):
        pivot = next((i for i in range(k, len(A)) if A[i][k]), None)
        if pivot is None:
            return 0
        if pivot != k:
            A[k], A[pivot], sign = A[pivot], A[k], -sign
        for i in range(k + 1, len(A)):
            for j in range(k + 1, len(A)):
                A[i][j] = (A[i][j] * A[k][k] - A[i][k] * A[k][j]) // previous
        previous = A[k][k]
    return sign * A[-1][-1]


@settings(max_examples=100, deadline=None)
@given(cases)
def test_factors_multiply_back(case):
    Q = matrix_of(*case)
    Z, L, d = decorrelate(Q)
    terms = np.diag(np.abs(Z.T) @ np.abs(Q) @ np.abs(Z))
    rounding = 1e-13 * np.sqrt(np.outer(terms, terms))  # an entry may be small by cancelling
    assert np.all(np.abs(Z.T @ Q @ Z - L.T @ np.diag(d) @ L) <= rounding)
    assert np.all(np.abs(Z.T @ Q @ Z - decorrelate(Q).Q_z) <= rounding)
    assert np.array_equal(decorrelate(Q).Q_z, decorrelate(Q).Q_z.T)


@settings(max_examples=100, deadline=None)
@given(cases)
def test_integers_stay_integers_both_ways(case):
    Z = decorrelate(matrix_of(*case)).Z
    assert Z.dtype == np.int64
    assert abs(determinant(Z)) == 1


@settings(max_examples=100, deadline=None)
@given(cases)
def test_shape_of_the_factors_and_how_far_it_decorrelates(case):
    _, L, d = decorrelate(matrix_of(*case))
    assert np.array_equal(np.diag(L), np.ones(len(d)))
    assert np.array_equal(L, np.tril(L))
    assert np.all(np.abs(np.tril(L, -1)) <= 0.5 + 1e-9)
    later = d[:-1] + np.diag(L, -1) ** 2 * d[1:]  # an exchange of neighbours would give this, and gains nothing
    assert np.all(later >= (1 - 1e-5) * d[1:])


def test_needle_becomes_round():
    """The matrix of the Delft textbooks: correlation 0.993 falls to 0.25, and the variances from 53 and 28 to 4.6 and 4.8."""
    Z, L, d = decorrelate([[53.4, 38.4], [38.4, 28.0]])
    Q_z = L.T @ np.diag(d) @ L
    assert np.allclose(sorted(np.diag(Q_z)), [4.6, 4.8])
    assert np.isclose(abs(Q_z[0, 1]), 1.2)
    assert abs(determinant(Z)) == 1


def test_stack_equals_one_by_one(rng):
    Q = np.array([[covariance(5, rng) for _ in range(3)] for _ in range(2)])
    Q.flags.writeable = False
    Z, L, d = decorrelate(Q)
    assert (Z.shape, L.shape, d.shape) == ((2, 3, 5, 5), (2, 3, 5, 5), (2, 3, 5))
    for index in np.ndindex(2, 3):
        assert all(np.array_equal(whole[index], alone) for whole, alone in zip((Z, L, d), decorrelate(Q[index]), strict=True))


def test_sixty_ambiguities(rng):
    basis = np.linalg.qr(rng.standard_normal((60, 60)))[0]
    Q = basis @ np.diag(np.geomspace(1e-8, 1e4, 60)) @ basis.T
    Z, _, d = decorrelate((Q + Q.T) / 2)
    assert abs(determinant(Z)) == 1
    assert np.isclose(np.sum(np.log(d)), 60 * np.log(1e-2), atol=1e-2)  # det Q; its log is good to cond(Q) * 2e-16 * n


@settings(max_examples=100, deadline=None)
@given(cases)
def test_factors_without_decorrelation_multiply_back(case):
    Q = matrix_of(*case)
    L, d = ltdl(Q)
    assert np.array_equal(np.diag(L), np.ones(len(d)))
    assert np.array_equal(L, np.tril(L))
    assert np.all(np.abs(L.T @ np.diag(d) @ L - Q) <= 1e-13 * np.max(Q))


@settings(max_examples=100, deadline=None)
@given(cases)
def test_factors_are_the_conditional_variances(case):
    """d_i is the variance of a_i once all later ones are known: Q_ii less what they tell, by the covariance of all of them."""
    Q = matrix_of(*case)
    for i, d_i in enumerate(ltdl(Q).d):
        told = Q[i, i + 1 :] @ np.linalg.solve(Q[i + 1 :, i + 1 :], Q[i + 1 :, i])
        assert abs(Q[i, i] - told - d_i) <= 1e-10 * Q[i, i]  # condition up to 1e6


def test_factors_of_sixty_ambiguities_a_trillion_wide(rng):
    basis = np.linalg.qr(rng.standard_normal((60, 60)))[0]
    Q = basis @ np.diag(np.geomspace(1e-8, 1e4, 60)) @ basis.T
    Q = (Q + Q.T) / 2
    L, d = ltdl(Q)
    assert np.all(np.abs(L.T @ np.diag(d) @ L - Q) <= 1e-14 * np.max(Q))
    assert np.isclose(np.sum(np.log(d)), 60 * np.log(1e-2), atol=1e-2)


def test_factors_of_a_stack_equal_one_by_one(rng):
    Q = np.array([[covariance(5, rng) for _ in range(3)] for _ in range(2)])
    Q.flags.writeable = False
    L, d = ltdl(Q)
    assert (L.shape, d.shape) == ((2, 3, 5, 5), (2, 3, 5))
    for index in np.ndindex(2, 3):
        assert np.allclose(L[index], ltdl(Q[index]).L, rtol=1e-12, atol=1e-12)
        assert np.allclose(d[index], ltdl(Q[index]).d, rtol=1e-12)
    assert ltdl(np.empty((0, 2, 2))).d.shape == (0, 2)


@settings(max_examples=100, deadline=None)
@given(cases, st.integers(0, 2**50))
def test_the_way_back_is_exact(case, largest):
    decorrelation = decorrelate(matrix_of(*case))
    a = np.random.default_rng(case[1]).integers(-largest, largest, (3, case[0]), endpoint=True)
    z = a.astype(object) @ decorrelation.Z.astype(object)  # Python's integers: no overflow
    within = np.all(np.abs(z) < 2**63, axis=-1)
    assert np.array_equal(decorrelation.restore(z[within].astype(np.int64)), a[within])
    assert np.array_equal(decorrelation.inverse.astype(object) @ decorrelation.Z, np.eye(case[0]))


def test_the_way_back_of_a_stack(rng):
    Q = np.array([[covariance(5, rng) for _ in range(3)] for _ in range(2)])
    decorrelation, a = decorrelate(Q), rng.integers(-99, 99, (2, 3, 5))
    assert np.array_equal(decorrelation.restore(np.matvec(decorrelation.Z.mT, a)), a)
    assert decorrelate(np.empty((0, 2, 2))).inverse.dtype == np.int64


def test_the_way_back_is_for_whole_numbers():
    with pytest.raises(ValueError, match=r"z must be whole numbers.*inverse\.mT @ z"):
        decorrelate(np.eye(2)).restore([1.0, 0.5])
    with pytest.raises(ValueError, match="z must be whole numbers"):
        decorrelate(np.eye(2)).restore([1.0, np.nan])


@pytest.mark.parametrize("function", [decorrelate, ltdl])
@pytest.mark.parametrize(
    ("Q", "message"),
    [
        ([[1.0, 0.5], [0.4, 1.0]], "Q is not symmetric; a covariance matrix is"),
        ([[1.0, 1.0], [1.0, 1.0]], "Q is not positive definite"),
        ([[[1.0]], [[np.nan]]], r"Q\[1\] contains NaN"),
        ([[1.0, 0.0]], r"shape \(1, 2\)"),
        ([[np.inf, 0.0], [0.0, 1.0]], "Q contains NaN or infinity"),
        ([[1.0, 0.0], [0.0, -1.0]], "Q is not positive definite"),
        ([[1.0, 1e-3], [0.0, 1.0]], "Q is not symmetric"),
        ([[[[1.0]], [[0.0]]]], r"Q\[0, 1\] is not positive definite"),
    ],
)
def test_bad_covariances_are_explained(function, Q, message):
    with pytest.raises(ValueError, match=message):
        function(Q)
