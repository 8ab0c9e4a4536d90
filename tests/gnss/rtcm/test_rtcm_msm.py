"""MSM4 to MSM7: measurements encoded by hand come back, from every system; what is invalid, unknown or repeated is said."""

import numpy as np
import pytest
from pyrtcm import RTCMMessage
from rtcm_encoder import INVALID, TENS, bits, frame, msm

from gnsslab.gnss.observations import HALF_CYCLE, SLIP
from gnsslab.gnss.rtcm.frames import find_frames
from gnsslab.gnss.rtcm.msm import read_cells, read_head, signal_name
from gnsslab.gnss.signals import SPEED_OF_LIGHT, frequency

MS = SPEED_OF_LIGHT / 1000  # [m]
micrometre = 1e-6
TOW = 500_000_000  # [ms]
SIGNALS = {"G": {2: "1C", 10: "2W"}, "E": {2: "1C", 23: "5Q"}, "C": {2: "2I", 8: "6I"}, "J": {2: "1C", 17: "2X"}, "R": {2: "1C", 9: "2P"}}
ONE = {(3, 2): {"cn0": 40, "lock": 9}}
AT_3 = {3: {"whole": 70}}


def drawn(rng, system, kind):
    """Return satellites and cells with random contents."""
    fine_code, fine_phase, cn0, lock = (15, 22, 6, 16) if kind < 6 else (20, 24, 10, 704)
    satellites = {
        k: {"whole": rng.integers(60, 90), "modulo": rng.integers(0, 1024), "channel": 5, "rate": rng.integers(-900, 900)} for k in (3, 7, 24)
    }
    cells = {
        (k, signal): {
            "fine_code": rng.integers(-(2 ** (fine_code - 1)) + 1, 2 ** (fine_code - 1)),
            "fine_phase": rng.integers(-(2 ** (fine_phase - 1)) + 1, 2 ** (fine_phase - 1)),
            "lock": rng.integers(0, lock),
            "half": rng.integers(0, 2),
            "cn0": rng.integers(1, 2**cn0),
            "fine_rate": rng.integers(-16383, 16384),
        }
        for k in (3, 7, 24)
        for signal in SIGNALS[system]
        if (k, signal) != (7, 2)
    }  # fmt: skip
    as_int = lambda table: {key: {name: int(value) for name, value in fields.items()} for key, fields in table.items()}  # noqa: E731
    return as_int(satellites), as_int(cells)


@pytest.mark.parametrize("kind", [4, 5, 6, 7])
@pytest.mark.parametrize("system", "GECJR")
def test_what_was_encoded_is_read(read, rng, system, kind):
    satellites, cells = drawn(rng, system, kind)
    clock = TOW if system != "R" else 5 << 27 | 50_000_000
    log = read(msm(system, kind, clock, satellites, cells))
    table = log.observations.tables[system]
    assert table.satellites == tuple(f"{system}{k:02d}" for k in (3, 7, 24))
    assert table.column("D" + SIGNALS[system][2]) is not None or kind in (4, 6)
    for (satellite, signal), cell in cells.items():
        name = SIGNALS[system][signal]
        row = np.flatnonzero(table.number == satellite)[0]
        rough = satellites[satellite]["whole"] + satellites[satellite]["modulo"] / 1024
        code, phase = (2.0**-24, 2.0**-29) if kind < 6 else (2.0**-29, 2.0**-31)
        value = {letter: table.value[row, table.column(letter + name)] for letter in "CS"}
        assert value["C"] == pytest.approx((rough + cell["fine_code"] * code) * MS, abs=micrometre)
        assert value["S"] == cell["cn0"] * (1 if kind < 6 else 1 / 16)
        carrier = frequency(system, name[0])
        if system == "R":
            if kind in (4, 6):  # no message says the channel
                assert table.column("L" + name) is None
                continue
            carrier += -2 * (562_500 if name[0] == "1" else 437_500)  # DF419 = 5 is channel -2
        phase_m = table.value[row, table.column("L" + name)] * SPEED_OF_LIGHT / carrier
        assert phase_m == pytest.approx((rough + cell["fine_phase"] * phase) * MS, abs=micrometre)
        assert table.lli[row, table.column("L" + name)] == cell["half"] * HALF_CYCLE
        if kind in (5, 7):
            rate = satellites[satellite]["rate"] + cell["fine_rate"] * 1e-4
            assert table.value[row, table.column("D" + name)] == pytest.approx(-rate * carrier / SPEED_OF_LIGHT, abs=1e-6)
    assert np.isnan(table.value[np.flatnonzero(table.number == 7)[0], table.column("C" + SIGNALS[system][2])])


@pytest.mark.parametrize("kind", [4, 5, 6, 7])
def test_the_same_cells_as_pyrtcm_parses(rng, kind):
    satellites, cells = drawn(rng, "G", kind)
    payload = msm("G", kind, TOW, satellites, cells)[3:-3]
    ours = read_cells([payload], [read_head(payload).layout])["G"]
    theirs = RTCMMessage(payload=payload)
    assert_as_pyrtcm(ours, theirs, "G")


def test_the_same_cells_as_pyrtcm_parses_from_a_real_log(dataset):
    content = (dataset("beidou-slope") / "rover_all.rtcm3").read_bytes()[:60_000]
    frames = find_frames(content)
    payloads = [content[a:b] for a, b, number in zip(frames.start, frames.stop, frames.number, strict=True) if number == 1124]
    cells = read_cells(payloads, [read_head(payload).layout for payload in payloads])["C"]
    assert len(payloads) > 200
    for k in range(0, len(payloads), 40):
        own = type(cells)(*(field[cells.message == k] for field in cells))
        assert_as_pyrtcm(own, RTCMMessage(payload=payloads[k]), "C")


def assert_as_pyrtcm(ours, theirs, system):
    """Compare one message's cells with pyrtcm's own parse, cell by cell."""
    assert len(ours.number) == theirs.NCell > 0
    of = lambda name, k: getattr(theirs, f"{name}_{k:02d}", None)  # noqa: E731
    place = {of("PRN", k): k for k in range(1, theirs.NSat + 1)}
    for k in range(1, theirs.NCell + 1):
        assert (int(of("CELLPRN", k)), of("CELLSIG", k)) == (ours.number[k - 1], signal_name(system, int(ours.signal[k - 1])))
        satellite = place[of("CELLPRN", k)]
        rough = of("DF397", satellite) + of("DF398", satellite)
        fine_code, fine_phase = (of("DF400", k), of("DF401", k)) if hasattr(theirs, "DF400_01") else (of("DF405", k), of("DF406", k))
        if fine_code > -(2.0**-10):  # the lowest number is no value
            assert ours.code[k - 1] == pytest.approx((rough + fine_code) * MS, abs=micrometre)
        if fine_phase > -(2.0**-8):
            assert ours.phase[k - 1] == pytest.approx((rough + fine_phase) * MS, abs=micrometre)
        assert bool(of("DF420", k)) == ours.is_half[k - 1]
        assert (of("DF403", k) or of("DF408", k)) == ours.cn0[k - 1]
        if of("DF404", k) is not None:
            assert ours.rate[k - 1] == pytest.approx(of("DF399", satellite) + of("DF404", k), abs=1e-9)


@pytest.mark.parametrize("kind", [5, 7])
def test_invalid_numbers_are_no_values(read, kind):
    lowest = 4 if kind == 5 else 6
    satellites = {1: {"whole": 70}, 2: {"whole": 70, "rate": INVALID["rate"]}, 3: {"whole": INVALID["whole"]}, 4: {"whole": 70}, 5: {"whole": 70}}
    cells = {(k, 2): {"cn0": 40} for k in satellites} | {
        (1, 2): {"fine_code": INVALID["fine_code"][lowest]},
        (4, 2): {"fine_phase": INVALID["fine_phase"][lowest], "half": 1},
        (5, 2): {"fine_rate": INVALID["fine_rate"]},
    }  # fmt: skip
    table = read(msm("G", kind, TOW, satellites, cells)).observations.tables["G"]
    kinds = np.array([code[0] for code in table.codes])
    is_given = {int(k): "".join(kinds[np.isfinite(row)]) for k, row in zip(table.number, table.value, strict=True)}
    assert is_given == {1: "LD", 2: "CLS", 4: "CD", 5: "CL"}  # of satellite 3 nothing is known
    assert not table.lli.any()


def test_messages_of_one_time_are_one_epoch(read):
    parts = [msm("C", 4, TOW - 14_000, {k: {"whole": 70}}, {(k, 2): {"cn0": 40}}, multiple=int(k < 3)) for k in (1, 2, 3)]
    gps = msm("G", 4, TOW, AT_3, ONE, multiple=1)
    log = read(gps, *parts)
    assert len(log.observations.time) == 1
    assert log.observations.satellites == ("C01", "C02", "C03", "G03")
    assert log.warnings == ()


def test_a_lost_last_part_costs_nothing_else(read):
    parts = [msm("C", 4, TOW + 1000 * t, {k: {"whole": 70}}, {(k, 2): {"cn0": 40}}, multiple=int(k < 2)) for t in (0, 1) for k in (1, 2)]
    observations = read(parts[0], *parts[2:]).observations
    assert len(observations.time) == 2
    assert observations.tables["C"].number.tolist() == [1, 1, 2]


def test_slips_are_flagged_where_lock_times_say_so(read):
    locks = [9, 10, 10, 3, 8, None, 8]  # every second; the fourth is a slip; at the last but one there is no phase
    frames = []
    for k, lock in enumerate(locks):
        cell = {"fine_phase": INVALID["fine_phase"][4]} if lock is None else {"lock": lock}
        frames.append(msm("G", 4, TOW + 1000 * k, AT_3, {(3, 2): cell}))
    table = read(*frames).observations.tables["G"]
    assert table.lli[:, table.column("L1C")].tolist() == [0, 0, 0, SLIP, 0, 0, 0]


def test_a_slip_while_the_phase_was_missing_is_flagged_when_it_returns(read):
    cells = [{"lock": 15}, {"fine_phase": INVALID["fine_phase"][4]}, {"lock": 5, "half": 1}]
    table = read(*(msm("G", 4, TOW + 30_000 * k, AT_3, {(3, 2): cell}) for k, cell in enumerate(cells))).observations.tables["G"]
    assert table.lli[:, table.column("L1C")].tolist() == [0, 0, SLIP | HALF_CYCLE]


def test_unknown_signals_are_counted_and_said(read):
    log = read(msm("G", 4, TOW, AT_3, ONE | {(3, 5): {"cn0": 30}}))
    assert log.observations.tables["G"].codes == ("C1C", "L1C", "S1C")
    assert log.warnings == ("signals of GPS that are not known here were left out, with the number of measurements: 5 (1)",)


def test_a_repeated_message_is_said(read):
    one = msm("G", 4, TOW, AT_3, ONE)
    log = read(one, one)
    assert len(log.observations.tables["G"].number) == 1
    assert log.warnings == ("measurements given a second time at the same time: 1; the first were kept",)


def test_a_message_shorter_than_its_masks_say_is_left_out(read):
    payload = msm("G", 4, TOW, AT_3, ONE)[3:-3]
    short = frame("".join(format(octet, "08b") for octet in payload[:-2]))
    log = read(msm("G", 4, TOW, AT_3, ONE), short, msm("G", 4, 604_800_000, AT_3, ONE))
    assert len(log.observations.time) == 1
    assert log.warnings == ("observation messages left out, too short or of an impossible time: 2",)


@pytest.mark.parametrize("share", [0.02, 0.1, 0.5])
def test_messages_of_any_content_are_read_or_left_out(read, rng, share):
    """Whoever writes a right checksum over nonsense gets no traceback."""
    numbers = [1005, 1008, 1019, 1020, 1033, 1042, 1044, 1045, 1046, *(tens * 10 + kind for tens in TENS.values() for kind in (4, 5, 6, 7))] * 5
    contents = ["".join("01"[int(bit)] for bit in rng.random(rng.integers(0, 1500)) < share) for _ in numbers]
    log = read(*(frame(bits(number, 12) + content) for number, content in zip(numbers, contents, strict=True)))
    assert sum(log.messages.values()) == len(numbers)
    assert all("\n" not in warning for warning in log.warnings)


def test_another_station_is_left_out_and_said(read):
    frames = [msm("G", 4, TOW + 1000 * k, AT_3, ONE, number=7) for k in range(3)]
    log = read(*frames, msm("G", 4, TOW, {9: {"whole": 70}}, {(9, 2): {"cn0": 40}}, number=8))
    assert log.observations.header.marker == "0007"
    assert log.observations.satellites == ("G03",)
    assert log.warnings == ("observations of several stations: those of station 7 were read, left out (messages): 8 (1)",)


def test_channels_of_glonass_come_from_ephemerides_too(read):
    ephemeris = frame(bits(1020, 12) + bits(3, 6) + bits(12, 5) + "0" * 337)  # slot 3, channel 5
    log = read(ephemeris, msm("R", 4, 50_000_000, AT_3, ONE))
    table = log.observations.tables["R"]
    carrier = 1602e6 + 5 * 562_500
    assert log.observations.header.glonass_channels == {"R03": 5}
    assert table.value[0, table.column("L1C")] == pytest.approx(70 * MS * carrier / SPEED_OF_LIGHT, abs=1e-4)
    without = read(msm("R", 4, 50_000_000, AT_3, ONE))
    assert without.warnings == ("no message says the frequency channels of R03: their phases are left out",)


def test_times_that_go_back_are_said(read):
    log = read(*(msm("G", 4, TOW + 1000 * k, AT_3, ONE) for k in (0, 2, 1)))
    assert np.all(np.diff(log.observations.time) > np.timedelta64(0))
    assert log.warnings == ("observation messages earlier than the one before them: 1; the epochs were put in order of time",)
