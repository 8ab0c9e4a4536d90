"""Kalman filter steps as small kernels, in place, usable on any state.

State x (n,) with covariance P (n, n); innovation z (k,) with covariance S = H P H' + R = C C', C lower triangular.
With W = C^-1 H P and w = C^-1 z the update is x + W'w, P - W'W: P stays symmetric and nothing is inverted. w has unit
covariance when the model holds, so w'w is chi-square with k degrees of freedom. W and w stand side by side in one matrix.
"""

import math

from gnsslab.core.jit import kernel, matrix


@kernel
def predict(x, P, F, Q, offset):
    """Move x and P one step on, in place: the first p states go x_p <- F x_p + offset, P_pp <- F P_pp F' + Q; the others stay.

    F, Q (p, p), offset (p,). F = 0 with a large Q forgets these states and starts again at the offset.

    >>> import numpy as np
    >>> x, P = np.array([1.0, 5.0]), np.eye(2)
    >>> predict(x, P, np.array([[2.0]]), np.array([[0.5]]), np.array([0.0]))
    >>> x.tolist(), P.tolist()
    ([2.0, 5.0], [[4.5, 0.0], [0.0, 1.0]])
    """
    p, n = len(offset), len(x)
    moved = matrix(p, n + 1)  # F [P_p, x_p]
    for i in range(p):
        for j in range(p):
            add_multiple(moved[i], P[j], F[i][j])
            moved[i][n] += F[i][j] * x[j]
    for i in range(p):
        x[i] = moved[i][n] + offset[i]
        for j in range(p, n):
            P[i][j] = P[j][i] = moved[i][j]
        for j in range(p):
            P[i][j] = Q[i][j]
            for k in range(p):
                P[i][j] += moved[i][k] * F[j][k]


@kernel
def add_multiple(row, other, factor):
    """Add factor times another row to a row, in place, over the shorter one's length."""
    if factor != 0.0:
        for k in range(min(len(row), len(other))):
            row[k] += factor * other[k]


@kernel
def factor_cholesky(S):
    """Replace a symmetric positive definite S (k, k) by its lower triangular factor C, C C' = S; only the lower half is read and written.

    Where rounding leaves nothing above zero of a diagonal entry, it and its column become 0: the sign of a singular S.

    >>> import numpy as np
    >>> S = np.array([[4.0, 2.0], [2.0, 10.0]])
    >>> factor_cholesky(S)
    >>> np.tril(S).tolist()
    [[2.0, 0.0], [1.0, 3.0]]
    """
    for i in range(len(S)):
        S_i = S[i]
        for j in range(i):
            S_j, rest = S[j], S_i[j]
            for k in range(j):
                rest -= S_i[k] * S_j[k]
            S_i[j] = rest / S_j[j] if S_j[j] > 0.0 else 0.0
        rest = S_i[i]
        for k in range(i):
            rest -= S_i[k] * S_i[k]
        S_i[i] = math.sqrt(max(rest, 0.0))


@kernel
def solve_lower(C, B):
    """Replace B (k, m) by C^-1 B, C (k, k) lower triangular, by forward substitution.

    >>> import numpy as np
    >>> B = np.array([[2.0], [3.0]])
    >>> solve_lower(np.array([[2.0, 0.0], [1.0, 1.0]]), B)
    >>> B.tolist()
    [[1.0], [2.0]]
    """
    for i in range(len(B)):
        B_i, C_i = B[i], C[i]
        for j in range(i):
            add_multiple(B_i, B[j], -C_i[j])
        for m in range(len(B_i)):
            B_i[m] /= C_i[i]


@kernel
def update(x, P, W):
    """Add W'w to x and subtract W'W from P, in place; w is the last column of W (k, n + 1).

    >>> import numpy as np
    >>> x, P, W = np.zeros(1), np.eye(1), np.array([[1.0, 2.0]]) / np.sqrt(2)  # H = 1, R = 1, z = 2
    >>> update(x, P, W)
    >>> x.round(12).tolist(), P.round(12).tolist()
    ([1.0], [[0.5]])
    """
    n = len(x)
    for k in range(len(W)):
        W_k = W[k]
        for i in range(n):
            x[i] += W_k[i] * W_k[n]
            P_i = P[i]
            for j in range(i + 1):
                P_i[j] -= W_k[i] * W_k[j]
    for i in range(n):
        for j in range(i):
            P[j][i] = P[i][j]


@kernel
def worst_outlier(C, W, A):
    """Return the column of A (k, m) along which an error would best explain the innovation, and by how many sigma.

    |a' S^-1 z| / sqrt(a' S^-1 a): the w-test of Baarda (1968) on the innovation (Teunissen 1990, detection, identification and
    adaptation), standard normal when the model holds. w is the last column of W; A is overwritten by C^-1 A.

    >>> import numpy as np
    >>> worst_outlier(np.eye(2), np.array([[0.5], [-4.0]]), np.eye(2))
    (1, 4.0)
    """
    solve_lower(C, A)
    worst, most = -1, 0.0
    for column in range(len(A[0])):
        explained, length = 0.0, 0.0
        for k in range(len(A)):
            explained += A[k][column] * W[k][-1]
            length += A[k][column] * A[k][column]
        if explained * explained > most * most * length:
            worst, most = column, abs(explained) / math.sqrt(length)
    return worst, most


@kernel
def is_consistent(W):
    """Return whether w'w, w the last column of W (k, n + 1), passes the chi-square test that one good epoch in a thousand fails.

    The quantile is that of Wilson and Hilferty (1931), good to a percent from k = 6 on, 3 % high at k = 1: k (1 - 2 / 9k + 3.09 sqrt(2 / 9k))^3.
    """
    k, total = len(W), 0.0
    for i in range(k):
        total += W[i][-1] * W[i][-1]
    return k == 0 or total < k * (1 - 2 / (9 * k) + 3.09 * math.sqrt(2 / (9 * k))) ** 3
