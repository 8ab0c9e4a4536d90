"""Station messages: position, antenna height, names."""

import numpy as np
import pytest
from rtcm_encoder import descriptors, frame, msm, station

from gnsslab.gnss.frames import geodetic_from_ecef

POSITION = np.array([-1083472.4132, 5483515.8821, 3066256.4629])
EPOCH = msm("G", 4, 0, {3: {"whole": 70}}, {(3, 2): {"cn0": 40}})
tenth_millimetre = 1e-4


def test_position_and_names(read):
    header = read(station(POSITION), descriptors(1007, "TRM59800.00     SCIS"), EPOCH).observations.header
    assert header.position_ecef == pytest.approx(POSITION, abs=tenth_millimetre)
    assert (header.marker, header.antenna, header.receiver) == ("0000", "TRM59800.00     SCIS", "")
    header = read(descriptors(1008, "A1"), descriptors(1033, "A2", "SEPT POLARX5"), EPOCH).observations.header
    assert (header.antenna, header.receiver, header.position_ecef) == ("A2", "SEPT POLARX5", None)


def test_the_marker_is_lower_than_the_antenna_by_its_height(read):
    header = read(station(POSITION, 1.5), EPOCH).observations.header
    assert header.antenna_delta_enu.tolist() == [0, 0, 1.5]
    at, marker = geodetic_from_ecef(POSITION), geodetic_from_ecef(header.position_ecef)
    assert at[2] - marker[2] == pytest.approx(1.5, abs=2 * tenth_millimetre)
    assert marker[:2] == pytest.approx(at[:2], abs=1e-11)


def test_a_position_that_changes_is_said_and_zeros_are_none(read):
    log = read(station(POSITION), station(POSITION + np.array([0, 0, 0.25])), EPOCH)
    assert log.observations.header.position_ecef == pytest.approx(POSITION, abs=tenth_millimetre)
    assert log.warnings == ("the station's position changes by 0.250 m within the log; the first was kept",)
    assert read(station((0, 0, 0)), EPOCH).observations.header.position_ecef is None


def test_other_stations_and_short_messages_do_not_count(read):
    short = frame("".join(format(octet, "08b") for octet in descriptors(1007, "LONG NAME")[3:9]))
    header = read(station(POSITION, number=5), short, EPOCH).observations.header
    assert (header.position_ecef, header.antenna) == (None, "")
