"""Success rate, ADOP and bounds: published values, closed forms, the same by geometry, and fixes counted."""

import itertools
import json
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from obvious import covariance, unimodular
from scipy.stats import binom

from gnsslab.core.integers import (
    adop,
    adop_success_rate,
    decorrelate,
    integer_bootstrapping,
    integer_least_squares,
    integer_rounding,
    simulate_success,
    success_bounds,
    success_rate,
)
from gnsslab.core.integers.simulation import wilson_interval

SIGMAS = 4.5  # of a binomial count: seven in a million by chance
PERCENT = 0.005 * 1.01  # published to 0.01 %
PUBLISHED = json.loads((Path(__file__).parents[2] / "reference" / "success.json").read_text())


def half_cycle(sigma):
    return math.erf(0.5 / (math.sqrt(2) * sigma))


def test_published_success_rates(reference):
    for case in reference["success_rate"]:
        assert abs(100 * success_rate(case["Q"]) - case["percent"]) <= case["rounded_to"] / 2 * 1.01, case["name"]


def test_reference_cases(reference):
    for case in reference["ils_cases"]:
        assert np.isclose(adop(case["Q"]), case["adop_cycles"], rtol=1e-6), case["name"]
        assert np.isclose(success_rate(case["Q"]), case["success_rate_after_decorrelation"], rtol=2e-3), case["name"]  # Z is not unique


def test_adop_success_rate_of_the_delft_example(reference):
    case = reference["success_rate"][0]
    promised = math.erf(1 / (math.sqrt(8) * adop(case["Q"]))) ** 2  # (2 Phi(1 / (2 ADOP)) - 1)^n
    assert abs(100 * promised - case["adop_success_percent"]) <= 0.005


@settings(max_examples=50, deadline=None)
@given(st.integers(1, 8), st.integers(0, 2**32 - 1))
def test_adop_is_the_determinant_whatever_the_variables(n, seed):
    rng = np.random.default_rng(seed)
    Q, Z = covariance(n, rng), unimodular(n, rng)
    assert np.isclose(adop(Q), np.exp(np.linalg.slogdet(Q)[1] / (2 * n)), rtol=1e-9)
    assert np.isclose(adop(Z.T @ Q @ Z), adop(Q), rtol=1e-6)


def bootstrap(z_hat, L):
    """Round the last variable, condition the others on it, and so on; z_hat (N, n)."""
    z_hat, z = z_hat.copy(), np.empty_like(z_hat)
    for k in range(z_hat.shape[-1] - 1, -1, -1):
        z[:, k] = np.rint(z_hat[:, k])
        z_hat[:, :k] -= (z_hat[:, k] - z[:, k])[:, None] * L[k, :k]
    return z


@pytest.mark.parametrize("scale", [0.2, 0.5, 1.0])
def test_promised_is_counted_and_least_squares_does_no_worse(scale, rng):
    N, n = 20_000, 5
    Q = scale * covariance(n, rng, decades=1.0)
    Z, L, _ = decorrelate(Q)
    a_hat = rng.multivariate_normal(np.zeros(n), Q, N)  # the true integers are zero
    promised = success_rate(Q)
    sigma = np.sqrt(promised * (1 - promised) / N)
    bootstrapped = np.mean(np.all(bootstrap(a_hat @ Z, L) == 0, axis=-1))
    least_squares = np.mean(np.all(integer_least_squares(a_hat, Q, n_best=1).best == 0, axis=-1))
    assert 0.05 < promised < 0.9999  # else nothing is tested
    assert abs(bootstrapped - promised) < SIGMAS * sigma
    assert least_squares > promised - SIGMAS * sigma


def test_stacks():
    Q = np.array([[[0.25]], [[0.01]]])
    assert np.allclose(success_rate(Q), [math.erf(1 / math.sqrt(2)), math.erf(5 / math.sqrt(2))])
    assert np.allclose(adop(Q), [0.5, 0.1])


@pytest.mark.parametrize("function", [success_rate, adop, success_bounds])
def test_no_covariance_no_answer(function):
    with pytest.raises(ValueError, match="not positive definite"):
        function([[1.0, 1.0], [1.0, 1.0]])


@pytest.mark.parametrize("variables", ["original", "decorrelated"])
def test_published_bounds(variables):
    Q, expected = PUBLISHED["bounds"]["Q"], PUBLISHED["bounds"][variables]
    bounds = success_bounds(Q if variables == "original" else decorrelate(Q).Q_z)
    assert len(expected) == 8
    for name, percent in expected.items():
        assert abs(100 * getattr(bounds, name) - percent) <= PERCENT, name
    assert bounds.is_sharp


def test_sharpest_of_the_published_bounds():
    bounds = success_bounds(PUBLISHED["bounds"]["Q"])
    assert (bounds.lower, bounds.upper) == (bounds.pull_in_lower, bounds.pull_in_upper)
    assert repr(bounds) == "SuccessBounds: bootstrapping 90.41%, integer least squares 94.90% to 97.13%"
    stack = success_bounds([PUBLISHED["bounds"]["Q"]] * 3)
    assert stack.upper.shape == stack.lower.shape == (3,)
    assert repr(stack) == "SuccessBounds: 3 covariances"


def test_published_simulated_bootstrapping(rng):
    """10^6 samples there, 10^5 here, and the exact value between them."""
    Q, N = np.array(PUBLISHED["bounds"]["Q"]), 100_000
    for name, Q_z in (("original", Q), ("decorrelated", decorrelate(Q).Q_z)):
        published = PUBLISHED["bounds"]["simulated"][f"bootstrapping_{name}"] / 100
        low, high = wilson_interval(published * 1e6, 1e6, SIGMAS)
        assert low < success_bounds(Q_z).bootstrapped < high
        fixed = integer_bootstrapping(rng.multivariate_normal(np.zeros(2), Q_z, N), Q_z)
        low, high = wilson_interval(np.sum(np.all(fixed == 0, axis=-1)), N, SIGMAS)
        assert low < success_bounds(Q_z).bootstrapped < high


def test_published_success_rate_is_that_of_the_bounds_after_decorrelation(reference):
    case = reference["success_rate"][1]
    assert abs(100 * success_bounds(decorrelate(case["Q"]).Q_z).bootstrapped - case["percent"]) <= case["rounded_to"] / 2 * 1.01


def test_adop_success_rates_by_hand():
    cases = PUBLISHED["by_adop"]["cases"]
    assert len(cases) == 2
    for case in cases:
        assert abs(adop_success_rate(case["adop"], case["n"]) - case["rate"]) <= 0.0005
    assert np.allclose(adop_success_rate([0.14, 0.2], 28), [case["rate"] for case in cases], atol=0.0005)


@given(st.floats(0.02, 5.0))
def test_one_ambiguity_has_one_success_rate(sigma):
    bounds = success_bounds([[sigma**2]])
    assert np.allclose(bounds[:8], half_cycle(sigma), rtol=1e-12)


@given(st.integers(1, 8), st.floats(0.05, 2.0))
def test_equal_and_uncorrelated_ambiguities(n, sigma):
    """The pull-in region is a cube: all but the ball inside and the ball of its volume are exact."""
    bounds = success_bounds(sigma**2 * np.eye(n))
    cube = half_cycle(sigma) ** n
    exact = (bounds.bootstrapped, bounds.adop, bounds.variance_lower, bounds.eigenvalue_lower, bounds.eigenvalue_upper, bounds.pull_in_upper)
    assert np.allclose(exact, cube, rtol=1e-9)
    assert bounds.pull_in_lower <= cube * (1 + 1e-12)
    assert bounds.adop_upper >= cube * (1 - 1e-12)


def test_discs_have_closed_forms(rng):
    """In the plane P(chi2_2 <= r^2) = 1 - exp(-r^2 / 2): half the shortest distance, and the disc of area pi r^2 ADOP^2 = 1."""
    for _ in range(20):
        Q = covariance(2, rng, decades=2.0)
        shortest = min(np.array(z) @ np.linalg.solve(Q, z) for z in itertools.product(range(-40, 41), repeat=2) if any(z))
        bounds = success_bounds(Q)
        assert np.isclose(bounds.pull_in_lower, -np.expm1(-shortest / 8), rtol=1e-9)
        assert np.isclose(bounds.adop_upper, -np.expm1(-1 / (2 * np.pi * np.sqrt(np.linalg.det(Q)))), rtol=1e-9)


def nearest_independent(Q, half_width):
    """The n shortest independent integer vectors, from every point of a box, shortest first."""
    points = np.array([z for z in itertools.product(range(-half_width, half_width + 1), repeat=len(Q)) if any(z)])
    points = points[np.argsort(np.einsum("pi,pi->p", points, np.linalg.solve(Q, points.T).T), kind="stable")]
    chosen = np.empty((0, len(Q)))
    for z in points:
        if np.linalg.matrix_rank(np.vstack([chosen, z])) > len(chosen):
            chosen = np.vstack([chosen, z])
    return chosen


@pytest.mark.parametrize("n", [2, 3])
def test_slabs_by_the_covariance_of_their_coordinates(n, rng):
    """v_i = z_i' Q^-1 a / z_i' Q^-1 z_i has covariance z_i' Q^-1 z_j over both lengths; each conditioned on those before it."""
    for _ in range(20):
        Q = covariance(n, rng, decades=1.0)
        z = nearest_independent(Q, 9)
        weights = z @ np.linalg.solve(Q, z.T)
        C = weights / np.outer(np.diag(weights), np.diag(weights))
        conditional = [C[i, i] - C[i, :i] @ np.linalg.solve(C[:i, :i], C[:i, i]) for i in range(n)]
        assert np.isclose(success_bounds(Q).pull_in_upper, np.prod([half_cycle(math.sqrt(v)) for v in conditional]), rtol=1e-9)


def test_bootstrapping_by_quadrature(rng):
    """The normal density over the parallelogram |a_2| < 1/2, |a_1 - a_2 q_12 / q_22| < 1/2, by Gauss and Legendre."""
    nodes, weights = np.polynomial.legendre.leggauss(80)
    for _ in range(10):
        Q = 0.3 * covariance(2, rng, decades=1.0)
        a_2 = nodes[:, None] / 2
        a_1 = nodes / 2 + a_2 * Q[0, 1] / Q[1, 1]
        a = np.stack([a_1, np.broadcast_to(a_2, a_1.shape)], axis=-1)
        density = np.exp(-0.5 * np.einsum("ijk,ijk->ij", a, np.linalg.solve(Q, a[..., None])[..., 0])) / (2 * np.pi * np.sqrt(np.linalg.det(Q)))
        assert np.isclose(success_bounds(Q).bootstrapped, weights @ density @ weights / 4, rtol=1e-6)


@settings(max_examples=25, deadline=None)
@given(st.integers(1, 6), st.integers(0, 2**32 - 1), st.floats(-2.0, 0.3))
def test_rounding_bootstrapping_least_squares_and_the_upper_bounds_in_this_order(n, seed, power):
    rng = np.random.default_rng(seed)
    Q, N = 10.0**power * covariance(n, rng, decades=1.5), 4000
    a_hat = rng.multivariate_normal(np.zeros(n), Q, N)
    rounded, bootstrapped, best = (
        np.count_nonzero(np.all(fixed == 0, axis=-1))
        for fixed in (integer_rounding(a_hat), integer_bootstrapping(a_hat, Q), integer_least_squares(a_hat, Q, n_best=1).best)
    )
    bounds = success_bounds(Q)
    assert bounds.variance_lower <= bounds.bootstrapped * (1 + 1e-9)
    assert bounds.bootstrapped <= bounds.adop * (1 + 1e-9)
    assert may_be_at_least(bounds.variance_lower, rounded, N)
    assert may_be_at_most(bounds.bootstrapped, rounded, N)
    assert may_be_at_least(bounds.bootstrapped, bootstrapped, N)
    assert may_be_at_most(bounds.bootstrapped, bootstrapped, N)
    for lower in (bounds.bootstrapped, bounds.eigenvalue_lower, bounds.pull_in_lower, success_rate(Q)):
        assert may_be_at_least(lower, best, N)
    for upper in (bounds.adop_upper, bounds.eigenvalue_upper, bounds.pull_in_upper):
        assert may_be_at_most(upper, best, N)


def may_be_at_least(probability, count, N):
    """Whether a count does not contradict a chance of that or more: as few or fewer come more often than once in 10^8 runs."""
    return binom.cdf(count, N, min(probability, 1.0)) > 1e-8


def may_be_at_most(probability, count, N):
    return may_be_at_least(1.0 - min(probability, 1.0), N - count, N)


@settings(max_examples=50, deadline=None)
@given(st.integers(1, 6), st.integers(0, 2**32 - 1))
def test_what_no_change_of_variables_alters(n, seed):
    rng = np.random.default_rng(seed)
    Q, Z = covariance(n, rng), unimodular(n, rng)
    one, other = success_bounds(Q), success_bounds(Z.T @ Q @ Z)
    for name in ("adop", "adop_upper", "pull_in_lower"):
        assert np.isclose(getattr(one, name), getattr(other, name), rtol=1e-6), name
    assert np.isclose(one.pull_in_upper, other.pull_in_upper, rtol=1e-3)  # the n-th wall may stand elsewhere, if far off


def test_bounds_hold_without_the_nearest_integers(rng):
    basis = np.linalg.qr(rng.standard_normal((60, 60)))[0]
    Q = basis @ np.diag(np.geomspace(1e-7, 1e5, 60)) @ basis.T  # condition 1e12; the nearest would take hours
    Q = (Q + Q.T) / 2
    bounds, simulated = success_bounds(Q), simulate_success(Q, rng, 2000, node_limit=10_000)
    assert not bounds.is_sharp
    assert np.all(np.isfinite(bounds[:8]))
    assert bounds.pull_in_lower <= simulated.interval[1]
    assert simulated.interval[0] <= min(bounds.pull_in_upper, bounds.adop_upper)


def test_bounds_cut_short_are_weaker_but_no_other(rng):
    for _ in range(20):
        Q = 0.1 * covariance(6, rng, decades=1.5)
        cut, whole = success_bounds(Q, node_limit=10), success_bounds(Q)
        assert (cut.is_sharp, whole.is_sharp) == (False, True)
        assert cut.pull_in_lower <= whole.pull_in_lower * (1 + 1e-12)
        assert success_rate(Q) <= cut.pull_in_upper
        assert cut[:6] == whole[:6]


def test_stack_of_bounds_equals_one_by_one(rng):
    Q = np.array([[covariance(4, rng) for _ in range(3)] for _ in range(2)])
    Q.flags.writeable = False
    together = success_bounds(Q)
    for index in np.ndindex(2, 3):
        assert np.allclose([field[index] for field in together], success_bounds(Q[index]), rtol=1e-9)
    assert success_bounds(np.empty((0, 3, 3))).pull_in_upper.shape == (0,)


@pytest.mark.parametrize(("adop", "n"), [(0.0, 3), (-0.1, 3), (np.nan, 3), (0.1, 0)])
def test_no_adop_no_success_rate(adop, n):
    with pytest.raises(ValueError, match="ADOP must be positive and n at least 1"):
        adop_success_rate(adop, n)
