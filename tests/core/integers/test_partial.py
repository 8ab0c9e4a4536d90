"""Partial fixing: its two ends, the same by other ways, and counted successes."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from obvious import covariance

from gnsslab.core.integers import (
    adop,
    decorrelate,
    fix_accepted_subset,
    fix_combinations,
    fix_most_certain,
    fix_subset,
    given_combinations,
    integer_least_squares,
    ratio_test,
    simulate_fixes,
    success_rate,
)
from gnsslab.core.mixed_model import FloatSolution, given_integers

SIGMAS = 4.5  # of a binomial count: seven in a million by chance
cases = st.tuples(st.integers(1, 8), st.integers(0, 2**32 - 1), st.floats(0.05, 0.5), st.floats(0.5, 1.0))  # n, seed, ADOP, rate


def problem(n, seed, cycles=0.3, decades=3.0):
    rng = np.random.default_rng(seed)
    Q = covariance(n, rng, decades)
    return rng.uniform(-20.0, 20.0, n), Q * (cycles / adop(Q)) ** 2, rng


def float_solution(n, seed, p=3):
    """A FloatSolution of n ambiguities and p real unknowns, correlated as one covariance of all."""
    rng = np.random.default_rng(seed)
    Q = 0.1 * covariance(n + p, rng, decades=1.5)
    x = rng.uniform(-5, 5, n + p)
    return FloatSolution(x[:n], x[n:], Q[:n, :n], Q[n:, n:], Q[n:, :n])


def measured(x, Q, H, y):
    """Estimate x with covariance Q and exact measurements y = H x, taken in one after the other."""
    for h, value in zip(H, y, strict=True):
        gain = Q @ h / (h @ Q @ h)
        x, Q = x + gain * (value - h @ x), Q - np.outer(gain, Q @ h)
    return x, Q


@settings(max_examples=60, deadline=None)
@given(cases)
def test_fixes_as_many_as_reach_the_rate(case):
    n, seed, cycles, rate = case
    a_hat, Q, _ = problem(n, seed, cycles)
    found = fix_most_certain(a_hat, Q, rate)
    d = decorrelate(Q).d
    chance = [np.prod([success_rate([[d_i]]) for d_i in d[n - k :]]) for k in range(n + 1)]
    assert chance[found.fixed] >= rate
    assert found.fixed == n or chance[found.fixed + 1] < rate
    assert np.isclose(found.success_rate, chance[found.fixed], rtol=1e-12)
    assert f"{found.fixed} of {n} fixed" in repr(found)


@settings(max_examples=60, deadline=None)
@given(cases)
def test_the_rest_is_conditioned_on_what_is_fixed(case):
    """Second way: the fixed combinations as exact measurements of the float vector, one after the other."""
    n, seed, cycles, rate = case
    a_hat, Q, _ = problem(n, seed, cycles, decades=1.5)
    found = fix_most_certain(a_hat, Q, rate)
    assert np.allclose(found.C.T @ found.a, found.z, rtol=0, atol=1e-7)
    a, Q_a = measured(a_hat, Q, found.C.T, found.z)
    assert np.allclose(found.a, a, rtol=0, atol=1e-8)
    assert np.allclose(found.Q_a, Q_a, rtol=0, atol=1e-8)
    assert np.array_equal(found.Q_a, found.Q_a.T)


def test_nothing_fixed_is_the_float_solution():
    a_hat, Q, _ = problem(4, 1, cycles=3.0)
    for found in (fix_most_certain(a_hat, Q), fix_subset(a_hat, Q), fix_accepted_subset(a_hat, Q, lambda found: False)):
        assert found.fixed == 0
        assert found.success_rate == 1.0
        assert np.array_equal(found.a, a_hat)
        assert np.array_equal(found.Q_a, Q)
        assert (found.C.shape, found.z.shape, found.norms.shape) == ((4, 0), (0,), (0,))
        assert not np.shares_memory(found.a, a_hat)


def test_everything_fixed_is_integer_least_squares():
    a_hat, Q, _ = problem(4, 1, cycles=0.05)
    best = integer_least_squares(a_hat, Q).best
    for found in (fix_most_certain(a_hat, Q, 0.9), fix_subset(a_hat, Q, 0.9), fix_accepted_subset(a_hat, Q, lambda found: True)):
        assert found.fixed == 4
        assert np.allclose(found.a, best, rtol=0, atol=1e-9)
        assert np.allclose(found.Q_a, 0.0, atol=1e-12)
    assert fix_most_certain(a_hat, 100 * Q, success_rate=0.0).fixed == 4  # no chance is too small


def test_one_ambiguity():
    fixed, kept = fix_most_certain([2.2], [[0.01]]), fix_most_certain([2.2], [[0.09]])
    assert (fixed.a.tolist(), fixed.fixed) == ([2.0], 1)
    assert (kept.a.tolist(), kept.fixed) == ([2.2], 0)


@pytest.mark.parametrize("rate", [0.9, 0.97])
def test_the_promised_rate_is_kept_and_the_errors_are_those_of_q(rate, rng):
    _, Q, _ = problem(6, 11, cycles=0.22)
    fixes = simulate_fixes(Q, rng, 20_000)  # the true integers are zero
    found = fix_most_certain(fixes.a_hat, Q, rate)
    right = np.all(found.z == 0, axis=-1)
    assert 0 < found.fixed < 6
    assert right.mean() > rate - SIGMAS * np.sqrt(rate * (1 - rate) / len(right))
    direction = np.linalg.eigh(found.Q_a)[1][:, -1]  # where the remaining error is largest
    error, sigma = fixes.a_hat @ direction, np.sqrt(direction @ found.Q_a @ direction)
    given_truth = fix_combinations(fixes.a_hat[right], Q, found.C).a @ direction
    assert abs(np.std(given_truth) / sigma - 1) < 0.05
    assert sigma < 0.99 * np.std(error)


@pytest.mark.parametrize("k", [1, 2, 3, 4])
def test_real_unknowns_follow(k):
    """b by the fixed combinations, by the partly fixed ambiguities, and as exact measurements of (a, b)."""
    solution = float_solution(5, k)
    found = fix_combinations(solution.a_hat, solution.Q_a, decorrelate(solution.Q_a).Z[:, 5 - k :])
    b, Q_b = given_combinations(solution, found.C, found.z)
    assert np.allclose(b, given_integers(solution, found.a)[0], rtol=0, atol=1e-9)
    Q = np.block([[solution.Q_a, solution.Q_ba.T], [solution.Q_ba, solution.Q_b]])
    H = np.hstack([found.C.T, np.zeros((k, 3))])
    x, Q_x = measured(np.concatenate([solution.a_hat, solution.b_hat]), Q, H, found.z)
    assert np.allclose(b, x[5:], rtol=0, atol=1e-9)
    assert np.allclose(Q_b, Q_x[5:, 5:], rtol=0, atol=1e-9)


def test_real_unknowns_at_the_two_ends():
    solution = float_solution(4, 2)
    b, Q_b = given_combinations(solution, np.eye(4, dtype=int), [1, 2, 3, 4])
    expected, Q_expected = given_integers(solution, [1, 2, 3, 4])
    assert np.allclose(b, expected, rtol=0, atol=1e-12)
    assert np.allclose(Q_b, Q_expected, rtol=0, atol=1e-12)
    b, Q_b = given_combinations(solution, np.empty((4, 0), dtype=int), [])
    assert np.array_equal(b, solution.b_hat)
    assert np.array_equal(Q_b, solution.Q_b)


def test_each_combination_more_improves_all_others():
    solution = float_solution(6, 4)
    Z = decorrelate(solution.Q_a).Z
    z = integer_least_squares(solution.a_hat, solution.Q_a).best @ Z
    before = solution.Q_b
    for k in range(1, 7):
        _, Q_b = given_combinations(solution, Z[:, 6 - k :], z[6 - k :])
        assert np.all(np.linalg.eigvalsh(before - Q_b) > -1e-12)
        before = Q_b


def test_subset_leaves_out_the_worst_first():
    Q = np.diag([0.04, 0.0004, 0.01, 0.36])
    found = fix_subset([0.3, 1.1, 2.2, 3.4], Q, 0.999)
    assert found.C.T.tolist() == [[0, 1, 0, 0], [0, 0, 1, 0]]  # sigma 0.2 fails in 1.2 %, sigma 0.1 in 6e-7
    assert found.z.tolist() == [1, 2]
    assert found.a.tolist() == [0.3, 1.0, 2.0, 3.4]  # nothing correlated, nothing gained


def test_subset_is_the_largest_in_the_order_given(rng):
    for seed in range(10):
        a_hat, Q, rng = problem(6, seed, cycles=0.25)
        order = rng.permutation(6)
        found = fix_subset(a_hat, Q, 0.95, leave_out=order)
        rates = [success_rate(Q[np.ix_(kept, kept)]) for kept in (np.sort(order[k:]) for k in range(6))]
        left_out = next((k for k, rate in enumerate(rates) if rate >= 0.95), 6)
        assert found.fixed == 6 - left_out
        assert np.flatnonzero(found.C.any(axis=1)).tolist() == sorted(order[left_out:])
        assert np.isclose(found.success_rate, [*rates, 1.0][left_out])


def test_a_satellite_leaves_with_all_its_ambiguities():
    """Two frequencies of three satellites: ambiguities k and k + 3 are of one satellite."""
    Q = np.diag([0.0004, 0.09, 0.0004, 0.0004, 0.0004, 0.0004])
    found = fix_subset(np.full(6, 0.1), Q, 0.999, leave_out=[[1, 4], [0, 3], [2, 5]])
    assert np.flatnonzero(found.C.any(axis=1)).tolist() == [0, 2, 3, 5]
    everything = fix_subset(np.full(6, 0.1), 100 * Q, 0.999, leave_out=[[1, 4]])  # the order ends before the rate is reached
    assert everything.fixed == 0


def test_accepted_subset_is_the_first_that_passes():
    passed = 0
    for seed in range(20):
        a_hat, Q, _ = problem(5, seed, cycles=0.25)
        order = np.argsort(-np.diag(Q))
        found = fix_accepted_subset(a_hat, Q, lambda found: ratio_test(found.norms, 3.0))
        for kept in (np.sort(order[k:]) for k in range(5)):
            solution = integer_least_squares(a_hat[kept], Q[np.ix_(kept, kept)])
            if solution.ratio >= 3.0:
                passed += len(kept) < 5
                assert found.fixed == len(kept)
                assert np.array_equal(found.z, solution.best)
                assert np.allclose(found.a[kept], solution.best, rtol=0, atol=1e-9)
                break
        else:
            assert found.fixed == 0
    assert passed > 3  # else the first subset always passed, or none


def test_shift_by_integers_and_large_integers():
    a_hat, Q, rng = problem(5, 7)
    shift = rng.integers(-(10**8), 10**8, 5)
    found, shifted = fix_most_certain(a_hat, Q, 0.9), fix_most_certain(a_hat + shift, Q, 0.9)
    assert np.array_equal(shifted.z, found.z + shift @ found.C)
    assert np.allclose(shifted.a - shift, found.a, rtol=0, atol=1e-6)


def test_stack_equals_one_by_one(rng):
    a_hat, Q, _ = problem(4, 3)
    stack = a_hat + rng.uniform(-9, 9, (2, 3, 4))
    stack.flags.writeable = Q.flags.writeable = False
    for fix in (fix_most_certain, fix_subset):
        together = fix(stack, Q, 0.9)
        assert 0 < together.fixed < 4
        assert together.a.shape == (2, 3, 4)
        assert together.norms.shape == (2, 3, 2)
        for index in itertools.product(range(2), range(3)):
            alone = fix(stack[index], Q, 0.9)
            assert np.array_equal(together.z[index], alone.z)
            assert np.allclose(together.a[index], alone.a, rtol=0, atol=1e-12)
        assert fix(np.empty((0, 4)), Q).a.shape == (0, 4)


BAD_CALLS = [
    (fix_most_certain, ([0.1, 0.2], [[1.0, 2.0], [2.0, 1.0]]), "Q is not positive definite"),
    (fix_most_certain, ([0.1, np.nan], np.eye(2) / 1e4), "a_hat contains NaN"),
    (fix_most_certain, ([0.1, 0.2, 0.3], np.eye(2)), "one value for each row of Q, 2"),
    (fix_most_certain, ([0.1, 0.2], np.ones((3, 2, 2))), "one covariance matrix"),
    (fix_most_certain, ([0.1], [[1.0]], 99.9), "success_rate is a probability between 0 and 1; it is 99.9"),
    (fix_subset, ([0.1], [[1.0]], -0.1), "between 0 and 1; it is -0.1"),
    (fix_subset, ([0.1, 0.2], np.eye(2), 0.9, [2]), r"indices of ambiguities, 0 to 1, or groups of them; it holds \[2\]"),
    (fix_subset, ([0.1, 0.2], np.eye(2), 0.9, [0.5]), r"it holds \[0.5\]"),
    (fix_subset, ([0.1, 0.2], np.eye(2), 0.9, 1), r"leave_out must be a list.*\[1\] leaves out one"),
    (fix_most_certain, ([0.1, np.nan], 100 * np.eye(2)), "a_hat contains NaN"),  # also where nothing is fixed
    (fix_accepted_subset, ([[0.1, 0.2]], np.eye(2), bool), "one float vector"),
    (fix_accepted_subset, ([0.1, 0.2], [[1.0, 0.5], [0.4, 1.0]], lambda found: True), "Q is not symmetric"),
    (fix_combinations, ([0.1, 0.2], [[1.0, 2.0], [2.0, 1.0]], [[1], [0]]), "Q is not positive definite"),
    (fix_combinations, ([0.1, 0.2], np.eye(2), [[1.0], [0.5]]), "C must be integers.*type float64"),
    (fix_combinations, ([0.1, 0.2], np.eye(2), [[1]]), r"a row for each of the 2 ambiguities; it has shape \(1, 1\)"),
    (fix_combinations, ([0.1, 0.2], np.eye(2), [[1, 2], [1, 2]]), "not positive definite"),
]


FLOAT = FloatSolution(np.array([0.3, 0.4]), np.ones(3), np.eye(2), np.eye(3), np.zeros((3, 2)))


@pytest.mark.parametrize(
    ("C", "z", "message"),
    [
        (np.eye(3, dtype=int), [1, 2, 3], "a row for each of the 2 ambiguities"),
        ([[1], [0]], [1, 2], "each of the 1 combinations"),
        ([[1, 1], [0, 0]], [1, 1], "singular"),
    ],
)
def test_combinations_that_do_not_fit_are_explained(C, z, message):
    with pytest.raises(ValueError, match=message):
        given_combinations(FLOAT, C, z)


@pytest.mark.parametrize(("function", "call", "message"), BAD_CALLS)
def test_bad_calls_are_explained(function, call, message):
    with pytest.raises(ValueError, match=message):
        function(*call)
