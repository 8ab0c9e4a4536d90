"""`gnsslab simulate`: files in a folder, the same for the same seed, which the other commands read."""

import json

import pytest

from gnsslab.simulate import PRESETS, SERIES_PRESETS


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A simulated two-antenna baseline at rest."""
    from gnsslab.cli import main

    folder = tmp_path_factory.mktemp("simulated") / "new"
    assert main(["simulate", "static-baseline", "-o", str(folder), "--seed", "3"]) == 0
    return folder


def test_list_names_all_presets(run):
    lines = run("simulate", "--list").out.splitlines()
    assert [line.split()[0] for line in lines] == [*PRESETS, *SERIES_PRESETS]
    assert all(len(line) <= 100 for line in lines)


def test_files_are_those_promised(folder):
    assert {path.name for path in folder.iterdir()} == {"master.obs", "rover.obs", "broadcast.nav", "truth.csv", "simulation.json"}
    assert (folder / "truth.csv").read_text().startswith("time,east_m,north_m,up_m,heading_deg,pitch_deg,roll_deg\n2024-")
    made = json.loads((folder / "simulation.json").read_text())
    assert made["options"] == {"preset": "static-baseline", "output": str(folder), "seed": 3}


def test_same_seed_same_data(run, folder, tmp_path):
    run("simulate", "static-baseline", "-o", tmp_path / "same", "--seed", 3)
    run("simulate", "static-baseline", "-o", tmp_path / "other", "--seed", 4)
    for name in ("master.obs", "rover.obs", "broadcast.nav", "truth.csv"):
        assert undated(tmp_path / "same" / name) == undated(folder / name)
    assert undated(tmp_path / "other" / "rover.obs") != undated(folder / "rover.obs")


def undated(path):
    """Return the lines of a file but the one that says when it was written."""
    return [line for line in path.read_text().splitlines() if not line.rstrip().endswith("PGM / RUN BY / DATE")]


def test_the_other_commands_read_it(run, folder, tmp_path):
    assert "epochs       300, one every 1 s" in run("info", folder / "rover.obs").out
    assert "navigation" in run("info", folder / "broadcast.nav").out
    answer = run("rtk", folder / "master.obs", folder / "rover.obs", folder / "broadcast.nav", "-o", tmp_path / "r.csv", "--every", 30)
    assert answer.status == 0, answer.err
    assert len((tmp_path / "r.csv").read_text().splitlines()) == 1 + 10
