"""The observation messages of a log: those of one station that can be read, in their order."""

from collections import Counter
from typing import NamedTuple

import numpy as np

from gnsslab.gnss.rtcm.msm import msm_system, read_head
from gnsslab.gnss.rtcm.weeks import is_possible, own_clock


class Observed(NamedTuple):
    """M MSM messages of one station."""

    place: np.ndarray  # (M,) int64, index among all messages of the log
    system: np.ndarray  # (M,) letters
    clock: np.ndarray  # (M,) int64 [ms], GPS time of week, GLONASS: time of day
    layouts: list
    payloads: list
    station: int  # 0 where there is none


def find_observed(numbers, payloads):
    """Return the `Observed` messages and notes on those that cannot be read or are another station's."""
    heads = {k: read_head(payloads[k]) for k, number in enumerate(numbers) if msm_system(number)}
    readable = {k: head for k, head in heads.items() if head and is_possible(msm_system(numbers[k]), head.clock)}
    stations = Counter(head.station for head in readable.values()).most_common()
    station = stations[0][0] if stations else 0
    own = {k: head for k, head in readable.items() if head.station == station}
    observed = Observed(
        place=np.array(list(own), dtype=np.int64),
        system=np.array([msm_system(numbers[k]) for k in own], dtype="<U1"),
        clock=np.array([own_clock(msm_system(numbers[k]), head.clock) for k, head in own.items()], dtype=np.int64),
        layouts=[head.layout for head in own.values()],
        payloads=[payloads[k] for k in own],
        station=station,
    )
    return observed, (*_unreadable_note(len(heads) - len(readable)), *_station_note(stations))


def _unreadable_note(count):
    return [f"observation messages left out, too short or of an impossible time: {count}"] if count else []


def _station_note(stations):
    others = ", ".join(f"{station} ({count})" for station, count in stations[1:])
    return [f"observations of several stations: those of station {stations[0][0]} were read, left out (messages): {others}"] if others else []
