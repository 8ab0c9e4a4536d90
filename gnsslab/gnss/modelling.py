"""Modelling: a Pair of receivers made ready for the filter, by orbits, clocks, troposphere, weights and screening.

The ionosphere is left in: over the few kilometres that these methods are for it cancels to millimetres, and the broadcast
model's difference between two ends is no better than nothing (`relative.ATMOSPHERE` accounts for what is left).
"""

from dataclasses import dataclass

import numpy as np

from gnsslab.gnss.delays import saastamoinen
from gnsslab.gnss.differences import Pair
from gnsslab.gnss.frames import azimuth_elevation, enu_rotation_at, geodetic_from_ecef
from gnsslab.gnss.orbits import rotate_to_reception, satellite_states, select_ephemerides
from gnsslab.gnss.screening import ages, cycle_slips, has_half_cycle, is_shadowed, row_medians
from gnsslab.gnss.signals import SPEED_OF_LIGHT
from gnsslab.gnss.times import usual_step
from gnsslab.gnss.weighting import information_step, sigma_code, sigma_phase

_GROSS_CODE = 10_000.0  # [m]: far beyond biases between systems and any multipath; what is less the filter sets aside itself
_HEIGHT_STEP = 10.0  # [m], over which the troposphere's slope is taken


@dataclass(frozen=True, eq=False)
class Model:
    """T common epochs and c channels of a Pair: what is left to find is the baseline, clocks and ambiguities."""

    pair: Pair
    near: np.ndarray  # (T, 3) [m], approximate baseline, ECEF
    design: np.ndarray  # (T, c, 3), change of a channel's single difference with the baseline: - u, and the troposphere's slope
    code: np.ndarray  # (T, c) [m], single difference, measured minus modelled at `near`
    phase: np.ndarray  # (T, c) [m], the same of the carrier; wavelength times ambiguity is left in it
    sigma_code: np.ndarray  # (T, c) [m], of the single difference
    sigma_phase: np.ndarray  # (T, c) [m]
    novelty: np.ndarray  # (T, c) 0 to 1, share of a measurement's information that earlier ones have not given yet
    usable: np.ndarray  # (T, c) bool: measured, healthy, above the mask, no half cycle in doubt, no shadow
    slip: np.ndarray  # (T, c) bool: the ambiguity starts anew


def build_model(pair, master_ecef, rover_ecef, ephemerides, mask, noise, forgets):
    """Return the Model of a Pair with the receivers' positions (T, 3) [m] at its epochs, an elevation mask [rad] and a NoiseModel.

    `forgets` (T,) bool are epochs at which all ambiguities start anew. The master's position is taken as known, the rover's need
    only be good to some metres. Each receiver's signals are traced to their own transmission times, so receiver clocks
    apart by milliseconds do no harm.
    """
    index = select_ephemerides(ephemerides, pair.satellites, pair.time)  # one choice for both ends: another data set is metres off in its clock
    at_master = _trace(pair, pair.master, pair.time_master, master_ecef, ephemerides, index)
    at_rover = _trace(pair, pair.rover, pair.time, rover_ecef, ephemerides, index)
    modelled = (at_rover.modelled - at_master.modelled)[:, pair.satellite]
    elevation = at_master.elevation[:, pair.satellite]
    code = pair.rover.code - pair.master.code - modelled
    usable = _usable(pair, modelled, elevation, mask) & ~_has_gross_code(pair, code)
    sigma = _single_difference_sigma(sigma_phase, noise, pair, elevation)
    slip = usable & (cycle_slips(pair, usable, sigma) | forgets[:, None])
    return Model(
        pair=pair,
        near=rover_ecef - master_ecef,
        design=at_rover.design[:, pair.satellite],
        code=code,
        phase=(pair.rover.phase - pair.master.phase) * pair.wavelength - modelled,
        sigma_code=_single_difference_sigma(sigma_code, noise, pair, elevation),
        sigma_phase=sigma,
        novelty=_novelty(pair, ages(usable, slip), noise),
        usable=usable,
        slip=slip,
    )


@dataclass(frozen=True, eq=False)
class _Traced:
    """Signals of m satellites followed from transmission to one receiver."""

    modelled: np.ndarray  # (T, m) [m], range plus troposphere minus satellite clock
    design: np.ndarray  # (T, m, 3), change of `modelled` with the receiver's position
    elevation: np.ndarray  # (T, m) [rad]


def _trace(pair, tracks, time, receiver_ecef, ephemerides, index):
    states = satellite_states(ephemerides, pair.satellites, time, _satellite_codes(pair, tracks) / SPEED_OF_LIGHT, index)
    travel_time = np.linalg.norm(states.position - receiver_ecef[:, None], axis=-1) / SPEED_OF_LIGHT
    sight = rotate_to_reception(states.position, travel_time) - receiver_ecef[:, None]
    rho = np.linalg.norm(sight, axis=-1)
    u = sight / rho[..., None]
    lat, lon, height = np.moveaxis(geodetic_from_ecef(receiver_ecef), -1, 0)
    R_ne = enu_rotation_at(lat, lon)
    _, elevation = azimuth_elevation(np.einsum("tij,tmj->tmi", R_ne, u))
    troposphere, slope = _troposphere(lat[:, None], height[:, None], elevation)
    return _Traced(
        modelled=rho + troposphere - SPEED_OF_LIGHT * states.clock,
        design=slope[..., None] * R_ne[:, None, 2] - u,
        elevation=elevation,
    )


def _troposphere(lat, height, elevation):
    """Return the delay (T, m) [m] and its change with height [m/m]: metres of error in the rover's height would else cost millimetres."""
    zenith_below, zenith, zenith_above = (saastamoinen(lat, height + step, np.pi / 2) for step in (-_HEIGHT_STEP, 0.0, _HEIGHT_STEP))
    obliquity = np.where(elevation > 0, 1 / np.sin(np.where(elevation > 0, elevation, np.nan)), np.nan)
    return zenith * obliquity, (zenith_above - zenith_below) / (2 * _HEIGHT_STEP) * obliquity


def _satellite_codes(pair, tracks):
    """Return one code (T, m) [m] of each satellite, of its first band that was measured: it tells the time of transmission."""
    codes = np.full((len(pair.time), len(pair.satellites)), np.nan)
    for channel in np.argsort(-pair.band, kind="stable"):
        code = tracks.code[:, channel]
        codes[:, pair.satellite[channel]] = np.where(np.isfinite(code), code, codes[:, pair.satellite[channel]])
    return codes


def _usable(pair, modelled, elevation, mask):
    measured = np.isfinite(pair.rover.code + pair.master.code + pair.rover.phase + pair.master.phase + modelled)
    return measured & (elevation >= mask) & ~has_half_cycle(pair) & ~is_shadowed(pair)


def _has_gross_code(pair, code):
    """Return (T, c) bool: one of the satellite's codes is kilometres off the usual one of its epoch; its time of transmission is not known then."""
    usual = row_medians(code)
    gross = np.zeros((len(code), len(pair.satellites)), dtype=bool)
    for channel, satellite in enumerate(pair.satellite):
        with np.errstate(invalid="ignore"):
            gross[:, satellite] |= np.abs(code[:, channel] - usual) > _GROSS_CODE
    return gross[:, pair.satellite]


def _single_difference_sigma(sigma, noise, pair, elevation):
    """Return the standard deviation (T, c) [m] of rover minus master, NaN below the horizon."""
    elevation = np.where(elevation > 0, elevation, np.nan)
    return np.hypot(*(sigma(noise, elevation, tracks.cn0, pair.wavelength) for tracks in (pair.master, pair.rover)))


def _novelty(pair, age, noise):
    """Return the share (T, c) of new information: multipath lasts, so the hundredth measurement of an ambiguity tells little."""
    steps = information_step(np.arange(1, len(age) + 1), usual_step(pair.time), noise.correlated_share, noise.novelty_time)
    return steps[np.maximum(age, 1) - 1]
