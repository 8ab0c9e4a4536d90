"""GLONASS frequency channels: each satellite has a carrier of its own, and a phase in cycles needs to know which."""

import numpy as np
from pyrtcm import RTCMMessage
from pyrtcm.exceptions import RTCMMessageError, RTCMTypeError

GLONASS_EPHEMERIS = 1020
CHANNEL_STEP = {"1": 562_500.0, "2": 437_500.0}  # [Hz] by band (GLONASS ICD 5.1, section 3.3.1.1)
_OFFSET, _LAST = 7, 13  # DF040 and DF419 hold channel + 7; above 13 the channel is not given


def frequency_channels(cells, messages):
    """Return satellite number -> frequency channel, from the cells of MSM5 and MSM7 and from (1020, payload) pairs."""
    raw = {}
    for _, payload in messages:
        try:
            message = RTCMMessage(payload=payload)
        except (RTCMMessageError, RTCMTypeError):
            continue
        raw[message.DF038] = message.DF040
    if cells is not None:
        known = cells.channel <= _LAST
        raw |= dict(zip(cells.number[known].tolist(), cells.channel[known].tolist(), strict=True))
    return {number: channel - _OFFSET for number, channel in sorted(raw.items()) if channel <= _LAST}


def channel_table(channels):
    """Return the channels as an array (65,) by satellite number, NaN where not known."""
    table = np.full(65, np.nan)
    table[list(channels)] = list(channels.values())
    return table
