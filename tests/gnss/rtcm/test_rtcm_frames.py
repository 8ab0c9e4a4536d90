"""Frames: found among anything, with a checksum computed in another way, and every byte accounted for."""

import io

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pyrtcm import RTCMReader
from rtcm_encoder import frame, station

from gnsslab.gnss.rtcm.frames import find_frames

MESSAGES = [station((1.0, 2.0, 3.0)), station((1.0, 2.0, 3.0), 1.5), frame("0" * 30), frame("1" * 8184)]


def test_each_frame_is_found_with_number_and_place():
    content = b"".join(MESSAGES)
    frames = find_frames(content)
    assert frames.number.tolist() == [1005, 1006, 0, 4095]
    assert [content[a - 3 : b + 3] for a, b in zip(frames.start, frames.stop, strict=True)] == MESSAGES
    assert frames[3:] == (0, 0, False)


@settings(max_examples=30, deadline=None)
@given(st.lists(st.binary(max_size=40), min_size=5, max_size=5))
def test_anything_may_stand_between_frames(between):
    """Garbage may hold preambles; that it holds a checksum that fits has a chance of 2^-24."""
    content = b"".join(part for pair in zip(between, [*MESSAGES, b""], strict=True) for part in pair)
    frames = find_frames(content)
    assert frames.number.tolist() == [1005, 1006, 0, 4095]
    assert frames.passed_over == sum(map(len, between))


def test_a_damaged_bit_costs_one_message(rng):
    for at in rng.integers(0, len(MESSAGES[1]) * 8, 40).tolist():
        broken = bytearray(MESSAGES[1])
        broken[at // 8] ^= 1 << at % 8
        frames = find_frames(MESSAGES[0] + bytes(broken) + MESSAGES[2])
        assert frames.number.tolist() == [1005, 0]
        assert frames.passed_over == len(MESSAGES[1])
        assert frames.damaged == (at >= 16 or at in (8, 9))  # else its head is none any more: bytes like any others


def test_a_wrong_length_hides_no_good_frame():
    broken = b"\xd3\x00\xff" + MESSAGES[0][3:]
    frames = find_frames(broken + MESSAGES[1] * 20)
    assert frames.number.tolist() == [1006] * 20
    assert frames.damaged == 1


@pytest.mark.parametrize("kept", [1, 2, 3, 10, 24])
def test_a_log_that_ends_within_a_message(kept):
    frames = find_frames(MESSAGES[0] + MESSAGES[1][:kept])
    assert (frames.number.tolist(), frames.passed_over, frames.is_cut_off) == ([1005], kept, True)


def test_nothing_is_found_where_nothing_is():
    for content in (b"", b"\xd3", b"\xd3\x00", b"\xd3\x00\x00\x47\xea\x4b", bytes(1000)):
        assert len(find_frames(content).start) == 0


def test_the_same_frames_as_pyrtcm_reads(dataset):
    content = (dataset("beidou-slope") / "base_all.rtcm3").read_bytes()[:150_000]
    content = content[: content.rindex(b"\xd3\x00")]  # pyrtcm complains of an end within a message
    ours = find_frames(content)
    theirs = [raw for raw, _ in RTCMReader(io.BytesIO(content), validate=1, parsed=0)]
    assert len(theirs) > 500
    assert [content[a - 3 : b + 3] for a, b in zip(ours.start, ours.stop, strict=True)] == theirs
    assert np.all(np.diff(ours.start) > 0)
