"""Decorrelation: an integer change of variables after which rounding is nearly the best one can do.

The ambiguities of one epoch are so correlated that their confidence ellipse is a needle: the nearest integers to the
float values are almost never the most probable ones. Any integer matrix Z with |det Z| = 1 gives new ambiguities
z = Z' a which are integers exactly when a are, with covariance Q_z = Z' Q Z. Z is made of two kinds of steps on the
factors of Q_z = L' diag(d) L (L unit lower triangular, d_i the variance of z_i once z_i+1 ... z_n are known):

* integer Gauss: z_j <- z_j - mu z_i, mu the integer nearest to L_ij. This leaves |L_ij| <= 1/2, and d alone.
* permutation of the neighbours z_j and z_j+1, wherever it makes the conditional variance d_j+1 smaller.

The product of all d is det Q and stays; the permutations even it out, until the last variables, which the search fixes
first, are as well known as the others (Teunissen 1995; de Jonge and Tiberius 1996; in lattice words: LLL reduction).
Three savings of Chang, Yang and Zhou (2005) are used: the factorisation already takes the smallest variance for the
last place; after an exchange only the neighbours are looked at again; and off the subdiagonal, which decides
nothing, the Gauss steps wait until the end.

Inside the kernels U = L' is kept, so that a Gauss step runs along rows.
"""

import math
from typing import NamedTuple

import numpy as np

from gnsslab.core.jit import kernel, kernel_input, matrix, vector

GOOD, NOT_FINITE, NOT_SYMMETRIC, NOT_POSITIVE, TOO_LARGE = range(5)

_ASYMMETRY = 1e-8  # |Q_ij - Q_ji| / sqrt(Q_ii Q_jj): rounding stays below, a wrong formula does not
_ROUNDING = 4 * 2.0**-52  # times n Q_ii: what rounding leaves of a conditional variance that is zero
_GAIN = 1.0 - 1e-6  # an exchange must gain this much: else equal variances would change places for ever
_EXACT = 2.0**52  # integers up to here are exact in float64


class Decorrelation(NamedTuple):
    """Z' Q Z = L' diag(d) L: Z (..., n, n) int64 with |det Z| = 1, L (..., n, n) unit lower, d (..., n) [Q's unit]."""

    Z: np.ndarray
    L: np.ndarray
    d: np.ndarray


def decorrelate(Q):
    """Find integer combinations z = Z' a that are nearly uncorrelated, and the factors of their covariance.

    Z' Q Z = L' diag(d) L

    Q: (n, n) or (..., n, n) covariance of the ambiguities [cycles^2]. Returns Z, L, d; d_i is the variance of z_i
    given z_i+1 ... z_n. Raises ValueError where Q is not a covariance matrix.
    Source: Teunissen (1995), J. Geodesy 70:65-82; Chang, Yang and Zhou (2005), J. Geodesy 79:552-565.

    >>> Z, L, d = decorrelate([[5.0, 4.0], [4.0, 3.3]])
    >>> (Z.T @ [[5.0, 4.0], [4.0, 3.3]] @ Z).round(6).tolist()
    [[1.7, 0.1], [0.1, 0.3]]
    """
    Q = checked_covariance(Q)
    Z, L, d = np.empty(Q.shape, dtype=np.int64), np.empty(Q.shape), np.empty(Q.shape[:-1])
    for index in np.ndindex(Q.shape[:-2]):
        Z[index], L[index], d[index], status = decorrelate_kernel(kernel_input(Q[index]))
        raise_status(status, index)
    return Decorrelation(Z, L, d)


def checked_covariance(Q):
    """Return Q (..., n, n) as float64, or say what is wrong with its shape."""
    Q = np.asarray(Q, dtype=np.float64)
    if Q.ndim < 2 or Q.shape[-1] != Q.shape[-2] or Q.shape[-1] == 0:
        raise ValueError(f"Q must be a covariance matrix of shape (n, n) or (..., n, n) with n >= 1; it has shape {Q.shape}.")
    return Q


_COMPLAINTS = {
    NOT_FINITE: "{} contains NaN or infinity; leave out the ambiguities that were not estimated before fixing the others.",
    NOT_SYMMETRIC: "{} is not symmetric; a covariance matrix is, so look at how it was made, or pass (Q + Q.T) / 2 if rounding did it.",
    NOT_POSITIVE: "{} is not positive definite; at least one combination of its ambiguities has no variance: "
    "look for a satellite used twice, or too few measurements.",
    TOO_LARGE: "{} mixes variances too different to decorrelate exactly (integers above 2^52 arise); are all ambiguities in cycles?",
}


def raise_status(status, index):
    """Turn a kernel's status into ValueError; index is the place in the stack of matrices, () for a single one."""
    if status != GOOD:
        name = "Q[" + ", ".join(str(k) for k in index) + "]" if index else "Q"
        raise ValueError(_COMPLAINTS[status].format(name))


@kernel
def decorrelate_kernel(Q):
    """Decorrelate one Q (n, n): returns Z (n, n), L (n, n), d (n) and a status, GOOD where the three are to be used."""
    n = len(Q)
    U, d, T, W = matrix(n, n), vector(n), identity(n), identity(n)
    status = decorrelate_in_place(Q, U, d, T, W)
    return transposed(T), unit_lower(U), d, status


@kernel
def decorrelate_in_place(Q, U, d, T, W):
    """Write U = L' and d of the decorrelated Q, and make T <- Z' T, W <- Z^-1 W; returns a status.

    T (n, w) carries along whatever is to be decorrelated: float ambiguities in its columns, or the identity to get Z'.
    W (n, n), the identity at first, brings integers back: a_k = sum over i of z_i W_ik.
    """
    status = copy_symmetric(Q, U)
    if status == GOOD:
        status = factor(U, d, T, W)
    if status == GOOD:
        permute(U, d, T, W)
        status = shorten(U, T, W)
    return status


@kernel
def copy_symmetric(Q, A):
    """Write (Q + Q') / 2 to A; returns a status."""
    n = len(Q)
    for i in range(n):
        for j in range(i + 1):
            difference, size = Q[i][j] - Q[j][i], Q[i][i] * Q[j][j]
            A[i][j] = A[j][i] = 0.5 * (Q[i][j] + Q[j][i])
            if not abs(A[i][j]) < math.inf:
                return NOT_FINITE
            if difference * difference > _ASYMMETRY * _ASYMMETRY * abs(size):
                return NOT_SYMMETRIC
    return GOOD


@kernel
def factor(U, d, T, W):
    """Replace the covariance standing in U by its factors U and d, the smallest conditional variance last.

    From the last row up: d_j = A_jj, U_ij = A_ij / d_j, A_ik <- A_ik - U_ij A_jk. Before each step the variable that is
    known best, given those already taken, changes places with j.
    """
    n = len(d)
    for i in range(n):
        d[i] = U[i][i]
    for j in range(n - 1, -1, -1):
        best = j
        for i in range(j):
            if U[i][i] < U[best][best]:
                best = i
        if best != j:
            for i in range(j + 1):
                U[i][best], U[i][j] = U[i][j], U[i][best]
            exchange(U, d, T, W, best, j)
        A_j, variance, d[j] = U[j], d[j], U[j][j]
        if not d[j] > n * _ROUNDING * variance:
            return NOT_POSITIVE
        for i in range(j):
            A_i = U[i]
            A_i[j] /= d[j]
            for k in range(j):
                A_i[k] -= A_i[j] * A_j[k]
    return GOOD


@kernel
def exchange(U, d, T, W, i, j):
    """Let the variables i and j change places in all that has one row a variable."""
    d[i], d[j] = d[j], d[i]
    exchange_rows(U, i, j, 0)
    exchange_rows(T, i, j, 0)
    exchange_rows(W, i, j, 0)


@kernel
def exchange_rows(A, i, j, start):
    """Let the rows i and j of A change places, from column `start` on."""
    A_i, A_j = A[i], A[j]
    for k in range(start, len(A_i)):
        A_i[k], A_j[k] = A_j[k], A_i[k]


@kernel
def permute(U, d, T, W):
    """Exchange neighbours, after a Gauss step, while that makes a later conditional variance smaller.

    With u = U_j,j+1 the variance of z_j given z_j+2 ... is d_j + u^2 d_j+1: less than d_j+1, z_j should come later.
    """
    n = len(d)
    j = n - 2
    while j >= 0:
        u = U[j][j + 1]
        mu = math.floor(u + 0.5)
        u -= mu
        later = d[j] + u * u * d[j + 1]
        if later < _GAIN * d[j + 1]:
            if mu != 0:
                gauss(U, T, W, j, j + 1, mu)
            exchange_neighbours(U, d, T, W, j, u, later)
            j = min(j + 1, n - 2)
        else:
            j -= 1


@kernel
def exchange_neighbours(U, d, T, W, j, u, later):
    """Exchange z_j and z_j+1, and refactor: d_j+1' = later, d_j' = d_j d_j+1 / later, u' = u d_j+1 / later."""
    u_new, rest = u * d[j + 1] / later, d[j] / later
    for i in range(j):
        U_i = U[i]
        a, b = U_i[j], U_i[j + 1]
        U_i[j], U_i[j + 1] = b - u * a, u_new * b + rest * a
    d[j], d[j + 1] = rest * d[j + 1], later
    exchange_rows(U, j, j + 1, j + 2)
    exchange_rows(T, j, j + 1, 0)
    exchange_rows(W, j, j + 1, 0)
    U[j][j + 1] = u_new


@kernel
def shorten(U, T, W):
    """Make all |U_ij| <= 1/2 by Gauss steps; returns a status."""
    n = len(U)
    for j in range(n - 2, -1, -1):
        for i in range(j + 1, n):
            mu = math.floor(U[j][i] + 0.5)
            if mu != 0:
                gauss(U, T, W, j, i, mu)
    for i in range(n):
        for k in range(n):
            if abs(W[i][k]) > _EXACT:
                return TOO_LARGE
    return GOOD


@kernel
def gauss(U, T, W, j, i, mu):
    """Replace z_j by z_j - mu z_i, i > j."""
    U_j, U_i, T_j, T_i, W_j, W_i = U[j], U[i], T[j], T[i], W[j], W[i]
    U_j[i] -= mu
    for k in range(i + 1, len(U)):
        U_j[k] -= mu * U_i[k]
    for k in range(len(T_j)):
        T_j[k] -= mu * T_i[k]
    for k in range(len(W_j)):
        W_i[k] += mu * W_j[k]


@kernel
def identity(n):
    """Allocate the identity."""
    A = matrix(n, n)
    set_identity(A)
    return A


@kernel
def set_identity(A):
    """Overwrite a square A by the identity."""
    for i in range(len(A)):
        for j in range(len(A)):
            A[i][j] = 1.0 if i == j else 0.0


@kernel
def transposed(A):
    """Return A' of a square A."""
    n = len(A)
    B = matrix(n, n)
    for i in range(n):
        for j in range(n):
            B[j][i] = A[i][j]
    return B


@kernel
def unit_lower(U):
    """Return L = U', reading U above its diagonal only."""
    n = len(U)
    L = identity(n)
    for i in range(n):
        for j in range(i + 1, n):
            L[j][i] = U[i][j]
    return L
