"""RTKLIB's solution files: one solution in every format it writes, with and without header, and files that are wrong."""

import gzip
from pathlib import Path

import numpy as np
import pytest

from gnsslab.gnss.relative import Status
from gnsslab.gnss.rinex.errors import RinexError
from gnsslab.gnss.series_files import read_series
from gnsslab.gnss.series_files.pos import rotated_sigma

FOLDER = Path(__file__).parents[1] / "reference" / "rtklib-pos"
FILES = sorted(FOLDER.glob("*.pos"))
MAIN = FOLDER / "llh-hms-gpst.pos"
PRINTED = 0.3e-3  # [m]: seconds of arc are printed to 1e-5 (0.3 mm), degrees to 1e-9 (0.1 mm), metres to 1e-4
PRINTED_SIGMA = 0.2e-3  # [m]: roots of covariances are printed to 1e-4, and rotating them adds three of them up
HEAD = MAIN.read_text().splitlines()[:10]
ROWS = MAIN.read_text().splitlines()[10:]


@pytest.fixture
def written(tmp_path):
    """Write lines of text or bytes to a file and return its path."""

    def write(content, name="a.pos"):
        path = tmp_path / name
        path.write_bytes(content if isinstance(content, bytes) else "\n".join([*content, ""]).encode())
        return path

    return write


def test_there_is_a_file_for_every_format():
    assert len(FILES) == 15


@pytest.mark.parametrize("path", [path for path in FILES if path.stem != "llh-geoid"], ids=lambda path: path.stem)
def test_one_solution_in_every_format(path):
    """RTKLIB's own east, north, up are the second route for latitudes, longitudes and ECEF coordinates."""
    fields = np.array([line.split(";")[1:] for line in (FOLDER / "enu-hms-semicolon-jst.pos").read_text().splitlines()[10:]], dtype=float)
    series, notes = read_series(path)
    assert series.time.tolist() == (np.datetime64("2024-06-24T08:20:00", "ns") + np.arange(6) * np.timedelta64(1, "s")).tolist()
    np.testing.assert_allclose(series.enu, fields[:, :3], atol=PRINTED)
    np.testing.assert_allclose(series.sigma, fields[:, 5:8], atol=PRINTED_SIGMA)
    assert (series.status == Status.FIXED).all()
    assert series.ratio.tolist() == fields[:, 12].tolist()
    assert any("header" in note or "as the file gives them" in note for note in notes)


def test_heights_above_the_geoid_are_told():
    series, notes = read_series(FOLDER / "llh-geoid.pos")
    assert any("above the geoid" in note for note in notes)
    np.testing.assert_allclose(series.enu[:, 2] - read_series(MAIN)[0].enu[:, 2], -37.779, atol=PRINTED)


@pytest.mark.parametrize("path", [path for path in FILES if "utc" not in path.stem and "jst" not in path.stem], ids=lambda path: path.stem)
def test_without_header_the_format_is_guessed_and_said(path, written):
    whole, _ = read_series(path)
    series, notes = read_series(written([line for line in path.read_text().splitlines() if not line.startswith("%")]))
    assert notes[0].startswith("no header: taken as GPS time")
    assert np.array_equal(series.time, whole.time)
    np.testing.assert_allclose(np.diff(series.enu, axis=0), np.diff(whole.enu, axis=0), atol=1e-5)
    np.testing.assert_allclose(series.sigma, whole.sigma, atol=1e-6)


def test_without_reference_positions_are_about_the_median_of_the_fixed_ones(written):
    rows = [*ROWS[:4], ROWS[4].replace("  1  40 ", "  2  40 ").replace("35.1346", "35.1356")]
    series, notes = read_series(written([HEAD[-1], *rows]))
    assert "median of all fixed positions" in notes[0]
    np.testing.assert_allclose(np.median(series.enu[:4], axis=0), 0, atol=PRINTED)
    assert series.enu[4, 1] > 100


@pytest.mark.parametrize(("quality", "status"), [(1, 2), (2, 1), (3, 1), (4, 1), (5, 1), (6, 1), (7, 1), (0, 0)])
def test_quality(quality, status, written):
    series, notes = read_series(written([*HEAD, *ROWS[:3], ROWS[3].replace("  1  40 ", f"  {quality}  40 ")]))
    assert series.status.tolist() == [2, 2, 2, status]
    assert any("taken as float: 1 epoch" in note for note in notes) == (quality > 2)


def test_ratio_zero_is_none_and_short_rows_have_none(written):
    series, _ = read_series(written([*HEAD, *(line[: line.rindex("0.00")] + "0.00    0.0" for line in ROWS)]))
    assert np.isnan(series.ratio).all()
    series, _ = read_series(written([*HEAD, *(" ".join(line.split()[:7]) for line in ROWS)]))
    assert np.isnan(series.ratio).all()
    assert np.isnan(series.sigma).all()
    assert len(series) == 6


def test_south_and_west_of_zero_degrees(written):
    """-00 degrees keep their sign: 30 m south of the equator are not 30 m north of it."""
    head = ["%  GPST                    latitude(d'\")   longitude(d'\")  height(m)   Q  ns"]
    rows = [
        f"2024/06/24 08:20:0{k}.000  {lat} {lon} 10.0 1 9"
        for k, (lat, lon) in enumerate([("-00 00 01.0", "-00 00 02.0"), ("00 00 01.0", "00 00 02.0")])
    ]
    east, north, _ = (read_series(written([*head, *rows]))[0].enu[1] - read_series(written([*head, *rows]))[0].enu[0]).tolist()
    assert north == pytest.approx(2 * 6335439 * np.pi / 648000, abs=0.01)  # meridional radius at the equator, a (1 - e2)
    assert east == pytest.approx(4 * 6378137 * np.pi / 648000, abs=0.01)


def test_rotation_with_cross_terms_against_the_matrix_product(rng):
    for _ in range(20):
        root = rng.normal(size=(3, 3))
        Q, R = root @ root.T, np.linalg.qr(rng.normal(size=(3, 3)))[0]
        spread = [np.sign(q) * abs(q) ** 0.5 for q in (Q[0, 0], Q[1, 1], Q[2, 2], Q[0, 1], Q[1, 2], Q[2, 0])]
        np.testing.assert_allclose(rotated_sigma(np.array([spread]), R[None])[0] ** 2, np.diag(R @ Q @ R.T))


def test_a_standard_deviation_that_rtklib_prints_as_zero_is_not_stated(written):
    series, notes = read_series(written([*HEAD, ROWS[0], ROWS[1].replace("0.0024   0.0024", "0.0000   0.0024")]))
    assert np.isnan(series.sigma[1]).tolist() == [False, True, False]  # sdn is the first that RTKLIB prints, north our second
    assert any("1 row with a standard deviation of zero" in note for note in notes)


def test_line_ends_byte_order_mark_and_compression_change_nothing(written):
    whole, notes = read_series(MAIN)
    plain = MAIN.read_bytes()
    for content in (plain.replace(b"\n", b"\r\n"), b"\xef\xbb\xbf" + plain, gzip.compress(plain), plain.decode().encode("utf-16"), plain.rstrip()):
        series, said = read_series(written(content))
        assert np.array_equal(series.enu, whole.enu)
        assert np.array_equal(series.time, whole.time)
        assert said == notes


def test_progress_counts_the_bytes_of_the_file(written):
    calls = []
    path = written([*HEAD, *(ROWS[0].replace("08:20:00.000", f"{k // 3600:02d}:{k // 60 % 60:02d}:{k % 60:02d}.000") for k in range(20_000))])
    series, _ = read_series(path, progress=lambda done, total: calls.append((done, total)))
    assert len(series) == 20_000  # in more than one piece
    assert len(calls) > 2
    assert calls[-1] == (path.stat().st_size,) * 2


def test_a_solution_of_our_own(tmp_path):
    from gnsslab.cli.tables import write_relative_pos
    from gnsslab.gnss.frames import ecef_from_geodetic
    from gnsslab.gnss.relative import Relative

    time = np.datetime64("2024-06-24T08:20:00", "ns") + np.arange(3) * np.timedelta64(1, "s")
    place = np.tile(ecef_from_geodetic([0.6, 2.4, 100.0]), (3, 1))
    Q = np.tile(np.diag([4e-6, 9e-6, 25e-6]), (3, 1, 1))
    enu = np.zeros((3, 3))
    write_relative_pos(tmp_path / "o.pos", Relative(time, np.array([2, 0, 1]), enu, enu, Q, place, np.full(3, 5.0), np.full(3, 9)))
    series, _ = read_series(tmp_path / "o.pos")
    assert np.array_equal(series.time, time[[0, 2]])
    assert series.status.tolist() == [2, 1]
    np.testing.assert_allclose(series.sigma, [[2e-3, 3e-3, 5e-3]] * 2)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "the file is empty"),
        (HEAD, "a header but no rows"),
        ([*HEAD, ROWS[0], ROWS[1].replace("35.1346", "35.x346"), ROWS[2]], "line 12: expected a number in column 3, found '35.x346"),
        ([*HEAD, ROWS[0], ROWS[1].replace("/06/24", "/13/24")], r"line 12: expected a date like .* found '2024-13-24"),
        ([*HEAD, ROWS[0], ROWS[1][:40], ROWS[2]], "line 12: expected 6 fields, as in the rows before, found 3"),
        ([*HEAD, ROWS[0].replace("  1  40 ", "  9  40 ")], "line 11: expected a quality Q from 0 to 7, found '9'"),
        ([*HEAD, *ROWS, *(FOLDER / "xyz-tow-blank.pos").read_text().splitlines()], "line 23: .*another reference|line 2[0-9]: a second header"),
        ([*HEAD, *ROWS, *[line.replace("104.8530", "104.9530") for line in HEAD], *ROWS], "line 23: a second header with another reference position"),
        ([HEAD[-1], *ROWS, HEAD[-1].replace("GPST", "UTC "), *ROWS], "line 8: a second header with another format"),
        (["$GPGGA,081951.00,3508.08,N,13658.65,E,4,42,1.0,66.1,M,37.8,M,0.0,0*6A"], "NMEA sentences"),
        (["hello", "world"], "line 1: expected a row of RTKLIB's solution, found 'hello'"),
        (gzip.compress(MAIN.read_bytes())[:200], "damaged or cut short"),
        (b"PK\x03\x04 and more", "zip archive or spreadsheet"),
        (bytes(range(256)) * 4, "not a text file"),
        (["2320 700000.0 35.134699014 136.977575478 104.8601 1 40"], "line 1: expected a GPS week and seconds from 0 to 604800, found 2320 700000.0"),
    ],
)
def test_files_that_are_wrong(content, words, written):
    with pytest.raises(ValueError, match=words) as told:
        read_series(written(content))
    assert not isinstance(told.value, RinexError)
    assert "\n" not in str(told.value)


def test_columns_and_unit_are_for_plain_tables():
    with pytest.raises(ValueError, match="states its own columns"):
        read_series(MAIN, unit="mm")


def test_the_same_header_again_is_no_harm_and_repeated_rows_count_once(written):
    series, notes = read_series(written([*HEAD, *ROWS, *HEAD, *ROWS]))
    assert len(series) == 6
    assert "times go backward at 1 place, first to 2024-06-24T08:20:00.000: sorted" in notes
    assert "6 rows repeating another left out" in notes
    assert "12 rows give 6 epochs" in notes


def test_a_last_line_cut_short_is_left_out_and_said(written):
    series, notes = read_series(written("\n".join([*HEAD, *ROWS])[:-90].encode()))
    assert len(series) == 5
    assert "the last line is cut short: left out" in notes


def test_real_solutions(dataset):
    series, _ = read_series(dataset("matrtklib-static") / "rover_rtk.pos")
    assert len(series) == 301
    assert (series.status == Status.FIXED).all()
    np.testing.assert_allclose(np.median(series.enu, axis=0), [-0.223, -0.965, 0.009], atol=2e-3)
    walk, notes = read_series(dataset("gnssimu-walk") / "gnss_1730_sf.pos")
    assert len(walk) == 536
    assert set(walk.status.tolist()) == {1, 2}
    assert "median of all fixed positions" in notes[0]
