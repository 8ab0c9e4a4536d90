"""Multiple signal messages: MSM4 to MSM7 of GPS, GLONASS, Galileo, QZSS and BeiDou into measurements (RTCM 10403.3, 3.5.16).

A message has a head with three masks (satellites, signals, and which signal of which satellite), then satellite data,
one field of all satellites after the other, then cell data, one field of all cells after the other:

    range = rough range + fine range        [ms of light], rough from the satellite, fine from the cell

Messages with the same masks have each field at the same bits and are taken apart together. Widths and scales of the
fields, and the names of the signals, are those of the package pyrtcm.
"""

from typing import NamedTuple

import numpy as np
from pyrtcm.rtcmtables import PRNSIGMAP
from pyrtcm.rtcmtypes_core import RTCM_DATA_FIELDS

from gnsslab.gnss.rtcm.lock_times import extended_lock_range, lock_range
from gnsslab.gnss.signals import SPEED_OF_LIGHT

METRES_PER_MS = SPEED_OF_LIGHT * 1e-3
_SYSTEM_OF_TENS = {107: "G", 108: "R", 109: "E", 111: "J", 112: "C"}
_STATION_BIT, _CLOCK_BIT, _MASK_BIT, _CELL_BIT = 12, 24, 73, 169  # where these begin in the message
_HEAD_BITS, _MOST_CELLS = 240, 64  # the longest head has 169 bits and 64 for the cells
_AT_ONCE = 512  # messages taken apart together, about 2 MB
_SATELLITE_FIELDS = {  # in their order in the message; DF419, the GLONASS channel, is reserved in the other systems
    4: ("DF397", "DF398"),
    5: ("DF397", "DF419", "DF398", "DF399"),
}
_CELL_FIELDS = {
    4: ("DF400", "DF401", "DF402", "DF420", "DF403"),
    5: ("DF400", "DF401", "DF402", "DF420", "DF403", "DF404"),
    6: ("DF405", "DF406", "DF407", "DF420", "DF408"),
    7: ("DF405", "DF406", "DF407", "DF420", "DF408", "DF404"),
}
_SATELLITE_FIELDS |= {6: _SATELLITE_FIELDS[4], 7: _SATELLITE_FIELDS[5]}
_NO_ROUGH_RANGE = 255  # of DF397


class Head(NamedTuple):
    """The head of one message; two messages with the same layout have all fields at the same bits."""

    station: int
    clock: int  # 30 bits, time as the system counts it
    layout: tuple  # message number, satellite and signal mask (96 bits), cell mask


class Cells(NamedTuple):
    """k measurements of single signals: one cell of one message each; NaN where a quantity is not given."""

    message: np.ndarray  # (k,) int64, index of the message
    number: np.ndarray  # (k,) int16, satellite number in its system
    signal: np.ndarray  # (k,) int8, signal number 1 to 32
    code: np.ndarray  # (k,) [m], pseudorange
    phase: np.ndarray  # (k,) [m], phase range
    rate: np.ndarray  # (k,) [m/s], phase range rate
    cn0: np.ndarray  # (k,) [dB-Hz]
    shortest: np.ndarray  # (k,) [ms], lock time at least
    longest: np.ndarray  # (k,) [ms], lock time less than this
    is_half: np.ndarray  # (k,) bool, half-cycle ambiguity not resolved
    channel: np.ndarray  # (k,) int8, DF419: GLONASS channel + 7; 15 where not given


def msm_system(number):
    """Return the letter of the system of an MSM4 to MSM7 message, "" for any other message number.

    >>> msm_system(1124), msm_system(1077), msm_system(1071), msm_system(1005)
    ('C', 'G', '', '')
    """
    return _SYSTEM_OF_TENS.get(number // 10, "") if 4 <= number % 10 <= 7 else ""


def signal_name(system, signal):
    """Return the RINEX 3 name of a signal number, "" where the standard has none.

    >>> signal_name("C", 2), signal_name("C", 1)
    ('2I', '')
    """
    tens = next(tens for tens, letter in _SYSTEM_OF_TENS.items() if letter == system)
    return PRNSIGMAP[str(tens)][1].get(signal, ("", ""))[1]


def read_head(payload):
    """Return the `Head` of a message, or None where the message is shorter than its masks say."""
    head = int.from_bytes(payload[: _HEAD_BITS // 8].ljust(_HEAD_BITS // 8, b"\0"), "big")
    masks = _bits(head, _MASK_BIT, 96)
    possible = (masks >> 32).bit_count() * (masks & 0xFFFF_FFFF).bit_count()
    if possible > _MOST_CELLS:
        return None
    layout = head >> (_HEAD_BITS - 12), masks, _bits(head, _CELL_BIT, possible)
    if len(payload) * 8 < _length(layout):
        return None
    return Head(_bits(head, _STATION_BIT, 12), _bits(head, _CLOCK_BIT, 30), layout)


def _bits(head, first, count):
    return head >> (_HEAD_BITS - first - count) & ((1 << count) - 1)


def _length(layout):
    """Return how many bits a message of this layout has."""
    kind, (satellites, signals) = layout[0] % 10, _counts(layout)
    of_satellite, of_cell = _widths(_SATELLITE_FIELDS[kind]), _widths(_CELL_FIELDS[kind])
    return _CELL_BIT + satellites * (signals + of_satellite) + layout[2].bit_count() * of_cell


def _counts(layout):
    """Return how many satellites and signals the masks of a layout name."""
    return (layout[1] >> 32).bit_count(), (layout[1] & 0xFFFF_FFFF).bit_count()


def _widths(names):
    return sum(map(_width, names))


def _width(name):
    return RTCM_DATA_FIELDS[name][1]


def read_cells(payloads, layouts, progress=None):
    """Return the `Cells` of messages, a dict by system letter; `progress(done, total)` is called with messages."""
    alike = {}
    for k, layout in enumerate(layouts):
        alike.setdefault(layout, []).append(k)
    pieces, done = {}, 0
    for layout, messages in alike.items():
        for at in range(0, len(messages), _AT_ONCE):
            group = messages[at : at + _AT_ONCE]
            pieces.setdefault(msm_system(layout[0]), []).append(_cells_alike(layout, group, payloads))
            done += len(group)
            if progress:
                progress(done, len(layouts))
    return {system: Cells(*map(np.concatenate, zip(*parts, strict=True))) for system, parts in pieces.items()}


def _cells_alike(layout, messages, payloads):
    """Return the `Cells` of messages of one layout."""
    kind, n_satellites, n_signals = layout[0] % 10, *_counts(layout)
    number, signal, place = _cell_names(layout)
    bits = _bit_table(payloads, messages, _length(layout))
    at = _CELL_BIT + n_satellites * n_signals
    raw = _take(bits, at, _SATELLITE_FIELDS[kind], n_satellites)
    raw = {name: values[:, place] for name, values in raw.items()}  # (M, k), of the cell's satellite
    raw |= _take(bits, bits.shape[1] - _widths(_CELL_FIELDS[kind]) * len(number), _CELL_FIELDS[kind], len(number))
    shape = len(messages), len(number)
    fields = (
        np.repeat(messages, len(number)),
        np.broadcast_to(number.astype(np.int16), shape),
        np.broadcast_to(signal.astype(np.int8), shape),
        *_quantities(kind, raw),
        *_lock(kind, raw),
        raw["DF420"] > 0,
        raw.get("DF419", np.full(shape, 15)).astype(np.int8),
    )
    return Cells(*(field.reshape(-1) for field in fields))


def _cell_names(layout):
    """Return satellite number, signal number and the satellite's place in the message for each cell (k,)."""
    _, masks, cells = layout
    satellites, signals = _ones(masks >> 32, 64), _ones(masks & 0xFFFF_FFFF, 32)
    cell = _ones(cells, len(satellites) * len(signals)) - 1
    place, which = np.divmod(cell, max(len(signals), 1))
    return satellites[place], signals[which], place


def _ones(mask, width):
    """Return the places of the ones in a mask, the first bit being 1.

    >>> _ones(0b1010, 4).tolist()
    [1, 3]
    """
    return np.array([place for place in range(1, width + 1) if mask >> (width - place) & 1], dtype=np.int64)


def _bit_table(payloads, messages, length):
    """Return the first bits (M, length) of messages."""
    octets = [np.frombuffer(payloads[k], dtype=np.uint8, count=-(-length // 8)) for k in messages]
    return np.unpackbits(np.stack(octets), axis=1, count=length)


def _take(bits, at, names, n):
    """Return fields as integers (M, n), a dict by name: from bit `at` on, each field of all n before the next field."""
    raw = {}
    for name in names:
        width = _width(name)
        raw[name] = bits[:, at : at + n * width].reshape(len(bits), n, width) @ (1 << np.arange(width - 1, -1, -1))
        at += n * width
    return raw


def _quantities(kind, raw):
    """Return code [m], phase [m], rate [m/s] and C/N0 [dB-Hz] (M, k)."""
    extended = kind >= 6
    rough = np.where(raw["DF397"] == _NO_ROUGH_RANGE, np.nan, raw["DF397"] + raw["DF398"] * _scale("DF398"))  # [ms]
    code = (rough + _signed(raw, "DF405" if extended else "DF400")) * METRES_PER_MS
    phase = (rough + _signed(raw, "DF406" if extended else "DF401")) * METRES_PER_MS
    rate = _signed(raw, "DF399") + _signed(raw, "DF404") if "DF404" in raw else np.full(rough.shape, np.nan)
    strength = "DF408" if extended else "DF403"
    return code, phase, rate, np.where(raw[strength] > 0, raw[strength] * _scale(strength), np.nan)


def _signed(raw, name):
    """Return a field of two's complement in its unit; the most negative number means that there is no value."""
    half = 1 << (_width(name) - 1)
    number = (raw[name] ^ half) - half
    return np.where(number == -half, np.nan, number * _scale(name))


def _scale(name):
    return RTCM_DATA_FIELDS[name][2]


def _lock(kind, raw):
    """Return the shortest and the longest lock time [ms] (M, k)."""
    return extended_lock_range(raw["DF407"]) if kind >= 6 else lock_range(raw["DF402"])
