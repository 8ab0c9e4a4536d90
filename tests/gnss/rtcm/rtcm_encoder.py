"""A small encoder of RTCM 3 messages, written from the tables of RTCM 10403.3 and apart from the reader: text of ones and zeros."""

from pyrtcm.rtcmhelpers import crc2bytes

_ORBIT = {  # the run of the orbit: bits, signed, unit; `long` fields are four bytes in every system
    "crs": 1, "delta_n": 1, "m0": 1, "cuc": 1, "e": 0, "cus": 1, "sqrt_a": 0, "toe": 0, "cic": 1, "omega0": 1, "cis": 1, "i0": 1,
    "crc": 1, "omega": 1, "omega_dot": 1,
}  # fmt: skip
_LONG = {"m0": 2**-31, "omega0": 2**-31, "i0": 2**-31, "omega": 2**-31, "e": 2**-33, "sqrt_a": 2**-19}


def _orbit(short_bits, harmonic, distance, toe_bits, toe_unit):
    """Return the fields of an orbit (name, bits, is_signed, unit)."""
    for name, is_signed in _ORBIT.items():
        if name in _LONG:
            yield name, 32, is_signed, _LONG[name]
        elif name == "toe":
            yield name, toe_bits, is_signed, toe_unit
        elif name == "omega_dot":
            yield name, 24, is_signed, 2**-43
        elif name == "delta_n":
            yield name, 16, is_signed, 2**-43
        else:
            yield name, short_bits, is_signed, distance if name in ("crs", "crc") else harmonic


_GPS_ORBIT = (*_orbit(16, 2**-29, 2**-5, 16, 16),)
_BEIDOU_ORBIT = (*_orbit(18, 2**-31, 2**-6, 17, 8),)
_GALILEO_ORBIT = (*_orbit(16, 2**-29, 2**-5, 14, 60),)
_GPS_CLOCK = (("toc", 16, 0, 16), ("af2", 8, 1, 2**-55), ("af1", 16, 1, 2**-43), ("af0", 22, 1, 2**-31))
_BEIDOU_CLOCK = (("toc", 17, 0, 8), ("af2", 11, 1, 2**-66), ("af1", 22, 1, 2**-50), ("af0", 24, 1, 2**-33))
_GALILEO_CLOCK = (("toc", 14, 0, 60), ("af2", 6, 1, 2**-59), ("af1", 21, 1, 2**-46), ("af0", 31, 1, 2**-34))
_GALILEO_HEAD = (("number", 6, 0, 1), ("week", 12, 0, 1), ("issue", 10, 0, 1), ("accuracy", 8, 0, 1), ("idot", 14, 1, 2**-43))
EPHEMERIS_FIELDS = {  # message: (name, bits, is_signed, unit)
    1019: (
        ("number", 6, 0, 1), ("week", 10, 0, 1), ("accuracy", 4, 0, 1), ("codes_on_l2", 2, 0, 1), ("idot", 14, 1, 2**-43),
        ("issue", 8, 0, 1), *_GPS_CLOCK, ("clock_issue", 10, 0, 1), *_GPS_ORBIT, ("delay_1", 8, 1, 2**-31), ("health", 6, 0, 1),
        ("l2p", 1, 0, 1), ("fit", 1, 0, 1),
    ),
    1042: (
        ("number", 6, 0, 1), ("week", 13, 0, 1), ("accuracy", 4, 0, 1), ("idot", 14, 1, 2**-43), ("issue", 5, 0, 1), *_BEIDOU_CLOCK,
        ("clock_issue", 5, 0, 1), *_BEIDOU_ORBIT, ("delay_1", 10, 1, 1e-10), ("delay_2", 10, 1, 1e-10), ("health", 1, 0, 1),
    ),
    1044: (
        ("number", 4, 0, 1), *_GPS_CLOCK, ("issue", 8, 0, 1), *_GPS_ORBIT, ("idot", 14, 1, 2**-43), ("codes_on_l2", 2, 0, 1),
        ("week", 10, 0, 1), ("accuracy", 4, 0, 1), ("health", 6, 0, 1), ("delay_1", 8, 1, 2**-31), ("clock_issue", 10, 0, 1), ("fit", 1, 0, 1),
    ),
    1045: (
        *_GALILEO_HEAD, *_GALILEO_CLOCK, *_GALILEO_ORBIT, ("delay_1", 10, 1, 2**-32), ("e5a_health", 2, 0, 1), ("e5a_invalid", 1, 0, 1),
        ("reserved", 7, 0, 1),
    ),
    1046: (
        *_GALILEO_HEAD, *_GALILEO_CLOCK, *_GALILEO_ORBIT, ("delay_1", 10, 1, 2**-32), ("delay_2", 10, 1, 2**-32), ("e5b_health", 2, 0, 1),
        ("e5b_invalid", 1, 0, 1), ("e1b_health", 2, 0, 1), ("e1b_invalid", 1, 0, 1), ("reserved", 2, 0, 1),
    ),
}  # fmt: skip
TENS = {"G": 107, "R": 108, "E": 109, "J": 111, "C": 112}
INVALID = {"fine_code": {4: -(2**14), 6: -(2**19)}, "fine_phase": {4: -(2**21), 6: -(2**23)}, "fine_rate": -(2**14), "rate": -8192, "whole": 255}


def bits(value, width):
    """Return a number as ones and zeros, negative ones in two's complement."""
    assert -(1 << (width - 1)) <= value < 1 << width, f"{value} needs more than {width} bits"
    return format(value & ((1 << width) - 1), f"0{width}b")


def frame(text):
    """Return the frame of a message given as ones and zeros; zeros fill its last byte."""
    text += "0" * (-len(text) % 8)
    payload = bytes(int(text[k : k + 8], 2) for k in range(0, len(text), 8))
    message = b"\xd3" + len(payload).to_bytes(2, "big") + payload
    return message + crc2bytes(message)


def ephemeris(message, raw):
    """Return the frame of an ephemeris message from its integers by name; what is not given is 0."""
    return frame(bits(message, 12) + "".join(bits(raw.get(name, 0), width) for name, width, _, _ in EPHEMERIS_FIELDS[message]))


def station(position, height=None, number=0):
    """Return the frame of message 1005, or 1006 where an antenna height is given; position and height [m]."""
    x, y, z = (bits(round(coordinate * 1e4), 38) for coordinate in position)
    text = bits(1005 if height is None else 1006, 12) + bits(number, 12) + "000000" + "1111" + x + "10" + y + "00" + z
    return frame(text if height is None else text + bits(round(height * 1e4), 16))


def descriptors(message, antenna, receiver="", number=0):
    """Return the frame of message 1007, 1008 or 1033 with the names of antenna and receiver."""
    text = bits(message, 12) + bits(number, 12) + _string(antenna) + bits(0, 8)
    if message >= 1008:
        text += _string("serial 7")
    if message == 1033:
        text += _string(receiver) + _string("firmware 1") + _string("serial 8")
    return frame(text)


def _string(text):
    return bits(len(text), 8) + "".join(bits(ord(letter), 8) for letter in text)


def msm(system, kind, clock, satellites, cells, multiple=0, number=0):
    """Return the frame of an MSM4 to MSM7 message.

    satellites: number -> dict of `whole` [ms], `modulo` [2^-10 ms], `channel`, `rate` [m/s]; cells: (satellite, signal) ->
    dict of `fine_code`, `fine_phase`, `lock`, `half`, `cn0`, `fine_rate`, all as the integers that stand in the message.
    """
    extended, has_rate = kind >= 6, kind in (5, 7)
    signals = sorted({signal for _, signal in cells})
    text = bits(TENS[system] * 10 + kind, 12) + bits(number, 12) + bits(clock, 30) + bits(multiple, 1) + "0" * 18
    text += "".join("1" if k in satellites else "0" for k in range(1, 65)) + "".join("1" if k in signals else "0" for k in range(1, 33))
    text += "".join("1" if (satellite, signal) in cells else "0" for satellite in sorted(satellites) for signal in signals)
    columns = [("whole", 8), ("channel", 4), ("modulo", 10), ("rate", 14)] if has_rate else [("whole", 8), ("modulo", 10)]
    for name, width in columns:
        text += "".join(bits(satellites[k].get(name, 0), width) for k in sorted(satellites))
    widths = (20, 24, 10, 1, 10, 15) if extended else (15, 22, 4, 1, 6, 15)
    names = ("fine_code", "fine_phase", "lock", "half", "cn0", *(["fine_rate"] if has_rate else []))
    for name, width in zip(names, widths, strict=False):
        text += "".join(bits(cells[key].get(name, 0), width) for key in sorted(cells))
    return frame(text)
