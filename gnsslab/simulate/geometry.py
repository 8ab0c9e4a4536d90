"""Geometry of a preset: distances, clocks and delays of every receiver to every satellite, before any noise.

What is slow, the satellites, depends on site, span and systems only and is kept: a slider that changes noise, clocks, or
the length of a baseline finds it ready.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from gnsslab.core.rotations import rotation_from_heading_pitch_roll
from gnsslab.gnss.delays import klobuchar, saastamoinen
from gnsslab.gnss.ephemerides import ARRAY_FIELDS, Ephemerides
from gnsslab.gnss.frames import azimuth_elevation, ecef_from_geodetic, enu_rotation, geodetic_from_ecef
from gnsslab.gnss.orbits import EARTH_RATE_WGS84, GRAVITATION, rotate_to_reception, satellite_states, select_ephemerides
from gnsslab.gnss.signals import SPEED_OF_LIGHT, frequency
from gnsslab.gnss.times import seconds_between
from gnsslab.simulate.events import hidden_by_streets
from gnsslab.simulate.presets import Preset
from gnsslab.simulate.sky import broadcast_ephemerides
from gnsslab.simulate.trajectories import velocity

TYPICAL_TRAVEL = 0.075  # [s], from 20 000 to 36 000 km it is 0.065 to 0.14
_SEARCH_EVERY = 300.0  # [s]; elevations change by less than _SEARCH_MARGIN in half of it
_SEARCH_MARGIN = np.radians(3.0)
_CACHED_SKIES = 8
_EARTH_SPIN = np.array([0.0, 0.0, EARTH_RATE_WGS84])  # [rad/s]


@dataclass(frozen=True, eq=False)
class Tracks:
    """Motion of m satellites over T epochs, each epoch expanded about tag - TYPICAL_TRAVEL (second order: 1 um off after 70 ms, 0.1 mm after 1 s)."""

    satellites: tuple[str, ...]  # (m,)
    ephemerides: Ephemerides
    index: np.ndarray  # (T, m) rows of the ephemerides
    position: np.ndarray  # (T, m, 3) ECEF [m]
    velocity: np.ndarray  # (T, m, 3) [m/s]
    acceleration: np.ndarray  # (T, m, 3) [m/s^2]
    clock: np.ndarray  # (T, m) [s]
    clock_drift: np.ndarray  # (T, m) [s/s]


@dataclass(frozen=True, eq=False)
class Geometry:
    """What R receivers would measure of m satellites over T epochs but for noise, signals and events."""

    preset: Preset
    tracks: Tracks
    pseudorange: np.ndarray  # (R, T, m) [m], distance and clocks: c (t_r - clock reading of the satellite at transmission)
    rate: np.ndarray  # (R, T, m) [m/s], its derivative by receiver time
    elevation: np.ndarray  # (R, T, m) [rad]
    ionosphere: np.ndarray  # (R, T, m) [m], delay of a code on L1
    troposphere: np.ndarray  # (R, T, m) [m]
    hidden: np.ndarray  # (R, T, m) bool, behind the houses of a street


def prepare_geometry(preset):
    """Return the `Geometry` of a preset."""
    tracks = satellite_tracks(preset.start, preset.epochs, preset.interval, preset.systems, preset.satellites, preset.site, preset.mask_deg)
    if not tracks.satellites:
        raise ValueError(f"preset {preset.name!r}: no satellite rises above {preset.mask_deg} degrees; lower the mask or add systems")
    parts = [_one_receiver(preset, tracks, receiver) for receiver in range(preset.receivers)]
    return Geometry(preset, tracks, *(np.stack(part) for part in zip(*parts, strict=True)))


@lru_cache(maxsize=_CACHED_SKIES)
def satellite_tracks(start, epochs, interval, systems, satellites, site, mask_deg):
    """Return the `Tracks` of the satellites that rise above the mask at the site within the span; `satellites` (if any) narrows the choice."""
    time = np.datetime64(start, "ns") + np.round(np.arange(epochs) * interval * 1e9).astype("timedelta64[ns]")
    ephemerides = broadcast_ephemerides(time[0], time[-1], systems)
    wanted = [name for name in ephemerides.satellites if not satellites or name in satellites]
    every = max(1, round(_SEARCH_EVERY / interval))
    elevation = _elevations_from_afar(_tracks(ephemerides, wanted, np.append(time[::every], time[-1])), site)
    rises = elevation.max(axis=0) > np.radians(mask_deg) - _SEARCH_MARGIN
    return _locked(_tracks(ephemerides, [name for name, is_up in zip(wanted, rises, strict=True) if is_up], time))


def instants(preset, receiver):
    """Return the GPS times (T,), seconds after the start, at which a receiver really measures: its tags less its clock's error.

    >>> from dataclasses import replace
    >>> from gnsslab.simulate import Clock, find_preset
    >>> instants(replace(find_preset("ship-heading"), clocks=(Clock(), Clock(offset=0.5))), 1)[:2].tolist()
    [-0.5, 0.5]
    """
    tags = np.arange(preset.epochs) * preset.interval
    return tags - preset.clocks[receiver].error(tags)


def body_in_ecef(preset, seconds):
    """Return ECEF positions (T, 3) [m] of the body's origin and the rotations R_eb (T, 3, 3) from its axes to ECEF."""
    pose = preset.trajectory.at(seconds)
    site = _site(preset)
    position = site + pose.position_enu @ enu_rotation(site)
    R_nb = rotation_from_heading_pitch_roll(pose.heading, pose.pitch, pose.roll)
    return position, np.swapaxes(enu_rotation(position), -1, -2) @ R_nb


def antenna_position(preset, receiver, seconds):
    """Return ECEF positions (T, 3) [m] of a receiver's antenna at seconds (T,) of GPS time after the start."""
    if preset.base is not None and receiver == 0:
        site = _site(preset)
        return np.broadcast_to(site + np.array(preset.base) @ enu_rotation(site), (len(seconds), 3))
    position, R_eb = body_in_ecef(preset, seconds)
    return position + R_eb @ np.array(preset.antennas[receiver - (preset.base is not None)])


def _site(preset):
    latitude, longitude, height = preset.site
    return ecef_from_geodetic([np.radians(latitude), np.radians(longitude), height])


def _locked(tracks):
    """Return the same tracks, their arrays made read-only: they are kept, and lent to every simulation of this sky."""
    for name in ARRAY_FIELDS:
        getattr(tracks.ephemerides, name).flags.writeable = False
    for name in ("index", "position", "velocity", "acceleration", "clock", "clock_drift"):
        getattr(tracks, name).flags.writeable = False
    return tracks


def _elevations_from_afar(tracks, site):
    latitude, longitude, height = site
    place = ecef_from_geodetic([np.radians(latitude), np.radians(longitude), height])
    return azimuth_elevation((tracks.position - place) @ enu_rotation(place).T)[1]


def _tracks(ephemerides, satellites, time):
    index = select_ephemerides(ephemerides, satellites, time)
    transit = TYPICAL_TRAVEL - _clock_polynomial(ephemerides, index, time)  # makes tag - TYPICAL_TRAVEL the time of transmission
    states = satellite_states(ephemerides, satellites, time, transit)
    mu = np.array([GRAVITATION[name[0]] for name in satellites])[:, np.newaxis]
    acceleration = _acceleration(states.position, states.velocity, mu)
    return Tracks(tuple(satellites), ephemerides, index, states.position, states.velocity, acceleration, states.clock, states.clock_drift)


def _clock_polynomial(ephemerides, index, time):
    """Return the satellite clocks' polynomials (T, m) [s] at tag - TYPICAL_TRAVEL."""
    age = seconds_between(time[:, np.newaxis], ephemerides.toc[index]) - TYPICAL_TRAVEL
    return ephemerides.af0[index] + ephemerides.af1[index] * age + ephemerides.af2[index] * age**2


def _acceleration(position, velocity_ecef, mu):
    """Return accelerations (T, m, 3) in ECEF: attraction of a sphere, Coriolis and centrifugal: -mu r / |r|^3 - 2 w x v - w x (w x r).

    Oblateness and harmonic terms, left out, are 1e-4 m/s^2: 0.3 um over 70 ms.
    """
    distance = np.linalg.norm(position, axis=-1, keepdims=True)
    whirl = np.cross(_EARTH_SPIN, np.cross(_EARTH_SPIN, position) + 2 * velocity_ecef)
    return -mu * position / distance**3 - whirl


def _one_receiver(preset, tracks, receiver):
    """Return pseudorange, rate, elevation, ionosphere, troposphere and what is hidden (T, m) of one receiver."""
    seconds = np.arange(preset.epochs) * preset.interval
    clock, true_seconds = preset.clocks[receiver], instants(preset, receiver)
    place = antenna_position(preset, receiver, true_seconds)
    speed = velocity(lambda t: antenna_position(preset, receiver, t), true_seconds)
    travel, u, satellite, satellite_velocity = _light_path(tracks, place, clock.error(seconds))
    sent_after = TYPICAL_TRAVEL - clock.error(seconds)[:, np.newaxis] - travel
    satellite_clock = tracks.clock + tracks.clock_drift * sent_after
    pseudorange = SPEED_OF_LIGHT * (travel + clock.error(seconds)[:, np.newaxis] - satellite_clock)
    rate = _pseudorange_rate(u, satellite, satellite_velocity, speed, clock.drift, tracks.clock_drift)
    azimuth, elevation = azimuth_elevation(np.matvec(enu_rotation(place)[:, np.newaxis], u))
    hidden = hidden_by_streets(preset.events, receiver, preset.trajectory.at(true_seconds).heading, azimuth, elevation)
    return pseudorange, rate, elevation, *_delays(preset, place, azimuth, elevation), hidden


def _light_path(tracks, place, clock_error):
    """Return travel time (T, m) [s], unit vectors u (T, m, 3) and satellite position and velocity, ECEF of the time of reception.

    c tau = |R_z(w tau) r_s(t - tau) - r_r(t)|, solved for tau: each round is 4e-6 times nearer, three leave nothing.
    """
    travel = np.full(tracks.clock.shape, TYPICAL_TRAVEL)
    for _ in range(3):
        after = (TYPICAL_TRAVEL - clock_error[:, np.newaxis] - travel)[..., np.newaxis]
        position = tracks.position + after * (tracks.velocity + after / 2 * tracks.acceleration)
        satellite = rotate_to_reception(position, travel)
        towards = satellite - place[:, np.newaxis]
        distance = np.sqrt(np.vecdot(towards, towards))
        travel = distance / SPEED_OF_LIGHT
    satellite_velocity = rotate_to_reception(tracks.velocity + after * tracks.acceleration, travel)
    return travel, towards / distance[..., np.newaxis], satellite, satellite_velocity


def _pseudorange_rate(u, satellite, satellite_velocity, speed, drift, satellite_drift):
    """Return dP/dt_r (T, m) [m/s] exactly: with dt = (1 - drift) dt_r the time of transmission moves by (1 - drift)(1 - tau').

    From c tau = |R r_s(t - tau) - r_r(t)|:  tau' = u (R v_s - v_r) / (c + u (R v_s - R' r_s)), R' = dR/dtau.
    """
    x, y = satellite[..., 0], satellite[..., 1]
    sideways = EARTH_RATE_WGS84 * (u[..., 0] * y - u[..., 1] * x)  # u R' r_s
    closing = np.vecdot(u, satellite_velocity)
    travel_rate = (closing - np.vecdot(u, speed[:, np.newaxis])) / (SPEED_OF_LIGHT + closing - sideways)
    # c [1 - (1 + satellite_drift)(1 - drift)(1 - travel_rate)], the ones taken out so that no digits are lost
    slow = drift + travel_rate - drift * travel_rate
    return SPEED_OF_LIGHT * (slow - satellite_drift * (1 - slow))


def _delays(preset, place, azimuth, elevation):
    """Return ionosphere on L1 and troposphere (T, m) [m] as the preset has them."""
    latitude, longitude, height = geodetic_from_ecef(place).T[..., np.newaxis]
    none = np.zeros_like(elevation)
    ionosphere, troposphere = none, none
    if preset.ionosphere is not None:
        coefficients = np.array(preset.ionosphere)
        ionosphere = klobuchar(coefficients, preset.time[:, np.newaxis], latitude, longitude, azimuth, elevation, frequency("G", "1"))
    if preset.humidity is not None:
        troposphere = saastamoinen(latitude, height, elevation, preset.humidity)
    return ionosphere, troposphere
