"""The filter of relative positioning: baseline, velocity and single-difference ambiguities, fixed to integers at every epoch.

Its state is x = [baseline (3), velocity (3, or none), ambiguities of all channels in cycles]. Measurements enter as double
differences of code and carrier; integers are sought for the double-difference ambiguities, so a change of reference channel
changes only which channels are paired and costs nothing. With its integers known a carrier is a range of millimetres: the
fixed baseline is solved from the carriers of its epoch alone. One source for compiled and plain Python (core.jit).
"""

from typing import NamedTuple

import numpy as np

from gnsslab.core.integers import GOOD, fix_groups
from gnsslab.core.jit import cube, integer_matrix, kernel, kernel_indices, kernel_input, matrix, vector
from gnsslab.core.kalman import add_multiple, factor_cholesky, is_consistent, predict, solve_lower, update, worst_outlier

SIGMA_NEW_AMBIGUITY = 100.0  # [m], of an ambiguity just opened at carrier minus code: above any multipath of the code
OUTLIER_SIGMAS = 4.5  # an innocent measurement is set aside once in 150 000 times
_SINGULAR = 1e-12  # share of the normal matrix left for the last unknown, below which there is none
_EXCLUDED = 1e6  # factor on the variance of a measurement set aside: it no longer matters
_NODE_LIMIT = 50_000  # of the integer search; a good epoch needs 10 to 1000, and one that needs more has no clear winner
_FIXABLE = 0.1  # cycles: the integers of noisier carriers, low or weak, are not sought; one of them would make all the others doubtful

# Inside the kernels an epoch is a table with a row a channel and these columns: few arguments compile fast.
_CODE, _PHASE, _SIGMA_CODE, _SIGMA_PHASE, _NOVELTY, _SLIP, _WAVELENGTH, _COLUMNS = 3, 4, 5, 6, 7, 8, 9, 10  # 0 to 2: design
# The filter's results are a row an epoch.
_FLOAT, _FIXED, _RATIO, _RESTARTED, _MISFIT, _FREEDOM, _INTEGERS, _RESULTS = 0, 12, 24, 25, 26, 27, 28, 29


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
    novelty: np.ndarray  # (T, k) 0 to 1, share of a measurement's information that earlier ones have not given yet
    slip: np.ndarray  # (T, k) 1 where the ambiguity starts anew, else 0
    drift: np.ndarray  # (T,) [m^2], variance that every ambiguity gains since the epoch before
    wavelength: np.ndarray  # (k,) [m]
    channel: np.ndarray  # (d,) int, a double difference is this channel
    reference: np.ndarray  # (d,) int, minus this one


class Outcome(NamedTuple):
    """What the filter found at each of T epochs."""

    baseline_float: np.ndarray  # (T, 3) [m]
    Q_float: np.ndarray  # (T, 3, 3) [m^2]
    baseline_fixed: np.ndarray  # (T, 3) [m], from the epoch's carriers with the best integers
    Q_fixed: np.ndarray  # (T, 3, 3) [m^2]
    ratio: np.ndarray  # (T,) second best over best squared norm, 0 where nothing could be searched
    restarted: np.ndarray  # (T,) int, how many ambiguities the filter itself found to have slipped
    misfit: np.ndarray  # (T,) weighted sum of squared carrier residuals of the fixed solution
    freedom: np.ndarray  # (T,) what the misfit is expected to be if the sigmas are right
    integers: np.ndarray  # (T,) how many integers were sought


def filter_block(x, P, block):
    """Run one block from state x (n,), P (n, n); return x, P after its last epoch and the Outcome.

    The first k ambiguity states belong to the block's channels; any further ones are carried along untouched.
    """
    T, k = block.code.shape
    table = np.empty((T, k, _COLUMNS))
    measured = (block.code, block.phase, block.sigma_code, block.sigma_phase, block.novelty, block.slip, block.wavelength)
    table[:, :, :3] = block.design
    for column, values in enumerate(measured, 3):
        table[:, :, column] = values
    pairs = kernel_indices(np.column_stack([block.channel, block.reference]))
    x, P = kernel_input(np.array(x)), kernel_input(np.array(P))  # copies: the kernel works in place
    motion = (kernel_input(values) for values in (block.F, block.Q, block.offset, block.drift, block.near))
    rows = np.asarray(_filter_epochs(x, P, *motion, kernel_input(table), pairs))
    return np.asarray(x), np.asarray(P), _outcome(rows)


def _outcome(rows):
    b_float, Q_float, b_fixed, Q_fixed, *numbers = np.split(rows, [3, 12, 15, 24, *range(25, _RESULTS)], axis=1)
    square = (len(rows), 3, 3)
    return Outcome(b_float, Q_float.reshape(square), b_fixed, Q_fixed.reshape(square), *(column[:, 0] for column in numbers))


@kernel
def _filter_epochs(x, P, F, Q, offset, drift, near, table, pairs):
    """Move x, P through T epochs, in place; return a row of results an epoch (T, 29)."""
    rows = matrix(len(table), _RESULTS)
    p = len(offset[0])
    for t in range(len(table)):
        channels, row = table[t], rows[t]
        predict(x, P, F[t], Q[t], offset[t])
        _loosen(P, p, channels, drift[t])
        _update_by_code(x, P, p, channels, pairs, near[t])
        row[_RESTARTED] = _update_by_phase(x, P, p, channels, pairs, near[t])
        _copy_baseline(x, P, row)
        row[_RATIO] = _fix(x, P, p, channels, _fixable(channels, pairs), near[t], row)
    return rows


@kernel
def _loosen(P, p, channels, drift):
    """Let the ambiguities drift by a variance [m^2], in place."""
    for i in range(len(channels)):
        P[p + i][p + i] += drift / channels[i][_WAVELENGTH] ** 2


@kernel
def _copy_baseline(x, P, row):
    """Write the float baseline and its covariance to a row of results."""
    for i in range(3):
        row[_FLOAT + i] = x[i]
        for j in range(3):
            row[_FLOAT + 3 + 3 * i + j] = P[i][j]


@kernel
def _update_by_code(x, P, p, channels, pairs, near):
    """Update x, P by an epoch's codes, in place; a code that the others contradict is set aside for this epoch."""
    k = len(channels)
    variance = _variances(channels, _SIGMA_CODE, True)
    for most_left in range(k // 3, -1, -1):
        C, W = _innovation(x, P, p, channels, pairs, near, variance, _CODE)
        worst = _outlying_channel(C, W, pairs, k)
        if worst < 0 or most_left == 0:
            break
        variance[worst] *= _EXCLUDED
    update(x, P, W)


@kernel
def _update_by_phase(x, P, p, channels, pairs, near):
    """Update x, P by an epoch's carriers, in place; return how many ambiguities the others contradicted: they start anew.

    Slips are looked for at the carriers' full precision; the update itself believes them only as far as they are news.
    """
    for i in range(len(channels)):
        if channels[i][_SLIP] != 0.0:
            _restart(x, P, p, channels, i)
    restarted = _restart_slipped(x, P, p, channels, pairs, near)
    _, W = _innovation(x, P, p, channels, pairs, near, _variances(channels, _SIGMA_PHASE, True), _PHASE)
    update(x, P, W)
    return restarted


@kernel
def _restart_slipped(x, P, p, channels, pairs, near):
    """Restart the ambiguities that the carriers contradict, the worst first, in place; return how many."""
    k = len(channels)
    variance, restarted = _variances(channels, _SIGMA_PHASE, False), vector(k)
    for _ in range(k // 3):
        C, W = _innovation(x, P, p, channels, pairs, near, variance, _PHASE)
        worst = _outlying_channel(C, W, pairs, k)
        if worst < 0 or restarted[worst] > 0:
            break
        restarted[worst] = 1.0
        _restart(x, P, p, channels, worst)
    return sum(restarted)


@kernel
def _variances(channels, column, for_filter):
    """Return the squares (k,) of a column of sigmas, for the filter enlarged where the measurement tells little new."""
    variance = vector(len(channels))
    for i in range(len(channels)):
        variance[i] = channels[i][column] ** 2 / (channels[i][_NOVELTY] if for_filter else 1.0)
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
def _fixable(channels, pairs):
    """Return the pairs (f, 2) whose two carriers are good to a tenth of a cycle."""
    count, chosen = 0, integer_matrix(len(pairs), 2)
    for r in range(len(pairs)):
        i, j = pairs[r][0], pairs[r][1]
        worse = max(channels[i][_SIGMA_PHASE], channels[j][_SIGMA_PHASE])
        if worse <= _FIXABLE * channels[i][_WAVELENGTH]:
            chosen[count][0], chosen[count][1] = i, j
            count += 1
    return chosen[:count]


@kernel
def _fix(x, P, p, channels, pairs, near, row):
    """Write the fixed baseline to a row of results, in place; return the ratio, 0 where there are no integers or no baseline."""
    row[_INTEGERS] = len(pairs)
    if len(pairs) < 3:
        return 0.0
    a_hat, Q_a = _double_difference_ambiguities(x, P, p, pairs)
    candidates, norms, nodes, status, _ = fix_groups(a_hat, Q_a, 2, _NODE_LIMIT)
    if status != GOOD or nodes[0][0] >= _NODE_LIMIT:
        return 0.0
    if not _solve_fixed(channels, pairs, candidates[0], near, row):
        return 0.0
    return norms[0][1] / max(norms[0][0], 1e-12)


@kernel
def _double_difference_ambiguities(x, P, p, pairs):
    """Return a_hat (1, 1, d) and Q_a (1, d, d) [cycles] of the double differences: one vector, one covariance."""
    d = len(pairs)
    a_hat, Q_a = cube(1, 1, d), cube(1, d, d)
    for r in range(d):
        i, j = p + pairs[r][0], p + pairs[r][1]
        a_hat[0][0][r] = x[i] - x[j]
        for q in range(d):
            g, h = p + pairs[q][0], p + pairs[q][1]
            Q_a[0][r][q] = P[i][g] - P[i][h] - P[j][g] + P[j][h]
    return a_hat, Q_a


@kernel
def _solve_fixed(channels, pairs, integers, near, row):
    """Solve the baseline by least squares from the carriers less their integers; write it, its covariance and misfit to the row.

    y = D phase - wavelength a,  H = D design,  R = D diag(sigma^2) D' = C C',  N = H' R^-1 H:  b = near + N^-1 H' R^-1 y, Q = N^-1,
    misfit y' R^-1 y - y' R^-1 H (b - near), expected d - 3. Returns False where the satellites leave the baseline open.
    """
    d = len(pairs)
    variance, C, G, N = _variances(channels, _SIGMA_PHASE, False), matrix(d, d), matrix(d, 4), matrix(4, 4)
    for r in range(d):
        i, j = pairs[r][0], pairs[r][1]
        G[r][3] = channels[i][_PHASE] - channels[j][_PHASE] - channels[i][_WAVELENGTH] * integers[r]
        for axis in range(3):
            G[r][axis] = channels[i][axis] - channels[j][axis]
        for q in range(r + 1):
            C[r][q] = _noise(pairs, r, q, variance)
    factor_cholesky(C)
    solve_lower(C, G)
    for r in range(d):
        for i in range(4):
            add_multiple(N[i], G[r], G[r][i])
    return _write_fixed(N, d, near, row)


@kernel
def _write_fixed(N, d, near, row):
    """Solve the bordered normal equations N = [[H'H, H'y], [y'H, y'y]] (4, 4) by Cholesky and write the results to the row."""
    size = N[0][0] + N[1][1] + N[2][2]
    factor_cholesky(N)
    smallest = min(N[0][0], N[1][1], N[2][2])
    if not smallest * smallest > _SINGULAR * size:
        return False
    inverse = matrix(3, 3)
    for i in range(3):
        inverse[i][i] = 1.0
    solve_lower(N, inverse)
    for i in range(3):
        row[_FIXED + i] = near[i]
        for k in range(3):
            row[_FIXED + i] += inverse[k][i] * N[3][k]
            for j in range(3):
                row[_FIXED + 3 + 3 * i + j] += inverse[k][i] * inverse[k][j]
    row[_MISFIT], row[_FREEDOM] = N[3][3] ** 2, d - 3
    return True
