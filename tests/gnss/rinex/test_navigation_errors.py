"""What is wrong with a navigation file is said in one sentence with file and line, and nothing else is ever raised."""

import gzip
from contextlib import suppress

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from navigation_texts import BEIDOU, EPOCH, GPS, GPS_2, MIXED_3, MIXED_4, header, record

from gnsslab.gnss.rinex.errors import RinexError
from gnsslab.gnss.rinex.navigation_reader import read_rinex_nav


@pytest.fixture
def refused(tmp_path):
    """A function from a file's content to the error that reading it raises."""

    def read(content, name="bad.nav"):
        path = tmp_path / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode("latin-1"))
        with pytest.raises(RinexError) as caught:
            read_rinex_nav(path)
        assert str(path) in str(caught.value)
        assert "\n" not in str(caught.value)
        return caught.value

    return read


def changed(text, line, old, new):
    """Return a text with `old` replaced in one of its lines, counted from 1."""
    lines = text.split("\n")
    assert old in lines[line - 1]
    lines[line - 1] = lines[line - 1].replace(old, new, 1)
    return "\n".join(lines)


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        (header(kind="OBSERVATION DATA"), 1, "found an observation file"),
        (header(kind="METEOROLOGICAL DATA"), 1, "found a meteorological file"),
        (header(kind="CLOCK DATA"), 1, "found a clock file"),
        (header(kind="X"), 1, "found type 'X'"),
        (header(version="1.00"), 1, "expected RINEX version 2, 3 or 4, found '1.00'"),
        (header(version="5.00"), 1, "expected RINEX version 2, 3 or 4"),
        (header(version="3.o4"), 1, "expected a number in columns 1-9, found"),
        ("hello\n", 1, "expected a RINEX header with RINEX VERSION / TYPE, found 'hello'"),
        (header("3.04", "N", "M", ("GPSA   1.0000E-08  x.0000E-08", "IONOSPHERIC CORR")), 3, "expected a number in columns 18-29"),
        (header("3.04", "N", "M", ("  abc", "LEAP SECONDS")), 3, "expected a number in columns 1-6, found '  abc'"),
        (changed(MIXED_3, 5, "2024 06", "2024 o6"), 5, "expected year month day hour minute second, found '2024 o6 24 10 00 00'"),
        (changed(MIXED_3, 5, "2024 06", "2024 13"), 5, "expected year month day hour minute second"),
        (changed(MIXED_3, 5, "10 00 00", "10 00 61"), 5, "expected year month day hour minute second"),
        (changed(MIXED_3, 5, "10 00 00", "10 00   "), 5, "expected year month day hour minute second"),
        (changed(MIXED_3, 5, "2024", "9999"), 5, "expected year month day hour minute second"),
        (changed(MIXED_3, 6, "-9.82", "-9,82"), 6, "expected a number in columns 24-42, found '-9,821875000000E+01'"),
        (changed(MIXED_3, 8, "1.224", "1_224"), 8, "expected a number in columns 5-23"),
        (changed(MIXED_3, 8, "1.224000000000E+05", "               nan"), 8, "found 'nan'"),
        (changed(MIXED_3, 5, "-1.364242052659E-12", "           Infinity"), 5, "columns 43-61, found 'Infinity'"),
        (changed(MIXED_3, 5, "G05", "X05"), 5, "expected a satellite (one of G R E C J S I and a number, as G05), found 'X05'"),
        (changed(MIXED_3, 5, "G05", "Gx5"), 5, "expected a satellite"),
        (changed(MIXED_3, 5, "G05", " 05"), 5, "expected a satellite or a record that begins with >"),
        (changed(MIXED_3, 13, "E18", "   "), 13, "expected a satellite, as eight lines make a data set"),
        (changed(GPS_2, 7, " 5 ", "x5 "), 7, "expected a satellite number in columns 1-2"),
        (changed(GPS_2, 8, "4.29", "4 29"), 8, "expected a number in columns 42-60"),
        (header("4.00") + "> XYZ G05 LNAV\n", 4, "expected > EPH, ION, STO or EOP"),
        (header("4.00") + "> EPH Q05 LNAV\n", 4, "expected a satellite"),
        (header("4.00") + "> EPH G05 LNAV\n" + record("G06", EPOCH, GPS), 5, "expected G05 as the line before says, found 'G06'"),
        (header("4.00") + record("G05", EPOCH, GPS), 4, "expected a satellite or a record that begins with >"),
    ],
)
def test_errors_name_line_expected_and_found(refused, text, line, words):
    error = refused(text)
    assert error.line == line
    assert words in str(error)
    assert f"line {line}" in str(error)


@pytest.mark.parametrize(
    ("content", "name", "words"),
    [(b"", "empty.nav", "empty"), (bytes(range(256)) * 9, "binary.nav", "expected a RINEX header"), (b"\x1f\x8b", "two.nav.gz", "gz"),
     (header()[:130].encode(), "cut.nav", "END OF HEADER"), (b"\x00" * 500, "zeros.nav", "expected a RINEX header")],
)  # fmt: skip
def test_files_that_are_none(refused, content, name, words):
    assert words in str(refused(content, name))


def test_missing_files_and_folders(tmp_path):
    for path in (tmp_path, tmp_path / "missing.nav"):
        with pytest.raises(RinexError):
            read_rinex_nav(path)


@pytest.mark.parametrize("text", [MIXED_3, MIXED_4, GPS_2], ids=["3", "4", "2"])
def test_a_file_cut_anywhere_keeps_its_whole_data_sets_and_says_what_it_left_out(tmp_path, text):
    """Every data set that is read is as in the whole file, but for its last line; what is not whole is said."""
    path = tmp_path / "cut.nav"
    path.write_text(text)
    whole = read_rinex_nav(path)
    body = text.index("END OF HEADER") + 20 + 1
    for end in range(body, len(text), 13):
        path.write_text(text[:end])
        eph = read_rinex_nav(path)
        assert set(eph.idot.tolist()) <= set(whole.idot.tolist())
        begun = sum(bool(line[:2].strip()) for line in text[body:end].split("\n"))
        if text is not MIXED_4:  # there records of other kinds stand between
            assert len(eph.satellite) + len(eph.warnings) == begun


def test_a_cut_inside_the_last_number_leaves_the_data_set_out(tmp_path):
    path = tmp_path / "cut.nav"
    path.write_text(MIXED_3.rstrip("\n")[:-30])
    eph = read_rinex_nav(path)
    assert eph.satellites == ("C01", "E18", "G05")
    assert eph.warnings == ("cut.nav: line 29: the data set of J02 is cut off and is left out",)
    path.write_text(MIXED_3.rstrip("\n"))
    assert read_rinex_nav(path).warnings == ()


def test_a_short_data_set_between_others_is_left_out_and_said(tmp_path):
    path = tmp_path / "short.nav"
    short = "".join(record("G05", EPOCH, GPS).splitlines(keepends=True)[:5])
    path.write_text(header() + short + record("G07", EPOCH, GPS))
    eph = read_rinex_nav(path)
    assert eph.satellites == ("G07",)
    assert eph.warnings == ("short.nav: line 4: the data set of G05 is cut off and is left out",)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (" 6.493358730316E+03", " 0.000000000000E+00", "root of the semi-major axis 0,"),
        (" 2.352053998038E-04", " 2.352053998038E+00", "eccentricity 2.35205"),
        (" 1.152000000000E+05", " 7.152000000000E+05", "toe 715200 s"),
        (" 9.039411088452E-04", " 9.039411088452E+04", "clock 90394.1 s"),
        (" 3.987812500000E+02", " 3.98781250000E+299", "is no orbit"),
        (" 3.987812500000E+02", " 3.987812500000E999", "is no orbit"),
    ],
)
def test_data_sets_that_are_no_orbit_are_left_out_and_said(tmp_path, old, new, words):
    assert old in BEIDOU
    path = tmp_path / "odd.nav"
    path.write_text(header() + record("C01", EPOCH, BEIDOU.replace(old, new)) + record("G07", EPOCH, GPS))
    eph = read_rinex_nav(path)
    assert eph.satellites == ("G07",)
    assert len(eph.warnings) == 1
    assert words in eph.warnings[0]
    assert eph.warnings[0].startswith("odd.nav: line 4: the data set of C01 is no orbit")


# Any bytes ------------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    return tmp_path_factory.mktemp("fuzz") / "any.nav"


def only_rinex_error(place, content):
    place.write_bytes(content)
    with suppress(RinexError):
        read_rinex_nav(place)


TEXTS = st.sampled_from([MIXED_3, MIXED_4, GPS_2, MIXED_3.replace("\n", "\r\n")])


@given(st.binary(max_size=300))
@settings(max_examples=200, deadline=None)
@example(gzip.compress(b""))
@example(b"\xef\xbb\xbf")
def test_no_bytes_raise_anything_else(place, content):
    only_rinex_error(place, content)


@given(st.sampled_from(["2.10", "3.04", "4.00"]), st.binary(max_size=400))
@settings(max_examples=200, deadline=None)
def test_no_body_raises_anything_else(place, version, body):
    only_rinex_error(place, header(version).encode() + body)


@given(TEXTS, st.lists(st.tuples(st.integers(0, 3500), st.integers(0, 3), st.binary(max_size=3)), min_size=1, max_size=5))
@settings(max_examples=400, deadline=None)
def test_no_damage_raises_anything_else(place, text, damages):
    content = text.encode()
    for start, length, new in damages:
        content = content[:start] + new + content[start + length :]
    only_rinex_error(place, content)


@given(TEXTS, st.data())
@settings(max_examples=200, deadline=None)
def test_no_shuffled_lines_raise_anything_else(place, text, data):
    lines = text.encode().splitlines(keepends=True)
    kept = data.draw(st.lists(st.integers(1, len(lines) - 1), max_size=40))
    only_rinex_error(place, lines[0] + b"".join(lines[k] for k in kept))


@given(st.text("0123456789.+-EeDd ", min_size=19, max_size=19), st.integers(0, 30))
@settings(max_examples=300, deadline=None)
def test_no_number_raises_anything_else(place, number, place_of_number):
    text = record("G05", EPOCH, GPS)
    lines = [line.ljust(80) for line in text.splitlines()]
    below, across = divmod(place_of_number + 1, 4)
    start = 4 + 19 * across
    lines[below] = lines[below][:start] + number + lines[below][start + 19 :]
    only_rinex_error(place, (header() + "\n".join(lines) + "\n").encode())
