"""The filter of relative positioning: baseline, velocity and single-difference ambiguities, fixed to integers at every epoch.

Its state is x = [baseline (3), velocity (3, or none), ambiguities of all channels in cycles]. Measurements enter as double
differences of code and carrier; integers are sought for the double-difference ambiguities, so a change of reference channel
changes only which channels are paired and costs nothing. With its integers known a carrier is a range of millimetres: the
fixed baseline is solved from the carriers of its epoch alone. One source for compiled and plain Python (core.jit).
"""

from typing import NamedTuple

import numpy as np

from gnsslab.core.integers import GOOD
from gnsslab.core.jit import integer_matrix, kernel, kernel_input, matrix, vector
from gnsslab.core.kalman import add_multiple, factor_cholesky, is_consistent, predict, solve_lower, update, worst_outlier
from gnsslab.gnss.filter_steps import (
    CODE,
    PHASE,
    SIGMA_CODE,
    SIGMA_PHASE,
    SLIP,
    WAVELENGTH,
    copy_baseline,
    innovation,
    kernel_table,
    loosen,
    noise,
    restart,
    search_integers,
    variances,
)

OUTLIER_SIGMAS = 4.5  # an innocent measurement is set aside once in 150 000 times
_SINGULAR = 1e-12  # share of the normal matrix left for the last unknown, below which there is none
_EXCLUDED = 1e6  # factor on the variance of a measurement set aside: it no longer matters
_NODE_LIMIT = 50_000  # of the integer search; a good epoch needs 10 to 1000, and one that needs more has no clear winner
_FIXABLE = 0.1  # cycles: the integers of noisier carriers, low or weak, are not sought; one of them would make all the others doubtful

# The filter's results are a row an epoch.
_FLOAT, _FIXED, _RATIO, _RESTARTED, _MISFIT, _FREEDOM, _INTEGERS, _COST, _RESULTS = 0, 12, 24, 25, 26, 27, 28, 29, 30


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
    cost: np.ndarray  # (T,) squared norm of the best integers, what the length costs included where it is known


def filter_block(x, P, block, length=0.0, length_sigma=0.0):
    """Run one block from state x (n,), P (n, n); return x, P after its last epoch and the Outcome.

    The first k ambiguity states belong to the block's channels; any further ones are carried along untouched. A known
    `length` [m] (0: none) takes part in the search for the integers, and nowhere else (C-LAMBDA); its sigma widens the sphere.
    """
    table, pairs = kernel_table(block)
    x, P = kernel_input(np.array(x)), kernel_input(np.array(P))  # copies: the kernel works in place
    motion = (kernel_input(values) for values in (block.F, block.Q, block.offset, block.drift, block.near))
    rows = np.asarray(_filter_epochs(x, P, *motion, table, pairs, float(length), float(length_sigma)))
    return np.asarray(x), np.asarray(P), _outcome(rows)


def _outcome(rows):
    b_float, Q_float, b_fixed, Q_fixed, *numbers = np.split(rows, [3, 12, 15, 24, *range(25, _RESULTS)], axis=1)
    square = (len(rows), 3, 3)
    return Outcome(b_float, Q_float.reshape(square), b_fixed, Q_fixed.reshape(square), *(column[:, 0] for column in numbers))


@kernel
def _filter_epochs(x, P, F, Q, offset, drift, near, table, pairs, length, length_sigma):
    """Move x, P through T epochs, in place; return a row of results an epoch (T, 30)."""
    rows = matrix(len(table), _RESULTS)
    p = len(offset[0])
    for t in range(len(table)):
        channels, row = table[t], rows[t]
        predict(x, P, F[t], Q[t], offset[t])
        loosen(P, p, channels, drift[t])
        _update_by_code(x, P, p, channels, pairs, near[t])
        row[_RESTARTED] = _update_by_phase(x, P, p, channels, pairs, near[t])
        copy_baseline(x, P, row, _FLOAT)
        row[_RATIO] = _fix(x, P, p, channels, _fixable(channels, pairs), near[t], length, length_sigma, row)
    return rows


@kernel
def _update_by_code(x, P, p, channels, pairs, near):
    """Update x, P by an epoch's codes, in place; a code that the others contradict is set aside for this epoch."""
    k = len(channels)
    variance = variances(channels, SIGMA_CODE, True)
    for most_left in range(k // 3, -1, -1):
        C, W = innovation(x, P, p, channels, pairs, near, variance, CODE)
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
        if channels[i][SLIP] != 0.0:
            restart(x, P, p, channels, i)
    restarted = _restart_slipped(x, P, p, channels, pairs, near)
    _, W = innovation(x, P, p, channels, pairs, near, variances(channels, SIGMA_PHASE, True), PHASE)
    update(x, P, W)
    return restarted


@kernel
def _restart_slipped(x, P, p, channels, pairs, near):
    """Restart the ambiguities that the carriers contradict, the worst first, in place; return how many."""
    k = len(channels)
    variance, restarted = variances(channels, SIGMA_PHASE, False), vector(k)
    for _ in range(k // 3):
        C, W = innovation(x, P, p, channels, pairs, near, variance, PHASE)
        worst = _outlying_channel(C, W, pairs, k)
        if worst < 0 or restarted[worst] > 0:
            break
        restarted[worst] = 1.0
        restart(x, P, p, channels, worst)
    return sum(restarted)


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
        worse = max(channels[i][SIGMA_PHASE], channels[j][SIGMA_PHASE])
        if worse <= _FIXABLE * channels[i][WAVELENGTH]:
            chosen[count][0], chosen[count][1] = i, j
            count += 1
    return chosen[:count]


@kernel
def _fix(x, P, p, channels, pairs, near, length, length_sigma, row):
    """Write the fixed baseline to a row of results, in place; return the ratio, 0 where there are no integers or no baseline."""
    row[_INTEGERS] = len(pairs)
    if len(pairs) < 3:
        return 0.0
    candidates, norms, nodes, status = search_integers(x, P, p, pairs, length, length_sigma, _NODE_LIMIT)
    if status != GOOD or nodes[0][0] >= _NODE_LIMIT:
        return 0.0
    if not _solve_fixed(channels, pairs, candidates[0], near, row):
        return 0.0
    row[_COST] = norms[0][0]
    return norms[0][1] / max(norms[0][0], 1e-12)


@kernel
def _solve_fixed(channels, pairs, integers, near, row):
    """Solve the baseline by least squares from the carriers less their integers; write it, its covariance and misfit to the row.

    y = D phase - wavelength a,  H = D design,  R = D diag(sigma^2) D' = C C',  N = H' R^-1 H:  b = near + N^-1 H' R^-1 y, Q = N^-1,
    misfit y' R^-1 y - y' R^-1 H (b - near), expected d - 3. Returns False where the satellites leave the baseline open.
    """
    d = len(pairs)
    variance, C, G, N = variances(channels, SIGMA_PHASE, False), matrix(d, d), matrix(d, 4), matrix(4, 4)
    for r in range(d):
        i, j = pairs[r][0], pairs[r][1]
        G[r][3] = channels[i][PHASE] - channels[j][PHASE] - channels[i][WAVELENGTH] * integers[r]
        for axis in range(3):
            G[r][axis] = channels[i][axis] - channels[j][axis]
        for q in range(r + 1):
            C[r][q] = noise(pairs, r, q, variance)
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
