"""What is no RTCM 3 log, or not a whole one: one plain sentence each."""

import gzip
import pickle

import pytest
from rtcm_encoder import frame, msm, station

import gnsslab as gl
from gnsslab.gnss.rtcm import is_rtcm, read_rtcm

EPOCH = msm("G", 4, 0, {3: {"whole": 70}}, {(3, 2): {"cn0": 40}})
LEGACY = frame(format(1004, "012b") + "0" * 100)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "the file is empty; expected an RTCM 3 log"),
        (b"     3.04           OBSERVATION DATA", "no RTCM 3 message was found; expected a binary log of them, it begins with '     3.04'"),
        (b"\xb5\x62" * 500, "no RTCM 3 message was found"),
        (EPOCH[:20], "no RTCM 3 message was found"),
        (b"\x1f\x8b\x08", "the gzip data are damaged"),
    ],
)
def test_what_is_no_log_is_said(tmp_path, content, words):
    path = tmp_path / "x.rtcm3"
    path.write_bytes(content)
    with pytest.raises(gl.RtcmError, match=words.replace("(", r"\(")) as caught:
        read_rtcm(path)
    assert str(caught.value).startswith(str(path))
    assert "\n" not in str(caught.value)
    assert str(pickle.loads(pickle.dumps(caught.value))) == str(caught.value)


def test_places_that_are_no_file(tmp_path):
    with pytest.raises(gl.RtcmError, match="this is a folder"):
        read_rtcm(tmp_path)
    with pytest.raises(gl.RtcmError, match="cannot be read"):
        read_rtcm(tmp_path / "nothing.rtcm3")


def test_a_day_that_is_none(tmp_path):
    path = tmp_path / "x.rtcm3"
    path.write_bytes(EPOCH)
    for day in ("tomorrow", "2026-13-01", "NaT", "1900-01-01"):
        with pytest.raises(ValueError, match="expected a date like 2026-06-26"):
            read_rtcm(path, start=day)


def test_what_was_set_aside_is_said(read):
    broken = bytearray(EPOCH)
    broken[10] ^= 1
    log = read(EPOCH, b"$GPGGA\r\n", bytes(broken), LEGACY, LEGACY, frame(format(1230, "012b") + "0" * 20), EPOCH[:30])
    assert log.warnings == (
        "damaged messages (wrong checksum) that were passed over: 1",
        "the log ends within a message; that one is left out",
        f"bytes that belong to no good message: {8 + len(EPOCH) + 30}",
        "messages that are not used here were passed over: 1004 (2), 1230 (1)",
    )
    assert log.messages == {1004: 2, 1074: 1, 1230: 1}


def test_a_log_without_observations_is_read(read):
    log = read(LEGACY, station((1.0, 2.0, 3.0)))
    assert (len(log.observations.time), log.observations.tables, len(log.ephemerides.toe)) == (0, {}, 0)
    assert repr(log) == "RtcmLog: 2 messages; Observations: 0 epochs, 0 satellites of ; empty; Ephemerides: 0 data sets of 0 satellites"


def test_gzip_is_unpacked_and_recognised(tmp_path):
    path = tmp_path / "x.rtcm3.gz"
    path.write_bytes(gzip.compress(EPOCH))
    assert is_rtcm(path)
    assert gl.read_rtcm(path, start="2026-06-26").observations.satellites == ("G03",)


def test_progress_is_told(tmp_path):
    path, seen = tmp_path / "x.rtcm3", []
    path.write_bytes(EPOCH * 3)
    read_rtcm(path, "2026-06-26", lambda done, total: seen.append((done, total)))
    assert seen[-1] == (3, 3)
