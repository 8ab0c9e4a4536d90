"""Epochs solved alone: against one big least-squares system, and what the reference changes or does not."""

from dataclasses import replace

import numpy as np
import pytest

from gnsslab.core.integers import integer_least_squares
from gnsslab.gnss.correlation import double_difference_covariance, without_correlation
from gnsslab.gnss.differences import difference_operator
from gnsslab.labs.single_epochs import SingleDifferences, sampled_covariance, solve_each_epoch

T, M, LAMBDA = 400, 8, 0.1903


def ignoring(sigma, reference):
    """Return the covariance without its off-diagonal part."""
    return without_correlation(double_difference_covariance(sigma, reference))


@pytest.fixture
def data(rng):
    """Single differences of eight satellites spread over the sky, two of them noisier."""
    u = rng.standard_normal((M, 3))
    u[:, 2] = np.abs(u[:, 2]) + 0.3
    sigma_phase = 0.003 * np.array([1, 1, 2, 1, 1, 3, 1, 1.0])
    integers = rng.integers(-50, 50, M)
    noise = rng.standard_normal((2, T, M)) * np.sqrt(2)  # a difference of two readings
    return SingleDifferences(
        code=100 * sigma_phase * noise[0] + 12.0,  # a receiver's clock
        phase=sigma_phase * noise[1] + LAMBDA * integers + 12.0,
        design=-(u / np.linalg.norm(u, axis=1, keepdims=True))[np.newaxis],
        sigma_code=100 * sigma_phase,
        sigma_phase=sigma_phase,
        integers=integers,
        wavelength=LAMBDA,
    )


@pytest.mark.parametrize("believed", [double_difference_covariance, ignoring])
def test_against_the_whole_system_solved_at_once(data, believed):
    """y = A a + B b + e with codes and carriers stacked, all unknowns at once by whitened least squares, epoch by epoch."""
    solved = solve_each_epoch(data, 2, believed)
    D, n = difference_operator(M, 2), M - 1
    B = D @ data.design[0]
    A = np.block([[np.zeros((n, n)), B], [LAMBDA * np.eye(n), B]])
    Q_y = np.block([[believed(data.sigma_code, 2), np.zeros((n, n))], [np.zeros((n, n)), believed(data.sigma_phase, 2)]])
    W = np.linalg.inv(np.linalg.cholesky(Q_y))
    Q = np.linalg.inv(A.T @ W.T @ W @ A)
    for t in (0, 17, T - 1):
        y = np.concatenate([D @ data.code[t], D @ data.phase[t]])
        a_hat = np.linalg.lstsq(W @ A, W @ y)[0][:n]
        found = integer_least_squares(a_hat, Q[:n, :n])
        assert found.ratio == pytest.approx(solved.ratio[t], rel=1e-6)
        assert (found.best == D @ data.integers).all() == solved.is_right[t]
        fixed = np.linalg.lstsq(W[n:, n:] @ B, W[n:, n:] @ (y[n:] - LAMBDA * (D @ data.integers)))[0]
        np.testing.assert_allclose(solved.baseline[t], fixed, atol=1e-9)


def test_reference_does_not_matter_where_the_correlation_is_respected(data):
    solved = [solve_each_epoch(data, reference, double_difference_covariance) for reference in range(M)]
    for other in solved[1:]:
        np.testing.assert_allclose(other.baseline, solved[0].baseline, atol=1e-9)
        np.testing.assert_allclose(other.ratio, solved[0].ratio, rtol=1e-6)
        np.testing.assert_allclose(other.Q_baseline, solved[0].Q_baseline, rtol=1e-9)
        assert other.promised == pytest.approx(solved[0].promised, rel=1e-6)


def test_reference_matters_where_it_is_ignored(data):
    one, other = (solve_each_epoch(data, reference, ignoring).baseline for reference in (0, 5))
    assert np.sqrt(np.mean(np.sum((one - other) ** 2, axis=1))) > 0.002  # a carrier's noise


def test_claims_hold_where_the_correlation_is_respected(data):
    """A variance of T draws is good to sqrt(2 / T); three axes at 4 sigma. Shares of right integers are at least as promised."""
    solved = solve_each_epoch(data, 0, double_difference_covariance)
    np.testing.assert_allclose(solved.baseline.var(axis=0), np.diag(solved.Q_baseline), rtol=4 * np.sqrt(2 / T))
    assert solved.is_right.mean() > solved.promised - 4 * np.sqrt(solved.promised * (1 - solved.promised) / T)


def test_best_linear_estimate_scatters_least(data):
    """No linear unbiased estimate beats weighted least squares (Gauss-Markov): the claim itself, without drawing."""
    B = difference_operator(M, 5) @ data.design[0]
    Q = double_difference_covariance(data.sigma_phase, 5)
    W = np.linalg.inv(without_correlation(Q))
    gain = np.linalg.solve(B.T @ W @ B, B.T @ W)
    real = gain @ Q @ gain.T  # how the estimate that ignores the correlation really scatters
    claimed = solve_each_epoch(data, 5, double_difference_covariance).Q_baseline
    assert (np.linalg.eigvalsh(real - claimed) > -1e-12).all()
    assert np.trace(real) > 1.05 * np.trace(claimed)


def test_common_factor_changes_sigmas_but_no_ratio(data):
    once, twice = (solve_each_epoch(data, 0, lambda s, r, k=k: k * double_difference_covariance(s, r)) for k in (1, 2))
    np.testing.assert_allclose(twice.ratio, once.ratio, rtol=1e-6)
    np.testing.assert_allclose(twice.Q_baseline, 2 * once.Q_baseline, rtol=1e-9)


def test_designs_that_change_are_solved_epoch_by_epoch(data):
    many = replace(data, design=np.repeat(data.design, T, axis=0))
    one, other = (solve_each_epoch(each, 1, double_difference_covariance) for each in (data, many))
    np.testing.assert_allclose(other.ratio, one.ratio, rtol=1e-6)
    np.testing.assert_allclose(other.baseline, one.baseline, atol=1e-10)


def test_sampled_covariance_is_the_formula_within_its_own_scatter(data):
    Q = double_difference_covariance(data.sigma_phase, 3)
    spread = np.sqrt((Q**2 + np.outer(np.diag(Q), np.diag(Q))) / (T - 1))
    assert (np.abs(sampled_covariance(data, 3) - Q) < 4.5 * spread).all()
