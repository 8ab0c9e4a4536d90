"""The multi-process Kalman filter: at each epoch the series is steady, shows a gross error, or has stepped, with known chances.

Three filters, one for each answer at the last epoch, are each continued with each answer at this one: nine, weighed by their likelihoods and merged
to three by moments. So an epoch is judged once more when the next one is known, and then no more. Harrison and Stevens (1976), J. Royal
Statistical Society B 38:205-247, class II; in use for monitoring: Smith and West (1983), Biometrics 39:867-878.
"""

import math
from functools import partial

from gnsslab.core.jit import kernel, matrix, vector
from gnsslab.systems.step_followers.followed import AXES, begin, follow
from gnsslab.systems.step_followers.walking_level import (
    COLOUR,
    COLOURED,
    LEVEL,
    P_BOTH,
    P_COLOUR,
    P_LEVEL,
    STATE_SIZE,
    WHITE,
    innovation,
    innovation_variance,
    predict,
    update,
)

STEADY, OUTLIER, STEP = range(3)
MODELS = 3
GROSS = 6.0  # [sigma of the noise] of gross errors
CHANCE_OUTLIER = 0.003  # of a gross error at an epoch


def multi_process_follower(series, memory=300.0, width=4.0, chance=1e-5, sure=0.9):
    """Return the `Followed` of a multi-process Kalman filter of three models.

        p(i, j | z_1..k) ~ p(i | z_1..k-1) pi_j N(v_ij; 0, S_ij)      i: model of the last epoch, j: of this one

    `memory` [epochs] of the level; `width` [sigma of the noise] of a step, `chance` of one at an epoch; a step is found where the epoch
    before was one with a probability above `sure`, and none had been found there.

    >>> import numpy as np
    >>> from gnsslab.gnss.series import series_of_numbers
    >>> rng = np.random.default_rng(1)
    >>> enu = 0.01 * rng.standard_normal((400, 3)) + np.where(np.arange(400) < 300, 0.0, 0.1)[:, None]
    >>> found = multi_process_follower(series_of_numbers(np.arange(400).astype("M8[s]"), enu))
    >>> np.flatnonzero(found.is_step).tolist(), bool(abs(found.level[-1] - 0.1).max() < 0.01)
    ([301], True)
    """
    rules = float(width), math.log(CHANCE_OUTLIER), math.log(chance), float(sure)
    return follow(series, partial(_run, rules), memory)


def _run(rules, z, dt, noise, level, is_step):
    _follow(z, dt, noise, rules, level, is_step)


@kernel
def _follow(z, dt, noise, rules, level, is_step):
    """States stand in rows: model i's axis a in row 3 i + a of the three, row 3 (3 i + j) + a of the nine."""
    width, log_outlier, log_step, sure = rules
    three, nine = matrix(MODELS * AXES, STATE_SIZE), matrix(MODELS * MODELS * AXES, STATE_SIZE)
    chance, both, was_step = vector(MODELS), vector(MODELS * MODELS), False
    for i in range(MODELS):
        begin(three[AXES * i : AXES * i + AXES], noise)
        chance[i] = 1.0 / MODELS
    for k in range(len(z)):
        for row in range(len(three)):
            predict(three[row], noise[row % AXES], dt[k])
        if not math.isnan(z[k][0]):
            for i in range(MODELS):
                for j in range(MODELS):
                    prior = log_outlier if j == OUTLIER else log_step if j == STEP else 0.0
                    both[MODELS * i + j] = math.log(max(chance[i], 1e-300)) + prior
                    both[MODELS * i + j] += _continue(three, nine, i, j, noise, z[k], width)
            _normalise(both)
            stepped = both[MODELS * STEP] + both[MODELS * STEP + OUTLIER] + both[MODELS * STEP + STEP]
            is_step[k] = 1.0 if stepped > sure and not was_step else 0.0
            was_step = stepped > sure
            for j in range(MODELS):
                chance[j] = _merge(three, nine, both, j)
        for axis in range(AXES):
            for i in range(MODELS):
                level[k][axis] += chance[i] * three[AXES * i + axis][LEVEL]


@kernel
def _continue(three, nine, i, j, noise, z, width):
    """Fill row i, j of the nine: model i's prediction updated under model j; return the log likelihood."""
    total = 0.0
    for axis in range(AXES):
        state, variance = nine[AXES * (MODELS * i + j) + axis], noise[axis][WHITE] + noise[axis][COLOURED]
        for n in range(STATE_SIZE):
            state[n] = three[AXES * i + axis][n]
        if j == STEP:
            state[P_LEVEL] += width * width * variance
        S, v = innovation_variance(state, noise[axis]), innovation(state, z[axis])
        if j == OUTLIER:
            S += GROSS * GROSS * variance
        total -= 0.5 * (v * v / S + math.log(S))
        update(state, S, v)
    return total


@kernel
def _normalise(logs):
    """Turn log weights into weights of sum 1, in place."""
    most, total = max(logs), 0.0
    for i in range(len(logs)):
        logs[i] = math.exp(logs[i] - most)
        total += logs[i]
    for i in range(len(logs)):
        logs[i] /= total


@kernel
def _merge(three, nine, both, j):
    """Let model j's state have mean and covariance of the three mixed that end in it; return its probability."""
    total = both[j] + both[MODELS + j] + both[2 * MODELS + j]
    for axis in range(AXES):
        state = three[AXES * j + axis]
        for n in range(STATE_SIZE):
            state[n] = 0.0
        for i in range(MODELS):
            share = both[MODELS * i + j] / total if total > 0.0 else 1.0 / MODELS
            for n in range(STATE_SIZE):
                state[n] += share * nine[AXES * (MODELS * i + j) + axis][n]
        for i in range(MODELS):
            share = both[MODELS * i + j] / total if total > 0.0 else 1.0 / MODELS
            _add_spread(state, nine[AXES * (MODELS * i + j) + axis], share)
    return total


@kernel
def _add_spread(state, part, share):
    x, u = part[LEVEL] - state[LEVEL], part[COLOUR] - state[COLOUR]
    state[P_LEVEL] += share * x * x
    state[P_BOTH] += share * x * u
    state[P_COLOUR] += share * u * u
