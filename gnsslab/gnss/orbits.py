"""Broadcast orbits and clocks: where the satellites were, and what their clocks read, when the signals left.

The algorithm is that of IS-GPS-200N table 20-IV, of the Galileo OS SIS ICD 2.1 section 5.1.1 and of the BeiDou
interface documents (BDS-SIS-ICD-2.1 section 5.2.4.12, with its extra rotation for geostationary satellites).
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from gnsslab.gnss.signals import SPEED_OF_LIGHT, frequency
from gnsslab.gnss.times import BDT_BEHIND_GPS, NANOSECOND, week_and_tow

GRAVITATION = {"G": 3.986005e14, "J": 3.986005e14, "E": 3.986004418e14, "C": 3.986004418e14}  # mu [m^3/s^2], each ICD's own
EARTH_RATE = {"G": 7.2921151467e-5, "J": 7.2921151467e-5, "E": 7.2921151467e-5, "C": 7.292115e-5}  # [rad/s]
EARTH_RATE_WGS84 = EARTH_RATE["G"]
# Largest |t - toe| [s]: half the fit interval of GPS and QZSS; Galileo's 4 h validity; BeiDou as RTKLIB allows it (6 h).
AGE_LIMIT = {"G": 7200.0, "J": 7200.0, "E": 14_400.0, "C": 21_600.0}
AGE_SLACK = 1.0  # [s], so that an epoch tagged a few ms past the limit keeps its satellite
# Health bits that forbid use. GPS: all six. QZSS: its lowest bit speaks of a signal not used here (L1C/B, formerly L6).
# Galileo: E1B, E5a, E5b, validity and status each (RINEX 3.04 table A8). BeiDou: the one bit SatH1.
HEALTH_MASK = {"G": ~0, "J": ~1, "E": 0x1FF, "C": ~0}
GEO_SATELLITES = tuple(f"C{number:02d}" for number in (1, 2, 3, 4, 5, 59, 60, 61, 62, 63))
GEO_TILT = np.radians(-5.0)  # BDS-SIS-ICD: GEO elements are given in a frame tilted by -5 deg about x


@dataclass(frozen=True, eq=False)
class SatelliteStates:
    """States of m satellites at transmission for T epochs; NaN where there is no fit, healthy data set or no observation."""

    position: np.ndarray  # (T, m, 3) ECEF [m], in the frame of the time of transmission
    velocity: np.ndarray  # (T, m, 3) [m/s], in the same rotating frame
    clock: np.ndarray  # (T, m) [s], satellite clock minus system time, with relativity, without group delay
    clock_drift: np.ndarray  # (T, m) [s/s]
    index: np.ndarray  # (T, m) int, row of the Ephemerides; -1: none
    accuracy: np.ndarray  # (T, m) [m], broadcast URA or SISA

    def __repr__(self):
        return f"SatelliteStates: {self.index.shape[0]} epochs of {self.index.shape[1]} satellites, {(self.index >= 0).sum()} with orbits"


def satellite_states(ephemerides, satellites, time, transit, index=None):
    """Compute positions, velocities and clocks at transmission for epochs (T,) and a sequence of m satellite names.

    `time` holds the receiver's tags (T,) datetime64 and `transit` (T, m) [s] is pseudorange / c, NaN where not observed.
    The satellite's clock read tag - transit when the signal left; system time of transmission is t = tag - transit - dt(t).
    The receiver's own clock error cancels in tag - pseudorange / c, so each receiver has its own times of transmission.
    `index` (T, m) are the data sets to use; without it `select_ephemerides` chooses by the tags.

    Source: IS-GPS-200N sections 20.3.3.3.3.1 and 20.3.3.4.3. What is missing is NaN, with index -1; raises ValueError for
    a transit of another shape.
    """
    time = np.asarray(time, dtype="datetime64[ns]")
    transit = np.asarray(transit, dtype=float)
    _require_shape(transit, (len(time), len(satellites)))
    index = select_ephemerides(ephemerides, satellites, time) if index is None else index
    is_known = (index >= 0) & np.isfinite(transit)
    row, epoch = index[is_known], np.nonzero(is_known)[0]
    elements = orbit_elements(ephemerides, row)
    sent_after_toc = (time[epoch] - ephemerides.toc[row]) / NANOSECOND / 1e9 - transit[is_known]
    sent_after_toe = (time[epoch] - ephemerides.toe[row]) / NANOSECOND / 1e9 - transit[is_known]
    offset = _clock_iterated(elements, sent_after_toc)
    position, velocity, relativity, relativity_rate = kepler_states(elements, sent_after_toe - offset)
    clock, drift = _clock_polynomial(elements, sent_after_toc - offset)
    return SatelliteStates(
        position=_spread(position, is_known),
        velocity=_spread(velocity, is_known),
        clock=_spread(clock + relativity, is_known),
        clock_drift=_spread(drift + relativity_rate, is_known),
        index=index,
        accuracy=_spread(ephemerides.accuracy[index[is_known]], is_known),
    )


def _require_shape(transit, shape):
    if transit.shape != shape:
        raise ValueError(f"expected transit times of shape (epochs, satellites) = {shape}, came {transit.shape}")


def select_ephemerides(ephemerides, satellites, time):
    """Return rows (T, m) of the data sets to use for satellites (m names) at epochs (T,), -1 where there is none.

    The data set nearest in toe serves (the later of two equally near), if not older than its system allows; Galileo's I/NAV
    goes before F/NAV. If it calls its satellite unhealthy there is none: an older healthy one would overrule the warning.
    Chosen by the epoch's label, not by the time of transmission. Two receivers' labels of one epoch may lie on either side of
    the moment of change, so for a baseline choose once, for both ends.
    """
    time = np.asarray(time, dtype="datetime64[ns]")
    index = np.full((len(time), len(satellites)), -1)
    first = np.searchsorted(ephemerides.satellite, satellites, side="left")
    end = np.searchsorted(ephemerides.satellite, satellites, side="right")
    is_fnav = is_galileo_fnav(ephemerides)
    for column, satellite in enumerate(satellites):
        rows = np.arange(first[column], end[column])
        preferred = _nearest(ephemerides, rows[~is_fnav[rows]], satellite[:1], time)
        fallback = _nearest(ephemerides, rows[is_fnav[rows]], satellite[:1], time)
        index[:, column] = np.where(preferred >= 0, preferred, fallback)
    return np.where((index >= 0) & is_healthy(ephemerides)[index], index, -1) if len(ephemerides.satellite) else index


def is_healthy(ephemerides):
    """Return which data sets (k,) allow the use of their satellite, by the health bits that matter to its system."""
    mask = _by_system(ephemerides, HEALTH_MASK)
    return (ephemerides.health & mask) == 0


def is_galileo_fnav(ephemerides):
    """Return which data sets (k,) are Galileo F/NAV alone: data-source bit 1 set, the I/NAV bits 0 and 2 not (RINEX 3.04 table A8)."""
    is_galileo = ephemerides.satellite.astype("<U1") == "E"
    return is_galileo & ((ephemerides.clock_issue & 0b111) == 0b010)


def rotate_to_reception(position, travel_time):
    """Return ECEF positions (..., 3) turned into the frame of the time of reception (the Sagnac effect, to be applied once).

    The Earth turns by w tau while the signal travels: p' = Rz(w tau) p = [x cos + y sin, -x sin + y cos, z]; up to 40 m of range.

    >>> rotate_to_reception([26_600_000.0, 0.0, 0.0], 0.07)[1].round(3).item()
    -135.779
    """
    x, y, z = np.moveaxis(np.asarray(position, dtype=float), -1, 0)
    angle = EARTH_RATE_WGS84 * np.asarray(travel_time)
    cos, sin = np.cos(angle), np.sin(angle)
    return np.stack([x * cos + y * sin, y * cos - x * sin, z + 0 * angle], axis=-1)


def group_delay(ephemerides, index, systems, bands):
    """Return the delay [s] (T, m) that a single-frequency code user subtracts from the satellite clock.

    `index` (T, m) are rows (-1: NaN comes back), `systems` m letters, `bands` one RINEX band digit or m of them.
    GPS, QZSS: gamma TGD, gamma = (f1/f)^2. BeiDou, clock of B3I: TGD1 for B1, TGD2 for B2, 0 for B3.
    Galileo: B_clock + (gamma - 1) B_band, B_clock the BGD of the clock's own pair (I/NAV E1/E5b, F/NAV E1/E5a), B_band that of
    E1 and the band used. L5, B1C and B2a have corrections of their own in messages not read here; the nearest serves.
    Sources: IS-GPS-200N 20.3.3.3.3.2, Galileo OS SIS ICD 5.1.5, BDS-SIS-ICD-2.1 5.2.4.10.
    """
    delays = [_delay_of_band(ephemerides, system, band) for system, band in zip(systems, _one_each(bands, systems), strict=True)]
    if not len(ephemerides.satellite) or not delays:
        return np.full(np.shape(index), np.nan)
    columns = np.arange(len(delays))
    return np.where(index >= 0, np.stack(delays)[columns, index], np.nan)


class Elements(NamedTuple):
    """Orbit and clock parameters of n satellite epochs, each (n,): names and units of Ephemerides, and three constants each."""

    sqrt_a: np.ndarray
    e: np.ndarray
    i0: np.ndarray
    omega0: np.ndarray
    turned: np.ndarray  # w toe: angle the Earth has turned since the week began [rad]
    omega: np.ndarray
    m0: np.ndarray
    n: np.ndarray  # mean motion, corrected [rad/s]
    idot: np.ndarray
    omega_dot: np.ndarray
    cuc: np.ndarray
    cus: np.ndarray
    crc: np.ndarray
    crs: np.ndarray
    cic: np.ndarray
    cis: np.ndarray
    af0: np.ndarray
    af1: np.ndarray
    af2: np.ndarray
    mu: np.ndarray  # [m^3/s^2]
    earth_rate: np.ndarray  # [rad/s]
    is_geo: np.ndarray  # 1 for BeiDou's geostationary satellites, 0 for all others


def kepler_states(elements, t):
    """Compute positions (n, 3) [m], velocities (n, 3) [m/s], relativistic clock term (n,) [s] and its rate, t (n,) [s] after toe.

    M = M0 + n t;  E - e sin E = M;  nu = atan2(sqrt(1 - e^2) sin E, cos E - e);  u, r, i with their second harmonics;
    dt_rel = -2 sqrt(mu) / c^2 e sqrt(A) sin E.   Velocities are the exact time derivatives of the same formulas.

    >>> circle = Elements(*np.zeros((22, 1)))._replace(sqrt_a=np.array([5153.6]))
    >>> kepler_states(circle, np.zeros(1))[0].round(2).tolist()
    [[26559592.96, 0.0, 0.0]]
    """
    el = elements
    a = el.sqrt_a**2
    sin_E, cos_E, E_dot = _eccentric_anomaly(el, t)
    plane = _orbital_plane(el, t, a, sin_E, cos_E, E_dot)
    position, velocity = _earth_fixed(el, t, plane)
    relativity = -2 * np.sqrt(el.mu) / SPEED_OF_LIGHT**2 * el.e * el.sqrt_a
    return position, velocity, relativity * sin_E, relativity * cos_E * E_dot


def _eccentric_anomaly(el, t):
    """Return sin E, cos E and dE/dt: Newton's iteration of Kepler's equation; three rounds serve e up to 0.17 (E14, E18)."""
    M = el.m0 + el.n * t
    E = M + el.e * np.sin(M)
    for _ in range(12):
        step = (E - el.e * np.sin(E) - M) / (1 - el.e * np.cos(E))
        E = E - step
        if np.abs(step).max(initial=0.0) < 1e-9:  # quadratic: the next step would be below 1e-17 rad
            break
    cos_E = np.cos(E)
    return np.sin(E), cos_E, el.n / (1 - el.e * cos_E)


class _Plane(NamedTuple):
    """Position and velocity in the orbital plane (x to the ascending node), sine and cosine and rate of its inclination."""

    x: np.ndarray
    y: np.ndarray
    x_dot: np.ndarray
    y_dot: np.ndarray
    sin_i: np.ndarray
    cos_i: np.ndarray
    i_dot: np.ndarray


def _orbital_plane(el, t, a, sin_E, cos_E, E_dot):
    root = np.sqrt(1 - el.e**2)
    phi = np.arctan2(root * sin_E, cos_E - el.e) + el.omega  # argument of latitude before correction
    phi_dot = root * E_dot / (1 - el.e * cos_E)
    sin_2phi, cos_2phi = np.sin(2 * phi), np.cos(2 * phi)
    u = phi + el.cus * sin_2phi + el.cuc * cos_2phi
    r = a * (1 - el.e * cos_E) + el.crs * sin_2phi + el.crc * cos_2phi
    i = el.i0 + el.idot * t + el.cis * sin_2phi + el.cic * cos_2phi
    u_dot = phi_dot * (1 + 2 * (el.cus * cos_2phi - el.cuc * sin_2phi))
    r_dot = a * el.e * sin_E * E_dot + 2 * phi_dot * (el.crs * cos_2phi - el.crc * sin_2phi)
    i_dot = el.idot + 2 * phi_dot * (el.cis * cos_2phi - el.cic * sin_2phi)
    x, y = r * np.cos(u), r * np.sin(u)
    x_dot, y_dot = r_dot * np.cos(u) - y * u_dot, r_dot * np.sin(u) + x * u_dot
    return _Plane(x, y, x_dot, y_dot, np.sin(i), np.cos(i), i_dot)


def _earth_fixed(el, t, plane):
    """Turn the orbital plane into ECEF: by the node's Earth-fixed longitude, or inertially and then by the GEO rotation."""
    node_rate = el.omega_dot - np.where(el.is_geo, 0.0, el.earth_rate)
    node = el.omega0 + node_rate * t - el.turned
    sin_O, cos_O = np.sin(node), np.cos(node)
    across, across_dot = plane.y * plane.cos_i, plane.y_dot * plane.cos_i - plane.y * plane.sin_i * plane.i_dot
    x, y = plane.x * cos_O - across * sin_O, plane.x * sin_O + across * cos_O
    vx = plane.x_dot * cos_O - across_dot * sin_O - node_rate * y
    vy = plane.x_dot * sin_O + across_dot * cos_O + node_rate * x
    vz = plane.y_dot * plane.sin_i + plane.y * plane.cos_i * plane.i_dot
    position, velocity = np.stack([x, y, plane.y * plane.sin_i], axis=-1), np.stack([vx, vy, vz], axis=-1)
    geo = np.nonzero(el.is_geo)[0]
    if geo.size:
        position[geo], velocity[geo] = _geo_earth_fixed(position[geo], velocity[geo], el.earth_rate[geo], t[geo])
    return position, velocity


def _geo_earth_fixed(position, velocity, earth_rate, t):
    """Return p = Rz(w t) Rx(-5 deg) p_tilted and its derivative (BDS-SIS-ICD-2.1 table 5-11)."""
    cos, sin = np.cos(GEO_TILT), np.sin(GEO_TILT)
    Rx = np.array([[1, 0, 0], [0, cos, sin], [0, -sin, cos]])
    position = _rotate_z(position @ Rx.T, earth_rate * t)
    velocity = _rotate_z(velocity @ Rx.T, earth_rate * t)
    velocity[:, 0] += earth_rate * position[:, 1]
    velocity[:, 1] -= earth_rate * position[:, 0]
    return position, velocity


def _rotate_z(vectors, angle):
    cos, sin = np.cos(angle), np.sin(angle)
    x, y, z = vectors.T
    return np.stack([x * cos + y * sin, y * cos - x * sin, z], axis=-1)


def _clock_iterated(el, t):
    """Return dt solving dt = f(t - dt) for clock readings t (n,) [s] after toc; dt < 1 ms and af1 < 1e-9 make two rounds exact."""
    offset = np.zeros_like(t)
    for _ in range(3):
        offset, _drift = _clock_polynomial(el, t - offset)
    return offset


def _clock_polynomial(el, t):
    return el.af0 + (el.af1 + el.af2 * t) * t, el.af1 + 2 * el.af2 * t


def orbit_elements(ephemerides, row):
    """Gather the parameters of rows (n,), deriving mean motion and the like once a data set."""
    eph = ephemerides
    mu, earth_rate = _by_system(eph, GRAVITATION), _by_system(eph, EARTH_RATE)
    derived = {
        "mu": mu,
        "earth_rate": earth_rate,
        "n": np.sqrt(mu) / eph.sqrt_a**3 + eph.delta_n,
        "turned": earth_rate * _toe_in_own_week(eph),
        "is_geo": np.isin(eph.satellite, GEO_SATELLITES).astype(float),
    }
    table = np.stack([derived[name] if name in derived else getattr(eph, name) for name in Elements._fields])
    return Elements(*np.take(table, row, axis=1))


def _toe_in_own_week(ephemerides):
    """Return toe as seconds of the week (k,) of the system's own time: BDT is 14 s behind GPS time."""
    is_beidou = ephemerides.satellite.astype("<U1") == "C"
    return week_and_tow(ephemerides.toe - np.where(is_beidou, BDT_BEHIND_GPS, np.timedelta64(0, "s")))[1]


def _by_system(ephemerides, values):
    letters = ephemerides.satellite.astype("<U1")
    return np.select([letters == letter for letter in values], list(values.values()), next(iter(values.values())))


def _nearest(ephemerides, rows, system, time):
    """Return of rows (sorted by toe) the one nearest in toe to each time (T,), -1 where it is older than allowed."""
    if not len(rows):
        return np.full(len(time), -1)
    toe = ephemerides.toe[rows]
    is_last = np.append(toe[1:] != toe[:-1], True)  # of several data sets of one toe the one sent last
    rows, toe = rows[is_last], toe[is_last]
    nearest = np.searchsorted(toe[:-1] + (toe[1:] - toe[:-1]) // 2, time, side="right")
    age = np.abs((time - toe[nearest]) / NANOSECOND) / 1e9
    return np.where(age <= AGE_LIMIT.get(system, 0.0) + AGE_SLACK, rows[nearest], -1)


def _spread(values, is_known):
    """Return values (n, ...) at their places (T, m, ...), NaN elsewhere."""
    spread = np.full(is_known.shape + values.shape[1:], np.nan)
    spread[is_known] = values
    return spread


def _one_each(bands, systems):
    return list(bands) if len(bands) == len(systems) else [bands] * len(systems)


_BEIDOU_DELAY_COLUMN = {"2": 0, "1": 0, "7": 1, "5": 1, "8": 1}  # B1I, B1C: TGD1; B2I, B2a, B2: TGD2


def _delay_of_band(ephemerides, system, band):
    """Return the group delay (k,) of one system's signal, for every data set (those of other systems: meaningless)."""
    first, second = ephemerides.group_delay.T
    if system == "C":
        frequency("C", band)
        return np.zeros_like(first) if band == "6" else ephemerides.group_delay[:, _BEIDOU_DELAY_COLUMN[band]]
    gamma = (frequency(system, "1") / frequency(system, band)) ** 2
    if system == "E":
        of_clock = np.where(is_galileo_fnav(ephemerides), first, second)
        return of_clock + (gamma - 1) * (first if band == "5" else second)
    return gamma * first
