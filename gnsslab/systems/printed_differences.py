"""Covariances of differences as printed in papers A and D, misprints and all: for comparison only, called by labs and tests.

The mended forms stand in gnsslab.gnss.correlation.
"""

import numpy as np

from gnsslab.gnss.differences import difference_operator


def measurement_covariance_as_printed(sigma):
    """Return R = diag(sigma_1, ..., sigma_m-1) as paper A, equations (10) and (11), prints it for m satellites.

    The last satellite is missing, and the standard deviations are not squared. D of equation (13) is (m - 1, m), so that the
    product D R D' of equation (12) does not exist.

    >>> measurement_covariance_as_printed(np.array([3.0, 4.0, 5.0])).tolist()
    [[3.0, 0.0], [0.0, 4.0]]
    """
    return np.diag(np.asarray(sigma, dtype=float)[:-1])


def unsquared_covariance_as_printed(sigma, reference):
    """Return D diag(sigma_1, ..., sigma_m) D': paper A's equations (10) to (13) with the sizes mended, the squares still missing.

    Its numbers change with the unit of sigma: in metres carriers of 3 mm look 13 times worse than they are, in millimetres better.

    >>> unsquared_covariance_as_printed(np.array([0.003, 0.003, 0.003]), 0).round(4).tolist()
    [[0.006, 0.003], [0.003, 0.006]]
    """
    D = difference_operator(len(sigma), reference)
    return D @ np.diag(np.asarray(sigma, dtype=float)) @ D.T


def doubled_covariance_as_printed(sigma, reference):
    """Return the covariance of double differences made of single differences with the noise 2 V, as paper D2, equation (7), prints it.

    Right is V_rover - V_master, of variance 2 sigma^2. The noise 2 V has 4 sigma^2, and the pattern becomes 8-4-4.

    >>> doubled_covariance_as_printed(np.ones(3), 0).astype(int).tolist()
    [[8, 4], [4, 8]]
    """
    D = difference_operator(len(sigma), reference)
    return D @ np.diag(np.square(2 * np.asarray(sigma, dtype=float))) @ D.T
