"""Signals: systems, carrier frequencies and the RINEX 3 names of what a receiver tracks.

A signal is named as in RINEX 3: band digit and tracking letter ("1C", "2W", "7I"); an observation code puts the kind
in front: C code [m], L carrier phase [cycles], D Doppler [Hz], S signal strength [dB-Hz].
"""

SPEED_OF_LIGHT = 299_792_458.0  # [m/s]

SYSTEM_NAMES = {
    "G": "GPS", "R": "GLONASS", "E": "Galileo", "C": "BeiDou", "J": "QZSS", "S": "SBAS", "I": "NavIC",
}  # fmt: skip
USED_SYSTEMS = "GECJ"  # systems with orbits here; the others are read and kept, not used

_L1, _L2, _L5, _E5B, _E5, _E6, _B1I, _B3 = (
    1575.42e6, 1227.60e6, 1176.45e6, 1207.14e6, 1191.795e6, 1278.75e6, 1561.098e6, 1268.52e6,
)  # fmt: skip
_FREQUENCY = {
    "G": {"1": _L1, "2": _L2, "5": _L5},
    "J": {"1": _L1, "2": _L2, "5": _L5, "6": _E6},
    "E": {"1": _L1, "5": _L5, "7": _E5B, "8": _E5, "6": _E6},
    "C": {"2": _B1I, "1": _L1, "5": _L5, "7": _E5B, "8": _E5, "6": _B3},
    "S": {"1": _L1, "5": _L5},
    "I": {"5": _L5, "9": 2492.028e6, "1": _L1},
    "R": {"1": 1602.0e6, "2": 1246.0e6, "3": 1202.025e6, "4": 1600.995e6, "6": 1248.06e6},
}

# First, second and third band of each system; where two stand together, the second serves satellites without the first.
BANDS = {"G": ("1", "2", "5"), "J": ("1", "2", "5"), "E": ("1", "5", "7"), "C": ("21", "6", "75")}

SEMI_CODELESS = "WYDPMN"  # tracking letters of encrypted signals, received weaker and the more so the lower the satellite

# Tracking letters, best first: civil data and pilot channels before semi-codeless ones where both are sent,
# but on GPS L2 the W signal first, as every GPS satellite has it and L2C came only with Block IIR-M.
_TRACKING = {
    "G1": "CLSXPWYMN", "G2": "WLXSCPDYMN", "G5": "QXI",
    "J1": "CLXSZEB", "J2": "LXS", "J5": "QXIDPZ", "J6": "LXSEZ",
    "E1": "CXBAZ", "E5": "QXI", "E7": "QXI", "E8": "QXI", "E6": "CXBAZ",
    "C2": "IXQ", "C1": "PXDIQAN", "C5": "PXD", "C7": "IQXPDZ", "C8": "PXD", "C6": "IQXDPZA",
}  # fmt: skip


def frequency(system, band):
    """Return the carrier frequency [Hz] of a system letter and a RINEX 3 band digit (GLONASS: channel 0).

    >>> frequency("C", "2")
    1561098000.0
    """
    try:
        return _FREQUENCY[system][band]
    except KeyError:
        raise ValueError(f"no carrier frequency is known for system {system!r}, band {band!r}") from None


def wavelength(system, band):
    """Return the carrier wavelength [m]: c / f.

    >>> round(wavelength("G", "1"), 6)
    0.190294
    """
    return SPEED_OF_LIGHT / frequency(system, band)


def tracking_letters(system, band):
    """Return the tracking letters of a band, best first; an unknown band has none.

    >>> tracking_letters("E", "5")
    'QXI'
    """
    return _TRACKING.get(system + band, "")


def check_systems(systems):
    """Raise ValueError where a letter is no system that can be used here, or none is given.

    >>> check_systems("GE")
    """
    for letter in systems:
        if letter in SYSTEM_NAMES and letter not in USED_SYSTEMS:
            raise ValueError(f"{SYSTEM_NAMES[letter]} ({letter}) is read but has no orbits here: choose among {', '.join(USED_SYSTEMS)}")
        if letter not in USED_SYSTEMS:
            raise ValueError(f"unknown system {letter!r}: choose among {', '.join(USED_SYSTEMS)}")
    if not systems:
        raise ValueError(f"no system is given: choose among {', '.join(USED_SYSTEMS)}")
