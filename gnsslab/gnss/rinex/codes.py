"""Observation codes of every RINEX version in the names of RINEX 3.04.

RINEX 2 names only kind and band; the channel is filled in as follows (kind in front: C, L, D or S; P is a code).

==========  =====================================================================================================
GPS         C1 -> 1C, P1 -> 1W, C2 -> 2X (L2C), P2 -> 2W, C5 -> 5X; 2.12: CA -> 1C, CB -> 1X, CC -> 2X
GLONASS     C1 -> 1C, P1 -> 1P, C2 -> 2C, P2 -> 2P; 2.12: CA -> 1C, CD -> 2C
Galileo     1X, 5X, 6X, 7X, 8X
BeiDou      C2 -> 2I (B1I), 6I, 7I, 5X, 8X; C1 -> 2I where band 2 is not listed, else it keeps its name: B1I or B1C?
QZSS, SBAS  C1 -> 1C, 2X, 5X, 6X; 2.12: CA -> 1C, CB -> 1X, CC -> 2X
NavIC       5A, 9A, 1X
==========  =====================================================================================================

L1, D1 and S1 of GPS and GLONASS go with the code that is listed with them, C1 before P1; L2, D2 and S2 with P2 before
C2; where neither is listed they are L1C and L2W (GLONASS L2P). In 2.12, CA takes the place of C1 with LA, DA and SA of
its own, so L1 then goes with P1. (RINEX 2.11 table A1, 2.12 table A1; RTKLIB takes the same channels for most.)
"""

from functools import lru_cache

_LETTER_BANDS = {"A": ("1", "C"), "B": ("1", "X"), "C": ("2", "X"), "D": ("2", "C")}  # RINEX 2.12: CA, CB, CC, CD
_CHANNEL = {
    "G": {"5": "X"},
    "R": {"3": "X"},
    "E": dict.fromkeys("15678", "X"),
    "C": {"2": "I", "5": "X", "6": "I", "7": "I", "8": "X"},
    "J": {"1": "C", "2": "X", "5": "X", "6": "X"},
    "S": {"1": "C", "5": "X"},
    "I": {"5": "A", "9": "A", "1": "X"},
}


@lru_cache(maxsize=256)
def columns_of_version(system, types, version):
    """Return the RINEX 3.04 names of the observation types of a system, in the same order.

    >>> columns_of_version("G", ("L1", "C1", "L2", "P2"), 2.10)
    ('L1C', 'C1C', 'L2W', 'C2W')
    >>> columns_of_version("C", ("C1I", "L1I"), 3.02)
    ('C2I', 'L2I')
    """
    rename = _name_of_version_2 if version < 3 else _name_of_version_3
    renamed = [rename(system, kind, types, version) for kind in types]
    is_first = [name not in renamed[:at] for at, name in enumerate(renamed)]
    return tuple(new if first else old for new, old, first in zip(renamed, types, is_first, strict=True))


def _name_of_version_3(system, code, types, version):
    """B1I was band 1 in RINEX 3.02 and is band 2 before and since; letters I and Q exist on B1I only."""
    is_b1i = system == "C" and code[1:2] == "1" and (code[2:] in ("I", "Q") or (code[2:] == "X" and round(version, 2) == 3.02))
    new = f"{code[0]}2{code[2:]}"
    return new if is_b1i and new not in types else code


def _name_of_version_2(system, kind, types, version):
    letter, band = kind[0], kind[1:]
    if letter not in "CPLDS" or len(kind) != 2:
        return kind
    if band in _LETTER_BANDS:
        return letter + "".join(_LETTER_BANDS[band])
    if system == "C" and band == "1":
        if not {"C2", "P2", "L2"}.isdisjoint(types):
            return kind
        band = "2"
    channel = _channel(system, letter, band, types)
    return ("C" if letter == "P" else letter) + band + channel


def _channel(system, letter, band, types):
    if system in "GR" and band in "12":
        return _paired_channel(system, letter, band, types)
    return _CHANNEL[system].get(band, "X")


def _paired_channel(system, letter, band, types):
    """Channel of GPS and GLONASS on bands 1 and 2: of the code itself, or of the code that goes with a phase."""
    precise, civil = ("W" if system == "G" else "P"), ("X" if (system, band) == ("G", "2") else "C")
    if letter in "PC":
        return precise if letter == "P" else civil
    if band == "1":
        return precise if "P1" in types and "C1" not in types else civil
    return civil if "C2" in types and "P2" not in types else precise
