"""Measured minus geometric at three levels: undifferenced, single difference, double difference."""

from typing import NamedTuple

import numpy as np

from gnsslab.gnss.differences import difference_operator
from gnsslab.gnss.orbits import rotate_to_reception, satellite_states
from gnsslab.gnss.signals import SPEED_OF_LIGHT


class Levels(NamedTuple):
    """Series of T epochs, of satellite s and reference satellite r, measured minus geometric; NaN where nothing was measured."""

    undifferenced: np.ndarray  # (4, T) [m]: master s, master r, rover s, rover r
    single: np.ndarray  # (2, T) [m], rover minus master: s, r
    double: np.ndarray  # (1, T) [m], s minus r


def levels_of(residual, satellite, reference):
    """Return the Levels of residuals (2, T, m) [m], master and rover, for two of the m satellites (indices).

    >>> clock_of_rover = np.zeros((2, 1, 3)) + np.array([0.0, 5.0])[:, None, None]
    >>> [level.ravel().tolist() for level in levels_of(clock_of_rover, 2, 0)]
    [[0.0, 0.0, 5.0, 5.0], [5.0, 5.0], [0.0]]
    """
    pair = residual[:, :, [satellite, reference]]
    single = pair[1] - pair[0]  # (T, 2): what the satellites' clocks did is gone
    double = single @ difference_operator(2, 1).T  # (T, 1): what the receivers' clocks did is gone
    return Levels(pair.transpose(0, 2, 1).reshape(4, -1), single.T, double.T)


def traced_by_code(ephemerides, satellites, time, receiver_ecef, code):
    """Return ranges (T, m) [m] from a receiver at rest (3,), and the SatelliteStates, at the times of transmission that its code [m] tells.

    However wrong the receiver's clock is, tag minus code / c is when the signal left.
    """
    states = satellite_states(ephemerides, satellites, time, code / SPEED_OF_LIGHT)
    return _ranges(states, receiver_ecef), states


def traced_by_tags(ephemerides, satellites, time, receiver_ecef, code):
    """Return ranges (T, m) [m] and SatelliteStates as if the receiver's time tags were GPS time: a clock error moves the satellites.

    A satellite's range changes by up to 800 m/s: 0.8 m in a millisecond.
    """
    rho, states = traced_by_code(ephemerides, satellites, time, receiver_ecef, code)
    states = satellite_states(ephemerides, satellites, time, rho / SPEED_OF_LIGHT - states.clock, states.index)
    return _ranges(states, receiver_ecef), states


def grain(series):
    """Return the standard deviation [m] of a level (k, T) about a smooth curve, and the series less that curve (a parabola each).

    Clocks that drift and an atmosphere that changes within minutes are smooth; noise is not. Three of the T epochs go into the curve.
    """
    rest = np.stack([one - _parabola(one) for one in series])
    counted = np.maximum(np.isfinite(rest).sum(axis=1) - 3, 1)
    return float(np.sqrt(np.mean(np.nansum(rest**2, axis=1) / counted))), rest


def _parabola(values):
    """Return the parabola (T,) that fits values (T,) best, NaN where there are not four of them."""
    t = np.linspace(-1.0, 1.0, len(values))
    known = np.isfinite(values)
    if known.sum() < 4:
        return np.full(len(values), np.nan)
    middle = values[known].mean()  # taken off first: 100 km of clock would leave micrometres of rounding
    A = np.vander(t, 3)
    return middle + A @ np.linalg.lstsq(A[known], values[known] - middle)[0]


def _ranges(states, receiver_ecef):
    """Return distances (T, m) [m] in the frame of reception."""
    travel = np.linalg.norm(states.position - receiver_ecef, axis=-1) / SPEED_OF_LIGHT
    return np.linalg.norm(rotate_to_reception(states.position, travel) - receiver_ecef, axis=-1)
