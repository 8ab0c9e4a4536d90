"""The model behind single point positioning: what a code should measure from a supposed place, and the place that fits best."""

from typing import NamedTuple

import numpy as np
from scipy.special import chdtri

from gnsslab.core.least_squares import LeastSquares, least_squares, worst_rows
from gnsslab.gnss.delays import klobuchar, saastamoinen
from gnsslab.gnss.frames import azimuth_elevation, enu_rotation_at, geodetic_from_ecef
from gnsslab.gnss.orbits import EARTH_RATE_WGS84, SatelliteStates, group_delay, rotate_to_reception, satellite_states
from gnsslab.gnss.signals import SPEED_OF_LIGHT
from gnsslab.gnss.weighting import NoiseModel, sigma_code

ROUGH_SIGMA = 30.0  # [m] of any code before its elevation is known: the atmosphere's 30 m near the horizon
SCREENING_THRESHOLD = 4.0  # normalised residual: one good measurement in 16 000 is taken out
FALSE_ALARM = 1e-3  # of the chi-square test: one good epoch in a thousand would be refused
LOWEST_RADIUS, HIGHEST_RADIUS = 6.3e6, 2e7  # [m] from the centre of the Earth: the poles are at 6.36e6, GPS at 2.66e7
CONVERGED = 100.0  # [m]: a step s leaves s^2 / (2 * 20 000 km) to go, here 0.25 mm; the last round's step is centimetres and leaves nothing
MOST_STEPS = 12  # from the centre of the Earth five to six are needed
LOWEST_MAPPED = np.radians(2.0)  # below it the delays and sigmas of this elevation serve
UNKNOWN_ACCURACY = 10.0  # [m], for a satellite whose broadcast gives none
IONOSPHERE_LEFT = 0.5  # Klobuchar's model takes away at least half of the delay, rms (IS-GPS-200N 20.3.3.5.2.5)
# Broadcast by GPS on 2004-01-01, a day of middling activity, and used where a file has no coefficients (as RTKLIB does).
MIDDLING_IONOSPHERE = np.array([0.1118e-7, -0.7451e-8, -0.5961e-7, 0.1192e-6, 0.1167e6, -0.2294e6, -0.1311e6, 0.1049e7])
# Saastamoinen with a standard atmosphere: the wet part is off by some 5 cm in the zenith, more in the tropics.
TROPOSPHERE_ZENITH = 0.1  # [m]


class Sky(NamedTuple):
    """What is known of T epochs before the receiver is located: m satellites, s systems."""

    time: np.ndarray  # (T,) datetime64[ns]
    names: tuple  # (m,)
    frequency: np.ndarray  # (m,) [Hz]
    systems: str  # (s,) letters
    clock_columns: np.ndarray  # (m, s) 1 where a satellite belongs to a system
    code: np.ndarray  # (T, m) [m]
    doppler: np.ndarray  # (T, m) [Hz]
    cn0: np.ndarray  # (T, m) [dB-Hz]
    states: SatelliteStates
    to_clock: np.ndarray  # (T, m) [m], code plus satellite clock, less group delay: geometric range, receiver clock and delays
    usable: np.ndarray  # (T, m) bool, code and ephemeris are there
    ionosphere: dict  # system letter -> (8,) Klobuchar coefficients
    toe: np.ndarray  # (k,) datetime64[ns] of all ephemerides, to say what they are good for


class Problem(NamedTuple):
    """Ranges to locate a receiver by, all arrays with epochs in front."""

    satellite: np.ndarray  # (T, m, 3) ECEF [m] in the frame of reception
    range: np.ndarray  # (T, m) [m], less all delays: distance plus receiver clock
    sigma: np.ndarray  # (T, m) [m]
    used: np.ndarray  # (T, m) bool


class Located(NamedTuple):
    """Positions of T epochs, how they were found, and the directions seen from there."""

    position: np.ndarray  # (T, 3) ECEF [m]
    geodetic: np.ndarray  # (T, 3) latitude, longitude [rad] and height [m] from which the satellites were seen
    fit: LeastSquares  # of the last step: x = (step, clocks), residuals and the satellites kept
    rough: LeastSquares  # of the first round, without mask and atmosphere
    rough_radius: np.ndarray  # (T,) [m] of the first round's position from the centre of the Earth
    above: np.ndarray  # (T, m) bool, usable and above the mask
    satellite: np.ndarray  # (T, m, 3) ECEF [m] in the frame of reception
    u: np.ndarray  # (T, m, 3) unit vectors receiver to satellite, ECEF
    u_enu: np.ndarray  # (T, m, 3)
    azimuth: np.ndarray  # (T, m) [rad]
    elevation: np.ndarray  # (T, m) [rad]


def sky_of(time, measured, systems, ephemerides):
    """Return the `Sky` of `Dense` measurements at T epochs: satellite states from the receiver's own times of transmission."""
    letters = [name[0] for name in measured.satellites]
    states = satellite_states(ephemerides, measured.satellites, time, measured.code / SPEED_OF_LIGHT)
    delay = group_delay(ephemerides, states.index, letters, [signal[0] for signal in measured.signals])
    to_clock = measured.code + SPEED_OF_LIGHT * (states.clock - np.nan_to_num(delay))
    return Sky(
        time=time,
        names=measured.satellites,
        frequency=measured.frequency,
        systems=systems,
        clock_columns=np.array([[float(letter == system) for system in systems] for letter in letters]).reshape(len(letters), len(systems)),
        code=measured.code,
        doppler=measured.doppler,
        cn0=measured.cn0,
        states=states,
        to_clock=to_clock,
        usable=np.isfinite(to_clock),
        ionosphere=ephemerides.ionosphere,
        toe=ephemerides.toe,
    )


def locate(sky, mask):
    """Return the `Located` receiver: first roughly with every satellite, then with atmosphere and weights above the mask [rad].

    The second round is done twice, as delays and the Earth's turn are taken from where the round began: 50 m off, then centimetres.
    """
    satellite = rotate_to_reception(sky.states.position, sky.code / SPEED_OF_LIGHT)
    problem = Problem(satellite, sky.to_clock, np.full(sky.code.shape, ROUGH_SIGMA), sky.usable)
    position, rough = screened_position(problem, sky.clock_columns, _common_start(problem, sky.clock_columns))
    radius = np.where(rough.is_solved, np.linalg.norm(position, axis=-1), np.nan)
    position = np.where(is_plausible(rough, sky.usable, radius)[:, None], position, np.nan)
    kept = rough.used
    for _ in range(2):
        located = _seen_from(position, sky, mask)
        problem = _corrected(sky, located, kept & located.above)
        position, fit = screened_position(problem, sky.clock_columns, position)
        kept = fit.used
    return located._replace(position=position, fit=fit, rough=rough, rough_radius=radius)


def is_plausible(rough, usable, radius):
    """Return which rough positions (T,) are worth refining: their codes agree, and they are neither deep in the Earth nor among the satellites."""
    return is_trustworthy(rough, usable) & (radius > LOWEST_RADIUS) & (radius < HIGHEST_RADIUS)


def is_trustworthy(fit, candidates):
    """Return which solved epochs (T,) pass the chi-square test after at most as many removals as their redundancy still bears.

    j errors can be told apart from any other j only where redundancy was 2 j, so j is left after their removal.
    """
    removed = (candidates & ~fit.used).sum(axis=-1)
    return fit.is_solved & (fit.chi_square <= chi_square_limit(fit.redundancy)) & (removed <= fit.redundancy)


def chi_square_limit(redundancy):
    """Return the value that chi-square passes with probability FALSE_ALARM; infinite where nothing is redundant.

    >>> np.round(chi_square_limit(np.array([0, 1, 5])), 2).tolist()
    [inf, 10.83, 20.52]
    """
    checked = redundancy > 0
    return np.where(checked, chdtri(np.where(checked, redundancy, 1), FALSE_ALARM), np.inf)


def lines_of_sight(satellite, receiver):
    """Return unit vectors (..., m, 3) from receivers (..., 3) to satellites (..., m, 3) and the distances (..., m) [m]."""
    vector = satellite - receiver[..., None, :]
    distance = np.sqrt(np.einsum("...i,...i->...", vector, vector))
    return vector / distance[..., None], distance


def travel_times(satellite, receiver):
    """Return how long signals travelled (..., m) [s] from satellites (..., m, 3) in the frame of transmission to receivers (..., 3).

    c tau = |x_sat - x_rec| + w / c (x_sat y_rec - y_sat x_rec): the Sagnac effect to first order, the next is below 0.2 mm of range.
    """
    _, distance = lines_of_sight(satellite, receiver)
    across = satellite[..., 0] * receiver[..., None, 1] - satellite[..., 1] * receiver[..., None, 0]
    return (distance + EARTH_RATE_WGS84 / SPEED_OF_LIGHT * across) / SPEED_OF_LIGHT


def iterated_position(problem, clock_columns, start):
    """Return positions (T, 3) and the last fit by Gauss-Newton from `start` (T, 3): range = |x_sat - x| + clock.

    Linear in the clocks, so only the position is carried from step to step; A = [-u, clock columns].
    """
    position = start
    clocks = np.broadcast_to(clock_columns, (*problem.range.shape, clock_columns.shape[1]))
    for _ in range(MOST_STEPS):
        u, distance = lines_of_sight(problem.satellite, position)
        fit = least_squares(np.concatenate([-u, clocks], axis=-1), problem.range - distance, problem.sigma, problem.used)
        step = np.where(fit.is_solved[:, None], fit.x[:, :3], 0.0)
        position = position + step
        if np.abs(step).max(initial=0.0) < CONVERGED:
            break
    return position, fit


def screened_position(problem, clock_columns, start):
    """Return positions (T, 3) and fit after data snooping: an epoch's worst satellite is taken out and it is located again, until none is bad."""
    position, fit = iterated_position(problem, clock_columns, start)
    for _ in range(problem.used.shape[1]):
        worst = worst_rows(fit, SCREENING_THRESHOLD)
        rows = np.flatnonzero(worst.any(axis=1))
        if not len(rows):
            break
        again = Problem(*(array[rows] for array in problem._replace(used=fit.used & ~worst)))
        moved, refit = iterated_position(again, clock_columns, position[rows])
        position = _with_rows(position, rows, moved)
        fit = LeastSquares(*(_with_rows(old, rows, new) for old, new in zip(fit, refit, strict=True)))
    return position, fit


def _common_start(problem, clock_columns):
    """Return a start (T, 3) for all epochs: the position of the epoch with most satellites, itself found from the centre of the Earth."""
    T = len(problem.used)
    if T == 0 or problem.used.shape[1] == 0:
        return np.zeros((T, 3))
    best = [int(np.argmax(problem.used.sum(axis=1)))]
    position, _ = screened_position(Problem(*(array[best] for array in problem)), clock_columns, np.zeros((1, 3)))
    return np.repeat(position, T, axis=0)


def _seen_from(position, sky, mask):
    """Return a Located without a fit: satellites in the frame of reception at positions (T, 3), and where they stand in the sky."""
    satellite = rotate_to_reception(sky.states.position, travel_times(sky.states.position, position))
    u, _ = lines_of_sight(satellite, position)
    geodetic = geodetic_from_ecef(position)
    u_enu = u @ np.swapaxes(enu_rotation_at(geodetic[:, 0], geodetic[:, 1]), -1, -2)
    azimuth, elevation = azimuth_elevation(u_enu)
    above = sky.usable & (elevation >= mask)
    return Located(position, geodetic, None, None, None, above, satellite, u, u_enu, azimuth, elevation)


def _corrected(sky, seen, used):
    """Return the Problem with atmosphere and weights as seen from a supposed place."""
    latitude, longitude, height = np.moveaxis(seen.geodetic, -1, 0)[..., None]
    elevation = np.maximum(seen.elevation, LOWEST_MAPPED)
    troposphere = saastamoinen(latitude, height, elevation)
    ionosphere, ionosphere_left = _ionosphere(sky, latitude, longitude, seen.azimuth, elevation)
    accuracy = np.where(np.isfinite(sky.states.accuracy), sky.states.accuracy, UNKNOWN_ACCURACY)
    noise = sigma_code(NoiseModel(), elevation, sky.cn0, SPEED_OF_LIGHT / sky.frequency)
    sigma = np.sqrt(noise**2 + ionosphere_left**2 + (TROPOSPHERE_ZENITH / np.sin(elevation)) ** 2 + accuracy**2)
    return Problem(seen.satellite, sky.to_clock - troposphere - ionosphere, sigma, used)


def _ionosphere(sky, latitude, longitude, azimuth, elevation):
    """Return the modelled delay (T, m) [m] and what it leaves, one sigma."""
    given = _coefficients(sky.ionosphere)
    coefficients, left = (MIDDLING_IONOSPHERE, 1.0) if given is None else (given, IONOSPHERE_LEFT)
    delay = klobuchar(coefficients, sky.time[:, None], latitude, longitude, azimuth, elevation, sky.frequency)
    return delay, left * delay


def _coefficients(ionosphere):
    """Return the broadcast coefficients (8,), of GPS if there, else of QZSS or BeiDou; None where there are none."""
    given = [ionosphere[letter] for letter in "GJC" if letter in ionosphere]
    return next((alpha_beta for alpha_beta in given if np.isfinite(alpha_beta).all() and np.any(alpha_beta)), None)


def _with_rows(array, rows, values):
    """Return a copy with some rows replaced."""
    copy = array.copy()
    copy[rows] = values
    return copy
