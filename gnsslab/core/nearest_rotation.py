"""The rotation that brings the antennas of a rigid body nearest to where they were measured, all correlations counted.

The baselines of a rigid body are b_i = R f_i, with f_i known in the body frame. Measured baselines fit no rotation exactly.
If all coordinates were independent and equally good, a singular value decomposition would give the best one (Wahba 1965;
Kabsch 1976). GNSS baselines are not: up is worse than east, and baselines that share an antenna are correlated.

A body of rank rho (1: antennas in line, 2: in a plane, 3: in space) spans rho axes t_j, f_i = sum over j of X_ij t_j. What can be
measured of R are the turned axes u_j = R t_j, an orthonormal frame; they are found by `nearest_frame`.
"""

from typing import NamedTuple

import numpy as np

from gnsslab.core.jit import kernel_input, matrix
from gnsslab.core.nearest_frame import MEETING, nearest_frame, rotations_of_the_cube

_THIN = 1e-6  # of the largest length: antennas nearer than that to a line or plane (a micrometre in a metre) lie in it


class NearestRotation(NamedTuple):
    """The rotation that fits measured baselines best."""

    rotation: np.ndarray  # (..., 3, 3), b_i = R f_i; of antennas in line, one of the many that serve
    baselines: np.ndarray  # (..., k, 3) [m], the R f_i
    misfit: np.ndarray  # (...), squared distance from the measured baselines in the metric of their covariance
    bound: np.ndarray  # (...), no rotation has a smaller misfit than this

    @property
    def is_proved(self):
        """True (...) where misfit and bound meet; else the misfit is the lowest of the minima reached from 24 starts."""
        return self.misfit <= self.bound + MEETING * (self.bound + 1.0)


class BodyAxes(NamedTuple):
    """Axes of a body in the order of its antennas: f_i = sum over j of X_ij t_j."""

    X: np.ndarray  # (k, rho) [m]
    T: np.ndarray  # (3, 3), the t_j as rows, a right-handed set; the first rho carry the antennas


def nearest_rotation(b, Q_b, body):
    """Return the NearestRotation of measured baselines b (..., k, 3).

    minimise (b - (R f_1, ..., R f_k))' Q_b^-1 (b - (R f_1, ..., R f_k)) over rotations R

    b: [m]; Q_b (3k, 3k) [m^2], baseline by baseline, three coordinates each; body: f (k, 3) [m], one row a baseline.
    Raises ValueError where shapes do not fit, Q_b is not positive definite, or the body has a baseline of length zero.

    Two antennas east and north of a third; the measured ones are turned by a right angle and 10 % too long:

    >>> body = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]
    >>> found = nearest_rotation([[0.0, 1.1, 0.0], [-1.1, 0.0, 0.0]], 0.01 * np.eye(6), body)
    >>> found.baselines.round(6).tolist(), round(float(found.misfit), 6), bool(found.is_proved)
    ([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]], 2.0, True)
    """
    body, b, Q_b = checked_body(body), np.asarray(b, dtype=np.float64), np.asarray(Q_b, dtype=np.float64)
    _check(body, b, Q_b)
    X, T = body_axes(body)
    M, u_hat, rest = _of_axes(b.reshape(*b.shape[:-2], -1), Q_b, X)
    E, misfit, bound = np.empty((*rest.shape, 3, 3)), np.empty(rest.shape), np.empty(rest.shape)
    for index in np.ndindex(rest.shape):
        E[index], misfit[index], bound[index] = frame_near(u_hat[index], M)
    R = rotation_of_frame(E, T)
    return NearestRotation(R, body @ R.mT, misfit + rest, bound + rest)


def frame_near(u_hat, M):
    """Return the orthonormal frame nearest to u_hat (3 rho,) in the metric of M as rows (3, 3), its squared distance, and the lower bound."""
    E = matrix(3, 3)
    misfit, bound = nearest_frame(kernel_input(M), kernel_input(u_hat), rotations_of_the_cube(), E)
    return np.asarray(E), misfit, bound


def rotation_of_frame(E, T):
    """Return R (..., 3, 3), which turns the body's axes t_j, rows of T, into the rows u_j of E (..., 3, 3)."""
    return E.mT @ T


def checked_body(body):
    """Return the body (k, 3) as float64, or say what is wrong with it."""
    body = np.asarray(body, dtype=np.float64)
    if body.ndim != 2 or body.shape[1] != 3 or len(body) == 0:
        raise ValueError(f"body must have shape (k, 3), the coordinates of k baselines in the body frame; it has shape {body.shape}.")
    if not np.all(np.isfinite(body)):
        raise ValueError("body contains NaN or infinity; give every antenna's coordinates in metres.")
    lengths = np.linalg.norm(body, axis=1)
    if not np.all(lengths > _THIN * lengths.max()):
        raise ValueError(f"baseline {int(np.argmin(lengths))} of the body has length zero: its two antennas are in one place; leave it out.")
    return body


def body_axes(body):
    """Return the BodyAxes of a body (k, 3): Gram and Schmidt along its antennas, in their order.

    >>> body_axes(np.array([[0.0, 2.0, 0.0], [3.0, 2.0, 0.0]])).X.tolist()
    [[2.0, 0.0], [2.0, 3.0]]
    """
    T, size = np.zeros((0, 3)), np.linalg.norm(body, axis=1).max()
    for f in body:
        across = f - T.T @ (T @ f)
        across = across - T.T @ (T @ across)  # twice, so that a nearly flat body has square axes too
        if np.linalg.norm(across) > _THIN * size:
            T = np.vstack([T, across / np.linalg.norm(across)])
    X, whole = body @ T.T, _completed(T)
    return BodyAxes(X * np.diag(whole[: len(T)] @ T.T), whole)


def _completed(T):
    """Return orthonormal rows (rho, 3) with what makes them a right-handed set (3, 3); of three, the last may change its sign."""
    first = T[0]
    second = T[1] if len(T) > 1 else np.cross(first, np.eye(3)[np.argmin(abs(first))])
    second = second / np.linalg.norm(second)
    return np.array([first, second, np.cross(first, second)])


def _check(body, b, Q_b):
    if b.shape[-2:] != body.shape:
        raise ValueError(f"b must hold one baseline (3,) for each of the body's {len(body)} in its last two axes; it has shape {b.shape}.")
    if Q_b.shape != (body.size, body.size):
        raise ValueError(f"Q_b must have shape ({body.size}, {body.size}), three coordinates for each of {len(body)} baselines; it has {Q_b.shape}.")
    if not (np.all(np.isfinite(b)) and np.all(np.isfinite(Q_b))):
        raise ValueError("b and Q_b must be finite; they contain NaN or infinity.")


def _of_axes(b, Q_b, X):
    """Return the weight matrix M of the axes, their least-squares values u_hat (..., 3 rho), and the misfit (...) no axes can mend.

    M = G' Q_b^-1 G, u_hat = M^-1 G' Q_b^-1 b, G = X x I
    """
    try:
        C = np.linalg.cholesky((Q_b + Q_b.T) / 2)
    except np.linalg.LinAlgError:
        raise ValueError("Q_b is not positive definite, as a covariance must be: look for a baseline that is the difference of two others.") from None
    basis, triangle = np.linalg.qr(np.linalg.solve(C, np.kron(X, np.eye(3))))  # C^-1 G = basis triangle
    b_w = np.linalg.solve(C, b[..., None])[..., 0]
    along = b_w @ basis
    across = b_w - along @ basis.T
    return triangle.T @ triangle, np.linalg.solve(triangle, along[..., None])[..., 0], np.vecdot(across, across)
