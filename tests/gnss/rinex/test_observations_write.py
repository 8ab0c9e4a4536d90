"""Writing RINEX 3.04: reading back gives what was written, to the format's precision."""

from types import MappingProxyType

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gnsslab.gnss.observations import ObservationHeader, Observations, SystemTable
from gnsslab.gnss.rinex import RinexError, read_rinex_obs, write_rinex_obs

T0 = np.datetime64("2024-06-24T08:20:00", "ns")
NAN = float("nan")


def observations_of(value, lli=None, ssi=None, codes=("C1C", "L1C"), time=None, header=None, system="G", number=None):
    """Observations of one system with a row an epoch unless numbers say otherwise; arrays are read-only."""
    value = np.array(value, dtype=float)
    shape = value.shape
    time = T0 + np.arange(shape[0]) * np.timedelta64(1, "s") if time is None else time
    flags = [np.zeros(shape, np.uint8) if one is None else np.array(one, dtype=np.uint8) for one in (lli, ssi)]
    number = np.full(shape[0], 5, dtype=np.int16) if number is None else number
    table = SystemTable(system, tuple(codes), np.arange(shape[0], dtype=np.int32), number, value, *flags)
    for array in (table.epoch, table.number, table.value, table.lli, table.ssi, time):
        array.setflags(write=False)
    return Observations(time, MappingProxyType({system: table}), header or ObservationHeader(), np.zeros(len(time), bool))


def test_written_file_by_eye(tmp_path):
    header = ObservationHeader(
        marker="HILL", receiver="TYPE X", antenna="ANT Y", position_ecef=np.array([-3817680.727, 3562839.5216, 3650159.2407]),
        antenna_delta_enu=np.array([0.1, 0.2, 1.5]), interval=1.0, glonass_channels={"R02": -4, "R01": 1},
    )  # fmt: skip
    value = [[20000000.1234, 105000000.4567], [NAN, -0.0001]]
    write_rinex_obs(tmp_path / "out.obs", observations_of(value, [[0, 1], [0, 2]], [[7, 0], [0, 0]], header=header))
    lines = (tmp_path / "out.obs").read_text().splitlines()
    assert lines[0] == f"{'     3.04           OBSERVATION DATA    G':<60}RINEX VERSION / TYPE"
    assert lines[1].startswith("gnsslab 0.")
    assert lines[1][60:] == "PGM / RUN BY / DATE"
    assert lines[2:] == [
        f"{'HILL':<60}MARKER NAME",
        f"{'':<60}OBSERVER / AGENCY",
        f"{'                    TYPE X':<60}REC # / TYPE / VERS",
        f"{'                    ANT Y':<60}ANT # / TYPE",
        f"{' -3817680.7270  3562839.5216  3650159.2407':<60}APPROX POSITION XYZ",
        f"{'        1.5000        0.1000        0.2000':<60}ANTENNA: DELTA H/E/N",
        f"{'G    2 C1C L1C':<60}SYS / # / OBS TYPES",
        f"{'G L1C':<60}SYS / PHASE SHIFT",
        f"{'     1.000':<60}INTERVAL",
        f"{'  2024     6    24     8    20    0.0000000     GPS':<60}TIME OF FIRST OBS",
        f"{'  2024     6    24     8    20    1.0000000     GPS':<60}TIME OF LAST OBS",
        f"{'  2 R01  1 R02 -4':<60}GLONASS SLOT / FRQ #",
        f"{'':<60}END OF HEADER",
        "> 2024 06 24 08 20  0.0000000  0  1",
        "G05  20000000.123 7 105000000.4571",
        "> 2024 06 24 08 20  1.0000000  0  1",
        "G05                         0.0002",
    ]


def test_station_record_comes_back(tmp_path):
    header = ObservationHeader(
        marker="HILL", receiver="TYPE X", antenna="ANT Y", position_ecef=np.array([-3817680.727, 3562839.5216, 3650159.2407]),
        antenna_delta_enu=np.array([0.1, 0.2, 1.5]), interval=0.2, glonass_channels={f"R{slot:02d}": slot % 7 - 4 for slot in range(1, 25)},
    )  # fmt: skip
    write_rinex_obs(tmp_path / "out.obs", observations_of([[2e7, 1e8]], header=header))
    again = read_rinex_obs(tmp_path / "out.obs").header
    assert (again.marker, again.receiver, again.antenna, again.interval) == ("HILL", "TYPE X", "ANT Y", 0.2)
    assert again.position_ecef.tolist() == header.position_ecef.tolist()
    assert again.antenna_delta_enu.tolist() == header.antenna_delta_enu.tolist()
    assert again.glonass_channels == header.glonass_channels
    assert (again.version, again.time_scale) == (3.04, "GPS")


NUMBERS = st.one_of(
    st.just(NAN),
    st.floats(-999_999_999.0, 9_999_999_999.0, allow_nan=False, width=64),
    st.integers(-10_000_000, 10_000_000).map(lambda thousandths: thousandths / 1000),
)


@st.composite
def any_observations(draw):
    """Observations of up to three systems with gaps, flags, power failures and odd times."""
    epochs = draw(st.integers(1, 4))
    steps = draw(st.lists(st.integers(1, 10**13), min_size=epochs, max_size=epochs))  # units of 100 ns: up to 11 days
    time = T0 + np.cumsum(steps) * np.timedelta64(100, "ns")
    tables = {}
    for system in draw(st.lists(st.sampled_from("GRECJSI"), min_size=1, max_size=3, unique=True)):
        rows = draw(st.lists(st.tuples(st.integers(0, epochs - 1), st.integers(1, 99)), min_size=1, max_size=6, unique=True))
        codes = tuple(f"{kind}{band}C" for band in "12589"[: draw(st.integers(1, 5))] for kind in "CLDS")
        size = len(rows) * len(codes)
        value = np.array(draw(st.lists(NUMBERS, min_size=size, max_size=size))).reshape(len(rows), -1)
        flags = [np.array(draw(st.lists(st.integers(0, 9), min_size=size, max_size=size)), np.uint8).reshape(len(rows), -1) for _ in range(2)]
        epoch, number = np.array(sorted(rows)).T
        tables[system] = SystemTable(system, codes, epoch.astype(np.int32), number.astype(np.int16), value, *flags)
    failed = np.array(draw(st.lists(st.booleans(), min_size=epochs, max_size=epochs)))
    return Observations(time, tables, ObservationHeader(), failed)


def rounded(table):
    """What the format keeps of the values: three decimals; 0.0 of code and phase means missing."""
    value = np.array([[float(f"{one:.3f}") for one in row] for row in table.value])
    is_range = np.array([code[0] in "CL" for code in table.codes])
    return np.where((value == 0) & is_range, NAN, value)


@settings(max_examples=60, deadline=None)
@given(written=any_observations())
def test_reading_back_gives_what_was_written(tmp_path_factory, written):
    path = tmp_path_factory.getbasetemp() / "round.obs"
    write_rinex_obs(path, written)
    again = read_rinex_obs(path)
    assert np.array_equal(again.time, written.time)
    assert again.power_failure.tolist() == written.power_failure.tolist()
    assert again.systems == written.systems
    assert again.warnings == ()
    for system, table in written.tables.items():
        other = again.tables[system]
        assert other.codes == table.codes
        assert np.array_equal(other.value, rounded(table), equal_nan=True)
        for name in ("epoch", "number", "lli", "ssi"):
            assert np.array_equal(getattr(other, name), getattr(table, name)), name


def test_packed_by_name_and_replaced_whole(tmp_path):
    path = tmp_path / "out.obs.gz"
    write_rinex_obs(path, observations_of([[2e7, 1e8]]))
    write_rinex_obs(path, observations_of([[3e7, 1e8]]))
    assert path.read_bytes().startswith(b"\x1f\x8b")
    assert read_rinex_obs(path).tables["G"].value[0, 0] == 3e7
    assert [found.name for found in tmp_path.iterdir()] == ["out.obs.gz"]


def test_seconds_that_round_up_to_a_minute(tmp_path):
    time = np.array([T0 + np.timedelta64(59_999_999_960, "ns")])
    write_rinex_obs(tmp_path / "out.obs", observations_of([[2e7, 1e8]], time=time))
    assert read_rinex_obs(tmp_path / "out.obs").time[0] == T0 + np.timedelta64(60, "s")


@pytest.mark.parametrize("value", [1e10, -1e9, np.inf, -np.inf])
def test_numbers_that_do_not_fit_are_refused(tmp_path, value):
    with pytest.raises(RinexError, match=r"L1C of G05 at 2024-06-24T08:20:00.* does not fit"):
        write_rinex_obs(tmp_path / "out.obs", observations_of([[2e7, value]]))
    assert list(tmp_path.iterdir()) == []


def test_paths_that_cannot_be_written(tmp_path):
    observations = observations_of([[2e7, 1e8]])
    (tmp_path / "file").write_text("")
    (tmp_path / "folder").mkdir()
    for path in (tmp_path / "none" / "out.obs", tmp_path / "file" / "out.obs", tmp_path / "folder", "bad\0name", ""):
        with pytest.raises(RinexError, match=r"the file cannot be written \(.*\); check the folder"):
            write_rinex_obs(path, observations)
    assert sorted(found.name for found in tmp_path.iterdir()) == ["file", "folder"]


def test_nothing_observed_cannot_be_written(tmp_path):
    empty = Observations(np.array([], dtype="datetime64[ns]"), {}, ObservationHeader(), np.zeros(0, bool))
    with pytest.raises(RinexError, match="nothing to write"):
        write_rinex_obs(tmp_path / "out.obs", empty)
