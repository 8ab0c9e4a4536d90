"""The filter of relative positioning: baseline, velocity and single-difference ambiguities, fixed to integers at every epoch.

Its state is x = [baseline (3), velocity (3, or none), ambiguities of all channels in cycles]. Measurements enter as double
differences of code and carrier; integers are sought for the double-difference ambiguities, so a change of reference channel
changes only which channels are paired and costs nothing. One source for compiled and plain Python (core.jit).
"""

import math
from typing import NamedTuple

import numpy as np

from gnsslab.core.integers import decorrelate_kernel, search_kernel
from gnsslab.core.integers.decorrelation import GOOD
from gnsslab.core.jit import kernel, kernel_indices, kernel_input, matrix, vector
from gnsslab.core.kalman import add_multiple, factor_cholesky, is_consistent, predict, solve_lower, update, worst_outlier

SIGMA_NEW_AMBIGUITY = 100.0  # [m], of an ambiguity just opened at carrier minus code: above any multipath of the code
OUTLIER_SIGMAS = 4.5  # an innocent measurement is set aside once in 150 000 times
_EXCLUDED = 1e6  # factor on the variance of a measurement set aside: it no longer matters
_NODE_LIMIT = 100_000  # of the integer search; a good epoch needs 10 to 1000


class Block(NamedTuple):
    """T consecutive epochs with the same k channels; d double differences; p states of motion."""

    F: np.ndarray  # (T, p, p) transition of baseline and velocity from the epoch before
    Q: np.ndarray  # (T, p, p) its process noise covariance
    offset: np.ndarray  # (T, p)
    near: np.ndarray  # (T, 3) [m], baseline about which ranges are linearised: metres from the truth is near enough
    anchors: np.ndarray  # (T, k, 3) [m], satellites at transmission, ECEF of the rover's reception, origin at the master
    code: np.ndarray  # (T, k) [m], single difference of code plus the master's modelled range: the rover's range and clock
    phase: np.ndarray  # (T, k) [m], the same from the carrier, with its ambiguity
    sigma_code: np.ndarray  # (T, k) [m], of the single difference
    sigma_phase: np.ndarray  # (T, k) [m]
    slip: np.ndarray  # (T, k) 1 where the ambiguity starts anew, else 0
    drift: np.ndarray  # (T,) [m^2], variance that every ambiguity gains since the epoch before
    wavelength: np.ndarray  # (k,) [m]
    channel: np.ndarray  # (d,) int, a double difference is this channel
    reference: np.ndarray  # (d,) int, minus this one


class Outcome(NamedTuple):
    """What the filter found at each of T epochs."""

    baseline_float: np.ndarray  # (T, 3) [m]
    Q_float: np.ndarray  # (T, 3, 3) [m^2]
    baseline_fixed: np.ndarray  # (T, 3) [m], conditioned on the best integers
    Q_fixed: np.ndarray  # (T, 3, 3) [m^2]
    ratio: np.ndarray  # (T,) second best over best squared norm, 0 where nothing could be searched
    restarted: np.ndarray  # (T,) int, how many ambiguities the filter itself found to have slipped


def filter_block(x, P, block):
    """Run one block from state x (n,), P (n, n); return x, P after its last epoch and the Outcome.

    The first k ambiguity states belong to the block's channels; any further ones are carried along untouched.
    """
    x, P = kernel_input(x), kernel_input(P)
    measured = (kernel_input(values) for values in block[:-2])
    block = Block(*measured, kernel_indices(block.channel), kernel_indices(block.reference))
    rows = np.asarray(_filter_epochs(x, P, block))
    b_float, Q_float, b_fixed, Q_fixed, ratio, restarted = np.split(rows, [3, 12, 15, 24, 25], axis=1)
    square = (len(rows), 3, 3)
    outcome = Outcome(b_float, Q_float.reshape(square), b_fixed, Q_fixed.reshape(square), ratio[:, 0], restarted[:, 0].astype(int))
    return np.asarray(x), np.asarray(P), outcome


@kernel
def _filter_epochs(x, P, block):
    """Move x, P through the block, in place; return a row an epoch with the fields of Outcome side by side (T, 26)."""
    T = len(block.code)
    rows = matrix(T, 26)
    for t in range(T):
        predict(x, P, block.F[t], block.Q[t], block.offset[t])
        _loosen(P, block, t)
        rho, u = _ranges(block.anchors[t], block.near[t])
        _update_by_code(x, P, block, t, rho, u)
        rows[t][25] = _update_by_phase(x, P, block, t, rho, u)
        _copy_baseline(x, P, rows[t], 0)
        _copy_baseline(x, P, rows[t], 12)
        rows[t][24] = _fix(x, P, block, rows[t])
    return rows


@kernel
def _loosen(P, block, t):
    """Let the ambiguities drift, in place: multipath moves the carrier slowly, and no average of hours may be believed to the micrometre."""
    p = len(block.offset[t])
    for i in range(len(block.wavelength)):
        P[p + i][p + i] += block.drift[t] / block.wavelength[i] ** 2


@kernel
def _copy_baseline(x, P, row, start):
    for i in range(3):
        row[start + i] = x[i]
        for j in range(3):
            row[start + 3 + 3 * i + j] = P[i][j]


@kernel
def _ranges(anchors, baseline):
    """Return ranges rho (k,) and unit vectors u (k, 3) from the rover at the baseline's end to the anchors."""
    k = len(anchors)
    rho, u = vector(k), matrix(k, 3)
    for i in range(k):
        for axis in range(3):
            u[i][axis] = anchors[i][axis] - baseline[axis]
        rho[i] = math.sqrt(u[i][0] ** 2 + u[i][1] ** 2 + u[i][2] ** 2)
        for axis in range(3):
            u[i][axis] /= rho[i]
    return rho, u


@kernel
def _update_by_code(x, P, block, t, rho, u):
    """Update x, P by the codes of epoch t, in place; a code that the others contradict is set aside for this epoch."""
    k = len(rho)
    variance, no_wavelength = vector(k), vector(k)
    for i in range(k):
        variance[i] = block.sigma_code[t][i] ** 2
    for _ in range(k // 3 + 1):
        C, W = _innovation(x, P, block, t, block.code[t], rho, u, no_wavelength, variance)
        worst = _outlying_channel(C, W, block, k)
        if worst < 0:
            break
        variance[worst] *= _EXCLUDED
    update(x, P, W)


@kernel
def _update_by_phase(x, P, block, t, rho, u):
    """Update x, P by the carriers of epoch t, in place; return how many ambiguities the others contradicted: they start anew."""
    k = len(rho)
    variance, restarted = vector(k), vector(k)
    for i in range(k):
        variance[i] = block.sigma_phase[t][i] ** 2
        if block.slip[t][i] != 0.0:
            _restart(x, P, block, t, i)
    for _ in range(k // 3 + 1):
        C, W = _innovation(x, P, block, t, block.phase[t], rho, u, block.wavelength, variance)
        worst = _outlying_channel(C, W, block, k)
        if worst < 0 or restarted[worst] > 0:
            break
        restarted[worst] = 1.0
        _restart(x, P, block, t, worst)
    update(x, P, W)
    return sum(restarted)


@kernel
def _restart(x, P, block, t, channel):
    """Open the ambiguity of a channel anew at carrier minus code, in place: a wide prior, no correlation."""
    i = len(block.offset[t]) + channel
    x[i] = (block.phase[t][channel] - block.code[t][channel]) / block.wavelength[channel]
    for j in range(len(x)):
        P[i][j] = P[j][i] = 0.0
    P[i][i] = (SIGMA_NEW_AMBIGUITY / block.wavelength[channel]) ** 2


@kernel
def _innovation(x, P, block, t, measured, rho, u, wavelength, variance):
    """Return C (d, d) and W = C^-1 [H P, z] (d, n + 1) of the double differences of one kind of measurement.

    z = D (measured - rho(near)) - H (x - near),   H = [-D u, 0, D wavelength],   C C' = H P H' + D diag(variance) D'
    """
    d, n, p = len(block.channel), len(x), len(block.offset[t])
    S, W = matrix(d, d), matrix(d, n + 1)
    for r in range(d):
        i, j = block.channel[r], block.reference[r]
        W_r = W[r]
        W_r[n] = (measured[i] - rho[i]) - (measured[j] - rho[j])
        for axis in range(3):
            slope = u[j][axis] - u[i][axis]
            add_multiple(W_r, P[axis], slope)
            W_r[n] -= slope * (x[axis] - block.near[t][axis])
        add_multiple(W_r, P[p + i], wavelength[i])
        add_multiple(W_r, P[p + j], -wavelength[j])
        W_r[n] -= wavelength[i] * x[p + i] - wavelength[j] * x[p + j]
    for r in range(d):
        for q in range(r + 1):
            S[r][q] = _covariance(W[r], block, q, u, wavelength, p) + _noise(block, r, q, variance)
    factor_cholesky(S)
    solve_lower(S, W)
    return S, W


@kernel
def _covariance(HP_r, block, q, u, wavelength, p):
    """Return row r of H P times row q of H."""
    i, j = block.channel[q], block.reference[q]
    total = wavelength[i] * HP_r[p + i] - wavelength[j] * HP_r[p + j]
    for axis in range(3):
        total += (u[j][axis] - u[i][axis]) * HP_r[axis]
    return total


@kernel
def _noise(block, r, q, variance):
    """Return entry (r, q) of D diag(variance) D': the 4-2-2 pattern where all variances are 2."""
    if block.reference[r] != block.reference[q]:
        return 0.0
    return variance[block.reference[r]] + (variance[block.channel[r]] if r == q else 0.0)


@kernel
def _outlying_channel(C, W, block, k):
    """Return the channel whose error best explains an innovation that fails the overall test, -1 where it passes or none stands out."""
    if is_consistent(W):
        return -1
    D = matrix(len(W), k)
    for r in range(len(W)):
        D[r][block.channel[r]] = 1.0
        D[r][block.reference[r]] = -1.0
    worst, sigmas = worst_outlier(C, W, D)
    return worst if sigmas > OUTLIER_SIGMAS else -1


@kernel
def _fix(x, P, block, row):
    """Condition the baseline in a row of results on the best integers, in place; return the ratio, 0 without integers."""
    d, p = len(block.channel), len(block.offset[0])
    if d == 0:
        return 0.0
    a_hat, Q_ba, Q_a = vector(d), matrix(3, d), matrix(d, d)
    for r in range(d):
        i, j = p + block.channel[r], p + block.reference[r]
        a_hat[r] = x[i] - x[j]
        for axis in range(3):
            Q_ba[axis][r] = P[axis][i] - P[axis][j]
        for q in range(d):
            g, h = p + block.channel[q], p + block.reference[q]
            Q_a[r][q] = P[i][g] - P[i][h] - P[j][g] + P[j][h]
    Z, L, variances, status = decorrelate_kernel(Q_a)
    if status != GOOD:
        return 0.0
    z_hat, Q_bz = vector(d), matrix(3, d)
    for r in range(d):
        for q in range(d):
            z_hat[q] += (a_hat[r] - math.floor(a_hat[r])) * Z[r][q]
            for axis in range(3):
                Q_bz[axis][q] += Q_ba[axis][r] * Z[r][q]
    candidates, norms, nodes = search_kernel(z_hat, L, variances, 2, _NODE_LIMIT)
    if nodes >= _NODE_LIMIT:
        return 0.0
    for r in range(d):
        z_hat[r] = candidates[0][r] - z_hat[r]
    _condition_on_integers(row, z_hat, Q_bz, L, variances)
    return norms[1] / max(norms[0], 1e-12)


@kernel
def _condition_on_integers(row, step, Q_bz, L, variances):
    """Add Q_bz Q_z^-1 step to the baseline at 12 and subtract Q_bz Q_z^-1 Q_zb after it: one integer after the other, last first.

    With Q_z = L' diag(d) L the integers enter independently: step_j and column j of Q_bz, less what those after j explain.
    """
    for j in range(len(variances) - 1, -1, -1):
        for i in range(j + 1, len(variances)):
            step[j] -= step[i] * L[i][j]
            for axis in range(3):
                Q_bz[axis][j] -= Q_bz[axis][i] * L[i][j]
        for axis in range(3):
            row[12 + axis] += Q_bz[axis][j] * step[j] / variances[j]
            for other in range(3):
                row[15 + 3 * axis + other] -= Q_bz[axis][j] * Q_bz[other][j] / variances[j]
