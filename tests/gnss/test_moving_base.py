"""Moving base: two receivers that measure at different instants, by simulated truth and by the geometry of the error."""

from dataclasses import replace

import numpy as np
import pytest
from small_observations import short_preset

from gnsslab.core.rotations import heading_pitch_of
from gnsslab.gnss.blocks import run_blocks
from gnsslab.gnss.frames import enu_rotation
from gnsslab.gnss.moving_base import SIGMA_UNKNOWN, at_rover_instants, mean_velocity, shift_covariance
from gnsslab.gnss.preparation import Settings, path_of, prepare, prepare_moving
from gnsslab.gnss.relative import Status, solve_moving, solve_relative
from gnsslab.gnss.selection import keep_epochs
from gnsslab.simulate import NO_NOISE, Car, Clock, Gap, Ship, Turntable, instants, simulate, true_motion

MM, DEG, MICROMETRE, NANOSECOND = 1e-3, np.radians(1.0), 1e-6, 1e-9
ACROSS = ((-0.5835, 0.0, 1.5), (0.5835, 0.0, 1.5))  # 1.167 m, at right angles to the way
STRAIGHT = Ship(speed=20.0, turn_deg_s=0.0, roll_deg=0.0, pitch_deg=0.0, heave=0.0)
SETTINGS = Settings(systems="GE")


def preset_of(offset=0.0, trajectory=STRAIGHT, **changes):
    """Return half a minute of a vehicle with its antennas across the way; the rover's clock is early, so it measures later by `offset` [s]."""
    clocks = (Clock(), Clock(offset=-offset))
    return short_preset(**{"systems": "GE", "trajectory": trajectory, "antennas": ACROSS, "clocks": clocks, "duration": 30.0, **changes})


def prepared_of(preset, settings=SETTINGS):
    simulation = simulate(preset, np.random.default_rng(3))
    return prepare_moving(*simulation.observations, simulation.ephemerides, settings)


def fixed_baselines(prepared, settings=SETTINGS):
    """Return the fixed baselines (T, 3) ECEF [m]; the first second is the filter's own."""
    return run_blocks(prepared.model, path_of(prepared, settings)).outcome.baseline_fixed[1:]


def true_baselines(preset):
    """Return the true baselines (T, 3) ENU [m] at the instants when the rover measured."""
    return true_motion(preset, instants(preset, 1)).baselines_enu[0]


@pytest.mark.parametrize(
    "clocks",
    [
        (Clock(), Clock()),
        (Clock(offset=3e-4), Clock(offset=-2e-4)),
        (Clock(offset=0.5), Clock(offset=-0.5)),
        (Clock(drift=4e-5, jump=1e-3), Clock(drift=-7e-5, jump=1e-3)),
    ],
    ids=["none", "half a millisecond", "a second", "clocks that jump"],
)
def test_the_time_offset_is_that_of_the_instants(clocks):
    preset = preset_of(clocks=clocks, trajectory=Car())
    offset = instants(preset, 1) - instants(preset, 0)
    np.testing.assert_allclose(prepared_of(preset).time_offset, offset, rtol=0, atol=30 * NANOSECOND)  # 9 m: codes and biases between systems


def test_an_older_epoch_of_the_master_is_earlier_by_its_age():
    preset = preset_of(events=(Gap(10, 11, antennas=(0,)),))
    prepared = prepared_of(preset, replace(SETTINGS, longest_age=2.0))
    age = np.zeros(30)
    age[[10, 11]] = 1.0, 2.0
    np.testing.assert_allclose(prepared.time_offset, age, rtol=0, atol=30 * NANOSECOND)
    assert len(prepared_of(preset).time_offset) == 28, "without an age both have no partner"


def test_a_known_base_stands_still_and_nothing_moves():
    preset = preset_of(offset=0.3)
    simulation = simulate(preset, np.random.default_rng(3))
    prepared = prepare(*simulation.observations, simulation.truth.position_ecef, simulation.ephemerides, SETTINGS)
    assert not prepared.velocity_master.any()
    moved = at_rover_instants(prepared)
    np.testing.assert_array_equal(moved.model.near, prepared.model.near)
    assert not shift_covariance(prepared).any()


@pytest.mark.parametrize("offset", [0.0, 1e-3, 0.02, 0.5, 1.0, -1.0])
def test_the_heading_is_off_by_the_way_of_the_master_over_the_length_without_the_correction_and_right_with_it(offset):
    """20 m/s across a baseline of 1.167 m: atan(v dt / l) is 0.98 degrees for a millisecond. Noise is left out: rounding to 1 mm is not."""
    preset = preset_of(offset, noise=NO_NOISE)
    prepared = prepared_of(preset)
    R_ne = enu_rotation(prepared.master_ecef[1:])
    measured, corrected = (np.matvec(R_ne, fixed_baselines(one)) for one in (prepared, at_rover_instants(prepared)))
    true_heading, _ = heading_pitch_of(true_baselines(preset)[1:])
    error = wrapped(heading_pitch_of(measured).heading - true_heading)
    np.testing.assert_allclose(error, -np.arctan(20.0 * offset / 1.167), rtol=0, atol=0.1 * DEG)
    np.testing.assert_allclose(corrected, true_baselines(preset)[1:], rtol=0, atol=2 * MM + 2 * MM * abs(offset))  # Doppler rounded to 0.2 mm/s


def wrapped(angle):
    return (angle + np.pi) % (2 * np.pi) - np.pi


@pytest.mark.parametrize("trajectory", [Car(height=6.0, speed=15.0), Turntable(still=5.0), Ship()], ids=["car", "turntable", "ship"])
@pytest.mark.parametrize("offset", [1e-3, 0.5, -1.0])
def test_baselines_of_moving_bodies_are_right_within_their_sigma(trajectory, offset):
    preset = preset_of(offset, trajectory, duration=60.0)
    simulation = simulate(preset, np.random.default_rng(4))
    relative = solve_moving(*simulation.observations, simulation.ephemerides, systems="GE")
    is_fixed = relative.status == Status.FIXED
    assert is_fixed.mean() > 0.9
    error = (relative.baseline_enu - true_baselines(preset))[is_fixed]
    sigma = np.sqrt(np.diagonal(relative.Q_enu[is_fixed], axis1=1, axis2=2))
    assert (np.abs(error) < 5 * sigma).all()
    assert 0.3 < np.sqrt(np.mean((error / sigma) ** 2)) < 1.5
    assert np.median(sigma) < 10 * MM + 50 * MM * abs(offset)


def test_the_rover_stays_where_it_is():
    """Its position is the master's at the rover's instant plus the baseline at that instant: of the velocity nothing is left in the sum."""
    prepared = prepared_of(preset_of(0.5))
    moved = at_rover_instants(prepared)
    assert np.abs(moved.master_ecef - prepared.master_ecef).max() > 5.0
    np.testing.assert_allclose(
        moved.master_ecef[1:] + fixed_baselines(moved), prepared.master_ecef[1:] + fixed_baselines(prepared), rtol=0, atol=10 * MICROMETRE
    )


def test_a_master_moved_before_the_residuals_are_formed_takes_the_rover_along():
    """RTKLIB's way: the base's position is brought to the rover's time first. Of 10 m a thirty-thousandth is left, and no more."""
    simulation = simulate(preset_of(0.5), np.random.default_rng(3))
    place = simulation.truth.position_ecef
    way = 10.0 * np.array([0.6, 0.0, 0.8])
    here, ahead = (
        fixed_baselines(prepare(*simulation.observations, position, simulation.ephemerides, SETTINGS)) for position in (place, place + way)
    )
    np.testing.assert_allclose(here, ahead, rtol=0, atol=0.5 * MM)  # Earth turns while signals travel, which the linear model leaves out


def test_a_steady_acceleration_is_right_and_the_ends_too():
    """x = 2 t^2, v = 4 t: from t to t + d the way is 4 t d + 2 d^2."""
    t, d = np.arange(5.0), np.array([0.5, -0.5, 1.0, 0.25, 0.5])
    time = np.datetime64("2024-01-01", "ns") + t.astype("timedelta64[s]")
    velocity = np.outer(4 * t, [1.0, 0.0, -1.0])
    mean = mean_velocity(time, velocity, np.arange(5), d)
    np.testing.assert_allclose(mean * d[:, None], np.outer(4 * t * d + 2 * d**2, [1.0, 0.0, -1.0]), atol=1e-12)


def test_an_epoch_without_velocity_has_none_and_its_neighbours_lose_nothing():
    time = np.datetime64("2024-01-01", "ns") + np.arange(3).astype("timedelta64[s]")
    velocity = np.array([[4.0, 0, 0], [np.nan] * 3, [8.0, 0, 0]])
    mean = mean_velocity(time, velocity, np.array([0, 1, 2, 2]), np.array([0.5, 0.5, 0.5, np.nan]))
    assert mean[:, 0].tolist() == pytest.approx([4.5, np.nan, 8.5, 8.0], nan_ok=True)
    assert np.isnan(mean_velocity(time, velocity * np.nan, np.array([0]), np.array([0.1]))).all()
    assert mean_velocity(time[:1], velocity[:1], np.array([0]), np.array([0.1]))[0].tolist() == [4.0, 0.0, 0.0]


def test_an_unknown_velocity_shifts_nothing_and_says_so_in_the_sigma():
    preset = preset_of(1e-3)
    simulation = simulate(preset, np.random.default_rng(3))
    bare = [_without_doppler(one) for one in simulation.observations]
    prepared = prepare_moving(*bare, simulation.ephemerides, SETTINGS)
    assert np.isnan(prepared.velocity_master).all()
    np.testing.assert_array_equal(at_rover_instants(prepared).model.near, prepared.model.near)
    expected = (SIGMA_UNKNOWN * 1e-3) ** 2 * np.eye(3)  # 3 cm
    np.testing.assert_allclose(shift_covariance(prepared), np.tile(expected, (30, 1, 1)), rtol=1e-3, atol=1e-9)
    relative = solve_moving(*bare, simulation.ephemerides, systems="GE")
    error = (relative.baseline_enu - true_baselines(preset))[relative.status == Status.FIXED]
    assert np.linalg.norm(error, axis=1) == pytest.approx(20 * MM, abs=5 * MM)  # 20 m/s times a millisecond, within one sigma


def _without_doppler(observations):
    def bare(table):
        keep = [i for i, code in enumerate(table.codes) if code[0] != "D"]
        return replace(
            table,
            codes=tuple(table.codes[i] for i in keep),
            **{name: getattr(table, name)[:, keep] for name in ("value", "lli", "ssi")},
        )

    return replace(observations, tables={system: bare(table) for system, table in observations.tables.items()})


def test_the_covariance_is_that_of_the_velocity_times_the_offset():
    prepared = prepared_of(preset_of(0.5))
    R_ne = enu_rotation(prepared.master_ecef)
    for t in (0, 17):
        np.testing.assert_allclose(shift_covariance(prepared)[t], 0.25 * R_ne[t] @ prepared.Q_velocity[t] @ R_ne[t].T, rtol=1e-6)


# Older epochs of the master.


def test_a_rover_at_two_hertz_is_served_by_a_master_at_one(campaign):
    """Every second epoch of the master is taken away: the rover's others are served by one a second old, at rest as good as any."""
    real = campaign("matrtklib-static")
    slower = keep_epochs(real.base, np.arange(len(real.base.time)) % 2 == 0)
    options = {"base_position": real.facts.base_position}
    alone, served = (solve_relative(slower, real.rover, real.ephemerides, longest_age=age, **options) for age in (0.0, 1.0))
    step = np.median(np.diff(real.rover.time)) / np.timedelta64(1, "s")
    assert step == 1.0
    assert np.isnan(alone.baseline_enu[1::2]).all()
    assert (served.status == Status.FIXED).mean() > 0.98
    off = np.linalg.norm(served.baseline_enu - real.facts.baseline_enu, axis=1)[served.status == Status.FIXED]
    assert (off < 50 * MM).all()


def test_a_missing_epoch_of_the_master_is_bridged_on_the_turntable():
    """Paper A's epoch 218: the master has been missing for a second, in which it moved 6 cm, 3 degrees of heading."""
    preset = preset_of(trajectory=Turntable(still=0.0), antennas=((0.0, -0.5835, 0.0), (0.0, 0.5835, 0.0)), events=(Gap(20, 20, antennas=(0,)),))
    simulation = simulate(preset, np.random.default_rng(2))
    relative = solve_moving(*simulation.observations, simulation.ephemerides, systems="GE", longest_age=1.0)
    assert relative.status[20] == Status.FIXED
    error = relative.baseline_enu[20] - true_baselines(preset)[20]
    sigma = np.sqrt(relative.Q_enu[20].diagonal())
    assert (np.abs(error) < 4 * sigma).all()
    assert (sigma[:2] < 60 * MM).all()
    settings = replace(SETTINGS, longest_age=1.0)
    prepared = prepare_moving(*simulation.observations, simulation.ephemerides, settings)
    measured = np.matvec(enu_rotation(prepared.master_ecef[1:]), fixed_baselines(prepared, settings))[19] - true_baselines(preset)[20]
    assert np.linalg.norm(measured) == pytest.approx(0.0611, abs=10 * MM)


def test_nothing_given_is_changed():
    prepared = prepared_of(preset_of(0.5))
    for array in (prepared.model.near, prepared.master_ecef, prepared.velocity_master, prepared.Q_velocity, prepared.time_offset):
        array.flags.writeable = False
    at_rover_instants(prepared)
    shift_covariance(prepared)
