"""CUSUM on the innovations of paper B's robust Kalman filter, which starts anew where the sum is too large.

Page (1954), Biometrika 41:100-115: what exceeds the drift allowed is summed up, and the sum never falls below zero, so that it forgets quiet times.
The epoch at which it last was zero is the estimate of when the change began.
"""

import math

from gnsslab.core.jit import kernel, matrix
from gnsslab.core.robust import equivalent_weight
from gnsslab.systems.deformation import B_STEP
from gnsslab.systems.step_followers.followed import AXES, follow

UNUSED = 1.0  # memory of the learnt noise, which this one has no use for


def cusum_follower(series, system=B_STEP, drift=0.5, limit=10.0):
    """Return the `Followed` of paper B's robust Kalman filter, started anew by CUSUM on each axis.

        C+ <- max(0, C+ + v / s - drift),   C- <- max(0, C- - v / s - drift);   a step where one of them is above `limit`

    v / s are innovations over their sigma, cut to k1 of the filter's IGG III. The filter starts anew at the mean of the solutions since that sum
    was zero. `system` has q, r, k0 and k1; what is learnt of the noise is not used.

    >>> import numpy as np
    >>> from gnsslab.gnss.series import series_of_numbers
    >>> rng = np.random.default_rng(3)
    >>> enu = 0.02 * rng.standard_normal((400, 3)) + np.where(np.arange(400) < 300, 0.0, 0.2)[:, None]
    >>> found = cusum_follower(series_of_numbers(np.arange(400).astype("M8[s]"), enu))
    >>> np.flatnonzero(found.is_step)[0].item(), bool(abs(found.level[-1] - 0.2).max() < 0.02)
    (306, True)
    """
    rules = float(system.q), float(system.r), float(system.k0), float(system.k1), float(drift), float(limit)

    def run(z, dt, noise, level, is_step):
        _follow(z, dt, rules, level, is_step)

    return follow(series, run, UNUSED)


@kernel
def _follow(z, dt, rules, level, is_step):
    """Row 2 a of the sums is that of axis a upwards, 2 a + 1 downwards: the sum, and the epoch after which it last was zero."""
    q, r, k0, k1, drift, limit = rules
    walk, sums = matrix(AXES, 2), matrix(2 * AXES, 2)
    for axis in range(AXES):
        walk[axis][1] = r
    for k in range(len(z)):
        highest, since = 0.0, k
        for axis in range(AXES):
            walk[axis][1] += q * dt[k] if k > 0 else 0.0
            if not math.isnan(z[k][0]):
                v = _take_up(walk[axis], z[k][axis], r, k0, k1)
                for side in range(2):
                    total = _sum_up(sums[2 * axis + side], v if side == 0 else -v, drift, k)
                    if total > highest:
                        highest, since = total, int(sums[2 * axis + side][1])
        if highest > limit:
            is_step[k] = 1.0
            _start_anew(walk, sums, z, since, k, r)
        for axis in range(AXES):
            level[k][axis] = walk[axis][0]


@kernel
def _take_up(walk, z, r, k0, k1):
    """Update level and variance of one axis by IGG III; return the standardised innovation, cut to k1."""
    v = (z - walk[0]) / math.sqrt(walk[1] + r)
    eta = equivalent_weight(abs(v), k0, k1, math.inf, math.inf)
    if eta > 0.0:
        K = walk[1] / (walk[1] + r / eta)
        walk[0] += K * (z - walk[0])
        walk[1] *= 1.0 - K
    return max(-k1, min(k1, v))


@kernel
def _sum_up(total, v, drift, k):
    if total[0] == 0.0:
        total[1] = k
    total[0] = max(0.0, total[0] + v - drift)
    return total[0]


@kernel
def _start_anew(walk, sums, z, since, k, r):
    for axis in range(AXES):
        mean, n = 0.0, 0
        for i in range(since, k + 1):
            if not math.isnan(z[i][axis]):
                mean, n = mean + z[i][axis], n + 1
        walk[axis][0], walk[axis][1] = mean / n, r / n
        sums[2 * axis][0] = sums[2 * axis + 1][0] = 0.0
