"""Dense arrays (T, m), epochs by satellites, out of the tables of observations: the form in which all solving is done."""

from typing import NamedTuple

import numpy as np

from gnsslab.gnss.signals import BANDS, frequency, tracking_letters, wavelength

_NUMBERS = 256  # satellite numbers stay below (SBAS: 20 to 58, the others to 63)


class SignalArrays(NamedTuple):
    """One signal a satellite over all epochs; NaN, or 0 in lli, where nothing was measured."""

    code: np.ndarray  # (T, m) [m]
    phase: np.ndarray  # (T, m) [cycles]
    doppler: np.ndarray  # (T, m) [Hz]
    cn0: np.ndarray  # (T, m) [dB-Hz]
    lli: np.ndarray  # (T, m) uint8, bits SLIP and HALF_CYCLE of the phase


class Dense(NamedTuple):
    """The measurements of m satellites, one signal each, with what the signals are."""

    satellites: tuple  # (m,) names, "G05"
    signals: tuple  # (m,) band and tracking letter, "1C"
    code: np.ndarray  # (T, m) [m]
    phase: np.ndarray  # (T, m) [cycles]
    doppler: np.ndarray  # (T, m) [Hz]
    cn0: np.ndarray  # (T, m) [dB-Hz]
    lli: np.ndarray  # (T, m) uint8

    @property
    def frequency(self):
        """Carrier frequencies (m,) [Hz]."""
        return np.array([frequency(name[0], signal[0]) for name, signal in zip(self.satellites, self.signals, strict=True)])

    @property
    def wavelength(self):
        """Carrier wavelengths (m,) [m]."""
        return np.array([wavelength(name[0], signal[0]) for name, signal in zip(self.satellites, self.signals, strict=True)])

    def part(self, epochs, columns):
        """Return the Dense of some epochs (indices) and some satellites (column indices)."""
        satellites, signals = (tuple(texts[column] for column in columns) for texts in (self.satellites, self.signals))
        return Dense(satellites, signals, *(array[np.ix_(epochs, columns)] for array in self[2:]))


def single_frequency_codes(observations, systems="GECJ"):
    """Return the `Dense` arrays of the first band of each system: what a single-frequency receiver would have measured."""
    return dense(observations, systems, band_rank=0)


def dense(observations, systems="GECJ", band_rank=0):
    """Return the `Dense` arrays of one band (0 first, 1 second, 2 third) of the given systems, satellites in order of system and number.

    Each satellite keeps the one signal it was observed on most often; satellites without a code measurement in the band are left out.
    """
    satellites, signals = [], []
    for system in systems:
        table = observations.tables.get(system)
        if table is not None and system in BANDS and band_rank < len(BANDS[system]):
            chosen = choose_signals(table, BANDS[system][band_rank])
            satellites += chosen.keys()
            signals += chosen.values()
    return Dense(tuple(satellites), tuple(signals), *signal_arrays(observations, satellites, signals))


def choose_signals(table, bands):
    """Return {satellite name: signal}, the signal of the first of the bands the satellite was observed on.

    Within a band the tracking letter with most code and phase measurements wins, ties by the order of
    `signals.tracking_letters`. A satellite without any code in the bands is absent.
    """
    chosen = {}
    for band in bands:
        signals, numbers, counts = signal_counts(table, band)
        for number, row in zip(numbers, counts, strict=True):
            if row.max(initial=0):
                chosen.setdefault(f"{table.system}{number:02d}", signals[int(np.argmax(row))])
    return dict(sorted(chosen.items()))


def signal_counts(table, band):
    """Return the signals (s) of a band, best tracking first, the satellite numbers (m,) and how many measurements each has (m, s).

    A measurement counts once for its code and once more for its phase; a signal without any code counts zero.
    """
    signals = [band + letter for letter in tracking_letters(table.system, band) if f"C{band}{letter}" in table.codes]
    counts = np.zeros((_NUMBERS, len(signals)), dtype=int)
    for i, signal in enumerate(signals):
        codes = _count(table, "C" + signal)
        counts[:, i] = np.where(codes > 0, codes + _count(table, "L" + signal), 0)
    numbers = np.unique(table.number)
    return signals, numbers, counts[numbers]


def signal_arrays(observations, satellites, signals):
    """Return the `SignalArrays` (T, m) of satellite names (m,) and one signal each (m,), such as ("G05", "E11") and ("1C", "1X").

    A satellite may stand twice with different signals. What the receiver never recorded is NaN, or 0 in lli.

    >>> from gnsslab.gnss.observations import ObservationHeader, Observations, SystemTable
    >>> table = SystemTable("G", ("C1C",), np.array([0, 1]), np.array([5, 5]), np.array([[2e7], [3e7]]), *np.zeros((2, 2, 1), np.uint8))
    >>> second = np.datetime64("2024-01-01T00:00:00", "ns") + np.arange(2) * np.timedelta64(1, "s")
    >>> signal_arrays(Observations(second, {"G": table}, ObservationHeader(), np.zeros(2, bool)), ["G05"], ["1C"]).code.tolist()
    [[20000000.0], [30000000.0]]
    """
    shape = (len(observations.time), len(satellites))
    arrays = SignalArrays(*(np.full(shape, np.nan) for _ in range(4)), np.zeros(shape, dtype=np.uint8))
    columns = {}
    for column, (name, signal) in enumerate(zip(satellites, signals, strict=True)):
        columns.setdefault((name[0], signal), []).append((int(name[1:]), column))
    for (system, signal), pairs in columns.items():
        if system in observations.tables:
            _scatter(arrays, observations.tables[system], signal, np.array(pairs))
    return arrays


def _count(table, code):
    """Return how often each satellite number (256,) has a value of an observation code."""
    column = table.column(code)
    if column is None:
        return np.zeros(_NUMBERS, dtype=int)
    return np.bincount(table.number[~np.isnan(table.value[:, column])], minlength=_NUMBERS)


def _scatter(arrays, table, signal, pairs):
    """Write one signal of one table into fresh arrays, in place; pairs (j, 2) of satellite number and column."""
    column_of = np.full(_NUMBERS, -1)
    column_of[pairs[:, 0]] = pairs[:, 1]
    target = column_of[table.number]
    rows = np.flatnonzero(target >= 0)
    where = table.epoch[rows], target[rows]
    for array, kind in zip(arrays[:4], "CLDS", strict=True):
        column = table.column(kind + signal)
        if column is not None:
            array[where] = table.value[rows, column]
    phase = table.column("L" + signal)
    if phase is not None:
        arrays.lli[where] = table.lli[rows, phase]
