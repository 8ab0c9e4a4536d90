"""The mixed model y = A a + B b + e: some unknowns are integers, some are not.

Least squares first takes all of them as real numbers (float solution); once the integers are known, the others improve.
"""

import math
from typing import NamedTuple

import numpy as np

from gnsslab.core.covariance import check_symmetric


class MixedModel(NamedTuple):
    """y = A a + B b + e, a integer, b real, e ~ N(0, Q_y)."""

    A: np.ndarray  # (k, n), change of the measurements with the integers
    B: np.ndarray  # (k, p), change of the measurements with the real unknowns
    Q_y: np.ndarray  # (k, k), covariance of the measurements


class FloatSolution(NamedTuple):
    """Least squares that takes the integers a for real numbers; many solutions of one model share their covariance."""

    a_hat: np.ndarray  # (..., n) [cycles]
    b_hat: np.ndarray  # (..., p), in GNSS a baseline [m]
    Q_a: np.ndarray  # (n, n) or (..., n, n) [cycles^2]
    Q_b: np.ndarray  # (p, p) or (..., p, p)
    Q_ba: np.ndarray  # (p, n) or (..., p, n)
    length_used: bool = False  # a known length of b has gone into it

    def __repr__(self):
        known = ", known length used" if self.length_used else ""
        *stack, n = np.shape(self.a_hat)
        return f"FloatSolution: {math.prod(stack)} of {n} ambiguities, {np.shape(self.b_hat)[-1]} real unknowns{known}"


def solve_float(y, A, B, Q_y):
    """Return the FloatSolution of y (..., k) = A (k, n) a + B (k, p) b + e, e ~ N(0, Q_y), with all unknowns real.

    x = (M' Q_y^-1 M)^-1 M' Q_y^-1 y,    M = (A, B),  x = (a, b)

    A, B and Q_y (k, k) are shared by all y. Raises ValueError where the shapes do not fit, Q_y is not positive definite,
    or the measurements cannot tell all unknowns apart. A NaN in y makes the solution of that y NaN, the others stay.
    Source: Teunissen (1995), J. Geodesy 70:65-82, eq. 2 to 5.

    One carrier of wavelength 0.2 m and one code measure a distance of 3.1 m; 0.1 m and 0.01 m are their sigmas:

    >>> found = solve_float([3.1, 3.1 + 0.2 * 7], [[0.0], [0.2]], [[1.0], [1.0]], [[0.01, 0.0], [0.0, 0.0001]])
    >>> found.a_hat.round(6).tolist(), found.b_hat.round(6).tolist(), found.Q_a.round(6).tolist()
    ([7.0], [3.1], [[0.2525]])
    """
    y, A, B, Q_y = (np.asarray(array, dtype=np.float64) for array in (y, A, B, Q_y))
    M, n = _both_designs(y, A, B, Q_y), A.shape[1]
    WM = _whitened(M, Q_y)
    Q = _inverse(M.T @ WM)
    x = y @ (WM @ Q)
    return FloatSolution(x[..., :n], x[..., n:], Q[:n, :n], Q[n:, n:], Q[n:, :n])


def given_integers(solution, a_fix):
    """Return b (..., p) and its covariance (p, p), given the integers a_fix (..., n) of a FloatSolution.

    b_fix = b_hat - Q_ba Q_a^-1 (a_hat - a_fix),    Q_b|a = Q_b - Q_ba Q_a^-1 Q_ab

    Real values in place of integers do as well. Raises ValueError where a_fix does not fit, or Q_a is singular.
    Source: Teunissen (1995), J. Geodesy 70:65-82, eq. 7 and 8.

    >>> found = FloatSolution(np.array([7.2]), np.array([3.0]), np.array([[0.2525]]), np.array([[0.01]]), np.array([[-0.05]]))
    >>> b_fix, Q_b_fix = given_integers(found, [7])
    >>> b_fix.round(4).tolist(), Q_b_fix.round(6).tolist()
    ([3.0396], [[9.9e-05]])
    """
    a_hat, a_fix = np.asarray(solution.a_hat), np.asarray(a_fix)
    if a_fix.shape[-1:] != a_hat.shape[-1:]:
        raise ValueError(f"a_fix must have one value for each of the {a_hat.shape[-1]} ambiguities in its last axis; it has shape {a_fix.shape}")
    return given_known(solution.b_hat, solution.Q_b, np.asarray(solution.Q_ba), np.asarray(solution.Q_a), a_hat - a_fix)


def given_known(b_hat, Q_b, Q_bz, Q_z, off):
    """Return b (..., p) and its covariance, given that k quantities correlated with it are off (..., k) by so much.

    b = b_hat - Q_bz Q_z^-1 off,    Q_b|z = Q_b - Q_bz Q_z^-1 Q_zb

    Q_bz: (..., p, k); Q_z: (..., k, k). Raises ValueError where Q_z is singular.

    >>> [value.round(6).tolist() for value in given_known([3.0], [[0.01]], np.array([[-0.05]]), np.array([[0.2525]]), [0.2])]
    [[3.039604], [[9.9e-05]]]
    """
    try:
        gain = np.linalg.solve(Q_z, Q_bz.mT).mT  # Q_bz Q_z^-1 (..., p, k)
    except np.linalg.LinAlgError:
        raise ValueError("the covariance of what is to be known is singular: two of the integers or combinations depend on each other") from None
    return b_hat - np.matvec(gain, off), Q_b - gain @ Q_bz.mT


def use_length(solution, length, sigma):
    """Return the FloatSolution with |b| = length entered as one more measurement, linearised at the float b.

    l - |b_hat| = h' (b - b_hat) + e,    h = b_hat / |b_hat|,    e ~ N(0, sigma^2)

    The row is good where b is known much better than its length; else it bends the solution (|b_hat| is too long by
    sigma_b^2 / 2l for each direction across, and h points the wrong way). The result says `length_used`, so that
    nobody uses the length a second time. Raises ValueError for a length or sigma that is not positive, and for a float
    baseline of zero, which has no direction.

    >>> free = FloatSolution(np.array([7.2]), np.array([0.0, 3.0]), np.array([[1.0]]), np.eye(2), np.array([[0.0], [0.5]]))
    >>> tied = use_length(free, 2.0, 0.01)
    >>> tied.b_hat.round(3).tolist(), tied.a_hat.round(3).tolist(), tied.length_used
    ([0.0, 2.0], [6.7], True)
    """
    _refuse_second_use(solution)
    _check_positive(length, "length", "m")
    _check_positive(sigma, "sigma of the length", "m")
    norm = np.linalg.norm(solution.b_hat, axis=-1)
    if np.any(norm == 0):
        raise ValueError("a float baseline is zero, so it has no direction to linearise the length in: take fix_with_length")
    h = solution.b_hat / norm[..., None]  # (..., p)
    Q_bh, Q_ah = np.matvec(solution.Q_b, h), np.matvec(np.swapaxes(solution.Q_ba, -1, -2), h)
    S = np.vecdot(h, Q_bh) + sigma**2  # (...) of the innovation
    gain = (length - norm) / S
    return FloatSolution(
        a_hat=solution.a_hat + Q_ah * gain[..., None],
        b_hat=solution.b_hat + Q_bh * gain[..., None],
        Q_a=solution.Q_a - _outer(Q_ah, Q_ah) / S[..., None, None],
        Q_b=solution.Q_b - _outer(Q_bh, Q_bh) / S[..., None, None],
        Q_ba=solution.Q_ba - _outer(Q_bh, Q_ah) / S[..., None, None],
        length_used=True,
    )


def _refuse_second_use(solution):
    if solution.length_used:
        raise ValueError("this float solution has used the known length already; a second use would count it twice: start from the one without it")


def _check_positive(value, name, unit):
    if not 0 < value < np.inf:
        raise ValueError(f"the {name} must be a positive number of {unit}; it is {value:g}")


def _outer(left, right):
    return left[..., :, None] * right[..., None, :]


def _both_designs(y, A, B, Q_y):
    """Return M = (A, B), or say which shape does not fit."""
    k = y.shape[-1] if y.ndim else 0
    for name, array in (("A", A), ("B", B), ("Q_y", Q_y)):
        if array.ndim != 2 or array.shape[0] != k:
            raise ValueError(f"{name} must have one row for each of the {k} measurements in y's last axis; it has shape {array.shape}")
    if Q_y.shape != (k, k):
        raise ValueError(f"Q_y must have shape ({k}, {k}), one row and column a measurement; it has shape {Q_y.shape}")
    return np.hstack([A, B])


def _whitened(M, Q_y):
    """Return Q_y^-1 M, or say why Q_y is no covariance matrix."""
    if not (np.all(np.isfinite(Q_y)) and np.all(np.isfinite(M))):
        raise ValueError("A, B and Q_y must be finite; they contain NaN or infinity: leave out what was not measured")
    check_symmetric(Q_y, "Q_y")
    try:
        C = np.linalg.cholesky(Q_y)
    except np.linalg.LinAlgError:
        raise ValueError("Q_y is not positive definite, as a covariance must be: look for a sigma of zero or a row used twice") from None
    return np.linalg.solve(C.T, np.linalg.solve(C, M))


def _inverse(N):
    """Return the inverse of a normal matrix, scaled to a unit diagonal first, so that metres and cycles do not matter."""
    try:
        if not np.all(np.diag(N) > 0):
            raise np.linalg.LinAlgError("no measurement depends on an unknown")
        scale = 1.0 / np.sqrt(np.diag(N))
        C = np.linalg.cholesky(N * np.outer(scale, scale))
    except np.linalg.LinAlgError:
        raise ValueError("the measurements cannot tell all unknowns apart: there are too few, or two unknowns act alike") from None
    half = np.linalg.solve(C, np.diag(scale))
    return half.T @ half
