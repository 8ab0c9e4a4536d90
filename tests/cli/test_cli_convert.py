"""`gnsslab convert` and `gnsslab info` on RTCM 3 logs: a slice of a real one there and back, and what is no log."""

import gzip
import json
from pathlib import Path

import numpy as np
import pytest

from gnsslab.gnss.rinex import read_rinex_nav, read_rinex_obs
from gnsslab.gnss.rtcm import read_rtcm

half_a_digit = 0.5005e-3  # of RINEX


@pytest.fixture(scope="module")
def log(dataset, tmp_path_factory):
    """The first half hour of a real log."""
    path = tmp_path_factory.mktemp("log") / "slope.rtcm3"
    path.write_bytes((dataset("beidou-slope") / "base_all.rtcm3").read_bytes()[:50_000])
    return path


def test_what_is_written_is_what_was_read(run, log, tmp_path):
    answer = run("convert", log, "-o", tmp_path / "new")
    assert answer.status == 0, answer.err
    first, second = answer.err.splitlines()
    assert first == "note: the log ends within a message; that one is left out"
    assert second.startswith("note: bytes that belong to no good message: ")
    assert f"written to {tmp_path / 'new' / 'slope.obs'}" in answer.out
    assert {path.name for path in (tmp_path / "new").iterdir()} == {"slope.obs", "slope.nav", "slope.obs.json", "slope.nav.json"}
    read, written = read_rtcm(log), read_rinex_obs(tmp_path / "new" / "slope.obs")
    ours, theirs = read.observations.tables["C"], written.tables["C"]
    assert len(written.time) > 100
    assert np.array_equal(written.time, read.observations.time)
    assert ours.codes == theirs.codes
    assert np.array_equal(ours.lli, theirs.lli)
    np.testing.assert_allclose(ours.value, theirs.value, rtol=0, atol=half_a_digit)
    navigation = read_rinex_nav(tmp_path / "new" / "slope.nav")
    assert np.array_equal(navigation.toe, read.ephemerides.toe)
    np.testing.assert_allclose(navigation.m0, read.ephemerides.m0, rtol=5.1e-12)


def test_each_output_says_what_made_it(run, log, tmp_path):
    run("convert", log, "-o", tmp_path, "--start", "2026-06-26")
    made = json.loads((tmp_path / "slope.nav.json").read_text())
    assert made["options"] == {"file": str(log), "output": str(tmp_path), "start": "2026-06-26"}
    assert made["inputs"][0]["bytes"] == 50_000
    assert made["notes"]


def test_info_tells_of_a_log(run, log):
    answer = run("info", log)
    assert answer.status == 0, answer.err
    text = " ".join(answer.out.split())
    assert "RTCM 3 log messages 1006 (23), 1042 (23), 1124 (230) station 0000" in text
    assert "span 2026-06-26T16:00:15.000 to 2026-06-26T16:" in text
    assert "one every 15 s" in text
    assert "BeiDou 2I CLS" in text
    assert "BeiDou 7D CLS" in text
    assert "data sets of" in text
    assert "warnings 2 the log ends within a message" in text


@pytest.fixture
def bad(log, tmp_path):
    """Files that cannot be converted."""
    (tmp_path / "empty.rtcm3").write_bytes(b"")
    (tmp_path / "text.rtcm3").write_text("dear diary\n")
    content = log.read_bytes()
    (tmp_path / "slope.obs").write_bytes(content)
    only = next(content[k : k + 27] for k in range(len(content)) if content[k : k + 5] == b"\xd3\x00\x15\x3e\xe0")
    (tmp_path / "station.rtcm3").write_bytes(only)
    return tmp_path


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["empty.rtcm3", "-o", "new"], "the file is empty"),
        (["text.rtcm3", "-o", "new"], "no RTCM 3 message was found"),
        (["nothing.rtcm3", "-o", "new"], "cannot be read"),
        ([".", "-o", "new"], "this is a folder"),
        (["station.rtcm3", "-o", "new"], "has nothing to convert: expected observations (MSM4 to MSM7) or ephemerides, found messages 1006 (1)"),
        (["slope.obs", "-o", "."], "is one of the inputs: give another name"),
        (["slope.obs", "-o", "text.rtcm3"], "cannot be made"),
        (["slope.obs", "-o", ""], "has no name"),
        (["slope.obs", "-o", "new", "--start", "yesterday"], "--start yesterday: expected"),
    ],
)
def test_what_cannot_be_done_is_said_in_one_line(run, bad, monkeypatch, arguments, words):
    monkeypatch.chdir(bad)
    answer = run("convert", *arguments)
    assert (answer.status, answer.out, len(answer.err.splitlines())) == (1, "", 1)
    assert words in answer.err
    assert not Path("new").exists()


def test_a_log_without_week_takes_the_day_that_is_given(run, log, tmp_path):
    """Without its ephemerides the same log is dated by --start, and has no navigation file."""
    from gnsslab.gnss.rtcm.frames import find_frames

    content = log.read_bytes()
    frames = find_frames(content)
    kept = [content[a - 3 : b + 3] for a, b, number in zip(frames.start, frames.stop, frames.number, strict=True) if number == 1124]
    path = tmp_path / "weekless.rtcm3.gz"
    path.write_bytes(gzip.compress(b"".join(kept)))
    answer = run("convert", path, "-o", tmp_path, "--start", "2026-06-24")
    assert answer.status == 0
    assert answer.err == "note: the log has no ephemerides: take the navigation file from another source\n"
    assert read_rinex_obs(tmp_path / "weekless.obs").time[0] == np.datetime64("2026-06-26T16:00:15")
    assert not (tmp_path / "weekless.nav").exists()
    assert "the date of the file serves" in run("convert", path, "-o", tmp_path).err
