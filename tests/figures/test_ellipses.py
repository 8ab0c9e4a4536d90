"""Ellipses of covariance matrices: their outline against the equation that it stands for."""

import numpy as np
import pytest
from matplotlib.patches import Ellipse

from gnsslab.figures.ellipses import CHI_SQUARE_95, set_ellipse


@pytest.mark.parametrize("Q", [np.eye(2), np.diag([9.0, 4.0]), [[2.0, 1.2], [1.2, 1.0]], [[1e-6, -9e-7], [-9e-7, 1e-6]]], ids=str)
def test_outline_is_where_the_quadratic_form_is_one(Q):
    patch = Ellipse((0, 0), 1, 1)
    set_ellipse(patch, (3.0, -7.0), np.array(Q))
    outline = patch.get_patch_transform().transform(np.column_stack([np.cos(np.arange(60)), np.sin(np.arange(60))])) - [3.0, -7.0]
    np.testing.assert_allclose(np.einsum("ki,ij,kj->k", outline, np.linalg.inv(Q), outline), 1.0, rtol=1e-6)


def test_ninety_five_percent_are_inside(rng):
    """A share of 100 000 draws, 4 sigma."""
    squared = np.sum(rng.standard_normal((100_000, 2)) ** 2, axis=1)
    assert abs(np.mean(squared < CHI_SQUARE_95) - 0.95) < 4 * np.sqrt(0.95 * 0.05 / 100_000)
