"""The mixed model: float solution, what known integers give, and the length as one more row."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gnsslab.core.mixed_model import FloatSolution, given_integers, solve_float, use_length

cases = st.tuples(st.integers(1, 6), st.integers(1, 4), st.integers(0, 2**32 - 1))  # n, p, seed


def model(n, p, seed):
    """Return a random model, its condition number below a thousand, so that two ways to solve it agree to ten digits."""
    rng = np.random.default_rng(seed)
    k = n + p + 3
    M, axes = (np.linalg.qr(rng.standard_normal((k, columns)))[0] for columns in (n + p, k))
    Q_y = axes @ np.diag(10.0 ** rng.uniform(-1, 1, k)) @ axes.T
    return M[:, :n], M[:, n:], (Q_y + Q_y.T) / 2, rng


@settings(max_examples=60, deadline=None)
@given(cases)
def test_equals_least_squares_of_whitened_rows(case):
    A, B, Q_y, rng = model(*case)
    y, n = rng.standard_normal(len(A)), case[0]
    found = solve_float(y, A, B, Q_y)
    whiten = np.linalg.inv(np.linalg.cholesky(Q_y))
    M = whiten @ np.hstack([A, B])
    x = np.linalg.lstsq(M, whiten @ y, rcond=None)[0]
    Q = np.linalg.pinv(M) @ np.linalg.pinv(M).T
    assert np.allclose(np.concatenate([found.a_hat, found.b_hat]), x, rtol=1e-6, atol=1e-8)
    assert np.allclose(np.block([[found.Q_a, found.Q_ba.T], [found.Q_ba, found.Q_b]]), Q, rtol=1e-6, atol=1e-8)
    assert found.a_hat.shape == (n,)


@settings(max_examples=60, deadline=None)
@given(cases)
def test_given_integers_equals_solving_without_them(case):
    """Conditioning is the same as moving A a to the other side and solving for b alone."""
    A, B, Q_y, rng = model(*case)
    y, a = rng.standard_normal((4, len(A))), rng.integers(-9, 9, case[0])
    b_fix, Q_b_fix = given_integers(solve_float(y, A, B, Q_y), a)
    W = np.linalg.inv(Q_y)
    Q = np.linalg.inv(B.T @ W @ B)
    assert np.allclose(b_fix, (y - A @ a) @ (W @ B @ Q), rtol=1e-6, atol=1e-7)
    assert np.allclose(Q_b_fix, Q, rtol=1e-6, atol=1e-8)


@settings(max_examples=60, deadline=None)
@given(cases)
def test_length_row_equals_one_more_measurement(case):
    A, B, Q_y, rng = model(*case)
    p, n = B.shape[1], A.shape[1]
    y = rng.standard_normal(len(A)) + B @ rng.uniform(2, 3, p)
    free = solve_float(y, A, B, Q_y)
    tied = use_length(free, 2.0, 0.05)
    h = free.b_hat / np.linalg.norm(free.b_hat)
    row_y = 2.0 - np.linalg.norm(free.b_hat) + h @ free.b_hat
    with_row = solve_float(
        np.append(y, row_y),
        np.vstack([A, np.zeros((1, n))]),
        np.vstack([B, h]),
        np.block([[Q_y, np.zeros((len(y), 1))], [np.zeros((1, len(y))), np.full((1, 1), 0.05**2)]]),
    )
    for ours, theirs in zip(tied[:5], with_row[:5], strict=True):
        assert np.allclose(ours, theirs, rtol=1e-6, atol=1e-8)
    assert tied.length_used
    assert not free.length_used


def test_length_row_in_a_stack(rng):
    A, B, Q_y, _ = model(3, 3, 8)
    free = solve_float(rng.standard_normal((5, len(A))) + 5.0, A, B, Q_y)
    tied = use_length(free, 2.0, 0.05)
    assert tied.Q_a.shape == (5, 3, 3)
    alone = use_length(free._replace(a_hat=free.a_hat[2], b_hat=free.b_hat[2]), 2.0, 0.05)
    assert all(np.allclose(whole[2], one) for whole, one in zip(tied[:5], alone[:5], strict=True))


def test_a_length_counts_once():
    free = FloatSolution(np.zeros(1), np.array([0.0, 3.0]), np.eye(1), np.eye(2), np.zeros((2, 1)))
    tied = use_length(free, 2.0, 0.01)
    assert "known length used" in repr(tied)
    with pytest.raises(ValueError, match="count it twice"):
        use_length(tied, 2.0, 0.01)


@pytest.mark.parametrize(
    ("length", "sigma", "message"), [(-1.0, 0.1, "length must be a positive number of m; it is -1"), (1.0, 0.0, "sigma of the length")]
)
def test_bad_lengths_are_explained(length, sigma, message):
    free = FloatSolution(np.zeros(1), np.array([0.0, 3.0]), np.eye(1), np.eye(2), np.zeros((2, 1)))
    with pytest.raises(ValueError, match=message):
        use_length(free, length, sigma)


@pytest.mark.parametrize(
    ("Q_a", "a_fix", "message"),
    [(np.eye(2), [1.0, 2.0, 3.0], "each of the 2 ambiguities"), (np.eye(2), 1.0, "each of the 2 ambiguities"), (np.ones((2, 2)), [1, 2], "singular")],
)
def test_integers_that_do_not_fit_are_explained(Q_a, a_fix, message):
    with pytest.raises(ValueError, match=message):
        given_integers(FloatSolution(np.zeros(2), np.ones(3), Q_a, np.eye(3), np.zeros((3, 2))), a_fix)


def test_lists_do_as_well_as_arrays():
    free = FloatSolution([7.2], [3.0], [[0.2525]], [[0.01]], [[-0.05]])
    assert np.allclose(given_integers(free, [7])[0], 3.0396, rtol=0, atol=1e-4)
    assert repr(free) == "FloatSolution: 1 of 1 ambiguities, 1 real unknowns"


def test_a_baseline_of_zero_has_no_direction_for_a_length():
    free = FloatSolution(np.zeros(1), np.zeros(2), np.eye(1), np.eye(2), np.zeros((2, 1)))
    with pytest.raises(ValueError, match="no direction"):
        use_length(free, 1.0, 0.1)


def test_a_measurement_that_is_missing_spoils_its_own_epoch_only():
    y = np.array([[1.0, 2.0], [np.nan, 2.0]])
    found = solve_float(y, [[1.0], [0.0]], [[1.0], [1.0]], np.eye(2))
    assert np.isfinite(found.a_hat[0]).all()
    assert np.isnan(found.a_hat[1]).all()


@pytest.mark.parametrize(
    ("y", "A", "B", "Q_y", "message"),
    [
        ([1.0, 2.0], [[1.0]], [[1.0], [1.0]], np.eye(2), "A must have one row"),
        ([1.0, 2.0], [[1.0], [0.0]], [[1.0], [1.0]], np.ones((2, 2)), "Q_y is not positive definite"),
        ([1.0, 2.0], [[1.0], [0.0]], [[1.0], [1.0]], [[1.0, 0.5], [0.4, 1.0]], "Q_y is not symmetric"),
        ([1.0, 2.0], [[np.nan], [0.0]], [[1.0], [1.0]], np.eye(2), "A, B and Q_y must be finite"),
        ([1.0, 2.0], [[0.0], [0.0]], [[1.0], [1.0]], np.eye(2), "cannot tell all unknowns apart"),
        ([1.0, 2.0], [[1.0], [1.0]], [[1.0], [1.0]], np.eye(2), "cannot tell all unknowns apart"),
        ([1.0, 2.0], [[1.0], [1.0]], [[1.0], [1.0]], np.eye(2)[:, :1], "Q_y must have shape"),
    ],
)
def test_bad_models_are_explained(y, A, B, Q_y, message):
    with pytest.raises(ValueError, match=message):
        solve_float(y, A, B, Q_y)
