"""Rounding and bootstrapping: the two quick ways from float ambiguities to integers.

Rounding takes every ambiguity for itself. Bootstrapping rounds the last one, corrects the others for what that tells
about them (they are correlated), rounds the last but one, and so on. Both are as good as least squares where nothing
is correlated, which is what decorrelation is for: `z_hat = Z' a_hat`, round, and `restore`.

A tie, a fraction of exactly one half, goes up, in -0.5 as in 0.5: then a whole number of cycles more gives a whole
number more, which rounding to even would not.
"""

import numpy as np

from gnsslab.core.integers.decorrelation import checked_covariance, ltdl

_NO_FRACTION = 2.0**51  # float64 of this size and more come in steps of a half or an integer


def integer_rounding(a_hat):
    """Round each float ambiguity to its nearest integer.

    a_hat: (..., n) float ambiguities [cycles]. Returns (..., n) int64; ties go up. Raises ValueError where a_hat is not
    finite or so large that it has no fraction. Source: Teunissen (1998), J. Geodesy 72:606-612, section 3.

    >>> integer_rounding([0.4, -0.4, 0.5, -0.5, 1.5]).tolist()
    [0, 0, 1, 0, 2]
    """
    a_hat = np.asarray(a_hat, dtype=np.float64)
    if not np.isfinite(a_hat).all():
        raise ValueError("a_hat contains NaN or infinity: leave out the ambiguities that were not estimated.")
    if np.any(np.abs(a_hat) >= _NO_FRACTION):
        raise ValueError("a_hat is 2^51 cycles or more, where float64 has no fractions left: subtract an approximate integer first.")
    return _nearest(a_hat).astype(np.int64)


def _nearest(x):
    below = np.floor(x)
    return below + (x - below >= 0.5)  # floor(x + 0.5) would be wrong just below one half, where the sum rounds to 1


def integer_bootstrapping(a_hat, Q):
    """Round the ambiguities one after the other, the last first, each conditioned on those already rounded.

    c_k = a_hat_k - sum over i > k of (c_i - a_i) L_ik,   a_k = nearest integer to c_k,   Q = L' diag(d) L

    a_hat: (..., n) float ambiguities [cycles]; Q: (n, n) or (..., n, n) their covariance [cycles^2], as they stand:
    decorrelate before if wanted. Returns (..., n) int64; ties go up. Raises ValueError where shapes do not fit, where
    Q is no covariance matrix, or where a_hat is not finite.
    Source: Teunissen (1998), J. Geodesy 72:606-612, section 4 (there the first comes first).

    >>> integer_bootstrapping([0.6, 0.7], [[0.05, 0.04], [0.04, 0.04]]).tolist()      # a_2 is 0.3 too small, so is a_1
    [1, 1]
    """
    a_hat, (L, _) = checked_stack(a_hat, Q), ltdl(Q)
    whole = integer_rounding(a_hat)
    c = np.broadcast_to(a_hat - whole, np.broadcast_shapes(a_hat.shape, L.shape[:-1])).copy()
    a = np.zeros_like(c)
    for k in range(c.shape[-1] - 1, -1, -1):
        a[..., k] = _nearest(c[..., k])
        c[..., :k] -= (c[..., k] - a[..., k])[..., None] * L[..., k, :k]
    return whole + a.astype(np.int64)


def checked_stack(a_hat, Q):
    """Return a_hat (..., n) as float64, or say how it does not fit Q (n, n) or (..., n, n)."""
    a_hat, shape = np.asarray(a_hat, dtype=np.float64), checked_covariance(Q).shape
    if a_hat.shape[-1:] != shape[-1:]:
        raise ValueError(f"a_hat must have one value for each row of Q, {shape[-1]}, in its last axis; it has shape {a_hat.shape}.")
    try:
        np.broadcast_shapes(a_hat.shape[:-1], shape[:-2])
    except ValueError:
        raise ValueError(f"The stacks of a_hat {a_hat.shape} and Q {shape} do not fit: one Q, or one for each a_hat.") from None
    return a_hat
