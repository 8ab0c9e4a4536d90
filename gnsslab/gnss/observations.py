"""Observations: everything one receiver measured, as read from a file or made by the simulator.

The measurements of one system stand in one table with a row for each satellite and epoch that was recorded and a
column for each observation code. Sparse in time (a satellite below the horizon costs nothing), dense in signals.
"""

from dataclasses import dataclass, field

import numpy as np

SLIP = 1  # bit of the loss-of-lock indicator: the cycle count was interrupted since the last epoch
HALF_CYCLE = 2  # bit of the loss-of-lock indicator: the phase may be off by half a cycle


@dataclass(frozen=True, eq=False)
class SystemTable:
    """Measurements of one satellite system: k rows (satellite, epoch) and n observation codes.

    Rows are sorted by epoch, then by satellite number.
    """

    system: str  # letter: G, R, E, C, J, S or I
    codes: tuple[str, ...]  # (n,) RINEX 3 observation codes: "C1C", "L1C", "D1C", "S1C"...
    epoch: np.ndarray  # (k,) int32, index into Observations.time
    number: np.ndarray  # (k,) int16, satellite number as in the satellite's name
    value: np.ndarray  # (k, n) float64: C [m], L [cycles], D [Hz], S [dB-Hz]; NaN where nothing was measured
    lli: np.ndarray  # (k, n) uint8, loss-of-lock bits SLIP and HALF_CYCLE
    ssi: np.ndarray  # (k, n) uint8, signal strength class 1 to 9, 0 where not given

    @property
    def satellites(self):
        """Names of the satellites with at least one row, sorted: ("G01", "G05")."""
        return tuple(f"{self.system}{number:02d}" for number in np.unique(self.number))

    def column(self, code):
        """Return the index of an observation code, or None where the table has no such column."""
        return self.codes.index(code) if code in self.codes else None


@dataclass(frozen=True, eq=False)
class ObservationHeader:
    """What the file says about the station; absent entries are None or empty."""

    version: float = 3.04
    marker: str = ""
    receiver: str = ""  # receiver type
    antenna: str = ""  # antenna type
    position_ecef: np.ndarray | None = None  # (3,) [m], approximate marker position
    antenna_delta_enu: np.ndarray = field(default_factory=lambda: np.zeros(3))  # (3,) [m], reference point above marker
    interval: float | None = None  # [s]
    time_scale: str = "GPS"  # scale the file was written in; the times here are GPS time already
    glonass_channels: dict[str, int] = field(default_factory=dict)  # "R05" -> frequency channel


@dataclass(frozen=True, eq=False)
class Observations:
    """All measurements of one receiver over T epochs."""

    time: np.ndarray  # (T,) datetime64[ns], receiver time tags in GPS time, increasing
    tables: dict[str, SystemTable]  # by system letter
    header: ObservationHeader
    power_failure: np.ndarray  # (T,) bool, epochs flagged "power failure since the last epoch": every phase slipped
    events: tuple[str, ...] = ()  # event records in words, with their line numbers
    warnings: tuple[str, ...] = ()  # what was set aside while reading, in words
    source: str = ""  # file name, or what made it

    @property
    def systems(self):
        """Letters of the systems with at least one row, sorted."""
        return "".join(sorted(self.tables))

    @property
    def satellites(self):
        """Names of all satellites, sorted."""
        return tuple(sorted(name for table in self.tables.values() for name in table.satellites))

    @property
    def interval(self):
        """Usual spacing of the epochs [s] (median), NaN with fewer than two epochs."""
        if len(self.time) < 2:
            return float("nan")
        return float(np.median(np.diff(self.time)) / np.timedelta64(1, "ns") * 1e-9)

    def __repr__(self):
        span = f"{self.time[0]} to {self.time[-1]}" if len(self.time) else "empty"
        return f"Observations: {len(self.time)} epochs, {len(self.satellites)} satellites of {self.systems}; {span}"
