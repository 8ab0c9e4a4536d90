"""What every covariance matrix is, checked where one comes in."""

import numpy as np

ASYMMETRY = 1e-8  # |Q_ij - Q_ji| / sqrt(Q_ii Q_jj): rounding stays below, a wrong formula does not
# A @kernel uses it too: with this word the text of this file is part of the key under which compiled kernels are kept.


def check_symmetric(Q, name):
    """Raise ValueError where Q (..., n, n) is not symmetric: factors and eigenvalues would take its lower half for all of it."""
    if not is_symmetric(Q).all():
        raise ValueError(f"{name} is not symmetric; a covariance matrix is, so look at how it was made, or pass (Q + Q.T) / 2 if rounding did it.")


def is_symmetric(Q):
    """Return whether the matrices Q (..., n, n) are symmetric but for rounding (...).

    >>> [bool(is_symmetric(np.array(Q))) for Q in ([[1.0, 0.5], [0.5, 4.0]], [[1.0, 0.5], [0.4, 4.0]])]
    [True, False]
    """
    sigma = np.sqrt(np.abs(np.diagonal(Q, axis1=-2, axis2=-1)))
    return (np.abs(Q - Q.mT) <= ASYMMETRY * sigma[..., None] * sigma[..., None, :]).all(axis=(-2, -1))
