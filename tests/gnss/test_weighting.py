"""Weighting against formulas worked out by hand, and means of correlated measurements against their whole covariance matrix."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gnsslab.gnss.weighting import TYPICAL_CN0, NoiseModel, inflation_of_mean, information_step, sigma_code, sigma_phase

L1, L2 = 0.190294, 0.244210  # [m]
MICROMETRE = 1e-6


def test_the_carriers_variance_is_the_sum_of_its_three_parts():
    noise = NoiseModel(phase=0.003, phase_horizon=0.0, code_ratio=1.0)
    assert sigma_phase(noise, np.pi / 2, np.inf, L1) == pytest.approx(0.003072, abs=MICROMETRE)  # an infinite C/N0 is not one: taken as 45 dB-Hz
    assert sigma_phase(NoiseModel(phase=0.0, phase_horizon=0.003), np.radians(30), 200.0, L1) == pytest.approx(0.006, abs=MICROMETRE)
    # thermal noise alone (Kaplan and Hegarty 2006, 5.9): (0.190294 / 2 pi) sqrt(15 / 10^3.5) = 2.086 mm at 35 dB-Hz
    assert sigma_phase(NoiseModel(phase=0.0, phase_horizon=0.0), 1.0, 35.0, L1) == pytest.approx(0.002086, abs=MICROMETRE)


@pytest.mark.parametrize("absent", [np.nan, 0.0, -1.0, 7.0], ids=str)
def test_a_missing_strength_counts_as_a_typical_one(absent):
    assert sigma_phase(NoiseModel(), 0.7, absent, L1) == sigma_phase(NoiseModel(), 0.7, TYPICAL_CN0, L1)


def test_an_absurd_strength_overflows_nothing():
    assert sigma_phase(NoiseModel(phase=0.003, phase_horizon=0.0), 0.7, 99999.999, L1) == pytest.approx(0.003, abs=MICROMETRE)


@given(elevation=st.floats(0.05, 1.5), cn0=st.floats(20, 55))
def test_lower_weaker_and_longer_waves_are_worse(elevation, cn0):
    sigma = sigma_phase(NoiseModel(), elevation, cn0, L1)
    assert sigma > sigma_phase(NoiseModel(), elevation + 0.01, cn0, L1)
    assert sigma > sigma_phase(NoiseModel(), elevation, cn0 + 0.5, L1)
    assert sigma < sigma_phase(NoiseModel(), elevation, cn0, L2)


def test_the_code_is_worse_by_its_ratio():
    assert sigma_code(NoiseModel(code_ratio=150.0), 0.7, 40.0, L1) == pytest.approx(150 * sigma_phase(NoiseModel(), 0.7, 40.0, L1))


def test_arrays_are_broadcast_and_nan_elevations_stay_nan():
    sigma = sigma_phase(NoiseModel(), np.array([[0.5], [np.nan]]), np.array([[40.0, 45.0, np.nan]]), np.array([L1, L2, L1]))
    assert sigma.shape == (2, 3)
    assert np.isfinite(sigma[0]).all()
    assert np.isnan(sigma[1]).all()


def correlation(n, interval, share, tau):
    """Return the correlation matrix (n, n) of measurements of which a share is a Gauss-Markov process."""
    lag = np.abs(np.subtract.outer(np.arange(n), np.arange(n))) * interval
    return (1 - share) * np.eye(n) + share * np.exp(-lag / tau)


@settings(deadline=None)
@given(n=st.integers(1, 200), interval=st.floats(0.05, 900), share=st.floats(0, 1), tau=st.floats(1, 300))
def test_the_variance_of_a_mean_is_that_of_the_whole_matrix(n, interval, share, tau):
    assert inflation_of_mean(n, interval, share, tau) == pytest.approx(correlation(n, interval, share, tau).sum() / n, rel=1e-6)


@settings(deadline=None)
@given(n=st.integers(1, 60), interval=st.floats(0.1, 100), share=st.floats(0, 1), tau=st.floats(1, 100))
def test_steps_of_information_add_up_to_that_of_the_mean(n, interval, share, tau):
    steps = information_step(np.arange(1, n + 1), interval, share, tau)
    assert steps[0] == pytest.approx(1.0, rel=1e-9)
    assert steps.sum() == pytest.approx(n**2 / correlation(n, interval, share, tau).sum(), rel=1e-6)
    assert (steps > 0).all(), "a measurement never takes information away"


def test_independent_measurements_are_not_inflated():
    assert inflation_of_mean(1000, 1.0, 0.0, 60.0) == 1.0
    assert inflation_of_mean(1000, 1e5, 2 / 3, 60.0) == pytest.approx(1.0, abs=1e-9)
