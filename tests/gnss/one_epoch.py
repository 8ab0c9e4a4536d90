"""Relative positioning of one epoch, written once more and differently: no differences are formed, clocks are unknowns.

For each group (system, signal) the receivers' clock difference is one unknown for the codes and one for the carriers; the
ambiguity of the group's first satellite is left out (it is the carrier clock's). By a theorem of least squares this equals
double differencing with its full covariance. Ranges are scalar, with the Sagnac term as a formula instead of a rotation.
"""

from math import asin, hypot, pi, sin, sqrt
from typing import NamedTuple

import numpy as np

from gnsslab.core.integers import integer_least_squares
from gnsslab.gnss.delays import saastamoinen
from gnsslab.gnss.frames import enu_rotation, geodetic_from_ecef
from gnsslab.gnss.orbits import satellite_states
from gnsslab.gnss.signals import SPEED_OF_LIGHT, wavelength

EARTH_RATE = 7.292115e-5  # [rad/s]


class Signal(NamedTuple):
    """One carrier of one satellite at both ends."""

    group: tuple[str, str]
    satellite: str
    code: tuple[float, float]  # base, rover [m]
    phase: tuple[float, float]  # [m]
    transit: tuple[float, float]  # [s]
    sigma: float  # [m] of the carriers' difference
    wavelength: float  # [m]


class Answer(NamedTuple):
    """Baselines [m, ECEF] and what they were found from."""

    float_baseline: np.ndarray
    fixed_baseline: np.ndarray
    satellites: int
    ratio: float


def solve_one_epoch(base, rover, ephemerides, epochs, base_ecef, rover_ecef, signals, mask_deg=15.0):
    """Return the Answer at (base epoch, rover epoch); `signals` gives those of each system, {"G": ("1C", "2W")}."""
    times = base.time[epochs[0]], rover.time[epochs[1]]
    measured = _signals(base, rover, ephemerides, epochs, times, base_ecef, signals, mask_deg)
    ambiguous = [s for i, s in enumerate(measured) if s.group in {other.group for other in measured[:i]}]
    place = np.array(rover_ecef, dtype=float)
    for _ in range(4):
        x, N = _least_squares(measured, ambiguous, ephemerides, times, base_ecef, place)
        place = place + x[:3]
    n = len(ambiguous)
    best = integer_least_squares(x[-n:], np.linalg.inv(N)[-n:, -n:])
    float_baseline = place - base_ecef
    for _ in range(4):
        place = place + _fixed_step(measured, dict(zip(_keys(ambiguous), best.candidates[0], strict=True)), ephemerides, times, base_ecef, place)
    return Answer(float_baseline, place - base_ecef, len({s.satellite for s in measured}), best.norms[1] / best.norms[0])


def _keys(signals):
    return [(s.satellite, s.group) for s in signals]


def _signals(base, rover, ephemerides, epochs, times, base_ecef, signals, mask_deg):
    found = []
    for system, names in signals.items():
        for name in names:
            for satellite in sorted(set(base.tables[system].satellites) & set(rover.tables[system].satellites)):
                values = [
                    {kind: _value(receiver, epoch, satellite, kind + name) for kind in "CLS"}
                    for receiver, epoch in ((base, epochs[0]), (rover, epochs[1]))
                ]
                transit = [
                    _value(receiver, epoch, satellite, "C" + names[0]) / SPEED_OF_LIGHT for receiver, epoch in ((base, epochs[0]), (rover, epochs[1]))
                ]
                if not np.isfinite([*transit, *(v[kind] for v in values for kind in "CL")]).all():
                    continue
                _, elevation = _modelled(ephemerides, satellite, times[0], transit[0], base_ecef)
                if elevation * 180 / pi < mask_deg:
                    continue
                length = wavelength(system, name[0])
                sigma = hypot(*(_sigma(elevation, v["S"], length) for v in values))
                codes, phases = (tuple(v[kind] * factor for v in values) for kind, factor in (("C", 1.0), ("L", length)))
                found.append(Signal((system, name), satellite, codes, phases, tuple(transit), sigma, length))
    return found


def _value(receiver, epoch, satellite, code):
    table = receiver.tables[satellite[0]]
    for row in range(len(table.epoch)):
        if table.epoch[row] == epoch and table.number[row] == int(satellite[1:]):
            return table.value[row, table.codes.index(code)] if code in table.codes else np.nan
    return np.nan


def _sigma(elevation, cn0, length):
    cn0 = cn0 if cn0 > 0 else 45.0
    return sqrt(0.003**2 + (0.003 / sin(elevation)) ** 2 + (length / (2 * pi)) ** 2 * 15.0 / 10 ** (cn0 / 10))


def _modelled(ephemerides, satellite, time, transit, place):
    """Return range + troposphere - satellite clock [m] and the elevation [rad] at one receiver."""
    states = satellite_states(ephemerides, (satellite,), np.array([time]), np.array([[transit]]))
    s, clock = states.position[0, 0], states.clock[0, 0]
    sight = s - place
    distance = sqrt(sum(sight**2)) + EARTH_RATE / SPEED_OF_LIGHT * (s[0] * place[1] - s[1] * place[0])
    angle = EARTH_RATE * distance / SPEED_OF_LIGHT
    turned = np.array([s[0] + angle * s[1], s[1] - angle * s[0], s[2]]) - place
    elevation = asin((enu_rotation(place) @ turned)[2] / sqrt(sum(turned**2)))
    lat, _, height = geodetic_from_ecef(place)
    return distance + float(saastamoinen(lat, height, elevation)) - SPEED_OF_LIGHT * clock, elevation


def _step_of_range(signal, ephemerides, times, base_ecef, place):
    """Return the modelled single difference [m] and its derivative (3,) by the rover's place, by central differences of 1 m."""
    at_base, _ = _modelled(ephemerides, signal.satellite, times[0], signal.transit[0], base_ecef)

    def at(x):
        return _modelled(ephemerides, signal.satellite, times[1], signal.transit[1], x)[0]

    slope = np.array([(at(place + step) - at(place - step)) / 2 for step in np.eye(3)])
    return at(place) - at_base, slope


def _least_squares(measured, ambiguous, ephemerides, times, base_ecef, place):
    """Return the unknowns [step (3), code clocks, carrier clocks, ambiguities] and their normal matrix."""
    groups, keys = list(dict.fromkeys(s.group for s in measured)), _keys(ambiguous)
    n = 3 + 2 * len(groups) + len(keys)
    N, right = np.zeros((n, n)), np.zeros(n)
    for s in measured:
        modelled, slope = _step_of_range(s, ephemerides, times, base_ecef, place)
        for kind, values, sigma in ((0, s.code, 100 * s.sigma), (1, s.phase, s.sigma)):
            row = np.zeros(n)
            row[:3] = slope
            row[3 + kind * len(groups) + groups.index(s.group)] = 1.0
            if kind == 1 and (s.satellite, s.group) in keys:
                row[3 + 2 * len(groups) + keys.index((s.satellite, s.group))] = s.wavelength
            N += np.outer(row, row) / sigma**2
            right += row * (values[1] - values[0] - modelled) / sigma**2
    scale = 1 / np.sqrt(N.diagonal())
    return scale * np.linalg.solve(scale[:, None] * N * scale, scale * right), N


def _fixed_step(measured, integers, ephemerides, times, base_ecef, place):
    """Return the step (3,) to the place that fits the carriers less their integers."""
    groups = list(dict.fromkeys(s.group for s in measured))
    rows, rest = [], []
    for s in measured:
        modelled, slope = _step_of_range(s, ephemerides, times, base_ecef, place)
        clock = [float(group == s.group) for group in groups]
        rows.append([*(slope / s.sigma), *(c / s.sigma for c in clock)])
        rest.append((s.phase[1] - s.phase[0] - modelled - s.wavelength * integers.get((s.satellite, s.group), 0)) / s.sigma)
    return np.linalg.lstsq(np.array(rows), np.array(rest), rcond=None)[0][:3]
