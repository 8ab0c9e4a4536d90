"""MC-LAMBDA: every integer vector within a bound with SciPy's rotations, C-LAMBDA for one baseline, counted successes."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from obvious import all_within, covariance, unimodular
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from gnsslab.core.integers import attitude_integer_least_squares, constrained_integer_least_squares, integer_least_squares
from gnsslab.core.mixed_model import FloatSolution, given_integers, solve_float
from gnsslab.gnss.short_baseline import short_baseline_model

NORM = 1e-6  # relative: what float64 leaves of a cost where metres and millimetres meet
SIGMAS = 4.5  # of a binomial count: seven in a million by chance
RIGHT_ANGLE = [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]
TRIPOD = [[0.0, 1.0, 0.0], [0.7, 0.7, 0.0], [0.0, 0.4, 0.6]]
BODIES = [
    [[0.0, 1.2, 0.0]],
    [[0.0, 1.0, 0.0], [0.0, -1.3, 0.0]],  # in line
    RIGHT_ANGLE,
    [[0.0, 1.0, 0.0], [0.7, 0.7, 0.0], [-0.7, 0.6, 0.0]],  # flat
    TRIPOD,
]
cases = st.tuples(st.integers(1, 5), st.sampled_from(BODIES), st.integers(0, 2**32 - 1))  # n, body, seed
STARTS = Rotation.random(40, random_state=1)


def arguments(solution, k):
    """Return what the search is called with: baselines of a FloatSolution as rows (..., k, 3)."""
    return solution.a_hat, solution.Q_a, solution.b_hat.reshape(*solution.b_hat.shape[:-1], k, 3), solution.Q_b, solution.Q_ba


def problem(n, body, seed):
    """Return a random float solution whose integers tell the baselines to a tenth or so of their spread, and a body."""
    rng, k = np.random.default_rng(seed), len(body)
    joint = covariance(n + 3 * k, rng, decades=1.5)
    F = np.hstack([np.zeros((3 * k, n)), np.eye(3 * k)]) + 0.3 * rng.standard_normal((3 * k, n + 3 * k))
    baselines = Rotation.random(random_state=rng).apply(body).ravel() + 0.5 * rng.standard_normal(3 * k)
    return FloatSolution(rng.uniform(-9, 9, n), baselines, joint[:n, :n], F @ joint @ F.T, (F @ joint)[:, :n]), np.array(body), rng


def epochs(body, count, rng, sigma_code=0.3, satellites=6, sigma_phase=0.003):
    """Return single-epoch L1 float solutions of antennas with one master, true integers zero, each epoch with a rotation of its own.

    Each baseline has the covariance of a short one; two that share the master have half of it in common.
    """
    k, azimuth = len(body), np.radians([10.0, 80.0, 150.0, 200.0, 260.0, 320.0, 45.0, 110.0])[:satellites]
    elevation = np.radians([75.0, 30.0, 45.0, 20.0, 55.0, 35.0, 25.0, 60.0])[:satellites]
    u = np.stack([np.cos(elevation) * np.sin(azimuth), np.cos(elevation) * np.cos(azimuth), np.sin(elevation)], axis=-1)
    one = short_baseline_model(u, [0.1903], np.full(satellites, sigma_code), np.full(satellites, sigma_phase))
    shared = 0.5 * (np.eye(k) + 1.0)
    A, B, Q_y = np.kron(np.eye(k), one.A), np.kron(np.eye(k), one.B), np.kron(shared, one.Q_y)
    R = Rotation.random(count, random_state=rng).as_matrix()
    b = np.einsum("nij,kj->nki", R, body).reshape(count, -1)
    y = b @ B.T + rng.standard_normal((count, len(Q_y))) @ np.linalg.cholesky(Q_y).T
    return solve_float(y, A, B, Q_y), R


def misfit_by_scipy(b, Q, body):
    """Return the least squared distance of baselines b (3k,) from a rotated body, by SciPy's Levenberg-Marquardt from the best 4 of 40 rotations."""
    half = np.linalg.inv(np.linalg.cholesky(Q))  # |half x|^2 = x' Q^-1 x
    turned = np.einsum("sij,kj->ski", STARTS.as_matrix(), body).reshape(len(STARTS), -1)
    promising = np.argsort(np.sum(((b - turned) @ half.T) ** 2, axis=-1))[:4]

    def off(theta):
        return half @ (b - Rotation.from_rotvec(theta).apply(body).ravel())

    return min(2.0 * least_squares(off, STARTS[i].as_rotvec(), xtol=1e-12).cost for i in promising)


def exhaustively(solution, body, n_best, bound):
    """Return candidates and costs of the n_best vectors, all within the bound looked at: costs are no less than norms.

    The lengths alone cost |(|b_i| - l_i)|^2 / q_max; in the order of what is certain, rotations are asked for until no more can be better.
    """
    a = np.array(all_within(solution.a_hat, solution.Q_a, bound * (1 + 1e-9)))
    residual = solution.a_hat - a
    norms = np.vecdot(residual, np.linalg.solve(solution.Q_a, residual.T).T)
    b, Q = given_integers(solution, a)
    off = np.linalg.norm(b.reshape(len(a), -1, 3), axis=-1) - np.linalg.norm(body, axis=-1)
    certain = norms + np.vecdot(off, off) / np.linalg.eigvalsh(Q)[-1]
    costs = np.full(len(a), np.inf)
    for i in np.argsort(certain):
        if certain[i] > np.sort(costs)[:n_best][-1]:
            break
        costs[i] = norms[i] + misfit_by_scipy(b[i], Q, body)
    order = np.argsort(costs)[:n_best]
    return a[order], costs[order]


@settings(max_examples=12, deadline=None)
@given(cases)
def test_equals_looking_at_every_vector(case):
    solution, body, _ = problem(*case)
    found = attitude_integer_least_squares(*arguments(solution, len(body)), body)
    a, costs = exhaustively(solution, body, 2, found.norms[-1])
    assert found.complete
    assert np.allclose(found.norms, costs, rtol=1e-5)  # SciPy's descent stops there
    if np.all(np.diff(costs) > 1e-3 * costs[-1]):
        assert np.array_equal(found.candidates, a)


@settings(max_examples=40, deadline=None)
@given(st.integers(1, 6), st.integers(0, 2**32 - 1))
def test_one_baseline_is_c_lambda(n, seed):
    solution, body, _ = problem(n, BODIES[0], seed)
    a_hat, Q_a, b_hat, Q_b, Q_ba = arguments(solution, 1)
    found = attitude_integer_least_squares(a_hat, Q_a, b_hat, Q_b, Q_ba, body, n_best=3)
    known = constrained_integer_least_squares(a_hat, Q_a, b_hat[0], Q_b, Q_ba, 1.2, n_best=3)
    assert np.allclose(found.norms, known.norms, rtol=NORM)
    apart = np.diff(known.norms, prepend=-1, append=np.inf) > 1e-6 * known.norms[-1]  # ties may stand in any order
    for i in np.flatnonzero(apart[:-1] & apart[1:]):
        assert np.array_equal(found.candidates[i], known.candidates[i])
        assert np.allclose(found.baselines[i, 0], known.baselines[i], atol=1e-5)


@settings(max_examples=60, deadline=None)
@given(cases)
def test_costs_are_those_of_the_candidates_and_the_baselines_are_rotated(case):
    solution, body, _ = problem(*case)
    found = attitude_integer_least_squares(*arguments(solution, len(body)), body, n_best=3)
    assert np.all(np.diff(found.norms) >= 0)
    assert np.allclose(found.rotations @ found.rotations.mT, np.eye(3), atol=1e-12)
    assert np.allclose(np.linalg.det(found.rotations), 1.0)
    assert np.allclose(found.baselines, body @ found.rotations.mT, atol=1e-12)
    joint = np.block([[solution.Q_a, solution.Q_ba.T], [solution.Q_ba, solution.Q_b]])
    off = np.hstack([solution.a_hat - found.candidates, solution.b_hat - found.baselines.reshape(3, -1)])
    assert np.allclose(found.norms, np.vecdot(off, np.linalg.solve(joint, off.T).T), rtol=NORM)


@settings(max_examples=40, deadline=None)
@given(cases)
def test_other_integers_and_other_axes_give_the_same_answer(case):
    """A unimodular map and a shift of the ambiguities, a rotation of the world, another one of the body."""
    solution, body, rng = problem(*case)
    n, k = len(solution.a_hat), len(body)
    Z, shift = unimodular(n, rng), rng.integers(-99, 99, n)
    S, P = (Rotation.random(random_state=rng).as_matrix() for _ in range(2))
    whole = np.kron(np.eye(k), S)
    a, Q_a, b, Q_b, Q_ba = arguments(solution, k)
    found = attitude_integer_least_squares(a, Q_a, b, Q_b, Q_ba, body)
    mapped = attitude_integer_least_squares(Z.T @ (a + shift), Z.T @ Q_a @ Z, b @ S.T, whole @ Q_b @ whole.T, whole @ Q_ba @ Z, body @ P.T)
    assert np.allclose(found.norms, mapped.norms, rtol=NORM)
    if found.norms[1] > found.norms[0] * (1 + 1e-6):
        assert np.array_equal((found.best + shift) @ Z, mapped.best)
        assert np.allclose(found.baselines[0] @ S.T, mapped.baselines[0], atol=1e-4)


@pytest.mark.parametrize("body", BODIES)
def test_without_noise_the_truth_comes_back(body, rng):
    solution, R = epochs(np.array(body), 3, rng, sigma_code=0.15)
    truth, k = rng.integers(-1000, 1000, solution.a_hat.shape[-1]), len(body)
    b = np.einsum("nij,kj->nki", R, body)
    clean = solution._replace(a_hat=np.tile(truth, (3, 1)).astype(float), b_hat=b.reshape(3, -1))
    found = attitude_integer_least_squares(*arguments(clean, k), body, n_best=1)
    assert np.array_equal(found.best, np.tile(truth, (3, 1)))
    assert np.all(found.norms < 1e-6)
    assert np.allclose(found.baselines[:, 0], b, atol=1e-6)


def test_the_more_is_known_the_more_epochs_are_right(rng):
    """Two baselines of a metre, single epochs of L1: without lengths, each with its length, both with lengths and angle.

    Of epochs decided differently most must be won by the one that knows more: McNemar's test.
    """
    body, N = np.array(RIGHT_ANGLE), 400
    solution, _ = epochs(body, N, rng)
    a, Q_a, b, Q_b, Q_ba = arguments(solution, 2)
    plain = np.all(integer_least_squares(a, Q_a, n_best=1).best == 0, axis=-1)
    one_by_one = np.ones(N, dtype=bool)
    for i in range(2):
        rows, three = slice(5 * i, 5 * i + 5), slice(3 * i, 3 * i + 3)
        fixed = constrained_integer_least_squares(a[:, rows], Q_a[rows, rows], b[:, i], Q_b[three, three], Q_ba[three, rows], 1.0, n_best=1)
        one_by_one &= np.all(fixed.best == 0, axis=-1)
    together = attitude_integer_least_squares(a, Q_a, b, Q_b, Q_ba, body, n_best=1)
    right = np.all(together.best == 0, axis=-1)
    assert np.all(together.complete)
    assert plain.mean() < 0.2 < 0.5 < one_by_one.mean() < 0.97 < right.mean()
    for less, more in ((plain, one_by_one), (one_by_one, right)):
        won, lost = np.sum(more & ~less), np.sum(less & ~more)
        assert won - lost > SIGMAS * np.sqrt(won + lost)


def test_best_vector_of_the_true_rotation_is_as_far_as_promised(rng):
    """The cost of the true integers is chi-square: n of the integers and one for each condition on the axes."""
    N, dimensions = 300, {"right angle": (RIGHT_ANGLE, 10 + 3), "tripod": (TRIPOD, 15 + 6)}
    for body, expected in dimensions.values():
        solution, _ = epochs(np.array(body), N, rng, sigma_code=0.15)
        found = attitude_integer_least_squares(*arguments(solution, len(body)), body, n_best=1)
        costs = found.norms[np.all(found.best == 0, axis=-1), 0]
        assert len(costs) > 0.98 * N
        assert abs(costs.mean() - expected) < SIGMAS * np.sqrt(2 * expected / len(costs)) + 0.05  # rotations are not quite linear


def test_a_node_limit_is_said_and_what_was_finished_stays_proved(rng):
    solution, _ = epochs(np.array(TRIPOD), 5, rng)
    called = arguments(solution, 3)
    whole = attitude_integer_least_squares(*called, TRIPOD, n_best=1)
    cut = attitude_integer_least_squares(*called, TRIPOD, n_best=2, node_limit=20_000)
    assert np.all(whole.complete)
    assert not np.any(cut.complete)
    assert np.all(cut.is_best_proved)
    assert np.array_equal(cut.best, whole.best)
    assert np.all(np.isinf(cut.norms[:, 1]))
    assert np.all(np.isnan(cut.baselines[:, 1]))
    assert np.all(cut.ratio > 1)
    assert "5 ended by the node limit, 0 of them before" in repr(cut)
    nothing = attitude_integer_least_squares(*called, TRIPOD, n_best=1, node_limit=2)
    assert not np.any(nothing.is_best_proved)
    assert np.all(np.isinf(nothing.norms))


def test_ratio_is_a_lower_bound_where_the_search_was_cut(rng):
    solution, _ = epochs(np.array(RIGHT_ANGLE), 5, rng)
    whole, cut = (attitude_integer_least_squares(*arguments(solution, 2), RIGHT_ANGLE, node_limit=limit) for limit in (10**6, 1000))
    assert np.all(whole.complete)
    assert not np.all(cut.complete)
    assert np.all(cut.ratio <= whole.ratio * (1 + NORM))


def test_stacks_keep_their_shape(rng):
    solution, _ = epochs(np.array(RIGHT_ANGLE), 6, rng)
    a, Q_a, b, Q_b, Q_ba = arguments(solution, 2)
    flat = attitude_integer_least_squares(a, Q_a, b, Q_b, Q_ba, RIGHT_ANGLE, n_best=1)
    stacked = attitude_integer_least_squares(a.reshape(2, 3, -1), Q_a, b.reshape(2, 3, 2, 3), Q_b, Q_ba, RIGHT_ANGLE, n_best=1)
    assert stacked.candidates.shape == (2, 3, 1, 10)
    assert stacked.baselines.shape == (2, 3, 1, 2, 3)
    assert np.array_equal(stacked.best.reshape(6, -1), flat.best)
    empty = attitude_integer_least_squares(a[:0], Q_a, b[:0], Q_b, Q_ba, RIGHT_ANGLE)
    assert empty.candidates.shape == (0, 2, 10)


def test_order_of_the_ambiguities_changes_nothing(rng):
    solution, _ = epochs(np.array(RIGHT_ANGLE), 3, rng)
    a, Q_a, b, Q_b, Q_ba = arguments(solution, 2)
    order = rng.permutation(10)
    found = attitude_integer_least_squares(a, Q_a, b, Q_b, Q_ba, RIGHT_ANGLE, n_best=1)
    mixed = attitude_integer_least_squares(a[:, order], Q_a[np.ix_(order, order)], b, Q_b, Q_ba[:, order], RIGHT_ANGLE, n_best=1)
    assert np.array_equal(found.best[:, order], mixed.best)


GOOD = dict(zip(("a_hat", "Q_a", "b_hat", "Q_b", "Q_ba"), (np.zeros(2), np.eye(2), np.eye(3)[:2], np.eye(6), np.zeros((6, 2))), strict=True))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"body": [0.0, 1.0, 0.0]}, r"body must have shape \(k, 3\)"),
        ({"body": [[0.0, 1.0, 0.0], [0.0, 0.0, 0.0]]}, "baseline 1 of the body has length zero: its two antennas are in one place"),
        ({"a_hat": np.zeros(3)}, r"a_hat must have shape \(2,\)"),
        ({"b_hat": np.zeros(6)}, r"b_hat must have shape \(2, 3\)"),
        ({"b_hat": np.zeros((4, 2, 3))}, "stacked alike"),
        ({"Q_a": np.eye(3)}, r"Q_ba must have shape \(6, 3\)"),
        ({"Q_a": np.zeros((0, 0)), "a_hat": np.zeros(0), "Q_ba": np.zeros((6, 0))}, "Q_a must have shape"),
        ({"Q_b": np.eye(3)}, r"Q_b must have shape \(6, 6\)"),
        ({"Q_ba": np.zeros((2, 6))}, r"Q_ba must have shape \(6, 2\)"),
        ({"a_hat": [np.nan, 0.0]}, "must be finite"),
        ({"Q_b": np.diag([1.0, 1.0, 1.0, 1.0, 1.0, np.inf])}, "must be finite"),
        ({"a_hat": [2.0**52, 0.0]}, "no fractions left"),
        ({"Q_a": [[1.0, 0.5], [0.0, 1.0]]}, "not symmetric"),
        ({"Q_ba": np.full((6, 2), 0.9)}, "not positive definite together"),
        ({"n_best": 0}, "n_best must be a whole number"),
        ({"node_limit": 0}, "node_limit must be a whole number"),
    ],
)
def test_bad_input_is_told_in_a_sentence(change, words):
    with pytest.raises(ValueError, match=words):
        attitude_integer_least_squares(**{**GOOD, "body": RIGHT_ANGLE, **change})


def test_arguments_are_left_alone():
    body, given = np.array(RIGHT_ANGLE), {name: array.copy() for name, array in GOOD.items()}
    for array in (body, *given.values()):
        array.flags.writeable = False
    assert attitude_integer_least_squares(**given, body=body).complete
