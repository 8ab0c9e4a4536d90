"""Recordings: everything one receiver measured over some minutes, simulated or read, with the terms of the observation equation."""

from dataclasses import dataclass, replace

import numpy as np

from gnsslab.gnss.delays import klobuchar, saastamoinen
from gnsslab.gnss.differences import Pair, Tracks, pair_receivers
from gnsslab.gnss.frames import azimuth_elevation, enu_rotation, geodetic_from_ecef
from gnsslab.gnss.observation_equations import RangeTerms
from gnsslab.gnss.orbits import rotate_to_reception, satellite_states
from gnsslab.gnss.point_model import MIDDLING_IONOSPHERE, lines_of_sight
from gnsslab.gnss.points import solve_points
from gnsslab.gnss.selection import keep_epochs
from gnsslab.gnss.signals import SPEED_OF_LIGHT, USED_SYSTEMS, frequency
from gnsslab.gnss.times import seconds_between
from gnsslab.simulate.measurements import measure
from gnsslab.simulate.recording import record

LONGEST = 600.0  # [s] of a long file: the ionosphere is still a smooth curve, and noise and slips are seen
FEWEST_EPOCHS = 60  # but so many, where they are 15 or 30 s apart


@dataclass(frozen=True, eq=False)
class Recording:
    """One receiver over T epochs: m satellites, c channels (a channel is one carrier of one satellite)."""

    pair: Pair  # of this receiver, as rover, and a silent partner: the form in which the engine looks for slips
    elevation: np.ndarray  # (T, m) [rad]
    terms: RangeTerms  # (T, m) of the first carrier, L1 where there is one

    @property
    def time(self):
        """Receiver time tags (T,)."""
        return self.pair.time


def simulated_recording(geometry, noise, rng):
    """Return the Recording of the first receiver of a simulated geometry; its terms are the truth."""
    preset = geometry.preset
    observations = record(preset, measure(geometry, noise, rng), 0)
    pair = _alone(observations, preset.systems)
    columns = [geometry.tracks.satellites.index(name) for name in pair.satellites]
    seconds = np.arange(preset.epochs) * preset.interval
    clock_receiver = np.broadcast_to(SPEED_OF_LIGHT * preset.clocks[0].error(seconds)[:, None], (len(seconds), len(columns)))
    clock_satellite = SPEED_OF_LIGHT * geometry.tracks.clock[:, columns]
    rho = geometry.pseudorange[0][:, columns] - clock_receiver + clock_satellite
    atmosphere = geometry.troposphere[0][:, columns], geometry.ionosphere[0][:, columns]
    return Recording(pair, geometry.elevation[0][:, columns], RangeTerms(rho, clock_receiver, clock_satellite, *atmosphere))


def read_recording(observations, ephemerides):
    """Return the Recording of a receiver at rest, GPS where there is any; ValueError in words where nothing can be solved.

    The distances start from the mean of its single point positions, and the clock is theirs, so the terms are good to a metre.
    """
    systems = "G" if "G" in observations.tables else "".join(letter for letter in USED_SYSTEMS if letter in observations.tables)
    if not systems:
        raise ValueError(f"the file holds no satellite of {', '.join(USED_SYSTEMS)}: give one with GPS, Galileo, BeiDou or QZSS")
    observations = keep_epochs(observations, shown_epochs(observations.time))
    points = solve_points(observations, ephemerides, systems=systems, mask_deg=5.0)
    place = points.mean_position()
    pair = _alone(observations, systems)
    clock = np.stack([points.clock[:, points.systems.index(name[0])] for name in pair.satellites], axis=-1)
    elevation, terms = _terms(pair, ephemerides, place, clock)
    return Recording(pair, elevation, terms)


def shown_epochs(time):
    """Return which epochs (T,) of a file are shown: its first ten minutes, or its first sixty epochs if they take longer."""
    return (np.arange(len(time)) < FEWEST_EPOCHS) | (seconds_between(time, time[:1]) < LONGEST)


def with_slip(recording, channels, epoch, cycles):
    """Return the recording with whole cycles added to the carriers of some channels from an epoch on."""
    phase = recording.pair.rover.phase.copy()
    for channel, count in zip(channels, cycles, strict=True):
        phase[epoch:, channel] += count
    return replace(recording, pair=replace(recording.pair, rover=replace(recording.pair.rover, phase=phase)))


def _alone(observations, systems):
    """Return the Pair of one receiver and a partner that measures zero: between-receiver differences are then its own measurements."""
    pair = pair_receivers(observations, observations, systems=systems)
    nothing = np.zeros_like(pair.rover.phase)
    return replace(pair, master=Tracks(nothing, nothing, nothing, pair.rover.cn0, np.zeros_like(pair.rover.lli)))


def _terms(pair, ephemerides, place, clock):
    """Return elevations (T, m) and the RangeTerms (T, m) of satellites seen from a place, the receiver's clock given [m]."""
    code = _first_codes(pair)
    states = satellite_states(ephemerides, pair.satellites, pair.time, code / SPEED_OF_LIGHT)
    places = np.broadcast_to(place, (len(pair.time), 3))
    travel = lines_of_sight(states.position, places)[1] / SPEED_OF_LIGHT
    u, rho = lines_of_sight(rotate_to_reception(states.position, travel), places)
    azimuth, elevation = azimuth_elevation(u @ enu_rotation(place).T)
    latitude, longitude, height = geodetic_from_ecef(place)
    carrier = np.array([frequency(name[0], pair.signal_rover[_channel(pair, s, 0)][0]) for s, name in enumerate(pair.satellites)])
    coefficients = ephemerides.ionosphere.get("G", MIDDLING_IONOSPHERE)
    ionosphere = klobuchar(coefficients, pair.time[:, None], latitude, longitude, azimuth, elevation, carrier)
    troposphere = saastamoinen(latitude, height, elevation)
    return elevation, RangeTerms(rho, clock, SPEED_OF_LIGHT * states.clock, troposphere, ionosphere)


def _first_codes(pair):
    return np.stack([pair.rover.code[:, _channel(pair, s, 0)] for s in range(len(pair.satellites))], axis=-1)


def _channel(pair, satellite, rank):
    """Return the channel of a satellite's first (0) or second (1) carrier; where it has one only, that."""
    channels = np.flatnonzero(pair.satellite == satellite)
    return channels[np.argsort(pair.band[channels], kind="stable")][min(rank, len(channels) - 1)]
