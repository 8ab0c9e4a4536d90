"""Kalman filter steps against the dense formulas of textbooks, written with inverses on purpose; their tests against the distributions."""

import json
import os
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import chi2

from gnsslab.core import kalman

SEEDS = st.integers(0, 2**32 - 1)
SIZES = st.integers(1, 8)
UNITS = st.sampled_from([1e-6, 1e-3, 1.0, 1e3])  # of all states and measurements: mm or km must not matter
ROUNDING = 1e-9  # relative; the matrices here have condition numbers up to some hundreds


def positive_definite(rng, n):
    """Return a covariance (n, n), far from singular."""
    A = rng.standard_normal((n, n))
    return A @ A.T / n + 0.1 * np.eye(n)


def innovate(H, P, R, z):
    """Return C and W = C^-1 [H P, z] through the kernels under test."""
    C, W = H @ P @ H.T + R, np.column_stack([H @ P, z])
    kalman.factor_cholesky(C)
    kalman.solve_lower(C, W)
    return C, W


@settings(deadline=None)
@given(seed=SEEDS, n=SIZES, p=SIZES, unit=UNITS)
def test_predict_is_the_dense_formula_with_the_identity_for_all_other_states(seed, n, p, unit):
    rng, p = np.random.default_rng(seed), min(n, p)
    x, P = unit * rng.standard_normal(n), unit**2 * positive_definite(rng, n)
    F, Q, offset = rng.standard_normal((p, p)), unit**2 * positive_definite(rng, p), unit * rng.standard_normal(p)
    F_all, Q_all = np.eye(n), np.zeros((n, n))
    F_all[:p, :p], Q_all[:p, :p] = F, Q
    x_dense, P_dense = F_all @ x + np.pad(offset, (0, n - p)), F_all @ P @ F_all.T + Q_all
    kalman.predict(x, P, F, Q, offset)
    np.testing.assert_allclose(x, x_dense, rtol=0, atol=ROUNDING * unit)
    np.testing.assert_allclose(P, P_dense, rtol=0, atol=ROUNDING * unit**2)


def test_a_transition_of_zero_forgets_the_states_and_their_correlations():
    x, P = np.arange(4.0), positive_definite(np.random.default_rng(1), 4)
    kept = P[2:, 2:].copy()
    kalman.predict(x, P, np.zeros((2, 2)), 9.0 * np.eye(2), np.array([7.0, 8.0]))
    assert x.tolist() == [7.0, 8.0, 2.0, 3.0]
    assert P[:2, :2].tolist() == [[9.0, 0.0], [0.0, 9.0]]
    assert not P[:2, 2:].any()
    assert not P[2:, :2].any()
    assert (P[2:, 2:] == kept).all()


@settings(deadline=None)
@given(seed=SEEDS, n=SIZES, k=SIZES, unit=UNITS)
def test_update_is_the_gain_formula_with_josephs_covariance(seed, n, k, unit):
    rng = np.random.default_rng(seed)
    x, P = unit * rng.standard_normal(n), unit**2 * positive_definite(rng, n)
    H, R, z = rng.standard_normal((k, n)), unit**2 * positive_definite(rng, k), unit * rng.standard_normal(k)
    K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
    x_dense, rest = x + K @ z, np.eye(n) - K @ H
    P_dense = rest @ P @ rest.T + K @ R @ K.T
    _, W = innovate(H, P, R, z)
    kalman.update(x, P, W)
    np.testing.assert_allclose(x, x_dense, rtol=0, atol=ROUNDING * unit)
    np.testing.assert_allclose(P, P_dense, rtol=0, atol=ROUNDING * unit**2)
    assert (P == P.T).all()


@settings(deadline=None)
@given(seed=SEEDS, k=SIZES)
def test_whitened_innovation_has_the_squared_norm_of_the_innovation_in_its_covariance(seed, k):
    rng = np.random.default_rng(seed)
    H, P, R, z = rng.standard_normal((k, 3)), positive_definite(rng, 3), positive_definite(rng, k), rng.standard_normal(k)
    C, W = innovate(H, P, R, z)
    S = H @ P @ H.T + R
    assert W[:, -1] @ W[:, -1] == pytest.approx(z @ np.linalg.inv(S) @ z, rel=ROUNDING)
    np.testing.assert_allclose(np.tril(C) @ np.tril(C).T, S, rtol=ROUNDING, atol=ROUNDING)


@settings(deadline=None)
@given(seed=SEEDS, k=SIZES, m=SIZES)
def test_worst_outlier_is_the_largest_w_test_computed_with_the_inverse(seed, k, m):
    rng = np.random.default_rng(seed)
    S, z, A = positive_definite(rng, k), rng.standard_normal(k), rng.standard_normal((k, m))
    S_inv = np.linalg.inv(S)
    w = [abs(a @ S_inv @ z) / np.sqrt(a @ S_inv @ a) for a in A.T]
    C, W = innovate(np.zeros((k, 1)), np.eye(1), S, z)
    worst, sigmas = kalman.worst_outlier(C, W, A.copy())
    assert sigmas == pytest.approx(max(w), rel=ROUNDING)
    assert w[worst] == pytest.approx(max(w), rel=ROUNDING)


def test_worst_outlier_names_the_measurement_that_was_spoilt(rng):
    S, C = positive_definite(rng, 6), positive_definite(rng, 6)
    C[:] = S
    kalman.factor_cholesky(C)
    for spoilt in range(6):
        z = np.linalg.cholesky(S) @ rng.standard_normal(6)
        z[spoilt] += 40 * np.sqrt(S[spoilt, spoilt])
        W = z[:, None].copy()
        kalman.solve_lower(C, W)
        assert kalman.worst_outlier(C, W, np.eye(6))[0] == spoilt


def test_an_outlier_that_touches_no_measurement_is_never_the_worst():
    assert kalman.worst_outlier(np.eye(2), np.array([[3.0], [0.0]]), np.array([[0.0, 1.0], [0.0, 0.0]])) == (1, 3.0)
    assert kalman.worst_outlier(np.eye(1), np.array([[3.0]]), np.zeros((1, 2)))[0] == -1


@pytest.mark.parametrize("k", [1, 2, 3, 6, 10, 25, 60])
def test_one_good_epoch_in_a_thousand_fails_the_overall_test(k):
    quantile, allowed = chi2.ppf(0.999, k), 0.035 if k < 6 else 0.01  # of the quantile: the error of Wilson and Hilferty
    for share, passes in ((1 - allowed, True), (1 + allowed, False)):
        w = np.full((k, 1), np.sqrt(share * quantile / k))
        assert kalman.is_consistent(w) is passes


def test_without_measurements_nothing_is_inconsistent():
    assert kalman.is_consistent(np.zeros((0, 1)))


PROGRAM = """
import json
import numpy as np
from gnsslab.core import jit, kalman
rng, n, k = np.random.default_rng(3), 6, 4
A, B = rng.standard_normal((2, n, n))
x, P = rng.standard_normal(n), A @ A.T + np.eye(n)
x, P = jit.kernel_input(x), jit.kernel_input(P)
kalman.predict(x, P, *(jit.kernel_input(a) for a in (rng.standard_normal((3, 3)), np.eye(3), rng.standard_normal(3))))
C, W = jit.kernel_input(B[:k] @ B[:k].T + np.eye(k)), jit.kernel_input(rng.standard_normal((k, n + 1)))
kalman.factor_cholesky(C)
kalman.solve_lower(C, W)
kalman.update(x, P, W)
worst = kalman.worst_outlier(C, W, jit.kernel_input(np.eye(k)))
print(json.dumps([jit.COMPILED, np.asarray(x).tolist(), np.asarray(P).tolist(), list(worst), bool(kalman.is_consistent(W))]))
"""


def answers(**environment):
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path), **environment}
    done = subprocess.run([sys.executable, "-W", "error", "-c", PROGRAM], env=environment, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_compiled_and_plain_kernels_agree_to_the_last_bit():
    pytest.importorskip("numba")
    compiled, plain = answers(GNSSLAB_NO_NUMBA="0"), answers(GNSSLAB_NO_NUMBA="1")
    assert (compiled[0], plain[0]) == (True, False)
    assert compiled[1:] == plain[1:]
