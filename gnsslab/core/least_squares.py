"""Weighted least squares of many small problems at once: y = A x + e, e ~ N(0, diag(sigma^2)), stacks in front (..., k, p).

Each problem of a stack has its own mask of used rows, so the problems of a stack may differ in size: rows that are not used,
and unknowns that no used row speaks of, are left out of that problem.
"""

from typing import NamedTuple

import numpy as np

# A pivot of the normal matrix with unit diagonal is sin^2 of the angle between a column and those before it.
# Columns closer than 1e-5 rad are taken as the same: float64 leaves five digits in 1e-10.
SMALLEST_PIVOT = 1e-10
# An error in a row of redundancy r shows in its residual as r times itself; below this only rounding is left of it.
SMALLEST_REDUNDANCY = 1e-6


class LeastSquares(NamedTuple):
    """Solutions of a stack of problems; NaN where a problem, an unknown or a row has no answer."""

    x: np.ndarray  # (..., p) estimates
    Q: np.ndarray  # (..., p, p) their covariance (A' W A)^-1, W = diag(1 / sigma^2)
    residual: np.ndarray  # (..., k) y - A x, also of rows with a number that were not used
    normalised: np.ndarray  # (..., k) residual / its own standard deviation, 0 where the row is not used or not checked by others
    used: np.ndarray  # (..., k) bool
    chi_square: np.ndarray  # (...) sum over used rows of (residual / sigma)^2
    redundancy: np.ndarray  # (...) int, rows less unknowns; negative where there are too few rows
    is_solved: np.ndarray  # (...) bool, enough rows and no two unknowns alike


def least_squares(A, y, sigma, used=None):
    """Return the `LeastSquares` solutions of y (..., k) = A (..., k, p) x + e with standard deviations sigma (..., k).

    x = Q A' W y,  Q = (A' W A)^-1,  w = v / (sigma sqrt(1 - h)),  h = diag(A Q A' W)     (Teunissen 2000, Adjustment theory)

    `used` (..., k) masks rows; rows with a NaN are never used. An unknown with only zeros in its column is left out
    (its x is NaN). A problem with fewer rows than unknowns, or unknowns that cannot be told apart, is not solved.

    >>> fit = least_squares([[1.0], [1.0], [1.0]], [1.0, 2.0, 6.0], [1.0, 1.0, 1.0])
    >>> [round(float(v), 6) for v in (fit.x[0], fit.Q[0, 0], fit.chi_square)]
    [3.0, 0.333333, 14.0]
    """
    A, y, sigma = (np.asarray(array, dtype=float) for array in (A, y, sigma))
    used = _usable(A, y, sigma, used)
    weight_root = np.divide(1.0, sigma, out=np.zeros(used.shape), where=used)
    A_w = np.where(used[..., None], A * weight_root[..., None], 0.0)  # (..., k, p) rows of unit weight
    y_w = np.where(used, y * weight_root, 0.0)
    F, present, is_solved = _inverse_factor(_transpose(A_w) @ A_w)  # Q = F F'
    redundancy = used.sum(axis=-1) - present.sum(axis=-1)
    is_solved &= (redundancy >= 0) & present.any(axis=-1)
    half = A_w @ F  # (..., k, p), orthonormal columns
    x = _matvec(F, _matvec(_transpose(half), y_w))
    v_w = y_w - _matvec(A_w, x)
    return LeastSquares(
        x=np.where(present & is_solved[..., None], x, np.nan),
        Q=np.where(_both(present) & is_solved[..., None, None], F @ _transpose(F), np.nan),
        residual=np.where(is_solved[..., None], y - _matvec(A, x), np.nan),
        normalised=np.where(is_solved[..., None], _normalised(v_w, half, used), 0.0),
        used=used,
        chi_square=np.where(is_solved, np.vecdot(v_w, v_w), np.nan),
        redundancy=redundancy,
        is_solved=is_solved,
    )


def worst_rows(fit, threshold):
    """Return the rows (..., k) to remove next by data snooping: in each problem the largest |normalised residual| above the threshold.

    A problem of redundancy 1 offers none: there all normalised residuals are alike, an error shows but not where it is (Baarda 1968).
    """
    size = np.abs(fit.normalised)
    if size.size == 0:
        return np.zeros(size.shape, dtype=bool)
    worst = np.argmax(size, axis=-1)[..., None]
    found = (np.take_along_axis(size, worst, axis=-1) > threshold) & (fit.redundancy >= 2)[..., None]
    return found & (np.arange(size.shape[-1]) == worst)


def screened_least_squares(A, y, sigma, used=None, threshold=4.0):
    """Return the `LeastSquares` solutions after data snooping: the row with the largest |normalised residual| above the threshold is
    removed and the problem solved again, until none is left or redundancy runs out.

    The default 4 removes a good row in one case of 16 000.

    >>> A, sigma = [[1.0]] * 5, [1.0] * 5
    >>> screened_least_squares(A, [1.0, 2.0, 90.0, 1.5, 1.5], sigma).used.tolist()
    [True, True, False, True, True]
    """
    fit = least_squares(A, y, sigma, used)
    for _ in range(fit.used.shape[-1]):
        worst = worst_rows(fit, threshold)
        if not worst.any():
            break
        fit = least_squares(A, y, sigma, fit.used & ~worst)
    return fit


def _usable(A, y, sigma, used):
    """Return the mask (..., k) of rows that are wanted and complete, in the shape of the whole stack."""
    complete = np.isfinite(y) & np.isfinite(sigma) & np.isfinite(np.einsum("...p->...", A))  # a sum is quicker than four questions
    if np.any(sigma <= 0):
        raise ValueError("least squares expects standard deviations above zero, one is zero or negative: mask the row or give its sigma")
    return complete if used is None else complete & np.asarray(used, dtype=bool)


def _inverse_factor(N):
    """Return F (..., p, p) with F F' = N^-1, which unknowns are present (..., p) and whether those can be told apart (...).

    Cholesky N = L L' of the normal matrix scaled to a unit diagonal, column by column for the whole stack; F = L^-T scaled back.
    An absent unknown, one with a zero on the diagonal, gets zeros.
    """
    i = np.arange(N.shape[-1])
    present = N[..., i, i] > 0.0
    scale = np.sqrt(np.where(present, N[..., i, i], 1.0))
    N_u = N / (scale[..., :, None] * scale[..., None, :])
    N_u[..., i, i] = 1.0
    L, is_regular = _cholesky(N_u)
    F = _transpose(_lower_inverse(L)) / scale[..., :, None]
    return np.where(_both(present), F, 0.0), present, is_regular


def _cholesky(N):
    """Return L (..., p, p) of N = L L' and whether all pivots are large enough (...); a pivot too small is replaced by one."""
    L = np.zeros_like(N)
    is_regular = np.ones(N.shape[:-2], dtype=bool)
    for j in range(N.shape[-1]):
        column = N[..., j:, j] - _matvec(L[..., j:, :j], L[..., j, :j])
        good = column[..., 0] > SMALLEST_PIVOT
        is_regular &= good
        L[..., j:, j] = column / np.sqrt(np.where(good, column[..., 0], 1.0))[..., None]
        L[..., j, j] = np.where(good, L[..., j, j], 1.0)
    return L, is_regular


def _lower_inverse(L):
    """Return the inverse of lower triangular matrices (..., p, p) by forward substitution."""
    M = np.zeros_like(L)
    for i in range(L.shape[-1]):
        M[..., i, i] = 1.0
        M[..., i, :i] = -(L[..., i, None, :i] @ M[..., :i, :i])[..., 0, :]
        M[..., i, : i + 1] /= L[..., i, i, None]
    return M


def _normalised(v_w, half, used):
    """Return residuals of unit weight (..., k) over their standard deviation sqrt(1 - h); 0 where h is 1: nothing checks that row."""
    redundancy_number = 1.0 - np.vecdot(half, half)
    checked = used & (redundancy_number > SMALLEST_REDUNDANCY)
    spread = np.sqrt(np.where(checked, redundancy_number, 1.0))
    return np.where(checked, v_w / spread, 0.0)


def _both(present):
    return present[..., :, None] & present[..., None, :]


def _transpose(matrix):
    return np.swapaxes(matrix, -1, -2)


def _matvec(matrix, vector):
    return (matrix @ vector[..., None])[..., 0]
