"""Attitude as three angles, as a matrix, and as the direction of one vector.

Axes: navigation frame n = East-North-Up, body frame b = Right-Forward-Up. Heading psi clockwise from north in
[0, 2 pi), pitch theta nose up, roll phi right side down; all in radians. The columns of R_nb are the body's right,
forward and up axes written in ENU, so `v_n = R_nb @ v_b`.
"""

from typing import NamedTuple

import numpy as np

_GIMBAL = 1e-9  # cos(pitch) below this: 0.0002 arc seconds from the vertical, heading and roll turn about one axis


class Angles(NamedTuple):
    """Heading psi in [0, 2 pi), pitch theta in [-pi/2, pi/2] and roll phi in (-pi, pi], each (...) [rad]."""

    heading: np.ndarray
    pitch: np.ndarray
    roll: np.ndarray


class Direction(NamedTuple):
    """Heading psi in [0, 2 pi) and pitch theta in [-pi/2, pi/2] of a vector, each (...) [rad]."""

    heading: np.ndarray
    pitch: np.ndarray


def rotation_from_heading_pitch_roll(heading, pitch=0.0, roll=0.0):
    """Build the matrix that takes body (RFU) vectors into the navigation frame (ENU).

    R_nb = [R_y(phi) R_x(theta) R_z(-psi)]', the elementary matrices passive (they turn the axes).

    heading, pitch, roll: (...) [rad], broadcast together. Returns (..., 3, 3).

    >>> R_nb = rotation_from_heading_pitch_roll(np.pi / 2)      # heading east:
    >>> (R_nb @ [0, 1, 0]).round(12)                            # forward points east
    array([1., 0., 0.])
    """
    psi, theta, phi = np.broadcast_arrays(heading, pitch, roll)
    s_psi, c_psi, s_theta, c_theta, s_phi, c_phi = (f(x) for x in (psi, theta, phi) for f in (np.sin, np.cos))
    right = [c_phi * c_psi + s_phi * s_theta * s_psi, s_phi * s_theta * c_psi - c_phi * s_psi, -s_phi * c_theta]
    forward = [c_theta * s_psi, c_theta * c_psi, s_theta]
    up = [s_phi * c_psi - c_phi * s_theta * s_psi, -s_phi * s_psi - c_phi * s_theta * c_psi, c_phi * c_theta]
    axes = [np.stack(axis, axis=-1) for axis in (right, forward, up)]
    return np.stack(axes, axis=-1)  # (..., 3, 3), one column an axis


def heading_pitch_roll(R_nb):
    """Read heading, pitch and roll from R_nb; the inverse of `rotation_from_heading_pitch_roll`.

    psi = atan2(R_12, R_22), theta = atan2(R_32, hypot(R_12, R_22)), phi = atan2(-R_31, R_33).

    R_nb: (..., 3, 3). Nose straight up or down, heading and roll are one turn: it is all called heading, roll is 0.

    >>> heading, pitch, roll = heading_pitch_roll([[0, 1, 0], [-1, 0, 0], [0, 0, 1]])   # forward is east, right south
    >>> float(heading), float(pitch), abs(float(roll))
    (1.5707963267948966, 0.0, 0.0)
    """
    R_nb = _with_last_axes(R_nb, (3, 3), "R_nb")
    right, forward, up = (R_nb[..., :, k] for k in range(3))
    level = np.hypot(forward[..., 0], forward[..., 1])
    vertical = level < _GIMBAL
    heading = np.where(vertical, np.arctan2(-right[..., 1], right[..., 0]), np.arctan2(forward[..., 0], forward[..., 1]))
    roll = np.where(vertical, 0.0, np.arctan2(-right[..., 2], up[..., 2]))
    return Angles(_to_circle(heading), np.arctan2(forward[..., 2], level), roll)


def heading_pitch_of(vector_enu):
    """Read the heading and pitch of a vector, such as the baseline between two antennas.

    psi = atan2(e, n), theta = atan2(u, hypot(e, n)).

    vector_enu: (..., 3), any unit of length. A vertical vector has heading 0; one of length zero has neither: NaN.

    >>> heading, pitch = heading_pitch_of([1.0, 1.0, 0.0])
    >>> float(heading), float(pitch)
    (0.7853981633974483, 0.0)
    """
    vector_enu = _with_last_axes(vector_enu, (3,), "vector_enu")
    e, n, u = (vector_enu[..., k] for k in range(3))
    unknown = np.where(np.any(vector_enu != 0.0, axis=-1), 0.0, np.nan)
    return Direction(_to_circle(np.arctan2(e, n)) + unknown, np.arctan2(u, np.hypot(e, n)) + unknown)


def within_half_turn(angle):
    """Return angles (...) [rad] less whole turns, in [-pi, pi): how far one heading is from another.

    >>> within_half_turn(np.array([3.5, -0.5])).round(4).tolist()
    [-2.7832, -0.5]
    """
    return (angle + np.pi) % (2 * np.pi) - np.pi


def _to_circle(angle):
    """Bring angles (...) [rad] into [0, 2 pi); a tiny negative angle would otherwise round up to 2 pi itself."""
    turned = np.mod(angle, 2 * np.pi)
    return np.where(turned >= 2 * np.pi, 0.0, turned)


def _with_last_axes(values, shape, name):
    values = np.asarray(values, dtype=float)
    if values.shape[-len(shape) :] != shape:
        wanted = ", ".join(str(size) for size in shape)
        raise ValueError(f"{name} must have shape (..., {wanted}); it has shape {values.shape}.")
    return values
