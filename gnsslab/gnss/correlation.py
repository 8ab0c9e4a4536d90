"""Correlation: what double differences have in common because they share a reference, as a covariance matrix."""

import numpy as np

from gnsslab.gnss.differences import difference_operator


def single_difference_covariance(sigma):
    """Return the covariance (m, m) of rover minus master, for m satellites with standard deviations sigma (m,) of one receiver.

    Q = diag(2 sigma_1^2, ..., 2 sigma_m^2): two receivers, equally good, share nothing but the satellite.

    >>> single_difference_covariance(np.array([1.0, 3.0])).tolist()
    [[2.0, 0.0], [0.0, 18.0]]
    """
    return np.diag(2 * np.square(np.asarray(sigma, dtype=float)))


def double_difference_covariance(sigma, reference):
    """Return the covariance (m - 1, m - 1) of the double differences against the satellite `reference` (an index).

    Q_y = D diag(2 sigma_1^2, ..., 2 sigma_m^2) D'          (paper A, equations 10 to 13, mended)

    sigma (m,) are standard deviations of one receiver's measurements; Q_y has their unit squared.

    >>> double_difference_covariance(np.ones(4), 0).astype(int).tolist()        # 4 on, 2 off the diagonal
    [[4, 2, 2], [2, 4, 2], [2, 2, 4]]
    """
    D = difference_operator(len(sigma), reference)
    return D @ single_difference_covariance(sigma) @ D.T


def without_correlation(Q):
    """Return a covariance (n, n) as one who ignores correlation has it: the diagonal alone.

    >>> without_correlation(np.array([[4, 2], [2, 4]])).tolist()
    [[4, 0], [0, 4]]
    """
    return np.diag(np.diag(Q))
