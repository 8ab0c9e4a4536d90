import shutil
import subprocess
from dataclasses import replace

import numpy as np
import pytest

import gnsslab as gl
from gnsslab.core.rotations import heading_pitch_of, rotation_from_heading_pitch_roll
from gnsslab.gnss.ephemerides import ARRAY_FIELDS
from gnsslab.gnss.frames import enu_rotation
from gnsslab.simulate import PRESETS, draw, idealise, observe, observe_drawn, prepare_geometry, simulate, write_simulation
from gnsslab.simulate.geometry import antenna_position, satellite_tracks
from gnsslab.simulate.receivers import NO_NOISE, Clock, Noise

MM = 1e-3
SHORT = replace(PRESETS["static-baseline"], duration=20.0)


def of_seed(preset, seed):
    return simulate(preset, np.random.default_rng(seed))


def assert_same(a, b):
    """Hold two `Observations` equal, bit for bit."""
    assert np.array_equal(a.time, b.time)
    assert list(a.tables) == list(b.tables)
    for system, one in a.tables.items():
        other = b.tables[system]
        assert one.codes == other.codes
        for name in ("epoch", "number", "value", "lli", "ssi"):
            mine, theirs = getattr(one, name), getattr(other, name)
            assert mine.dtype == theirs.dtype
            assert np.array_equal(mine, theirs, equal_nan=name == "value")


def test_the_same_seed_gives_the_same_data_another_seed_other_data():
    first, again, other = of_seed(SHORT, 5), of_seed(SHORT, 5), of_seed(SHORT, 6)
    for a, b in zip(first.observations, again.observations, strict=True):
        assert_same(a, b)
    different = first.observations[0].tables["G"].value != other.observations[0].tables["G"].value
    assert different.mean() > 0.9
    assert np.array_equal(first.truth.baselines_enu, other.truth.baselines_enu)  # the truth knows no seed


def test_the_same_seed_writes_the_same_bytes(tmp_path):
    for folder in ("a", "b"):
        write_simulation(tmp_path / folder, of_seed(SHORT, 5))
    names = sorted(path.name for path in (tmp_path / "a").iterdir())
    assert names == ["broadcast.nav", "master.obs", "rover.obs", "truth.csv"]
    for name in names:
        a, b = ((tmp_path / folder / name).read_text().splitlines() for folder in ("a", "b"))
        assert [line for line in a if "PGM" not in line] == [line for line in b if "PGM" not in line]  # that line has the time of day


@pytest.mark.parametrize("name", ["static-baseline", "paper-a-turntable", "car-rtk", "four-antennas"])
def test_rinex_gives_back_bit_for_bit_what_was_simulated(tmp_path, name):
    simulation = of_seed(replace(PRESETS[name], duration=230.0 if "turn" in name else 160.0, bands=3), 2)
    paths = write_simulation(tmp_path, simulation)
    assert len(paths) == len(simulation.observations) + 2
    for path, observations in zip(paths, simulation.observations, strict=False):
        read = gl.read_rinex_obs(path)
        assert_same(read, observations)
        assert np.array_equal(read.header.position_ecef, observations.header.position_ecef)
        assert read.header.marker == observations.header.marker
        assert read.warnings == ()
    read = gl.read_rinex_nav(tmp_path / "broadcast.nav")
    for field in ARRAY_FIELDS:
        assert np.array_equal(getattr(read, field), getattr(simulation.ephemerides, field))
    assert all(np.array_equal(read.ionosphere[key], simulation.ephemerides.ionosphere[key]) for key in simulation.ephemerides.ionosphere)


def test_values_are_what_a_file_can_hold():
    for observations in of_seed(SHORT, 1).observations:
        for table in observations.tables.values():
            value = table.value[np.isfinite(table.value)]
            assert all(float(f"{x:.3f}") == x for x in value.tolist())
            assert not np.signbit(value[value == 0]).any()
            order = np.lexsort((table.number, table.epoch))
            assert np.array_equal(order, np.arange(len(order)))


def test_signal_strength_classes_follow_cn0():
    table = of_seed(SHORT, 1).observations[0].tables["G"]
    for signal in ("1C", "2W"):
        cn0, code, carrier = (table.column(kind + signal) for kind in "SCL")
        expected = np.clip(table.value[:, cn0] // 6, 1, 9)
        assert np.array_equal(table.ssi[:, code], expected)
        assert np.array_equal(table.ssi[:, carrier], expected)
        assert not table.ssi[:, cn0].any()


def test_the_truth_is_written_as_agreed(tmp_path):
    simulation = of_seed(PRESETS["paper-a-turntable"], 1)
    write_simulation(tmp_path, simulation)
    lines = (tmp_path / "truth.csv").read_text().splitlines()
    assert lines[0] == "time,east_m,north_m,up_m,heading_deg,pitch_deg,roll_deg"
    assert len(lines) == 1 + 300  # also the epoch that the master missed
    assert lines[1].startswith("2019-03-16T12:35:00.000,")
    assert "-0.00000," not in "\n".join(lines)
    values = np.array([[float(x) for x in line.split(",")[1:]] for line in lines[1:]])
    assert np.abs(values[:, :3] - simulation.truth.baselines_enu[0]).max() < 0.01 * MM
    assert np.abs(values[:, 3] - np.degrees(simulation.truth.heading)).max() < 1e-6


def test_heading_and_pitch_of_the_baseline_follow_from_the_bodys():
    for name in ("static-baseline", "ship-heading", "paper-a-turntable"):
        truth = of_seed(replace(PRESETS[name], duration=60.0, events=()), 1).truth
        heading, pitch = heading_pitch_of(truth.baselines_enu[0])
        assert np.abs(np.angle(np.exp(1j * (heading - truth.heading)))).max() < 1e-6
        assert np.abs(pitch - truth.pitch).max() < 1e-6


def test_four_baselines_are_the_lever_arms_turned():
    preset = PRESETS["four-antennas"]
    truth = of_seed(replace(preset, duration=30.0), 1).truth
    R_nb = rotation_from_heading_pitch_roll(truth.heading, truth.pitch, truth.roll)
    for k, arm in enumerate(preset.antennas[1:]):
        assert np.abs(truth.baselines_enu[k] - R_nb @ np.subtract(arm, preset.antennas[0])).max() < 0.001 * MM


def test_with_a_base_the_baseline_starts_there():
    preset = PRESETS["car-rtk"]
    truth = of_seed(preset, 1).truth
    assert np.ptp(truth.position_ecef, axis=0).max() < 1e-6
    rover = antenna_position(preset, 1, np.arange(300.0))
    expected = (rover - truth.position_ecef) @ enu_rotation(truth.position_ecef[0]).T
    assert np.abs(truth.baselines_enu[0] - expected).max() < 1e-6


@pytest.mark.parametrize("name", ["static-baseline", "car-rtk", "static-rtk-5km"])
def test_single_points_recover_the_truth_of_a_quiet_simulation(name):
    preset = replace(PRESETS[name], duration=60.0, events=(), noise=NO_NOISE, clocks=(Clock(3e-4, 1e-8), Clock(-2e-4, 2e-8)))
    simulation = of_seed(preset, 1)
    for receiver, observations in enumerate(simulation.observations):
        points = gl.solve_points(observations, simulation.ephemerides)
        seconds = np.arange(60.0)
        true = antenna_position(preset, receiver, seconds - preset.clocks[receiver].error(seconds))
        assert np.abs(points.position_ecef - true).max() < 2 * MM  # codes are rounded to 1 mm


@pytest.mark.parametrize("site", [(-33.0, -70.0, 500.0), (89.9, 10.0, 0.0), (0.0, 180.0, 3000.0), (90.0, 0.0, 0.0)])
def test_any_place_and_the_turn_of_the_week_will_do(site):
    preset = replace(SHORT, site=site, start="2024-06-22T23:59:50", noise=NO_NOISE)
    simulation = of_seed(preset, 1)
    points = gl.solve_points(simulation.observations[0], simulation.ephemerides)
    assert np.abs(points.position_ecef - simulation.truth.position_ecef).max() < 5 * MM  # rounding, geometry of the poles
    assert np.linalg.norm(simulation.truth.baselines_enu[0], axis=-1) == pytest.approx(1.167, abs=1e-6)


def test_noise_and_length_find_the_sky_ready():
    satellite_tracks.cache_clear()
    geometry = prepare_geometry(SHORT)
    prepare_geometry(replace(SHORT, noise=Noise(code=1.0), antennas=((0.0, 0.0, 0.0), (0.0, 3.0, 0.0))))
    assert satellite_tracks.cache_info().misses == 1
    assert_same(observe(geometry, SHORT.noise, np.random.default_rng(5)).observations[0], of_seed(SHORT, 5).observations[0])


def test_errors_drawn_once_serve_every_noise():
    geometry, noises = prepare_geometry(SHORT), (SHORT.noise, Noise(code=1.0, carrier=0.004), SHORT.noise)
    ideals, draws = idealise(geometry), draw(geometry, np.random.default_rng(5))
    for noise in noises:
        expected = observe(geometry, noise, np.random.default_rng(5))
        for a, b in zip(observe_drawn(geometry, ideals, draws, noise).observations, expected.observations, strict=True):
            assert_same(a, b)


def test_errors_of_a_system_do_not_depend_on_the_others():
    whole = prepare_geometry(SHORT)
    galileo = prepare_geometry(replace(SHORT, satellites=tuple(name for name in whole.tracks.satellites if name[0] == "E")))
    alone = observe_drawn(galileo, idealise(galileo), draw(whole, np.random.default_rng(5)), SHORT.noise).observations[0]
    among_all = observe(whole, SHORT.noise, np.random.default_rng(5)).observations[0]
    assert list(alone.tables) == ["E"]
    assert_same(replace(among_all, tables={"E": among_all.tables["E"]}), alone)


def test_what_is_kept_cannot_be_written_into():
    tracks = prepare_geometry(SHORT).tracks
    with pytest.raises(ValueError, match="read-only"):
        tracks.position[0] = 0
    with pytest.raises(ValueError, match="read-only"):
        tracks.ephemerides.m0[0] = 0


def test_a_single_epoch_is_enough():
    simulation = of_seed(replace(SHORT, duration=1.0), 1)
    assert len(simulation.observations[0].time) == 1


def test_milliseconds_of_clock_do_not_touch_the_truth_but_the_ranges():
    jumping = replace(SHORT, noise=NO_NOISE, clocks=(Clock(0.4e-3, 4e-5, jump=1e-3), Clock()))
    master = of_seed(jumping, 1).observations[0]
    points = gl.solve_points(master, of_seed(jumping, 1).ephemerides)
    steps = np.diff(points.clock[:, 0]) / 299_792_458.0
    assert (np.isclose(steps, 4e-5, atol=1e-10) | np.isclose(steps, 4e-5 - 1e-3, atol=1e-10)).all()
    assert (steps < 0).sum() == 1


def test_a_folder_that_cannot_be_is_said_in_words(tmp_path):
    (tmp_path / "file").write_text("not a folder")
    with pytest.raises(ValueError, match=r"cannot be written to .*file.*choose a folder"):
        write_simulation(tmp_path / "file", of_seed(replace(SHORT, duration=1.0), 1))


@pytest.mark.skipif(shutil.which("rnx2rtkp") is None, reason="RTKLIB's rnx2rtkp is not installed (Debian: apt install rtklib)")
def test_another_program_fixes_every_epoch_of_it_on_the_truth(tmp_path):
    """RTKLIB, kinematic, two frequencies, all systems: 2.5 mm are the noise asked for, seen through 36 satellites."""
    simulation = of_seed(replace(SHORT, duration=60.0), 1)
    write_simulation(tmp_path, simulation)
    base = simulation.truth.position_ecef[0]
    command = ["rnx2rtkp", "-p", "2", "-f", "2", "-m", "15", "-sys", "G,E,C,J", "-e", "-o", "out.pos", "-r", *(f"{x:.4f}" for x in base)]
    subprocess.run([*command, "rover.obs", "master.obs", "broadcast.nav"], cwd=tmp_path, check=True, capture_output=True)
    rows = [line.split() for line in (tmp_path / "out.pos").read_text().splitlines() if not line.startswith("%")]
    assert [row[5] for row in rows] == ["1"] * 60  # fixed
    baseline = (np.array([row[2:5] for row in rows], dtype=float) - base) @ enu_rotation(base).T
    assert np.abs(baseline - simulation.truth.baselines_enu[0]).max() < 15 * MM


def test_it_says_what_it_is():
    assert repr(of_seed(replace(SHORT, duration=2.0), 1)).startswith("Simulation: static-baseline, 2 receivers, 2 epochs, ")
