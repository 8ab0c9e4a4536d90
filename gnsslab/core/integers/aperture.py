"""Integer aperture bootstrapping: fix only where every rounding was a clear one.

Bootstrapping rounds one conditional float value c_i after the other. Its pull-in region is a box about each integer
vector: half a cycle to each side of every c_i. Shrunk by a factor beta, the aperture, the boxes leave gaps, and float
vectors in a gap stay float. A small aperture fixes rarely, and is hardly ever wrong.
Source: Teunissen (2005), J. Geodesy 79:389-397.
"""

from typing import NamedTuple

import numpy as np
from scipy.special import erf

from gnsslab.core.integers.acceptance import check_countable, threshold_of_fixes
from gnsslab.core.integers.decorrelation import checked_problem, decorrelate, one_covariance
from gnsslab.core.integers.rounding import integer_bootstrapping, integer_rounding
from gnsslab.core.integers.search import checked_count
from gnsslab.core.integers.simulation import checked_generator


class ApertureSolution(NamedTuple):
    """Bootstrapped integers, and how clear the rounding was."""

    a: np.ndarray  # (..., n) int64 [cycles]
    aperture: np.ndarray  # (...) the smallest aperture that holds the float vector: 2 max |c_i - z_i|, from 0 to 1


def aperture_bootstrapping(a_hat, Q):
    """Bootstrap after decorrelation; fix where `.aperture` is no more than the aperture beta chosen.

    |c_i - z_i| <= beta / 2 for all i

    a_hat: (..., n) [cycles]; Q: (n, n) [cycles^2]. Returns an ApertureSolution. Raises ValueError where shapes do not fit,
    Q is no covariance matrix, or a_hat is not finite.

    >>> solution = aperture_bootstrapping([[0.1], [3.4]], [[0.04]])
    >>> solution.a.tolist(), solution.aperture.round(6).tolist()
    ([[0], [3]], [0.2, 0.8])
    """
    a_hat, Q = checked_problem(a_hat, Q)
    whole, decorrelation = integer_rounding(a_hat), decorrelate(Q)
    z, aperture = _bootstrap((a_hat - whole) @ decorrelation.Z, decorrelation.L, decorrelation.d)
    return ApertureSolution(whole + decorrelation.restore(z), aperture)


def _bootstrap(z_hat, L, d):
    """Return z (..., n) and 2 max |c_i - z_i| (...); z_hat - z = L' (c - z)."""
    z = integer_bootstrapping(z_hat, L.T * d @ L)
    return z, np.minimum(2.0 * np.max(np.abs((z_hat - z) @ np.linalg.inv(L)), axis=-1), 1.0)  # rounding may leave a little more


def aperture_success_rate(Q, aperture):
    """Return the probability that bootstrapping with this aperture fixes, and rightly.

    P = prod over i of (2 Phi(beta / (2 sigma_i)) - 1)

    Q: (n, n) or (..., n, n) [cycles^2]; aperture: beta from 0 to 1, where it is `success_rate`. Returns (...).

    >>> float(aperture_success_rate([[0.0625]], 0.5).round(4))        # a quarter of a cycle is one sigma
    0.6827
    """
    if not 0 <= aperture <= 1:
        raise ValueError(f"the aperture is a factor from 0, nothing fixed, to 1, everything fixed; it is {aperture:g}")
    return np.prod(erf(aperture / np.sqrt(8.0 * decorrelate(Q).d)), axis=-1)


class ApertureThreshold(NamedTuple):
    """An aperture, and what it does with simulated float vectors of the model it was made for."""

    aperture: float  # fix where the float vector lies within
    failure_rate: float  # fixed and wrong, of all samples
    fix_rate: float  # fixed, of all samples
    samples: int


def failure_rate_aperture(Q, failure_rate, rng, samples=100_000):
    """Find the largest aperture with which no more than failure_rate of all samples are fixed and wrong.

    Q: (n, n) [cycles^2]. Returns an ApertureThreshold. Raises ValueError where less than one failure is to be expected.

    >>> failure_rate_aperture([[0.0004]], 0.001, np.random.default_rng(1), samples=10_000).aperture      # half a cycle is 25 sigma
    1.0
    """
    samples, rng = checked_count(samples, "samples"), checked_generator(rng)
    check_countable(failure_rate, samples)
    _, L, d = decorrelate(one_covariance(Q))
    z, aperture = _bootstrap((rng.standard_normal((samples, len(d))) * np.sqrt(d)) @ L, L, d)
    found = threshold_of_fixes(1.0 / aperture, np.all(z == 0, axis=-1), failure_rate)
    return ApertureThreshold(1.0 / found.ratio, found.failure_rate, found.fix_rate, samples)
