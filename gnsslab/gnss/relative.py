"""Relative positioning: the baseline from a master to a rover by carrier phase, epoch by epoch.

Observations of two receivers -> Pair (common epochs and channels) -> Model (ranges, weights, slips) -> Blocks -> filter -> Relative.
The master may stand on known ground or move along (moving base): only its own position array differs.
"""

from dataclasses import dataclass, replace
from enum import IntEnum

import numpy as np

from gnsslab.gnss.blocks import run_blocks
from gnsslab.gnss.frames import enu_rotation
from gnsslab.gnss.judging import believed_by_ratio, variance_factor
from gnsslab.gnss.known_length import cautious, run_with_length
from gnsslab.gnss.moving_base import at_rover_instants, shift_covariance
from gnsslab.gnss.points import solve_points, solve_positions
from gnsslab.gnss.preparation import Settings, path_of, prepare, prepare_moving, without_gaps
from gnsslab.gnss.times import usual_step
from gnsslab.gnss.weighting import inflation_of_mean

FEWEST_SATELLITES = 4
ATMOSPHERE = 1e-6  # of the baseline's length, standard deviation on each axis: what ionosphere and troposphere leave in a difference
LARGEST_SIGMA = 30.0  # [m], of a float baseline: beyond, the codes of the epoch have not determined it
BASE_MISPLACED = 500.0  # [m] between a base's position and its codes: each 100 m move the rover by up to a millimetre a kilometre


class Status(IntEnum):
    """How far an epoch's solution may be trusted."""

    NONE = 0
    FLOAT = 1
    FIXED = 2


@dataclass(frozen=True, eq=False)
class Relative:
    """Baselines from master to rover at every epoch of the rover; NaN where there is none."""

    time: np.ndarray  # (T,) datetime64[ns], the rover's tags
    status: np.ndarray  # (T,) int8 of Status
    baseline_ecef: np.ndarray  # (T, 3) [m]
    baseline_enu: np.ndarray  # (T, 3) [m], axes at the master
    Q_enu: np.ndarray  # (T, 3, 3) [m^2]
    position_ecef: np.ndarray  # (T, 3) [m], the master's plus the baseline
    ratio: np.ndarray  # (T,) second best over best squared norm of the integer search
    satellites: np.ndarray  # (T,) int, used

    def __repr__(self):
        fixed, floats = (int((self.status == status).sum()) for status in (Status.FIXED, Status.FLOAT))
        return f"Relative: {len(self.time)} epochs, {fixed} fixed, {floats} float, {len(self.time) - fixed - floats} without solution"


def solve_relative(base, rover, ephemerides, *, base_position=None, static=False, progress=None, **settings):
    """Return the Relative position of a rover against a base that stands still.

    `base_position` (3,) [m] is the base's antenna reference point in ECEF; without it `station_position` serves. With `static`
    the rover stands still too (single epochs are not averaged all the same). `settings` are those of `Settings`;
    `progress(done, total)` is called now and then. Raises ValueError without common epochs or satellites, where the
    navigation data are of another day, or where the base's own codes place it elsewhere.
    """
    settings = Settings(**settings)
    if base_position is None:
        base_position = station_position(base, ephemerides)
    base_position = _checked_position(base_position)
    _refuse_misplaced(base_position, base, ephemerides)
    master_ecef = np.broadcast_to(base_position, (len(base.time), 3))
    prepared = prepare(base, rover, master_ecef, ephemerides, settings)
    return _relative(*_solve(prepared, settings, static, progress), prepared, rover.time)


def solve_moving(master, rover, ephemerides, *, length=None, length_sigma=0.005, progress=None, **settings):
    """Return the Relative position of a rover against a master that may move itself (moving base).

    A known `length` [m] of the baseline, with `length_sigma` [m], takes part in the search for the integers (`known_length`).

    The master's own position comes from its code at each epoch: an error of 1 m there turns a baseline of length l by
    l / 20 000 km only. Baselines are those at the instants when the rover measured (`moving_base.at_rover_instants`), and the
    error of the master's Doppler velocity is in their covariance. Options and errors as in `solve_relative`.
    """
    settings = Settings(**settings)
    if length is not None:
        settings = replace(settings, noise=cautious(settings.noise))
    prepared = prepare_moving(master, rover, ephemerides, settings)
    if settings.position_correction:
        prepared = at_rover_instants(prepared)
    relative = _relative(*_solve_with_length(prepared, settings, length, length_sigma, progress), prepared, rover.time)
    if not settings.position_correction:
        return relative
    Q_enu = relative.Q_enu.copy()
    Q_enu[prepared.model.pair.epoch] += shift_covariance(prepared)
    return replace(relative, Q_enu=Q_enu)


def running_mean(outcome, is_fixed, interval, noise):
    """Return the Outcome with each fixed baseline replaced by the weighted mean of all fixed ones up to it: the rover stands still.

    b = (sum Q_t^-1)^-1 sum Q_t^-1 b_t; its covariance is inflated as that of a mean of correlated measurements.
    """
    baseline, Q = outcome.baseline_fixed.copy(), outcome.Q_fixed.copy()
    weight = np.linalg.inv(Q[is_fixed])
    total = np.cumsum(weight, axis=0)
    inflation = inflation_of_mean(np.arange(1, len(weight) + 1), interval, noise.correlated_share, noise.correlation_time)
    Q_mean = np.linalg.inv(total)
    baseline[is_fixed] = np.einsum("tij,tj->ti", Q_mean, np.cumsum(np.einsum("tij,tj->ti", weight, baseline[is_fixed]), axis=0))
    Q[is_fixed] = Q_mean * inflation[:, None, None]
    return outcome._replace(baseline_fixed=baseline, Q_fixed=Q)


def station_position(base, ephemerides):
    """Return the ECEF position (3,) [m] of a base's antenna reference point.

    It is `header_position`, or the mean single-point position where the header has none or one that the base's codes contradict.
    """
    position = header_position(base)
    if position is None or distance_from_codes(position, base, ephemerides) > BASE_MISPLACED:
        return without_gaps(solve_positions(base, ephemerides)).mean(axis=0)
    return position


def header_position(base):
    """Return the ECEF position (3,) [m] that the RINEX header gives, marker plus antenna offset; None without a marker."""
    marker = base.header.position_ecef
    return None if marker is None else marker + enu_rotation(marker).T @ base.header.antenna_delta_enu


def distance_from_codes(position, base, ephemerides):
    """Return how far [m] a position (3,) lies from where the base's own codes, at a few of its epochs, place it; NaN where they do not."""
    few = np.arange(0, len(base.time), max(1, len(base.time) // 5))
    points = solve_points(base, ephemerides, epochs=few)
    if not points.is_solved.any():
        return np.nan
    return float(np.linalg.norm(np.nanmedian(points.position_ecef, axis=0) - position))


def _checked_position(position):
    checked = np.asarray(position, dtype=float)
    if checked.shape != (3,) or not np.isfinite(checked).all():
        raise ValueError(f"base_position must be three finite ECEF coordinates [m], not {position}")
    return checked


def _refuse_misplaced(position, base, ephemerides):
    apart = distance_from_codes(position, base, ephemerides)
    if apart > BASE_MISPLACED:
        raise ValueError(f"the base position is {apart / 1000:.1f} km from where the base's own codes place it: give the right one")


def _solve(prepared, settings, static, progress):
    """Return the Solution of the epochs Prepared, and the Status (T,) of each."""
    model = prepared.model
    solution = run_blocks(model, path_of(prepared, settings, static), progress)
    status = _judged(solution, believed_by_ratio(solution.outcome, solution.outcome.integers, settings.acceptance))
    if static and not settings.single_epoch:
        averaged = running_mean(solution.outcome, status == Status.FIXED, usual_step(model.pair.time), settings.noise)
        solution = solution._replace(outcome=averaged)
    return solution, status


def _solve_with_length(prepared, settings, length, length_sigma, progress):
    """Return the same, the baseline's length being known; None where it is not."""
    if length is None:
        return _solve(prepared, settings, False, progress)
    path = path_of(prepared, settings)
    solution, is_believed = run_with_length(prepared.model, path, length, length_sigma, settings.acceptance, progress)
    return solution, _judged(solution, is_believed)


def _judged(solution, is_believed):
    """Return the Status (T,) of every common epoch, given whose integers are believed (T,)."""
    outcome = solution.outcome
    status = np.where(is_believed, Status.FIXED, Status.FLOAT).astype(np.int8)
    is_vague = np.trace(outcome.Q_float, axis1=1, axis2=2) > LARGEST_SIGMA**2
    status[(solution.satellites < FEWEST_SATELLITES) | (is_vague & ~is_believed)] = Status.NONE
    return status


def _relative(solution, status, prepared, time):
    """Return the Relative of all the rover's epochs `time` (T_all,) from what was found at those Prepared (T,)."""
    outcome, epoch, master_ecef = solution.outcome, prepared.model.pair.epoch, prepared.master_ecef
    factor = variance_factor(outcome, status == Status.FIXED)
    is_fixed = (status == Status.FIXED)[:, None]
    baseline = np.where(is_fixed, outcome.baseline_fixed, outcome.baseline_float)
    Q = np.where(is_fixed[..., None], outcome.Q_fixed, outcome.Q_float)
    R_ne = enu_rotation(master_ecef)
    solved = status > Status.NONE

    def at_all_epochs(values, missing=np.nan):
        spread = np.full((len(time), *values.shape[1:]), missing, dtype=np.asarray(values).dtype)
        spread[epoch[solved]] = values[solved]
        return spread

    return Relative(
        time=time,
        status=at_all_epochs(status, Status.NONE),
        baseline_ecef=at_all_epochs(baseline),
        baseline_enu=at_all_epochs(np.einsum("tij,tj->ti", R_ne, baseline)),
        Q_enu=at_all_epochs(factor * R_ne @ Q @ R_ne.swapaxes(-1, -2) + _atmosphere_left(baseline)),
        position_ecef=at_all_epochs(master_ecef + baseline),
        ratio=at_all_epochs(outcome.ratio),
        satellites=at_all_epochs(solution.satellites, 0),
    )


def _atmosphere_left(baseline):
    """Return the covariance (T, 3, 3) [m^2] of what the atmospheres of both ends do not have in common: 1 mm a kilometre."""
    sigma = ATMOSPHERE * np.linalg.norm(baseline, axis=-1)
    return sigma[:, None, None] ** 2 * np.eye(3)
