"""The filter's last step, by itself: the baseline from carriers whose integers are known, also where they are only just enough or not."""

import numpy as np
import pytest

from gnsslab.core.jit import kernel_input, matrix
from gnsslab.gnss.ambiguity_filter import _FIXED, _FREEDOM, _MISFIT, _RESULTS, _write_fixed

NEAR = np.array([1.0, 2.0, 3.0])  # [m]
SIGMA = 4e-3  # [m], by which rows and measurements are divided


def solved(H, y):
    """Return whether there is a solution, and the row of results, of y = H (b - near) in units of sigma."""
    bordered = np.column_stack([H, y])
    row = matrix(1, _RESULTS)[0]
    done = _write_fixed(kernel_input(bordered.T @ bordered), len(y), kernel_input(NEAR), row)
    return done, np.asarray(row)


def test_three_differences_leave_nothing_over(rng):
    for _ in range(200):
        H, y = rng.uniform(-1, 1, (3, 3)) / SIGMA, rng.normal(0, 3.0, 3) / SIGMA
        if np.linalg.cond(H) > 1e3:
            continue
        done, row = solved(H, y)
        assert done
        assert row[_FREEDOM] == 0
        assert 0 <= row[_MISFIT] < 1e-6 * y @ y, "a root of a rounding error below zero is not a number"
        np.testing.assert_allclose(row[_FIXED : _FIXED + 3], NEAR + np.linalg.solve(H, y), rtol=0, atol=1e-6)


def test_more_differences_agree_with_numpy(rng):
    H, y = rng.uniform(-1, 1, (12, 3)) / SIGMA, rng.normal(0, 1.0, 12)
    done, row = solved(H, y)
    step, misfit, *_ = np.linalg.lstsq(H, y, rcond=None)
    assert done
    assert row[_MISFIT] == pytest.approx(misfit[0], rel=1e-9)
    np.testing.assert_allclose(row[_FIXED : _FIXED + 12], [*(NEAR + step), *np.linalg.inv(H.T @ H).ravel()], rtol=1e-9)


def test_two_directions_on_two_bands_leave_the_baseline_open(rng):
    for _ in range(200):
        H = np.repeat(rng.uniform(-1, 1, (2, 3)), 2, axis=0) / SIGMA
        assert not solved(H, rng.normal(0, 3.0, 4) / SIGMA)[0]
