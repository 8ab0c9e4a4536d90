"""The known length as one more measurement of a filter whose first three states are the baseline: four ways to enter it.

z = l - |b|,  H = b' / |b|,  R = sigma^2     (paper A: Wang, Li, Sun and Ji 2019, equations 14, 32, and 16 mended)

|b| is not linear in b. Where b is known to decimetres only, the row points the wrong way and is sure of it, so that the
integers found afterwards are wrong: each way deals with that differently.
"""

import math
from enum import IntEnum

from gnsslab.core.jit import kernel, matrix, vector
from gnsslab.core.kalman import add_multiple, update

_SURE = 0.1  # of the length: a baseline with a larger sigma is no place to linearise the length at (RTKLIB's guard)
_ROUNDS = 10  # of the iterated row; two to four are usual
_ENOUGH = 1e-6  # [m], step at which it stops


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
    if use == _GUARDED and P[0][0] + P[1][1] + P[2][2] > 3.0 * (_SURE * length) ** 2:
        return _DROPPED, math.nan, math.nan
    z, S = _linearised(x, P, b, h, length, variance)
    if use == _SECOND_ORDER:
        bias, spread = _curvature(P, b, h)
        z, S = z - bias, S + spread
    if use == _ITERATED:
        for _ in range(_ROUNDS):
            if _step(x, P, b, h, z / S) < _ENOUGH:
                break
            z, S = _linearised(x, P, b, h, length, variance)
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
def _step(x, P, b, h, gain):
    """Move b to x_b + P h gain, in place; return how far."""
    square = 0.0
    for i in range(3):
        moved = x[i]
        for j in range(3):
            moved += P[i][j] * h[j] * gain
        square += (moved - b[i]) ** 2
        b[i] = moved
    return math.sqrt(square)


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
