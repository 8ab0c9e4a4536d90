"""Broken observation files: one plain sentence each, with file and line, and never another exception."""

import os

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from observation_texts import SMALL2, SMALL3, epoch3, header2, header3, header_line, text_of

from gnsslab.gnss.rinex import RinexError, read_rinex_obs
from gnsslab.gnss.rinex.text import read_bytes

GPS_ONLY = {"G": ("C1C", "L1C")}
NAVIGATION = header_line("     3.04           NAVIGATION DATA     M (Mixed)", "RINEX VERSION / TYPE") + "\n"
OLD_NAVIGATION = header_line("     2.10           N: GPS NAV DATA", "RINEX VERSION / TYPE") + "\n"


def replaced(old, new, text=SMALL3):
    """The small file with one thing broken."""
    assert text.count(old) >= 1
    return text.replace(old, new, 1)


BROKEN = {
    "empty file": ("", None, "the file is empty"),
    "binary file": (bytes(range(256)), 1, "binary"),
    "binary file without zeros": (b"\xd3\x80\x81\x82\x83" * 40, 1, "binary"),
    "other text": ("time,east,north\n1,2,3\n", 1, "expected 'RINEX VERSION / TYPE' in columns 61 to 80, found 'time,east,north'"),
    "navigation file": (NAVIGATION, 1, "this is a navigation file; name the observation file here"),
    "old navigation file": (OLD_NAVIGATION, 1, "this is a navigation file; name the observation file here"),
    "wrong version": (replaced("3.04", "5.00"), 1, "expected RINEX version 2, 3 or 4, found 5"),
    "version 1": (replaced("3.04", "1.00"), 1, "expected RINEX version 2, 3 or 4, found 1"),
    "no version": (replaced("3.04", "x.04"), 1, "expected a version number, found 'x.04'"),
    "unknown kind": (replaced("OBSERVATION", "PBSERVATION"), 1, "expected 'OBSERVATION DATA' in columns 21 to 36"),
    "unknown system of the file": (replaced("DATA    M", "DATA    Q"), 1, "unknown satellite system 'Q' in column 41"),
    "missing end of header": (replaced("END OF HEADER", "END"), 6, "expected 'END OF HEADER' before the first epoch"),
    "missing end of an old header": (replaced("END OF HEADER", "END", SMALL2), 4, "expected 'END OF HEADER' before the first epoch"),
    "no observation types": (text_of(header3({})), 3, "expected a header line 'SYS / # / OBS TYPES', found none"),
    "no old observation types": (text_of(header2(())), 2, "expected a header line '# / TYPES OF OBSERV', found none"),
    "fewer old types than announced": (replaced("     6", "     7", SMALL2), 2, "expected 7 observation types as announced, found 6"),
    "header alone, cut": (SMALL3[:200], 3, "expected 'END OF HEADER', found the end of the file"),
    "fewer types than announced": (replaced("G    4", "G    5"), 2, "expected 5 observation types as announced, found 4"),
    "type twice": (replaced("C1C L1C", "C1C C1C"), 2, "expected each observation type once, found C1C twice"),
    "letters for the number of types": (replaced("G    4", "G    x"), 2, "expected the number of observation types, found 'x'"),
    "unknown system in the header": (replaced("G    4", "X    4"), 2, "unknown satellite system 'X': expected one of G, R, E, C, J, S, I"),
    "unknown time scale": (replaced("GPS", "TAI"), 4, "unknown time scale 'TAI'"),
    "position in letters": (
        text_of(header3(GPS_ONLY, extra=[header_line("  1.0  abc  2.0", "APPROX POSITION XYZ")])), 4, "expected a number, found 'abc'",
    ),
    "unknown system letter": (replaced("E03", "X03"), 9, "expected a satellite such as G05 (systems are G, R, E, C, J, S, I), found 'X03'"),
    "unknown old system letter": (replaced("G05R03", "G05X03", SMALL2), 4, "found 'X03'"),
    "no satellite number": (replaced("G12", "G1x"), 8, "found 'G1x'"),
    "system without types": (replaced("E03", "C03"), 9, "the header lists no observation types of system C, found C03"),
    "letters in a number": (
        replaced("20000000.123", "2000x000.123"), 7, "expected a number and flags (C1C) in columns 4 to 19, found '  2000x000.123 7'",
    ),
    "not a number": (replaced("-1234.567", "      nan"), 7, "(D1C)"),
    "blank inside a number": (replaced("20000000.123", "2000 000.123"), 7, "(C1C)"),
    "two points": (replaced("20000000.123", "2000.000.123"), 7, "(C1C)"),
    "minus inside": (replaced("20000000.123", "2000-000.123"), 7, "(C1C)"),
    "point without digits": (replaced("20000000.123", "           ."), 7, "(C1C)"),
    "letter for a flag": (replaced("105000000.45617", "105000000.456x7"), 7, "(L1C)"),
    "shifted to the right": (replaced("  45.250", "   45.250"), 7, "(S1C)"),
    "letters in an old number": (replaced("19000000.123", "19x00000.123", SMALL2), 7, "(C1C)"),
    "letters in a continued old number": (replaced("        41.000", "        4x.000", SMALL2), 8, "(S2P)"),
    "more than announced": (replaced("131000000.50003", "131000000.50003  1.000"), 9, "found '1.000' behind them"),
    "more satellites than lines": (replaced("  0  3\n", "  0  4\n"), 6, "expected 4 lines in this epoch as it announces, found 3"),
    "fewer satellites than lines": (replaced("  0  3\n", "  0  2\n"), 9, "expected an epoch line starting with '>', found 'E03"),
    "more old satellites than lines": (replaced("  0  2G05R03", "  0  3G05R03", SMALL2), 4, "expected more lines in this epoch"),
    "fewer old satellites than lines": (replaced("  0  2G05R03", "  0  1G05", SMALL2), 7, "expected an epoch line"),
    "letters for the number of satellites": (replaced("  0  3\n", "  0  x\n"), 6, "expected the number of satellites, found 'x'"),
    "unprintable character in the number of satellites": (replaced("  0  3\n", "  0\x1e x\n"), 6, "expected the number of satellites"),
    "unknown epoch flag": (replaced("  0  3\n", "  7  3\n"), 6, "expected an epoch flag from 0 to 6, found 7"),
    "letter for an epoch flag": (replaced("  0  3\n", "  a  3\n"), 6, "expected an epoch flag from 0 to 6, found 'a'"),
    "no such month": (replaced("> 2024 01 01", "> 2024 13 01"), 6, "expected year month day hour minute second"),
    "no such day": (replaced("> 2024 01 01", "> 2023 02 29"), 6, "expected year month day hour minute second"),
    "letters in the time": (replaced("> 2024 01 01", "> 2024 a1 01"), 6, "expected year month day hour minute second"),
    "no such old minute": (replaced(" 24  1  1  0  0", " 24  1  1  0 60", SMALL2), 4, "expected year month day hour minute second"),
    "bad scale factor": (text_of(header3(GPS_ONLY, extra=[header_line("G    0", "SYS / SCALE FACTOR")])), 4, "expected a positive scale factor"),
    "types lost in an event": (
        text_of(header3(GPS_ONLY), epoch3(0, 1, flag=4), header_line("G    3 L1C", "SYS / # / OBS TYPES")), 6,
        "expected 3 observation types as announced, found 1",
    ),
    "nothing after Hatanaka's first line": (f"{'3.0':<20}{'COMPACT RINEX FORMAT':<40}CRINEX VERS   / TYPE\n", None, "Hatanaka"),
}  # fmt: skip


@pytest.mark.parametrize("name", BROKEN)
def test_broken_file_is_told_in_one_sentence(tmp_path, name):
    content, line, words = BROKEN[name]
    path = tmp_path / "broken.obs"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(RinexError) as caught:
        read_rinex_obs(path)
    message = str(caught.value)
    assert words in message
    assert caught.value.file == str(path)
    assert caught.value.line == line
    assert message.startswith(f"{path}, line {line}: " if line else f"{path}: ")
    assert "\n" not in message


@pytest.mark.parametrize("suffix", [".gz", ".Z", ".crx.gz", ".bz2", ".zip"])
@pytest.mark.parametrize("content", [b"ab", b"\x1f\x8b", b"\x1f\x9d", b"BZ", b"PK", b"BZh9", b"PK\x03\x04"])
def test_two_bytes_named_as_compressed(tmp_path, suffix, content):
    path = tmp_path / f"short.obs{suffix}"
    path.write_bytes(content)
    with pytest.raises(RinexError, match=r"fetch the file again|nothing is in"):
        read_bytes(path)


def test_cut_off_compressed_file(tmp_path):
    import gzip

    path = tmp_path / "cut.obs.gz"
    path.write_bytes(gzip.compress(SMALL3.encode())[:-20])
    with pytest.raises(RinexError, match="end too early; fetch the file again"):
        read_rinex_obs(path)


def test_missing_file_and_folder(tmp_path):
    with pytest.raises(RinexError, match="there is no such file"):
        read_rinex_obs(tmp_path / "missing.obs")
    with pytest.raises(RinexError, match="this is a folder"):
        read_rinex_obs(tmp_path)
    with pytest.raises(RinexError, match="cannot be read"):
        read_rinex_obs("no\0name.obs")


@pytest.mark.skipif(os.geteuid() == 0 if hasattr(os, "geteuid") else True, reason="the administrator may read everything")
def test_file_that_may_not_be_read(tmp_path):
    path = tmp_path / "locked.obs"
    path.write_text(SMALL3)
    path.chmod(0)
    with pytest.raises(RinexError, match="cannot be read"):
        read_rinex_obs(path)


def test_error_survives_pickling():
    import pickle

    error = pickle.loads(pickle.dumps(RinexError("a.obs", "expected this", 3)))
    assert (error.file, error.line, str(error)) == ("a.obs", 3, "a.obs, line 3: expected this")
    assert isinstance(error, ValueError)


EVENTS3 = text_of(
    header3({"G": ("C1C", "L1C"), "C": ("C2I",)}, scale="BDT", extra=[header_line("G   10  1 L1C", "SYS / SCALE FACTOR")]),
    epoch3(0, 1, flag=1), "G05  20000000.123 7 105000000.45617", "> " + " " * 29 + "4  1",
    header_line("G    1 L1C", "SYS / # / OBS TYPES"), epoch3(1, 2), "G05  20000000.123 7", "C05  20000000.123 7",
    epoch3(2, 1, flag=6), "G05         1.000", epoch3(2, 0, flag=5), epoch3(3, 1), "C05  20000000.123 7",
)  # fmt: skip
PIECES = [b"\n", b" ", b"> ", b"-", b".", b"\x00", b"\xff", b"999", b"G", b"\r\n", b"END OF HEADER", b"1e9", b"nan", b"\xb2", b"\x1e"]


@st.composite
def mutations(draw):
    """A small valid file with up to four bytes changed, pieces cut, pieces put in or lines moved."""
    content = draw(st.sampled_from([SMALL3, SMALL2, EVENTS3])).encode()
    for _ in range(draw(st.integers(1, 4))):
        at = draw(st.integers(0, max(len(content) - 1, 0)))
        how = draw(st.sampled_from(["flip", "digit", "cut", "end", "insert", "repeat"]))
        length = draw(st.integers(1, 90))
        piece = draw(st.sampled_from(PIECES))
        byte = bytes([draw(st.integers(0, 255))])
        content = {
            "flip": content[:at] + byte + content[at + 1 :],
            "digit": content[:at] + b"7" + content[at + 1 :],
            "cut": content[:at] + content[at + length :],
            "end": content[:at],
            "insert": content[:at] + piece + content[at:],
            "repeat": content[: at + length] + content[at:],
        }[how]
    return content


@settings(max_examples=400, deadline=None)
@given(content=mutations())
def test_any_bytes_give_observations_or_a_rinex_error(tmp_path_factory, content):
    path = tmp_path_factory.getbasetemp() / "mutated.obs"
    path.write_bytes(content)
    message, observations = message_or_observations(path)
    if observations is None:
        assert str(path) in message
        assert "\n" not in message
        return
    assert (np.diff(observations.time) > np.timedelta64(0)).all()
    for table in observations.tables.values():
        assert len(table.epoch) == len(table.number) == len(table.value) == len(table.lli) == len(table.ssi)
        assert table.value.shape[1] == len(table.codes)
        assert (np.diff(table.epoch * 100 + table.number) > 0).all()


def message_or_observations(path):
    """What RinexError says, or what was read."""
    try:
        return None, read_rinex_obs(path)
    except RinexError as error:
        return str(error), None


@settings(max_examples=100, deadline=None)
@given(content=st.binary(max_size=300))
def test_noise_gives_a_rinex_error(tmp_path_factory, content):
    path = tmp_path_factory.getbasetemp() / "noise.obs"
    path.write_bytes(content)
    with pytest.raises(RinexError):
        read_rinex_obs(path)
