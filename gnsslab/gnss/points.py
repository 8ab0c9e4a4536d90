"""Single point positioning: where a receiver was, from its own code measurements and broadcast orbits, each epoch by itself.

code = |x_sat - x_rec| + clock_system - c dt_sat + troposphere + ionosphere + group delay + e     (one clock a system)
"""

import re
from collections import Counter
from dataclasses import dataclass, fields, replace
from enum import IntEnum
from typing import NamedTuple

import numpy as np

from gnsslab.core.least_squares import least_squares
from gnsslab.gnss.dense import single_frequency_codes
from gnsslab.gnss.frames import geodetic_from_ecef
from gnsslab.gnss.point_model import locate, sky_of
from gnsslab.gnss.point_reasons import no_solution_reasons
from gnsslab.gnss.signals import USED_SYSTEMS, check_systems
from gnsslab.gnss.velocity import solve_velocity

_CHUNK = 512  # epochs solved together: their arrays of 15 satellites stay within a processor's cache


class PointStatus(IntEnum):
    """Whether an epoch has a position; where NONE, `Points.reason` says why."""

    NONE = 0
    SOLVED = 1


@dataclass(frozen=True, eq=False)
class Points:
    """Single point solutions of T epochs, m satellites, s systems; NaN where there is none."""

    time: np.ndarray  # (T,) datetime64[ns], receiver time tags
    status: np.ndarray  # (T,) int8 of PointStatus
    position_ecef: np.ndarray  # (T, 3) [m] of the antenna
    Q_position: np.ndarray  # (T, 3, 3) [m^2]
    clock: np.ndarray  # (T, s) [m], receiver clock against each system's time, in order of `systems`
    velocity_ecef: np.ndarray  # (T, 3) [m/s], NaN without Doppler
    Q_velocity: np.ndarray  # (T, 3, 3) [m^2/s^2]
    clock_drift: np.ndarray  # (T,) [m/s]
    dop: np.ndarray  # (T, 4) geometric, position, horizontal and vertical dilution of precision, one clock
    satellites: np.ndarray  # (T,) int, how many were used
    reason: np.ndarray  # (T,) text, why there is no solution; empty where there is one
    used: np.ndarray  # (T, m) bool
    residual: np.ndarray  # (T, m) [m], measured - modelled code, also of satellites above the mask that were screened out
    azimuth: np.ndarray  # (T, m) [rad]
    elevation: np.ndarray  # (T, m) [rad]
    names: tuple[str, ...]  # (m,) satellites with code measurements
    systems: str  # (s,) letters of the clocks

    @property
    def is_solved(self):
        """Epochs with a position (T,) bool."""
        return self.status == PointStatus.SOLVED

    @property
    def geodetic(self):
        """Latitude, longitude [rad] and ellipsoidal height [m] (T, 3)."""
        return geodetic_from_ecef(self.position_ecef)

    def mean_position(self):
        """Return the mean ECEF position (3,) [m] of a receiver that stood still, weighted by 1 / trace Q; ValueError without any solution."""
        solved = self.is_solved
        if not solved.any():
            raise ValueError(f"no epoch has a single point position: {self.main_reason()}")
        weight = 1 / np.trace(self.Q_position[solved], axis1=-2, axis2=-1)
        return weight @ self.position_ecef[solved] / weight.sum()

    def main_reason(self):
        """Return a reason of the kind most unsolved epochs give (numbers aside), empty where all are solved."""
        return _most_common(self.reason)

    def __repr__(self):
        solved = int(self.is_solved.sum())
        return f"Points: {len(self.time)} epochs, {solved} solved; {len(self.names)} satellites of {self.systems or 'no system'}"


class Positions(NamedTuple):
    """Single point positions of T epochs and nothing else."""

    position_ecef: np.ndarray  # (T, 3) [m] of the antenna, NaN where there is none
    reason: np.ndarray  # (T,) text, why there is no solution; empty where there is one

    def main_reason(self):
        """Return a reason of the kind most unsolved epochs give (numbers aside), empty where all are solved."""
        return _most_common(self.reason)


_PER_EPOCH = tuple(f.name for f in fields(Points) if f.name not in ("names", "systems"))
_PER_SATELLITE = ("used", "residual", "azimuth", "elevation")


def solve_points(observations, ephemerides, *, systems=USED_SYSTEMS, mask_deg=10.0, epochs=None):
    """Return the `Points` of one receiver: position, clocks, Doppler velocity and their covariances at every epoch.

    Weighted least squares on the codes of the first band of each system, one clock a system, repeated until nothing is left to move;
    a satellite with a normalised residual above 4 is taken out, one at a time. Broadcast ionosphere, Saastamoinen troposphere.
    `epochs` (indices, mask or slice) picks some epochs; `mask_deg` is the lowest elevation used. An epoch without a
    solution is NaN with the reason in words; an unknown system raises ValueError.
    """
    measured, chunks = _chunks(observations, systems, mask_deg, epochs)
    systems = _letters(measured.satellites)
    parts = [_solve_chunk(observations.time[chunk], measured, chunk, systems, ephemerides, np.radians(mask_deg)) for chunk in chunks]
    joined = {name: np.concatenate([getattr(part, name) for part in parts]) for name in _PER_EPOCH}
    return Points(**joined, names=measured.satellites, systems=systems)


def solve_positions(observations, ephemerides, *, systems=USED_SYSTEMS, mask_deg=10.0, epochs=None):
    """Return the `Positions` of one receiver: those of `solve_points`, without velocities and dilutions, in three quarters of the time."""
    measured, chunks = _chunks(observations, systems, mask_deg, epochs)
    parts = []
    for chunk in chunks:
        sky, _ = _sky_of_chunk(observations.time[chunk], measured, chunk, _letters(measured.satellites), ephemerides)
        located = locate(sky, np.radians(mask_deg))
        reason = no_solution_reasons(sky, located, np.radians(mask_deg))
        parts.append((np.where((reason == "")[:, None], located.position, np.nan), reason))
    return Positions(*map(np.concatenate, zip(*parts, strict=True)))


def dilution_of_precision(u_enu, used):
    """Return GDOP, PDOP, HDOP, VDOP (..., 4) of unit vectors to m satellites (..., m, 3) in ENU; NaN with fewer than four or all in a cone.

    D = (A' A)^-1, A = [-u 1];  GDOP^2 = tr D,  PDOP^2 = D_ee + D_nn + D_uu,  HDOP^2 = D_ee + D_nn,  VDOP^2 = D_uu

    >>> u = [[0, 0, 1], [0, 1, 0], [np.sqrt(0.75), -0.5, 0], [-np.sqrt(0.75), -0.5, 0]]
    >>> np.round(dilution_of_precision(np.array(u), np.ones(4, bool)) ** 2, 3).tolist()
    [3.0, 2.667, 1.333, 1.333]
    """
    A = np.concatenate([-u_enu, np.ones((*u_enu.shape[:-1], 1))], axis=-1)
    fit = least_squares(A, np.zeros(used.shape), np.ones(used.shape), used)
    east, north, up, clock = np.moveaxis(np.diagonal(fit.Q, axis1=-2, axis2=-1), -1, 0)
    return np.sqrt(np.stack([east + north + up + clock, east + north + up, east + north, up], axis=-1))


def _check(systems, mask_deg):
    check_systems(systems)
    if not -90 <= mask_deg < 90:
        raise ValueError(f"the elevation mask must be between -90 and 90 degrees, {mask_deg:g} was given")


def _chunks(observations, systems, mask_deg, epochs):
    """Return the Dense codes of a receiver, and the chosen epochs in chunks of indices."""
    _check(systems, mask_deg)
    epochs = np.arange(len(observations.time))[slice(None) if epochs is None else epochs]
    return single_frequency_codes(observations, systems), [epochs[i : i + _CHUNK] for i in range(0, max(len(epochs), 1), _CHUNK)]


def _letters(satellites):
    return "".join(dict.fromkeys(name[0] for name in satellites))


def _sky_of_chunk(time, measured, epochs, systems, ephemerides):
    """Return the Sky of some epochs, and which satellites (j,) were seen in them: the others take no part."""
    columns = np.flatnonzero(np.isfinite(measured.code[epochs]).any(axis=0))
    return sky_of(time, measured.part(epochs, columns), systems, ephemerides), columns


def _solve_chunk(time, measured, epochs, systems, ephemerides, mask):
    """Return the Points of some epochs; satellites not seen in them stand empty in the result."""
    sky, columns = _sky_of_chunk(time, measured, epochs, systems, ephemerides)
    points, shape = _solve(sky, mask), (len(epochs), len(measured.satellites))
    return replace(points, **{name: _spread(getattr(points, name), columns, shape) for name in _PER_SATELLITE})


def _spread(values, columns, shape):
    """Return values (T, j) at their columns of an array (T, m), NaN or False elsewhere."""
    spread = np.zeros(shape, dtype=bool) if values.dtype == bool else np.full(shape, np.nan)
    spread[:, columns] = values
    return spread


def _solve(sky, mask):
    """Return the Points of one Sky."""
    located = locate(sky, mask)
    reason = no_solution_reasons(sky, located, mask)
    solved = reason == ""
    motion = solve_velocity(sky, located, solved)
    keep = solved[:, None]
    return Points(
        time=sky.time,
        status=np.where(solved, PointStatus.SOLVED, PointStatus.NONE).astype(np.int8),
        position_ecef=np.where(keep, located.position, np.nan),
        Q_position=np.where(keep[..., None], located.fit.Q[:, :3, :3], np.nan),
        clock=np.where(keep, located.fit.x[:, 3:], np.nan),
        velocity_ecef=motion.velocity,
        Q_velocity=motion.Q_velocity,
        clock_drift=motion.clock_drift,
        dop=np.where(keep, dilution_of_precision(located.u_enu, located.fit.used), np.nan),
        satellites=np.where(solved, located.fit.used.sum(axis=-1), 0),
        reason=reason,
        used=located.fit.used & keep,
        residual=np.where(keep & located.above, located.fit.residual, np.nan),
        azimuth=np.where(keep, located.azimuth, np.nan),
        elevation=np.where(keep, located.elevation, np.nan),
        names=sky.names,
        systems=sky.systems,
    )


def _most_common(reasons):
    """Return the first of the most common kind of reasons, numbers and empty ones aside; empty where there is none."""
    given = [reason for reason in reasons.tolist() if reason]
    kinds = [re.sub(r"\d+", "#", reason) for reason in given]
    return given[kinds.index(Counter(kinds).most_common(1)[0][0])] if given else ""
