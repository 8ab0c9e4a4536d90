"""The known length as a row: each way against a second route of its own, and what it does to a baseline known well or badly."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import least_squares

from gnsslab.core.jit import kernel_input
from gnsslab.systems.dual_antenna import with_known_length
from gnsslab.systems.length_row import LengthUse, RowState, update_by_length

LENGTH, SIGMA = 1.167, 0.005  # [m]
MM = 1e-3
ROWS = (LengthUse.GUARDED_ROW, LengthUse.ROW, LengthUse.ITERATED_ROW, LengthUse.SECOND_ORDER_ROW)


def state(scale, seed):
    """Return a baseline drawn about one of the length, with two more states, and its covariance of about scale^2 [m^2]."""
    rng = np.random.default_rng(seed)
    truth = rng.standard_normal(3)
    truth *= LENGTH / np.linalg.norm(truth)
    A = np.vstack([rng.standard_normal((3, 5)), rng.standard_normal((2, 5))]) * scale / 5**0.5
    P = A @ A.T + (1 * MM) ** 2 * np.eye(5)
    return np.concatenate([truth, rng.standard_normal(2)]) + np.linalg.cholesky(P) @ rng.standard_normal(5), P


def updated(x, P, use, length=LENGTH, sigma=SIGMA):
    """Return x, P and what the row says of itself; the arguments stay."""
    x, P = kernel_input(np.array(x)), kernel_input(np.array(P))
    said = update_by_length(x, P, length, sigma, float(use))
    return np.asarray(x), np.asarray(P), said


@pytest.mark.parametrize("use", [LengthUse.NOWHERE, LengthUse.SEARCH])
def test_without_a_row_nothing_changes(use):
    x, P = state(0.1, 1)
    x_new, P_new, (row, innovation, sigma) = updated(x, P, use)
    assert (x_new == x).all()
    assert (P_new == P).all()
    assert row == RowState.NONE
    assert np.isnan([innovation, sigma]).all()


@settings(max_examples=60, deadline=None)
@given(st.floats(0.01, 3.0), st.integers(0, 2**32 - 1))
def test_the_row_is_the_one_written_for_single_epochs(scale, seed):
    """`with_known_length` has it in numpy's arrays and with the guard; the guarded row drops where that leaves the baseline as it is."""
    x, P = state(scale, seed)
    b, Q = with_known_length(x[:3], P[:3, :3], LENGTH, SIGMA)
    x_new, P_new, (row, *_) = updated(x, P, LengthUse.GUARDED_ROW)
    assert (row == RowState.DROPPED) == (b == x[:3]).all() == (np.trace(P[:3, :3]) / 3 > (0.1 * LENGTH) ** 2)
    np.testing.assert_allclose(x_new[:3], b, rtol=0, atol=1e-9)
    np.testing.assert_allclose(P_new[:3, :3], Q, rtol=0, atol=1e-9 * np.trace(P))
    if row == RowState.USED:
        for one, other in zip(updated(x, P, LengthUse.ROW)[:2], (x_new, P_new), strict=True):
            np.testing.assert_array_equal(one, other)


@settings(max_examples=60, deadline=None)
@given(st.floats(0.01, 30.0), st.integers(0, 2**32 - 1))
def test_the_iterated_row_ends_at_the_most_likely_baseline(scale, seed):
    """A general minimiser of all states in units of P, started there, finds nothing lower; from the float one it may end in another dip."""
    x, P = state(scale, seed)
    C = np.linalg.cholesky(P)
    x_new, *_ = updated(x, P, LengthUse.ITERATED_ROW)

    def residuals(w):
        return np.append(w, (np.linalg.norm((x + C @ w)[:3]) - LENGTH) / SIGMA)

    here = np.linalg.solve(C, x_new - x)
    better = least_squares(residuals, here, xtol=1e-15, ftol=1e-15, gtol=1e-15)
    cost, least = (residuals(w) @ residuals(w) for w in (here, better.x))
    assert cost <= least + 1e-6 * (1 + least)
    far = least_squares(residuals, np.zeros(5))
    assert cost <= residuals(far.x) @ residuals(far.x) * (1 + 1e-6) + 1e-6


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_iterating_by_hand_ends_there_too_where_the_baseline_is_known(seed):
    x, P = state(0.02, seed)
    b = x
    for _ in range(30):
        h = np.append(b[:3] / np.linalg.norm(b[:3]), [0.0, 0.0])
        gain = P @ h / (h @ P @ h + SIGMA**2)
        b = x + gain * (LENGTH - np.linalg.norm(b[:3]) - h @ (x - b))
    x_new, P_new, _ = updated(x, P, LengthUse.ITERATED_ROW)
    np.testing.assert_allclose(x_new, b, rtol=0, atol=1e-7)
    np.testing.assert_allclose(P_new, P - np.outer(gain, h @ P), rtol=0, atol=1e-9)


@pytest.mark.parametrize("seed", range(6))
def test_the_second_order_row_knows_the_mean_and_scatter_of_a_drawn_length(seed, rng):
    """N draws: the mean is that of |b| but for terms of fourth order, the variance that of h'e + (e'e - (h'e)^2) / 2 |b|; 4 sigma of each."""
    x, P = state(0.1, seed)
    N, norm = 400_000, np.linalg.norm(x[:3])
    e = rng.multivariate_normal(np.zeros(3), P[:3, :3], N)
    along = e @ x[:3] / norm
    curved = np.var(along + (np.vecdot(e, e) - along**2) / (2 * norm))
    *_, (_, innovation, sigma) = updated(x, P, LengthUse.SECOND_ORDER_ROW)
    *_, (_, plain, plain_sigma) = updated(x, P, LengthUse.ROW)
    fourth_order = np.trace(P[:3, :3]) ** 2 / norm**3
    assert innovation == pytest.approx(LENGTH - np.mean(np.linalg.norm(x[:3] + e, axis=1)), abs=4 * np.sqrt(curved / N) + fourth_order)
    assert plain - innovation > 4 * fourth_order, "else the tolerance would swallow the bias"
    assert sigma**2 - SIGMA**2 == pytest.approx(curved, rel=4 * np.sqrt(2 / N))
    assert sigma > plain_sigma


@pytest.mark.parametrize("use", ROWS)
def test_where_the_baseline_is_known_all_rows_are_one(use):
    """3 mm of sigma on 1.167 m: what curvature changes is of the order of 3 mm^2 / 1.167 m = 8 um."""
    x, P = state(3 * MM, 4)
    x_row, P_row, _ = updated(x, P, LengthUse.ROW)
    x_new, P_new, (row, *_) = updated(x, P, use)
    assert row == RowState.USED
    np.testing.assert_allclose(x_new, x_row, rtol=0, atol=0.1 * MM)
    np.testing.assert_allclose(P_new, P_row, rtol=0, atol=0.05 * np.trace(P))


@pytest.mark.parametrize("use", ROWS)
@pytest.mark.parametrize("scale", [0.01, 0.1, 1.0])
def test_turned_axes_turn_the_answer(use, scale):
    x, P = state(scale, 9)
    R = np.eye(5)
    R[:3, :3] = np.linalg.qr(np.random.default_rng(3).standard_normal((3, 3)))[0]
    (x_new, P_new, said), (x_turned, P_turned, turned) = updated(x, P, use), updated(R @ x, R @ P @ R.T, use)
    np.testing.assert_allclose(x_turned, R @ x_new, rtol=0, atol=1e-9)
    np.testing.assert_allclose(P_turned, R @ P_new @ R.T, rtol=0, atol=1e-9)
    np.testing.assert_allclose(turned, said, rtol=1e-9)


@settings(max_examples=60, deadline=None)
@given(st.sampled_from(ROWS), st.floats(0.01, 10.0), st.integers(0, 2**32 - 1))
def test_covariances_stay_symmetric_and_never_grow(use, scale, seed):
    x, P = state(scale, seed)
    _, P_new, _ = updated(x, P, use)
    assert (P_new == P_new.T).all()
    assert np.linalg.eigvalsh(P_new)[0] > -1e-12 * np.trace(P)
    assert np.linalg.eigvalsh(P - P_new)[0] > -1e-12 * np.trace(P)


def test_the_row_as_printed_says_next_to_nothing():
    """(16): with the length itself as sigma a sigma of 10 mm stays 10.00 mm, where 5 mm leave 4.47."""
    for sigma, left in ((LENGTH, 10.00 * MM), (5 * MM, 4.472 * MM)):
        _, P, _ = updated([0.0, LENGTH, 0.0], np.eye(3) * (10 * MM) ** 2, LengthUse.ROW, sigma=sigma)
        assert np.sqrt(P[1, 1]) == pytest.approx(left, abs=0.005 * MM)
