"""Recording: dense measurements become the `Observations` of a receiver, each value as a RINEX file holds it."""

import numpy as np

from gnsslab.gnss.observations import ObservationHeader, Observations, SystemTable
from gnsslab.gnss.signals import USED_SYSTEMS
from gnsslab.simulate.events import KINDS
from gnsslab.simulate.geometry import antenna_position

_DECIMALS = 1000.0  # RINEX writes three: 1 mm, 0.001 cycles, 0.001 Hz
_DB_PER_CLASS = 6.0  # signal strength class = C/N0 / 6 dB-Hz, from 1 to 9 (RINEX 3.04, section 5.7)


def record(preset, measured, receiver):
    """Return the `Observations` of one receiver; epochs at which nothing was recorded are absent, as from a file."""
    tables = [_table(system, measured[system], receiver) for system in USED_SYSTEMS if system in measured]
    tables = [table for table in tables if len(table.epoch)]
    epochs = np.unique(np.concatenate([np.zeros(0, dtype=np.int32), *(table.epoch for table in tables)]))
    renumbered = {table.system: _with_epochs(table, np.searchsorted(epochs, table.epoch)) for table in tables}
    no_failure = np.zeros(len(epochs), dtype=bool)
    return Observations(preset.time[epochs], renumbered, _header(preset, receiver), no_failure, source=f"simulated: {preset.name}")


def _table(system, measured, receiver):
    values = np.moveaxis(measured.value[:, receiver], 0, -1)  # (T, m, b, 4)
    epoch, column = np.nonzero(np.isfinite(values[..., 0]).any(axis=-1))
    number = np.array([int(name[1:]) for name in measured.satellites], dtype=np.int16)
    codes = tuple(kind + signal for signal in measured.signals for kind in KINDS)
    value = _rounded(values[epoch, column]).reshape(len(epoch), len(codes))
    lli = np.zeros(value.shape, dtype=np.uint8)
    lli[:, 1 :: len(KINDS)] = measured.lli[receiver][epoch, column]
    return SystemTable(system, codes, epoch.astype(np.int32), number[column], value, lli, _strength_classes(value))


def _with_epochs(table, epoch):
    return SystemTable(table.system, table.codes, epoch.astype(np.int32), table.number, table.value, table.lli, table.ssi)


def _rounded(value):
    """Round to three decimals, to the very number that reading the decimals back gives; a negative zero becomes zero."""
    return np.rint(value * _DECIMALS) / _DECIMALS + 0.0


def _strength_classes(value):
    """Return signal strength classes (k, n): beside code and carrier the one of their C/N0, 0 elsewhere."""
    cn0 = value[:, 3 :: len(KINDS)]
    classes = np.where(np.isfinite(cn0), np.clip(cn0 // _DB_PER_CLASS, 1, 9), 0).astype(np.uint8)
    ssi = np.zeros(value.shape, dtype=np.uint8)
    ssi[:, 0 :: len(KINDS)] = ssi[:, 1 :: len(KINDS)] = classes
    return ssi


def _header(preset, receiver):
    """Return the header; the position is the antenna's at the start, to the 0.1 mm a header holds."""
    position = np.round(antenna_position(preset, receiver, np.zeros(1))[0], 4)
    first_on_body = int(preset.base is not None)
    marker = "BASE" if receiver < first_on_body else f"ANT{receiver + 1 - first_on_body}"
    return ObservationHeader(marker=marker, receiver="gnsslab simulator", antenna="NONE", position_ecef=position, interval=preset.interval)
