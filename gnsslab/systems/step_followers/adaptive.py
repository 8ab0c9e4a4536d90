"""The adaptive robust Kalman filter: the measurement is weighed by a robust factor, the prediction by an adaptive one.

The adaptive factor of Yang, He and Xu (2001), J. Geodesy 75:109-116, divides the predicted covariance:  P <- P / alpha.  It falls where prediction
and measurement disagree, and there one solution cannot tell which of them is wrong. So it is asked first whether the last n innovations agree
with each other (the mean of n standardised innovations; as statistic: Yang and Gao 2006, J. Geodesy 80:177-183). If so the prediction
is wrong and gets the factor; else a large innovation is the measurement's and gets an equivalent weight. The factor goes to the level
alone and not to the coloured error, whose prediction is as good as before (classified factors: Yang and Cui 2008, Survey Review 40:260-270).
"""

import math
from functools import partial

from gnsslab.core.jit import kernel, matrix
from gnsslab.core.robust import equivalent_weight
from gnsslab.systems.step_followers.followed import AXES, begin, follow, squared_length
from gnsslab.systems.step_followers.walking_level import LEVEL, P_LEVEL, STATE_SIZE, WHITE, innovation, innovation_variance, predict, update

SMALLEST = 1e-3  # adaptive factor
K0, K1 = 2.5, 4.5  # [sigma] of IGG III for the length of an innovation of three axes: 90 % of good ones are below the first


def adaptive_follower(series, memory=300.0, agreeing=12, c0=4.0, c1=6.0):
    """Return the `Followed` of an adaptive robust Kalman filter.

        Delta = |sum of n standardised innovations| / sqrt(n)
        alpha = 1 where Delta <= c0;  c0 / Delta ((c1 - Delta) / (c1 - c0))^2  up to c1;  then (almost) 0     (IGG III)

    `memory` [epochs] of the level; `agreeing` is n; c0, c1 [sigma of one axis]. A step is found where Delta is above c1.
    Raises ValueError unless 0 < c0 < c1.

    >>> import numpy as np
    >>> from gnsslab.gnss.series import series_of_numbers
    >>> rng = np.random.default_rng(1)
    >>> enu = 0.01 * rng.standard_normal((400, 3)) + np.where(np.arange(400) < 300, 0.0, 0.1)[:, None]
    >>> found = adaptive_follower(series_of_numbers(np.arange(400).astype("M8[s]"), enu))
    >>> np.flatnonzero(found.is_step).tolist()[:1], bool(abs(found.level[-1] - 0.1).max() < 0.01)
    ([304], True)
    """
    if not 0 < c0 < c1:
        raise ValueError(f"the adaptive factor expects 0 < c0 < c1, such as 4 and 6; got c0 = {c0}, c1 = {c1}")
    return follow(series, partial(_run, (float(c0), float(c1), K0, K1), int(agreeing)), memory)


def _run(rules, agreeing, z, dt, noise, level, is_step):
    _follow(z, dt, noise, rules, matrix(agreeing, AXES), level, is_step)


@kernel
def _follow(z, dt, noise, rules, recent, level, is_step):
    c0, c1, k0, k1 = rules
    state, count = matrix(AXES, STATE_SIZE), 0
    begin(state, noise)
    for k in range(len(z)):
        for axis in range(AXES):
            predict(state[axis], noise[axis], dt[k])
        if not math.isnan(z[k][0]):
            _remember(recent[count % len(recent)], state, noise, z[k], k1)
            count += 1
            agreement = _agreement(recent)
            alpha = equivalent_weight(agreement, c0, c1, math.inf, math.inf)
            if alpha < 1.0:
                _let_go(state, recent, max(alpha, SMALLEST), agreement > c1)
            is_step[k] = 1.0 if agreement > c1 else 0.0
            _take_up(state, noise, z[k], k0, k1)
        for axis in range(AXES):
            level[k][axis] = state[axis][LEVEL]


@kernel
def _remember(recent, state, noise, z, longest):
    """Keep the standardised innovation, cut to `longest`: a gross error alone must not look like agreement."""
    size = math.sqrt(squared_length(state, noise, z))
    for axis in range(AXES):
        sigma = math.sqrt(innovation_variance(state[axis], noise[axis]))
        recent[axis] = innovation(state[axis], z[axis]) / sigma * min(1.0, longest / max(size, longest))


@kernel
def _agreement(recent):
    """Return the length of the sum of n standardised innovations over sqrt(n)."""
    total = 0.0
    for axis in range(AXES):
        mean = 0.0
        for i in range(len(recent)):
            mean += recent[i][axis]
        total += mean * mean
    return math.sqrt(total / len(recent))


@kernel
def _let_go(state, recent, alpha, forget):
    """Divide the level's variance by alpha; innovations from before a step that was found say nothing about the next."""
    for axis in range(AXES):
        state[axis][P_LEVEL] /= alpha
        if forget:
            for i in range(len(recent)):
                recent[i][axis] = 0.0


@kernel
def _take_up(state, noise, z, k0, k1):
    eta = equivalent_weight(math.sqrt(squared_length(state, noise, z)), k0, k1, math.inf, math.inf)
    if eta > 0.0:
        for axis in range(AXES):
            S = innovation_variance(state[axis], noise[axis]) + noise[axis][WHITE] * (1.0 / eta - 1.0)
            update(state[axis], S, innovation(state[axis], z[axis]))
