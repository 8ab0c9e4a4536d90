"""The point of a sphere nearest to a given one, in the metric of a covariance matrix: exactly, by the secular equation.

minimise (b - c)' Q^-1 (b - c) over |b| = l

In the principal axes of Q = V diag(q) V' a stationary point has b_i = c_i / (1 + nu q_i). The smallest cost belongs to the
largest nu, beyond the pole of the largest q; with t = 1 + nu q_max > 0 and r_i = q_i / q_max

    x_i = 1 - r_i + t r_i,    b_i = c_i / x_i,    sum b_i^2 = l^2        (secular equation)

1 / |b(t)| is concave and grows with t, so Newton's steps from the left never pass the root. If c has no part along the
longest axis, t may reach 0 with |b| still too short (the hard case): then b gets what is missing along that axis,
on either side. Source: Gander (1981), Numer. Math. 36:291-307; More and Sorensen (1983), SIAM J. Sci. Stat. Comput. 4:553-572.
"""

import math
from typing import NamedTuple

import numpy as np

from gnsslab.core.covariance import check_symmetric
from gnsslab.core.jit import kernel, kernel_input, vector

_MOST_STEPS = 60  # Newton doubles the digits each time; three to six steps are usual
_MOST_SWEEPS = 20  # of Jacobi rotations; four are usual


class OnSphere(NamedTuple):
    """The nearest points of a sphere and how far they are."""

    b: np.ndarray  # (..., p) [m]
    cost: np.ndarray  # (...) squared distances in the metric of Q


def nearest_on_sphere(c, Q, length):
    """Return the points b of |b| = length nearest to c (..., p) in the metric of Q (p, p), and their squared distances.

    minimise (b - c)' Q^-1 (b - c) over |b| = length

    c, length: [m]; Q: [m^2]. Scaling c to the length is the answer only where all axes of Q are equal. Where two points
    are equally near, one of them is returned. Raises ValueError where Q is no covariance matrix or shapes do not fit.

    >>> found = nearest_on_sphere([0.0, 2.0], [[4.0, 0.0], [0.0, 1.0]], 1.0)
    >>> found.b.tolist(), float(found.cost)
    ([0.0, 1.0], 1.0)
    >>> nearest_on_sphere([0.0, 0.3], [[4.0, 0.0], [0.0, 1.0]], 1.0).b.round(6).tolist()       # the hard case
    [0.916515, 0.4]
    """
    c, Q = np.asarray(c, dtype=np.float64), np.asarray(Q, dtype=np.float64)
    _check(c, Q, length)
    q, V = np.linalg.eigh(Q)
    if not q[0] > len(q) * np.finfo(float).eps * q[-1]:  # rounding leaves this much of an eigenvalue that is zero
        raise ValueError("Q is not positive definite, as a covariance must be")
    b, cost = np.empty_like(c), np.empty(c.shape[:-1])
    for index in np.ndindex(cost.shape):
        point, cost[index] = _nearest_in_axes(kernel_input(V.T @ c[index]), kernel_input(q), float(length))
        b[index] = V @ np.asarray(point)
    return OnSphere(b, cost)


def _check(c, Q, length):
    if Q.ndim != 2 or Q.shape[0] != Q.shape[1] or c.shape[-1:] != Q.shape[:1]:
        raise ValueError(f"c must be (..., p) and Q (p, p) with the same p; they have shapes {c.shape} and {Q.shape}")
    if not (np.all(np.isfinite(c)) and np.all(np.isfinite(Q))):
        raise ValueError("c and Q must be finite; they contain NaN or infinity")
    check_symmetric(Q, "Q")
    if not 0 < length < math.inf:
        raise ValueError(f"the length must be a positive number of metres; it is {length}")


@kernel
def _nearest_in_axes(c, q, length):
    b = vector(len(c))
    return b, sphere_kernel(c, q, length, b)


@kernel
def sphere_kernel(c, q, length, b):
    """Write the nearest point to b (p,), all in principal axes with variances q (p,) > 0; returns the squared distance.

    b_i - c_i = (1 - t) r_i b_i, so the cost is ((1 - t) / q_max)^2 sum q_i b_i^2.
    """
    p, longest = len(c), 0
    for i in range(p):
        if q[i] > q[longest]:
            longest = i
    q_max = q[longest]
    t = 0.0  # no term alone may exceed l^2: the root is not left of any t at which one does
    for i in range(p):
        r = q[i] / q_max
        t = max(t, (abs(c[i]) / length - (1.0 - r)) / r)
    for _ in range(_MOST_STEPS):
        total, slope = 0.0, 0.0
        for i in range(p):
            r = q[i] / q_max
            x = 1.0 - r + t * r
            b[i] = c[i] / x if c[i] != 0.0 else 0.0
            total += b[i] * b[i]
            slope += b[i] * b[i] * r / x if c[i] != 0.0 else 0.0
        if total <= length * length:
            break
        step = (math.sqrt(total) / length - 1.0) * total / slope
        if t + step == t:
            break
        t += step
    if t == 0.0:
        b[longest] = math.sqrt(max(length * length - total, 0.0))
    cost = 0.0
    for i in range(p):
        cost += q[i] * b[i] * b[i]
    return cost * ((1.0 - t) / q_max) ** 2


@kernel
def principal_axes(Q, q, V):
    """Write the eigenvalues of a symmetric Q (p, p) to q and its eigenvectors to the rows of V, by Jacobi's rotations; Q is used up."""
    p = len(q)
    for i in range(p):
        for j in range(p):
            V[i][j] = 1.0 if i == j else 0.0
    for _ in range(_MOST_SWEEPS):
        rest = 0.0
        for i in range(p):
            for j in range(i):
                if Q[i][j] * Q[i][j] > 1e-34 * abs(Q[i][i] * Q[j][j]):
                    rest += 1.0
                    rotate(Q, V, i, j)
        if rest == 0.0:
            break
    for i in range(p):
        q[i] = Q[i][i]


@kernel
def rotate(Q, V, i, j):
    """Turn the axes i and j until Q_ij is zero (Golub and Van Loan, Matrix Computations, 8.5.2)."""
    ratio = (Q[j][j] - Q[i][i]) / (2.0 * Q[i][j])
    tangent = math.copysign(1.0, ratio) / (abs(ratio) + math.sqrt(1.0 + ratio * ratio))
    cosine = 1.0 / math.sqrt(1.0 + tangent * tangent)
    sine = tangent * cosine
    for k in range(len(V)):
        Q[k][i], Q[k][j] = cosine * Q[k][i] - sine * Q[k][j], sine * Q[k][i] + cosine * Q[k][j]
    for k in range(len(V)):
        Q[i][k], Q[j][k] = cosine * Q[i][k] - sine * Q[j][k], sine * Q[i][k] + cosine * Q[j][k]
        V[i][k], V[j][k] = cosine * V[i][k] - sine * V[j][k], sine * V[i][k] + cosine * V[j][k]
