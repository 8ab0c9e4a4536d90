"""Reading navigation files of all three generations: by hand, against a naive reader, and real ones."""

import gzip
import re

import numpy as np
import pytest
from navigation_texts import BEIDOU, COEFFICIENTS, EPOCH, GALILEO, GLONASS, GPS, GPS_2, MIXED_3, MIXED_4, QZSS, header, record

from gnsslab.gnss.rinex.navigation_reader import merge_ephemerides, read_rinex_nav, within_half_a_week
from gnsslab.gnss.times import BDT_BEHIND_GPS

MINUTE = np.timedelta64(60, "s")


@pytest.fixture
def read(tmp_path):
    """A function from a text to the ephemerides of the file that holds it."""

    def read_text(text, name="test.nav"):
        path = tmp_path / name
        path.write_bytes(text.encode("latin-1"))
        return read_rinex_nav(path)

    return read_text


def test_every_field_of_gps_stands_in_its_place(read):
    eph = read(header() + record("G05", EPOCH, GPS))
    got = {name: getattr(eph, name)[0] for name in ("af0", "af1", "af2", "crs", "delta_n", "m0", "cuc", "e", "cus", "sqrt_a", "cic", "omega0",
           "cis", "i0", "crc", "omega", "omega_dot", "idot", "accuracy")}  # fmt: skip
    assert got == {
        "af0": -1.774230040610e-04, "af1": -1.364242052659e-12, "af2": 0.0, "crs": -98.21875, "delta_n": 4.293035965037e-09,
        "m0": 1.714815412488, "cuc": -5.291774868965e-06, "e": 5.927642923780e-03, "cus": 1.830980181694e-06, "sqrt_a": 5153.635631561,
        "cic": 3.352761268616e-08, "omega0": 2.520897825810, "cis": -5.774199962616e-08, "i0": 0.9719266524177, "crc": 353.625,
        "omega": 1.273307347665, "omega_dot": -8.275344701323e-09, "idot": -2.610823036973e-10, "accuracy": 2.0,
    }  # fmt: skip
    assert (eph.issue[0], eph.clock_issue[0], eph.health[0]) == (72, 72, 0)
    assert eph.group_delay.tolist() == [[-1.071020960808e-08, 0.0]]
    assert eph.toc[0] == eph.toe[0] == np.datetime64("2024-06-24T10:00:00")
    assert eph.transmission[0] == np.datetime64("2024-06-24T08:00:18")
    assert repr(eph) == "Ephemerides: 1 data sets of 1 satellites"


def test_systems_keep_their_own_conventions(read):
    """BeiDou's times are 14 s behind; Galileo's and BeiDou's second group delays, data sources and AODC have their places."""
    eph = read(MIXED_3)
    c01, e18, _, j02 = range(4)
    assert eph.satellites == ("C01", "E18", "G05", "J02")
    assert eph.toe[c01] == eph.toc[c01] == np.datetime64("2024-06-24T08:00:00") + BDT_BEHIND_GPS
    assert eph.transmission[c01] == np.datetime64("2024-06-24T08:00:27.6") + BDT_BEHIND_GPS  # 115227.6 s = 1 d 8 h 27.6 s
    assert eph.group_delay[c01].tolist() == [-4.9e-09, -1.0e-08]
    assert eph.group_delay[e18].tolist() == [-9.313225746155e-10, -2.095475792885e-09]
    assert eph.clock_issue.tolist() == [3, 517, 72, 797]
    assert eph.issue.tolist() == [1, 60, 72, 29]
    assert eph.health.tolist() == [0, 0, 0, 1]
    assert eph.toe[e18] == np.datetime64("2024-06-24T07:10:00")
    assert (eph.leap_seconds, eph.ionosphere, eph.warnings) == (18, {}, ())
    assert eph.group_delay[j02].tolist() == [-6.053596735001e-09, 0.0]


def test_rinex_4_gives_the_same_data_sets_as_rinex_3(read):
    old, new = read(MIXED_3, "old.nav"), read(MIXED_4, "new.nav")
    for satellite in old.satellites:
        a, b = np.nonzero(old.satellite == satellite)[0][0], np.nonzero(new.satellite == satellite)[0][0]
        for name in ("toe", "toc", "transmission", "sqrt_a", "af0", "idot", "issue", "clock_issue", "health"):
            assert getattr(new, name)[b] == getattr(old, name)[a], f"{satellite} {name}"
    assert new.satellite.tolist() == ["C01", "C19", "E18", "E18", "G05", "J02"]
    assert sorted(new.clock_issue[2:4].tolist()) == [258, 517]
    assert new.ionosphere.keys() == {"G", "C"}
    assert new.ionosphere["G"].tolist() == COEFFICIENTS
    assert new.leap_seconds == 18
    skipped = ("GPS CNAV", "BeiDou CNV1", "GLONASS FDMA")
    assert new.warnings == tuple(f"new.nav: 1 {name} data set is not used here" for name in skipped)


def test_rinex_2(read):
    eph = read(GPS_2)
    assert eph.satellites == ("G05",)
    assert eph.toe[0] == np.datetime64("2024-06-24T10:00:00")
    assert eph.af0[0] == -1.774230040610e-04
    assert eph.transmission[0] == np.datetime64("2024-06-24T08:00:18")
    assert eph.ionosphere["G"].tolist() == [1.118e-08, 1.49e-08, -5.96e-08, -5.96e-08, 88060.0, 16380.0, -196600.0, -131100.0]
    assert eph.leap_seconds == 13


@pytest.mark.parametrize(("kind", "count"), [("G: GLONASS NAV DATA", "GLONASS"), ("H: GEO NAV MSG DATA", "SBAS")])
def test_rinex_2_of_other_systems_is_counted(read, kind, count):
    eph = read(header("2.11", kind, "") + 2 * record(" 1", "24  6 24 10  0  0.0", GLONASS, indent=3))
    assert len(eph.satellite) == 0
    assert eph.warnings == (f"test.nav: 2 {count} data sets are not used here",)


@pytest.mark.parametrize(
    ("kind", "satellite", "numbers", "toe"), [("E: GALILEO NAV DATA", "E18", GALILEO, "07:10"), ("J: QZSS NAV DATA", "J18", QZSS, "10:00")]
)
def test_rinex_2_12_of_galileo_and_qzss(read, kind, satellite, numbers, toe):
    nequick = ("    4.9250D+01  2.0703D-01  4.0283D-03", "ION ALPHA")
    eph = read(header("2.12", kind, "", *([nequick] if "GAL" in kind else [])) + record("18", "24  6 24  7 10  0.0", numbers, indent=3))
    assert eph.satellites == (satellite,)
    assert eph.toe[0] == np.datetime64(f"2024-06-24T{toe}:00")
    assert (eph.ionosphere, eph.warnings) == ({}, ())


def test_rounded_copies_of_merged_files_are_repetitions(read):
    """As IGS merges them: I/NAV with bits of E1, E5b and both, one of them with two digits less; F/NAV is another message."""
    copies = [GALILEO.replace(" 5.170000000000E+02", f" {bits:.12E}") for bits in (258, 513, 516, 517)]
    copies[2] = copies[2].replace("2.575535327196E-04", "2.575535327200E-04")
    eph = read(header() + "".join(record("E18", "2024 06 24 07 10 00", text) for text in copies))
    assert eph.clock_issue.tolist() == [258, 513]


@pytest.mark.parametrize(("year", "expected"), [("94", "1994"), ("00", "2000"), (" 5", "2005"), ("79", "2079")])
def test_years_of_two_digits(read, year, expected):
    text = header("2.10", "N: GPS NAV DATA", "") + record(" 5", f"{year}  6 24 10  0  0.0", GPS, indent=3)
    assert str(read(text).toc[0]).startswith(f"{expected}-06-24T10:00:00")


@pytest.mark.parametrize("letter", ["D", "d", "e"])
def test_all_exponent_letters_mean_the_same(read, letter):
    same = read(header() + record("G05", EPOCH, GPS.replace("E", letter)), "other.nav")
    assert same.sqrt_a[0] == 5153.635631561
    assert same.af0[0] == -1.774230040610e-04


def test_dos_line_ends_gzip_and_a_dos_end_mark(read, tmp_path):
    plain = read(MIXED_3)
    dos = read(MIXED_3.replace("\n", "\r\n") + "\x1a", "dos.nav")
    packed = tmp_path / "test.nav.gz"
    packed.write_bytes(gzip.compress(MIXED_3.encode()))
    for other in (dos, read_rinex_nav(packed)):
        assert other.af0.tolist() == plain.af0.tolist()
        assert other.warnings == ()


def test_blank_fields_are_zero_and_an_unwritten_transmission_unknown(read):
    lines = GPS.replace(" 2.000000000000E+00 0.000000000000E+00-1.0", " 2.000000000000E+00" + 19 * " " + "-1.0").splitlines()
    eph = read(header() + record("G 5", EPOCH, "\n".join([*lines[:-1], ""]) + "\n\n"))
    assert eph.satellites == ("G05",)
    assert eph.health[0] == 0
    assert eph.group_delay[0, 0] == -1.071020960808e-08
    assert np.isnat(eph.transmission[0])


def test_unknown_transmission_and_accuracy(read):
    numbers = GPS.replace(" 1.152180000000E+05 4.0", " 9.999000000000E+08 4.0").replace(" 2.000000000000E+00 0.0", " 8.192000000000E+03 0.0")
    eph = read(
        header() + record("G05", EPOCH, numbers) + record("E18", "2024 06 24 07 10 00", GALILEO.replace(" 3.120000000000E+00", "-1.000000000000E+00"))
    )
    assert np.isnat(eph.transmission[1])
    assert np.isnan(eph.accuracy).all()


@pytest.mark.parametrize("week", [" 2.320000000000E+03", " 2.720000000000E+02", " 0.000000000000E+00", 19 * " ", " 1.360000000000E+03"])
def test_wrong_and_missing_weeks_do_not_matter(read, week):
    eph = read(header() + record("G05", EPOCH, GPS.replace(" 2.320000000000E+03", week)))
    assert eph.toe[0] == np.datetime64("2024-06-24T10:00:00")


@pytest.mark.parametrize(
    ("toc", "tow", "toe"),
    [("2024 06 22 23 59 44", 0.0, "2024-06-23T00:00:00"), ("2024 06 23 00 00 00", 604_784.0, "2024-06-22T23:59:44"),
     ("2024 06 23 02 00 00", 7200.0, "2024-06-23T02:00:00")],
)  # fmt: skip
def test_toe_at_the_turn_of_the_week(read, toc, tow, toe):
    eph = read(header() + record("G05", toc, GPS.replace(" 1.224000000000E+05", f"{tow:19.12E}")))
    assert eph.toe[0] == np.datetime64(toe)


def test_beidous_week_turns_14_seconds_after_gps(read):
    eph = read(header() + record("C01", "2024 06 23 00 00 00", BEIDOU.replace(" 1.152000000000E+05", " 0.000000000000E+00")))
    assert eph.toe[0] == np.datetime64("2024-06-23T00:00:14")
    assert within_half_a_week(np.datetime64("2024-06-23T00:00:00"), 604_799.0) == np.datetime64("2024-06-22T23:59:59")


def test_repeated_data_sets_stand_once_and_several_files_become_one(read, tmp_path):
    first = read(MIXED_3, "first.nav")
    later = GPS.replace(" 1.152180000000E+05", " 1.152480000000E+05")
    second = header("3.04", "N", "G", *klobuchar_lines("GPS"), ("    17", "LEAP SECONDS"))
    (tmp_path / "second.nav").write_text(second + record("G05", EPOCH, later) + record("G07", EPOCH, GPS))
    eph = read_rinex_nav(tmp_path / "first.nav", str(tmp_path / "second.nav"))
    assert eph.satellite.tolist() == ["C01", "E18", "G05", "G07", "J02"]
    assert eph.transmission[2] == first.transmission[2]
    assert eph.leap_seconds == 18
    assert eph.ionosphere.keys() == {"G"}
    assert eph.source == f"{tmp_path / 'first.nav'}, {tmp_path / 'second.nav'}"


def test_other_health_or_issue_is_no_repetition(read):
    ill = GPS.replace(" 2.000000000000E+00 0.000000000000E+00", " 2.000000000000E+00 6.300000000000E+01")
    newer = GPS.replace(" 7.200000000000E+01", " 7.300000000000E+01")
    assert len(read(header() + "".join(record("G05", EPOCH, text) for text in (GPS, ill, newer, GPS))).satellite) == 3


def test_rows_are_sorted_by_satellite_and_toe(read):
    later, earlier = GPS.replace(" 1.224000000000E+05", " 1.296000000000E+05"), GPS
    eph = read(header() + record("G07", EPOCH, GPS) + record("G05", "2024 06 24 12 00 00", later) + record("G05", EPOCH, earlier))
    assert eph.satellite.tolist() == ["G05", "G05", "G07"]
    assert eph.toe[1] - eph.toe[0] == 120 * MINUTE


def test_other_systems_are_counted_and_no_file_name_is_said(read):
    eph = read(header() + record("R01", EPOCH, GLONASS) + record("R02", EPOCH, GLONASS) + record("I02", EPOCH, GPS) + record("G05", EPOCH, GPS))
    assert eph.warnings == ("test.nav: 2 GLONASS data sets are not used here", "test.nav: 1 NavIC data set is not used here")
    assert len(read(header()).satellite) == 0
    with pytest.raises(ValueError, match="at least one navigation file"):
        read_rinex_nav()


def klobuchar_lines(name, first=1):
    """Return the two header lines of a system, with the numbers first to first + 7."""
    numbers = [f"{value:12.4E}" for value in range(first, first + 8)]
    return [(f"{name}A " + "".join(numbers[:4]), "IONOSPHERIC CORR"), (f"{name}B " + "".join(numbers[4:]), "IONOSPHERIC CORR")]


def test_ionosphere_of_all_systems(read):
    lines = [line for name in ("GPS", "BDS", "QZS") for line in klobuchar_lines(name)]
    later = [*klobuchar_lines("GPS", first=9), ("GAL    4.5500D+01  5.8590D-01  2.2280D-03", "IONOSPHERIC CORR")]
    eph = read(header("3.04", "N", "M", *lines, *later))
    assert sorted(eph.ionosphere) == ["C", "G", "J"]
    assert [values.tolist() for values in eph.ionosphere.values()] == 3 * [[1, 2, 3, 4, 5, 6, 7, 8]]
    assert eph.warnings == ()


def test_half_or_zero_ionosphere_is_left_out_and_said(read):
    zeros = [(f"BDS{half} " + 4 * "  0.0000E+00", "IONOSPHERIC CORR") for half in "AB"]
    eph = read(header("3.04", "N", "M", klobuchar_lines("GPS")[0], *zeros))
    assert eph.ionosphere == {}
    assert [("GPS" in w, "BeiDou" in w) for w in eph.warnings] == [(True, False), (False, True)]


def test_leap_seconds_told_in_beidou_time(read):
    line = "     4     4   185     7BDS"
    assert read(header("3.05", "N", "M", (line, "LEAP SECONDS"))).leap_seconds == 18


# Real files -----------------------------------------------------------------------------------------------------------


def naive(text):
    """Another reader, without columns: numbers are found by their looks, satellites by the letter at the line's start."""
    body = text.split("END OF HEADER")[1].splitlines()[1:]
    number = re.compile(r"[-+]?\d*\.\d+[DE][-+]\d\d")
    data = {}
    for line in body:
        if line[:1].isalpha():
            key = [line[:3], line[4:23]]
            rest = line[23:]
        else:
            rest = line
        values = [float(found.replace("D", "E")) for found in number.findall(rest)]
        data.setdefault(tuple(key), []).extend([values])
    return data


@pytest.mark.parametrize(("name", "file"), [("matrtklib-static", "base.nav"), ("beidou-slope", "base_all.nav"), ("cssrlib-078", "30340780.21q")])
def test_real_files_hold_what_a_naive_reader_finds(dataset, name, file):
    path = dataset(name) / file
    eph = read_rinex_nav(path)
    found = {key: lines for key, lines in naive(path.read_text()).items() if key[0][0] in "GECJ"}
    assert {key[0] for key in found} == set(eph.satellites)
    ours = set(
        zip(eph.satellite.tolist(), eph.af0.tolist(), eph.e.tolist(), eph.cis.tolist(), eph.omega_dot.tolist(), eph.idot.tolist(), strict=True)
    )
    theirs = {(key[0], lines[0][0], lines[2][1], lines[3][3], lines[4][3], lines[5][0]) for key, lines in found.items()}
    assert theirs <= ours


def test_counts_of_the_real_files(dataset):
    """Satellites and data sets as RTKLIB counts them, repeats dropped; 19 GLONASS data sets stand in the file."""
    eph = read_rinex_nav(dataset("matrtklib-static") / "base.nav")
    assert (len(eph.satellite), len(eph.satellites), eph.leap_seconds) == (109, 62, 18)
    assert eph.warnings == ("base.nav: 19 GLONASS data sets are not used here",)
    both = read_rinex_nav(*(dataset("geonet-0759-3040") / name for name in ("07590920.05n", "30400920.05n")))
    one = read_rinex_nav(dataset("geonet-0759-3040") / "07590920.05n")
    assert set(one.satellites) <= set(both.satellites)
    assert len(one.satellite) <= len(both.satellite) < 1.1 * len(one.satellite)
    assert len(merge_ephemerides([both, both]).satellite) == len(both.satellite)
