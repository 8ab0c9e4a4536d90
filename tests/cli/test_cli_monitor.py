"""`gnsslab monitor`: its table, what it says, its record and picture, and one plain sentence for what is wrong."""

import csv
import json
import re
from types import SimpleNamespace

import numpy as np
import pytest

from gnsslab.cli.monitored import summary
from gnsslab.gnss.series_files import read_series

COLUMNS = [
    *("time", "east_m", "north_m", "up_m", "east_filtered_m", "north_filtered_m", "up_filtered_m"),
    *("sigma_east_m", "sigma_north_m", "sigma_up_m", "flag", "alarm"),
]
MILLIMETRE = 1e-3
STEP_AT, STEP = 240, 0.10  # [epochs], [m] east: twenty sigmas, which no filter should miss
GROSS_AT, GAPS_AT = (130, 350), range(180, 190)


@pytest.fixture(scope="module")
def table(tmp_path_factory):
    """A table of 400 epochs at 30 s: a step, two gross errors, ten rows without solution, a longer interval before row 300."""
    rng = np.random.default_rng(5)
    enu = rng.normal(0, 5 * MILLIMETRE, (400, 3))
    enu[STEP_AT:, 0] += STEP
    for k in GROSS_AT:
        enu[k] += 1.0
    seconds = 30 * np.arange(400) + 600 * (np.arange(400) >= 300)
    time = np.datetime64("2024-06-24T00:00:00", "ms") + seconds.astype("m8[s]")
    rows = [f"{t},{e:.5f},{n:.5f},{u:.5f}" if k not in GAPS_AT else f"{t},,," for k, (t, (e, n, u)) in enumerate(zip(time, enu, strict=True))]
    path = tmp_path_factory.mktemp("monitor") / "series.csv"
    path.write_text("\n".join(["time,east_m,north_m,up_m", *rows, ""]))
    return path


@pytest.fixture(scope="module")
def made(table):
    """The table filtered, with its picture: what the command said, and the rows it wrote."""
    import contextlib
    import io

    from gnsslab.cli import main

    out, said = table.with_name("filtered.csv"), io.StringIO()
    with contextlib.redirect_stdout(said):
        assert main(["monitor", str(table), "-o", str(out), "--plot", str(out.with_suffix(".png"))]) == 0
    with open(out, newline="") as file:
        header, *rows = csv.reader(file)
    return out, said.getvalue(), header, rows


def test_the_table_has_its_columns_and_one_row_an_epoch(made, table):
    _, _, header, rows = made
    assert header == COLUMNS
    series, _ = read_series(table)
    assert [row[0] for row in rows] == [str(t)[:23] for t in series.time]
    assert {row[-1] for row in rows} <= {"0", "1"}
    assert {row[-2] for row in rows} <= {"ok", "outlier", "step", "gap"}
    assert not any("nan" in field.lower() for row in rows for field in row)


def test_rows_without_solution_are_gaps_with_a_prediction(made):
    _, _, _, rows = made
    for k in GAPS_AT:
        assert rows[k][1:4] == ["", "", ""]
        assert rows[k][-2] == "gap"
        assert abs(float(rows[k][4])) < 20 * MILLIMETRE
    assert sum(row[-2] == "gap" for row in rows) == len(GAPS_AT)


def test_the_positions_are_those_of_the_input(made, table):
    again, notes = read_series(made[0])
    np.testing.assert_array_equal(again.enu, read_series(table)[0].enu)
    assert "unfiltered positions" in notes[0]


def test_outliers_and_the_step_are_found_and_said(made):
    _, said, _, rows = made
    assert all(rows[k][-2] == "outlier" for k in GROSS_AT)
    east = [float(row[4]) for row in rows]
    assert abs(np.median(east[-50:]) - STEP) < 5 * MILLIMETRE
    steps = re.findall(r"step at (\S+): east ([+-][\d.]+) mm \(sigma ([\d.]+)\), north ([+-][\d.]+) mm .*up ([+-][\d.]+) mm", said)
    assert steps
    largest = max(steps, key=lambda step: abs(float(step[1])))
    assert abs(np.datetime64(largest[0]) - np.datetime64("2024-06-24T02:00:00")) <= np.timedelta64(150, "s")  # five epochs
    assert abs(float(largest[1]) - 100) < 4 * float(largest[2]) + 5
    assert "400 epochs: " in said
    assert f"{len(GAPS_AT)} without solution" in said
    assert "usual interval 30 s; 1 longer one, the longest 630 s from 2024-06-24T02:29:30.000" in said
    assert said.endswith("filtered.csv\n")


def test_a_step_raises_the_alarm(made):
    _, said, _, rows = made
    assert rows[-1][-1] == "1"
    assert not any(row[-1] == "1" for row in rows[: STEP_AT - 1])
    assert re.search(r"alarm from 2024-06-24T02:\d\d:\d\d.000 to ", said)


def test_of_many_steps_and_alarms_the_first_are_told():
    T = 400
    time = np.datetime64("2024-01-01", "ns") + np.arange(T) * np.timedelta64(1, "s")
    steps = tuple(SimpleNamespace(time=time[k], first=k, found=k + 2, size=np.array([k * 1e-3, 0, 0]), sigma=np.full(3, 1e-3)) for k in range(30))
    told = summary(SimpleNamespace(time=time, flag=np.zeros(T), alarm=np.arange(T) % 2 == 1, steps=steps))
    assert told[0] == "400 epochs: 0 outliers, 30 steps, 0 without solution"
    assert told[1] == "the largest 20 of them:"
    assert told[2].startswith("step at 2024-01-01T00:00:10.000: east +10.0 mm (sigma 1.0), north +0.0 mm")
    assert told[21].endswith("found 2 epochs later")
    assert told[22] == "alarm from 2024-01-01T00:00:01.000 to 2024-01-01T00:00:01.000 (1 epoch)"
    assert told[42:] == ["and 180 alarms more, in the table"]


def test_the_record_says_what_made_it(made, table):
    for name in (made[0], made[0].with_suffix(".png")):
        record = json.loads(name.with_name(f"{name.name}.json").read_text())
        assert record["command"] == "monitor"
        assert record["inputs"][0]["file"] == str(table)
        assert "MonitorSettings" in record["method"]
    assert made[0].with_suffix(".png").read_bytes().startswith(b"\x89PNG")


def test_a_span_and_named_columns(run, table, tmp_path):
    out = tmp_path / "part.csv"
    given = ("--columns", "time,north,east,up", "--from", "2024-06-24T00:10:00", "--to", "2024-06-24T00:20:00")
    answer = run("monitor", table, "-o", out, *given)
    assert answer.status == 0
    rows = out.read_text().splitlines()[1:]
    assert len(rows) == 21
    source = table.read_text().splitlines()[21].split(",")
    assert rows[0].split(",")[1:4] == [source[2], source[1], source[3]]


def test_settings_are_the_filters_own_unless_given(run, table, tmp_path):
    from gnsslab.systems.monitoring import MonitorSettings

    assert f"[{MonitorSettings().alarm:g} m]" in run("monitor", "--help").out
    for options, settings in (((), MonitorSettings()), (("--alarm", "0.5", "--memory", "100"), MonitorSettings(alarm=0.5, memory=100.0))):
        answer = run("monitor", table, "-o", tmp_path / "o.csv", *options)
        assert json.loads((tmp_path / "o.csv.json").read_text())["method"] == repr(settings)
    assert "no alarm" in answer.out  # a step of 10 cm is no matter where the alarm is for half a metre


@pytest.mark.parametrize(
    ("content", "options", "words"),
    [
        ("time,east_m,north_m,up_m\n2024-01-01,,,\n", (), "has no position at any of its 1 epochs: nothing to monitor"),
        ("time,east_m,north_m,up_m\n", (), "a header but no rows"),
        ("", (), "the file is empty"),
        ("time,east_m,north_m,up_m\n2024-01-01,1,2,3\n", (), "monitoring needs 16 solutions or more"),
        ("time,east_m,north_m,up_m\n2024-01-01,1,2,3\n", ("--alarm", "-1"), "--alarm -1: expected metres above zero"),
        ("time,east_m,north_m,up_m\n2024-01-01,1,2,3\n", ("--memory", "0"), "--memory 0: expected a number of epochs above zero"),
        ("time,x,y,z\n2024-01-01,1,2,3\n", (), "name the columns in their order, as in --columns time,north,east,up"),
        ("time,east_m,north_m,up_m\n2024-01-01,1,2,3\n", ("--unit", "feet"), "unit 'feet': expected m, cm or mm"),
        (
            "time,east_m,north_m,up_m\n2024-01-01,1,2,3\n",
            ("--from", "2025-01-01"),
            "no epochs between --from and --to: it spans 2024-01-01T00:00:00.000 to",
        ),
        ("time,east_m,north_m,up_m\n2024-01-01,1,2,3\n", ("--plot", "a.doc"), "expected a name that ends in .png"),
        ("time,east_m,north_m,up_m\n2024-01-01,1,2,3\n2024-01-02,1,2,x\n2024-01-03,1,2,3\n", (), "line 3: expected a number in column up, found 'x'"),
    ],
)
def test_what_is_wrong_gets_one_plain_line(run, tmp_path, content, options, words):
    (tmp_path / "a.csv").write_text(content)
    answer = run("monitor", tmp_path / "a.csv", "-o", tmp_path / "o.csv", *options)
    assert answer.status == 1
    assert len(answer.complaint) == 1
    assert words in answer.complaint[0]
    assert not (tmp_path / "o.csv").exists()


@pytest.mark.parametrize(
    ("series", "output", "words"),
    [
        ("nowhere.csv", "o.csv", "nowhere.csv: no such file"),
        (".", "o.csv", "this is a folder"),
        ("a.csv", "a.csv", "one of the inputs"),
        ("a.csv", "o.png", "monitor writes CSV"),
        ("a.csv", "no/where/o.csv", "does not exist"),
    ],
)
def test_files_that_are_wrong(run, tmp_path, monkeypatch, series, output, words):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.csv").write_text("time,east_m,north_m,up_m\n2024-01-01,1,2,3\n")
    answer = run("monitor", series, "-o", output)
    assert answer.status == 1
    assert words in answer.err


def test_a_command_that_is_not_understood(run, tmp_path):
    assert run("monitor").status == 2
    assert run("monitor", "a.csv").status == 2
    assert run("monitor", "a.csv", "-o", "b.csv", "--nonsense").status == 2
