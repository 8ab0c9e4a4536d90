"""Files that are made from a log of the same data set: on a machine, or a mirror, that has the log only."""

import hashlib
import json

import pytest

from gnsslab.data import DataFile, Dataset, dataset_path, fetch, find_dataset, verify
from gnsslab.data import fetching as module
from gnsslab.gnss.rinex import read_rinex_nav, read_rinex_obs

NEVER = "0" * 64  # no file has this checksum


@pytest.fixture
def small(dataset, monkeypatch, tmp_path):
    """A registered data set whose mirror has the log, ten minutes of a real one, but not what is converted from it."""
    content = (dataset("beidou-slope") / "base_all.rtcm3").read_bytes()[:17_000]
    log = DataFile("base.rtcm3", len(content), hashlib.sha256(content).hexdigest(), "http://127.0.0.1:9/base.rtcm3")
    made = [DataFile(name, 1, NEVER, made_from="converted by another program", converted_from="base.rtcm3") for name in ("base.obs.gz", "base.nav")]
    monkeypatch.setattr(module, "find_dataset", lambda name: Dataset("small", "a small set", "none", "", "", (*made, log)))
    (tmp_path / "mirror" / "small").mkdir(parents=True)
    (tmp_path / "mirror" / "small" / "base.rtcm3").write_bytes(content)
    monkeypatch.setenv("GNSSLAB_CACHE", str(tmp_path / "cache"))
    monkeypatch.setenv("GNSSLAB_DATA_MIRROR", str(tmp_path / "mirror"))
    return tmp_path


def test_a_mirror_with_the_log_alone_serves(small):
    assert verify("small") == {"base.obs.gz": "not here yet", "base.nav": "not here yet", "base.rtcm3": "ok"}
    folder = fetch("small")
    assert folder == small / "cache" / "small"
    assert {path.name for path in folder.iterdir()} == {"base.obs.gz", "base.obs.gz.json", "base.nav", "base.nav.json", "base.rtcm3"}
    assert len(read_rinex_obs(folder / "base.obs.gz").time) > 30
    assert len(read_rinex_nav(folder / "base.nav").toe) > 5
    assert set(verify("small").values()) == {"ok"}


def test_it_is_made_once_and_again_when_damaged(small):
    made = dataset_path("small", "base.nav")
    first = made.read_bytes()
    made_at = made.stat().st_mtime_ns
    assert dataset_path("small", "base.nav").stat().st_mtime_ns == made_at
    made.write_bytes(first[:-100])
    assert verify("small")["base.nav"].startswith("wrong checksum")
    assert len(dataset_path("small", "base.nav").read_bytes()) == len(first)


@pytest.mark.parametrize("proof", ["", "[]", "{}", json.dumps({"its_sha256": NEVER, "sha256": NEVER})])
def test_a_file_without_its_proof_is_not_trusted(small, proof):
    made = dataset_path("small", "base.nav")
    made.with_name("base.nav.json").write_text(proof)
    assert verify("small")["base.nav"].startswith("wrong checksum")
    dataset_path("small", "base.nav")
    assert verify("small")["base.nav"] == "ok"


def test_what_the_registry_converts_from_is_there_with_an_address():
    logs = {(name, file.converted_from) for name in ("beidou-slope",) for file in find_dataset(name).files if file.converted_from}
    assert logs == {("beidou-slope", "base_all.rtcm3"), ("beidou-slope", "rover_all.rtcm3")}
    for name, log in logs:
        assert find_dataset(name).file(log).url


def test_a_registered_set_from_its_logs(dataset, monkeypatch, tmp_path):
    (tmp_path / "beidou-slope").mkdir()
    for log in ("base_all.rtcm3", "rover_all.rtcm3"):
        (tmp_path / "beidou-slope" / log).symlink_to(dataset("beidou-slope") / log)
    monkeypatch.setenv("GNSSLAB_CACHE", str(tmp_path / "cache"))
    monkeypatch.setenv("GNSSLAB_DATA_MIRROR", str(tmp_path))
    made = dataset_path("beidou-slope", "base_all.nav")
    assert len(read_rinex_nav(made).satellites) == 35  # as in RTKLIB's conversion
