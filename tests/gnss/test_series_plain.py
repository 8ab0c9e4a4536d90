"""Plain tables of time, east, north, up: names, units, separators and times found, odd rows accounted for, wrong files told by line."""

import gzip

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gnsslab.gnss.relative import Status
from gnsslab.gnss.series_files import read_series
from gnsslab.gnss.series_files.names import meaning
from gnsslab.gnss.times import gps_from_utc, week_and_tow

PRINTED = 1e-9  # [m]: what is written with so many decimals comes back
TIME = np.datetime64("2024-02-28T23:59:58", "ns") + np.arange(4) * np.timedelta64(1, "s")
ENU = np.array([[0.001, -0.002, 0.003], [0.004, 0.005, -0.006], [-1.5, 0.0, 2.25], [0.1, 0.2, 0.3]])


@pytest.fixture
def read(tmp_path):
    """Write lines of text, or bytes, to a file and read the series in it."""

    def read(content, **options):
        path = tmp_path / "a.csv"
        path.write_bytes(content if isinstance(content, bytes) else "\n".join([*content, ""]).encode())
        return read_series(path, **options)

    return read


def lines(header="time,east,north,up", mark=",", scale=1.0, times=None, form="{:.6f}"):
    """Return the lines of a table of TIME and ENU."""
    times = [str(t)[:23] for t in TIME] if times is None else times
    return [*([header] if header else []), *(mark.join([t, *(form.format(scale * x) for x in row)]) for t, row in zip(times, ENU, strict=True))]


def is_same(series):
    np.testing.assert_allclose(series.enu, ENU, atol=PRINTED)
    return np.array_equal(series.time, TIME) and (series.status == Status.FIXED).all()


@pytest.mark.parametrize(
    ("table", "words"),
    [
        (lines("time,east_m,north_m,up_m"), ()),
        (lines(), ("taken in metres",)),
        (lines("Time;East [mm];North [mm];Up [mm]", ";", 1000), ()),
        (lines("epoch\tdE(cm)\tdN(cm)\tdU(cm)", "\t", 100), ()),
        (lines("datetime|e|n|u", "|"), ("metres",)),
        (lines("t east north height", " "), ("metres",)),
        (["# made by hand", "# time east_m north_m up_m", *lines("", "  ")], ()),
        (["Station ABC, slope 3", "", *lines("time,east_m,north_m,up_m")], ()),
        (lines(""), ("no header: columns taken as time, east, north, up", "metres")),
        ([line.replace("T", " ") for line in lines("", "   ")], ("no header", "metres")),
        ([line.replace("-02-", "/02/").replace("T", " ") for line in lines("gpst,east_m,north_m,up_m")], ()),
        (["date,time,east_m,north_m,up_m", *[line.replace("T", ",") for line in lines("")]], ()),
        ([line.replace("T", " ") for line in lines("date clock east_m north_m up_m", " ")], ()),
        ([line.replace(".", ",") for line in lines("time;east_mm;north_mm;up_mm", ";", 1000)], ("decimal comma",)),
        ([f'"{line.replace(",", chr(34) + "," + chr(34))}"' for line in lines("time,east_m,north_m,up_m")], ()),
        ([line + "," for line in lines("time,east_m,north_m,up_m")], ()),
        (lines("time,east_m,north_m,up_m", form="{:.6e}"), ()),
    ],
)
def test_names_units_and_separators(table, words, read):
    series, notes = read(table)
    assert is_same(series)
    assert len(notes) == len(words)
    for note, word in zip(notes, words, strict=True):
        assert word in note


def seconds_of(time, origin):
    return ((time - np.datetime64(origin, "ns")) / np.timedelta64(1, "us") / 1e6).tolist()


DAYS = np.array(["2024-02-29", "2024-02-29T12", "2024-03-01T06", "2024-03-02"], "M8[ns]")
HALF_YEARS = np.array(["2023-07-02T12", "2024-01-01", "2024-07-02", "2025-01-01"], "M8[ns]")


@pytest.mark.parametrize(
    ("name", "times", "words", "expected"),
    [
        ("time", [f"{t}Z" for t in TIME.astype("M8[ms]")], None, gps_from_utc(TIME)),
        ("time", [f"{t}+09:00" for t in TIME.astype("M8[ms]")], None, gps_from_utc(TIME - np.timedelta64(9, "h"))),
        ("time (UTC)", [str(t) for t in TIME.astype("M8[ms]")], None, gps_from_utc(TIME)),
        ("time", ["2024/2/28 23:59:58", "2024/2/28 23:59:59", "2024/2/29 0:00:00", "2024/2/29 0:0:1"], None, TIME),
        ("time", ["2024-02-28 23:59", "2024-02-29 00:01", "2024-02-29 00:02", "2024-03-01"], None, None),
        ("time", [f"{t:.3f}" for t in seconds_of(TIME, "1980-01-06")], "Unix seconds", None),
        ("gps seconds", [f"{t:.3f}" for t in seconds_of(TIME, "1980-01-06")], "counted from 1980-01-06", TIME),
        ("unix", [f"{t:.3f}" for t in seconds_of(TIME, "1970-01-01")], "Unix seconds", gps_from_utc(TIME)),
        ("time", ["0.0", "1", "2.5", "1e3"], "counted from 1980-01-06", None),
        ("mjd", ["60369.0", "60369.5", "60370.25", "60371"], "modified Julian", DAYS),
        ("t", ["60369.0", "60369.5", "60370.25", "60371"], "modified Julian", DAYS),
        ("decimal_year", ["2023.5", "2024.0", "2024.5", "2025.0"], "decimal years", HALF_YEARS),
        ("time", ["2023.5", "2024.0", "2024.5", "2025.0"], "decimal years", HALF_YEARS),
        ("week,tow", [f"{w},{s}" for w, s in zip(*week_and_tow(TIME), strict=True)], "GPS week", TIME),
    ],
)  # fmt: skip
def test_times(name, times, words, expected, read):
    series, notes = read(lines(f"{name},east_m,north_m,up_m", times=times))
    if expected is not None:
        assert np.array_equal(series.time, expected)
    assert len(series) == 4
    assert (words is None) == (not notes)
    assert words is None or words in notes[0]


def test_the_caller_names_columns_that_mislead(read):
    table = ["time,lat,lon,ver,group", *[f"{line},J188" for line in lines("", scale=1000)]]
    with pytest.raises(ValueError, match="line 1: no column for east, north, up among 'time, lat, lon, ver, group'"):
        read(table)
    series, notes = read(table, columns="time,east,north,up", unit="mm")
    assert is_same(series)
    assert notes == ()
    swapped, _ = read(table, columns="time,north,east,up", unit="mm")
    np.testing.assert_allclose(swapped.enu, ENU[:, [1, 0, 2]], atol=PRINTED)
    skipped, _ = read([f"x,{line}" for line in table], columns="-,time,east,north,up", unit="mm")
    assert is_same(skipped)


def test_our_own_tables(read):
    rtk = [
        "time,status,x_m,y_m,z_m,lat_deg,lon_deg,height_m,east_m,north_m,up_m,sigma_east_m,sigma_north_m,sigma_up_m,ratio,satellites",
        "2024-06-24T08:20:00.000,none,,,,,,,,,,,,,,",
        "2024-06-24T08:20:01.000,fixed,1,2,3,4,5,99.0,0.1,0.2,0.3,0.003,0.004,0.009,12.5,20",
        "2024-06-24T08:20:02.000,float,1,2,3,4,5,99.0,0.4,0.5,0.6,0.1,0.2,0.3,,9",
    ]
    series, notes = read(rtk)
    assert notes == ()
    assert series.status.tolist() == [0, 2, 1]
    assert series.enu[1:].tolist() == [[0.1, 0.2, 0.3], [0.4, 0.5, 0.6]]
    assert series.sigma[1:].tolist() == [[0.003, 0.004, 0.009], [0.1, 0.2, 0.3]]
    np.testing.assert_array_equal(series.ratio, [np.nan, 12.5, np.nan])
    heading = ["time,status,heading_deg,pitch_deg,length_m,east_m,north_m,up_m,sigma_heading_deg,sigma_pitch_deg,ratio,satellites"]
    series, _ = read([*heading, "2024-06-24T08:20:00.000,fixed,10.0,1.0,1.2,0.1,0.2,0.3,0.4,0.5,3.0,20"])
    assert series.enu.tolist() == [[0.1, 0.2, 0.3]]
    assert np.isnan(series.sigma).all()
    monitor = "time,east_m,north_m,up_m,east_filtered_m,north_filtered_m,up_filtered_m,sigma_east_m,sigma_north_m,sigma_up_m,flag,alarm"
    series, notes = read(
        [
            monitor,
            "2024-06-24T08:20:00.000,0.1,0.2,0.3,0.4,0.5,0.6,0.001,0.001,0.001,ok,0",
            "2024-06-24T08:20:01.000,,,,0.4,0.5,0.6,0.1,0.1,0.1,gap,0",
        ]
    )
    assert series.enu[0].tolist() == [0.1, 0.2, 0.3]
    assert np.isnan(series.sigma).all()
    assert "its unfiltered positions are taken" in notes[0]


def test_every_odd_row_is_accounted_for(read):
    head = "time,east_mm,north_mm,up_mm,status,sigma_east_mm,sigma_north_mm,sigma_up_mm"
    rows = {
        "good": "2024-01-01,1,2,3,fixed,1,1,2",
        "empty": "2024-01-02,,,,,,,",
        "nan": "2024-01-03,NaN,nan,NA,none,,,",
        "partly": "2024-01-04,1,,3,fixed,1,1,2",
        "infinite": "2024-01-05,1,inf,3,fixed,1,1,2",
        "denied": "2024-01-06,1,2,3,none,1,1,2",
        "late": "2024-01-09,1,2,3,float,1,1,2",
        "early": "2024-01-08,1,2,3,fixed,0,1,2",
        "same": "2024-01-01,1,2,3,fixed,1,1,2",
        "float before fixed": "2024-01-09,4,5,6,fixed,1,1,2",
        "no time": ",1,2,3,fixed,1,1,2",
    }
    series, notes = read([head, *rows.values()])
    assert series.time.astype("M8[D]").astype(str).tolist() == [f"2024-01-0{day}" for day in (1, 2, 3, 4, 5, 6, 8, 9)]
    assert series.status.tolist() == [2, 0, 0, 0, 0, 0, 2, 2]
    assert series.enu[-1].tolist() == [0.004, 0.005, 0.006]
    assert np.isnan(series.sigma[-2, 0])
    assert notes == (
        "1 row without a time left out",
        "1 row without east, north and up kept as epochs without solution",
        "1 row with only one or two of east, north and up kept as epochs without solution",
        "1 row with a position that is not finite kept as epochs without solution",
        "1 row with a position but status none kept as epochs without solution",
        "1 row with a standard deviation of zero, below or infinite: taken as not stated",
        "times go backward at 2 places, first to 2024-01-08T00:00:00.000: sorted",
        "1 row repeating another left out",
        "1 row at the time of another row, but with another position or status, left out: the fixed or else the first one is kept",
        "11 rows give 8 epochs",
    )


def test_daily_series_of_a_data_centre(read):
    """The columns of tenv3: whole metres in e0, n0, u0, the rest in east, north, up."""
    head = "site YYMMMDD yyyy.yyyy __MJD week d reflon _e0(m) __east(m) ____n0(m) _north(m) u0(m) ____up(m) _ant(m) sig_e(m) sig_n(m) sig_u(m)"
    rows = [f"J188 09JAN0{k} 2009.000{k} {54831 + k} 1512 {k} 140.3 -12 0.10{k} 43 0.20{k} 99 0.30{k} 0.05 0.001 0.002 0.004" for k in (2, 3)]
    series, notes = read([head, *rows])
    assert series.time.astype("M8[D]").astype(str).tolist() == ["2009-01-02", "2009-01-03"]
    assert series.enu[1].tolist() == [0.103, 0.203, 0.303]
    assert series.sigma[0].tolist() == [0.001, 0.002, 0.004]
    assert notes == ("times taken as modified Julian dates",)


def test_numbers_of_quality_and_spellings_of_status(read):
    rows = [f"2024-01-0{k + 1},1,2,3,{word}" for k, word in enumerate(["1", "2", "5", "Fix", "FLOAT", ""])]
    series, _ = read(["time,east_m,north_m,up_m,Q", *rows])
    assert series.status.tolist() == [2, 1, 1, 2, 1, 2]


def test_line_ends_marks_and_compression_change_nothing(read):
    plain = "\n".join(lines("time,east_m,north_m,up_m")).encode()
    for content in (
        plain,
        plain.replace(b"\n", b"\r\n"),
        plain.replace(b"\n", b"\r"),
        b"\xef\xbb\xbf" + plain,
        gzip.compress(plain),
        plain.decode().encode("utf-16"),
    ):
        series, notes = read(content)
        assert is_same(series)
        assert notes == ()


def test_one_epoch_and_all_gaps(read):
    series, _ = read(["time,east_m,north_m,up_m", "2024-01-01,1,2,3"])
    assert len(series) == 1
    series, _ = read(["time,east_m,north_m,up_m", "2024-01-01,,,", "2024-01-02,,,"])
    assert not series.is_solved.any()


def test_a_long_table_with_gaps_comes_in_pieces(read, rng):
    T = 30_000
    enu = rng.normal(0, 0.01, (T, 3)).round(4)
    time = np.datetime64("2024-01-01", "ms") + np.arange(T) * np.timedelta64(30, "s")
    rows = [f"{t},{e:.4f},{n:.4f},{u:.4f}" if k % 7 else f"{t},,," for k, (t, (e, n, u)) in enumerate(zip(time, enu.tolist(), strict=True))]
    calls = []
    series, notes = read(["time,east_m,north_m,up_m", *rows], progress=lambda *counts: calls.append(counts))
    assert len(calls) > 1
    assert calls[-1][0] == calls[-1][1]
    expected = np.where((np.arange(T) % 7 > 0)[:, None], enu, np.nan)
    np.testing.assert_array_equal(series.enu, expected)
    assert notes == (f"{(T + 6) // 7} rows without east, north and up kept as epochs without solution",)
    rows[25_000] = rows[25_000].replace(",", ",x", 1)
    with pytest.raises(ValueError, match=r"line 25002: expected a number in column east, found 'x"):
        read(["time,east_m,north_m,up_m", *rows])


HEAD = "time,east_m,north_m,up_m"
ROW = "2024-01-01,1,2,3"


@pytest.mark.parametrize(
    ("table", "options", "words"),
    [
        ([], {}, "the file is empty"),
        ([HEAD], {}, "a header but no rows"),
        (["time,x,y,z", ROW], {}, "line 1: no column for east, north, up among 'time, x, y, z': name the columns in their order"),
        (["east_m,north_m,up_m,more", "1,2,3,4"], {}, "no column for the time"),
        (["time,east_m,north_m,up_m,height_m,e_m", ROW + ",4,5"], {}, "columns east_m and e_m both look like east"),
        (["2024-01-01,1,2", "2024-01-02,1,2"], {}, "line 1: no header, and 3 columns are not time, east, north, up"),
        ([HEAD, ROW, "2024-01-02,1,two,3"], {}, "line 3: expected a number in column north, found 'two'"),
        ([HEAD, ROW, "2024-01-02,1,2", ROW], {}, "line 3: expected 4 fields, as in the rows before, found 3: '2024-01-02,1,2'"),
        ([HEAD, ROW, "2024-01-02,1,2,3,4"], {}, "line 3: expected 4 fields, as in the rows before, found 5"),
        ([HEAD, ROW, "", "", "01.02.2024,1,2,3"], {}, "line 5: expected a date like 2024-06-24T08:20:00 .* found '01.02.2024'"),
        ([HEAD, ROW, "2024-13-01,1,2,3"], {}, "line 3: expected a date"),
        ([HEAD, ROW, "1066-10-14,1,2,3"], {}, "line 3: expected a date"),
        ([HEAD, "2024-01-01T00:00:00Z,1,2,3", "2024-01-01T00:00:01,1,2,3"], {}, "line 3: expected a date .* the same time zone in every row"),
        ([HEAD, "20240101,1,2,3"], {}, "line 2: expected a time like 2024-06-24T08:20:00, found '20240101'"),
        (["mjd,east_m,north_m,up_m", "60000,1,2,3", "600,1,2,3"], {}, "line 3: expected a modified Julian date like 55631.5, found '600'"),
        ([HEAD + ",status", ROW + ",fixed", ROW + ",great"], {}, "line 3: expected status fixed, float or none, or a quality .* found 'great'"),
        ([HEAD, ROW], {"unit": "km"}, "unit 'km': expected m, cm or mm"),
        ([HEAD, ROW], {"unit": "mm"}, "column east is in m by its name, not in mm"),
        ([HEAD, ROW], {"columns": "time,a,b,c"}, "no column for east, north, up among 'time, a, b, c'"),
        ([HEAD, ROW], {"columns": "time,east,north,up,x"}, "5 columns are named, but a row has 4 fields"),
        (["just one word"], {}, "expected rows of time, east, north, up, found .just one word"),
    ],
)  # fmt: skip
def test_files_that_are_wrong(table, options, words, read):
    with pytest.raises(ValueError, match=words) as told:
        read(table, **options)
    assert "\n" not in str(told.value)


@pytest.mark.parametrize(
    ("name", "quantity", "unit"),
    [
        ("East", "east", ""),
        ("delta_n [cm]", "north", "cm"),
        ("Up(mm)", "up", "mm"),
        ("u-baseline(m)", "up", "m"),
        ("sde(m)", "sigma_east", "m"),
        ("sigma_north_mm", "sigma_north", "mm"),
        ("std u", "sigma_up", ""),
        ("GPS week", "week", ""),
        ("height_m", "height", "m"),
    ],
)
def test_names(name, quantity, unit):
    assert meaning(name) == (quantity, unit)


@pytest.mark.parametrize("name", ["", "x_m", "east_filtered_m", "satellites", "lat", "lon", "heading_deg", "sigma_heading_deg", "length_m", "7"])
def test_other_names_mean_nothing(name):
    assert meaning(name) is None


instants = st.integers(0, 4_000_000_000).map(lambda ms: np.datetime64("1999-01-01", "ms") + np.timedelta64(ms * 200, "ms"))


@settings(max_examples=40, deadline=None)
@given(
    st.dictionaries(instants, st.tuples(*[st.floats(-1e4, 1e4)] * 3), min_size=1, max_size=8),
    st.sampled_from([(",", "mm", 1e3), (";", "cm", 1e2), ("\t", "m", 1.0), (" ", "m", 1.0)]),
    st.randoms(),
)
def test_round_trip_in_any_order(tmp_path_factory, rows, form, random):
    mark, unit, scale = form
    order = list(rows.items())
    random.shuffle(order)
    path = tmp_path_factory.getbasetemp() / "round.csv"
    text = [mark.join([str(t), *(repr(scale * x) for x in enu)]) for t, enu in order]
    path.write_text("\n".join([mark.join(["time", f"east_{unit}", f"north_{unit}", f"up_{unit}"]), *text]))
    series, _ = read_series(path)
    assert series.time.tolist() == [np.datetime64(t, "ns").astype(int) for t in sorted(rows)]
    np.testing.assert_allclose(series.enu, [rows[t] for t in sorted(rows)], rtol=1e-12)


def test_a_real_set_with_columns_that_mislead(dataset):
    series, notes = read_series(dataset("geonet-tohoku-neu") / "J188neu9818.csv", columns="time,north,east,up", unit="mm")
    assert len(series) == 3390
    assert notes == ()
    day = np.searchsorted(series.time, np.datetime64("2011-03-11", "ns"))
    step = np.median(series.enu[day + 1 : day + 8], axis=0) - np.median(series.enu[day - 30 : day], axis=0)
    np.testing.assert_allclose(step, [0.893, -0.521, 0.034], atol=0.03)  # the registry's; post-seismic motion within the week
