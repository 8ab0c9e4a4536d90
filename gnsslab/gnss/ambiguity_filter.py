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

# Inside the kernels an epoch is a table with a row a channel and these columns: few arguments compile fast.
_CODE, _PHASE, _SIGMA_CODE, _SIGMA_PHASE, _SLIP, _WAVELENGTH, _COLUMNS = 3, 4, 5, 6, 7, 8, 9  # 0 to 2: design
# The filter's results are a row an epoch.
_FLOAT, _FIXED, _RATIO, _RESTARTED, _MISFIT, _FREEDOM, _RESULTS = 0, 12, 24, 25, 26, 27, 28


class Block(NamedTuple):
    """T consecutive epochs with the same k channels; d double differences; p states of motion."""

    F: np.ndarray  # (T, p, p) transition of baseline and velocity from the epoch before
    Q: np.ndarray  # (T, p, p) its process noise covariance
    offset: np.ndarray  # (T, p)
    near: np.ndarray  # (T, 3) [m], baseline about which ranges are linearised: metres from the truth is near enough
    design: np.ndarray  # (T, k, 3), change of a channel's single difference with the baseline
    code: np.ndarray  # (T, k) [m], single difference, measured minus modelled at `near`
    phase: np.ndarray  # (T, k) [m], the same of the carrier; wavelength times ambiguity is left in it
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
    misfit: np.ndarray  # (T,) weighted sum of squared carrier residuals of the fixed solution
    freedom: np.ndarray  # (T,) what the misfit is expected to be if the sigmas are right


def filter_block(x, P, block):
    """Run one block from state x (n,), P (n, n); return x, P after its last epoch and the Outcome.

    The first k ambiguity states belong to the block's channels; any further ones are carried along untouched.
    """
    T, k = block.code.shape
    table = np.empty((T, k, _COLUMNS))
    table[:, :, :3] = block.design
    for column, values in enumerate((block.code, block.phase, block.sigma_code, block.sigma_phase, block.slip, block.wavelength), 3):
        table[:, :, column] = values
    pairs = kernel_indices(np.column_stack([block.channel, block.reference]))
    x, P = kernel_input(x), kernel_input(P)
    motion = (kernel_input(values) for values in (block.F, block.Q, block.offset, block.drift, block.near))
    rows = np.asarray(_filter_epochs(x, P, *motion, kernel_input(table), pairs))
    return np.asarray(x), np.asarray(P), _outcome(rows)


def _outcome(rows):
    b_float, Q_float, b_fixed, Q_fixed, *numbers = np.split(rows, [3, 12, 15, 24, 25, 26, 27], axis=1)
    square = (len(rows), 3, 3)
    return Outcome(b_float, Q_float.reshape(square), b_fixed, Q_fixed.reshape(square), *(column[:, 0] for column in numbers))


@kernel
def _filter_epochs(x, P, F, Q, offset, drift, near, table, pairs):
    """Move x, P through T epochs, in place; return a row of results an epoch (T, 28)."""
    rows = matrix(len(table), _RESULTS)
    p = len(offset[0])
    for t in range(len(table)):
        channels, row = table[t], rows[t]
        predict(x, P, F[t], Q[t], offset[t])
        _loosen(P, p, channels, drift[t])
        _update_by_code(x, P, p, channels, pairs, near[t])
        row[_RESTARTED] = _update_by_phase(x, P, p, channels, pairs, near[t])
        _copy_baseline(x, P, row, _FLOAT)
        _copy_baseline(x, P, row, _FIXED)
        row[_RATIO] = _fix(x, P, p, pairs, row)
        _judge(channels, pairs, near[t], row)
    return rows


@kernel
def _loosen(P, p, channels, drift):
    """Let the ambiguities drift by a variance [m^2], in place."""
    for i in range(len(channels)):
        P[p + i][p + i] += drift / channels[i][_WAVELENGTH] ** 2


@kernel
def _copy_baseline(x, P, row, start):
    """Write baseline and covariance to a row of results, from column `start` on."""
    for i in range(3):
        row[start + i] = x[i]
        for j in range(3):
            row[start + 3 + 3 * i + j] = P[i][j]


@kernel
def _update_by_code(x, P, p, channels, pairs, near):
    """Update x, P by an epoch's codes, in place; a code that the others contradict is set aside for this epoch."""
    k = len(channels)
    variance = _variances(channels, _SIGMA_CODE)
    for _ in range(k // 3 + 1):
        C, W = _innovation(x, P, p, channels, pairs, near, variance, _CODE)
        worst = _outlying_channel(C, W, pairs, k)
        if worst < 0:
            break
        variance[worst] *= _EXCLUDED
    update(x, P, W)


@kernel
def _update_by_phase(x, P, p, channels, pairs, near):
    """Update x, P by an epoch's carriers, in place; return how many ambiguities the others contradicted: they start anew."""
    k = len(channels)
    variance, restarted = _variances(channels, _SIGMA_PHASE), vector(k)
    for i in range(k):
        if channels[i][_SLIP] != 0.0:
            _restart(x, P, p, channels, i)
    for _ in range(k // 3 + 1):
        C, W = _innovation(x, P, p, channels, pairs, near, variance, _PHASE)
        worst = _outlying_channel(C, W, pairs, k)
        if worst < 0 or restarted[worst] > 0:
            break
        restarted[worst] = 1.0
        _restart(x, P, p, channels, worst)
    update(x, P, W)
    return sum(restarted)


@kernel
def _variances(channels, column):
    """Return the squares (k,) of a column of sigmas."""
    variance = vector(len(channels))
    for i in range(len(channels)):
        variance[i] = channels[i][column] ** 2
    return variance


@kernel
def _restart(x, P, p, channels, i):
    """Open the ambiguity of channel i anew at carrier minus code, in place: a wide prior, no correlation."""
    wavelength, state = channels[i][_WAVELENGTH], p + i
    x[state] = (channels[i][_PHASE] - channels[i][_CODE]) / wavelength
    for j in range(len(x)):
        P[state][j] = P[j][state] = 0.0
    P[state][state] = (SIGMA_NEW_AMBIGUITY / wavelength) ** 2


@kernel
def _innovation(x, P, p, channels, pairs, near, variance, kind):
    """Return C (d, d) and W = C^-1 [H P, z] (d, n + 1) of the double differences of one kind of measurement, _CODE or _PHASE.

    z = D y - H (x - near),   H = [D design, 0, D wavelength],   C C' = H P H' + D diag(variance) D';  the wavelengths stand in H
    for the carrier only.
    """
    d, n = len(pairs), len(x)
    S, W = matrix(d, d), matrix(d, n + 1)
    for r in range(d):
        i, j, W_r = pairs[r][0], pairs[r][1], W[r]
        W_r[n] = channels[i][kind] - channels[j][kind]
        for axis in range(3):
            slope = channels[i][axis] - channels[j][axis]
            add_multiple(W_r, P[axis], slope)
            W_r[n] -= slope * (x[axis] - near[axis])
        if kind == _PHASE:
            wavelength = channels[i][_WAVELENGTH]
            add_multiple(W_r, P[p + i], wavelength)
            add_multiple(W_r, P[p + j], -wavelength)
            W_r[n] -= wavelength * (x[p + i] - x[p + j])
        for q in range(r + 1):
            S[r][q] = _noise(pairs, r, q, variance)
    for r in range(d):
        for q in range(r + 1):
            i, j = pairs[q][0], pairs[q][1]
            for axis in range(3):
                S[r][q] += W[r][axis] * (channels[i][axis] - channels[j][axis])
            if kind == _PHASE:
                S[r][q] += (W[r][p + i] - W[r][p + j]) * channels[i][_WAVELENGTH]
    factor_cholesky(S)
    solve_lower(S, W)
    return S, W


@kernel
def _noise(pairs, r, q, variance):
    """Return entry (r, q) of D diag(variance) D': the 4-2-2 pattern where all variances are 2."""
    if pairs[r][1] != pairs[q][1]:
        return 0.0
    return variance[pairs[r][1]] + (variance[pairs[r][0]] if r == q else 0.0)


@kernel
def _outlying_channel(C, W, pairs, k):
    """Return the channel whose error best explains an innovation that fails the overall test, -1 where it passes or none stands out."""
    if is_consistent(W):
        return -1
    D = matrix(len(W), k)
    for r in range(len(W)):
        D[r][pairs[r][0]] = 1.0
        D[r][pairs[r][1]] = -1.0
    worst, sigmas = worst_outlier(C, W, D)
    return worst if sigmas > OUTLIER_SIGMAS else -1


@kernel
def _fix(x, P, p, pairs, row):
    """Condition the fixed baseline in a row of results on the best integers, in place; return the ratio, 0 without integers."""
    d = len(pairs)
    if d == 0:
        return 0.0
    a_hat, Q_a, Q_ba = _double_difference_ambiguities(x, P, p, pairs)
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
def _double_difference_ambiguities(x, P, p, pairs):
    """Return a_hat (d,) and Q_a (d, d) [cycles] of the double differences, and their covariance Q_ba (3, d) with the baseline."""
    d = len(pairs)
    a_hat, Q_a, Q_ba = vector(d), matrix(d, d), matrix(3, d)
    for r in range(d):
        i, j = p + pairs[r][0], p + pairs[r][1]
        a_hat[r] = x[i] - x[j]
        for axis in range(3):
            Q_ba[axis][r] = P[axis][i] - P[axis][j]
        for q in range(d):
            g, h = p + pairs[q][0], p + pairs[q][1]
            Q_a[r][q] = P[i][g] - P[i][h] - P[j][g] + P[j][h]
    return a_hat, Q_a, Q_ba


@kernel
def _condition_on_integers(row, step, Q_bz, L, variances):
    """Add Q_bz Q_z^-1 step to the fixed baseline and subtract Q_bz Q_z^-1 Q_zb from its covariance, in place.

    With Q_z = L' diag(d) L the integers enter one after the other, last first: step_j and column j of Q_bz, less what those
    after j explain.
    """
    for j in range(len(variances) - 1, -1, -1):
        for i in range(j + 1, len(variances)):
            step[j] -= step[i] * L[i][j]
            for axis in range(3):
                Q_bz[axis][j] -= Q_bz[axis][i] * L[i][j]
        for axis in range(3):
            row[_FIXED + axis] += Q_bz[axis][j] * step[j] / variances[j]
            for other in range(3):
                row[_FIXED + 3 + 3 * axis + other] -= Q_bz[axis][j] * Q_bz[other][j] / variances[j]


@kernel
def _judge(channels, pairs, near, row):
    """Write r' R^-1 r of the fixed baseline's carrier residuals and its expectation d - tr(R^-1 H Q H') to the row.

    r = D phase - H (b - near) less the nearest whole wavelengths, H = D design, Q the covariance of that baseline: a Kalman update leaves
    residuals of covariance R - H Q H'.
    """
    d = len(pairs)
    variance, R, G = _variances(channels, _SIGMA_PHASE), matrix(d, d), matrix(d, 4)
    for r in range(d):
        i, j = pairs[r][0], pairs[r][1]
        wavelength = channels[i][_WAVELENGTH]
        residual = channels[i][_PHASE] - channels[j][_PHASE]
        for axis in range(3):
            G[r][axis] = channels[i][axis] - channels[j][axis]
            residual -= G[r][axis] * (row[_FIXED + axis] - near[axis])
        G[r][3] = residual - wavelength * math.floor(residual / wavelength + 0.5)
        for q in range(r + 1):
            R[r][q] = _noise(pairs, r, q, variance)
    factor_cholesky(R)
    solve_lower(R, G)
    row[_FREEDOM] = d
    for r in range(d):
        row[_MISFIT] += G[r][3] ** 2
        for axis in range(3):
            for other in range(3):
                row[_FREEDOM] -= G[r][axis] * row[_FIXED + 3 + 3 * axis + other] * G[r][other]
