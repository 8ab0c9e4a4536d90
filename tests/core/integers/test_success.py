"""Success rate and ADOP: published values, and fixes counted."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from obvious import covariance, unimodular

from gnsslab.core.integers import adop, decorrelate, integer_least_squares, success_rate

SIGMAS = 4.5  # of a binomial count: seven in a million by chance


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


@pytest.mark.parametrize("function", [success_rate, adop])
def test_no_covariance_no_answer(function):
    with pytest.raises(ValueError, match="not positive definite"):
        function([[1.0, 1.0], [1.0, 1.0]])
