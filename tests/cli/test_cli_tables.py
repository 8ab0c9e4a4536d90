"""The tables: columns as promised, one row a rover epoch, empty where there is no solution."""

import csv
import json
import re
from typing import NamedTuple

import numpy as np
import pytest

from gnsslab.cli.tables import ATTITUDE_COLUMNS, RELATIVE_COLUMNS, row_of_epoch, write_attitude_csv, write_relative_csv, write_relative_pos
from gnsslab.gnss.frames import ecef_from_geodetic

NAN = float("nan")
TIME = np.datetime64("2024-06-24T08:20:00", "ns") + np.arange(4) * np.timedelta64(1_000_000_000, "ns")


class Attitude(NamedTuple):
    """As the solver gives it: epochs 0 fixed, 1 none, 2 float; the rover's epoch 3 has no partner."""

    time: np.ndarray = TIME[:3]
    status: np.ndarray = np.array([2, 0, 1], dtype=np.int8)
    heading: np.ndarray = np.radians([359.99999, NAN, 12.5])
    pitch: np.ndarray = np.radians([-1.25, NAN, 0.5])
    length: np.ndarray = np.array([1.0, NAN, 1.1])
    baseline_enu: np.ndarray = np.array([[0.0, 1.0, 0.0], [NAN] * 3, [0.2, 1.0, 0.1]])
    sigma_heading: np.ndarray = np.radians([0.1, NAN, 9.0])
    sigma_pitch: np.ndarray = np.radians([0.2, NAN, 9.0])
    ratio: np.ndarray = np.array([12.345, NAN, 1.2])
    satellites: np.ndarray = np.array([9, 0, 7])


class Relative(NamedTuple):
    """The same epochs as positions."""

    time: np.ndarray = TIME[:3]
    status: np.ndarray = np.array([2, 0, 1], dtype=np.int8)
    position_ecef: np.ndarray = np.array([ecef_from_geodetic([0.5, 2.0, 100.0]), [NAN] * 3, ecef_from_geodetic([-0.5, -2.0, 50.0])])
    baseline_enu: np.ndarray = np.array([[0.0, 1.0, 0.0], [NAN] * 3, [0.2, 1.0, 0.1]])
    Q_enu: np.ndarray = np.array([[[4e-6, -1e-6, 0], [-1e-6, 9e-6, 0], [0, 0, 1.6e-5]], np.full((3, 3), NAN), np.eye(3)])
    ratio: np.ndarray = np.array([12.345, NAN, NAN])
    satellites: np.ndarray = np.array([9, 0, 7])


def read(path):
    with open(path, newline="") as stream:
        return list(csv.DictReader(stream))


def test_attitude_columns_are_those_promised(tmp_path):
    write_attitude_csv(tmp_path / "a.csv", Attitude(), TIME)
    rows = read(tmp_path / "a.csv")
    assert (tmp_path / "a.csv").read_text().splitlines()[0] == ATTITUDE_COLUMNS
    assert [row["time"] for row in rows] == [f"2024-06-24T08:20:0{k}.000" for k in range(4)]
    assert [row["status"] for row in rows] == ["fixed", "none", "float", "none"]
    assert (rows[0]["heading_deg"], rows[0]["pitch_deg"], rows[0]["ratio"], rows[0]["satellites"]) == ("0.0000", "-1.2500", "12.35", "9")
    for row in (rows[1], rows[3]):
        assert all(value == "" for name, value in row.items() if name not in ("time", "status"))


def test_relative_columns_are_those_promised(tmp_path):
    write_relative_csv(tmp_path / "r.csv", Relative(), TIME)
    rows = read(tmp_path / "r.csv")
    assert (tmp_path / "r.csv").read_text().splitlines()[0] == RELATIVE_COLUMNS
    assert float(rows[0]["lat_deg"]) == pytest.approx(np.degrees(0.5), abs=1e-9)
    assert float(rows[2]["height_m"]) == pytest.approx(50.0, abs=1e-4)
    assert (rows[0]["sigma_east_m"], rows[0]["sigma_north_m"], rows[0]["sigma_up_m"]) == ("0.0020", "0.0030", "0.0040")
    assert rows[2]["ratio"] == ""
    assert all(value == "" for name, value in rows[1].items() if name not in ("time", "status"))
    assert "nan" not in (tmp_path / "r.csv").read_text()


def test_pos_file_has_rtklibs_columns(tmp_path):
    write_relative_pos(tmp_path / "r.pos", Relative(), ["base.obs"])
    lines = [line for line in (tmp_path / "r.pos").read_text().splitlines() if not line.startswith("%")]
    first, second = (line.split() for line in lines)
    assert first[:2] == ["2024/06/24", "08:20:00.000"]
    assert (first[5], second[5]) == ("1", "2")
    assert [float(value) for value in first[7:13]] == [0.003, 0.002, 0.004, -0.001, 0.0, 0.0]
    assert len(first) == len(second) == 15


@pytest.mark.parametrize(("offset_ms", "expected"), [(0, [0, 1, 2, -1]), (1, [0, 1, 2, -1]), (-3, [0, 1, 2, -1]), (400, [-1] * 4)])
def test_rows_are_found_by_time(offset_ms, expected):
    assert row_of_epoch(TIME, TIME[:3] + np.timedelta64(offset_ms, "ms")).tolist() == expected
    assert row_of_epoch(TIME, TIME[:0]).tolist() == [-1] * 4
    assert row_of_epoch(TIME, TIME[:1]).tolist() == [0, -1, -1, -1]


def test_rtk_on_real_data(run, files, tmp_path):
    out = tmp_path / "rover.csv"
    answer = run("rtk", *files, "-o", out, "--base-position", "-3959400.631,3385704.533,3667523.111", "--plot", tmp_path / "rover.png")
    assert answer.status == 0, answer.err
    rows = read(out)
    assert len(rows) == 60
    assert {row["status"] for row in rows} == {"fixed"}
    centimetre = 0.01
    assert np.median([float(row["x_m"]) for row in rows]) == pytest.approx(-3962108.673, abs=centimetre)
    assert (tmp_path / "rover.png").read_bytes().startswith(b"\x89PNG")
    made = json.loads((tmp_path / "rover.csv.json").read_text())
    assert made["command"] == "rtk"
    assert made["options"]["base-position"].startswith("-3959400")
    assert [re.fullmatch("[0-9a-f]{64}", one["sha256"]) is not None for one in made["inputs"]] == [True] * 3


def test_rtk_says_where_the_base_comes_from(run, files, tmp_path):
    answer = run("rtk", *files, "-o", tmp_path / "rover.pos", "--every", 10, "--systems", "G")
    assert answer.status == 0, answer.err
    assert "RINEX header" in answer.err
    assert sum(not line.startswith("%") for line in (tmp_path / "rover.pos").read_text().splitlines()) == 6


def test_heading_with_a_span(run, files, tmp_path):
    out = tmp_path / "heading.csv"
    answer = run("heading", *files, "-o", out, "--from", "2021-03-19T12:00:10", "--to", "2021-03-19T12:00:20", "--every", 5)
    assert answer.status == 0, answer.err
    assert [row["time"][-6:] for row in read(out)] == ["10.000", "15.000", "20.000"]
