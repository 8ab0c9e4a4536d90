"""Random walk: against least squares of all epochs at once, the numbers of paper B, and what stays the same when units do not."""

import json
import os
import subprocess
import sys
import tracemalloc

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import chi2

from gnsslab.core.jit import COMPILED
from gnsslab.core.random_walk import random_walk_filter, random_walk_smoother
from gnsslab.core.robust import danish, huber, igg3, igg3_weight, tukey

SEEDS = st.integers(0, 2**32 - 1)
CM2 = 1e-4  # [m^2]
PAPER = {"q": 0.48 * CM2, "r": 9.9 * CM2, "weight": igg3(1, 2)}


def walk(rng, T, d, q, r):
    """Return z (T, d) of a random walk, with wild values and gaps."""
    z = np.cumsum(np.sqrt(q) * rng.standard_normal((T, d)), axis=0) + np.sqrt(r) * rng.standard_normal((T, d))
    z[rng.random((T, d)) < 0.1] += 20 * np.sqrt(r)
    z[rng.random((T, d)) < 0.15] = np.nan
    return z


def all_at_once(z, q, r, eta):
    """Return level and variance (T,) of one axis by least squares: prior z_0 of variance r, z_k of variance r / eta_k, steps of variance q."""
    T = len(z)
    rows = [(np.eye(T)[0], z[0], r)]
    rows += [(np.eye(T)[k], z[k], r / eta[k]) for k in range(T) if eta[k] > 0]
    rows += [(np.eye(T)[k] - np.eye(T)[k - 1], 0.0, q) for k in range(1, T)]
    A, y, variance = (np.array(part) for part in zip(*rows, strict=True))
    Q = np.linalg.inv(A.T @ (A / variance[:, None]))
    return Q @ A.T @ (y / variance), np.diag(Q)


@settings(deadline=None, max_examples=40)
@given(seed=SEEDS, T=st.integers(1, 12), ratio=st.floats(-3, 2), weight=st.sampled_from([None, igg3(1, 2), huber(1.345), tukey(4.685), danish(2)]))
def test_filter_and_smoother_are_least_squares_of_the_epochs_they_know(seed, T, ratio, weight):
    rng, r = np.random.default_rng(seed), 1.0
    q = r * 10**ratio
    z = walk(rng, T, 1, q, r)
    z[0] = 1.0  # the first epoch is measured
    filtered = random_walk_filter(z, q, r, weight)
    for k in range(T):
        level, variance = all_at_once(z[: k + 1, 0], q, r, filtered.weight[: k + 1, 0])
        assert filtered.level[k, 0] == pytest.approx(level[-1], abs=1e-8)
        assert filtered.variance[k, 0] == pytest.approx(variance[-1], rel=1e-8)
    smooth, sure = random_walk_smoother(filtered, q)
    np.testing.assert_allclose(smooth[:, 0], level, rtol=0, atol=1e-8)
    np.testing.assert_allclose(sure[:, 0], variance, rtol=1e-8)


@settings(deadline=None, max_examples=30)
@given(seed=SEEDS, unit=st.sampled_from([1e-3, 1.0, 1e2]), shift=st.floats(-1e3, 1e3))
def test_units_and_the_origin_do_not_matter(seed, unit, shift):
    z = walk(np.random.default_rng(seed), 30, 2, 0.1, 1.0)
    one, other = random_walk_filter(z, 0.1, 1.0, igg3(1, 2)), random_walk_filter(unit * (z + shift), unit**2 * 0.1, unit**2, igg3(1, 2))
    np.testing.assert_allclose(other.level, unit * (one.level + shift), rtol=0, atol=1e-8 * unit)
    np.testing.assert_allclose(other.variance, unit**2 * one.variance, rtol=1e-8)
    np.testing.assert_allclose(other.weight, one.weight, atol=1e-6)


def test_axes_and_series_of_a_stack_are_independent_with_variances_of_their_own(rng):
    z = np.stack([walk(rng, 40, 3, 0.1, 1.0) for _ in range(4)])
    q, r = np.array([0.1, 0.2, 0.0]), np.array([1.0, 2.0, 3.0])
    stack = random_walk_filter(z, q, r, huber(1.5))
    smooth = random_walk_smoother(stack, q)
    for i in range(4):
        for j in range(3):
            alone = random_walk_filter(z[i, :, j : j + 1], q[j], r[j], huber(1.5))
            for name in ("level", "variance", "innovation", "innovation_sigma", "weight"):
                np.testing.assert_array_equal(getattr(stack, name)[i, :, j], getattr(alone, name)[:, 0], err_msg=name)
            for together, single in zip(smooth, random_walk_smoother(alone, q[j]), strict=True):
                np.testing.assert_array_equal(together[i, :, j], single[:, 0])


def test_the_weight_is_that_of_the_standardised_innovation_and_zero_leaves_the_epoch_out(rng):
    z = walk(rng, 500, 3, 0.1, 1.0)
    z[0] = 0.0
    filtered = random_walk_filter(z, 0.1, 1.0, igg3(1, 2))
    measured, rejected = np.isfinite(z), filtered.weight == 0
    v = filtered.innovation / filtered.innovation_sigma
    np.testing.assert_array_equal(filtered.weight[measured], igg3_weight(v[measured], 1, 2))
    assert (rejected & measured).sum() > 50
    assert (np.isnan(filtered.innovation) == ~measured).all()
    assert (rejected | measured).all()
    passed = rejected[1:]
    assert (filtered.level[1:][passed] == filtered.level[:-1][passed]).all()
    assert (filtered.variance[1:][passed] == filtered.variance[:-1][passed] + 0.1).all()


def test_innovations_of_a_true_model_are_white_and_of_the_size_they_claim(rng):
    T, q, r = 20_000, 0.3, 2.0
    z = np.cumsum(np.sqrt(q) * rng.standard_normal((T, 3)), axis=0) + np.sqrt(r) * rng.standard_normal((T, 3))
    filtered = random_walk_filter(z, q, r)
    v = (filtered.innovation / filtered.innovation_sigma)[50:].ravel()
    assert chi2.ppf(1e-4, v.size) < v @ v < chi2.ppf(1 - 1e-4, v.size)
    assert abs(np.mean(v[3:] * v[:-3])) < 4 / np.sqrt(v.size)


def test_numbers_of_paper_b_in_the_steady_state():
    """q = 0.48, r = 9.9 cm^2: P^- solves P^2 - q P - q r = 0."""
    filtered = random_walk_filter(np.zeros((300, 1)), **PAPER)
    predicted = (filtered.innovation_sigma[-1, 0] ** 2 - PAPER["r"]) / CM2
    assert predicted == pytest.approx((0.48 + np.sqrt(0.48**2 + 4 * 0.48 * 9.9)) / 2)
    assert predicted == pytest.approx(2.433, abs=5e-4)
    assert predicted / (predicted + 9.9) == pytest.approx(0.197, abs=5e-4)
    assert 100 * 2 * filtered.innovation_sigma[-1, 0] == pytest.approx(7.02, abs=5e-3)


@pytest.mark.parametrize(("step", "locked_out"), [(0.0700, 0), (0.0705, 1), (0.10, 27), (0.15, 92)])
def test_a_large_step_is_locked_out(step, locked_out):
    """Noise-free: a step of 10 cm is rejected in 27 epochs, of 15 cm in 92, of a little more than 7.02 cm in one."""
    z = np.zeros((600, 1))
    z[300:] = step
    weight = random_walk_filter(z, **PAPER).weight[300:, 0]
    assert np.argmax(weight > 0) == locked_out


def test_before_the_first_number_nothing_is_known():
    filtered = random_walk_filter([[np.nan, 1.0], [np.nan, np.nan], [4.0, 1.0]], 2.0, 4.0)
    assert np.isnan(filtered.level[:2, 0]).all()
    assert filtered.level[2].tolist() == [4.0, 1.0]
    assert filtered.variance[:, 1].tolist() == [2.0, 4.0, 6.0 * 4.0 / 10.0]
    assert filtered.variance[2, 0] == 2.0
    level, variance = random_walk_smoother(filtered, 2.0)
    assert np.isnan(level[:2, 0]).all()
    assert np.isfinite(level[:, 1]).all()
    assert (variance[:, 1] <= filtered.variance[:, 1]).all()


def test_small_and_still_series():
    assert random_walk_filter(np.empty((0, 3)), 1.0, 1.0).level.shape == (0, 3)
    assert random_walk_smoother(random_walk_filter(np.empty((0, 3)), 1.0, 1.0), 1.0)[0].shape == (0, 3)
    assert random_walk_filter([[7.0]], 1.0, 1.0, igg3(1, 2)).level.tolist() == [[7.0]]
    assert np.isnan(random_walk_filter(np.full((9, 2), np.nan), 1.0, 1.0).level).all()
    still = random_walk_filter(np.full((50, 1), 1.2), 0.0, 1.0, tukey(4.685))
    np.testing.assert_allclose(still.level, 1.2, rtol=1e-14)
    assert still.variance[-1, 0] == pytest.approx(1 / 51)  # the mean of 50 values and the prior


def test_a_hair_of_weight_is_no_overflow():
    """Far out the Danish weight is 1e-300 and less: r / eta would be infinite."""
    z = np.zeros((60, 1))
    z[30] = np.sqrt(720.0) * 2.3
    filtered = random_walk_filter(z, 0.1, 1.0, danish(1.0))
    assert np.isfinite(filtered.level).all()
    assert np.isfinite(filtered.variance).all()
    assert filtered.weight[30, 0] < 1e-100


def test_nothing_of_the_callers_is_written(rng):
    z = rng.standard_normal((10, 3))
    z.flags.writeable = False
    filtered = random_walk_filter(z, **PAPER)
    for array in (filtered.level, filtered.variance):
        array.flags.writeable = False
    random_walk_smoother(filtered, PAPER["q"])


@pytest.mark.skipif(not COMPILED, reason="lists of numbers are five times as large")
def test_memory_stays_small(rng):
    z = rng.standard_normal((100_000, 3))
    z.flags.writeable = False
    random_walk_filter(z[:10], **PAPER)
    tracemalloc.start()
    random_walk_filter(z, **PAPER)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 8 * z.nbytes  # five results, a copy of z because it is read-only


def test_it_reads_aloud():
    z = np.zeros((10, 2))
    z[5, 0], z[7, 1] = 100.0, np.nan
    assert repr(random_walk_filter(z, **PAPER)) == "RandomWalk: 10 x 2 values, 19 measured, 1 rejected"


@pytest.mark.parametrize(
    ("z", "q", "r", "weight", "words"),
    [
        (np.zeros(5), 1.0, 1.0, None, r"write z\[:, None\]"),
        ([[np.inf]], 1.0, 1.0, None, "finite, or NaN"),
        (np.zeros((5, 3)), [1.0, 2.0], 1.0, None, r"q must be one number or one per axis, \(3,\)"),
        (np.zeros((5, 3)), 1.0, -1.0, None, "r is a variance"),
        (np.zeros((5, 3)), np.nan, 1.0, None, "q is a variance"),
        (np.zeros((5, 3)), 1.0, 0.0, None, "r, the variance of a measurement, must be above zero"),
        (np.zeros((5, 3)), 1.0, 1.0, igg3_weight, r"such as igg3\(1, 2\)"),
    ],
)
def test_a_bad_call_is_told_what_was_expected(z, q, r, weight, words):
    with pytest.raises(ValueError, match=words):
        random_walk_filter(z, q, r, weight)


PROGRAM = """
import json
import numpy as np
from gnsslab.core import jit
from gnsslab.core.random_walk import random_walk_filter, random_walk_smoother
from gnsslab.core.robust import danish, huber, igg3, tukey
rng = np.random.default_rng(3)
z = np.cumsum(rng.standard_normal((80, 2)), axis=0) + 3 * rng.standard_normal((80, 2)) ** 3
z[[0, 4, 5, 40], [0, 1, 1, 0]] = np.nan
out = {"compiled": jit.COMPILED, "answers": []}
for weight in (None, igg3(1, 2), huber(1.345), tukey(4.685), danish(2)):
    walk = random_walk_filter(z, 1.0, 9.0, weight)
    parts = [walk.level, walk.variance, walk.innovation, walk.innovation_sigma, walk.weight, *random_walk_smoother(walk, 1.0)]
    out["answers"].append(np.nan_to_num(parts, nan=-1e9).tolist())
print(json.dumps(out))
"""


def run(**environment):
    environment = {"PATH": os.environ["PATH"], "PYTHONPATH": os.pathsep.join(sys.path), **environment}
    done = subprocess.run([sys.executable, "-W", "error", "-c", PROGRAM], env=environment, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_the_same_answers_compiled_and_not_and_kept_for_the_next_process(tmp_path):
    pytest.importorskip("numba")
    plain = run(GNSSLAB_NO_NUMBA="1")
    compiled = run(NUMBA_CACHE_DIR=str(tmp_path), HOME=str(tmp_path))
    kept = sorted(path.name for path in tmp_path.rglob("*.nb*"))
    assert compiled["compiled"]
    assert not plain["compiled"]
    np.testing.assert_allclose(compiled["answers"], plain["answers"], rtol=1e-11)
    assert any("_filter" in name for name in kept)
    run(NUMBA_CACHE_DIR=str(tmp_path), HOME=str(tmp_path))
    assert sorted(path.name for path in tmp_path.rglob("*.nb*")) == kept, "a second process compiled again"
