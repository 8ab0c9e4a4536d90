"""Receivers: the signals they track, their noise and their clocks."""

from dataclasses import dataclass, fields

import numpy as np

# Signals of the first, second and third band, named as in RINEX 3; the second generation of BeiDou sends B2I, the third B2a.
SIGNALS = {
    "G": (("1C",), ("2W",), ("5Q",)),
    "E": (("1C",), ("5Q",), ("7Q",)),
    "C": (("2I",), ("6I",), ("7I", "5P")),
    "J": (("1C",), ("2L",), ("5Q",)),
}
_GPS_WITH_L5 = frozenset((1, 3, 4, 6, 8, 9, 10, 11, 14, 18, 23, 24, 25, 26, 27, 28, 30, 32))  # blocks IIF and III, as of 2024
_LAST_OF_BEIDOU_2 = 18
_HARDWARE_DELAY = {"G": 0.0, "J": 0.4, "E": 3.1, "C": -11.7}  # [m], of usual size
_NEGLIGIBLE = 1e-17  # a weight below this changes no double
_LOWEST = np.radians(1.0)  # the laws by elevation stop growing here


@dataclass(frozen=True)
class Noise:
    """Standard deviations of one antenna's raw measurements at the zenith, the same on every signal; all in SI units.

    White noise grows towards the horizon as sqrt(1/2 + 1/(2 sin^2 el)), multipath as 1/sin el. Multipath is a first-order
    Gauss-Markov series with its correlation time [s], of its own for each satellite, signal and receiver.
    """

    code: float = 0.3  # [m]
    carrier: float = 0.001  # [m]
    doppler: float = 0.03  # [m/s], as range rate
    code_multipath: float = 0.2  # [m]
    code_multipath_time: float = 20.0  # [s]
    carrier_multipath: float = 0.0015  # [m]
    carrier_multipath_time: float = 60.0  # [s]
    cn0: float = 0.5  # [dB-Hz]

    def __post_init__(self):
        for each in fields(self):
            value = getattr(self, each.name)
            is_time = each.name.endswith("_time")
            if not np.isfinite(value) or value < 0 or (is_time and value == 0):
                limit = "a time above zero [s]" if is_time else "zero or a positive number (it is a standard deviation)"
                raise ValueError(f"noise {each.name!r} must be {limit}; it is {value}")


SURVEY = Noise()  # a geodetic receiver and antenna on a good site
LOW_COST = Noise(code=0.6, carrier=0.002, doppler=0.05, code_multipath=0.4, carrier_multipath=0.003)  # a patch antenna on a car's roof
NO_NOISE = Noise(code=0.0, carrier=0.0, doppler=0.0, code_multipath=0.0, carrier_multipath=0.0, cn0=0.0)


@dataclass(frozen=True)
class Clock:
    """A receiver's clock: its error dt = offset + drift * t, t [s] since the start, kept within half a `jump` where it is set back by jumps.

    The receiver stamps t_r and measures at GPS time t_r - dt.

    >>> Clock(offset=0.0, drift=1e-4, jump=1e-3).error(np.array([4.0, 6.0])).round(6)
    array([ 0.0004, -0.0004])
    """

    offset: float = 0.0  # [s]
    drift: float = 0.0  # [s/s]
    jump: float = 0.0  # [s], 0: never set back; cheap receivers step by 1 ms

    def error(self, seconds):
        """Return dt (T,) [s] at receiver time tags seconds (T,) after the start."""
        free = self.offset + self.drift * np.asarray(seconds, dtype=float)
        return free - self.jump * np.round(free / self.jump) if self.jump else free


def signals_of(system, bands):
    """Return the names of a system's signals in its first `bands` bands.

    >>> signals_of("C", 3)
    ('2I', '6I', '7I', '5P')
    """
    return tuple(signal for band in SIGNALS[system][:bands] for signal in band)


def sends(satellite, signal):
    """Say whether a satellite sends a signal: L5 came with Block IIF, B2I went with BeiDou's second generation.

    >>> sends("G01", "5Q"), sends("G02", "5Q"), sends("C19", "7I")
    (True, False, False)
    """
    system, number = satellite[0], int(satellite[1:])
    if system == "G":
        return signal != "5Q" or number in _GPS_WITH_L5
    if system == "C" and signal in ("7I", "5P"):
        return (number <= _LAST_OF_BEIDOU_2) == (signal == "7I")
    return True


def hardware_delay(system, receiver):
    """Return the delay [m] of a system's codes in the k-th receiver, against GPS: what makes inter-system biases; no two receivers have the same.

    >>> hardware_delay("G", 1), hardware_delay("E", 0)
    (0.0, 3.1)
    """
    return _HARDWARE_DELAY[system] * (1 + 0.25 * receiver)


def white_factor(elevation):
    """Return how much white noise has grown at elevations [rad] from the zenith: sqrt(1/2 + 1/(2 sin^2 el)).

    >>> white_factor(np.radians([90.0, 30.0])).round(4).tolist()
    [1.0, 1.5811]
    """
    return np.sqrt(0.5 + 0.5 / np.sin(np.maximum(elevation, _LOWEST)) ** 2)


def multipath_factor(elevation):
    """Return how much multipath has grown at elevations [rad] from the zenith: 1/sin el.

    >>> multipath_factor(np.radians([90.0, 30.0])).round(4).tolist()
    [1.0, 2.0]
    """
    return 1 / np.sin(np.maximum(elevation, _LOWEST))


def cn0_at(elevation):
    """Return the usual carrier-to-noise density [dB-Hz] at elevations [rad]: from 32 at the horizon to 50 at the zenith.

    >>> cn0_at(np.radians([90.0, 30.0])).tolist()
    [50.0, 41.0]
    """
    return np.round(32.0 + 18.0 * np.sin(elevation), 9)


def gauss_markov(white, interval, correlation_time):
    """Turn white unit noise (..., T, m, n), time third from last, into a stationary series of unit variance and correlation exp(-dt / tau).

    x_k = a x_{k-1} + sqrt(1 - a^2) w_k,  a = exp(-interval / correlation_time),  x_0 = w_0.

    The recursion is the filter 1 / (1 - a B), B one step back, and 1 / (1 - a B) = (1 + a B)(1 + a^2 B^2)(1 + a^4 B^4)...:
    a factor is one operation on the whole array, and ten reach back over a thousand epochs.

    >>> gauss_markov(np.ones((2, 1, 1)), 1.0, 1.0)[1].round(4).item()         # 0.3679 + sqrt(1 - 0.1353)
    1.2978
    """
    a = np.exp(-interval / correlation_time)
    series = np.array(white, dtype=float)
    series[..., 1:, :, :] *= np.sqrt(1 - a * a)
    back = 1
    while back < series.shape[-3] and a > _NEGLIGIBLE:
        series[..., back:, :, :] += a * series[..., :-back, :, :]
        back, a = 2 * back, a * a
    return series
