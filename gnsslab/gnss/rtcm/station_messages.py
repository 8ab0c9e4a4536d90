"""Station messages: 1005 and 1006 (position, antenna height), 1007, 1008 and 1033 (antenna, receiver) into an `ObservationHeader`."""

import numpy as np
from pyrtcm import RTCMMessage
from pyrtcm.exceptions import RTCMMessageError, RTCMTypeError

from gnsslab.gnss.frames import enu_rotation
from gnsslab.gnss.observations import ObservationHeader

STATION_MESSAGES = (1005, 1006, 1007, 1008, 1033)
_MOVED = 1e-3  # [m]


def station_header(messages, station, glonass_channels):
    """Return the `ObservationHeader` of a station from (message number, payload) pairs, and notes.

    The position in the messages is that of the antenna reference point; RINEX has the marker, which is lower by the
    antenna height. The first position and the last names count.
    """
    facts, notes = {}, []
    for number, payload in messages:
        message = _parsed(payload)
        if message and message.DF003 == station:  # noqa: SIM300
            notes += _take(facts, number, message)
    position, height = facts.pop("position", None), facts.pop("height", 0.0)
    header = ObservationHeader(
        marker=f"{station:04d}",
        position_ecef=_below(position, height),
        antenna_delta_enu=np.array([0.0, 0.0, height]),
        glonass_channels=glonass_channels,
        **facts,
    )
    return header, tuple(dict.fromkeys(notes))


def _parsed(payload):
    try:
        return RTCMMessage(payload=payload)
    except (RTCMMessageError, RTCMTypeError):  # shorter than its own counts say
        return None


def _take(facts, number, message):
    """Take what a message says into the facts; return notes."""
    if number in (1005, 1006):
        return _take_position(facts, message)
    facts["antenna"] = _text(message, "DF030", message.DF029)
    if number == 1033:
        facts["receiver"] = _text(message, "DF228", message.DF227)
    return []


def _take_position(facts, message):
    position = np.array([message.DF025, message.DF026, message.DF027])
    if not position.any():
        return []  # not known
    first = facts.setdefault("position", position)
    facts.setdefault("height", getattr(message, "DF028", 0.0))
    moved = np.linalg.norm(position - first)
    return [f"the station's position changes by {moved:.3f} m within the log; the first was kept"] if moved > _MOVED else []


def _text(message, name, length):
    return "".join(getattr(message, f"{name}_{k:02d}") for k in range(1, length + 1)).strip()


def _below(position, height):
    return position if position is None or height == 0 else position - height * enu_rotation(position)[2]
