"""Bayesian online change points: how long ago the level last stepped, as a distribution, with observations that may be far off.

Each hypothesis "the last step was at epoch s" keeps its own filter; a step comes with a constant chance (hazard) at each epoch. Adams and MacKay
(2007), arXiv:0710.3742, (3); Fearnhead and Liu (2007), J. Royal Statistical Society B 69:589-605. The noise is Student's t: an innovation
far off is unlikely but not impossible, and the farther off it is the less it moves the level. The least likely hypotheses are dropped.
"""

import math
from functools import partial

from gnsslab.core.jit import kernel, matrix, vector
from gnsslab.systems.step_followers.followed import AXES, begin, follow
from gnsslab.systems.step_followers.walking_level import COLOURED, LEVEL, P_LEVEL, STATE_SIZE, WHITE, innovation, innovation_variance, predict, update

IMPOSSIBLE = -1e300  # log weight
FRESH = 10.0  # [sigma of the noise] that a new level may be off what was there before


def change_point_follower(series, memory=600.0, width=1.0, chance=0.01, freedom=6.0, sure=0.99, kept=80):
    """Return the `Followed` of Bayesian online change point detection.

        w_s <- w_s (1 - h) t(v_s; S_s) for s < k;   w_k = w_b h t(v_k; S_k)      h the chance of a step

    v_k is that of the likeliest hypothesis b, its level widened by what steps may be (Adams and MacKay sum over all that may have come before).
    The level is the mean of all hypotheses with two solutions or more: the first may be a gross error, by metres. `memory` [epochs] of each
    hypothesis' level; `width` [sigma of the noise] of steps, `chance` of one at an epoch; `freedom` of Student's t; a step is found where the
    hypotheses younger than the last one found have a probability above `sure`; `kept` hypotheses.

    >>> import numpy as np
    >>> from gnsslab.gnss.series import series_of_numbers
    >>> rng = np.random.default_rng(1)
    >>> enu = 0.01 * rng.standard_normal((400, 3)) + np.where(np.arange(400) < 300, 0.0, 0.1)[:, None]
    >>> found = change_point_follower(series_of_numbers(np.arange(400).astype("M8[s]"), enu))
    >>> np.flatnonzero(found.is_step).tolist(), bool(abs(found.level[-1] - 0.1).max() < 0.01)
    ([301], True)
    """
    rules = float(width), math.log(chance / (1.0 - chance)), float(freedom), float(sure)
    return follow(series, partial(_run, rules, int(kept)), memory)


def _run(rules, kept, z, dt, noise, level, is_step):
    _follow(z, dt, noise, rules, matrix(kept * AXES, STATE_SIZE), vector(kept), level, is_step)


@kernel
def _follow(z, dt, noise, rules, states, weight, level, is_step):
    """Hypothesis c has axis a in row 3 c + a of the states; weights are logarithms, the largest of them 0 after each epoch."""
    width, log_chance, freedom, sure = rules
    start, best, told, newest = vector(len(weight)), 0, 0, -1
    begin(states, noise)
    for c in range(1, len(weight)):
        weight[c] = IMPOSSIBLE
    for k in range(len(z)):
        for row in range(len(states)):
            predict(states[row], noise[row % AXES], dt[k])
        if not math.isnan(z[k][0]):
            if k > 0:
                newest = _least_likely(weight)
                _be_born(states, newest, best, noise, width)
                start[newest], weight[newest] = k, weight[best] + log_chance
            for c in range(len(weight)):
                if weight[c] > IMPOSSIBLE:
                    weight[c] += _take_up(states, c, noise, z[k], freedom, start[c] == k)
            best = _rescale(weight)
            if _younger(weight, start, told, newest) > sure:
                is_step[k], told = 1.0, k
        _average(states, weight, newest, level[k])


@kernel
def _least_likely(weight):
    c = 0
    for i in range(len(weight)):
        if weight[i] < weight[c]:
            c = i
    return c


@kernel
def _be_born(states, c, best, noise, width):
    """Let hypothesis c be the best one with a step at this epoch: the coloured error goes on."""
    for axis in range(AXES):
        for n in range(STATE_SIZE):
            states[AXES * c + axis][n] = states[AXES * best + axis][n]
        states[AXES * c + axis][P_LEVEL] += width * width * (noise[axis][WHITE] + noise[axis][COLOURED])


@kernel
def _take_up(states, c, noise, z, freedom, is_new):
    """Update hypothesis c; return the log density of Student's t, less a constant: -(log |S| + (nu + 3) log(1 + v' S^-1 v / nu)) / 2."""
    size, log_S = 0.0, 0.0
    for axis in range(AXES):
        v, S = innovation(states[AXES * c + axis], z[axis]), innovation_variance(states[AXES * c + axis], noise[axis])
        size += v * v / S
        log_S += math.log(S)
    eta = min(1.0, (freedom + AXES) / (freedom + size))  # what a normal law of unknown variance makes of it
    if is_new:  # a step may be larger than is usual: its level is that of its first solution
        eta = 1.0
        for axis in range(AXES):
            states[AXES * c + axis][P_LEVEL] += FRESH**2 * (noise[axis][WHITE] + noise[axis][COLOURED])
    for axis in range(AXES):
        state = states[AXES * c + axis]
        update(state, innovation_variance(state, noise[axis]), eta * innovation(state, z[axis]))
    return -0.5 * (log_S + (freedom + AXES) * math.log(1.0 + size / freedom))


@kernel
def _rescale(weight):
    """Subtract the largest log weight from all that are possible, in place; return whose it is."""
    best = 0
    for c in range(len(weight)):
        if weight[c] > weight[best]:
            best = c
    most = weight[best]
    for c in range(len(weight)):
        if weight[c] > IMPOSSIBLE:
            weight[c] -= most
    return best


@kernel
def _younger(weight, start, told, newest):
    """Return the probability of the hypotheses that started after epoch `told`."""
    younger, total = 0.0, 0.0
    for c in range(len(weight)):
        p = math.exp(weight[c]) if c != newest else 0.0
        total += p
        if start[c] > told:
            younger += p
    return younger / total


@kernel
def _average(states, weight, newest, level):
    total = 0.0
    for c in range(len(weight)):
        p = math.exp(weight[c]) if c != newest else 0.0
        total += p
        for axis in range(AXES):
            level[axis] += p * states[AXES * c + axis][LEVEL]
    for axis in range(AXES):
        level[axis] /= total
