"""The known length as one more measurement of a filter whose first three states are the baseline: four ways to enter it.

z = l - |b|,  H = b' / |b|,  R = sigma^2     (paper A: Wang, Li, Sun and Ji 2019, equations 14, 32, and 16 mended)

|b| is not linear in b. Where b is known to decimetres only, the row points the wrong way and is sure of it, so that the
integers found afterwards are wrong: each way deals with that differently.
"""

import math
from enum import IntEnum

from gnsslab.core.jit import kernel, matrix, vector
from gnsslab.core.kalman import add_multiple, update
from gnsslab.core.sphere import principal_axes, sphere_kernel

SURE = 0.1  # of the length: a baseline with a larger sigma is no place to linearise the length at (RTKLIB's guard)


class LengthUse(IntEnum):
    """Where the known length goes."""

    NOWHERE = 0
    GUARDED_ROW = 1  # a measurement, linearised; dropped while the baseline is uncertain by more than a tenth of the length
    ROW = 2  # the same at every epoch
    ITERATED_ROW = 3  # linearised again where the update has led, until it stays (iterated extended Kalman filter)
    SECOND_ORDER_ROW = 4  # its bias and its uncertainty by curvature taken into account (second-order extended Kalman filter)
    SEARCH = 5  # not in the filter but in the search for the integers: C-LAMBDA


class RowState(IntEnum):
    """What became of the length's row at an epoch."""

    NONE = 0
    USED = 1
    DROPPED = 2


# Kernels know them as floats.
_NOWHERE, _GUARDED, AS_ROW, _ITERATED, _SECOND_ORDER, IN_SEARCH = (float(use) for use in LengthUse)
_NONE, _USED, _DROPPED = (float(state) for state in RowState)


@kernel
def update_by_length(x, P, length, sigma, use):
    """Update x, P by |b| = length, in place; return the RowState, the innovation [m] and its sigma (NaN where no row is used)."""
    if use in (_NOWHERE, IN_SEARCH):
        return _NONE, math.nan, math.nan
    variance, h, b = sigma**2, vector(3), vector(3)
    for axis in range(3):
        b[axis] = x[axis]
    if use == _GUARDED and P[0][0] + P[1][1] + P[2][2] > 3.0 * (SURE * length) ** 2:
        return _DROPPED, math.nan, math.nan
    if use == _ITERATED:
        _go_to_most_likely(x, P, b, length, variance)
    z, S = _linearised(x, P, b, h, length, variance)
    if use == _SECOND_ORDER:
        bias, spread = _curvature(P, b, h)
        z, S = z - bias, S + spread
    _update_by_row(x, P, h, z, S)
    return _USED, z, math.sqrt(S)


@kernel
def _linearised(x, P, b, h, length, variance):
    """Write h = b / |b|; return the innovation z = l - |b| - h' (x_b - b) and its variance S = h' P h + sigma^2."""
    norm = math.sqrt(b[0] * b[0] + b[1] * b[1] + b[2] * b[2])
    z, S = length - norm, variance
    for i in range(3):
        h[i] = b[i] / norm
        z -= h[i] * (x[i] - b[i])
    for i in range(3):
        for j in range(3):
            S += h[i] * P[i][j] * h[j]
    return z, S


@kernel
def _go_to_most_likely(x, P, b, length, variance):
    """Move b, in place, to where the iteration ends: the least of (b - x_b)' P_b^-1 (b - x_b) + (l - |b|)^2 / sigma^2.

    Found at once, as Gauss and Newton's steps leave a sphere again that is small beside the sigma of b. The same cost has a
    b + e on the sphere, e ~ N(0, sigma^2 I): with Q = P_b + sigma^2 I, s the point nearest to x_b in its metric, b is
    s - sigma^2 Q^-1 (s - x_b), and both parts point to s.
    """
    Q, V, rows = matrix(3, 3), matrix(3, 3), matrix(3, 3)
    q, turned, s = rows[0], rows[1], rows[2]
    for i in range(3):
        for j in range(3):
            Q[i][j] = P[i][j] + (variance if i == j else 0.0)
    principal_axes(Q, q, V)
    for i in range(3):
        for j in range(3):
            turned[i] += V[i][j] * x[j]
    sphere_kernel(turned, q, length, s)
    for j in range(3):
        b[j] = 0.0
        for i in range(3):
            b[j] += V[i][j] * (s[i] - variance * (s[i] - turned[i]) / q[i])


@kernel
def _curvature(P, b, h):
    """Return what |b| exceeds its linear form by in the mean, tr(M P) / 2 |b|, and the variance of that, tr(M P M P) / 2 |b|^2; M = I - h h'."""
    norm = math.sqrt(b[0] * b[0] + b[1] * b[1] + b[2] * b[2])
    MP, bias, spread = matrix(3, 3), 0.0, 0.0
    for i in range(3):
        for j in range(3):
            for k in range(3):
                MP[i][j] += ((1.0 if i == k else 0.0) - h[i] * h[k]) * P[k][j]
        bias += MP[i][i] / (2.0 * norm)
    for i in range(3):
        for j in range(3):
            spread += MP[i][j] * MP[j][i] / (2.0 * norm * norm)
    return bias, spread


@kernel
def _update_by_row(x, P, h, z, S):
    """Update x, P by one measurement of h' b with innovation z and its variance S, in place."""
    n = len(x)
    W = matrix(1, n + 1)
    for axis in range(3):
        add_multiple(W[0], P[axis], h[axis] / math.sqrt(S))
    W[0][n] = z / math.sqrt(S)
    update(x, P, W)
