"""The search written down node by node: the same as the compiled one, and a tree that holds together."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from obvious import covariance

from gnsslab.core.integers import decorrelate, integer_least_squares, ltdl, search_kernel, search_tree
from gnsslab.core.integers.tree import MOST_AMBIGUITIES, Outcome, nearest_first
from gnsslab.core.jit import kernel_input

cases = st.tuples(st.integers(1, 6), st.integers(0, 2**32 - 1), st.floats(0.0, 2.5), st.integers(1, 4))  # n, seed, decades of spread, n_best
ULPS = 1e-13  # relative: the two add the same terms, and may divide and round differently in the last digit


def problem(n, seed, decades):
    rng = np.random.default_rng(seed)
    return rng.uniform(-5.0, 5.0, n), covariance(n, rng, decades)


def compiled(z_hat, L, d, n_best):
    return search_kernel(kernel_input(z_hat), kernel_input(L), kernel_input(d), n_best, 10**7)


@settings(max_examples=100, deadline=None)
@given(cases)
def test_equals_the_compiled_search_with_and_without_decorrelation(case):
    *given_by, n_best = case
    a_hat, Q = problem(*given_by)
    Z, *factors = decorrelate(Q)
    for z_hat, L, d in ((a_hat @ Z, *factors), (a_hat, *ltdl(Q))):
        tree = search_tree(z_hat, L, d, n_best)
        candidates, norms, nodes = compiled(z_hat, L, d, n_best)
        assert len(tree.nodes) == nodes
        assert tree.candidates.tolist() == np.asarray(candidates).tolist()
        np.testing.assert_allclose(tree.norms, norms, rtol=ULPS)


@settings(max_examples=60, deadline=None)
@given(cases)
def test_after_decorrelation_it_is_integer_least_squares_node_by_node(case):
    *given_by, n_best = case
    a_hat, Q = problem(*given_by)
    decorrelation = decorrelate(Q)
    tree = search_tree(a_hat @ decorrelation.Z, decorrelation.L, decorrelation.d, n_best)
    solution = integer_least_squares(a_hat, Q, n_best)
    assert len(tree.nodes) == solution.nodes
    assert decorrelation.restore(tree.candidates).tolist() == solution.candidates.tolist()
    np.testing.assert_allclose(tree.norms, solution.norms, rtol=1e-9)


@settings(max_examples=60, deadline=None)
@given(cases)
def test_each_node_follows_from_those_above_it(case):
    """The conditional value by a solve with the covariance, and the partial norm as the squared norm of the integers chosen so far."""
    *given_by, n_best = case
    a_hat, Q = problem(*given_by)
    n, tree = len(a_hat), search_tree(a_hat, *ltdl(Q), n_best)
    for k, node in enumerate(tree.nodes):
        chosen = np.array([above.integer for above in ancestry(tree.nodes, k)])  # of level, level + 1 ... n - 1
        known = slice(node.level + 1, n)
        moved = Q[node.level, known] @ np.linalg.solve(Q[known, known], a_hat[known] - chosen[1:])
        assert node.value == pytest.approx(a_hat[node.level] - moved, abs=1e-6)
        residual = a_hat[node.level :] - chosen
        assert node.norm == pytest.approx(residual @ np.linalg.solve(Q[node.level :, node.level :], residual), rel=1e-5, abs=1e-9)


def ancestry(nodes, k):
    while k >= 0:
        yield nodes[k]
        k = nodes[k].parent


@settings(max_examples=60, deadline=None)
@given(cases)
def test_outcomes_are_what_their_words_say(case):
    *given_by, n_best = case
    a_hat, Q = problem(*given_by)
    tree = search_tree(a_hat, *ltdl(Q), n_best)
    found = []
    for k, node in enumerate(tree.nodes):
        assert node.parent < k
        assert node.parent < 0 or (tree.nodes[node.parent].level == node.level + 1 and tree.nodes[node.parent].outcome == Outcome.DOWN)
        assert node.bound == (sorted(found)[n_best - 1] if len(found) >= n_best else math.inf)
        assert (node.outcome == Outcome.CUT) == (node.norm >= node.bound)
        assert node.outcome != (Outcome.DOWN if node.level == 0 else Outcome.CANDIDATE)
        found += [node.norm] * (node.outcome == Outcome.CANDIDATE)
    assert sorted(found)[:n_best] == tree.norms.tolist()
    assert tree.nodes[-1].outcome == Outcome.CUT
    assert tree.nodes[-1].level == len(a_hat) - 1  # the search ends where the top level does


def test_published_case(reference):
    case = next(case for case in reference["ils_cases"] if case["name"] == "joosten_tiberius_small_3")
    tree = search_tree(case["a_float"], *ltdl(case["Q"]), n_best=3)
    assert tree.candidates.tolist() == [best["z"] for best in case["best3"]]
    np.testing.assert_allclose(tree.norms, [best["sqnorm"] for best in case["best3"]], rtol=1e-9)


def test_decorrelation_makes_the_tree_of_a_needle_smaller():
    a_hat, Q = np.array([1.5, 1.1]), np.array([[53.4, 38.4], [38.4, 28.0]])
    Z, L, d = decorrelate(Q)
    assert len(search_tree(a_hat @ Z, L, d).nodes) < len(search_tree(a_hat, *ltdl(Q)).nodes)


@given(st.floats(-1e6, 1e6))
def test_integers_come_nearest_first(c):
    integers = [z for z, _ in zip(nearest_first(c), range(9), strict=False)]
    assert sorted(integers) == list(range(min(integers), min(integers) + 9))  # none left out
    assert np.all(np.diff(np.abs(np.array(integers) - c)) >= 0)


@pytest.mark.parametrize(
    ("z_hat", "L", "d", "n_best", "words"),
    [
        (np.zeros(13), np.eye(13), np.ones(13), 2, f"1 to {MOST_AMBIGUITIES} ambiguities"),
        ([], np.zeros((0, 0)), [], 2, "there are 0"),
        ([0.0], np.eye(2), [1.0, 1.0], 2, "must have shapes"),
        ([0.0, np.nan], np.eye(2), [1.0, 1.0], 2, "must be finite"),
        ([0.0, 0.0], np.eye(2), [1.0, 0.0], 2, "positive"),
        ([0.0, 0.0], np.eye(2), [1.0, 1.0], 0, "n_best must be a whole number"),
        ([0.0, 0.0], np.eye(2), [1.0, 1.0], 1.5, "n_best must be a whole number"),
        ([1e16, 0.0], np.eye(2), [1.0, 1.0], 2, "below 2.51 cycles"),
        ([0.0, 0.0], [[1.0, 0.5], [0.0, 1.0]], [1.0, 1.0], 2, "unit lower triangular"),
        ([0.3, 0.4], [[1.0, 0.0], [0.618, 1.0]], [1e-10, 1e4], 2, "more than 20000 nodes.*decorrelate first"),
    ],
)
def test_bad_input_is_refused_in_words(z_hat, L, d, n_best, words):
    with pytest.raises(ValueError, match=words):
        search_tree(z_hat, L, d, n_best)


def test_nothing_given_is_changed():
    z_hat, L, d = np.array([0.4, 0.2]), np.array([[1.0, 0.0], [0.5, 1.0]]), np.array([0.1, 0.4])
    for array in (z_hat, L, d):
        array.flags.writeable = False
    assert repr(search_tree(z_hat, L, d)).startswith("SearchTree: ")
