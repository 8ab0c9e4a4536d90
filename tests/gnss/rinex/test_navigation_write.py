"""Navigation files that are written: they read back, other programs read them, and they are whole or not there."""

from dataclasses import replace

import numpy as np
import pytest
from navigation_texts import MIXED_3, MIXED_4

from gnsslab.gnss.ephemerides import ARRAY_FIELDS
from gnsslab.gnss.rinex.errors import RinexError
from gnsslab.gnss.rinex.navigation_reader import read_rinex_nav
from gnsslab.gnss.rinex.navigation_writer import write_rinex_nav
from gnsslab.gnss.times import BDT_WEEK_ZERO

HALF_A_DIGIT = 5.1e-13  # thirteen significant digits: at most 5e-13 of the value, and its rounding
FILES = [("matrtklib-static", "base.nav"), ("beidou-slope", "base_all.nav"), ("cssrlib-078", "SEPT078M.21P"), ("geonet-0759-3040", "07590920.05n")]


@pytest.fixture
def mixed(tmp_path):
    path = tmp_path / "mixed.nav"
    path.write_text(MIXED_4)
    return read_rinex_nav(path)


def assert_equal(a, b, ionosphere=1e-5):
    for name in ARRAY_FIELDS:
        x, y = getattr(a, name), getattr(b, name)
        if x.dtype.kind == "f":
            np.testing.assert_allclose(x, y, rtol=HALF_A_DIGIT, err_msg=name)
        else:
            np.testing.assert_array_equal(x, y, err_msg=name)
    assert a.leap_seconds == b.leap_seconds
    assert a.ionosphere.keys() == b.ionosphere.keys()
    for name, coefficients in a.ionosphere.items():
        np.testing.assert_allclose(coefficients, b.ionosphere[name], rtol=ionosphere)


def test_what_is_written_reads_back(mixed, tmp_path):
    write_rinex_nav(tmp_path / "out.nav", mixed)
    again = read_rinex_nav(tmp_path / "out.nav")
    assert_equal(again, mixed, ionosphere=5.1e-5)
    assert again.warnings == ()


def test_a_name_ending_in_gz_is_compressed(mixed, tmp_path):
    write_rinex_nav(tmp_path / "out.nav.gz", mixed)
    assert (tmp_path / "out.nav.gz").read_bytes().startswith(b"\x1f\x8b")
    assert_equal(read_rinex_nav(tmp_path / "out.nav.gz"), mixed, ionosphere=5.1e-5)


def test_the_second_writing_is_the_first_but_for_its_date(mixed, tmp_path):
    write_rinex_nav(tmp_path / "first.nav", mixed)
    write_rinex_nav(tmp_path / "second.nav", read_rinex_nav(tmp_path / "first.nav"))
    first, second = ([line for line in (tmp_path / name).read_text().splitlines() if "DATE" not in line] for name in ("first.nav", "second.nav"))
    assert first == second


@pytest.mark.parametrize(("name", "file"), FILES)
def test_real_files_read_back(dataset, tmp_path, name, file):
    eph = read_rinex_nav(dataset(name) / file)
    write_rinex_nav(tmp_path / "out.nav", eph)
    assert_equal(read_rinex_nav(tmp_path / "out.nav"), eph, ionosphere=5.1e-5)


def test_lines_are_those_of_the_format(tmp_path):
    """Byte for byte the hand-written file, where the format leaves no choice."""
    (tmp_path / "in.nav").write_text(MIXED_3)
    write_rinex_nav(tmp_path / "out.nav", read_rinex_nav(tmp_path / "in.nav"))
    lines, by_hand = (tmp_path / "out.nav").read_text().splitlines(), MIXED_3.splitlines()
    assert all(len(line) <= 80 for line in lines)
    assert lines[0] == "     3.04           N: GNSS NAV DATA    M: MIXED            RINEX VERSION / TYPE"
    assert [line[60:].strip() for line in lines[:4]] == ["RINEX VERSION / TYPE", "PGM / RUN BY / DATE", "LEAP SECONDS", "END OF HEADER"]
    g05, c01 = lines.index(by_hand[4]), lines.index(by_hand[20])
    assert lines[c01 : c01 + 8] == by_hand[20:28]
    assert lines[g05 : g05 + 5] == by_hand[4:9]
    assert lines[g05 + 6] == by_hand[10]


def test_rtklib_reads_the_same_numbers(rtk, mixed, tmp_path):
    write_rinex_nav(tmp_path / "out.nav", mixed)
    nav = rtk.nav_t()
    rtk.readrnx(str(tmp_path / "out.nav"), 1, "", rtk.obs_t(), nav, rtk.sta_t())
    assert nav.n == len(mixed.satellite)
    theirs = sorted((nav.eph[k].toes, nav.eph[k].A, nav.eph[k].f0, nav.eph[k].M0, nav.eph[k].week) for k in range(nav.n))
    for (toes, a, f0, m0, week), row in zip(theirs, sorted(range(nav.n), key=lambda k: key_of(mixed, k)), strict=True):
        assert toes == key_of(mixed, row)[0]
        assert week == (2320 - BDT_WEEK_ZERO if mixed.satellite[row][0] == "C" else 2320)
        np.testing.assert_allclose([a, f0, m0], [mixed.sqrt_a[row] ** 2, mixed.af0[row], mixed.m0[row]], rtol=1e-12)


def key_of(ephemerides, row):
    """Seconds of week in the system's own time, then what RTKLIB's records are sorted by."""
    behind = 14 if ephemerides.satellite[row][0] == "C" else 0
    seconds = (ephemerides.toe[row] - np.datetime64("2024-06-23", "ns")) / np.timedelta64(1, "s") - behind
    return (seconds, ephemerides.sqrt_a[row] ** 2, ephemerides.af0[row], ephemerides.m0[row])


def test_unknown_things_are_written_as_the_format_has_them(mixed, tmp_path):
    unknown = replace(
        mixed, transmission=np.full_like(mixed.transmission, np.datetime64("NaT")), accuracy=np.full_like(mixed.accuracy, np.nan), leap_seconds=None
    )
    write_rinex_nav(tmp_path / "out.nav", unknown)
    again = read_rinex_nav(tmp_path / "out.nav")
    assert np.isnat(again.transmission).all()
    assert np.isnan(again.accuracy).all()
    assert again.leap_seconds is None


def test_nothing_and_tiny_numbers_can_be_written(mixed, tmp_path):
    empty = replace(mixed, **{name: getattr(mixed, name)[:0] for name in ARRAY_FIELDS})
    write_rinex_nav(tmp_path / "empty.nav", empty)
    assert len(read_rinex_nav(tmp_path / "empty.nav").satellite) == 0
    write_rinex_nav(tmp_path / "tiny.nav", replace(mixed, af2=np.full_like(mixed.af2, -1e-150)))
    assert read_rinex_nav(tmp_path / "tiny.nav").af2.tolist() == [0.0] * len(mixed.af2)


def test_a_clock_reference_between_seconds_is_refused(mixed, tmp_path):
    with pytest.raises(ValueError, match="toc in whole seconds, as RINEX 3 writes it; that of C01"):
        write_rinex_nav(tmp_path / "out.nav", replace(mixed, toc=mixed.toc + np.timedelta64(1, "ms")))
    assert not (tmp_path / "out.nav").exists()


def test_a_place_that_cannot_be_written_is_named_and_nothing_is_left(mixed, tmp_path):
    (tmp_path / "folder").mkdir()
    for path in (tmp_path / "folder", tmp_path / "missing" / "out.nav"):
        with pytest.raises(RinexError, match="cannot be written"):
            write_rinex_nav(path, mixed)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["folder", "mixed.nav"]
