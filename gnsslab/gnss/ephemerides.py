"""Ephemerides: broadcast orbit and clock parameters of many satellites, as arrays, one entry a data set."""

from dataclasses import dataclass, field, fields

import numpy as np


@dataclass(frozen=True, eq=False)
class Ephemerides:
    """k broadcast data sets of GPS, Galileo, BeiDou and QZSS; angles in radians, times in GPS time.

    Names follow IS-GPS-200 and the Galileo and BeiDou interface documents. Rows are sorted by satellite, then by toe.
    """

    satellite: np.ndarray  # (k,) '<U3', "G05"
    toe: np.ndarray  # (k,) datetime64[ns], reference time of the orbit
    toc: np.ndarray  # (k,) datetime64[ns], reference time of the clock
    transmission: np.ndarray  # (k,) datetime64[ns], when the message was sent; NaT where the file does not say
    sqrt_a: np.ndarray  # (k,) [sqrt m]
    e: np.ndarray  # (k,)
    i0: np.ndarray  # (k,) [rad]
    omega0: np.ndarray  # (k,) [rad], longitude of the ascending node at the start of the week
    omega: np.ndarray  # (k,) [rad], argument of perigee
    m0: np.ndarray  # (k,) [rad]
    delta_n: np.ndarray  # (k,) [rad/s]
    idot: np.ndarray  # (k,) [rad/s]
    omega_dot: np.ndarray  # (k,) [rad/s]
    cuc: np.ndarray  # (k,) [rad]
    cus: np.ndarray  # (k,) [rad]
    crc: np.ndarray  # (k,) [m]
    crs: np.ndarray  # (k,) [m]
    cic: np.ndarray  # (k,) [rad]
    cis: np.ndarray  # (k,) [rad]
    af0: np.ndarray  # (k,) [s]
    af1: np.ndarray  # (k,) [s/s]
    af2: np.ndarray  # (k,) [s/s^2]
    group_delay: np.ndarray  # (k, 2) [s]: GPS, QZSS TGD and 0; Galileo BGD E1/E5a, E1/E5b; BeiDou TGD1 (B1/B3), TGD2 (B2/B3)
    issue: np.ndarray  # (k,) int, IODE, IODnav or AODE
    clock_issue: np.ndarray  # (k,) int, IODC, data-source bits (Galileo) or AODC
    accuracy: np.ndarray  # (k,) [m], URA or SISA; NaN where no prediction is given
    health: np.ndarray  # (k,) int as broadcast; orbits.is_healthy says which bits forbid use (0 never does)
    ionosphere: dict[str, np.ndarray] = field(default_factory=dict)  # "G" or "C" or "J" -> (8,) Klobuchar alpha 0-3, beta 0-3
    leap_seconds: int | None = None
    warnings: tuple[str, ...] = ()
    source: str = ""

    @property
    def satellites(self):
        """Names of the satellites with at least one data set, sorted."""
        return tuple(np.unique(self.satellite).tolist())

    def __repr__(self):
        return f"Ephemerides: {len(self.satellite)} data sets of {len(self.satellites)} satellites"


ARRAY_FIELDS = tuple(f.name for f in fields(Ephemerides) if f.type is np.ndarray)
