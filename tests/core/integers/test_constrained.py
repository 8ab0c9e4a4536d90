"""C-LAMBDA: published geometry, every integer vector within a bound, a second way to the bound, and what must not change the answer."""

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from obvious import all_within, covariance, unimodular

from gnsslab.core.integers import (
    constrained_by_shrinking,
    constrained_integer_least_squares,
    fix_with_length,
    integer_least_squares,
)
from gnsslab.core.mixed_model import FloatSolution, MixedModel, given_integers, solve_float, use_length
from gnsslab.core.sphere import nearest_on_sphere

SIGMAS = 4.5  # of a binomial count: seven in a million by chance
NORM = 1e-6  # relative: what float64 leaves of a cost where metres and millimetres meet
METRE = 1e-6
both_ways = pytest.mark.parametrize("solve", [constrained_integer_least_squares, constrained_by_shrinking])
cases = st.tuples(st.integers(1, 6), st.integers(1, 3), st.integers(0, 2**32 - 1))  # n, p, seed


@pytest.fixture(scope="module")
def published():
    return json.loads((Path(__file__).parents[2] / "reference" / "constrained.json").read_text())


@pytest.fixture(scope="module")
def one_epoch(published):
    """The model of the published example: six satellites, one epoch of GPS L1."""
    model = published["model"]
    elevation, azimuth = np.array(model["El_rad"]), np.array(model["Az_rad"])
    u = np.stack([np.cos(elevation) * np.sin(azimuth), np.cos(elevation) * np.cos(azimuth), np.sin(elevation)], axis=-1)
    D = np.hstack([-np.ones((5, 1)), np.eye(5)])
    code, phase = (2 * D @ np.diag((sigma / (0.2 + np.sin(elevation))) ** 2) @ D.T for sigma in (0.200, 0.002))
    none = np.zeros((5, 5))
    A = np.vstack([none, model["c"] / model["f"] * np.eye(5)])
    return MixedModel(A, np.vstack([D @ u, D @ u]), np.block([[code, none], [none, phase]]))


def float_solution(model, rng, *stack):
    """Return float solutions of simulated epochs: integers zero, antennas 1 m apart."""
    return solve_float(model.B @ [0.6, 0.0, 0.8] + rng.multivariate_normal(np.zeros(10), model.Q_y, stack or None), *model)


def arguments(solution):
    return solution.a_hat, solution.Q_a, solution.b_hat, solution.Q_b, solution.Q_ba


def problem(n, p, seed):
    """Return a random float solution whose carriers fix b to about a tenth of its spread, and a length."""
    rng = np.random.default_rng(seed)
    joint = covariance(n + p, rng, decades=1.5)
    F = np.hstack([np.zeros((p, n)), np.eye(p)]) + 0.3 * rng.standard_normal((p, n + p))
    Q_a, Q_ba, Q_b = joint[:n, :n], (F @ joint)[:, :n], F @ joint @ F.T
    return FloatSolution(rng.uniform(-9, 9, n), rng.standard_normal(p), Q_a, Q_b, Q_ba), 10.0 ** rng.uniform(-0.5, 0.5), rng


def exhaustively(solution, length, n_best, bound):
    """Return candidates, costs and baselines of the n_best vectors, all within the bound looked at: costs are no less than norms."""
    a = np.array(all_within(solution.a_hat, solution.Q_a, bound * (1 + 1e-9)))
    residual = solution.a_hat - a
    b, Q = given_integers(solution, a)
    landed = nearest_on_sphere(b, (Q + Q.T) / 2, length)
    costs = np.vecdot(residual, np.linalg.solve(solution.Q_a, residual.T).T) + landed.cost
    order = np.argsort(costs)[:n_best]
    return a[order], costs[order], landed.b[order]


@both_ways
def test_published_instances(solve, published, one_epoch):
    """Of eight epochs plain least squares has two right and this has all."""
    kinds = [case["kind"] for case in published["instances"]]
    assert (kinds.count("ils_right"), kinds.count("ils_wrong")) == (2, 6)
    for case in published["instances"]:
        found = solve_float(np.concatenate([case["y_code_m"], case["y_phase_m"]]), *one_epoch)
        solution = solve(*arguments(found), case["baseline_length"])
        assert integer_least_squares(found.a_hat, found.Q_a).best.tolist() == case["unconstrained_ILS"]
        assert solution.best.tolist() == case["constrained_ILS"] == case["true_N"]
        assert np.isclose(solution.norms[0], case["constrained_cost"], rtol=NORM)
        assert np.allclose(solution.baselines[0], case["constrained_b_enu"], atol=METRE)
        if case["second_best_constrained_cost"]:
            assert solution.candidates[1].tolist() == case["second_best_constrained"]
            assert np.isclose(solution.norms[1], case["second_best_constrained_cost"], rtol=NORM)


@pytest.mark.parametrize("length", [0.5, 1.0, 2.0])
def test_published_success_rates(length, published, one_epoch, rng):
    """31.6 % of single epochs of L1 without the length, 95.6 % with it (1 m)."""
    A, B, Q_y = one_epoch
    N, truth = 3000, rng.integers(-50, 50, 5)
    b = rng.standard_normal((N, 3))
    b *= length / np.linalg.norm(b, axis=1, keepdims=True)
    found = solve_float(A @ truth + b @ B.T + rng.multivariate_normal(np.zeros(10), Q_y, N), *one_epoch)
    plain = integer_least_squares(found.a_hat, found.Q_a, n_best=1).best
    with_length = fix_with_length(found, length, n_best=1).best
    rates = published["success_rate"]
    for fixed, expected in ((plain, rates["unconstrained_ILS"]), (with_length, rates["constrained"])):
        counted, said = np.mean(np.all(fixed == truth, axis=-1)), expected[f"l={length}"]
        assert abs(counted - said) < SIGMAS * np.sqrt(said * (1 - said) * (1 / N + 1 / rates["trials"]))


@settings(max_examples=60, deadline=None)
@given(cases)
def test_equals_looking_at_every_vector(case):
    solution, length, _ = problem(*case)
    found = constrained_integer_least_squares(*arguments(solution), length, n_best=3)
    a, costs, b = exhaustively(solution, length, 3, found.norms[-1])
    assert np.allclose(found.norms, costs, rtol=NORM)
    distinct = np.diff(costs, prepend=-1, append=np.inf).clip(0) > 1e-6 * costs[-1]  # ties may stand in any order
    for k in np.flatnonzero(distinct[:-1] & distinct[1:]):
        assert np.array_equal(found.candidates[k], a[k])
        assert np.allclose(found.baselines[k], b[k], atol=1e-5)


@settings(max_examples=40, deadline=None)
@given(cases)
def test_both_ways_to_the_bound_agree(case):
    solution, length, _ = problem(*case)
    expanded, shrunk = (solve(*arguments(solution), length, n_best=4) for solve in (constrained_integer_least_squares, constrained_by_shrinking))
    assert np.array_equal(expanded.candidates, shrunk.candidates)
    assert np.allclose(expanded.norms, shrunk.norms, rtol=1e-9)


@settings(max_examples=40, deadline=None)
@given(cases)
def test_baselines_have_the_length_and_costs_are_theirs(case):
    solution, length, _ = problem(*case)
    found = constrained_integer_least_squares(*arguments(solution), length, n_best=3)
    assert np.allclose(np.linalg.norm(found.baselines, axis=-1), length, rtol=1e-12)
    assert np.all(np.diff(found.norms) >= 0)
    joint = np.block([[solution.Q_a, solution.Q_ba.T], [solution.Q_ba, solution.Q_b]])
    misfit = np.hstack([solution.a_hat - found.candidates, solution.b_hat - found.baselines])
    assert np.allclose(found.norms, np.vecdot(misfit, np.linalg.solve(joint, misfit.T).T), rtol=NORM)


@settings(max_examples=40, deadline=None)
@given(cases)
def test_other_integers_and_other_axes_give_the_same_answer(case):
    solution, length, rng = problem(*case)
    n, p = len(solution.a_hat), len(solution.b_hat)
    Z, shift, R = unimodular(n, rng), rng.integers(-99, 99, n), np.linalg.qr(rng.standard_normal((p, p)))[0]
    found = constrained_integer_least_squares(*arguments(solution), length)
    a, Q_a, b, Q_b, Q_ba = arguments(solution)
    mapped = constrained_integer_least_squares(Z.T @ (a + shift), Z.T @ Q_a @ Z, R @ b, R @ Q_b @ R.T, R @ Q_ba @ Z, length)
    assert np.allclose(mapped.norms, found.norms, rtol=1e-5)
    if found.ratio > 1 + 1e-4:
        assert np.array_equal(mapped.best, (found.best + shift) @ Z)
        assert np.allclose(mapped.baselines[0], R @ found.baselines[0], atol=1e-4)


@settings(max_examples=40, deadline=None)
@given(cases)
def test_more_candidates_begin_with_the_fewer(case):
    solution, length, _ = problem(*case)
    few, many = (constrained_integer_least_squares(*arguments(solution), length, n_best=n_best) for n_best in (1, 8))
    assert np.isclose(few.norms[0], many.norms[0], rtol=1e-12)


def test_exact_measurements_give_the_truth_at_no_cost(one_epoch):
    truth, b = np.array([7, -3, 40, 0, -12]), np.array([0.6, 0.0, 0.8])
    solution = fix_with_length(solve_float(one_epoch.A @ truth + one_epoch.B @ b, *one_epoch), 1.0)
    assert np.array_equal(solution.best, truth)
    assert np.allclose(solution.baselines[0], b, atol=1e-9)
    assert solution.norms[0] < 1e-12


def test_stacks_equal_one_by_one(one_epoch, rng):
    found = float_solution(one_epoch, rng, 2, 3)
    together = fix_with_length(found, 1.0)
    shapes = [array.shape for array in (together.candidates, together.norms, together.baselines, together.nodes)]
    assert shapes == [(2, 3, 2, 5), (2, 3, 2), (2, 3, 2, 3), (2, 3)]
    many = [np.broadcast_to(Q, (2, 3, *Q.shape)) for Q in (found.Q_a, found.Q_b, found.Q_ba)]
    with_many = constrained_integer_least_squares(found.a_hat, many[0], found.b_hat, many[1], many[2], 1.0)
    for index in np.ndindex(2, 3):
        alone = fix_with_length(found._replace(a_hat=found.a_hat[index], b_hat=found.b_hat[index]), 1.0)
        for whole in (together, with_many):
            assert np.array_equal(whole.candidates[index], alone.candidates)
            assert np.array_equal(whole.norms[index], alone.norms)
            assert np.array_equal(whole.baselines[index], alone.baselines)


def test_nothing_in_nothing_out(one_epoch):
    found = solve_float(np.empty((0, 10)), *one_epoch)
    assert fix_with_length(found, 1.0).candidates.shape == (0, 2, 5)


def test_a_float_solution_that_is_exact_already_is_found_at_once():
    """Its cost is zero: a bound made of it must still hold it."""
    exact = ([2.0, -1.0], np.eye(2), [1.0, 0.0, 0.0], np.eye(3), np.zeros((3, 2)), 1.0)
    for fix in (constrained_integer_least_squares, constrained_by_shrinking):
        found = fix(*exact, n_best=1)
        assert found.complete
        assert found.candidates.tolist() == [[2, -1]]
        assert found.norms == [0.0]


def test_node_limit_is_said(one_epoch, rng):
    found = float_solution(one_epoch, rng)
    cut = constrained_integer_least_squares(*arguments(found), 1.0, node_limit=7)
    assert not cut.complete
    assert cut.nodes == 7
    assert "node limit" in repr(cut)
    assert np.isinf(cut.norms[-1])
    assert np.isnan(cut.baselines[-1]).all()  # no candidate, no baseline
    assert "completely" in repr(fix_with_length(found, 1.0))


def test_a_length_in_the_float_solution_is_not_used_again(one_epoch, rng):
    found = float_solution(one_epoch, rng)
    with pytest.raises(ValueError, match="count it a second time"):
        fix_with_length(use_length(found, 1.0, 0.005), 1.0)


def test_a_length_used_twice_is_seen_by_the_joint_covariance():
    """A row of no error leaves the baseline no variance along it: nothing is left for the sphere to weigh."""
    free = FloatSolution(np.array([0.2]), np.array([0.0, 1.1]), np.eye(1), np.eye(2), np.zeros((2, 1)))
    tied = use_length(free, 1.0, 1e-9)
    with pytest.raises(ValueError, match="not positive definite together"):
        constrained_integer_least_squares(*arguments(tied), 1.0)


def test_inputs_stay_as_they_are(one_epoch):
    found = solve_float(np.arange(10.0), *one_epoch)
    for array in arguments(found):
        array.flags.writeable = False
    assert fix_with_length(found, 1.0).complete


GOOD_CALL = {"a_hat": [0.2, 0.1], "Q_a": np.eye(2), "b_hat": [1.0, 0.0, 0.0], "Q_b": np.eye(3), "Q_ba": np.zeros((3, 2)), "length": 1.0}


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"length": -1.0}, "length must be one positive number of metres; it is -1"),
        ({"length": np.nan}, "length must be"),
        ({"length": [1.0, 2.0]}, "length must be one positive number"),
        ({"b_hat": [1.0, 0.0]}, r"Q_b must have shape \(2, 2\)"),
        ({"Q_ba": np.zeros((2, 3))}, r"Q_ba must have shape \(3, 2\)"),
        ({"a_hat": [0.2]}, r"a_hat must have shape \(2,\)"),
        ({"a_hat": [0.2, np.nan]}, "a_hat contains NaN"),
        ({"Q_a": np.ones((2, 2))}, "not positive definite"),
        ({"Q_a": [[1.0, 0.5], [0.4, 1.0]]}, "not symmetric"),
        ({"Q_ba": np.full((3, 2), 0.9)}, "not positive definite together"),
        ({"Q_b": np.eye(3) + 0.1 * np.eye(3, k=1)}, "Q_b is not symmetric"),
        ({"n_best": 0}, "n_best must be a whole number"),
    ],
)
def test_bad_calls_are_explained(wrong, message):
    assert constrained_integer_least_squares(**GOOD_CALL).complete
    with pytest.raises(ValueError, match=message):
        constrained_integer_least_squares(**(GOOD_CALL | wrong))


def test_a_second_best_far_away_takes_no_long_search(rng):
    """Sigmas of a hundredth of a cycle: a second best costs thousands, the first bound holds the best only, and a neighbour tells the next one."""
    n = 12
    A = rng.standard_normal((n, n)) / n**0.5 + 2 * np.eye(n)
    Q_a, Q_ba = 1e-5 * A @ A.T, 1e-3 * rng.standard_normal((3, n)) / n
    Q_b = Q_ba @ np.linalg.solve(Q_a, Q_ba.T) + 1e-4 * np.eye(3)
    truth, b = rng.integers(-9, 9, n), np.array([0.6, 0.0, 0.8])
    floats = truth + 0.003 * rng.standard_normal(n), Q_a, b, Q_b, Q_ba, 1.0
    found, certain = constrained_integer_least_squares(*floats), constrained_by_shrinking(*floats)
    assert np.array_equal(found.best, truth)
    assert found.norms[1] > 100 * 2 * (n + 1), "many steps of the bound away"
    assert np.array_equal(found.candidates, certain.candidates)
    assert np.allclose(found.norms, certain.norms, rtol=1e-9)
    assert found.nodes < 2 * certain.nodes + 3 * n
