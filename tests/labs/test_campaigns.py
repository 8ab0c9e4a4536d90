"""Campaigns: files are read once, again when they change, and what is missing is named."""

import numpy as np
import pytest

from gnsslab.labs import campaigns
from gnsslab.labs.campaigns import FileReader, blocked_by_data, require_files
from gnsslab.simulate import find_preset, simulate, write_simulation


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """A folder with a simulated campaign: master.obs, rover.obs, broadcast.nav."""
    folder = tmp_path_factory.mktemp("campaign")
    write_simulation(folder, simulate(find_preset("static-baseline"), np.random.default_rng(5)))
    return folder


def test_a_file_is_read_once(files):
    reader = FileReader()
    assert reader.observations(files / "rover.obs") is reader.observations(str(files / "rover.obs"))
    assert reader.ephemerides(files / "broadcast.nav") is reader.ephemerides(files / "broadcast.nav")


def test_two_labs_share_nothing(files):
    assert FileReader().observations(files / "rover.obs") is not FileReader().observations(files / "rover.obs")


def test_a_changed_file_is_read_again(files, tmp_path):
    path, reader = tmp_path / "own.obs", FileReader()
    path.write_bytes((files / "master.obs").read_bytes())
    first = reader.observations(path)
    lines = path.read_text().splitlines(keepends=True)
    last_epoch = max(i for i, line in enumerate(lines) if line.startswith(">"))
    path.write_text("".join(lines[:last_epoch]))
    assert len(reader.observations(path).time) == len(first.time) - 1


def test_a_real_set_is_read_from_the_project_itself(monkeypatch, tmp_path):
    """The small set travels with the project: neither network nor mirror nor cache is needed."""
    monkeypatch.delenv("GNSSLAB_DATA_MIRROR", raising=False)
    monkeypatch.setenv("GNSSLAB_CACHE", str(tmp_path))
    base, rover, ephemerides = FileReader().data_set("cssrlib-078")
    assert len(base.time) == len(rover.time) == 60  # registry: 60 s at 1 Hz
    assert set("GE") <= set(base.systems)
    assert "G" in {name[0] for name in ephemerides.satellites}


def test_a_set_is_looked_up_once(monkeypatch, files):
    calls, real = [], campaigns.fetch
    monkeypatch.setattr(campaigns, "fetch", lambda name: calls.append(name) or real(name))
    reader = FileReader()
    for _ in range(3):
        reader.data_set("cssrlib-078")
    assert calls == ["cssrlib-078"]


@pytest.mark.parametrize(
    ("paths", "words"),
    [
        ({"master": "", "rover": "r", "navigation": "n"}, "your master file is missing: upload it"),
        ({"master": "", "rover": "", "navigation": "n"}, "your master and rover files are missing: upload them"),
        ({"master": "", "rover": "", "navigation": ""}, "your master, rover and navigation files are missing"),
    ],
)
def test_missing_files_are_named(paths, words):
    with pytest.raises(ValueError, match=words):
        require_files(**paths)


def test_nothing_missing_is_no_error():
    assert require_files(observations="a.obs", navigation="b.nav") is None


@pytest.mark.parametrize(
    ("data", "blocked"),
    [("simulated", {"rover_file"}), ("real", {"seed", "rover_file"}), ("mine", {"seed"})],
)
def test_controls_without_effect_on_the_data_are_named(data, blocked):
    assert set(blocked_by_data(data, ("seed",), ("rover_file",))) == blocked
