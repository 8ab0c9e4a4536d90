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

from gnsslab.core.covariance import ASYMMETRY, is_symmetric
from gnsslab.core.jit import kernel, kernel_input, matrix, nearest

GOOD, NOT_FINITE, NOT_SYMMETRIC, NOT_POSITIVE, TOO_LARGE = range(5)

_ROUNDING = 4 * 2.0**-52  # times n Q_ii: what rounding leaves of a conditional variance that is zero
_GAIN = 1.0 - 1e-6  # an exchange must gain this much: else equal variances would change places for ever
_EXACT = 2.0**52  # integers up to here are exact in float64


class Decorrelation(NamedTuple):
    """Z' Q Z = L' diag(d) L: Z (..., n, n) int64 with |det Z| = 1, L (..., n, n) unit lower, d (..., n) [Q's unit]."""

    Z: np.ndarray
    L: np.ndarray
    d: np.ndarray

    @property
    def Q_z(self):
        """Covariance of the combinations, L' diag(d) L (..., n, n): exactly symmetric, and without the digits that Z' Q Z loses."""
        root = np.sqrt(self.d)[..., None] * self.L
        return root.mT @ root

    @property
    def inverse(self):
        """Z^-1 (..., n, n) int64, exactly: a = inverse' z, for real z as well."""
        inverse = np.empty_like(self.Z)
        for index in np.ndindex(self.Z.shape[:-2]):
            inverse[index] = _inverse(self.Z[index])
        return inverse

    def restore(self, z):
        """Return the ambiguities a (..., n) int64 whose combinations Z' a are the integers z (..., n), exactly.

        Raises ValueError where z does not hold n whole numbers in its last axis.

        >>> decorrelation = decorrelate([[5.0, 4.0], [4.0, 3.3]])
        >>> decorrelation.restore(decorrelation.Z.T @ [100_000_007, -3]).tolist()
        [100000007, -3]
        """
        with np.errstate(invalid="ignore"):  # NaN becomes some integer, which it does not equal
            whole = np.asarray(z).astype(np.int64)
        n = self.d.shape[-1]
        if whole.shape[-1:] != (n,) or not np.array_equal(whole, z):
            raise ValueError(f"z must be whole numbers, {n} in its last axis, as integer_least_squares gives; for real z take inverse.mT @ z.")
        return np.matvec(self.inverse.mT, whole)


def _inverse(Z):
    """Return the inverse of an integer matrix (n, n) with determinant 1 or -1, exactly, by Gauss and Jordan modulo 2^64.

    There every odd number has a reciprocal, and as det Z is odd each column has an odd pivot. The entries of Z^-1 are
    below 2^52 (`reduce` sees to it), so nothing is lost by counting modulo 2^64.
    """
    n = len(Z)
    A = np.hstack([Z, np.eye(n, dtype=np.int64)]).astype(np.uint64)
    for k in range(n):
        pivot = k + np.argmax(A[k:, k] % 2)
        A[[k, pivot]] = A[[pivot, k]]
        A[k] *= np.uint64(pow(int(A[k, k]), -1, 2**64))
        others = np.arange(n) != k
        A[others] -= A[others, k, None] * A[k]
    return A[:, n:].astype(np.int64)


class LtDL(NamedTuple):
    """Q = L' diag(d) L: L (..., n, n) unit lower triangular, d (..., n) conditional variances [Q's unit]."""

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
        *result, status = decorrelate_kernel(kernel_input(Q[index]))
        raise_status(status, index)
        Z[index], L[index], d[index] = result
    return Decorrelation(Z, L, d)


def ltdl(Q):
    """Factor a covariance as it stands, without decorrelation.

    Q = L' diag(d) L

    Q: (n, n) or (..., n, n) [cycles^2]. Returns L, unit lower triangular, and d; d_i is the variance of a_i given
    a_i+1 ... a_n, and L_ij (i > j) what one cycle of error in a_i moves a_j. Raises ValueError where Q is not a
    covariance matrix. Source: de Jonge and Tiberius (1996), LGR-Series 12.

    >>> L, d = ltdl([[5.0, 4.0], [4.0, 4.0]])
    >>> L.tolist(), d.tolist()
    ([[1.0, 0.0], [1.0, 1.0]], [1.0, 4.0])
    """
    Q = checked_covariance(Q)
    _refuse(~np.isfinite(Q).all(axis=(-2, -1)), NOT_FINITE)
    variance = np.abs(np.diagonal(Q, axis1=-2, axis2=-1))
    _refuse(~is_symmetric(Q), NOT_SYMMETRIC)
    n, A = Q.shape[-1], 0.5 * (Q + Q.mT)
    L, d = np.zeros(Q.shape), np.zeros(Q.shape[:-1])
    for j in range(n - 1, -1, -1):
        d[..., j] = A[..., j, j]
        _refuse(~(d[..., j] > n * _ROUNDING * variance[..., j]), NOT_POSITIVE)
        L[..., j, : j + 1] = A[..., j, : j + 1] / d[..., j, None]
        A[..., :j, :j] -= L[..., j, :j, None] * A[..., j, None, :j]
    return LtDL(L, d)


def _refuse(bad, status):
    """Raise what a status says of the first bad matrix of a stack, bad (...)."""
    if np.any(bad):
        raise_status(status, np.argwhere(bad)[0].tolist())


def checked_covariance(Q):
    """Return Q (..., n, n) as float64, or say what is wrong with its shape."""
    Q = np.asarray(Q, dtype=np.float64)
    shape = Q.shape
    if len(shape) < 2 or shape[-1] != shape[-2] or shape[-1] == 0:
        raise ValueError(f"Q must be a covariance matrix of shape (n, n) or (..., n, n) with n >= 1; it has shape {Q.shape}.")
    return Q


def checked_stack(a_hat, Q):
    """Return the shape of the stack that the arrays a_hat (..., n) and Q (n, n) or (..., n, n) make, or say how they do not fit."""
    shape, n = a_hat.shape, Q.shape[-1]
    if not shape or shape[-1] != n:
        raise ValueError(f"a_hat must have one value for each row of Q, {n}, in its last axis; it has shape {shape}.")
    if Q.ndim == 2:
        return shape[:-1]
    try:
        return np.broadcast_shapes(shape[:-1], Q.shape[:-2])
    except ValueError:
        raise ValueError(f"The stacks of a_hat {a_hat.shape} and Q {Q.shape} do not fit: one Q, or one for each a_hat.") from None


def one_covariance(Q):
    """Return one Q (n, n) as float64, or say that there are more."""
    Q = checked_covariance(Q)
    if Q.ndim != 2:
        raise ValueError(f"Q must be one covariance matrix (n, n); it has shape {Q.shape}: call this for each.")
    return Q


def checked_problem(a_hat, Q):
    """Return a_hat (..., n) and one Q (n, n) as float64, or say how they do not fit."""
    a_hat, Q = np.asarray(a_hat, dtype=np.float64), one_covariance(Q)
    checked_stack(a_hat, Q)
    return a_hat, Q


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
    M, W, d, Z, L = matrix(n, 2 * n), matrix(n, n), matrix(1, n)[0], matrix(n, n), matrix(n, n)
    for i in range(n):
        M[i][n + i] = 1.0
    status = factor(Q, M, W, d)
    if status == GOOD:
        status = reduce(M, W, d, 0.5)
    for i in range(n):
        L[i][i] = 1.0
        for j in range(n):
            Z[j][i] = M[i][n + j]
            if abs(Z[j][i]) > _EXACT:
                status = TOO_LARGE
            if j > i:
                L[j][i] = M[i][j]
    return Z, L, d, status


@kernel
def factor(Q, M, W, d):
    """Factor P' Q P = U diag(d) U', the smallest conditional variance last; U, P' T to M = (U, T), P' to W; returns a status.

    From the last row up: d_j = A_jj, U_ij = A_ij / d_j, A_ik <- A_ik - U_ij A_jk. Before each step the variable that is
    known best, given those already taken, changes places with j.
    """
    n = len(d)
    status = start(Q, M, W, d)
    for j in range(n - 1, -1, -1):
        best = j
        for i in range(j):
            if M[i][i] < M[best][best]:
                best = i
        if best != j:
            for i in range(j + 1):
                M[i][best], M[i][j] = M[i][j], M[i][best]
            d[best], d[j] = d[j], d[best]
            exchange_rows(M, best, j, 0)
            exchange_rows(W, best, j, 0)
        variance, d[j] = d[j], M[j][j]
        if status == GOOD and not d[j] > n * _ROUNDING * variance:
            status = NOT_POSITIVE
        if status != GOOD:
            return status
        M_j, weight = M[j], 1.0 / d[j]
        for i in range(j):
            M_i = M[i]
            u = M_i[j] = M_i[j] * weight
            for k in range(j):
                M_i[k] -= u * M_j[k]
    return status


@kernel
def start(Q, M, W, d):
    """Write (Q + Q') / 2 to M, the variances to d and the identity to W; returns a status."""
    n = len(d)
    for i in range(n):
        d[i] = Q[i][i]
        for j in range(n):
            W[i][j] = 1.0 if i == j else 0.0
            M[i][j] = 0.5 * (Q[i][j] + Q[j][i])
            if not abs(M[i][j]) < math.inf:
                return NOT_FINITE
            if (Q[i][j] - Q[j][i]) ** 2 > ASYMMETRY**2 * abs(Q[i][i] * Q[j][j]):
                return NOT_SYMMETRIC
    return GOOD


@kernel
def reduce(M, W, d, longest):
    """Reduce factors: M = (U, T) (n, n + w) becomes (U, Z' T), W (n, n) becomes Z^-1 W; returns a status.

    Neighbours are exchanged, after a Gauss step, while that makes the later conditional variance smaller. With
    u = U_j,j+1 the variance of z_j given z_j+2 ... is d_j + u^2 d_j+1: less than d_j+1, z_j should come later. Then
    d_j+1' = d_j + u^2 d_j+1, d_j' = d_j d_j+1 / d_j+1', u' = u d_j+1 / d_j+1'.
    T carries along whatever is to be decorrelated: float ambiguities as columns, or the identity to become Z'. W
    brings integers back: a_k = sum over i of z_i W_ik. Entries of U up to `longest` are left as they are: 1/2 is full
    decorrelation; the search, which needs the subdiagonal only, asks no more than that rounding errors stay small.
    """
    n = len(d)
    j = n - 2
    while j >= 0:
        mu = nearest(M[j][j + 1])
        u = M[j][j + 1] - mu
        later = d[j] + u * u * d[j + 1]
        if later >= _GAIN * d[j + 1]:
            j -= 1
            continue
        if mu != 0:
            gauss(M, W, j, j + 1, mu)
        if abs(mu) > 1:  # a large step makes the row long: shorten the rest of it as well
            shorten(M, W, j, 0.5)
        rest, u_new = d[j] / later, u * d[j + 1] / later
        for i in range(j):
            M_i = M[i]
            a, b = M_i[j], M_i[j + 1]
            M_i[j], M_i[j + 1] = b - u * a, u_new * b + rest * a
        d[j], d[j + 1] = rest * d[j + 1], later
        exchange_rows(M, j, j + 1, j + 2)
        exchange_rows(W, j, j + 1, 0)
        M[j][j + 1] = u_new
        j = min(j + 1, n - 2)
    for j in range(n - 2, -1, -1):
        shorten(M, W, j, longest)
    for i in range(n):
        for k in range(n):
            if abs(W[i][k]) > _EXACT:
                return TOO_LARGE
    return GOOD


@kernel
def shorten(M, W, j, longest):
    """Take the nearest integer off U_ji for all i > j where |U_ji| > longest."""
    for i in range(j + 1, len(W)):
        if abs(M[j][i]) > longest:
            gauss(M, W, j, i, nearest(M[j][i]))


@kernel
def gauss(M, W, j, i, mu):
    """Replace z_j by z_j - mu z_i, i > j."""
    M_j, M_i, W_j, W_i = M[j], M[i], W[j], W[i]
    M_j[i] -= mu
    for k in range(i + 1, len(M_j)):
        M_j[k] -= mu * M_i[k]
    for k in range(len(W_j)):
        W_i[k] += mu * W_j[k]


@kernel
def exchange_rows(A, i, j, start):
    """Let the rows i and j of A change places, from column `start` on."""
    A_i, A_j = A[i], A[j]
    for k in range(start, len(A_i)):
        A_i[k], A_j[k] = A_j[k], A_i[k]
