"""Logs made by the encoder, read back."""

import pytest

from gnsslab.gnss.rtcm import read_rtcm


@pytest.fixture
def read(tmp_path):
    """Write frames to a file and return the `RtcmLog` that is read from it; the day is 2026-06-26 unless another is given."""

    def read(*frames, start="2026-06-26"):
        path = tmp_path / "made.rtcm3"
        path.write_bytes(b"".join(frames))
        return read_rtcm(path, start=start)

    return read
