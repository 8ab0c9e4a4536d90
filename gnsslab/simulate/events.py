"""Events: what happens to receivers at certain epochs, each a frozen record.

Epochs count from 0. Antennas are counted as the observation files are: 0 is the master (or the base), 1 the rover. Where
no antennas, satellites or signals are named, all of them are meant.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from gnsslab.gnss.observations import HALF_CYCLE, SLIP

KINDS = "CLDS"  # of observations, in the order in which they stand in files and in our arrays
_SLIPS_UP_TO = 20  # [cycles], of a slip at random


@dataclass(frozen=True)
class Slip:
    """From this epoch on the carrier phase is off by whole cycles (0: at random from 1 to 20 either way, each signal its own)."""

    epoch: int
    antennas: tuple[int, ...] = ()
    satellites: tuple[str, ...] = ()
    signals: tuple[str, ...] = ()  # "1C", "2W"...
    cycles: int = 0
    is_flagged: bool = True  # whether the receiver notices and says so


@dataclass(frozen=True)
class HalfCycle:
    """From first to last epoch the receiver does not know the sign of the carrier: half a cycle too much, flagged."""

    first: int
    last: int
    antennas: tuple[int, ...] = ()
    satellites: tuple[str, ...] = ()
    signals: tuple[str, ...] = ()


@dataclass(frozen=True)
class Outage:
    """From first to last epoch there is no signal (a bridge, a tree); after that lock is new, and flagged so."""

    first: int
    last: int
    antennas: tuple[int, ...] = ()
    satellites: tuple[str, ...] = ()
    signals: tuple[str, ...] = ()


@dataclass(frozen=True)
class Street:
    """From first to last epoch houses stand on both sides of the way; what they hide is lost, and lock is new when it is seen again.

    They follow the body's heading psi: a satellite of azimuth alpha is hidden where tan el < tan(roofs) |sin(alpha - psi)|, so
    straight ahead and behind the sky is open down to the horizon. A hidden signal is gone; reflections of it there are none.
    """

    first: int
    last: int
    roofs_deg: float = 50.0  # elevation of the roofs, seen straight across
    antennas: tuple[int, ...] = ()


@dataclass(frozen=True)
class Gap:
    """From first to last epoch nothing is recorded (a full buffer, a broken link); tracking goes on and the phase continues."""

    first: int
    last: int
    antennas: tuple[int, ...] = ()
    satellites: tuple[str, ...] = ()
    signals: tuple[str, ...] = ()


@dataclass(frozen=True)
class GrossError:
    """One wrong measurement at one epoch: `error` is added to the observation `code`, in its unit (C metres, L cycles, D hertz, S dB-Hz)."""

    epoch: int
    code: str  # "C1C", "L2W"...
    error: float
    antennas: tuple[int, ...] = (1,)
    satellites: tuple[str, ...] = ()

    @property
    def signals(self):
        """The one signal concerned."""
        return (self.code[1:],)


class Axes(NamedTuple):
    """What the axes (R, T, m, b) of arrays of measurements stand for."""

    receivers: int
    epochs: int
    satellites: tuple[str, ...]
    signals: tuple[str, ...]

    @property
    def shape(self):
        """The shape (R, T, m, b)."""
        return self.receivers, self.epochs, len(self.satellites), len(self.signals)


def event_claims(event, epochs, receivers, systems):
    """Yield what must be true of an event in a preset, and the sentence to say where it is not."""
    first, last = _span(event)
    yield 0 <= first <= last < epochs, f"{event} lies outside the epochs 0 to {epochs - 1}; move it or make the preset longer"
    yield set(event.antennas) <= set(range(receivers)), f"{event} names an antenna that is not there; they are 0 to {receivers - 1}"
    yield all(name[:1] in systems for name in getattr(event, "satellites", ())), f"{event} names a satellite of none of the systems {systems}"
    if isinstance(event, GrossError):
        yield event.code[:1] in KINDS and len(event.code) == 3, f"{event}: an observation code is C, L, D or S and a signal, as in 'C1C'"
    if isinstance(event, Street):
        yield 0 <= event.roofs_deg < 90, f"{event}: the elevation of the roofs is from 0 to below 90 degrees"


def concerned(event, axes, first, last):
    """Return a mask (R, T, m, b) of what an event concerns from first to last epoch."""
    epoch = np.arange(axes.epochs)
    receiver = _named(event.antennas, range(axes.receivers))
    satellite, signal = _named(event.satellites, axes.satellites), _named(event.signals, axes.signals)
    moment = (first <= epoch) & (epoch <= last)
    return receiver[:, None, None, None] & moment[:, None, None] & satellite[:, None] & signal


def slipped_cycles(events, axes, rng):
    """Return the whole cycles (R, T, m, b) int64 by which the phase is off at each epoch, and the SLIP flags (R, T, m, b) uint8."""
    steps, flags = np.zeros(axes.shape, dtype=np.int64), np.zeros(axes.shape, dtype=np.uint8)
    for event in events:
        if isinstance(event, Slip | Outage):
            start = _span(event)[1] + isinstance(event, Outage)  # an outage: when the signal is back
            where = concerned(event, axes, start, start)
            steps += where * _slip_sizes(event, axes, rng)[:, np.newaxis]
            flags[where & getattr(event, "is_flagged", True)] = SLIP
    return np.cumsum(steps, axis=1), flags


def half_cycles(events, axes):
    """Return the half cycles (R, T, m, b) in the phase and the HALF_CYCLE flags; when half a cycle comes or goes a slip is flagged too."""
    where = _any_of(events, HalfCycle, axes)
    changes = np.diff(where, axis=1, prepend=False)
    return 0.5 * where, HALF_CYCLE * where.astype(np.uint8) + SLIP * changes.astype(np.uint8)


def silent(events, axes):
    """Return the mask (R, T, m, b) of what is not recorded: outages and gaps."""
    return _any_of(events, Outage | Gap, axes)


def hidden_by_streets(events, receiver, heading, azimuth, elevation):
    """Return the mask (T, m) of the satellites hidden from a receiver with heading (T,) [rad]: azimuth, elevation (T, m) [rad].

    >>> east = np.array([[np.pi / 2]])
    >>> [hidden_by_streets((Street(0, 0),), 0, np.array([heading]), east, 0.5 * np.ones((1, 1))).item() for heading in (0.0, np.pi / 2)]
    [True, False]
    """
    hidden, epoch = np.zeros(elevation.shape, dtype=bool), np.arange(len(heading))
    across = np.abs(np.sin(azimuth - heading[:, np.newaxis]))
    for event in events:
        if isinstance(event, Street) and (not event.antennas or receiver in event.antennas):
            is_inside = (event.first <= epoch) & (epoch <= event.last)
            hidden |= is_inside[:, np.newaxis] & (np.tan(elevation) < np.tan(np.radians(event.roofs_deg)) * across)
    return hidden


def locked_anew(hidden, axes, rng):
    """Return cycles (R, T, m, b) int64 and SLIP flags uint8 after satellites were hidden (R, T, m): none where nothing was."""
    cycles, flags = np.zeros(axes.shape, dtype=np.int64), np.zeros(axes.shape, dtype=np.uint8)
    if hidden.any():
        is_back = np.diff(hidden.astype(np.int8), axis=1, prepend=0) < 0
        flags[is_back] = SLIP
        cycles[is_back] = _random_slips(rng, cycles[is_back].shape)
    return np.cumsum(cycles, axis=1), flags


def gross_errors(events, axes):
    """Return what gross errors add to code, carrier, Doppler and C/N0 (4, R, T, m, b), each in its unit."""
    added = np.zeros((len(KINDS), *axes.shape))
    for event in events:
        if isinstance(event, GrossError):
            added[KINDS.index(event.code[0])] += event.error * concerned(event, axes, event.epoch, event.epoch)
    return added


def _span(event):
    return (event.epoch, event.epoch) if isinstance(event, Slip | GrossError) else (event.first, event.last)


def _named(names, everything):
    return np.array([not names or one in names for one in everything], dtype=bool)


def _slip_sizes(event, axes, rng):
    """Return cycles (R, m, b): as the event says or at random, of its own for each receiver, satellite and signal."""
    shape = (axes.receivers, len(axes.satellites), len(axes.signals))
    if getattr(event, "cycles", 0):
        return np.full(shape, event.cycles)
    return _random_slips(rng, shape)


def _random_slips(rng, shape):
    return rng.integers(1, _SLIPS_UP_TO + 1, shape) * rng.choice([-1, 1], shape)


def _any_of(events, kind, axes):
    where = np.zeros(axes.shape, dtype=bool)
    for event in events:
        if isinstance(event, kind):
            where |= concerned(event, axes, *_span(event))
    return where
