"""Observations made by hand: a few satellites with chosen signals, and simulated pairs of receivers."""

from dataclasses import replace

import numpy as np

from gnsslab.gnss.observations import ObservationHeader, Observations, SystemTable
from gnsslab.simulate import find_preset

START = np.datetime64("2024-06-24T08:20:00", "ns")
MILLISECOND = np.timedelta64(1, "ms")


def times(milliseconds):
    """Return time tags (T,) at so many milliseconds after the start."""
    return START + np.asarray(milliseconds) * MILLISECOND


def receiver(signals, T=4, milliseconds=None):
    """Return Observations in which every satellite has its signals, {"G05": ("1C", "2W")}, at every epoch.

    A signal may come with the epochs at which it was recorded, ("1C", (0, 3)). The code of number p at epoch t is
    2e7 + 1000 p + t [m] plus the signal's rank, the phase that plus 0.25 [cycles].
    """
    time = times(np.arange(T) * 1000 if milliseconds is None else milliseconds)
    tables = {system: _table(system, {k: v for k, v in signals.items() if k[0] == system}, len(time)) for system in {name[0] for name in signals}}
    return Observations(time, tables, ObservationHeader(), np.zeros(len(time), dtype=bool), source="made by hand")


def _table(system, signals, T):
    wanted = {name: [entry if isinstance(entry, tuple) else (entry, range(T)) for entry in entries] for name, entries in signals.items()}
    names = sorted({signal for entries in wanted.values() for signal, _ in entries})
    codes = tuple(kind + name for name in names for kind in "CLDS")
    rows = [(t, int(name[1:]), entries) for t in range(T) for name, entries in sorted(wanted.items())]
    value = np.full((len(rows), len(codes)), np.nan)
    for row, (t, number, entries) in enumerate(rows):
        for signal, epochs in entries:
            if t in epochs:
                rank = names.index(signal)
                code = 2e7 + 1000 * number + t + rank
                value[row, 4 * rank : 4 * rank + 4] = code, code + 0.25, -1.0, 45.0
    epoch, number = (np.array([row[i] for row in rows]) for i in (0, 1))
    flags = np.zeros(value.shape, dtype=np.uint8)
    return SystemTable(system, codes, epoch.astype(np.int32), number.astype(np.int16), value, flags, flags.copy())


def with_flag(observations, satellite, code, epoch, bits):
    """Return the observations with these loss-of-lock bits at one measurement."""
    table = observations.tables[satellite[0]]
    lli = table.lli.copy()
    row = np.flatnonzero((table.epoch == epoch) & (table.number == int(satellite[1:])))
    assert len(row) == 1, "no such measurement"
    lli[row, table.column(code)] |= bits
    return replace(observations, tables={**observations.tables, satellite[0]: replace(table, lli=lli)})


def short_preset(**changes):
    """Return one minute of two antennas on a roof, GPS only, changed as wished."""
    return replace(find_preset("static-baseline"), **{"duration": 60.0, "systems": "G", **changes})
