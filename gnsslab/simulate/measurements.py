"""Measurements: geometry, noise and events become what R receivers measure, in dense arrays, not yet rounded."""

from typing import NamedTuple

import numpy as np

from gnsslab.gnss.orbits import group_delay
from gnsslab.gnss.signals import SPEED_OF_LIGHT, frequency
from gnsslab.simulate.events import Axes, gross_errors, half_cycles, locked_anew, silent, slipped_cycles
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


class Ideal(NamedTuple):
    """What chance has no part in, of one system: R receivers, T epochs, m satellites, b signals."""

    axes: Axes
    interval: float  # [s], between epochs
    value: np.ndarray  # (4, R, T, m, b) as in Measured, without noise and ambiguities
    halves: np.ndarray  # (R, T, m, b) [cycles], half cycles in the carrier
    half_flags: np.ndarray  # (R, T, m, b) uint8
    gross: np.ndarray  # (4, R, T, m, b), gross errors in the units of the observations
    wavelength: np.ndarray  # (b,) [m]
    white: np.ndarray  # (R, T, m, 1), growth of white noise from the zenith
    multipath: np.ndarray  # (R, T, m, 1), growth of multipath from the zenith
    is_recorded: np.ndarray  # (R, T, m, b) bool


class Draw(NamedTuple):
    """What chance decides, of one system; how large its errors are is not chance's to say."""

    integers: np.ndarray  # (R, T, m, b) int64, ambiguities [cycles], slips included
    fractions: np.ndarray  # (R, b) [cycles]
    slip_flags: np.ndarray  # (R, T, m, b) uint8
    unit: np.ndarray  # (6, R, T, m, b), white noise of unit variance: code, carrier, Doppler, C/N0, multipath of code and of carrier


def measure(geometry, noise, rng):
    """Return a dictionary from system letter to its `Measured`."""
    return disturb(idealise(geometry), draw(geometry, rng), noise)


def idealise(geometry):
    """Return a dictionary from system letter to its `Ideal`."""
    return {system: _ideal(geometry, columns, _axes(geometry, system, columns)) for system, columns in _columns(geometry).items()}


def draw(geometry, rng):
    """Return a dictionary from system letter to its `Draw`, which depends on what is measured and not on where (but for streets, which hide)."""
    return {system: _draw(geometry, columns, _axes(geometry, system, columns), rng) for system, columns in _columns(geometry).items()}


def disturb(ideals, draws, noise):
    """Return a dictionary from system letter to its `Measured`: ideal measurements with the errors drawn, as large as `noise` has them."""
    return {system: _disturbed(ideal, draws[system], noise) for system, ideal in ideals.items()}


def _columns(geometry):
    """Return which satellites (m,) belong to each system, by its letter."""
    letters = np.array([name[0] for name in geometry.tracks.satellites])
    return {str(system): np.flatnonzero(letters == system) for system in np.unique(letters)}


def _axes(geometry, system, columns):
    satellites = tuple(geometry.tracks.satellites[k] for k in columns)
    return Axes(geometry.preset.receivers, geometry.preset.epochs, satellites, signals_of(system, geometry.preset.bands))


def _ideal(geometry, columns, axes):
    preset, system, elevation = geometry.preset, axes.satellites[0][0], geometry.elevation[..., columns]
    value = _noise_free(geometry, system, columns, axes.signals)
    value[0] += np.reshape([hardware_delay(system, receiver) for receiver in range(preset.receivers)], (-1, 1, 1, 1))
    halves, half_flags = half_cycles(preset.events, axes)
    return Ideal(
        axes=axes,
        interval=preset.interval,
        value=value,
        halves=halves,
        half_flags=half_flags,
        gross=gross_errors(preset.events, axes),
        wavelength=SPEED_OF_LIGHT / _frequencies(system, axes.signals),
        white=white_factor(elevation)[..., np.newaxis],
        multipath=multipath_factor(elevation)[..., np.newaxis],
        is_recorded=_recorded(preset, elevation, axes) & ~geometry.hidden[..., columns, np.newaxis],
    )


def _draw(geometry, columns, axes, rng):
    return Draw(*_ambiguities(geometry.preset.events, geometry.hidden[..., columns], axes, rng), rng.standard_normal((6, *axes.shape)))


def _disturbed(ideal, drawn, noise):
    value = ideal.value.copy()
    value[1] += drawn.integers + drawn.fractions[:, np.newaxis, np.newaxis] + ideal.halves
    value += _errors(ideal, drawn.unit, noise) + ideal.gross
    lli = np.where(ideal.is_recorded, drawn.slip_flags | ideal.half_flags, 0).astype(np.uint8)
    value = np.where(ideal.is_recorded, value, np.nan)
    return Measured(ideal.axes.satellites, ideal.axes.signals, value, lli, drawn.integers, drawn.fractions)


def _ambiguities(events, hidden, axes, rng):
    """Return integers (R, T, m, b), one at random and the slips after it, fractions (R, b), and the slip flags (R, T, m, b)."""
    first = rng.integers(-_INTEGERS_UP_TO, _INTEGERS_UP_TO + 1, (axes.receivers, 1, len(axes.satellites), len(axes.signals)))
    fractions = rng.random((axes.receivers, len(axes.signals)))
    slipped, flags = slipped_cycles(events, axes, rng)
    anew, anew_flags = locked_anew(hidden, axes, rng)
    return first + slipped + anew, fractions, flags | anew_flags


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


def _errors(ideal, unit, noise):
    """Return white noise and multipath (4, R, T, m, b), grown by elevation, in the units of the observations."""
    reflected_code = gauss_markov(unit[4], ideal.interval, noise.code_multipath_time)
    reflected_carrier = gauss_markov(unit[5], ideal.interval, noise.carrier_multipath_time)
    code = noise.code * ideal.white * unit[0] + noise.code_multipath * ideal.multipath * reflected_code
    carrier = noise.carrier * ideal.white * unit[1] + noise.carrier_multipath * ideal.multipath * reflected_carrier
    return np.stack([code, carrier / ideal.wavelength, noise.doppler * ideal.white * unit[2] / ideal.wavelength, noise.cn0 * unit[3]])


def _recorded(preset, elevation, axes):
    """Return what is recorded (R, T, m, b): a signal that is sent, from above the mask, in no outage and no gap."""
    is_sent = np.array([[sends(satellite, signal) for signal in axes.signals] for satellite in axes.satellites])
    is_up = elevation > np.radians(preset.mask_deg)
    return is_up[..., np.newaxis] & is_sent & ~silent(preset.events, axes)


def _frequencies(system, signals):
    return np.array([frequency(system, signal[0]) for signal in signals])
