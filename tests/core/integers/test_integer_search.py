"""Integer least squares: published numbers, two obvious implementations, and what must not change the answer."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from obvious import best_by_recursion, best_in_box, covariance, unimodular

from gnsslab.core.integers import IntegerSolution, decorrelate, integer_least_squares, search_kernel
from gnsslab.core.jit import kernel_input

NORM = 1e-6  # relative: what float64 leaves of a norm where cond(Q) reaches 1e9
cases = st.tuples(st.integers(1, 9), st.integers(0, 2**32 - 1), st.floats(0.0, 5.0))  # n, seed, decades of spread


def problem(n, seed, decades=3.0):
    rng = np.random.default_rng(seed)
    return rng.uniform(-20.0, 20.0, n), covariance(n, rng, decades), rng


def test_published_cases_exactly(reference):
    assert len(reference["ils_cases"]) == 5
    for case in reference["ils_cases"]:
        solution = integer_least_squares(case["a_float"], case["Q"], n_best=3)
        assert solution.candidates.tolist() == [best["z"] for best in case["best3"]], case["name"]
        assert np.allclose(solution.norms, [best["sqnorm"] for best in case["best3"]], rtol=NORM), case["name"]
        published = case["published"]
        if published:
            assert solution.candidates[:2].tolist() == [published["fixed_best"], published["fixed_second"]], case["name"]
            assert np.allclose(solution.norms[:2], published["sqnorm"], rtol=NORM, atol=1e-6), case["name"]  # 6 decimals


@pytest.mark.parametrize("n", [1, 2, 3, 4])
def test_equals_every_point_of_a_box(n, rng):
    for _ in range(20):
        Q = covariance(n, rng, decades=1.0)
        a_hat = rng.uniform(-5, 5, n)
        expected, norms = best_in_box(a_hat, Q, 4, 5)  # norms below 4 lie within 2 sigma <= 2 cycles: inside the box
        solution = integer_least_squares(a_hat, Q, n_best=4)
        assert np.array_equal(solution.candidates, expected)
        assert np.allclose(solution.norms, norms, rtol=1e-9)


@pytest.mark.parametrize("n", [2, 5, 7])
def test_equals_the_obvious_recursion(n, rng):
    for _ in range(20):
        Q, a_hat = covariance(n, rng, decades=2.0), rng.uniform(-5, 5, n)
        solution = integer_least_squares(a_hat, Q, n_best=5)
        expected, norms = best_by_recursion(a_hat, Q, 5, solution.norms[-1])
        assert np.array_equal(solution.candidates, expected)
        assert np.allclose(solution.norms, norms, rtol=1e-9)


@settings(max_examples=60, deadline=None)
@given(cases)
def test_norms_are_those_of_the_candidates_and_in_order(case):
    a_hat, Q, _ = problem(*case)
    solution = integer_least_squares(a_hat, Q, n_best=6)
    residual = a_hat - solution.candidates
    assert np.allclose(solution.norms, np.einsum("ki,ki->k", residual, np.linalg.solve(Q, residual.T).T), rtol=NORM)
    assert np.all(np.diff(solution.norms) >= 0)
    assert len({tuple(candidate) for candidate in solution.candidates}) == 6


@settings(max_examples=60, deadline=None)
@given(cases)
def test_more_candidates_begin_with_the_fewer(case):
    a_hat, Q, _ = problem(*case)
    few, many = integer_least_squares(a_hat, Q, n_best=1), integer_least_squares(a_hat, Q, n_best=20)
    assert np.array_equal(few.candidates, many.candidates[:1])


@settings(max_examples=60, deadline=None)
@given(cases)
def test_integer_shift_shifts_the_answer(case):
    a_hat, Q, rng = problem(*case)
    shift = rng.integers(-50, 50, len(a_hat))
    solution, shifted = integer_least_squares(a_hat, Q), integer_least_squares(a_hat + shift, Q)
    assert np.array_equal(shifted.candidates, solution.candidates + shift)


@settings(max_examples=60, deadline=None)
@given(cases)
def test_unimodular_map_maps_the_answer(case):
    a_hat, Q, rng = problem(*case)
    Z = unimodular(len(a_hat), rng)
    solution, mapped = integer_least_squares(a_hat, Q), integer_least_squares(Z.T @ a_hat, Z.T @ Q @ Z)
    assert np.array_equal(mapped.candidates, solution.candidates @ Z)
    assert np.allclose(mapped.norms, solution.norms, rtol=1e-5)  # Z'QZ loses up to five digits of Q


@settings(max_examples=60, deadline=None)
@given(cases, st.integers(-(10**8), 10**8))
def test_units_of_the_covariance_do_not_matter(case, power):
    a_hat, Q, _ = problem(*case)
    scale = 2.0 ** (power // 10**7)
    plain, scaled = integer_least_squares(a_hat, Q), integer_least_squares(a_hat, scale * Q)
    assert np.array_equal(plain.candidates, scaled.candidates)
    assert np.allclose(plain.norms, scale * scaled.norms, rtol=1e-12)


def test_an_integer_float_vector_is_its_own_answer():
    solution = integer_least_squares([3.0, -7.0, 1e8], np.eye(3), n_best=1)
    assert solution.best.tolist() == [3, -7, 100_000_000]
    assert solution.norms.tolist() == [0.0]


def test_a_hundred_million_cycles_cost_nothing(rng):
    Q = covariance(8, rng)
    small = rng.integers(-8, 8, 8) / 16.0  # exact in float64, also on top of 2^40
    large = 2**40 + rng.integers(0, 10**8, 8)
    near, far = integer_least_squares(small, Q), integer_least_squares(small + large, Q)
    assert np.array_equal(far.candidates - large, near.candidates)
    assert np.array_equal(far.norms, near.norms)


def test_one_covariance_for_many_floats_equals_one_by_one(rng):
    Q, a_hat = covariance(6, rng), rng.uniform(-9, 9, (4, 5, 6))
    together = integer_least_squares(a_hat, Q, n_best=3)
    assert together.candidates.shape == (4, 5, 3, 6)
    assert together.norms.shape == (4, 5, 3)
    assert together.nodes.shape == together.complete.shape == (4, 5)
    for index in np.ndindex(4, 5):
        alone = integer_least_squares(a_hat[index], Q, n_best=3)
        assert np.array_equal(together.candidates[index], alone.candidates)
        assert np.array_equal(together.norms[index], alone.norms)


def test_stack_of_covariances_broadcasts(rng):
    Q, a_hat = np.array([covariance(4, rng) for _ in range(3)]), rng.uniform(-9, 9, (2, 1, 4))
    together = integer_least_squares(a_hat, Q)
    assert together.candidates.shape == (2, 3, 2, 4)
    for i, k in np.ndindex(2, 3):
        assert np.array_equal(together.candidates[i, k], integer_least_squares(a_hat[i, 0], Q[k]).candidates)


def test_nothing_in_nothing_out():
    solution = integer_least_squares(np.empty((0, 3)), np.eye(3))
    assert solution.candidates.shape == (0, 2, 3)
    assert integer_least_squares(np.empty((0, 3)), np.empty((0, 3, 3))).norms.shape == (0, 2)


def test_one_ambiguity():
    solution = integer_least_squares([2.4], [[0.25]], n_best=4)
    assert solution.candidates.ravel().tolist() == [2, 3, 1, 4]
    assert np.allclose(solution.norms, np.array([0.4, 0.6, 1.4, 1.6]) ** 2 / 0.25)


def test_sixty_ambiguities_a_trillion_wide(rng):
    basis = np.linalg.qr(rng.standard_normal((60, 60)))[0]
    Q = basis @ np.diag(np.geomspace(1e-8, 1e4, 60)) @ basis.T  # condition 1e12
    Q = (Q + Q.T) / 2
    truth = rng.integers(-1000, 1000, 60)
    a_hat = truth + 0.1 * np.linalg.cholesky(Q) @ rng.standard_normal(60)
    solution = integer_least_squares(a_hat, Q, n_best=1)  # the second best of such a random lattice takes hours, in any program
    assert solution.complete
    assert np.array_equal(solution.best, truth)


def test_node_limit_is_said(rng):
    Q, a_hat = covariance(10, rng), rng.uniform(-9, 9, 10)
    proved, cut = integer_least_squares(a_hat, Q), integer_least_squares(a_hat, Q, node_limit=11)
    assert proved.complete
    assert proved.nodes > 11
    assert not cut.complete
    assert cut.nodes == 11
    assert "node limit" in repr(cut)
    assert "completely" in repr(proved)
    nothing = integer_least_squares(a_hat, Q, node_limit=3)  # ten levels cannot be passed in three nodes
    assert np.all(np.isinf(nothing.norms))


def test_first_candidate_alone_is_bootstrapping(rng):
    """After n nodes the search has rounded one variable after the other: bootstrapping."""
    Q, a_hat = covariance(6, rng), rng.uniform(-9, 9, 6)
    Z, L, d = decorrelate(Q)
    candidates, norms, nodes = search_kernel(kernel_input(Z.T @ a_hat), kernel_input(L), kernel_input(d), 1, 6)
    z, z_hat = np.zeros(6), Z.T @ a_hat
    for k in range(5, -1, -1):
        z[k] = np.rint(z_hat[k])
        z_hat[:k] -= L[k, :k] * (z_hat[k] - z[k])
    assert np.array_equal(np.asarray(candidates)[0], z)
    assert nodes == 6
    assert np.isclose(norms[0], np.sum((z_hat - z) ** 2 / d))


def test_ratio_is_second_over_best():
    assert np.isclose(integer_least_squares([0.1], [[1.0]]).ratio, 81.0)  # 0.9^2 / 0.1^2


def test_inputs_stay_as_they_are(rng):
    Q, a_hat = covariance(5, rng), rng.uniform(-9, 9, 5)
    copies = Q.copy(), a_hat.copy()
    Q.flags.writeable = a_hat.flags.writeable = False
    assert isinstance(integer_least_squares(a_hat, Q), IntegerSolution)
    assert np.array_equal(Q, copies[0])
    assert np.array_equal(a_hat, copies[1])
    fortran = np.asfortranarray(Q)
    assert np.array_equal(integer_least_squares(a_hat[::-1], fortran).candidates, integer_least_squares(a_hat[::-1].copy(), Q).candidates)


BAD_CALLS = [
    (([0.1, 0.2], [[1.0, 0.5], [0.4, 1.0]]), "Q is not symmetric"),
    (([0.1, 0.2], [[1.0, 2.0], [2.0, 1.0]]), "Q is not positive definite"),
    (([0.1, 0.2], [[1.0, 1.0], [1.0, 1.0]]), "Q is not positive definite"),
    (([0.1], [[0.0]]), "Q is not positive definite"),
    (([0.1, 0.2], [[1.0, np.nan], [np.nan, 1.0]]), "Q contains NaN or infinity"),
    (([0.1, 0.2], [[np.inf, 0.0], [0.0, 1.0]]), "Q contains NaN or infinity"),
    (([[0.1]] * 3, [[[1.0]], [[1.0]], [[-1.0]]]), r"Q\[2\] is not positive definite"),
    (([], np.empty((0, 0))), r"with n >= 1; it has shape \(0, 0\)"),
    (([0.1, 0.2], [1.0, 2.0]), r"Q must be a covariance matrix of shape \(n, n\).*it has shape \(2,\)"),
    (([0.1, 0.2], np.ones((2, 3))), r"it has shape \(2, 3\)"),
    (([0.1, 0.2, 0.3], np.eye(2)), r"one value for each row of Q, 2, in its last axis; it has shape \(3,\)"),
    ((0.5, np.eye(1)), r"it has shape \(\)"),
    ((np.zeros((3, 2)), np.ones((2, 2, 2)) + np.eye(2)), "do not fit: one Q, or one for each a_hat"),
    (([np.nan, 0.2], np.eye(2)), "a_hat contains NaN or infinity"),
    (([np.inf, 0.2], np.eye(2)), "a_hat contains NaN or infinity"),
    (([1e16, 0.2], np.eye(2)), r"2\^51 cycles or more"),
    (([0.1], [[1.0]], 0), "n_best must be a whole number, 1 or more; it is 0"),
    (([0.1], [[1.0]], 1.5), "n_best must be a whole number"),
    (([0.1, 0.2], [[1e40, 1e20], [1e20, 2.0]]), "mixes variances too different"),
]


@pytest.mark.parametrize(("call", "message"), BAD_CALLS)
def test_bad_calls_are_explained(call, message):
    with pytest.raises(ValueError, match=message):
        integer_least_squares(*call)


def test_bad_node_limit_is_explained():
    with pytest.raises(ValueError, match="node_limit must be a whole number, 1 or more; it is 0"):
        integer_least_squares([0.1], [[1.0]], node_limit=0)


def test_rounding_asymmetry_is_forgiven(rng):
    Q = covariance(6, rng)
    assert integer_least_squares(np.full(6, 0.3), Q * (1 + 1e-13 * rng.standard_normal((6, 6)))).complete


def test_counts_too_large_are_explained():
    with pytest.raises(ValueError, match="n_best must be no more than 10000; it is 10001"):
        integer_least_squares([0.1], [[1.0]], 10_001)
    with pytest.raises(ValueError, match="node_limit must be no more than"):
        integer_least_squares([0.1], [[1.0]], node_limit=10**30)
    with pytest.raises(ValueError, match="node_limit must be a whole number"):
        integer_least_squares([0.1], [[1.0]], node_limit=np.inf)


def test_one_vector_has_no_ratio():
    with pytest.raises(ValueError, match="n_best=2 or more"):
        _ = integer_least_squares([0.1], [[1.0]], 1).ratio
