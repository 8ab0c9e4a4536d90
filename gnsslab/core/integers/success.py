"""How often a fix is right: the success rate of bootstrapping, ADOP, and bounds of what least squares reaches.

All of it is computed from the covariance alone, before any measurement, and all of it believes the model: unbiased
normal errors with just that covariance.
"""

import math
from typing import NamedTuple

import numpy as np
from scipy.special import chdtr, erf, gammaln

from gnsslab.core.integers.decorrelation import checked_covariance, decorrelate, ltdl
from gnsslab.core.integers.search import integer_least_squares

_DEPENDENT = 1e-12  # of the squared length: rounding leaves less of a vector that the shorter ones span
_NEAR = 8  # times n integer vectors, half of them opposites: n independent ones are almost always among them
_NODES = 1_000_000  # for the integer vectors nearest to zero: a tenth of a second; without them the bounds stand, less sharp


def success_rate(Q):
    """Return the probability that bootstrapping after decorrelation finds the true integers.

    P = prod over i of (2 Phi(1 / (2 sigma_i)) - 1) = prod over i of erf(1 / sqrt(8 d_i))

    d_i = sigma_i^2: conditional variances after decorrelation [cycles^2]. A lower bound for integer least squares,
    usually a sharp one, if the float ambiguities are normal and unbiased with covariance Q; no word on a biased model.

    Q: (n, n) or (..., n, n) [cycles^2]. Returns (...). Raises ValueError where Q is not a covariance matrix.
    Source: Teunissen (1998), J. Geodesy 72:606-612, eq. 24 and 28.

    >>> float(success_rate([[0.25]]).round(4))        # half a cycle is one sigma
    0.6827
    """
    return np.prod(_within_half_a_cycle(decorrelate(Q).d), axis=-1)


def adop(Q):
    """Return the ambiguity dilution of precision, the geometric mean of the conditional sigmas.

    ADOP = (det Q)^(1 / 2n) = prod over i of sqrt(d_i)^(1 / n)

    Q: (n, n) or (..., n, n) [cycles^2]. Returns (...) [cycles]; no integer change of variables alters it. A rule
    of thumb: below 0.12 cycles up to 30 ambiguities can be fixed with 99.9 % success (`adop_success_rate`), if their
    conditional variances are much the same after decorrelation.
    Raises ValueError where Q is not a covariance matrix. Source: Teunissen (1997); Odijk and Teunissen (2008).

    >>> float(adop([[0.04, 0.0], [0.0, 0.01]]).round(4))      # sigmas 0.2 and 0.1
    0.1414
    """
    return _adop(decorrelate(Q).d)


def adop_success_rate(adop, n):
    """Return the success rate of n ambiguities that are all as uncertain as ADOP says, and uncorrelated.

    P = (2 Phi(1 / (2 ADOP)) - 1)^n

    adop: (...) [cycles]. Returns (...). An upper bound for bootstrapping (the d that are equal are the best with one
    det Q) and an approximation for least squares after decorrelation, often a good one. Raises ValueError where
    ADOP is not positive or n below 1.
    Source: Teunissen (2000), Artificial Satellites 35:171-179; Verhagen (2003), J. Global Positioning Systems 2:117-124.

    >>> float(adop_success_rate(0.14, 28).round(3))
    0.99
    """
    adop = np.asarray(adop, dtype=np.float64)
    if not np.all(adop > 0.0) or not n >= 1:
        raise ValueError(f"ADOP must be positive and n at least 1; they are {adop} and {n}.")
    return _within_half_a_cycle(adop**2) ** n


class SuccessBounds(NamedTuple):
    """Probabilities (...) that a fix is right: of bootstrapping exactly, of integer least squares between bounds.

    bootstrapped: of bootstrapping, exactly; a lower bound for least squares.
    adop: approximation by ADOP; an upper bound for bootstrapping.
    variance_lower: all ambiguities taken as uncorrelated; a lower bound for rounding, so for the other two as well.
    adop_upper: the pull-in region taken as a ball of its volume; an upper bound for least squares.
    eigenvalue_lower, eigenvalue_upper: all directions taken as uncertain as the worst, and as the best one.
    pull_in_lower: the largest ellipsoid inside the pull-in region; pull_in_upper: its walls towards the nearest integers.
    is_sharp: bool; False where a node limit ended the search for those nearest integers: the two pull-in bounds hold
    then too, but sharper ones could be had.
    """

    bootstrapped: np.ndarray
    adop: np.ndarray
    variance_lower: np.ndarray
    adop_upper: np.ndarray
    eigenvalue_lower: np.ndarray
    eigenvalue_upper: np.ndarray
    pull_in_lower: np.ndarray
    pull_in_upper: np.ndarray
    is_sharp: np.ndarray

    @property
    def lower(self):
        """The highest of the lower bounds (...) for integer least squares."""
        return np.max([self.bootstrapped, self.variance_lower, self.eigenvalue_lower, self.pull_in_lower], axis=0)

    @property
    def upper(self):
        """The lowest of the upper bounds (...) for integer least squares."""
        return np.min([self.adop_upper, self.eigenvalue_upper, self.pull_in_upper], axis=0)

    def __repr__(self):
        if np.ndim(self.lower) > 0:
            return f"SuccessBounds: {np.size(self.lower)} covariances"
        return f"SuccessBounds: bootstrapping {self.bootstrapped:.2%}, integer least squares {self.lower:.2%} to {self.upper:.2%}"


def success_bounds(Q, *, node_limit=_NODES):
    """Return what can be said of the success rate without simulation, for the ambiguities as they stand.

    Q: (n, n) or (..., n, n) [cycles^2]; bootstrapped, variance_lower and the eigenvalue bounds are better after
    decorrelation (call it with `decorrelate(Q).Q_z` as well), the others stay. Returns SuccessBounds. Raises ValueError
    where Q is not a covariance matrix.
    Source: collected by Verhagen (2003), J. Global Positioning Systems 2:117-124; Verhagen, Li and Teunissen (2013),
    Computers & Geosciences 54:361-376. Rounding <= bootstrapping <= least squares: Teunissen (1998), J. Geodesy
    72:606-612; (1999), J. Geodesy 73:587-593.

    >>> success_bounds([[0.04, 0.0], [0.0, 0.04]])       # sigmas 0.2, nothing correlated: bounds meet
    SuccessBounds: bootstrapping 97.53%, integer least squares 97.53% to 97.53%
    """
    Q = checked_covariance(Q)
    d, n = ltdl(Q).d, Q.shape[-1]
    lower, upper, is_sharp = _pull_in_bounds(Q, node_limit)
    eigenvalues = np.maximum(np.linalg.eigvalsh(Q), np.finfo(float).tiny)  # rounding may leave the smallest below zero
    return SuccessBounds(
        bootstrapped=np.prod(_within_half_a_cycle(d), axis=-1),
        adop=adop_success_rate(_adop(d), n),
        variance_lower=np.prod(_within_half_a_cycle(np.diagonal(Q, axis1=-2, axis2=-1)), axis=-1),
        adop_upper=_ball_of_volume_one(_adop(d), n),
        eigenvalue_lower=_within_half_a_cycle(eigenvalues[..., -1]) ** n,
        eigenvalue_upper=_within_half_a_cycle(eigenvalues[..., 0]) ** n,
        pull_in_lower=lower,
        pull_in_upper=upper,
        is_sharp=is_sharp,
    )


def _within_half_a_cycle(variance):
    """Return P(|x| < 1/2) = 2 Phi(1 / (2 sigma)) - 1 = erf(1 / sqrt(8 variance)) of a normal x."""
    return erf(1.0 / np.sqrt(8.0 * variance))


def _adop(d):
    return np.exp(0.5 * np.mean(np.log(d), axis=-1))


def _ball_of_volume_one(adop, n):
    """P(chi2_n <= c_n / ADOP^2), c_n = Gamma(n/2 + 1)^(2/n) / pi: of all regions of one volume a ball holds most.

    Source: Hassibi and Boyd (1998), IEEE Trans. Signal Processing 46:2938-2952; by ADOP: Teunissen (2000).
    """
    return chdtr(n, np.exp(2.0 / n * gammaln(n / 2.0 + 1.0)) / math.pi / adop**2)


def _pull_in_bounds(Q, node_limit):
    """Return lower and upper bounds (...) from the integers nearest to zero, and whether these are proved.

    The pull-in region of zero ends half way to its neighbours. The ball of half the distance to the nearest lies inside:
    P(chi2_n <= min z' Q^-1 z / 4). The region lies inside the slabs |v_i| <= 1/2, v_i = z_i' Q^-1 a / z_i' Q^-1 z_i.
    Source: Hassibi and Boyd (1998) for the ball, Verhagen (2003) for the slabs.
    """
    decorrelation = decorrelate(Q)
    _, L, d = decorrelation
    n = d.shape[-1]
    near = integer_least_squares(np.zeros(d.shape), decorrelation.Q_z, n_best=_NEAR * n + 1, node_limit=node_limit)
    shortest = np.where(near.complete, near.norms[..., 1], 1.0 / np.max(d, axis=-1))  # no vector is shorter than the latter
    upper = np.empty(d.shape[:-1])
    for index in np.ndindex(upper.shape):
        upper[index] = _slabs(near.candidates[index], L[index], d[index])
    return chdtr(n, shortest / 4.0), upper[()], near.complete


def _slabs(candidates, L, d):
    """Return the bound of the slabs towards n independent integer vectors, the nearest of the candidates (N, n).

    P = product over i of 2 Phi(1 / (2 sigma_i)) - 1, sigma_i of v_i given v_1 ... v_i-1. With e_i = D^(-1/2) L^-T z_i,
    v_i is e_i . x / (e_i . e_i) of a standard normal x, so sigma_i is what of e_i is orthogonal to those before it,
    over e_i . e_i. Any vectors give a bound, also where fewer than n are found.
    """
    z = np.vstack([candidates, np.eye(len(d))])  # unit vectors, lest fewer than n are independent
    e = np.linalg.solve(L.T, z.T).T / np.sqrt(d)
    bound, basis = 1.0, np.empty((0, len(d)))
    for e_i in e[np.argsort(np.sum(e**2, axis=-1), kind="stable")]:
        rest = e_i - basis.T @ (basis @ e_i)
        if np.sum(rest**2) > _DEPENDENT * np.sum(e_i**2):
            bound *= _within_half_a_cycle(np.sum(rest**2) / np.sum(e_i**2) / np.sum(e_i**2))
            basis = np.vstack([basis, rest / np.sqrt(np.sum(rest**2))])
    return bound
