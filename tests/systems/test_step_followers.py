"""Filters that follow a step: each against the same formulas written with matrices, and what all of them must do with steps, outliers and gaps."""

import json
import os
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import logsumexp
from scipy.stats import multivariate_normal

from gnsslab.core.random_walk import random_walk_filter
from gnsslab.core.robust import igg3, igg3_weight
from gnsslab.gnss.relative import Status
from gnsslab.gnss.series import series_of_numbers
from gnsslab.systems.deformation import B_STEP, PublishedSeries
from gnsslab.systems.step_followers import adaptive_follower, change_point_follower, cusum_follower, multi_process_follower
from gnsslab.systems.step_followers.adaptive import K0, K1
from gnsslab.systems.step_followers.change_point import FRESH
from gnsslab.systems.step_followers.followed import noise_rows
from gnsslab.systems.step_followers.multi_process import CHANCE_OUTLIER, GROSS

FOLLOWERS = [adaptive_follower, multi_process_follower, change_point_follower, cusum_follower]
SEEDS = st.integers(0, 2**32 - 1)
SIGMA = 0.02  # [m] of each solution on an axis
mm = 1e-3


def noisy(T=600, seed=1, first=None, step=(0.0, 0.0, 0.0)):
    """Return a Series of white noise about (1, 2, 3) m, with a step at epoch `first`."""
    rng = np.random.default_rng(seed)
    enu = [1.0, 2.0, 3.0] + SIGMA * rng.standard_normal((T, 3))
    if first is not None:
        enu[first:] += step
    return series_of_numbers(np.arange(T).astype("M8[s]"), enu)


class Dense:
    """Level and coloured error of three axes as one Kalman filter of six states."""

    H = np.kron(np.eye(3), [1.0, 1.0])

    def __init__(self, noise):
        w, c, tau, q = noise.T
        self.a = np.exp(-1 / tau)
        self.F, self.R = np.diag(np.stack([np.ones(3), self.a], 1).ravel()), np.diag(w)
        self.Q, self.x = np.diag(np.stack([q, (1 - self.a**2) * c], 1).ravel()), np.zeros(6)
        self.P, self.sigma2 = np.diag(np.stack([w + c, c], 1).ravel()), w + c

    def copy(self):
        new = object.__new__(Dense)
        new.__dict__.update({name: np.copy(value) for name, value in vars(self).items()})
        return new

    def predict(self):
        self.x, self.P = self.F @ self.x, self.F @ self.P @ self.F.T + self.Q

    def widen(self, sigmas):
        self.P[[0, 2, 4], [0, 2, 4]] += sigmas**2 * self.sigma2

    def innovation(self, z, gross=0.0):
        return z - self.H @ self.x, self.H @ self.P @ self.H.T + self.R + gross**2 * np.diag(self.sigma2)

    def update(self, v, S):
        G = self.P @ self.H.T @ np.linalg.inv(S)
        self.x, self.P = self.x + G @ v, self.P - G @ S @ G.T

    @property
    def level(self):
        return self.x[[0, 2, 4]]


def prepared(series, memory):
    z = series.enu - series.enu[0]
    return z, Dense(noise_rows(z, memory))


def test_adaptive_filter_is_its_formulas_with_matrices():
    series = noisy(80, 3, first=50, step=(0.08, 0.0, -0.04))
    series.enu[30] += 0.5
    (z, dense), agreeing, c0, c1 = prepared(series, 100.0), 5, 2.0, 3.0
    found = adaptive_follower(series, 100.0, agreeing, c0, c1)
    recent, alphas = np.zeros((agreeing, 3)), []
    for k in range(len(z)):
        dense.predict()
        v, S = dense.innovation(z[k])
        standard = v / np.sqrt(np.diag(S))
        recent[k % agreeing] = standard * K1 / max(np.linalg.norm(standard), K1)
        Delta = np.linalg.norm(recent.sum(axis=0)) / np.sqrt(agreeing)
        alphas.append(max(igg3_weight(Delta, c0, c1), 1e-3))
        dense.P[[0, 2, 4], [0, 2, 4]] /= alphas[-1]
        assert found.is_step[k] == (c1 < Delta)
        if found.is_step[k]:
            recent[:] = 0.0
        v, S = dense.innovation(z[k])
        eta = igg3_weight(np.linalg.norm(v / np.sqrt(np.diag(S))), K0, K1)
        if eta > 0:
            dense.update(v, S + dense.R * (1 / eta - 1))
        np.testing.assert_allclose(found.level[k], series.enu[0] + dense.level, rtol=0, atol=1e-9)
    assert min(alphas) == 1e-3
    assert any(1e-3 < alpha < 1 for alpha in alphas), "the part between the thresholds was never in use"


def test_multi_process_filter_is_its_formulas_with_matrices():
    series = noisy(60, 4, first=40, step=(0.1, 0.0, 0.0))
    series.enu[20] += 0.3
    width, chance, sure = 2.0, 1e-2, 0.5
    found = multi_process_follower(series, 100.0, width, chance, sure)
    z, dense = prepared(series, 100.0)
    three, p, told = [dense.copy() for _ in range(3)], np.full(3, 1 / 3), [False]
    prior = np.log([1.0, CHANCE_OUTLIER, chance])
    for k in range(len(z)):
        nine, logs = {}, np.empty((3, 3))
        for i in range(3):
            three[i].predict()
            for j in range(3):
                part = nine[i, j] = three[i].copy()
                if j == 2:
                    part.widen(width)
                v, S = part.innovation(z[k], GROSS if j == 1 else 0.0)
                logs[i, j] = np.log(p[i]) + prior[j] + multivariate_normal(np.zeros(3), S).logpdf(v)
                part.update(v, S)
        both = np.exp(logs - logsumexp(logs))
        p = both.sum(axis=0)
        for j in range(3):
            share = both[:, j] / p[j]
            three[j].x = sum(s * nine[i, j].x for i, s in enumerate(share))
            three[j].P = sum(s * (nine[i, j].P + spread(nine[i, j].x - three[j].x)) for i, s in enumerate(share))
        np.testing.assert_allclose(found.level[k], series.enu[0] + sum(p[j] * three[j].level for j in range(3)), rtol=0, atol=1e-9)
        told.append(both[2].sum() > sure)
        assert found.is_step[k] == (told[-1] and not told[-2])
    assert found.is_step.any()


def spread(x):
    """Return what scatter adds to a covariance (6, 6), axis by axis: the axes are filters of their own."""
    return np.kron(np.eye(3), np.ones((2, 2))) * np.outer(x, x)


def test_change_points_are_their_formulas_with_matrices_and_nothing_dropped():
    series = noisy(60, 5, first=40, step=(0.1, 0.0, 0.0))
    series.enu[20] += 0.3
    width, chance, freedom, sure = 1.5, 1e-2, 6.0, 0.9
    found = change_point_follower(series, 100.0, width, chance, freedom, sure, kept=80)
    z, dense = prepared(series, 100.0)
    runs, logs, told = [dense], [0.0], 0
    for k in range(len(z)):
        for run in runs:
            run.predict()
        best = int(np.argmax(logs))
        if k > 0:
            runs.append(runs[best].copy())
            runs[-1].widen(width)
            logs.append(logs[best] + np.log(chance / (1 - chance)))
        for s, run in enumerate(runs):
            v, S = run.innovation(z[k])
            misfit = v @ np.linalg.solve(S, v)
            logs[s] -= 0.5 * (np.linalg.slogdet(S)[1] + (freedom + 3) * np.log1p(misfit / freedom))
            eta = min(1.0, (freedom + 3) / (freedom + misfit))
            if s == len(runs) - 1:
                eta = 1.0
                run.widen(FRESH)
                v, S = run.innovation(z[k])
            run.update(eta * v, S)
        old = np.array(logs[:-1] if k > 0 else logs)  # a run of one solution does not count
        w = np.exp(old - logsumexp(old))
        level = sum(p * run.level for p, run in zip(w, runs[: len(w)], strict=True))
        np.testing.assert_allclose(found.level[k], series.enu[0] + level, rtol=0, atol=1e-9)
        is_step = w[told + 1 :].sum() > sure
        told = k if is_step else told
        assert found.is_step[k] == is_step
    assert found.is_step.any()


def test_with_few_hypotheses_the_answer_is_nearly_that_of_many():
    series = noisy(400, 6, first=250, step=(0.05, 0.02, 0.0))
    few, many = change_point_follower(series, kept=40), change_point_follower(series, kept=400)
    assert np.abs(few.level - many.level).max() < 1 * mm
    assert np.abs(np.flatnonzero(few.is_step) - np.flatnonzero(many.is_step)).max() <= 1


def test_cusum_is_the_papers_filter_until_the_sum_of_its_innovations_is_too_large():
    series, system, drift, limit = noisy(400, 7, first=300, step=(0.0, -0.06, 0.0)), PublishedSeries("b-step", k0=1.5, k1=3.0), 0.25, 5.0
    found = cusum_follower(series, system, drift, limit)
    paper = random_walk_filter(series.enu, system.q, system.r, igg3(system.k0, system.k1))
    v = np.clip(paper.innovation / paper.innovation_sigma, -system.k1, system.k1)
    sums = np.zeros((400, 6))
    for k in range(400):
        sums[k] = np.maximum(0.0, sums[k - 1] + np.concatenate([v[k], -v[k]]) - drift)
    first = int(np.argmax(sums.max(axis=1) > limit))
    assert 300 < first < 330
    assert np.flatnonzero(found.is_step)[0] == first
    np.testing.assert_allclose(found.level[:first], paper.level[:first], rtol=0, atol=1e-12)
    began = np.flatnonzero(sums[:first, 4] == 0.0)[-1] + 1  # the sum of north, downwards
    np.testing.assert_allclose(found.level[first], series.enu[began : first + 1].mean(axis=0), rtol=0, atol=1e-12)


@pytest.mark.parametrize("follower", FOLLOWERS)
def test_a_step_is_found_and_followed_soon_after_it_and_not_before(follower):
    step = np.array([0.2, -0.15, 0.1])
    for seed in range(5):
        found = follower(noisy(600, seed, first=400, step=step))
        assert not found.is_step[100:400].any()
        assert np.flatnonzero(found.is_step[400:])[0] <= 8
        np.testing.assert_allclose(found.level[440], np.add([1.0, 2.0, 3.0], step), rtol=0, atol=2.5 * SIGMA)


@pytest.mark.parametrize("follower", FOLLOWERS)
def test_one_gross_error_moves_nothing_and_is_no_step(follower):
    series, wrong = noisy(), noisy()
    wrong.enu[400] += [3.0, -1.0, 0.5]
    clean, stained = follower(series), follower(wrong)
    assert not stained.is_step[300:].any()
    assert np.abs(stained.level - clean.level)[400:].max() < 1.0 * SIGMA


@pytest.mark.parametrize("follower", FOLLOWERS)
def test_what_comes_later_changes_nothing_once_the_noise_is_known(follower):
    one, other = noisy(first=500, step=(0.1, 0.0, 0.0)), noisy(first=500, step=(-0.5, 0.3, 0.0))
    found, beside = follower(one), follower(other)
    np.testing.assert_array_equal(found.level[:500], beside.level[:500])
    np.testing.assert_array_equal(found.is_step[:500], beside.is_step[:500])


@settings(deadline=None, max_examples=15)
@given(seed=SEEDS, scale=st.floats(0.1, 10.0), east=st.floats(-100.0, 100.0))
def test_units_and_the_place_do_not_matter(seed, scale, east):
    series = noisy(120, seed, first=80, step=(0.1, 0.0, 0.0))
    moved = replace(series, enu=scale * series.enu + [east, 0.0, 0.0])
    scaled = replace(B_STEP, q=B_STEP.q * scale**2, r=B_STEP.r * scale**2)
    for follower in FOLLOWERS:
        found, beside = follower(series), follower(moved, scaled) if follower is cusum_follower else follower(moved)
        np.testing.assert_allclose(beside.level, scale * found.level + [east, 0.0, 0.0], rtol=0, atol=1e-6 * scale)
        np.testing.assert_array_equal(beside.is_step, found.is_step)


@pytest.mark.parametrize("follower", FOLLOWERS)
def test_gaps_are_predicted_through_and_nothing_is_known_before_the_first_solution(follower):
    series = noisy(first=400, step=(0.2, -0.15, 0.1))
    is_gap = np.isin(np.arange(600), [*range(5), *range(200, 220), 401, 403])
    gappy = replace(series, enu=np.where(is_gap[:, None], np.nan, series.enu), status=np.where(is_gap, Status.NONE, Status.FIXED).astype(np.int8))
    for each in vars(gappy).values():
        each.flags.writeable = False
    found = follower(gappy)
    assert np.isnan(found.level[:5]).all()
    assert np.isfinite(found.level[5:]).all()
    np.testing.assert_allclose(found.level[200:220], np.tile(found.level[199], (20, 1)), rtol=0, atol=1e-12)
    assert not found.is_step[is_gap].any()
    assert found.is_step[400:412].any()


@pytest.mark.parametrize("follower", FOLLOWERS)
def test_a_series_without_solutions_and_a_short_one_are_refused_in_words(follower):
    empty = replace(noisy(40), enu=np.full((40, 3), np.nan), status=np.zeros(40, np.int8))
    with pytest.raises(ValueError, match="the series has none"):
        follower(empty)
    with pytest.raises(ValueError, match="16 values or more"):
        follower(noisy(10))


def test_thresholds_the_wrong_way_round_are_refused():
    with pytest.raises(ValueError, match="0 < c0 < c1"):
        adaptive_follower(noisy(40), c0=5.0, c1=4.0)


PROGRAM = """
import json
import numpy as np
from gnsslab.core import jit
from gnsslab.gnss.series import series_of_numbers
from gnsslab.systems.step_followers import adaptive_follower, change_point_follower, cusum_follower, multi_process_follower
rng = np.random.default_rng(3)
enu = 0.02 * rng.standard_normal((150, 3)) + np.where(np.arange(150) < 100, 0.0, 0.12)[:, None]
enu[[5, 60]], enu[40] = np.nan, 0.7
series = series_of_numbers(np.arange(150).astype("M8[s]"), enu)
found = [follower(series) for follower in (adaptive_follower, change_point_follower, cusum_follower, multi_process_follower)]
print(json.dumps({"compiled": jit.COMPILED, "level": [each.level.tolist() for each in found], "is_step": [each.is_step.tolist() for each in found]}))
"""


def run(switch):
    environment = {**os.environ, "GNSSLAB_NO_NUMBA": switch, "PYTHONPATH": os.pathsep.join(sys.path)}
    done = subprocess.run([sys.executable, "-W", "error", "-c", PROGRAM], env=environment, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_the_same_answers_compiled_and_not():
    pytest.importorskip("numba")
    compiled, plain = run("0"), run("1")
    assert compiled["compiled"]
    assert not plain["compiled"]
    assert compiled["is_step"] == plain["is_step"]
    assert np.any(plain["is_step"], axis=1).all(), "a follower found no step: nothing was compared"
    np.testing.assert_allclose(compiled["level"], plain["level"], rtol=0, atol=1e-10)
