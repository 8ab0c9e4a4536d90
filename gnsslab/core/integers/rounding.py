"""Rounding and bootstrapping: the two quick ways from float ambiguities to integers.

Rounding takes every ambiguity for itself. Bootstrapping rounds the last one, corrects the others for what that tells
about them (they are correlated), rounds the last but one, and so on. Both do as well as least squares where nothing is
correlated, and nearly as well where little is, which is what decorrelation is for: `z_hat = Z' a_hat`, round, `restore`.

A tie, a fraction of exactly one half, goes up, in -0.5 as in 0.5: then a whole number of cycles more in a_hat gives as
many more in the integers, which rounding to even would not.
"""

import numpy as np

from gnsslab.core.integers.decorrelation import checked_covariance, checked_stack, ltdl
from gnsslab.core.integers.search import HAS_NO_FRACTION, NO_FRACTION, NOT_A_FLOAT, raise_problem


def integer_rounding(a_hat):
    """Round each float ambiguity to its nearest integer.

    a_hat: (..., n) float ambiguities [cycles]. Returns (..., n) int64; ties go up. Raises ValueError where a_hat is not
    finite, or so large that it has no fraction. Source: Teunissen (1998), J. Geodesy 72:606-612.

    >>> integer_rounding([0.4, -0.4, 0.5, -0.5, 1.5]).tolist()
    [0, 0, 1, 0, 2]
    """
    a_hat = np.asarray(a_hat, dtype=np.float64)
    if not np.isfinite(a_hat).all():
        raise_problem(NOT_A_FLOAT, 0, ())
    if np.any(np.abs(a_hat) >= NO_FRACTION):
        raise_problem(HAS_NO_FRACTION, 0, ())
    return _nearest(a_hat).astype(np.int64)


def _nearest(x):
    below = np.floor(x)
    return below + (x - below >= 0.5)  # floor(x + 0.5) is wrong just below one half, where the sum rounds to 1


def integer_bootstrapping(a_hat, Q):
    """Round the ambiguities one after the other, the last first, each conditioned on those already rounded.

    a_k = nearest integer to c_k,   c_k = a_hat_k + sum over i > k of (a_i - c_i) L_ik,   Q = L' diag(d) L

    a_hat: (..., n) float ambiguities [cycles]; Q: (n, n) or (..., n, n) their covariance [cycles^2], taken as they
    stand: decorrelate before if wanted. Returns (..., n) int64; ties go up. Raises ValueError where shapes do not fit,
    where Q is no covariance matrix, or where a_hat is not finite.
    Source: Teunissen (1998), J. Geodesy 72:606-612 (there the first ambiguity comes first).

    >>> integer_bootstrapping([0.4, 0.7], [[0.05, 0.04], [0.04, 0.04]]).tolist()   # a_2 is 0.3 too small, so is a_1
    [1, 1]
    """
    a_hat, Q = np.asarray(a_hat, dtype=np.float64), checked_covariance(Q)
    stack, L = checked_stack(a_hat, Q), ltdl(Q).L
    whole = integer_rounding(a_hat)
    c = np.broadcast_to(a_hat - whole, (*stack, Q.shape[-1])).copy()  # without the integers: exact for 1e8 cycles too
    a = np.empty(c.shape, dtype=np.int64)
    for k in range(c.shape[-1] - 1, -1, -1):
        a[..., k] = _nearest(c[..., k])
        c[..., :k] += (a[..., k] - c[..., k])[..., None] * L[..., k, :k]
    return whole + a
