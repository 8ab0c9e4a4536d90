"""The quick mean: as quick as asked, and nothing that is as quick is calmer."""

import numpy as np
import pytest

from gnsslab.core.jit import kernel_input
from gnsslab.core.recent_mean import LONGEST, QUICK, covariance, quick_weights, recent_mean, variances_of_mean

NOISES = [(1.0, 0.0, 1.0), (1.25, 3.5, 7.5), (3.9, 1.1, 110.0), (1e-6, 1.0, 10.0)]


@pytest.mark.parametrize("noise", NOISES)
def test_no_other_mean_that_is_as_quick_is_calmer(rng, noise):
    Q = covariance(*noise)
    h = quick_weights(Q)
    response = np.cumsum(h)
    assert response[-1] == pytest.approx(1.0)
    for epochs, share in QUICK:
        assert response[epochs - 1] == pytest.approx(share)
    A = np.stack([np.ones(LONGEST), *(1.0 * (np.arange(LONGEST) < epochs) for epochs, _ in QUICK)])
    for _ in range(20):
        change = rng.standard_normal(LONGEST)
        change -= A.T @ np.linalg.lstsq(A.T, change)[0]  # keeps the response at the points asked for
        other = h + 0.01 * change
        assert A @ other == pytest.approx(A @ h, abs=1e-9)
        assert other @ Q @ other > h @ Q @ h


@pytest.mark.parametrize("noise", NOISES)
def test_variance_is_that_of_the_mean_itself(rng, noise):
    Q = covariance(*noise)
    h = quick_weights(Q)
    draws = np.linalg.cholesky(Q + 1e-12 * np.eye(LONGEST)) @ rng.standard_normal((LONGEST, 4000))  # row 0: the latest
    for rows in (1, 7, LONGEST):
        means = [recent_mean(kernel_input(draw[:rows][::-1, None]), 0, rows, 0, kernel_input(h)) for draw in draws.T[:400]]
        expected = variances_of_mean(h, Q)[rows - 1]
        assert np.var(means) == pytest.approx(expected, rel=5 * np.sqrt(2 / 400))  # 5 sigma of a variance


def test_a_constant_stays():
    values = kernel_input(np.full((300, 1), 7.5))
    h = kernel_input(quick_weights(covariance(1.0, 2.0, 5.0)))
    assert [recent_mean(values, begin, 300, 0, h) for begin in (0, 150, 299)] == pytest.approx([7.5] * 3)
