"""Printed covariances of differences: what is wrong with them shows."""

import numpy as np
import pytest

from gnsslab.gnss.correlation import double_difference_covariance
from gnsslab.gnss.differences import difference_operator
from gnsslab.systems.printed_differences import (
    doubled_covariance_as_printed,
    measurement_covariance_as_printed,
    unsquared_covariance_as_printed,
)

SIGMA = np.array([0.003, 0.004, 0.006, 0.005])


def test_printed_sizes_do_not_fit_each_other():
    with pytest.raises(ValueError, match="matmul"):
        difference_operator(4, 0) @ measurement_covariance_as_printed(SIGMA)


def test_unsquared_numbers_depend_on_the_unit():
    """A covariance in millimetres squared is a million times the one in metres squared; the printed one is a thousand times."""
    for build, factor in ((double_difference_covariance, 1e6), (unsquared_covariance_as_printed, 1e3)):
        np.testing.assert_allclose(build(1000 * SIGMA, 0), factor * build(SIGMA, 0), rtol=1e-12)


def test_unsquared_carriers_of_3_mm_look_13_times_worse():
    """sqrt(sigma / 2 sigma^2) = sqrt(1 / 0.006) = 12.9."""
    printed, right = (build(np.full(3, 0.003), 0)[0, 0] for build in (unsquared_covariance_as_printed, double_difference_covariance))
    assert np.sqrt(printed / right) == pytest.approx(12.91, abs=0.005)


def test_noise_2V_has_twice_the_variance_of_a_difference(rng):
    """Second route by drawing: V_rover - V_master against 2 V; a variance of N draws is good to sqrt(2 / N)."""
    N = 100_000
    V = rng.standard_normal((N, 2))
    ratio = np.var(2 * V[:, 0]) / np.var(V[:, 1] - V[:, 0])
    assert ratio == pytest.approx(2.0, rel=4 * np.sqrt(4 / N))
    np.testing.assert_allclose(doubled_covariance_as_printed(SIGMA, 1), 2 * double_difference_covariance(SIGMA, 1), rtol=1e-12)
