"""Outlier or step: the filter against batch least squares, and what it makes of outliers and steps of all sizes."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gnsslab.core import step_test
from gnsslab.core.jit import kernel_input, matrix, vector
from gnsslab.core.level_filter import P_RR, P_UU, P_XX, STATE_SIZE
from gnsslab.core.recent_mean import covariance, quick_weights, variances_of_mean

NEVER = 1e9
RULES = {
    "clip": 3.0, "outlier": 4.5, "lost": 12.0, "width": 4.0, "threshold": 12.0, "pretest": 8.0, "story": 3.0, "sure_story": 9.0,
    "settling": 60.0, "fewest": 3.0,
}  # fmt: skip


def follow(z, noise, prior=(4.0, 0.0, 0.0), dt=None, window=16, **rules):
    """Return level, sigma (T, 3), flag and start (T,) of positions z (T, 3) with one noise row for all axes."""
    T = len(z)
    state = matrix(3, STATE_SIZE)
    for axis in range(3):
        state[axis][P_XX], state[axis][P_RR], state[axis][P_UU] = prior
    starts = vector(window)
    for c in range(window):
        starts[c] = -1.0
    effects, saved = matrix(window, 3 * step_test.EFFECT_SIZE), matrix(window, 3 * STATE_SIZE)
    memory = state, effects, saved, starts, matrix(T, 3), vector(T), vector(2)
    Q = covariance(*noise[:3])
    h = quick_weights(Q)
    weights, variances = (kernel_input(np.tile(each, (3, 1))) for each in (h, variances_of_mean(h, Q)))
    out = *(matrix(T, 3) for _ in range(6)), vector(T), vector(T)
    dt = np.ones(T) if dt is None else dt
    rules = tuple(float(value) for value in (RULES | rules).values())
    step_test.follow(kernel_input(z), kernel_input(dt), kernel_input(np.tile(noise, (3, 1))), weights, variances, rules, memory, 0, T, out)
    level, sigma, *_, flag, start = (np.asarray(each) for each in out)
    return level, sigma, flag.astype(int), start.astype(int)


def test_level_is_that_of_batch_least_squares(rng):
    """Level and rate with a prior, coloured and white noise: one generalised least-squares problem, solved at once."""
    T, (w, c, tau), (P_x, P_r) = 60, (1.0, 2.0, 5.0), (9.0, 0.04)
    t = np.cumsum(rng.integers(1, 4, T)).astype(float)  # irregular
    z = rng.standard_normal((T, 3))
    dt = np.diff(t, prepend=0.0)
    level, sigma, *_ = follow(z, [w, c, tau, 0.0], (P_x, P_r, c), dt, clip=NEVER, threshold=NEVER, pretest=NEVER)
    Q = w * np.eye(T) + c * np.exp(-np.abs(t[:, None] - t) / tau)
    A = np.column_stack([np.ones(T), t])  # the prior is of level and rate at time 0
    N = A.T @ np.linalg.solve(Q, A) + np.diag([1 / P_x, 1 / P_r])
    x = np.linalg.solve(N, A.T @ np.linalg.solve(Q, z))
    assert level[-1] == pytest.approx(x[0] + t[-1] * x[1], abs=1e-9)
    assert sigma[-1] == pytest.approx([np.sqrt([1, t[-1]] @ np.linalg.solve(N, [1, t[-1]]))] * 3)


@settings(max_examples=25, deadline=None)
@given(size=st.floats(5.0, 1e6), at=st.integers(100, 180), direction=st.integers(0, 2))
def test_one_gross_error_is_no_step_whatever_its_size(size, at, direction):
    z = np.random.default_rng(5).standard_normal((200, 3))
    noise = [1.0, 1e-6, 4.0, 1e-9]
    quiet, *_ = follow(z, noise)
    z[at, direction] += size
    level, _, flag, _ = follow(z, noise)
    assert (flag != step_test.STEP).all()
    assert np.abs(level - quiet).max() < 0.3  # sigma of a solution: 3 sigma at most come in, to be shared with some hundred epochs


@settings(max_examples=25, deadline=None)
@given(size=st.floats(7.0, 1e6), at=st.integers(100, 180))
def test_a_large_step_is_found_at_its_third_epoch_and_dated(size, at):
    z = np.random.default_rng(5).standard_normal((200, 3))
    z[at:, 0] += size
    level, _, flag, start = follow(z, [1.0, 1e-6, 4.0, 1e-9])
    found = np.flatnonzero(flag == step_test.STEP)
    assert found.tolist()[:1] == [at + 2]
    assert abs(start[at + 2] - at) <= 1
    assert abs(level[-1, 0] - size) < 2.0


def test_missing_epochs_are_gaps_and_change_nothing_else(rng):
    z = rng.standard_normal((120, 3))
    spread = np.full((240, 3), np.nan)
    spread[::2] = z
    dt = np.full(240, 0.5)
    dt[0] = 1.0
    whole, _, flag, _ = follow(z, [1.0, 0.5, 5.0, 1e-9])
    thin, _, flag_thin, _ = follow(spread, [1.0, 0.5, 5.0, 1e-9], dt=dt)
    assert thin[::2] == pytest.approx(whole, abs=1e-9)
    assert (flag_thin[1::2] == step_test.GAP).all()
    assert (flag_thin[::2] == flag).all()
