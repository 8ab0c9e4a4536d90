"""Modelling: a Pair of receivers made ready for the filter, by orbits, clocks, troposphere, weights and screening."""

from dataclasses import dataclass

import numpy as np

from gnsslab.gnss.delays import saastamoinen
from gnsslab.gnss.differences import Pair
from gnsslab.gnss.frames import azimuth_elevation, enu_rotation, geodetic_from_ecef
from gnsslab.gnss.orbits import rotate_to_reception, satellite_states
from gnsslab.gnss.screening import cycle_slips, has_half_cycle, is_shadowed
from gnsslab.gnss.signals import SPEED_OF_LIGHT
from gnsslab.gnss.weighting import sigma_code, sigma_phase


@dataclass(frozen=True, eq=False)
class Model:
    """T common epochs and c channels of a Pair: what is left to find is the baseline, clocks and ambiguities."""

    pair: Pair
    near: np.ndarray  # (T, 3) [m], approximate baseline, ECEF
    anchors: np.ndarray  # (T, c, 3) [m], satellites at transmission, ECEF of the rover's reception, origin at the master
    code: np.ndarray  # (T, c) [m], the rover's range and receiver clocks: single difference plus the master's range
    phase: np.ndarray  # (T, c) [m], the same from the carrier, plus wavelength times ambiguity
    sigma_code: np.ndarray  # (T, c) [m], of the single difference
    sigma_phase: np.ndarray  # (T, c) [m]
    elevation: np.ndarray  # (T, c) [rad]
    usable: np.ndarray  # (T, c) bool: measured, healthy, above the mask, no half cycle in doubt, no shadow
    slip: np.ndarray  # (T, c) bool: the ambiguity starts anew


def build_model(pair, master_ecef, rover_ecef, ephemerides, mask, noise):
    """Return the Model of a Pair with the receivers' positions (T, 3) [m] at its epochs, an elevation mask [rad] and a NoiseModel.

    The master's position is taken as known, the rover's need only be good to some metres. Each receiver's signals are
    traced to their own transmission times, so receiver clocks apart by milliseconds do no harm.
    """
    at_master = _trace(pair, pair.master, pair.time_master, master_ecef, ephemerides)
    at_rover = _trace(pair, pair.rover, pair.time, rover_ecef, ephemerides)
    known = (at_rover.correction - at_master.correction + at_master.range)[:, pair.satellite]
    elevation = at_master.elevation[:, pair.satellite]
    usable = _usable(pair, known, elevation, mask)
    return Model(
        pair=pair,
        near=rover_ecef - master_ecef,
        anchors=(at_rover.position - master_ecef[:, None])[:, pair.satellite],
        code=pair.rover.code - pair.master.code + known,
        phase=(pair.rover.phase - pair.master.phase) * pair.wavelength + known,
        sigma_code=_single_difference_sigma(sigma_code, noise, pair, elevation),
        sigma_phase=_single_difference_sigma(sigma_phase, noise, pair, elevation),
        elevation=elevation,
        usable=usable,
        slip=cycle_slips(pair, usable),
    )


@dataclass(frozen=True, eq=False)
class _Traced:
    """Signals of m satellites followed from transmission to one receiver."""

    position: np.ndarray  # (T, m, 3) [m] at transmission, ECEF of reception
    range: np.ndarray  # (T, m) [m]
    correction: np.ndarray  # (T, m) [m], to add to a measurement: satellite clock minus troposphere
    elevation: np.ndarray  # (T, m) [rad]


def _trace(pair, tracks, time, receiver_ecef, ephemerides):
    states = satellite_states(ephemerides, pair.satellites, time, _satellite_codes(pair, tracks) / SPEED_OF_LIGHT)
    travel_time = np.linalg.norm(states.position - receiver_ecef[:, None], axis=-1) / SPEED_OF_LIGHT
    position = rotate_to_reception(states.position, travel_time)
    sight = position - receiver_ecef[:, None]
    rho = np.linalg.norm(sight, axis=-1)
    R_ne = enu_rotation(receiver_ecef)
    _, elevation = azimuth_elevation(np.einsum("tij,tmj->tmi", R_ne, sight / rho[..., None]))
    lat, _, height = np.moveaxis(geodetic_from_ecef(receiver_ecef), -1, 0)
    troposphere = saastamoinen(lat[:, None], height[:, None], elevation)
    return _Traced(position, rho, SPEED_OF_LIGHT * states.clock - troposphere, elevation)


def _satellite_codes(pair, tracks):
    """Return one code (T, m) [m] of each satellite, of its first band that was measured: it tells the time of transmission."""
    codes = np.full((len(pair.time), len(pair.satellites)), np.nan)
    for channel in np.argsort(-pair.band, kind="stable"):
        code = tracks.code[:, channel]
        codes[:, pair.satellite[channel]] = np.where(np.isfinite(code), code, codes[:, pair.satellite[channel]])
    return codes


def _usable(pair, known, elevation, mask):
    measured = np.isfinite(pair.rover.code + pair.master.code + pair.rover.phase + pair.master.phase + known)
    return measured & (elevation >= mask) & ~has_half_cycle(pair) & ~is_shadowed(pair)


def _single_difference_sigma(sigma, noise, pair, elevation):
    """Return the standard deviation (T, c) [m] of rover minus master, NaN below the horizon."""
    elevation = np.where(elevation > 0, elevation, np.nan)
    return np.hypot(*(sigma(noise, elevation, tracks.cn0, pair.wavelength) for tracks in (pair.master, pair.rover)))
