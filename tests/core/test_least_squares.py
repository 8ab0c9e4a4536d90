"""Stacked least squares against numpy's solver, against the normal equations by hand, and against its own statistics."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from gnsslab.core.least_squares import least_squares, screened_least_squares, worst_rows

ROUNDING = 1e-9


def random_problem(rng, T=6, k=9, p=4):
    A, y = rng.normal(size=(T, k, p)), rng.normal(size=(T, k))
    sigma, used = rng.uniform(0.1, 10.0, size=(T, k)), rng.uniform(size=(T, k)) < 0.8
    for array in (A, y, sigma, used):
        array.flags.writeable = False
    return A, y, sigma, used


@given(seed=st.integers(0, 2**32 - 1), k=st.integers(5, 12), p=st.integers(1, 5))
def test_every_problem_is_solved_as_numpy_solves_it_alone(seed, k, p):
    A, y, sigma, used = random_problem(np.random.default_rng(seed), k=k, p=p)
    fit = least_squares(A, y, sigma, used)
    for t in np.flatnonzero(fit.is_solved):
        rows = used[t]
        A_w, y_w = A[t, rows] / sigma[t, rows, None], y[t, rows] / sigma[t, rows]
        x, *_ = np.linalg.lstsq(A_w, y_w, rcond=None)
        Q = np.linalg.pinv(A_w) @ np.linalg.pinv(A_w).T
        condition = np.linalg.cond(A_w) ** 2 * 1e-15 + ROUNDING
        np.testing.assert_allclose(fit.x[t], x, rtol=condition, atol=condition * np.abs(x).max())
        np.testing.assert_allclose(fit.Q[t], Q, rtol=condition, atol=condition * np.abs(Q).max())
    assert np.array_equal(fit.is_solved, used.sum(axis=1) >= p)


def test_residuals_are_normalised_by_the_textbook_covariance(rng):
    A, y, sigma, _ = random_problem(rng, T=1)
    fit = least_squares(A, y, sigma)
    Q_y = np.diag(sigma[0] ** 2)
    Q_v = Q_y - A[0] @ fit.Q[0] @ A[0].T
    np.testing.assert_allclose(fit.residual[0], y[0] - A[0] @ fit.x[0], atol=ROUNDING)
    np.testing.assert_allclose(fit.normalised[0], fit.residual[0] / np.sqrt(np.diag(Q_v)), rtol=1e-7)
    np.testing.assert_allclose(fit.chi_square[0], fit.residual[0] @ np.linalg.solve(Q_y, fit.residual[0]), rtol=1e-9)


def test_covariance_and_chi_square_are_what_noise_makes_of_them(rng):
    N, p = 20_000, 3
    A, truth = rng.normal(size=(7, p)), np.array([1.0, -2.0, 0.5])
    sigma = rng.uniform(0.5, 3.0, size=7)
    fit = least_squares(A, A @ truth + sigma * rng.normal(size=(N, 7)), sigma)
    error = fit.x - truth
    squared = np.einsum("ni,nij,nj->n", error, np.linalg.inv(fit.Q), error)
    four_sigma = 4 * np.sqrt(2 * p / N)  # of the mean of N chi-squares with p degrees of freedom
    assert abs(squared.mean() - p) < four_sigma
    assert stats.kstest(fit.chi_square, stats.chi2(7 - p).cdf).pvalue > 1e-4
    assert stats.kstest(fit.normalised[:, 2], stats.norm.cdf).pvalue > 1e-4


def test_a_false_covariance_would_be_noticed(rng):
    N = 20_000
    A, sigma = rng.normal(size=(7, 3)), np.ones(7)
    fit = least_squares(A, 1.05 * rng.normal(size=(N, 7)), sigma)
    assert stats.kstest(fit.chi_square, stats.chi2(4).cdf).pvalue < 1e-4


def test_scale_of_unknowns_does_not_matter(rng):
    A, y, sigma, _ = random_problem(rng)
    scale = np.array([1e-9, 1.0, 1e6, 1e12])
    plain, scaled = least_squares(A, y, sigma), least_squares(A * scale, y, sigma)
    assert scaled.is_solved.all()
    np.testing.assert_allclose(scaled.x * scale, plain.x, rtol=1e-8)


def test_unknowns_without_rows_are_left_out(rng):
    A, y, sigma, _ = random_problem(rng)
    A = A.copy()
    A[:3, :, 1] = 0.0
    fit = least_squares(A, y, sigma)
    assert np.isnan(fit.x[:3, 1]).all()
    assert np.isnan(fit.Q[:3, 1]).all()
    np.testing.assert_allclose(fit.x[:3][:, [0, 2, 3]], least_squares(A[:3][:, :, [0, 2, 3]], y[:3], sigma[:3]).x, rtol=1e-9)
    assert (fit.redundancy == [6, 6, 6, 5, 5, 5]).all()


def test_what_cannot_be_solved_is_flagged_and_leaves_the_others_alone(rng):
    A, y, sigma, _ = random_problem(rng)
    A, y, used = A.copy(), y.copy(), np.ones(y.shape, dtype=bool)
    A[0, :, 3] = 2 * A[0, :, 2]  # two unknowns alike
    used[1, 3:] = False  # three rows for four unknowns
    used[2] = False
    y[3, 0] = np.nan  # one row lost
    fit = least_squares(A, y, sigma, used)
    assert fit.is_solved.tolist() == [False, False, False, True, True, True]
    assert np.isnan(fit.x[:3]).all()
    assert fit.redundancy[1] == -1
    assert not fit.used[3, 0]
    np.testing.assert_allclose(fit.x[3], least_squares(A[3, 1:], y[3, 1:], sigma[3, 1:]).x, rtol=1e-9)


def test_no_rows_at_all():
    fit = screened_least_squares(np.zeros((2, 0, 4)), np.zeros((2, 0)), np.zeros((2, 0)))
    assert not fit.is_solved.any()
    assert fit.x.shape == (2, 4)


def test_snooping_finds_gross_errors_and_nothing_else(rng):
    N, k = 2_000, 10
    A, sigma = rng.normal(size=(N, k, 3)), np.ones(k)
    y = rng.normal(size=(N, k))
    clean = screened_least_squares(A, y, sigma)
    false_alarms, expected = int((~clean.used).sum()), N * k * 2 * stats.norm.sf(4)
    assert false_alarms <= expected + 4 * np.sqrt(expected) + 1
    hit = rng.integers(k, size=N)
    spoiled = y.copy()
    spoiled[np.arange(N), hit] += 1e4
    fit = screened_least_squares(A, spoiled, sigma)
    redundancy_number = (least_squares(A, y, sigma).normalised[np.arange(N), hit] != 0) & (clean.used.sum(axis=1) == k)
    assert not fit.used[np.arange(N), hit][redundancy_number].any()


def test_with_one_row_to_spare_an_error_shows_but_not_where():
    fit = least_squares([[1.0], [1.0]], [0.0, 100.0], [1.0, 1.0])
    assert abs(fit.normalised[0]) == pytest.approx(abs(fit.normalised[1]))
    assert fit.chi_square == pytest.approx(5000.0)
    assert not worst_rows(fit, 4.0).any()


def test_a_sigma_of_zero_is_refused():
    with pytest.raises(ValueError, match="above zero"):
        least_squares([[1.0]], [1.0], [0.0])
