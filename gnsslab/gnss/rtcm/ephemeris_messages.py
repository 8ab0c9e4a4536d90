"""Ephemeris messages: 1019 (GPS), 1042 (BeiDou), 1044 (QZSS), 1045 and 1046 (Galileo F/NAV and I/NAV) into `Ephemerides`.

The messages hold the broadcast bits, scaled by the package pyrtcm as RTCM 10403.3 says; angles are in semicircles there.
"""

from typing import NamedTuple

import numpy as np
from pyrtcm import RTCMMessage
from pyrtcm.exceptions import RTCMMessageError, RTCMTypeError

from gnsslab.gnss.ephemerides import ARRAY_FIELDS, Ephemerides
from gnsslab.gnss.rinex.navigation_reader import merge_ephemerides, within_half_a_week
from gnsslab.gnss.rtcm.weeks import Clue
from gnsslab.gnss.times import BDT_BEHIND_GPS, BDT_WEEK_ZERO, SECONDS_PER_WEEK

_CLOCK = ("toc", "af2", "af1", "af0")
_ORBIT = ("crs", "delta_n", "m0", "cuc", "e", "cus", "sqrt_a", "toe", "cic", "omega0", "cis", "i0", "crc", "omega", "omega_dot")
_SEMICIRCLES = ("m0", "delta_n", "omega0", "i0", "omega", "omega_dot", "idot")
_PI = 3.1415926535898  # as the interface documents have it
_NANOSECOND = 1e-9
_GALILEO_WEEK_ZERO = 1024  # GPS week in which Galileo week 0 begins
_FNAV, _INAV = 0b1_0000_0010, 0b10_0000_0101  # data sources of RINEX: message, and whose clock (E5a or E5b with E1)
_NO_URA = 15
_WEEKS = 5217  # GPS weeks until 2080, where RINEX's two-digit years end
_SISA_INDEX, _SISA = (0, 50, 75, 100, 125), (0.0, 0.5, 1.0, 2.0, 6.0)  # [m], linear in between


class _Kind(NamedTuple):
    """Where a message has what: first data field of the runs _CLOCK and _ORBIT, and fields of their own place."""

    system: str
    clock: int
    orbit: int
    satellite: str
    week: str
    week_zero: int  # GPS week of the system's week 0
    modulus: int  # weeks are known up to multiples of this
    accuracy: str
    idot: str
    issue: str
    clock_issue: str = ""
    delays: tuple = ()
    delay_unit: float = 1.0  # [s]
    health: tuple = ()  # (field, place of its first bit in the RINEX number)


_KINDS = {
    1019: _Kind("G", 81, 86, "DF009", "DF076", 0, 1024, "DF077", "DF079", "DF071", "DF085", ("DF101",), health=(("DF102", 0),)),
    1044: _Kind("J", 430, 435, "DF429", "DF452", 0, 1024, "DF453", "DF450", "DF434", "DF456", ("DF455",), health=(("DF454", 0),)),
    1042: _Kind(
        "C", 493, 498, "DF488", "DF489", BDT_WEEK_ZERO, 8192, "DF490", "DF491", "DF492", "DF497",
        ("DF513", "DF514"), _NANOSECOND, (("DF515", 0),),
    ),
    1045: _Kind(
        "E", 293, 297, "DF252", "DF289", _GALILEO_WEEK_ZERO, 4096, "DF291", "DF292", "DF290",
        delays=("DF312",), health=(("DF315", 3), ("DF314", 4)),
    ),
    1046: _Kind(
        "E", 293, 297, "DF252", "DF289", _GALILEO_WEEK_ZERO, 4096, "DF286", "DF292", "DF290",
        delays=("DF312", "DF313"), health=(("DF288", 0), ("DF287", 1), ("DF317", 6), ("DF316", 7)),
    ),
}  # fmt: skip
EPHEMERIS_MESSAGES = tuple(_KINDS)


class Broadcast(NamedTuple):
    """One ephemeris message, unpacked: angles in radians, times of week in the system's own time."""

    satellite: str
    week: int  # GPS week, up to multiples of `modulus`
    modulus: int
    toe: float  # [s] of the week
    toc: float  # [s] of the week
    values: dict  # the other fields of `Ephemerides`

    @property
    def behind_gps(self):
        """GPS time minus the system's own time."""
        return BDT_BEHIND_GPS if self.satellite[0] == "C" else np.timedelta64(0, "s")

    def clue(self, received):
        """Return what the message says about the week, received at a time [ms] since the beginning of the log's first week."""
        toe = round((self.toe + self.behind_gps / np.timedelta64(1, "s")) * 1000)
        return Clue(self.week, self.modulus, toe, received)


def read_broadcast(message_number, payload):
    """Return the `Broadcast` of an ephemeris message; None where it is too short or is no orbit of a navigation satellite."""
    try:
        message = RTCMMessage(payload=payload)
    except (RTCMMessageError, RTCMTypeError):
        return None
    kind = _KINDS[message_number]
    values = _run(message, kind.clock, _CLOCK) | _run(message, kind.orbit, _ORBIT) | {"idot": getattr(message, kind.idot)}
    values |= {name: values[name] * _PI for name in _SEMICIRCLES} | _flags(message, message_number, kind)
    toe, toc = values.pop("toe"), values.pop("toc")
    if not _is_orbit(values["sqrt_a"], values["e"], toe, toc):
        return None
    number, week = getattr(message, kind.satellite), getattr(message, kind.week) + kind.week_zero
    if number == 0 or week >= _WEEKS:
        return None
    return Broadcast(f"{kind.system}{number:02d}", week, kind.modulus, toe, toc, values)


def _run(message, first, names):
    return {name: getattr(message, f"DF{first + k:03d}") for k, name in enumerate(names)}


def _flags(message, number, kind):
    """Return issues, accuracy [m], health and group delays [s]."""
    delays = [getattr(message, name) * kind.delay_unit for name in kind.delays]
    data_sources = {1045: _FNAV, 1046: _INAV}.get(number)
    return {
        "issue": getattr(message, kind.issue),
        "clock_issue": getattr(message, kind.clock_issue) if kind.clock_issue else data_sources,
        "accuracy": (galileo_accuracy if kind.system == "E" else user_range_accuracy)(getattr(message, kind.accuracy)),
        "health": sum(getattr(message, name) << place for name, place in kind.health),
        "group_delay": [*delays, 0.0][:2],
    }


def user_range_accuracy(index):
    """Return the nominal accuracy [m] of a URA index of GPS, QZSS or BeiDou, NaN for 15 (IS-GPS-200, 20.3.3.3.1.3).

    >>> [user_range_accuracy(index) for index in (0, 1, 6, 7, 15)]
    [2.0, 2.8, 16.0, 32.0, nan]
    """
    if index == _NO_URA:
        return np.nan
    return round(2.0 ** (1 + index / 2), 1) if index <= 6 else 2.0 ** (index - 2)


def galileo_accuracy(index):
    """Return the signal-in-space accuracy [m] of a SISA index, NaN where none is given (Galileo OS SIS ICD, table 89).

    >>> [round(galileo_accuracy(index), 2) for index in (49, 50, 75, 100, 125, 255)]
    [0.49, 0.5, 1.0, 2.0, 6.0, nan]
    """
    return float(np.interp(index, _SISA_INDEX, _SISA)) if index <= _SISA_INDEX[-1] else np.nan


def _is_orbit(sqrt_a, e, toe, toc):
    """Return whether numbers are those of a navigation satellite: a placeholder of zeros is none."""
    return 4500 < sqrt_a < 7500 and e < 0.5 and 0 <= toe < SECONDS_PER_WEEK and 0 <= toc < SECONDS_PER_WEEK


def ephemerides_of(broadcasts, near, received):
    """Return the `Ephemerides` of messages: toe and toc within half a week of GPS time labels `near`.

    The time a message was received (NaT where not known) is taken for when the satellite sent it. Repeated data sets
    stand in it once.
    """
    columns = {name: [broadcast.values[name] for broadcast in broadcasts] for name in ARRAY_FIELDS[4:] if name != "group_delay"}
    everything = Ephemerides(
        satellite=np.array([broadcast.satellite for broadcast in broadcasts], dtype="<U3"),
        toe=np.array([_label(broadcast, broadcast.toe, label) for broadcast, label in zip(broadcasts, near, strict=True)], dtype="M8[ns]"),
        toc=np.array([_label(broadcast, broadcast.toc, label) for broadcast, label in zip(broadcasts, near, strict=True)], dtype="M8[ns]"),
        transmission=np.array(received, dtype="M8[ns]"),
        group_delay=np.array([broadcast.values["group_delay"] for broadcast in broadcasts]).reshape(-1, 2),
        **{name: np.array(column, dtype=np.int64 if name in _WHOLE else float) for name, column in columns.items()},
    )
    return merge_ephemerides([everything])


_WHOLE = ("issue", "clock_issue", "health")


def _label(broadcast, tow, near):
    """Return the GPS time label of a time of week [s] in the system's own time."""
    return within_half_a_week(near - broadcast.behind_gps, tow) + broadcast.behind_gps
