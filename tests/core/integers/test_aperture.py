"""Integer aperture bootstrapping: its ends, one ambiguity in closed form, and counted rates."""

import math

import numpy as np
import pytest
from obvious import covariance
from scipy.special import erf

from gnsslab.core.integers import (
    adop,
    aperture_bootstrapping,
    aperture_success_rate,
    decorrelate,
    failure_rate_aperture,
    integer_bootstrapping,
    success_rate,
)

SIGMAS = 4.5  # of a count: seven in a million by chance


def model(n, cycles, seed=2):
    Q = covariance(n, np.random.default_rng(seed), decades=2.0)
    return Q * (cycles / adop(Q)) ** 2


def draws(Q, rng, samples):
    return rng.standard_normal((samples, len(Q))) @ np.linalg.cholesky(Q).T


def clear_roundings(z_hat, L, aperture):
    """Round the last variable, look how clear that was, condition the others on it, and so on; one vector."""
    z_hat, clear = z_hat.copy(), True
    for k in range(len(z_hat) - 1, -1, -1):
        error = z_hat[k] - np.rint(z_hat[k])
        clear &= abs(error) <= aperture / 2
        z_hat[:k] -= error * L[k, :k]
    return clear


def test_integers_are_those_of_bootstrapping_and_the_aperture_says_how_clear(rng):
    Q = model(5, 0.3)
    a_hat = rng.uniform(-9, 9, (200, 5))
    found = aperture_bootstrapping(a_hat, Q)
    Z, L, d = decorrelate(Q)
    assert np.array_equal(found.a @ Z, integer_bootstrapping(a_hat @ Z, L.T @ np.diag(d) @ L))
    assert np.all((found.aperture >= 0) & (found.aperture <= 1))
    for aperture in (0.5, 0.8):
        accepted = found.aperture <= aperture
        assert accepted.tolist() == [clear_roundings(z_hat, L, aperture) for z_hat in a_hat @ Z]
        assert 0 < accepted.sum() < 200


def test_one_ambiguity():
    found = aperture_bootstrapping([[2.1], [2.45], [-3.0]], [[0.04]])
    assert found.a.tolist() == [[2], [2], [-3]]
    assert np.allclose(found.aperture, [0.2, 0.9, 0.0])
    assert np.isclose(aperture_success_rate([[0.04]], 0.5), erf(0.25 / 0.2 / math.sqrt(2)))


def test_ends_of_the_success_rate():
    Q = model(4, 0.3)
    assert np.isclose(aperture_success_rate(Q, 1.0), success_rate(Q))
    assert aperture_success_rate(Q, 0.0) == 0.0
    assert aperture_success_rate(np.array([Q, 0.01 * Q]), 0.5).shape == (2,)


@pytest.mark.parametrize("aperture", [0.4, 0.8])
def test_promised_success_is_counted(aperture, rng):
    Q, samples = model(5, 0.2), 20_000
    found = aperture_bootstrapping(draws(Q, rng, samples), Q)
    counted = np.mean((found.aperture <= aperture) & np.all(found.a == 0, axis=-1))
    promised = aperture_success_rate(Q, aperture)
    assert 0.05 < promised < 0.95
    assert abs(counted - promised) < SIGMAS * math.sqrt(promised * (1 - promised) / samples)


@pytest.mark.parametrize(("n", "failure_rate"), [(2, 0.01), (6, 0.001)])
def test_the_failure_rate_is_kept_on_fresh_samples(n, failure_rate, rng):
    Q, samples = model(n, 0.25), 100_000
    found = failure_rate_aperture(Q, failure_rate, rng, samples)
    fresh = aperture_bootstrapping(draws(Q, rng, samples), Q)
    accepted = fresh.aperture <= found.aperture
    failures = np.sum(accepted & np.any(fresh.a != 0, axis=-1))
    assert 0 < found.aperture < 1
    assert abs(failures - failure_rate * samples) < SIGMAS * math.sqrt(2 * failure_rate * samples)  # both counts err
    assert abs(accepted.mean() - found.fix_rate) < 0.03
    assert abs(found.fix_rate - found.failure_rate - aperture_success_rate(Q, found.aperture)) < 0.01


def test_a_good_model_is_fixed_outright(rng):
    assert failure_rate_aperture(model(3, 0.08), 0.001, rng, 10_000).aperture == 1.0


def test_shift_by_integers(rng):
    Q, a_hat = model(4, 0.3), rng.integers(-8, 8, (10, 4)) / 16.0
    shift = rng.integers(-(10**8), 10**8, 4)
    found, shifted = aperture_bootstrapping(a_hat, Q), aperture_bootstrapping(a_hat + shift, Q)
    assert np.array_equal(shifted.a, found.a + shift)
    assert np.array_equal(shifted.aperture, found.aperture)


BAD_CALLS = [
    (lambda: aperture_bootstrapping([0.1, 0.2, 0.3], np.eye(2)), "one value for each row of Q, 2"),
    (lambda: aperture_bootstrapping([0.1, np.inf], np.eye(2)), "a_hat contains NaN or infinity"),
    (lambda: aperture_success_rate([[1.0]], 1.1), "a factor from 0, nothing fixed, to 1, everything fixed; it is 1.1"),
    (lambda: failure_rate_aperture([[1.0]], 0.0, np.random.default_rng(1)), "more than 0 and less than 1; it is 0"),
    (lambda: failure_rate_aperture([[1.0]], 0.001, np.random.default_rng(1), 100), "less than one failure"),
    (lambda: failure_rate_aperture([[1.0]], 0.1, np.random.default_rng(1), 100.5), "samples must be a whole number"),
    (lambda: failure_rate_aperture([[1.0]], 0.1, 7, 100), "rng must be a Generator.*it is 7"),
    (lambda: failure_rate_aperture(np.ones((3, 1, 1)), 0.1, np.random.default_rng(1), 100), "one covariance matrix"),
]


@pytest.mark.parametrize(("call", "message"), BAD_CALLS)
def test_bad_calls_are_explained(call, message):
    with pytest.raises(ValueError, match=message):
        call()
