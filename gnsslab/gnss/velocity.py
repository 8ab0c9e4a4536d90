"""Velocity from Doppler: how fast a receiver moved, from the rate of its ranges to satellites of known velocity."""

from typing import NamedTuple

import numpy as np

from gnsslab.core.least_squares import screened_least_squares
from gnsslab.gnss.orbits import EARTH_RATE_WGS84, rotate_to_reception
from gnsslab.gnss.point_model import LOWEST_MAPPED, SCREENING_THRESHOLD
from gnsslab.gnss.signals import SPEED_OF_LIGHT
from gnsslab.gnss.weighting import TYPICAL_CN0

SIGMA_DOPPLER = 0.05  # [m/s] at 45 dB-Hz in the zenith: a receiver for surveying has 0.02, one of a phone 0.1 and more


class Motion(NamedTuple):
    """Velocities of T epochs, NaN where there are fewer than four Dopplers or no position."""

    velocity: np.ndarray  # (T, 3) ECEF [m/s]
    Q_velocity: np.ndarray  # (T, 3, 3) [m^2/s^2]
    clock_drift: np.ndarray  # (T,) [m/s]


def solve_velocity(sky, located, solved):
    """Return the `Motion` at the epochs `solved` (T,), screened by normalised residuals like the codes.

    -lambda D = r' + c dt_rec' - c dt_sat',   r' = g u . (v_sat - v_rec)   with g as in `range_rates`
    """
    v_sat, g = reception_velocities(sky.states, located)
    rate_still = g * (located.u * v_sat).sum(axis=-1)
    y = -SPEED_OF_LIGHT / sky.frequency * sky.doppler - rate_still + SPEED_OF_LIGHT * sky.states.clock_drift
    A = np.concatenate([-g[..., None] * located.u, np.ones((*y.shape, 1))], axis=-1)
    used = located.fit.used & solved[:, None]
    fit = screened_least_squares(A, y, sigma_doppler(located.elevation, sky.cn0), used, SCREENING_THRESHOLD)
    return Motion(fit.x[:, :3], fit.Q[:, :3, :3], fit.x[:, 3])


def reception_velocities(states, located):
    """Return satellite velocities (T, m, 3) [m/s] in the frame of reception, and the factor g (T, m) of the range rates.

    The signal received now left tau ago, and tau itself changes: with w the Earth's rotation vector and all in the frame of reception,
    r' = u . (v_sat - v_rec) - (r' / c) u . (v_sat + w x x_sat),   so   r' = g u . (v_sat - v_rec),  1 / g = 1 + u . (v_sat + w x x_sat) / c.
    The turn of the frame carries the Sagnac term; g is 1 within 3e-6 (2 mm/s).
    """
    distance = np.sqrt(((located.satellite - located.position[:, None]) ** 2).sum(axis=-1))
    v_sat = rotate_to_reception(states.velocity, distance / SPEED_OF_LIGHT)
    v_inertial = v_sat + np.cross([0.0, 0.0, EARTH_RATE_WGS84], located.satellite)
    return v_sat, 1 / (1 + (located.u * v_inertial).sum(axis=-1) / SPEED_OF_LIGHT)


def sigma_doppler(elevation, cn0):
    """Return the standard deviation of a range rate from Doppler (T, m) [m/s]: 0.05 sqrt((1 / sin^2 el + 10^((45 - C/N0) / 10)) / 2).

    A missing C/N0 counts as 45 dB-Hz; elevations below 2 deg count as 2 deg.

    >>> sigma_doppler(np.radians([90.0, 30.0]), np.array([45.0, np.nan])).round(3).tolist()
    [0.05, 0.079]
    """
    cn0 = np.where(np.isfinite(cn0) & (cn0 > 0), cn0, TYPICAL_CN0)
    thermal = 10 ** ((TYPICAL_CN0 - cn0) / 10)
    return SIGMA_DOPPLER * np.sqrt((1 / np.sin(np.maximum(elevation, LOWEST_MAPPED)) ** 2 + thermal) / 2)
