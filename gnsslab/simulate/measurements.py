"""Measurements: geometry, noise and events become what R receivers measure, in dense arrays, not yet rounded."""

from typing import NamedTuple

import numpy as np

from gnsslab.gnss.orbits import group_delay
from gnsslab.gnss.signals import SPEED_OF_LIGHT, frequency
from gnsslab.simulate.events import Axes, gross_errors, half_cycles, silent, slipped_cycles
from gnsslab.simulate.receivers import cn0_at, gauss_markov, hardware_delay, multipath_factor, sends, signals_of, white_factor

_INTEGERS_UP_TO = 100_000  # first ambiguities [cycles]


class Measured(NamedTuple):
    """Measurements of one system: R receivers, T epochs, m satellites, b signals."""

    satellites: tuple  # (m,)
    signals: tuple  # (b,), "1C"
    value: np.ndarray  # (4, R, T, m, b): code [m], carrier [cycles], Doppler [Hz], C/N0 [dB-Hz]; NaN where nothing was measured
    lli: np.ndarray  # (R, T, m, b) uint8, of the carrier
    integers: np.ndarray  # (R, T, m, b) int64, ambiguities [cycles], slips included
    fractions: np.ndarray  # (R, b) [cycles], in [0, 1): a receiver's phase at its start, common to all satellites


def measure(geometry, noise, rng):
    """Return a dictionary from system letter to its `Measured`."""
    letters = np.array([name[0] for name in geometry.tracks.satellites])
    return {str(system): _measure_system(geometry, noise, rng, str(system), np.flatnonzero(letters == system)) for system in np.unique(letters)}


def _measure_system(geometry, noise, rng, system, columns):
    preset, satellites = geometry.preset, tuple(geometry.tracks.satellites[k] for k in columns)
    axes = Axes(preset.receivers, preset.epochs, satellites, signals_of(system, preset.bands))
    integers, fractions, slip_flags = _ambiguities(preset.events, axes, rng)
    halves, half_flags = half_cycles(preset.events, axes)
    elevation = geometry.elevation[..., columns]
    value = _noise_free(geometry, system, columns, axes.signals)
    value[0] += np.reshape([hardware_delay(system, receiver) for receiver in range(preset.receivers)], (-1, 1, 1, 1))
    value[1] += integers + fractions[:, np.newaxis, np.newaxis] + halves
    value += _errors(noise, rng, elevation, preset.interval, system, axes) + gross_errors(preset.events, axes)
    is_recorded = _recorded(preset, elevation, axes)
    lli = np.where(is_recorded, slip_flags | half_flags, 0).astype(np.uint8)
    return Measured(satellites, axes.signals, np.where(is_recorded, value, np.nan), lli, integers, fractions)


def _ambiguities(events, axes, rng):
    """Return integers (R, T, m, b), one at random and the slips after it, fractions (R, b), and the slip flags."""
    first = rng.integers(-_INTEGERS_UP_TO, _INTEGERS_UP_TO + 1, (axes.receivers, 1, len(axes.satellites), len(axes.signals)))
    fractions = rng.random((axes.receivers, len(axes.signals)))
    slipped, flags = slipped_cycles(events, axes, rng)
    return first + slipped, fractions, flags


def _noise_free(geometry, system, columns, signals):
    """Return code, carrier, Doppler and C/N0 (4, R, T, m, b) without noise and ambiguities.

    code = P + T + g I + c delay,  carrier = (P + T - g I) / lambda,  Doppler = -(P' + T' - g I') / lambda,  g = (f_L1 / f)^2;
    the delay is the satellite's group delay in this band, which its clock does not contain.
    """
    f = _frequencies(system, signals)
    wavelength, g = SPEED_OF_LIGHT / f, (frequency("G", "1") / f) ** 2
    parts = (geometry.pseudorange, geometry.rate, geometry.troposphere, geometry.ionosphere)
    P, P_rate, T, iono = (part[..., columns, np.newaxis] for part in parts)
    length = P + T - g * iono
    rate = P_rate + _time_derivative(T - g * iono, geometry.preset.interval)
    delay = _group_delays(geometry.tracks, system, columns, signals)
    cn0 = np.broadcast_to(cn0_at(geometry.elevation[..., columns])[..., np.newaxis], length.shape)
    return np.stack([P + T + g * iono + delay, length / wavelength, -rate / wavelength, cn0])


def _group_delays(tracks, system, columns, signals):
    """Return the group delays (T, m, b) [m]."""
    index, systems = tracks.index[:, columns], [system] * len(columns)
    return SPEED_OF_LIGHT * np.stack([group_delay(tracks.ephemerides, index, systems, signal[0]) for signal in signals], axis=-1)


def _time_derivative(values, interval):
    return np.gradient(values, interval, axis=1) if values.shape[1] > 1 else np.zeros_like(values)


def _errors(noise, rng, elevation, interval, system, axes):
    """Return white noise and multipath (4, R, T, m, b), grown by elevation, in the units of the observations."""
    wavelength = SPEED_OF_LIGHT / _frequencies(system, axes.signals)
    white, multipath = white_factor(elevation)[..., np.newaxis], multipath_factor(elevation)[..., np.newaxis]
    unit = rng.standard_normal((6, *axes.shape))
    reflected_code = gauss_markov(unit[4], interval, noise.code_multipath_time)
    reflected_carrier = gauss_markov(unit[5], interval, noise.carrier_multipath_time)
    code = noise.code * white * unit[0] + noise.code_multipath * multipath * reflected_code
    carrier = noise.carrier * white * unit[1] + noise.carrier_multipath * multipath * reflected_carrier
    return np.stack([code, carrier / wavelength, noise.doppler * white * unit[2] / wavelength, noise.cn0 * unit[3]])


def _recorded(preset, elevation, axes):
    """Return what is recorded (R, T, m, b): a signal that is sent, from above the mask, in no outage and no gap."""
    is_sent = np.array([[sends(satellite, signal) for signal in axes.signals] for satellite in axes.satellites])
    is_up = elevation > np.radians(preset.mask_deg)
    return is_up[..., np.newaxis] & is_sent & ~silent(preset.events, axes)


def _frequencies(system, signals):
    return np.array([frequency(system, signal[0]) for signal in signals])
