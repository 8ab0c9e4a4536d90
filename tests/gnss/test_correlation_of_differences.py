"""The covariance of double differences: its pattern, a second route by loops, and what a change of reference does to it."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gnsslab.gnss.correlation import double_difference_covariance, single_difference_covariance, without_correlation
from gnsslab.gnss.differences import difference_operator

SIGMAS = st.lists(st.floats(1e-8, 10.0), min_size=2, max_size=12)


@pytest.mark.parametrize("m", [2, 3, 8, 40])
def test_equal_sigmas_give_the_unit_matrix_plus_ones(m):
    """D D' = I + 1 1', so that Q_y = 2 sigma^2 (I + 1 1'): 4 on the diagonal, 2 beside it."""
    D = difference_operator(m, m // 2)
    pattern = np.eye(m - 1) + np.ones((m - 1, m - 1))
    np.testing.assert_array_equal(D @ D.T, pattern)
    np.testing.assert_allclose(double_difference_covariance(np.full(m, 0.003), m // 2), 2 * 0.003**2 * pattern, rtol=1e-12)


@given(SIGMAS, st.data())
def test_covariance_from_loops(sigmas, data):
    """Two differences share the reference's two readings, a difference with itself also its own two."""
    reference = data.draw(st.integers(0, len(sigmas) - 1))
    others = [k for k in range(len(sigmas)) if k != reference]
    by_loops = [[2 * sigmas[reference] ** 2 + (2 * sigmas[i] ** 2 if i == j else 0.0) for j in others] for i in others]
    np.testing.assert_allclose(double_difference_covariance(np.array(sigmas), reference), by_loops, rtol=1e-12, atol=1e-30)


@given(SIGMAS)
def test_change_of_reference_is_a_change_of_variables(sigmas):
    """Differences against another reference are T times those against the first: T Q T' is their covariance."""
    m = len(sigmas)
    D = difference_operator(m, 0)
    T = difference_operator(m, m - 1) @ np.linalg.pinv(D)
    np.testing.assert_allclose(
        T @ double_difference_covariance(np.array(sigmas), 0) @ T.T, double_difference_covariance(np.array(sigmas), m - 1), rtol=1e-9, atol=1e-12
    )


def test_drawn_noise_shows_the_pattern(rng):
    """Each entry of a sample covariance of N normal draws has variance (Q_ij^2 + Q_ii Q_jj) / (N - 1); 4.5 sigma on each of 25."""
    sigma, N = np.array([1.0, 2.0, 0.5, 1.5, 3.0, 1.0]), 20_000
    noise = rng.standard_normal((N, 2, 6)) * sigma  # (epoch, receiver, satellite)
    sampled = np.cov((noise[:, 1] - noise[:, 0]) @ difference_operator(6, 2).T, rowvar=False)
    Q = double_difference_covariance(sigma, 2)
    assert (np.abs(sampled - Q) < 4.5 * np.sqrt((Q**2 + np.outer(np.diag(Q), np.diag(Q))) / (N - 1))).all()


def test_without_correlation_keeps_the_variances_alone():
    Q = double_difference_covariance(np.array([1.0, 2.0, 3.0]), 0)
    np.testing.assert_array_equal(without_correlation(Q), [[10.0, 0.0], [0.0, 20.0]])
    assert np.trace(single_difference_covariance([1.0, 2.0])) == 10.0


def test_a_reference_that_is_not_there_is_refused():
    with pytest.raises(ValueError, match="reference 3 is not one of the 3 measurements"):
        double_difference_covariance(np.ones(3), 3)
