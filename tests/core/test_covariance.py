"""Symmetry of covariance matrices: in any units, but for rounding."""

import numpy as np
import pytest

from gnsslab.core.covariance import check_symmetric, is_symmetric


@pytest.mark.parametrize("scale", [1e-300, 1e-12, 1.0, 1e12, 1e300])
def test_symmetry_does_not_depend_on_the_units(scale):
    good = scale * np.array([[1.0, 0.5 + 1e-12], [0.5, 4.0]])  # rounding
    bad = scale * np.array([[1.0, 0.5 + 1e-6], [0.5, 4.0]])
    assert is_symmetric(np.array([good, bad])).tolist() == [True, False]


def test_names_what_is_not_symmetric():
    check_symmetric(np.eye(2), "Q_b")
    with pytest.raises(ValueError, match="Q_b is not symmetric"):
        check_symmetric(np.array([[1.0, 0.5], [0.0, 1.0]]), "Q_b")
