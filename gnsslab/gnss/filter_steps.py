"""Steps of a filter of double differences, as kernels: what any filter of baseline, velocity and ambiguities is made of.

The state is x = [baseline (3), velocity (3, or none), single-difference ambiguities of all channels in cycles], P its covariance;
p states of motion stand before the ambiguities. Measurements enter as double differences: pairs (d, 2) of a channel and its reference.
"""

from typing import NamedTuple

import numpy as np

from gnsslab.core.integers import fix_groups, fix_groups_on_sphere
from gnsslab.core.jit import cube, kernel, kernel_indices, kernel_input, matrix, vector
from gnsslab.core.kalman import add_multiple, factor_cholesky, solve_lower

SIGMA_NEW_AMBIGUITY = 100.0  # [m], of an ambiguity just opened at carrier minus code: above any multipath of the code

# Inside the kernels an epoch is a table with a row a channel and these columns: few arguments compile fast.
CODE, PHASE, SIGMA_CODE, SIGMA_PHASE, NOVELTY, SLIP, WAVELENGTH, COLUMNS = 3, 4, 5, 6, 7, 8, 9, 10  # 0 to 2: design


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
    channels: np.ndarray  # (k,) int, which of the pair's channels they are


def kernel_table(block):
    """Return the measurements of a Block as a table (T, k, COLUMNS), and its pairs (d, 2), as kernels take them."""
    T, k = block.code.shape
    table = np.empty((T, k, COLUMNS))
    measured = (block.code, block.phase, block.sigma_code, block.sigma_phase, block.novelty, block.slip, block.wavelength)
    table[:, :, :3] = block.design
    for column, values in enumerate(measured, 3):
        table[:, :, column] = values
    return kernel_input(table), kernel_indices(np.column_stack([block.channel, block.reference]))


@kernel
def loosen(P, p, channels, drift):
    """Let the ambiguities drift by a variance [m^2], in place."""
    for i in range(len(channels)):
        P[p + i][p + i] += drift / channels[i][WAVELENGTH] ** 2


@kernel
def variances(channels, column, for_filter):
    """Return the squares (k,) of a column of sigmas, for the filter enlarged where the measurement tells little new."""
    variance = vector(len(channels))
    for i in range(len(channels)):
        variance[i] = channels[i][column] ** 2 / (channels[i][NOVELTY] if for_filter else 1.0)
    return variance


@kernel
def restart(x, P, p, channels, i):
    """Open the ambiguity of channel i anew at carrier minus code, in place: a wide prior, no correlation."""
    wavelength, state = channels[i][WAVELENGTH], p + i
    x[state] = (channels[i][PHASE] - channels[i][CODE]) / wavelength
    for j in range(len(x)):
        P[state][j] = P[j][state] = 0.0
    P[state][state] = (SIGMA_NEW_AMBIGUITY / wavelength) ** 2


@kernel
def innovation(x, P, p, channels, pairs, near, variance, kind):
    """Return C (d, d) and W = C^-1 [H P, z] (d, n + 1) of the double differences of one kind of measurement, CODE or PHASE.

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
        if kind == PHASE:
            wavelength = channels[i][WAVELENGTH]
            add_multiple(W_r, P[p + i], wavelength)
            add_multiple(W_r, P[p + j], -wavelength)
            W_r[n] -= wavelength * (x[p + i] - x[p + j])
        for q in range(r + 1):
            S[r][q] = noise(pairs, r, q, variance)
    for r in range(d):
        for q in range(r + 1):
            i, j = pairs[q][0], pairs[q][1]
            for axis in range(3):
                S[r][q] += W[r][axis] * (channels[i][axis] - channels[j][axis])
            if kind == PHASE:
                S[r][q] += (W[r][p + i] - W[r][p + j]) * channels[i][WAVELENGTH]
    factor_cholesky(S)
    solve_lower(S, W)
    return S, W


@kernel
def noise(pairs, r, q, variance):
    """Return entry (r, q) of D diag(variance) D': the 4-2-2 pattern where all variances are 2."""
    if pairs[r][1] != pairs[q][1]:
        return 0.0
    return variance[pairs[r][1]] + (variance[pairs[r][0]] if r == q else 0.0)


@kernel
def search_integers(x, P, p, pairs, length, length_sigma, node_limit):
    """Return the two best integer vectors, their norms, the nodes visited and a status; on the sphere where a length is known (not 0).

    A length uncertain by sigma is a sphere hit by b + e, e ~ N(0, sigma^2 I): along the radius that is the length's own error,
    and across it costs nothing anyway.
    """
    a_hat, Q_a = double_difference_ambiguities(x, P, p, pairs)
    if length == 0.0:
        candidates, norms, nodes, status, _ = fix_groups(a_hat, Q_a, 2, node_limit)
        return candidates, norms, nodes, status
    b_hat, Q_b, Q_ba = baseline_with_ambiguities(x, P, p, pairs)
    for axis in range(3):
        Q_b[0][axis][axis] += length_sigma**2
    bounds = matrix(1, 1)
    bounds[0][0] = 2.0 * (len(pairs) + 1.0)  # twice the mean cost of the true integers
    candidates, norms, nodes, _, status, _ = fix_groups_on_sphere(a_hat, Q_a, b_hat, Q_b, Q_ba, length, bounds, 2, node_limit)
    return candidates, norms, nodes, status


@kernel
def double_difference_ambiguities(x, P, p, pairs):
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
def baseline_with_ambiguities(x, P, p, pairs):
    """Return b_hat (1, 1, 3), Q_b (1, 3, 3) [m^2] and Q_ba (1, 3, d) [m cycles], with the double-difference ambiguities."""
    b_hat, Q_b, Q_ba = cube(1, 1, 3), cube(1, 3, 3), cube(1, 3, len(pairs))
    for axis in range(3):
        b_hat[0][0][axis] = x[axis]
        for other in range(3):
            Q_b[0][axis][other] = P[axis][other]
        for r in range(len(pairs)):
            Q_ba[0][axis][r] = P[axis][p + pairs[r][0]] - P[axis][p + pairs[r][1]]
    return b_hat, Q_b, Q_ba


@kernel
def copy_baseline(x, P, row, first):
    """Write the baseline and its covariance to a row of results, 12 numbers from `first` on."""
    for i in range(3):
        row[first + i] = x[i]
        for j in range(3):
            row[first + 3 + 3 * i + j] = P[i][j]
