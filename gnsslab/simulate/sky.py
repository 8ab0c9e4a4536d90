"""A sky of our own: GPS, Galileo, BeiDou and QZSS as broadcast ephemerides, each satellite on one orbit for ever.

The constellations are nominal ones (slots as the systems' documents describe them, numbers as they are in use), with
small eccentricities, harmonic terms and clocks, so that every parameter of a broadcast message matters. All data sets
of a satellite describe the same orbit and the same clock: going from one to the next moves nothing. The sky is
the same in every GPS week, as the orbits are laid out from the week's beginning.
"""

from typing import NamedTuple

import numpy as np

from gnsslab.core.rotations import within_half_turn
from gnsslab.gnss.ephemerides import ARRAY_FIELDS, Ephemerides
from gnsslab.gnss.orbits import EARTH_RATE, GEO_SATELLITES, GEO_TILT, GRAVITATION
from gnsslab.gnss.times import BDT_BEHIND_GPS, add_seconds, gps_time, seconds_between, week_and_tow

REPEAT = {"G": 7200, "J": 3600, "E": 600, "C": 3600}  # [s] from one data set to the next
SENT_AFTER_TOE = {"G": -7170, "J": -3090, "E": 660, "C": 28}  # [s], as usual in recorded files
ACCURACY = {"G": 2.0, "J": 2.8, "E": 3.12, "C": 2.0}  # [m], usual URA and SISA
# Klobuchar alpha 0-3, beta 0-3 as GPS broadcast them on 2005-04-02, a moderately quiet Sun: 5 m at the zenith after noon.
NOMINAL_IONOSPHERE = (1.118e-8, 1.490e-8, -5.960e-8, -5.960e-8, 8.806e4, 1.638e4, -1.966e5, -1.311e5)

_GOLDEN = (np.sqrt(5) - 1) / 2
_DEG = np.pi / 180


class Orbit(NamedTuple):
    """A satellite's Kepler elements at the beginning of a GPS week; the node counts from Greenwich at that moment."""

    satellite: str
    n: float  # [rad/s], mean motion
    e: float
    i: float  # [rad]
    node: float  # [rad]
    omega: float  # [rad], argument of perigee
    m0: float  # [rad], mean anomaly
    node_rate: float  # [rad/s]


def broadcast_ephemerides(start, stop, systems="GECJ"):
    """Return the `Ephemerides` of all satellites of the systems that a receiver has collected from start to stop.

    start, stop: datetime64, GPS time. Data sets follow each other every 2 h (GPS), 1 h (BeiDou, QZSS) or 10 min (Galileo),
    from three before start to one after stop. Numbers are rounded to the 13 digits of a RINEX file.

    >>> broadcast_ephemerides(np.datetime64("2024-06-24T08:00"), np.datetime64("2024-06-24T08:10"), "GJ")
    Ephemerides: 170 data sets of 34 satellites
    """
    _check_systems(systems)
    start, stop = (np.datetime64(label, "ns") for label in (start, stop))
    if stop < start:
        raise ValueError(f"the ephemerides' span must not end before it begins: start {start}, stop {stop}; swap them")
    sets = [_data_sets(orbit, rank, start, stop) for system in sorted(systems) for rank, orbit in enumerate(constellation(system))]
    columns = {name: np.concatenate([one[name] for one in sets]) for name in ARRAY_FIELDS}
    order = np.lexsort((columns["toe"], columns["satellite"]))
    ionosphere = {system: np.array(NOMINAL_IONOSPHERE) for system in sorted(systems) if system in "GCJ"}
    return Ephemerides(**{name: column[order] for name, column in columns.items()}, ionosphere=ionosphere, leap_seconds=18, source="simulated")


def constellation(system):
    """Return the tuple of `Orbit` of all satellites of one system, in order of their numbers.

    >>> len(constellation("E")), constellation("C")[0].satellite
    (24, 'C01')
    """
    _check_systems(system)
    return tuple(sorted(_CONSTELLATIONS[system](), key=lambda orbit: orbit.satellite))


def _check_systems(systems):
    unknown = sorted(set(systems) - set(_CONSTELLATIONS))
    if unknown or not systems:
        came = f"{', '.join(map(repr, unknown))} is among them" if unknown else "none came"
        raise ValueError(f"systems of a simulated sky are the letters G, E, C and J; {came}; write for instance 'GE'")


def _gps():
    numbers = [number for number in range(1, 33) if number not in (21, 22)]  # 30 in six planes, two numbers at rest
    in_plane = np.array([0.0, 77.0, 142.0, 219.0, 283.0])  # [deg], uneven as flown: neighbours are further apart than a failure needs
    for k, number in enumerate(numbers):
        plane, slot = k % 6, k // 6
        yield _orbit(f"G{number:02d}", k, 26_559_800.0, 0.008, 55.0, 60.0 * plane, in_plane[slot] + 13.0 * plane)


def _galileo():
    numbers = (2, 3, 4, 5, 7, 8, 9, 10, 11, 12, 13, 15, 19, 21, 23, 24, 25, 26, 27, 30, 31, 33, 34, 36)
    for k, number in enumerate(numbers):
        yield _orbit(f"E{number:02d}", k, 29_600_318.0, 0.0003, 56.0, *_walker_24_3_1(k))


def _beidou():
    yield from _beidou_geostationary()
    yield from _beidou_inclined()
    numbers = (*range(19, 31), *range(32, 38), *range(41, 47))
    for k, number in enumerate(numbers):
        yield _orbit(f"C{number:02d}", k, 27_906_100.0, 0.0008, 55.0, *_walker_24_3_1(k))
    for k, number in enumerate((11, 12, 14)):  # the second generation's, between the slots of the third
        yield _orbit(f"C{number:02d}", k, 27_906_100.0, 0.002, 55.0, 20.0 + 60.0 * k, 70.0 + 100.0 * k)


def _beidou_geostationary():
    longitudes = {1: 140.0, 2: 80.0, 3: 110.5, 4: 160.0, 5: 58.75, 59: 140.0, 60: 80.0, 61: 110.5}
    for k, (number, longitude) in enumerate(longitudes.items()):
        yield _synchronous(f"C{number:02d}", k, 0.0003, 1.2, longitude, 40.0 * k, 150.0)


def _beidou_inclined():
    tracks = {6: 118.0, 7: 118.0, 8: 118.0, 9: 95.0, 10: 95.0, 13: 95.0, 16: 112.0, 38: 118.0, 39: 112.0, 40: 106.0}
    for k, (number, longitude) in enumerate(tracks.items()):
        yield _synchronous(f"C{number:02d}", k, 0.004, 55.0, longitude, 120.0 * k + 17.0 * (k // 3), 190.0)


def _qzss():
    for k, (number, longitude) in enumerate({2: 139.0, 3: 135.0, 4: 137.0}.items()):
        yield _synchronous(f"J{number:02d}", k, 0.075, 41.0, longitude, 120.0 * k, 270.0)  # apogee in the north: an asymmetric eight
    yield _synchronous("J07", 3, 0.0002, 0.07, 127.0, 30.0, 150.0)


def _walker_24_3_1(k):
    """Return node and argument of latitude [deg] of satellite k of Walker 24/3/1: 3 planes of 8, one plane on shifts by 360/24 deg."""
    plane, slot = divmod(k, 8)
    return 120.0 * plane, 45.0 * slot + 15.0 * plane


def _orbit(satellite, k, a, e, i_deg, node_deg, latitude_argument_deg):
    """Build a medium orbit of about these elements; k, the rank, sets the little deviations from the nominal ones."""
    n = np.sqrt(GRAVITATION[satellite[0]] / (a + 300.0 * _spread(k, 1)) ** 3) + _mean_motion_correction(satellite)
    omega = np.pi * _spread(k, 2)
    m0 = latitude_argument_deg * _DEG - omega
    e = e * (1 + 0.7 * _spread(k, 3))
    return Orbit(satellite, n, e, (i_deg + 0.8 * _spread(k, 4)) * _DEG, node_deg * _DEG, omega, m0, -8e-9 + 3e-10 * _spread(k, 5))


def _synchronous(satellite, k, e, i_deg, longitude_deg, latitude_argument_deg, omega_deg):
    """Build an orbit of one sidereal day around a longitude: node + omega + m0 is that longitude at the week's beginning."""
    node_rate = 0.0 if satellite in GEO_SATELLITES else -2e-9 + 2e-10 * _spread(k, 5)
    n = EARTH_RATE[satellite[0]] - node_rate
    m0 = (latitude_argument_deg - omega_deg) * _DEG
    node = (longitude_deg - latitude_argument_deg) * _DEG
    return Orbit(satellite, n, e, (i_deg + 0.2 * i_deg * _spread(k, 4)) * _DEG, node, omega_deg * _DEG, m0, node_rate)


def _spread(k, kind):
    """Return a number in [-1, 1) for the k-th satellite: multiples of the golden section fill the interval evenly."""
    return 2 * ((k + 1) * kind * _GOLDEN % 1) - 1


def _mean_motion_correction(satellite):
    return 1.17e-8 if satellite in GEO_SATELLITES else 2.9e-9 if satellite[0] in "EJ" else 4.3e-9  # delta_n as usually broadcast


def _data_sets(orbit, rank, start, stop):
    """Return a dictionary of the Ephemerides columns of one satellite."""
    toe = _reference_times(orbit.satellite[0], start, stop)
    week_start = gps_time(week_and_tow(start)[0], 0.0)
    seconds = seconds_between(toe, week_start)
    columns = {name: np.zeros(len(toe)) for name in ARRAY_FIELDS} | _shape(orbit, rank) | _labels(orbit.satellite, toe)
    columns |= _clock(orbit, rank, seconds)
    columns["m0"] = within_half_turn(orbit.m0 + orbit.n * seconds)
    columns |= _tilted_plane(orbit, seconds, toe) if orbit.satellite in GEO_SATELLITES else _plane(orbit, rank, seconds, toe)
    return {name: _thirteen_digits(np.broadcast_to(value, (len(toe), *np.shape(value)[1:]))) for name, value in columns.items()}


def _reference_times(system, start, stop):
    """Return the times of ephemeris (k,): multiples of the repetition in the system's own time, three before start to one after stop."""
    own = BDT_BEHIND_GPS if system == "C" else np.timedelta64(0, "s")
    first, last = (seconds_between(label - own, gps_time(0, 0.0)) / REPEAT[system] for label in (start, stop))
    count = np.arange(np.floor(first) - 2, np.ceil(last) + 2)
    return add_seconds(gps_time(0, 0.0) + own, count * REPEAT[system])


def _labels(satellite, toe):
    issue = (seconds_between(toe, gps_time(0, 0.0)) // REPEAT[satellite[0]]).astype(int) % (24 if satellite[0] == "C" else 128)
    clock_issue = 517 if satellite[0] == "E" else issue  # Galileo: the bits that say I/NAV, clock for E1 and E5b
    sent = add_seconds(toe, float(SENT_AFTER_TOE[satellite[0]]))
    return {
        "satellite": np.array([satellite]), "toe": toe, "toc": toe, "transmission": sent, "issue": issue,
        "clock_issue": np.asarray(clock_issue), "accuracy": ACCURACY[satellite[0]], "health": np.array(0),
    }  # fmt: skip


def _shape(orbit, rank):
    """Return size, eccentricity and the harmonic corrections, which follow the argument of latitude and hence stay as they are."""
    system, delta_n = orbit.satellite[0], _mean_motion_correction(orbit.satellite)
    a = np.cbrt(GRAVITATION[system] / (orbit.n - delta_n) ** 2)
    amplitude = 0.0 if orbit.satellite in GEO_SATELLITES else 1.0  # in the tilted frame the argument of latitude changes with toe
    sizes = {"cuc": 3e-6, "cus": 8e-6, "crc": 220.0, "crs": 60.0, "cic": 1e-7, "cis": 1e-7}
    harmonics = {name: amplitude * size * _spread(rank, 6 + j) for j, (name, size) in enumerate(sizes.items())}
    return {"sqrt_a": np.sqrt(a), "e": orbit.e, "delta_n": delta_n, "omega": within_half_turn(orbit.omega)} | harmonics


def _clock(orbit, rank, seconds):
    """Return a clock that is up to 0.5 ms off and drifts by up to 8e-12, with group delays of some ns; one polynomial for all sets."""
    rate = 8e-12 * _spread(rank, 13)
    delays = {"G": (-9.3e-9, 0.0), "J": (-4.7e-9, 0.0), "E": (-2.3e-9, -2.8e-9), "C": (8.5e-9, -6.2e-9)}[orbit.satellite[0]]
    group_delay = np.round(np.multiply(delays, _spread(rank, 14)), 10)
    return {"af0": 5e-4 * _spread(rank, 12) + rate * seconds, "af1": rate, "group_delay": group_delay[np.newaxis]}


def _plane(orbit, rank, seconds, toe):
    """Return the orbit's plane as broadcast: the node refers to Greenwich at the start of the week (of the system) in which toe lies."""
    rate, idot = EARTH_RATE[orbit.satellite[0]], 2e-10 * _spread(rank, 15)
    omega0 = orbit.node + orbit.node_rate * seconds - rate * seconds + rate * _own_tow(orbit.satellite, toe)
    return {"omega0": within_half_turn(omega0), "omega_dot": orbit.node_rate, "i0": orbit.i + idot * seconds, "idot": idot}


def _tilted_plane(orbit, seconds, toe):
    """Return the plane of a BeiDou GEO, in the frame the interface document broadcasts it in.

    At toe the satellite stands at R_x(5 deg) R_z(omega0 - rate toe) R_x(i0) R_z(omega) o in ECEF, o its place in the
    orbit's plane; in inertial space the orbit is at rest. So three Euler angles (z-x-z) are read from R_x(-5 deg) times its
    attitude in ECEF (rotations turn vectors; BDS-SIS-ICD-B1I 3.0, table 5-11).
    """
    rate = EARTH_RATE["C"]
    at_rest = _turn_z(orbit.node) @ _turn_x(orbit.i) @ _turn_z(orbit.omega)
    R = _turn_x(GEO_TILT) @ _turn_z(-rate * seconds) @ at_rest  # (k, 3, 3)
    node = np.arctan2(R[:, 0, 2], -R[:, 1, 2])
    i0 = np.arctan2(np.hypot(R[:, 0, 2], R[:, 1, 2]), R[:, 2, 2])
    omega = np.arctan2(R[:, 2, 0], R[:, 2, 1])
    return {"omega0": within_half_turn(node + rate * _own_tow("C", toe)), "i0": i0, "omega": omega}


def _own_tow(satellite, toe):
    return week_and_tow(toe - BDT_BEHIND_GPS if satellite[0] == "C" else toe)[1]


def _turn_x(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def _turn_z(angle):
    c, s, one = np.cos(angle), np.sin(angle), np.ones_like(angle)
    return np.stack([np.stack([c, -s, 0 * one], -1), np.stack([s, c, 0 * one], -1), np.stack([0 * one, 0 * one, one], -1)], -2)


def _thirteen_digits(values):
    """Round to what a navigation file holds (D19.12), so that a simulated message and its file say the same."""
    if values.dtype.kind != "f":
        return values
    return np.array([float(f"{value:.12e}") for value in values.ravel()]).reshape(values.shape)


_CONSTELLATIONS = {"G": _gps, "E": _galileo, "C": _beidou, "J": _qzss}
