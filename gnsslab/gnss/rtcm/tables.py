"""From the cells of MSM messages to the tables of `Observations`: rows of satellites, columns of signals, loss-of-lock flags."""

import numpy as np

from gnsslab.gnss.observations import HALF_CYCLE, SLIP, SystemTable
from gnsslab.gnss.rtcm.glonass import CHANNEL_STEP, channel_table
from gnsslab.gnss.rtcm.lock_times import has_slipped
from gnsslab.gnss.rtcm.msm import Cells, signal_name
from gnsslab.gnss.signals import SPEED_OF_LIGHT, SYSTEM_NAMES, frequency

_MILLISECOND = np.timedelta64(1, "ms")


def observation_table(system, cells, epoch, time, channels):
    """Return the `SystemTable` of a system, and notes.

    epoch (M,): index of each message's epoch; time (T,): labels of the epochs; channels: satellite number -> GLONASS
    frequency channel. A phase slipped where `lock_times.has_slipped` says so of the two last measurements of its signal.
    """
    cells, unknown = _of_known_signals(system, cells)
    cells, epoch = _pick(cells, _is_measured(cells)), epoch[cells.message[_is_measured(cells)]]
    cells, epoch, twice = _in_order_once(cells, epoch)
    elapsed = (time - time[0]) / _MILLISECOND if len(time) else np.empty(0)  # [ms]
    wavelengths = _wavelengths(system, cells, channels)
    flags = np.where(_slips(cells, elapsed[epoch]), SLIP, 0) | np.where(cells.is_half, HALF_CYCLE, 0)
    columns = {
        "C": cells.code,
        "L": cells.phase / wavelengths,
        "D": -cells.rate / wavelengths,
        "S": cells.cn0,
    }
    table = _filled(system, cells, epoch, columns, flags)
    return table, (*unknown, *twice, *_channel_note(wavelengths, cells))


def _pick(cells, which):
    return Cells(*(field[which] for field in cells))


def _of_known_signals(system, cells):
    """Return the cells of signals that have a name, and what is to be said of the others."""
    numbers, count = np.unique(cells.signal, return_counts=True)
    strange = {int(k): int(n) for k, n in zip(numbers, count, strict=True) if not signal_name(system, int(k))}
    words = ", ".join(f"{k} ({n})" for k, n in strange.items())
    note = [f"signals of {SYSTEM_NAMES[system]} that are not known here were left out, with the number of measurements: {words}"] if strange else []
    return _pick(cells, ~np.isin(cells.signal, list(strange))), note


def _is_measured(cells):
    return np.isfinite(cells.code) | np.isfinite(cells.phase)


def _in_order_once(cells, epoch):
    """Return cells and epochs sorted by epoch, satellite and signal, of equal ones the first, and a note on the others."""
    key = (epoch.astype(np.int64) * 100 + cells.number) * 100 + cells.signal
    first = np.unique(key, return_index=True)[1]
    repeated = len(key) - len(first)
    note = [f"measurements given a second time at the same time: {repeated}; the first were kept"] if repeated else []
    return _pick(cells, first), epoch[first], note


def _wavelengths(system, cells, channels):
    """Return the wavelength [m] of each cell; NaN for GLONASS satellites of unknown channel."""
    carrier, step = np.zeros(33), np.zeros(33)
    for signal in np.unique(cells.signal).tolist():
        band = signal_name(system, signal)[0]
        carrier[signal], step[signal] = frequency(system, band), CHANNEL_STEP.get(band, 0.0)
    hertz = carrier[cells.signal]
    if system == "R":
        hertz = hertz + channel_table(channels)[cells.number] * step[cells.signal]
    return SPEED_OF_LIGHT / hertz


def _channel_note(wavelengths, cells):
    without = np.unique(cells.number[np.isnan(wavelengths)])
    names = " ".join(f"R{number:02d}" for number in without)
    return [f"no message says the frequency channels of {names}: their phases are left out"] if len(without) else []


def _slips(cells, elapsed):
    """Return which phases (k,) lost lock since the measurement before of the same signal; elapsed (k,): time [ms]."""
    slipped = np.zeros(len(elapsed), dtype=bool)
    order = np.lexsort((elapsed, cells.signal, cells.number))
    order = order[np.isfinite(cells.phase[order])]
    before, now = order[:-1], order[1:]
    same = (cells.number[before] == cells.number[now]) & (cells.signal[before] == cells.signal[now])
    slipped[now] = same & has_slipped(cells.shortest[before], cells.longest[now], elapsed[now] - elapsed[before])
    return slipped


def _filled(system, cells, epoch, columns, flags):
    """Return the `SystemTable` of cells in order: columns signal by signal, those without any value left out."""
    key = epoch.astype(np.int64) * 100 + cells.number
    first, row = np.unique(key, return_index=True, return_inverse=True)[1:]
    signals, place = np.unique(cells.signal, return_inverse=True)
    codes = tuple(kind + signal_name(system, signal) for signal in signals.tolist() for kind in columns)
    value = np.full((len(first), len(codes)), np.nan)
    lli = np.zeros(value.shape, dtype=np.uint8)
    for k, (kind, measured) in enumerate(columns.items()):
        value[row, place * len(columns) + k] = measured
        if kind == "L":
            lli[row, place * len(columns) + k] = np.where(np.isfinite(measured), flags, 0)
    used = np.isfinite(value).any(axis=0)
    codes = tuple(code for code, is_used in zip(codes, used, strict=True) if is_used)
    ssi = np.zeros((len(first), len(codes)), dtype=np.uint8)
    return SystemTable(system, codes, epoch[first].astype(np.int32), cells.number[first], value[:, used], lli[:, used], ssi)
