"""Ephemeris messages: integers encoded by hand come back as the quantities they stand for, and survive RINEX."""

import math

import numpy as np
import pytest
from rtcm_encoder import EPHEMERIS_FIELDS, ephemeris, frame, msm

from gnsslab.gnss.rinex import read_rinex_nav, write_rinex_nav
from gnsslab.gnss.rtcm.ephemeris_messages import galileo_accuracy, user_range_accuracy

ANGLES = {"m0", "delta_n", "omega0", "i0", "omega", "omega_dot", "idot"}
SYSTEM = {1019: "G", 1042: "C", 1044: "J", 1045: "E", 1046: "E"}
WEEK = {1019: 2424 % 1024, 1042: 2424 - 1356, 1044: 2424 % 1024, 1045: 1400, 1046: 1400}
TOE = 489_600  # [s] of the week
AT_3, ONE = {3: {"whole": 70}}, {(3, 2): {"cn0": 40}}


def drawn(rng, message):
    """Return integers of all fields: random, but an orbit of a navigation satellite at a known time."""
    raw = {}
    for name, width, is_signed, unit in EPHEMERIS_FIELDS[message]:
        low, high = (-(2 ** (width - 1)), 2 ** (width - 1)) if is_signed else (0, 2**width)
        raw[name] = int(rng.integers(low, high))
        if name in ("toe", "toc"):
            raw[name] = TOE // unit
    return raw | {"number": 3, "week": WEEK[message], "sqrt_a": int(5200.123 * 2**19), "e": raw["e"] // 16, "accuracy": 5}


def expected(message, raw):
    return {name: raw[name] * unit * (math.pi if name in ANGLES else 1) for name, _, _, unit in EPHEMERIS_FIELDS[message]}


@pytest.mark.parametrize("message", SYSTEM)
def test_what_was_encoded_is_read(read, rng, tmp_path, message):
    for _ in range(5):
        raw = drawn(rng, message)
        system = SYSTEM[message]
        found = read(msm("G", 4, TOE * 1000 + 15_000, AT_3, ONE), ephemeris(message, raw)).ephemerides
        assert found.satellite.tolist() == [f"{system}03"]
        for name, value in expected(message, raw).items():
            if name in ANGLES | {"af0", "af1", "af2", "crs", "crc", "cuc", "cus", "cic", "cis", "e", "sqrt_a"}:
                assert getattr(found, name)[0] == pytest.approx(value, rel=1e-14), name
        behind = 14 if system == "C" else 0
        assert str(found.toe[0])[:19] == f"2026-06-26T16:00:{behind:02d}"
        assert found.toc[0] == found.toe[0]
        assert str(found.transmission[0])[:19] == "2026-06-26T16:00:15"
        assert found.group_delay[0] == pytest.approx(delays(message, raw), rel=1e-12)
        assert found.issue[0] == raw["issue"]
        assert found.clock_issue[0] == raw.get("clock_issue", {1045: 258, 1046: 517}.get(message))
        assert found.accuracy[0] == pytest.approx(0.05 if system == "E" else 11.3)
        assert found.health[0] == health(message, raw)
        write_rinex_nav(tmp_path / "made.nav", found)
        again = read_rinex_nav(tmp_path / "made.nav")
        for name in ("toe", "toc", "transmission", "issue", "clock_issue", "health"):
            assert getattr(again, name)[0] == getattr(found, name)[0], name


def delays(message, raw):
    unit = {1042: 1e-10, 1045: 2**-32, 1046: 2**-32}.get(message, 2**-31)
    return [raw["delay_1"] * unit, raw.get("delay_2", 0) * unit]


def health(message, raw):
    """The number as RINEX 3.04 has it (table A8): E1-B validity and status, E5a the same, E5b the same."""
    if message == 1045:
        return raw["e5a_invalid"] * 8 + raw["e5a_health"] * 16
    if message == 1046:
        return raw["e1b_invalid"] + raw["e1b_health"] * 2 + raw["e5b_invalid"] * 64 + raw["e5b_health"] * 128
    return raw["health"]


def test_accuracies_are_those_of_the_interface_documents():
    assert [user_range_accuracy(k) for k in range(15)] == [2, 2.8, 4, 5.7, 8, 11.3, 16, 32, 64, 128, 256, 512, 1024, 2048, 4096]
    for first, last, metres, step in ((0, 50, 0, 0.01), (50, 75, 0.5, 0.02), (75, 100, 1, 0.04), (100, 125, 2, 0.16)):
        for index in range(first, last + 1):
            assert galileo_accuracy(index) == pytest.approx(metres + step * (index - first))
    assert all(np.isnan(value) for value in (user_range_accuracy(15), galileo_accuracy(126), galileo_accuracy(255)))


def test_repeated_messages_stand_once_with_the_first_time(read, rng):
    raw = drawn(rng, 1042)
    epochs = [msm("G", 4, TOE * 1000 + 15_000 * k, AT_3, ONE) for k in (1, 2, 3)]
    found = read(epochs[0], ephemeris(1042, raw), epochs[1], ephemeris(1042, raw), epochs[2]).ephemerides
    assert len(found.toe) == 1
    assert str(found.transmission[0])[:19] == "2026-06-26T16:00:15"


def test_placeholders_and_short_messages_are_no_orbits(read, rng):
    whole = "".join(format(octet, "08b") for octet in ephemeris(1019, drawn(rng, 1019))[3:-3])
    future = ephemeris(1042, drawn(rng, 1042) | {"week": 8191})
    log = read(ephemeris(1042, {"number": 3}), frame(whole[:400]), future, msm("G", 4, 15_000, AT_3, ONE))
    assert len(log.ephemerides.toe) == 0
    assert log.warnings == ("ephemeris messages left out, too short or no orbit of a navigation satellite: 3",)
