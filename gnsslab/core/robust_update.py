"""Kalman update by measurements that may be wrong and whose errors may be correlated: the equivalent covariance."""

from typing import NamedTuple

import numpy as np
from scipy.linalg import cho_factor, cho_solve


class RobustUpdate(NamedTuple):
    """State after an update, and what was made of the measurements."""

    x: np.ndarray  # (n,)
    P: np.ndarray  # (n, n)
    innovation: np.ndarray  # (k,) z - H x
    weight: np.ndarray  # (k,) eta in [0, 1]; 0 where z is NaN


def robust_update(x, P, H, R, z, weight):
    """Return the `RobustUpdate` of a state x (n,), P (n, n) by measurements z (k,) = H x + e, e ~ N(0, R).

        v_i = (z - H x)_i / sqrt((H P H' + R)_ii),  eta_i = weight(v_i),  lambda_i = 1 / eta_i,  R_bar_ij = sqrt(lambda_i lambda_j) R_ij

    R_bar keeps the correlations of R. Measurements with eta = 0, and NaN, are left out. That is a jump where errors are correlated: one
    with eta near 0 still tells of the errors of the others, as of an error near 0. The gain is K = P H' (H P H' + R_bar)^-1, and P is
    in Joseph's form. Raises ValueError for shapes that do not fit and for an R that is not positive definite.

    Source: Yang, Song and Xu (2002), Robust estimator for correlated observations based on bifactor equivalent weights, J. Geodesy 76:353-358.

    >>> from gnsslab.core.robust import igg3
    >>> done = robust_update([0.0], [[4.0]], [[1.0], [1.0]], [[4.0, 0.0], [0.0, 4.0]], [2.0, 90.0], igg3(1, 2))
    >>> done.x.round(9).tolist(), done.P.round(9).tolist(), done.weight.tolist()
    ([1.0], [[2.0]], [1.0, 0.0])
    """
    x, P, H, R, z = (np.asarray(array, dtype=np.float64) for array in (x, P, H, R, z))
    _check_shapes(x, P, H, R, z)
    innovation = z - H @ x
    eta = _weights(innovation, H @ P @ H.T + R, weight)
    used = eta > 0
    root = np.sqrt(eta[used])  # rows times root have R where R_bar was: no 1 / eta
    x_new, P_new = _joseph_update(x, P, H[used] * root[:, None], R[np.ix_(used, used)], innovation[used] * root)
    return RobustUpdate(x_new, P_new, innovation, eta)


def _check_shapes(x, P, H, R, z):
    n, k = x.size, z.size
    if (x.shape, P.shape, H.shape, R.shape, z.shape) != ((n,), (n, n), (k, n), (k, k), (k,)):
        expected = f"expected x ({n},), P ({n}, {n}), H ({k}, {n}), R ({k}, {k}) and z ({k},)"
        raise ValueError(f"{expected}; got x {x.shape}, P {P.shape}, H {H.shape}, R {R.shape} and z {z.shape}")
    if k and not (np.isfinite(R).all() and np.linalg.eigvalsh(R)[0] > 0):
        raise ValueError("R, the covariance of the measurements, must be positive definite: its smallest eigenvalue is not above zero")


def _weights(innovation, S, weight):
    """Return eta of each innovation; 0 for NaN."""
    present = np.isfinite(innovation)
    eta = np.zeros(len(innovation))
    eta[present] = weight(innovation[present] / np.sqrt(np.diag(S)[present]))
    return eta


def _joseph_update(x, P, H, R, v):
    """Return x + K v and (I - K H) P (I - K H)' + K R K'."""
    if not len(v):
        return x.copy(), P.copy()
    HP = H @ P
    K = cho_solve(cho_factor(HP @ H.T + R), HP).T
    J = np.eye(len(x)) - K @ H
    P = J @ P @ J.T + K @ R @ K.T
    return x + K @ v, (P + P.T) / 2
