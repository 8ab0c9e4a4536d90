import numpy as np
import pytest

from gnsslab.core.rotations import heading_pitch_of, rotation_from_heading_pitch_roll
from gnsslab.simulate.trajectories import GRAVITY, Car, Hop, Ship, Static, Turntable, velocity

DEG = np.pi / 180
EVERY = (Static(30.0, 5.0, -3.0), Turntable(), Car(), Ship(), Hop())


@pytest.mark.parametrize("trajectory", EVERY, ids=lambda trajectory: type(trajectory).__name__)
def test_shapes_and_no_jumps(trajectory):
    t = np.arange(0, 200, 0.01)
    pose = trajectory.at(t)
    assert pose.position_enu.shape == (len(t), 3)
    assert pose.heading.shape == pose.pitch.shape == pose.roll.shape == t.shape
    assert np.abs(np.diff(pose.position_enu, axis=0)).max() < 0.2  # [m] in 10 ms: 20 m/s
    assert all(np.abs(np.diff(angle)).max() < 0.2 * DEG for angle in pose[1:])  # 20 deg/s


@pytest.mark.parametrize("trajectory", EVERY, ids=lambda trajectory: type(trajectory).__name__)
def test_velocity_is_smooth_so_that_range_rates_are(trajectory):
    t = np.arange(0, 200, 0.05)
    arm = np.array([0.3, 1.0, 0.5])

    def antenna(seconds):
        pose = trajectory.at(seconds)
        return pose.position_enu + rotation_from_heading_pitch_roll(pose.heading, pose.pitch, pose.roll) @ arm

    assert np.abs(np.diff(velocity(antenna, t), axis=0)).max() < 15 * 0.05  # [m/s]: no acceleration beyond 15 m/s^2


@pytest.mark.parametrize("trajectory", EVERY, ids=lambda trajectory: type(trajectory).__name__)
def test_any_instant_can_be_asked_for_alone(trajectory):
    t = np.array([3.0, 77.7, 120.25])
    together = trajectory.at(t).position_enu
    alone = np.concatenate([trajectory.at(t[k : k + 1]).position_enu for k in range(3)])
    assert np.abs(together - alone).max() < 1e-9  # [m]


@pytest.mark.parametrize("trajectory", [Car(), Ship(heave=0.0)], ids=["Car", "Ship"])
def test_it_faces_where_it_goes(trajectory):
    t = np.linspace(0, 200, 400)
    heading, pitch = heading_pitch_of(velocity(lambda s: trajectory.at(s).position_enu, t))
    pose = trajectory.at(t)
    assert np.abs(np.angle(np.exp(1j * (heading - pose.heading)))).max() < 1e-6
    if isinstance(trajectory, Car):
        assert np.abs(pitch - pose.pitch).max() < 1e-6


def test_the_turntable_stands_then_turns_as_told():
    pose = Turntable(still=50.0, rate_deg_s=6.0, ramp=2.0, heading_deg=35.0).at(np.array([0.0, 50.0, 52.0, 60.0, 61.0]))
    assert np.allclose(pose.heading[:2], 35 * DEG)
    assert pose.heading[2] == pytest.approx((35 + 6) * DEG)  # half of the rate, on the mean, for two seconds
    assert pose.heading[4] - pose.heading[3] == pytest.approx(6 * DEG)
    assert not pose.position_enu.any()


def test_the_car_leans_out_of_the_turn_and_the_drone_into_it():
    hop = Hop()
    middle = np.array([hop.duration / 2])
    pose = hop.at(middle)
    v = np.linalg.norm(velocity(lambda s: hop.at(s).position_enu, middle))
    assert pose.roll[0] == pytest.approx(np.arctan(v**2 / (hop.radius * GRAVITY)), abs=1e-6)  # a right turn: right side down
    car = Car()
    t = np.linspace(0, 50, 500)
    turning = np.gradient(car.at(t).heading, t)
    assert np.corrcoef(turning, car.at(t).roll)[0, 1] < -0.9


def test_the_hop_begins_and_ends_on_the_ground_at_one_place():
    hop = Hop(height=40.0)
    pose = hop.at(np.array([0.0, hop.duration / 2, hop.duration]))
    assert np.abs(pose.position_enu[[0, 2]]).max() < 1e-9
    assert pose.position_enu[1, 2] == pytest.approx(40.0)
    assert np.abs(pose.position_enu[1, :2]).max() == pytest.approx(2 * hop.radius)
    assert pose.heading[2] == pytest.approx(2 * np.pi)


def test_the_ships_arc_has_its_speed_and_may_be_straight():
    t = np.linspace(0, 100, 50)
    for turn in (0.0, 0.5, -3.0):
        ship = Ship(speed=6.0, turn_deg_s=turn, heave=0.0)
        speed = np.linalg.norm(velocity(lambda s, ship=ship: ship.at(s).position_enu, t), axis=-1)
        assert np.abs(speed - 6.0).max() < 1e-6
