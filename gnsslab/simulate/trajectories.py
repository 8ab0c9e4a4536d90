"""Motions of a body: where its origin is and how it is turned, as smooth functions of time.

Every trajectory is a frozen record with one method, `at(seconds)`, in closed form: it can be asked for any instant, as
receivers with clocks of their own measure at instants of their own. East, north and up count from the site, on its
tangent plane; heading, pitch and roll are those against the local level where the body is (see core.rotations).
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

GRAVITY = 9.80665  # [m/s^2], for the bank of a coordinated turn
_STEP = 1e-3  # [s], for derivatives by central differences: error = jerk * 2e-7 s^2


class Pose(NamedTuple):
    """Places and attitudes of a body at T instants."""

    position_enu: np.ndarray  # (T, 3) [m] of the body's origin, from the site
    heading: np.ndarray  # (T,) [rad], growing through 2 pi where the body turns on
    pitch: np.ndarray  # (T,) [rad]
    roll: np.ndarray  # (T,) [rad]


@dataclass(frozen=True)
class Static:
    """A body at rest.

    >>> Static(heading_deg=90.0).at(np.zeros(1)).heading.round(4)
    array([1.5708])
    """

    heading_deg: float = 0.0
    pitch_deg: float = 0.0
    roll_deg: float = 0.0
    place_enu: tuple[float, float, float] = (0.0, 0.0, 0.0)  # [m]

    def at(self, seconds):
        """Return the `Pose` at seconds (T,) since the start."""
        still = np.zeros_like(seconds, dtype=float)
        angles = (still + np.radians(angle) for angle in (self.heading_deg, self.pitch_deg, self.roll_deg))
        return Pose(still[:, np.newaxis] + np.array(self.place_enu), *angles)


@dataclass(frozen=True)
class Turntable:
    """A body that stands still, then turns about its origin at a steady rate, which it takes up within `ramp` seconds.

    >>> Turntable(still=50.0, rate_deg_s=6.0, ramp=2.0).at(np.array([50.0, 61.0])).heading.round(4)
    array([0.    , 1.0472])
    """

    still: float = 50.0  # [s] before it starts
    rate_deg_s: float = 6.0
    ramp: float = 2.0  # [s]
    heading_deg: float = 0.0
    pitch_deg: float = 0.0

    def at(self, seconds):
        """Return the `Pose` at seconds (T,) since the start."""
        since = np.clip(np.asarray(seconds, dtype=float) - self.still, 0, None)
        x = np.clip(since / self.ramp, 0, 1)
        turning = self.ramp * (x**3 - x**4 / 2) + np.clip(since - self.ramp, 0, None)  # integral of the ramp 3x^2 - 2x^3, then of 1
        level = np.zeros_like(since)
        heading = np.radians(self.heading_deg) + np.radians(self.rate_deg_s) * turning
        return Pose(np.stack([level, level, level], axis=-1), heading, level + np.radians(self.pitch_deg), level)


@dataclass(frozen=True)
class Car:
    """A car on a road shaped like an eight over two hills: e = A sin a, n = B sin 2a, u = h cos 3a with a = rate t.

    It faces along its way, up and down the slopes, and leans outwards a little in the turns (0.3 deg for each m/s^2).
    The speed is `speed` where the road crosses itself and varies around it.
    """

    centre_enu: tuple[float, float, float] = (1000.0, 0.0, 0.0)  # [m] from the site
    size: float = 150.0  # A [m]; B = A / 2
    height: float = 2.0  # h [m]
    speed: float = 12.0  # [m/s] in the crossing

    def at(self, seconds):
        """Return the `Pose` at seconds (T,) since the start."""
        rate = self.speed / np.hypot(self.size, self.size)
        a = rate * np.asarray(seconds, dtype=float)
        A, B, h = self.size, self.size / 2, self.height
        position = np.stack([A * np.sin(a), B * np.sin(2 * a), h * np.cos(3 * a)], axis=-1)
        v = rate * np.stack([A * np.cos(a), 2 * B * np.cos(2 * a), -3 * h * np.sin(3 * a)], axis=-1)
        acceleration = -(rate**2) * np.stack([A * np.sin(a), 4 * B * np.sin(2 * a)], axis=-1)
        along = np.hypot(v[:, 0], v[:, 1])
        to_the_right = (acceleration[:, 0] * v[:, 1] - acceleration[:, 1] * v[:, 0]) / along
        heading = np.unwrap(np.arctan2(v[:, 0], v[:, 1]))
        return Pose(position + np.array(self.centre_enu), heading, np.arctan2(v[:, 2], along), -np.radians(0.3) * to_the_right)


@dataclass(frozen=True)
class Ship:
    """A ship in a slow turn, rolling, pitching and heaving in the waves, each at a period of its own."""

    speed: float = 6.0  # [m/s]
    turn_deg_s: float = 0.5
    heading_deg: float = 20.0
    roll_deg: float = 6.0  # amplitude
    roll_period: float = 9.0  # [s]
    pitch_deg: float = 2.0
    pitch_period: float = 6.5
    heave: float = 0.5  # [m]
    heave_period: float = 7.7

    def at(self, seconds):
        """Return the `Pose` at seconds (T,) since the start."""
        t = np.asarray(seconds, dtype=float)
        half_turn = np.radians(self.turn_deg_s) * t / 2
        chord = self.speed * t * np.sinc(half_turn / np.pi)  # of the arc sailed, also where the turn is zero
        direction = np.radians(self.heading_deg) + half_turn
        up = self.heave * _wave(t, self.heave_period)
        position = np.stack([chord * np.sin(direction), chord * np.cos(direction), up], axis=-1)
        roll = np.radians(self.roll_deg) * _wave(t, self.roll_period)
        pitch = np.radians(self.pitch_deg) * _wave(t, self.pitch_period)
        return Pose(position, direction + half_turn, pitch, roll)


@dataclass(frozen=True)
class Hop:
    """A drone that climbs, flies one turn to the right on a circle, banked, and comes down again.

    It leans as thrust must point: forward to gain speed (pitch = -atan(a / g)), into the turn (roll = atan(v^2 / (radius g))).
    The phases pass into one another with four continuous derivatives.
    """

    ground: float = 20.0  # [s] on the ground before and after
    climb: float = 20.0  # [s] up, and as long down
    turn: float = 60.0  # [s] on the circle
    height: float = 40.0  # [m]
    radius: float = 60.0  # [m]
    heading_deg: float = 0.0

    @property
    def duration(self):
        """Seconds from the start to standing on the ground again."""
        return 2 * self.ground + 2 * self.climb + self.turn

    def at(self, seconds):
        """Return the `Pose` at seconds (T,) since the start."""
        t = np.asarray(seconds, dtype=float)
        begin = self.ground + self.climb
        rise, _, _ = _smooth_step(t - self.ground, self.climb)
        fall, _, _ = _smooth_step(t - begin - self.turn, self.climb)
        angle, rate, gain = (2 * np.pi * step for step in _smooth_step(t - begin, self.turn))
        heading = np.radians(self.heading_deg) + angle
        right = np.stack([np.cos(heading), -np.sin(heading)], axis=-1)  # the circle's centre lies a radius to the right
        centre = self.radius * np.array([np.cos(np.radians(self.heading_deg)), -np.sin(np.radians(self.heading_deg))])
        level = centre - self.radius * right
        roll = np.arctan2(self.radius * rate**2, GRAVITY)
        pitch = -np.arctan2(self.radius * gain, GRAVITY)
        return Pose(np.column_stack([level, self.height * (rise - fall)]), heading, pitch, roll)


def velocity(position_at, seconds):
    """Return velocities (T, 3) of a function from seconds (T,) to positions (T, 3), by central differences over 1 ms either side.

    >>> velocity(lambda t: np.stack([t**2, t, 0 * t], axis=-1), np.array([3.0])).round(6)
    array([[6., 1., 0.]])
    """
    return (position_at(seconds + _STEP) - position_at(seconds - _STEP)) / (2 * _STEP)


def _wave(t, period):
    return np.sin(2 * np.pi * t / period)


def _smooth_step(t, duration):
    """Return a step from 0 to 1 within duration, its first and second derivatives: s = x^5 (126 - 420 x + 540 x^2 - 315 x^3 + 70 x^4)."""
    x = np.clip(t / duration, 0, 1)
    step = x**5 * (126 - 420 * x + 540 * x**2 - 315 * x**3 + 70 * x**4)
    first = 630 * x**4 * (1 - x) ** 4
    second = 2520 * x**3 * (1 - x) ** 3 * (1 - 2 * x)
    return step, first / duration, second / duration**2
