"""Outlier or step: a filter that waits a few epochs before it decides.

One solution far off says nothing: an outlier and the first epoch of a step look alike. So innovations longer than some sigma are clipped, and
what follows decides. At each epoch two tests are made on the last epochs with a solution:

1. the generalised likelihood ratio of Willsky and Jones (1976), IEEE Trans. Automatic Control 21:108-115. A step of height d at epoch j makes
   innovations g_k d, where g_k is what the filter has not yet taken up. With A = sum g v / S and B = sum g^2 / S the best height gains
   A^2 / 2B in likelihood; the more epochs are looked at, the more must be gained (log n / 2). It is cheap, and sees only clipped innovations;
2. where it speaks up, both stories are filtered once more from j: nothing happened, or the level is new at j. Their likelihoods know gross
   errors: log(N(v; 0, S) + exp(-lost) / (1 + v^2 / 25 S)^2), so that one solution costs about `lost` whatever its error.

A large gain decides for the second story unless gross errors explain it (`threshold`, `story`); so does a small one where the story is much the
better (`pretest`, `sure_story`): a step of many sigma, whose innovations are clipped. It becomes the filter's own: from j on as if the step had
been known. Deciding late and repairing the past is the "detection, identification, adaptation" of Teunissen (1990).
"""

import math

from gnsslab.core.jit import kernel, matrix
from gnsslab.core.level_filter import (
    COLOURED,
    LEVEL,
    P_RR,
    P_XX,
    RATE,
    STATE_SIZE,
    WHITE,
    gains,
    innovation,
    innovation_variance,
    predict,
    update,
)  # fmt: skip
from gnsslab.core.recent_mean import LONGEST, recent_mean

AXES = 3
OK, OUTLIER, STEP, GAP = range(4)
LEFT_LEVEL, LEFT_RATE, LEFT_COLOUR, EXPLAINED, POWER = range(5)  # of a unit step on one axis: what the states have not yet taken up; A; B
EFFECT_SIZE = 5
GROSS_SCALE = 5.0  # [sigma] from here on the likelihood of a gross error falls
AFTERSLIP = 0.01  # of its size, an epoch: how fast the ground may go on after a step
NO_STEP = -1


@kernel
def follow(z, dt, noise, weights, variances, settings, memory, first, last, out):
    """Filter epochs `first` to `last` - 1 of positions z (T, 3), NaN where there is none, `dt` (T,) epochs after the one before.

    noise (3, 4), see `level_filter`; weights and variances (3, 100) of a `recent_mean`. settings: clip, outlier, lost, width, threshold, pretest,
    story, sure_story, settling, fewest, see `systems.monitoring`. memory: state (3, 9), effects (W, 15), saved (W, 27), starts (W,), cleaned
    solutions (n, 3) in their order, the order (T,) of each epoch among them, [how many solutions there were, from which one on the level is the
    present one]; all go on from call to call. W is how many epochs back a step may lie.
    out: steady level, its sigma, rate, its sigma, recent level, its sigma (T, 3), flag (T,), start (T,): the first epoch of a step found at an
    epoch, else NO_STEP.
    """
    clip, outlier, lost, width, threshold, pretest, story, sure_story, settling, fewest = settings
    state, effects, saved, starts, cleaned, order, count = memory
    level, sigma, rate, sigma_rate, recent, sigma_recent, flag, start = out
    for k in range(first, last):
        start[k] = NO_STEP
        _predict_all(state, effects, noise, dt[k])
        if math.isnan(z[k][0]):
            flag[k] = GAP
        else:
            _start_candidate(k, state, effects, saved, starts, count)
            size = math.sqrt(_misfit(state, noise, z[k]))
            flag[k] = OUTLIER if size > outlier else OK
            weight = min(1.0, clip / max(size, clip))
            order[k] = count[0]
            _clean(cleaned[int(count[0])], state, z[k], weight)
            gain, which = _take_up(state, effects, noise, z[k], weight, starts, k, fewest)
            count[0] += 1.0
            doubt = 1.0 + settling / count[0]  # with few epochs the noise is badly known
            if gain > pretest * doubt and count[0] > settling:
                needed = doubt * (story if gain > threshold * doubt else sure_story)
                j = _decide(z, dt, noise, (clip, lost, width, needed, fewest), saved, starts, starts[which], k, state, cleaned, order)
                if j >= 0:
                    flag[k], start[k], count[1] = STEP, j, order[j]
                    for c in range(len(starts)):
                        starts[c] = NO_STEP
        for axis in range(AXES):
            level[k][axis], sigma[k][axis] = state[axis][LEVEL], math.sqrt(state[axis][P_XX])
            rate[k][axis], sigma_rate[k][axis] = state[axis][RATE], math.sqrt(state[axis][P_RR])
            begin, end = int(count[1]), int(count[0])
            recent[k][axis] = recent_mean(cleaned, begin, end, axis, weights[axis])
            sigma_recent[k][axis] = math.sqrt(variances[axis][min(end - begin, LONGEST) - 1])


@kernel
def _predict_all(state, effects, noise, dt):
    for axis in range(AXES):
        a = predict(state[axis], noise[axis], dt)
        for c in range(len(effects)):
            effect, i = effects[c], EFFECT_SIZE * axis
            effect[i + LEFT_LEVEL] += dt * effect[i + LEFT_RATE]
            effect[i + LEFT_COLOUR] *= a


@kernel
def _start_candidate(k, state, effects, saved, starts, count):
    """Let a step that begins at this epoch take the place of the oldest candidate."""
    c = int(count[0]) % len(starts)
    starts[c] = k
    for axis in range(AXES):
        for i in range(EFFECT_SIZE):
            effects[c][EFFECT_SIZE * axis + i] = 1.0 if i == LEFT_LEVEL else 0.0
        for i in range(STATE_SIZE):
            saved[c][STATE_SIZE * axis + i] = state[axis][i]


@kernel
def _misfit(state, noise, z):
    """Return the squared length of the innovation in sigmas."""
    total = 0.0
    for axis in range(AXES):
        v = innovation(state[axis], z[axis])
        total += v * v / innovation_variance(state[axis], noise[axis])
    return total


@kernel
def _clean(row, state, z, weight):
    """Write the solution z (3,) into a row, what is too far off cut as its innovation is."""
    for axis in range(AXES):
        row[axis] = z[axis] - (1.0 - weight) * innovation(state[axis], z[axis])


@kernel
def _take_up(state, effects, noise, z, weight, starts, k, fewest):
    """Update the state with the weighted innovation, and each candidate's effect; return the largest gain A^2 / 2B, and whose it is."""
    most, which = 0.0, 0
    for axis in range(AXES):
        S, v = innovation_variance(state[axis], noise[axis]), weight * innovation(state[axis], z[axis])
        on_level, on_rate, on_colour = gains(state[axis], S)
        update(state[axis], S, v)
        for c in range(len(effects)):
            _weigh(effects[c], EFFECT_SIZE * axis, v, S, on_level, on_rate, on_colour)
    for c in range(len(effects)):
        if starts[c] >= 0 and k - starts[c] >= fewest - 1:
            gain = _explained(effects[c]) - 0.5 * math.log(k - starts[c] + 1.0)
            if gain > most:
                most, which = gain, c
    return most, which


@kernel
def _weigh(effect, i, v, S, on_level, on_rate, on_colour):
    g = effect[i + LEFT_LEVEL] + effect[i + LEFT_COLOUR]
    effect[i + EXPLAINED] += g * v / S
    effect[i + POWER] += g * g / S
    effect[i + LEFT_LEVEL] -= on_level * g
    effect[i + LEFT_RATE] -= on_rate * g
    effect[i + LEFT_COLOUR] -= on_colour * g


@kernel
def _explained(effect):
    total = 0.0
    for axis in range(AXES):
        A, B = effect[EFFECT_SIZE * axis + EXPLAINED], effect[EFFECT_SIZE * axis + POWER]
        if B > 0.0:
            total += A * A / B / 2.0
    return total


@kernel
def _decide(z, dt, noise, rules, saved, starts, earliest, k, state, cleaned, order):
    """Tell both stories for each candidate from `earliest` on; take the best one for the state, if it is good enough, and return its start."""
    clip, lost, width, needed, fewest = rules
    trial, story = matrix(AXES, STATE_SIZE), matrix(len(starts), AXES)
    best, most = NO_STEP, needed
    for c in range(len(starts)):
        if starts[c] >= earliest and k - starts[c] >= fewest - 1:
            j = int(starts[c])
            _restore(trial, saved[c])
            quiet = _replay(z, dt, noise, trial, j, k, clip, lost, 0.0, story, order)
            _restore(trial, saved[c])
            gain = _replay(z, dt, noise, trial, j, k, clip, lost, width, story, order) - quiet
            if gain > most:
                best, most = j, gain
                _copy(state, trial, 0, AXES)
                _copy(cleaned, story, int(order[j]), int(order[k]) + 1)
    return best


@kernel
def _copy(rows, source, first, last):
    """Copy rows first to last - 1 from the beginning of another matrix."""
    for k in range(first, last):
        for i in range(len(rows[k])):
            rows[k][i] = source[k - first][i]


@kernel
def _restore(trial, saved):
    for axis in range(AXES):
        for i in range(STATE_SIZE):
            trial[axis][i] = saved[STATE_SIZE * axis + i]


@kernel
def _replay(z, dt, noise, trial, j, k, clip, lost, width, story, order):
    """Filter epochs j to k anew from a state predicted to j, in place; return the log likelihood.

    With a width [sigma of the noise] the level may have stepped by about as much at j: the likelihood of the first solution says so, and
    the level is then taken from it alone. The cleaned solutions are written into `story`.
    """
    total = 0.0
    for i in range(j, k + 1):
        if i > j:
            for axis in range(AXES):
                predict(trial[axis], noise[axis], dt[i])
        if not math.isnan(z[i][0]):
            if i == j:
                _widen(trial, noise, width)
            total += _log_likelihood(trial, noise, z[i], lost)
            weight = min(1.0, clip / max(math.sqrt(_misfit(trial, noise, z[i])), clip))
            if i == j and width > 0.0:
                weight = 1.0
                _begin_anew(trial, noise, z[i], width)
            _clean(story[int(order[i] - order[j])], trial, z[i], weight)
            for axis in range(AXES):
                update(trial[axis], innovation_variance(trial[axis], noise[axis]), weight * innovation(trial[axis], z[i][axis]))
    return total


@kernel
def _begin_anew(trial, noise, z, width):
    """Let the level be what the solution z (3,) says; its rate may be as before, or none, or the larger the larger the step."""
    _widen(trial, noise, 100.0 * width)
    for axis in range(AXES):
        trial[axis][P_RR] += (AFTERSLIP * innovation(trial[axis], z[axis])) ** 2 + trial[axis][RATE] ** 2


@kernel
def _widen(trial, noise, width):
    for axis in range(AXES):
        trial[axis][P_XX] += width * width * (noise[axis][WHITE] + noise[axis][COLOURED])


@kernel
def _log_likelihood(trial, noise, z, lost):
    """Return log(N(v; 0, S) + gross) in units in which the noise's own density is 1 at its middle."""
    misfit, shrink = 0.0, 0.0
    for axis in range(AXES):
        S, v = innovation_variance(trial[axis], noise[axis]), innovation(trial[axis], z[axis])
        misfit += v * v / S
        shrink += math.log(S / (noise[axis][WHITE] + noise[axis][COLOURED]))
    gross = math.exp(-lost) / (1.0 + misfit / GROSS_SCALE**2) ** 2
    return math.log(math.exp(-0.5 * (misfit + shrink)) + gross)
