"""The Kalman filter of paper A (Wang, Li, Sun and Ji 2019): baseline, velocity and ambiguities, with or without the known length.

State x = [b, v, B^1 ... B^m]: baseline [m], its velocity [m/s], single-difference ambiguities [cycles]. Double differences of code and
carrier come in as measurements (equations 7 to 13), the known length as one more (14, 32) or into the integer search; a ratio
test decides on the integers, and integers found some times in a row are held. What the paper misprints is mended here; two
switches bring misprints back, for comparison.
"""

import math
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np

from gnsslab.core.integers import GOOD
from gnsslab.core.jit import kernel, kernel_input, matrix, vector
from gnsslab.core.kalman import add_multiple, factor_cholesky, predict, solve_lower, update
from gnsslab.gnss.blocks import run_blocks
from gnsslab.gnss.filter_steps import (
    CODE,
    PHASE,
    SIGMA_CODE,
    SIGMA_PHASE,
    SLIP,
    copy_baseline,
    innovation,
    kernel_table,
    loosen,
    restart,
    search_integers,
    variances,
)
from gnsslab.gnss.frames import enu_rotation
from gnsslab.gnss.motion import forgetful, moving
from gnsslab.systems.length_row import AS_ROW, IN_SEARCH, LengthUse, update_by_length
from gnsslab.systems.printed_prediction import predict_as_printed

_NODE_LIMIT = 50_000


@dataclass(frozen=True)
class FilterSettings:
    """How the filter of paper A works; the defaults are those of its presets, whose noise gives the scatter of its figures."""

    length: float = 1.167  # [m]
    length_sigma: float = 0.005  # [m], of the row; the paper prints the length itself (equation 16)
    length_use: LengthUse = LengthUse.GUARDED_ROW
    ratio: float = 3.0  # least ratio of second best to best squared norm
    hold_after: int = 5  # fixes in a row, after which the integers are held; 0: never
    hold_sigma: float = 0.03  # [cycles], with which they are held: 0.001 cycles^2
    printed_prediction: bool = False  # P = F P + Q, equation (25) as printed
    printed_residual: bool = False  # equations (30), (31) as printed: the geometric range is left out


class FilterRun(NamedTuple):
    """What the filter found at each of T epochs, with c channels; axes of vectors are east, north, up."""

    baseline_float: np.ndarray  # (T, 3) [m]
    Q_float: np.ndarray  # (T, 3, 3) [m^2]
    baseline_fixed: np.ndarray  # (T, 3) [m], given the best integers; NaN where nothing could be searched
    Q_fixed: np.ndarray  # (T, 3, 3) [m^2]
    velocity: np.ndarray  # (T, 3) [m/s], NaN where the path has none
    ratio: np.ndarray  # (T,) second best over best squared norm, 0 where nothing could be searched
    is_fixed: np.ndarray  # (T,) bool, the ratio test is passed
    is_held: np.ndarray  # (T,) bool, the integers were written into the filter
    row_state: np.ndarray  # (T,) of RowState
    row_innovation: np.ndarray  # (T,) [m], length minus the filter's, NaN without a row
    row_sigma: np.ndarray  # (T,) [m], of this innovation
    nis_code: np.ndarray  # (T,) normalised innovation squared of the codes, chi-square of `freedom` when all is well
    nis_phase: np.ndarray  # (T,) of the carriers
    freedom: np.ndarray  # (T,) how many double differences there are of each
    innovation: np.ndarray  # (T, c) [m], of the carriers' double differences; NaN for references and what was not measured
    innovation_sigma: np.ndarray  # (T, c) [m], as the filter expects it

    @property
    def baseline(self):
        """The best baseline (T, 3) [m]: fixed where it is, else float."""
        return np.where(self.is_fixed[:, None], self.baseline_fixed, self.baseline_float)

    @property
    def Q(self):
        """Its covariance (T, 3, 3) [m^2]."""
        return np.where(self.is_fixed[:, None, None], self.Q_fixed, self.Q_float)

    @property
    def first_fix(self):
        """Index of the first fixed epoch; None without one."""
        return int(np.argmax(self.is_fixed)) if self.is_fixed.any() else None


def run_filter(prepared, path, settings, progress=None):
    """Return the FilterRun of the epochs Prepared (gnss.preparation) along a Path, baselines in axes east, north, up.

    Raises ValueError for a length, sigma, ratio or hold that makes no sense.
    """
    _check(settings)
    c = prepared.model.usable.shape[1]
    memory = np.zeros(1)  # fixes in a row, carried from block to block
    filter_ = partial(_run_block, settings=settings, memory=memory, channels=c)
    found = run_blocks(prepared.model, path, progress, filter_).outcome
    return _in_enu(found, enu_rotation(prepared.master_ecef))


def steady_path(prepared, velocity_noise):
    """Return the Path of a baseline whose velocity wanders (equations 23 to 28, mended): Q_v = S' diag(sigma^2) S dt.

    `velocity_noise` (3,) [m/s per sqrt(s)] east, north, up. After a gap all starts anew (`motion.moving`).
    Raises ValueError for a noise that is not three numbers, zero or above.
    """
    sigma = np.asarray(velocity_noise, dtype=float)
    if sigma.shape != (3,) or not (np.isfinite(sigma) & (sigma >= 0)).all():
        raise ValueError(f"the velocity noise must be three numbers, zero or above (east, north, up, in m/s per root second), not {velocity_noise}")
    pair, R_ne = prepared.model.pair, enu_rotation(prepared.master_ecef)
    path = moving(pair.time, prepared.model.near)
    goes_on = path.F[:, 0, 0] > 0
    dt = np.diff(pair.time, prepend=pair.time[:1]) / np.timedelta64(1, "s")
    Q_v = R_ne.swapaxes(-1, -2) @ (sigma[:, None] ** 2 * R_ne) * dt[:, None, None]
    Q = np.where(goes_on[:, None, None], 0.0, path.Q)
    Q[goes_on, 3:, 3:] = Q_v[goes_on]
    return path._replace(Q=Q)


def direct_path(prepared):
    """Return the Path of the direct solution: the baseline starts anew at every epoch, the ambiguities go on."""
    steady = steady_path(prepared, np.zeros(3))
    return forgetful(prepared.model.pair.time, prepared.model.near)._replace(drift=steady.drift)


def _check(settings):
    claims = (
        (0 < settings.length < np.inf, f"the length between the antennas must be more than 0 m, not {settings.length:g}"),
        (
            0 < settings.length_sigma < np.inf,
            f"the sigma of the length must be more than 0 m, not {settings.length_sigma:g}",
        ),
        (settings.length_use in tuple(LengthUse), f"the use of the length must be one of LengthUse, not {settings.length_use}"),
        (settings.ratio >= 1, f"the ratio must be 1 or more (second best over best squared norm), not {settings.ratio:g}"),
        (settings.hold_after >= 0, f"hold_after counts fixes in a row, 0 for never; it is {settings.hold_after}"),
        (0 < settings.hold_sigma < np.inf, f"the sigma of held integers must be more than 0 cycles, not {settings.hold_sigma:g}"),
    )
    for claim, sentence in claims:
        if not claim:
            raise ValueError(sentence)


def _in_enu(found, R_ne):
    """Return the FilterRun with its vectors and covariances turned from ECEF to east, north, up."""
    vectors = {name: np.matvec(R_ne, getattr(found, name)) for name in ("baseline_float", "baseline_fixed", "velocity")}
    matrices = {name: R_ne @ getattr(found, name) @ R_ne.swapaxes(-1, -2) for name in ("Q_float", "Q_fixed")}
    return found._replace(**vectors, **matrices)


# The kernel's options stand in a vector, and its results are a row an epoch.
_LENGTH, _LENGTH_SIGMA, _USE, _RATIO, _HOLD_AFTER, _HOLD_SIGMA, _PRINTED_PREDICTION, _PRINTED_RESIDUAL = range(8)
_B_FLOAT, _B_FIXED, _VELOCITY, _RATIO_FOUND, _IS_FIXED, _IS_HELD, _ROW_STATE, _ROW, _ROW_SIGMA, _NIS_CODE, _NIS_PHASE, _RESULTS = (
    0, 12, 24, 27, 28, 29, 30, 31, 32, 33, 34, 35,
)  # fmt: skip


def _run_block(x, P, block, settings, memory, channels):
    """Run one block from state x (n,), P (n, n); return both after its last epoch, and a FilterRun in ECEF of all the channels."""
    table, pairs = kernel_table(block)
    T, d = len(block.code), len(pairs)
    options = kernel_input([float(getattr(settings, name)) for name in _OPTIONS])
    x, P, innovations = kernel_input(np.array(x)), kernel_input(np.array(P)), kernel_input(np.empty((T, 2 * d)))
    motion = (kernel_input(values) for values in (block.F, block.Q, block.offset, block.drift, block.near))
    state = kernel_input(memory)
    rows = np.asarray(_run_epochs(x, P, *motion, table, pairs, options, state, innovations))
    memory[:] = state
    return np.asarray(x), np.asarray(P), _filter_run(rows, np.asarray(innovations), block, channels)


_OPTIONS = ("length", "length_sigma", "length_use", "ratio", "hold_after", "hold_sigma", "printed_prediction", "printed_residual")


def _filter_run(rows, innovations, block, channels):
    T, d = len(rows), len(block.channel)
    spread = np.full((2, T, channels), np.nan)
    spread[:, :, block.channels[block.channel]] = innovations.reshape(T, 2, d).swapaxes(0, 1)
    b_float, Q_float, b_fixed, Q_fixed, velocity, *numbers = np.split(rows, [3, 12, 15, 24, *range(27, _RESULTS)], axis=1)
    ratio, is_fixed, is_held, row_state, *others = (column[:, 0] for column in numbers)
    square = (T, 3, 3)
    b_fixed[ratio == 0], Q_fixed[ratio == 0] = np.nan, np.nan
    return FilterRun(
        b_float, Q_float.reshape(square), b_fixed, Q_fixed.reshape(square), velocity, ratio, is_fixed > 0, is_held > 0,
        row_state.astype(np.int8), *others, np.full(T, d), *spread,
    )  # fmt: skip


@kernel
def _run_epochs(x, P, F, Q, offset, drift, near, table, pairs, options, memory, innovations):
    """Move x, P through T epochs, in place; return a row of results an epoch (T, 35), and fill the innovations (T, 2 d)."""
    rows = matrix(len(table), _RESULTS)
    p = len(offset[0])
    for t in range(len(table)):
        channels, row = table[t], rows[t]
        if options[_PRINTED_PREDICTION] == 0.0:
            predict(x, P, F[t], Q[t], offset[t])
        else:
            predict_as_printed(x, P, F[t], Q[t], offset[t])
        loosen(P, p, channels, drift[t])
        for i in range(len(channels)):
            if channels[i][SLIP] != 0.0:
                restart(x, P, p, channels, i)
        _, W = innovation(x, P, p, channels, pairs, _origin(x, near[t], options), variances(channels, SIGMA_CODE, False), CODE)
        row[_NIS_CODE] = _squared(W)
        update(x, P, W)
        C, W = innovation(x, P, p, channels, pairs, _origin(x, near[t], options), variances(channels, SIGMA_PHASE, False), PHASE)
        row[_NIS_PHASE] = _squared(W)
        _copy_innovation(C, W, innovations[t])
        update(x, P, W)
        row[_ROW_STATE], row[_ROW], row[_ROW_SIGMA] = update_by_length(x, P, options[_LENGTH], options[_LENGTH_SIGMA], options[_USE])
        copy_baseline(x, P, row, _B_FLOAT)
        for axis in range(3):
            row[_VELOCITY + axis] = x[3 + axis] if p == 6 else math.nan
        _fix(x, P, p, pairs, options, memory, row)
    return rows


@kernel
def _origin(x, near, options):
    """Return the baseline (3,) at which measurements were modelled; with the printed residual, one that leaves the baseline in them.

    The innovation is y - H (x - near). Without the geometric range it is y + H near, which an origin of near + x gives.
    """
    origin = vector(3)
    for axis in range(3):
        origin[axis] = near[axis] + (x[axis] if options[_PRINTED_RESIDUAL] != 0.0 else 0.0)
    return origin


@kernel
def _squared(W):
    """Return w'w of an innovation of unit covariance, w the last column of W."""
    total = 0.0
    for r in range(len(W)):
        total += W[r][-1] * W[r][-1]
    return total


@kernel
def _copy_innovation(C, W, out):
    """Write the innovation z = C w (d,) and its sigma, the root of the diagonal of C C', to a row (2 d,)."""
    d = len(W)
    for r in range(d):
        z, variance = 0.0, 0.0
        for q in range(r + 1):
            z += C[r][q] * W[q][-1]
            variance += C[r][q] * C[r][q]
        out[r], out[d + r] = z, math.sqrt(variance)


@kernel
def _fix(x, P, p, pairs, options, memory, row):
    """Search the integers, write the fixed baseline to the row, and hold integers found some times in a row, in place."""
    if len(pairs) == 0:
        memory[0] = 0.0
        return
    known = options[_LENGTH] if options[_USE] == IN_SEARCH else 0.0
    candidates, norms, nodes, status = search_integers(x, P, p, pairs, known, options[_LENGTH_SIGMA], _NODE_LIMIT)
    integers, ratio = candidates[0], norms[0][1] / max(norms[0][0], 1e-12)
    if status != GOOD or nodes[0][0] >= _NODE_LIMIT:
        ratio = 0.0
    if ratio > 0.0:
        b, Q_b = _given(x, P, p, pairs, integers)
        if known > 0.0:
            update_by_length(b, Q_b, known, options[_LENGTH_SIGMA], AS_ROW)
        copy_baseline(b, Q_b, row, _B_FIXED)
    is_fixed = ratio >= options[_RATIO]
    memory[0] = memory[0] + 1.0 if is_fixed else 0.0
    row[_RATIO_FOUND], row[_IS_FIXED] = ratio, 1.0 if is_fixed else 0.0
    if is_fixed and 0.0 < options[_HOLD_AFTER] <= memory[0]:
        row[_IS_HELD] = 1.0
        update(x, P, _integer_innovation(x, P, p, pairs, integers, options[_HOLD_SIGMA] ** 2))


@kernel
def _given(x, P, p, pairs, integers):
    """Return the baseline (3,) and its covariance (3, 3), given the integers (d,) of the double differences."""
    W = _integer_innovation(x, P, p, pairs, integers, 0.0)
    b, Q_b = vector(3), matrix(3, 3)
    for i in range(3):
        b[i] = x[i]
        for r in range(len(W)):
            b[i] += W[r][i] * W[r][-1]
        for j in range(3):
            Q_b[i][j] = P[i][j]
            for r in range(len(W)):
                Q_b[i][j] -= W[r][i] * W[r][j]
    return b, Q_b


@kernel
def _integer_innovation(x, P, p, pairs, integers, variance):
    """Return W = C^-1 [T P, a - T x] (d, n + 1), T x the double-difference ambiguities, C C' = T P T' + variance T T' / 2.

    With that pattern, 1 on and 1/2 off the diagonal, it does not matter which channel is the reference.
    """
    d, n = len(pairs), len(x)
    S, W = matrix(d, d), matrix(d, n + 1)
    for r in range(d):
        i, j = p + pairs[r][0], p + pairs[r][1]
        add_multiple(W[r], P[i], 1.0)
        add_multiple(W[r], P[j], -1.0)
        W[r][n] = integers[r] - (x[i] - x[j])
        for q in range(r + 1):
            S[r][q] = W[r][p + pairs[q][0]] - W[r][p + pairs[q][1]]
            if pairs[q][1] == pairs[r][1]:
                S[r][q] += variance if q == r else 0.5 * variance
    factor_cholesky(S)
    solve_lower(S, W)
    return W
