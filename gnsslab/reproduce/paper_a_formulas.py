"""Equations of paper A as printed, minus as mended: one number each, at the paper's site and for its baseline."""

import numpy as np

from gnsslab.core.rotations import heading_pitch_of, within_half_turn
from gnsslab.gnss.frames import enu_rotation_at
from gnsslab.systems.dual_antenna import A_STATIC, angle_sigmas, with_known_length
from gnsslab.systems.printed_attitude import heading_as_printed, pitch_as_printed, sigma_heading_as_printed, sigma_pitch_as_printed

LATITUDE, LONGITUDE = np.radians(25.286), np.radians(110.33)
LENGTH = A_STATIC.filter.length
PRIOR = 0.01  # [m], of a baseline before its length is used
SIGMA_ENU = np.array([0.006, 0.009, 0.016])  # [m]
SPEED, AIM = 0.061, np.radians(0.5)  # [m/s] of the master on the turntable; the paper's accuracy of heading


def formula_numbers():
    """Return the numbers by key, angles in degrees, lengths in mm."""
    return {
        "formula 4": _deg(_heading_with_printed_axes(np.radians(35)) - np.radians(35)),
        "formula 5": _deg(heading_as_printed(_baseline(120)) - heading_pitch_of(_baseline(120))[0]),
        "formula 6": _deg(pitch_as_printed(_baseline(35, 20)) - heading_pitch_of(_baseline(35, 20))[1]),
        "formula 16": 1e3 * (_sigma_along(LENGTH) - _sigma_along(A_STATIC.filter.length_sigma)),
        "formula 25": _asymmetry_as_printed(),
        "formula 28": _velocity_variance_as_printed() - A_STATIC.velocity_noise[0] ** 2,
        "formula 33": _deg(_sigmas_as_printed()[0] - _sigmas()[0]),
        "formula 34": _deg(_sigmas_as_printed()[1] - _sigmas()[1]),
        "offset needed": 1e3 * LENGTH * np.tan(AIM) / SPEED,
    }


def enu_rotation_as_printed(lat, lon):
    """Return S (3, 3) of equation (4): the second entry of its first row, cos phi, should be cos lambda.

    >>> S = enu_rotation_as_printed(LATITUDE, LONGITUDE)
    >>> round(float(S[0] @ S[0]), 2)
    1.7
    """
    S = enu_rotation_at(lat, lon).copy()
    S[0, 1] = np.cos(lat)
    return S


def _heading_with_printed_axes(heading):
    baseline_ecef = enu_rotation_at(LATITUDE, LONGITUDE).T @ _baseline(np.degrees(heading))
    return heading_pitch_of(enu_rotation_as_printed(LATITUDE, LONGITUDE) @ baseline_ecef)[0]


def _baseline(heading_deg, pitch_deg=0.0):
    """Return a baseline (3,) [m], east, north, up."""
    psi, theta = np.radians([heading_deg, pitch_deg])
    return LENGTH * np.array([np.cos(theta) * np.sin(psi), np.cos(theta) * np.cos(psi), np.sin(theta)])


def _sigma_along(length_sigma):
    """Return the sigma [m] along a baseline known to PRIOR on each axis, once its length is known to `length_sigma` [m]."""
    b = _baseline(0)
    return np.sqrt(with_known_length(b, PRIOR**2 * np.eye(3), LENGTH, length_sigma)[1][1, 1])


def _asymmetry_as_printed():
    """Return how far F P, which (25) prints for F P F', is from a symmetric matrix, for a small example."""
    F, P = np.array([[1.0, 1.0], [0.0, 1.0]]), np.array([[1.0, 0.3], [0.3, 2.0]])
    return np.max(np.abs(F @ P - (F @ P).T))


def _velocity_variance_as_printed():
    """Return what (28) prints for a unit vector along the baseline: a quadratic form of standard deviations, a single number."""
    along = _baseline(35) / LENGTH
    return along @ np.diag(A_STATIC.velocity_noise) @ along


def _sigmas():
    return angle_sigmas(_baseline(50, 25), np.diag(SIGMA_ENU**2))


def _sigmas_as_printed():
    at = (np.radians(50), np.radians(25), LENGTH, SIGMA_ENU)
    return sigma_heading_as_printed(*at), sigma_pitch_as_printed(*at)


def _deg(angle):
    """Return an angle [rad] in degrees, from -180 to 180."""
    return float(np.degrees(within_half_turn(angle)))
