"""A known length in the search of the engine's filter: against the public search, and what it learns of the noise."""

from dataclasses import fields, replace

import numpy as np
import pytest

from gnsslab.core.integers import fix_with_length, integer_least_squares
from gnsslab.core.jit import kernel_indices, kernel_input
from gnsslab.core.mixed_model import FloatSolution
from gnsslab.gnss import motion
from gnsslab.gnss.ambiguity_filter import filter_block
from gnsslab.gnss.blocks import run_blocks
from gnsslab.gnss.filter_steps import SIGMA_NEW_AMBIGUITY, search_integers
from gnsslab.gnss.known_length import cautious, code_scale, run_with_length, scaled
from gnsslab.gnss.preparation import Settings, prepare_moving
from gnsslab.gnss.weighting import NoiseModel
from gnsslab.simulate import LOW_COST, find_preset, simulate

LENGTH, SIGMA = 1.167, 0.005  # [m]
MM = 1e-3  # [m]
T = 40
ACCEPTANCE = 16.0


@pytest.fixture(scope="module")
def prepared():
    """40 single epochs of two low-cost receivers at rest, GPS and BeiDou on one carrier, and the true baselines in ECEF."""
    simulation = simulate(replace(find_preset("paper-a-static"), duration=float(T), noise=LOW_COST, events=()), np.random.default_rng(2))
    found = prepare_moving(*simulation.observations, simulation.ephemerides, Settings(systems="GC", frequencies=1, single_epoch=True))
    return found.model, simulation.truth.baselines_enu[0]


def alone(model):
    """Return the Path of epochs that know nothing of each other."""
    return motion.forgetful(model.pair.time, model.near)


def drawn(model, rng, codes=1.0, carriers=1.0, b=(0.6, -0.6, 0.8)):
    """Return the Model with measurements drawn with so many times the sigmas it says, the baseline at a place on the sphere, integers zero."""
    b = LENGTH * np.array(b) / np.linalg.norm(b)
    ranges = np.einsum("tci,ti->tc", model.design, b - model.near) + rng.uniform(-30, 30, (len(model.near), 1))
    code, phase = (
        ranges + factor * sigma * rng.standard_normal(sigma.shape) for factor, sigma in ((codes, model.sigma_code), (carriers, model.sigma_phase))
    )
    return replace(model, code=code, phase=phase), b


# The search inside the filter.


@pytest.mark.parametrize("length", [LENGTH, 0.5])
@pytest.mark.parametrize("sigma", [SIGMA, 0.1])
@pytest.mark.parametrize("seed", range(4))
def test_the_search_is_the_public_one_with_the_length_uncertain(length, sigma, seed):
    """Channels 0 and 4 are references; `fix_with_length` gets double differences and Q_b + sigma^2 I."""
    rng = np.random.default_rng(seed)
    k, p = 8, 6
    A = rng.standard_normal((p + k, p + k))
    P = A @ A.T * np.outer(*2 * [np.append(np.full(p, 0.3), np.full(k, 0.6))]) + 1e-3 * np.eye(p + k)
    x = np.append(0.5 * rng.standard_normal(p), rng.uniform(-40, 40, k))
    pairs = [(1, 0), (2, 0), (3, 0), (5, 4), (6, 4), (7, 4)]
    D = np.zeros((len(pairs), p + k))
    for row, (channel, reference) in zip(D, pairs, strict=True):
        row[p + channel], row[p + reference] = 1.0, -1.0
    Q_a, Q_ba = D @ P @ D.T, P[:3] @ D.T
    solution = FloatSolution(D @ x, x[:3], (Q_a + Q_a.T) / 2, P[:3, :3] + sigma**2 * np.eye(3), Q_ba)
    known, free = fix_with_length(solution, length), integer_least_squares(solution.a_hat, solution.Q_a)
    for expected, given in ((known, length), (free, 0.0)):
        candidates, norms, *_ = search_integers(kernel_input(x), kernel_input(P), p, kernel_indices(pairs), given, sigma, 100_000)
        np.testing.assert_array_equal(candidates, expected.candidates)
        np.testing.assert_allclose(norms[0], expected.norms, rtol=1e-6)
    assert known.norms[0] >= free.norms[0], "a length can only cost"


def float_solution(model, t):
    """Return the FloatSolution of one epoch by least squares of all that is known in it, and the D (d, c) of its double differences."""
    usable = np.flatnonzero(model.usable[t])
    groups = model.pair.group[usable]
    firsts = [np.flatnonzero(groups == group)[0] for group in np.unique(groups)]
    D = np.array([np.eye(len(usable))[i] - np.eye(len(usable))[f] for f in firsts for i in np.flatnonzero(groups == groups[f]) if i != f])
    B, wavelength, n = model.design[t, usable], np.diag(model.pair.wavelength[usable]), len(usable)
    code, phase = model.code[t, usable], model.phase[t, usable]
    H = np.block([[np.eye(3), np.zeros((3, n))], [np.zeros((n, 3)), wavelength], [D @ B, 0 * D], [D @ B, D @ wavelength]])
    y = np.concatenate([np.zeros(3), phase - code, D @ code, D @ phase])  # b counts from `near`
    Q = np.zeros((len(y), len(y)))
    Q[: n + 3, : n + 3] = np.diag([motion.SIGMA_OPEN**2] * 3 + [SIGMA_NEW_AMBIGUITY**2] * n)
    for k, sigma in enumerate((model.sigma_code, model.sigma_phase)):
        rows = slice(n + 3 + k * len(D), n + 3 + (k + 1) * len(D))
        Q[rows, rows] = D @ np.diag(sigma[t, usable] ** 2) @ D.T
    W = np.linalg.inv(np.linalg.cholesky(Q))
    x, *_ = np.linalg.lstsq(W @ H, W @ y, rcond=None)
    P = np.linalg.inv(H.T @ W.T @ W @ H)
    Q_a, G = D @ P[3:, 3:] @ D.T, P[:3, 3:] @ D.T
    return FloatSolution(D @ x[3:], model.near[t] + x[:3], (Q_a + Q_a.T) / 2, P[:3, :3], G), D, usable


def test_a_block_with_the_length_fixes_as_fix_with_length_does(prepared):
    """Every epoch by itself: ratio and cost of the filter are those of the public search on the same float solution, which stays as it is."""
    model, _ = prepared
    outcome, free = (
        run_blocks(model, alone(model), run=run).outcome for run in (lambda x, P, block: filter_block(x, P, block, LENGTH, SIGMA), filter_block)
    )
    np.testing.assert_array_equal(outcome.baseline_float, free.baseline_float)
    np.testing.assert_array_equal(outcome.Q_float, free.Q_float)
    solutions = {t: float_solution(model, t) for t in range(0, T, 4)}
    whole = [t for t, (solution, *_) in solutions.items() if np.allclose(outcome.Q_float[t], solution.Q_b, rtol=1e-3)]
    assert len(whole) >= 6, "elsewhere the filter has set a code aside, here none is"
    for t in whole:
        solution, D, usable = solutions[t]
        np.testing.assert_allclose(outcome.baseline_float[t], solution.b_hat, rtol=0, atol=0.1 * MM)
        fixed = fix_with_length(solution._replace(Q_b=solution.Q_b + SIGMA**2 * np.eye(3)), LENGTH)
        assert outcome.cost[t] == pytest.approx(fixed.norms[0], rel=1e-3)
        assert outcome.ratio[t] == pytest.approx(fixed.ratio, rel=1e-3)
        W = np.linalg.inv(np.linalg.cholesky(D @ np.diag(model.sigma_phase[t, usable] ** 2) @ D.T))
        metres = D @ model.phase[t, usable] - np.array([model.pair.wavelength[usable[np.argmax(row)]] for row in D]) * fixed.best
        step, *_ = np.linalg.lstsq(W @ D @ model.design[t, usable], W @ metres, rcond=None)
        np.testing.assert_allclose(outcome.baseline_fixed[t], model.near[t] + step, rtol=0, atol=1e-6)


# What is learnt of the noise.


@pytest.mark.parametrize("factor", [0.3, 1.0, 3.0])
def test_codes_tell_their_own_noise(prepared, rng, factor):
    """The median of T chi-squares of k degrees scatters by sqrt(pi / 2) of their mean: variance 2 k, so 1.25 sqrt(2 / k T) of the scale's square."""
    model, _ = drawn(prepared[0], rng, codes=factor)
    k = model.usable[0].sum() - 3 - len(np.unique(model.pair.group))
    spread = 4 * 1.25 * np.sqrt(2 / (k * T)) / 2
    assumed = 10.0 / (10.0 + k * T)  # what is given to the sigmas as they are
    assert code_scale(model) ** 2 == pytest.approx(assumed + (1 - assumed) * factor**2, rel=2 * spread)
    twice = scaled(model, 2.0, 1.0)
    assert (twice.sigma_code == 2 * model.sigma_code).all()
    assert (twice.sigma_phase == model.sigma_phase).all()
    assert code_scale(twice) < 0.6 * code_scale(model) or factor == 0.3


def test_outliers_do_not_tell_the_noise_and_no_spare_code_tells_nothing(prepared, rng):
    model, _ = drawn(prepared[0], rng)
    bad = model.code.copy()
    bad[: T // 5, 0] += 500.0
    assert code_scale(replace(model, code=bad)) == pytest.approx(code_scale(model), rel=0.2)
    few = model.usable.copy()
    few[:, np.flatnonzero(model.pair.group == model.pair.group[0])[4:]] = False
    few[:, model.pair.group != model.pair.group[0]] = False
    assert few[0].sum() == 4
    assert code_scale(replace(model, usable=few)) == 1.0


def test_measurements_are_news_less_soon():
    assert cautious(NoiseModel(novelty_time=1.0)).novelty_time > 1.0
    assert cautious(NoiseModel(novelty_time=500.0)) == NoiseModel(novelty_time=500.0)


# The run.


@pytest.mark.parametrize("factor", [0.5, 1.0, 1.5])
def test_most_epochs_are_fixed_and_none_wrongly_whatever_the_noise_assumed(prepared, rng, factor):
    """Noise of half to one and a half of the sigmas. A wrong integer is many sigma away, chi-square of 3 not 30."""
    model, b = drawn(prepared[0], rng, factor, factor)
    solution, is_believed = run_with_length(model, alone(model), LENGTH, SIGMA, ACCEPTANCE)
    off = (solution.outcome.baseline_fixed - b)[is_believed]
    assert is_believed.mean() > 0.5
    assert np.vecdot(off, np.linalg.solve(solution.outcome.Q_fixed[is_believed], off[..., None])[..., 0]).max() < 30


def test_sigmas_of_another_size_change_nothing_where_there_is_much_to_learn_from(prepared, rng):
    """All sigmas 1.5 times as large: the run learns them back, but for what is assumed beforehand."""
    model, _ = drawn(prepared[0], rng)
    runs = [run_with_length(scaled(model, f, f), alone(model), LENGTH, SIGMA, ACCEPTANCE) for f in (1.0, 1.5)]
    (one, believed), (other, believed_too) = runs
    assert (believed != believed_too).mean() < 0.1
    both = believed & believed_too
    np.testing.assert_allclose(one.outcome.baseline_fixed[both], other.outcome.baseline_fixed[both], rtol=0, atol=1e-6)


def test_progress_of_two_runs_is_one(prepared):
    heard = []
    run_with_length(prepared[0], alone(prepared[0]), LENGTH, SIGMA, ACCEPTANCE, progress=lambda done, total: heard.append((done, total)))
    assert heard == sorted(heard)
    assert heard[-1] == (2 * T, 2 * T)


def test_arguments_stay_as_they_are(prepared):
    model, _ = prepared
    for field in fields(model):
        if isinstance(getattr(model, field.name), np.ndarray):
            getattr(model, field.name).flags.writeable = False
    _, once = run_with_length(model, alone(model), LENGTH, SIGMA, ACCEPTANCE)
    _, again = run_with_length(model, alone(model), LENGTH, SIGMA, ACCEPTANCE)
    assert (once == again).all()
