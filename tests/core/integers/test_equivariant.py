"""Best integer equivariant estimation: every integer vector of a box, the two ends it lies between, and the published gain."""

import itertools
import json
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from obvious import covariance, unimodular

from gnsslab.core.integers import adop, best_integer_equivariant, integer_least_squares, simulate_fixes
from gnsslab.core.mixed_model import FloatSolution, given_integers

PUBLISHED = json.loads((Path(__file__).parents[2] / "reference" / "equivariant.json").read_text())
cases = st.tuples(st.integers(1, 5), st.integers(0, 2**32 - 1), st.floats(0.05, 0.6))  # n, seed, ADOP


def problem(n, seed, cycles):
    """A float vector, a covariance with this ADOP, and the generator."""
    rng = np.random.default_rng(seed)
    Q = covariance(n, rng, decades=2.0)
    return rng.uniform(-20.0, 20.0, n), Q * (cycles / adop(Q)) ** 2, rng


def mean_of_a_box(a_hat, Q, half_width):
    """Return the weighted mean of all points of a box, and the greatest weight."""
    sides = [range(-half_width, half_width + 1)] * len(a_hat)
    points = np.array(list(itertools.product(*sides))) + np.rint(a_hat)
    residual = a_hat - points
    norms = np.einsum("pi,pi->p", residual, np.linalg.solve(Q, residual.T).T)
    weights = np.exp((norms.min() - norms) / 2)
    weights /= weights.sum()
    return weights @ points, weights.max()


@pytest.mark.parametrize(("n", "half_width"), [(1, 40), (2, 30), (3, 20), (4, 11)])
@pytest.mark.parametrize("variance", [0.02, 0.3, 1.0, 1.8])
def test_equals_the_mean_of_all_points_of_a_box(n, half_width, variance, rng):
    """At variance 1 and 1.8 some or all variables are summed as integrals; 8 sigma stay inside the box."""
    Q, a_hat = variance * covariance(n, rng, decades=1.0), rng.uniform(-5, 5, n)
    found = best_integer_equivariant(a_hat, Q, neglected=1e-12)
    expected, greatest = mean_of_a_box(a_hat, Q, half_width)
    assert np.allclose(found.a, expected, rtol=0, atol=1e-10)
    assert np.isclose(found.greatest_weight, greatest, rtol=1e-9)
    assert found.complete


@pytest.mark.parametrize("neglected", [1e-2, 1e-4, 1e-8])
@pytest.mark.parametrize("cycles", [0.2, 0.4, 0.6])
def test_no_more_is_neglected_than_said(neglected, cycles, rng):
    """The weights found are those of the whole sum, up to the bound: seen in the share of the nearest vector."""
    for seed in range(20):
        a_hat, Q, _ = problem(4, seed, cycles)
        coarse, fine = best_integer_equivariant(a_hat, Q, neglected=neglected), best_integer_equivariant(a_hat, Q, neglected=1e-14)
        assert coarse.complete
        assert coarse.neglected <= neglected
        assert 1 - fine.greatest_weight / coarse.greatest_weight <= coarse.neglected + 1e-12


@settings(max_examples=60, deadline=None)
@given(cases)
def test_integer_shift_shifts_the_mean(case):
    a_hat, Q, rng = problem(*case)
    shift = rng.integers(-(10**6), 10**6, len(a_hat))
    a, shifted = best_integer_equivariant(a_hat, Q).a, best_integer_equivariant(a_hat + shift, Q).a
    assert np.allclose(shifted - shift, a, rtol=0, atol=1e-6)  # what the bound leaves out may differ by a tie in rounding


@settings(max_examples=60, deadline=None)
@given(cases)
def test_unimodular_map_maps_the_mean(case):
    a_hat, Q, rng = problem(*case)
    Z = unimodular(len(a_hat), rng)
    a = best_integer_equivariant(a_hat, Q, neglected=1e-12).a
    mapped = best_integer_equivariant(Z.T @ a_hat, Z.T @ Q @ Z, neglected=1e-12).a
    assert np.allclose(mapped, Z.T @ a, rtol=1e-6, atol=1e-6)


@settings(max_examples=60, deadline=None)
@given(cases)
def test_mirror_image_and_the_middle_between_integers(case):
    a_hat, Q, rng = problem(*case)
    assert np.allclose(best_integer_equivariant(-a_hat, Q).a, -best_integer_equivariant(a_hat, Q).a, rtol=0, atol=1e-9)
    middle = rng.integers(-9, 9, len(a_hat)) / 2.0  # a point of symmetry of the integers
    assert np.allclose(best_integer_equivariant(middle, Q, neglected=1e-12).a, middle, rtol=0, atol=1e-9)


@pytest.mark.parametrize("n", [1, 3, 8])
def test_precise_data_give_the_fix_and_poor_data_the_float_solution(n, rng):
    Q = covariance(n, rng, decades=1.0)
    Q *= 1.0 / adop(Q) ** 2
    a_hat = rng.integers(-9, 9, n) + rng.uniform(-0.3, 0.3, n)
    precise, poor = best_integer_equivariant(a_hat, 1e-6 * Q), best_integer_equivariant(a_hat, 100.0 * Q)
    assert np.allclose(precise.a, integer_least_squares(a_hat, Q * 1e-6).best, rtol=0, atol=1e-6)
    assert precise.greatest_weight > 1 - 1e-6
    assert np.allclose(poor.a, a_hat, rtol=0, atol=1e-6)
    assert poor.greatest_weight < 0.1
    assert poor.integers == 1  # nothing was counted: all variables are integrals


@pytest.mark.parametrize("cycles", [0.2, 0.35, 0.5])
def test_mean_squared_error_is_no_greater_than_of_fix_and_float(cycles, rng):
    _, Q, _ = problem(4, 5, cycles)
    fixes = simulate_fixes(Q, rng, 20_000)
    metric = np.linalg.inv(Q)
    estimates = {"float": fixes.a_hat, "fixed": fixes.best, "mean": best_integer_equivariant(fixes.a_hat, Q).a}  # of the same samples
    squared = {name: np.einsum("ki,ij,kj->k", a, metric, a) for name, a in estimates.items()}  # float: n on average
    for other in ("float", "fixed"):
        gain = squared[other] - squared["mean"]
        assert gain.mean() > 4 * gain.std() / math.sqrt(len(gain))


def test_published_gain_of_the_baseline(rng):
    """LAMBDA 4.0, example 3: squared error of the baseline, 0.903 of the float one; fixed by least squares 1.231."""
    Q_a, Q_ba, Q_b = (np.array(PUBLISHED[name]) for name in ("Q_a", "Q_ba", "Q_b"))
    samples = 40_000
    factor = np.linalg.cholesky(np.block([[Q_a, Q_ba.T], [Q_ba, Q_b]]))
    a_hat, b_hat = np.split(rng.standard_normal((samples, 8)) @ factor.T, [5], axis=1)
    solution = FloatSolution(a_hat, b_hat, Q_a, Q_b, Q_ba)
    found = {
        "mse_equivariant_over_float": best_integer_equivariant(a_hat, Q_a).a,
        "mse_least_squares_over_float": integer_least_squares(a_hat, Q_a, n_best=1).best,
    }
    float_error = np.sum(b_hat**2, axis=1)
    for name, a in found.items():
        error = np.sum(given_integers(solution, a)[0] ** 2, axis=1)
        ratio = error.mean() / float_error.mean()
        sigma = np.std(error - ratio * float_error) / float_error.mean()  # of one sample, to first order
        assert abs(ratio - PUBLISHED[name]) < 0.0005 + 4 * sigma * math.sqrt(1 / samples + 1 / PUBLISHED["samples"]), name
        assert sigma * math.sqrt(1 / samples) < 0.01  # else it would say nothing
    assert found["mse_equivariant_over_float"].shape == a_hat.shape


def test_one_ambiguity_by_hand():
    found = best_integer_equivariant([2.25], [[0.09]])
    weights = {z: math.exp(-((2.25 - z) ** 2) / 0.18) for z in range(-3, 8)}
    assert np.isclose(found.a[0], sum(z * w for z, w in weights.items()) / sum(weights.values()), rtol=0, atol=1e-6)
    assert np.isclose(found.greatest_weight, weights[2] / sum(weights.values()), rtol=1e-6)


def test_the_limit_is_said_and_the_nearest_still_counts(rng):
    a_hat, Q, _ = problem(6, 3, 0.5)
    cut, one, whole = (best_integer_equivariant(a_hat, Q, most_integers=most) for most in (200, 1, 1_000_000))
    assert whole.complete
    assert not cut.complete
    assert 20 < cut.integers < 2000  # about 200
    assert "1 cut short" in repr(cut)
    assert "all complete" in repr(whole)
    assert 1 <= one.integers < 10  # the nearest, and who is hardly farther
    assert cut.neglected < one.neglected <= 1


def test_ends_where_the_nearest_vector_cannot_be_found():
    """60 ambiguities half way between integers have 2^60 nearest vectors: nobody can sum or find them."""
    Q, a_hat = 0.01 * np.eye(60), np.full((2, 60), 0.5)
    a_hat[1] = 3.0
    found = best_integer_equivariant(a_hat, Q)
    assert found.complete.tolist() == [False, True]
    assert found.neglected[0] == 1
    assert np.isnan(found.greatest_weight[0])
    assert np.isin(found.a[0], (0.0, 1.0)).all()  # one of them
    assert np.allclose(found.a[1], 3.0, rtol=0, atol=1e-3)
    assert np.allclose(best_integer_equivariant(a_hat, 100 * np.eye(60)).a, a_hat, rtol=0, atol=1e-6)  # integrals need no search


def test_stack_equals_one_by_one(rng):
    a_hat, Q, _ = problem(3, 8, 0.3)
    stack = a_hat + rng.uniform(-3, 3, (4, 5, 3))
    stack.flags.writeable = Q.flags.writeable = False
    together = best_integer_equivariant(stack, Q)
    assert together.a.shape == (4, 5, 3)
    assert together.integers.shape == together.greatest_weight.shape == together.complete.shape == (4, 5)
    for index in np.ndindex(4, 5):
        alone = best_integer_equivariant(stack[index], Q)
        assert np.allclose(together.a[index], alone.a, rtol=0, atol=1e-13)
        assert together.integers[index] == alone.integers
    assert best_integer_equivariant(np.empty((0, 3)), Q).a.shape == (0, 3)


BAD_CALLS = [
    (([0.1, 0.2], [[1.0, 0.5], [0.4, 1.0]]), {}, "Q is not symmetric"),
    (([0.1, 0.2], [[1.0, 2.0], [2.0, 1.0]]), {}, "Q is not positive definite"),
    (([0.1, np.nan], np.eye(2)), {}, "a_hat contains NaN"),
    (([0.1, 0.2, 0.3], np.eye(2)), {}, "one value for each row of Q, 2"),
    (([0.1, 0.2], np.ones((3, 2, 2))), {}, "one covariance matrix"),
    (([0.1], [[1.0]]), {"neglected": 0.0}, "neglected is a share of the weight.*it is 0"),
    (([0.1], [[1.0]]), {"neglected": 1.0}, "it is 1"),
    (([0.1], [[1.0]]), {"most_integers": 0}, "most_integers must be 1 or more; it is 0"),
]


@pytest.mark.parametrize(("call", "options", "message"), BAD_CALLS)
def test_bad_calls_are_explained(call, options, message):
    with pytest.raises(ValueError, match=message):
        best_integer_equivariant(*call, **options)
