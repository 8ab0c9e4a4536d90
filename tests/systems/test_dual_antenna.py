"""Two-antenna attitude: its formulas against draws and published numbers, its results against a surveyed roof and simulated truth."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gnsslab.core.rotations import heading_pitch_of
from gnsslab.gnss.relative import Status, solve_moving
from gnsslab.simulate import LOW_COST, Slip, find_preset, observe, prepare_geometry
from gnsslab.systems.dual_antenna import angle_sigmas, dual_antenna_attitude, with_known_length

MM, CM = 1e-3, 1e-2  # [m]
DEG = np.pi / 180
WRONG = 5 * CM


def vector(length, heading, pitch):
    """Return the baseline (3,) ENU [m] of a length and two angles [rad]."""
    return length * np.array([np.cos(pitch) * np.sin(heading), np.cos(pitch) * np.cos(heading), np.sin(pitch)])


def angle_between(a, b):
    """Return a - b [rad] in (-pi, pi]."""
    return -((b - a + np.pi) % (2 * np.pi) - np.pi)


# Sigma of the angles.


def test_sigma_of_the_angles_as_worked_out_for_paper_a():
    """1.167 m at heading 50 and pitch 25 degrees, sigma 6, 9 and 16 mm: 0.428 and 0.728 degrees (drawn: 0.4277 and 0.7283)."""
    sigmas = angle_sigmas(vector(1.167, 50 * DEG, 25 * DEG), np.diag([6 * MM, 9 * MM, 16 * MM]) ** 2)
    assert np.degrees(sigmas) == pytest.approx([0.428, 0.728], abs=5e-4)


@given(
    heading=st.floats(0, 2 * np.pi), pitch=st.floats(-1.2, 1.2), length=st.floats(0.5, 50.0), seed=st.integers(0, 1000)
)  # fmt: skip
def test_sigma_of_the_angles_is_their_gradient_in_the_covariance(heading, pitch, length, seed):
    """Central differences of 1e-6 of the length along each axis in place of the formulas."""
    A = np.random.default_rng(seed).standard_normal((3, 3)) * CM
    Q, b, step = A @ A.T, vector(length, heading, pitch), 1e-6 * length
    ahead, behind = (heading_pitch_of(b + sign * step * np.eye(3)) for sign in (1, -1))
    gradients = angle_between(ahead.heading, behind.heading) / (2 * step), (ahead.pitch - behind.pitch) / (2 * step)
    for sigma, gradient in zip(angle_sigmas(b, Q), gradients, strict=True):
        assert sigma == pytest.approx(np.sqrt(gradient @ Q @ gradient), rel=1e-4, abs=1e-9)


def test_sigma_of_the_angles_is_the_scatter_of_drawn_baselines(rng):
    b, n = vector(2.0, 300 * DEG, -10 * DEG), 20_000
    A = rng.standard_normal((3, 3)) * 5 * MM
    drawn = heading_pitch_of(b + rng.standard_normal((n, 3)) @ A.T)
    sigma_heading, sigma_pitch = angle_sigmas(b, A @ A.T)
    scatter = np.std(angle_between(drawn.heading, 300 * DEG)), np.std(drawn.pitch)
    assert scatter == pytest.approx((sigma_heading, sigma_pitch), rel=4 / np.sqrt(2 * n))  # 4 sigma of a standard deviation


def test_sigma_of_the_angles_takes_stacks_and_missing_epochs():
    b = np.array([vector(1.0, 1.0, 0.1), [np.nan] * 3])
    heading, pitch = angle_sigmas(b, np.stack([np.eye(3) * MM**2] * 2))
    assert heading.shape == pitch.shape == (2,)
    assert np.isfinite([heading[0], pitch[0]]).all()
    assert np.isnan([heading[1], pitch[1]]).all()


def test_a_vertical_baseline_has_no_heading():
    heading, pitch = angle_sigmas(np.array([0.0, 0.0, 1.0]), np.eye(3) * MM**2)
    assert not np.isfinite(heading) or heading > np.pi
    assert not pitch < 1 * MM / 2


# The known length.


def test_known_length_leaves_447_mm_of_ten():
    """Paper A corrected: 10 mm along the baseline and a length of 5 mm make 1 / sqrt(1/100 + 1/25) = 4.47 mm; across nothing changes."""
    b, Q = with_known_length(np.array([0.0, 1.167, 0.0]), np.diag([10 * MM] * 3) ** 2, 1.167, 5 * MM)
    assert np.sqrt(Q.diagonal()) == pytest.approx([10 * MM, 4.472 * MM, 10 * MM], abs=0.001 * MM)
    assert b.tolist() == [0.0, 1.167, 0.0]


@given(heading=st.floats(0, 2 * np.pi), pitch=st.floats(-1.2, 1.2), excess=st.floats(-0.02, 0.02), seed=st.integers(0, 1000))
def test_known_length_is_a_measurement_like_any_other(heading, pitch, excess, seed):
    """Information adds up: Q^-1 grows by u u' / sigma^2, and the baseline moves to the weighted mean."""
    A, u = np.random.default_rng(seed).standard_normal((3, 3)) * CM, vector(1.0, heading, pitch)
    b, Q, sigma = (1.167 + excess) * u, A @ A.T + (2 * MM) ** 2 * np.eye(3), 5 * MM
    updated, Q_updated = with_known_length(b, Q, 1.167, sigma)
    information = np.linalg.inv(Q) + np.outer(u, u) / sigma**2
    np.testing.assert_allclose(Q_updated, np.linalg.inv(information), rtol=1e-6, atol=1e-12)
    np.testing.assert_allclose(updated, np.linalg.solve(information, np.linalg.inv(Q) @ b + u * 1.167 / sigma**2), rtol=0, atol=1e-9)


def test_known_length_is_not_believed_where_the_direction_is_not_known():
    """A float baseline of 30 cm sigma on 1 m: its direction is off by 17 degrees and more, so the length says nothing."""
    b, Q = np.array([[0.0, 1.2, 0.0], [0.0, 1.2, 0.0]]), np.stack([np.eye(3) * 0.3**2, np.eye(3) * 0.03**2])
    updated, Q_updated = with_known_length(b, Q, 1.0, 5 * MM)
    assert (updated[0] == b[0]).all()
    assert (Q_updated[0] == Q[0]).all()
    assert np.linalg.norm(updated[1]) == pytest.approx(1.0, abs=1 * CM)


def test_known_length_leaves_missing_epochs_and_arguments_alone():
    b, Q = np.full((1, 3), np.nan), np.full((1, 3, 3), np.nan)
    b.flags.writeable = Q.flags.writeable = False
    updated, Q_updated = with_known_length(b, Q, 1.0, 5 * MM)
    assert np.isnan(updated).all()
    assert np.isnan(Q_updated).all()


# Attitude.


def simulated(name, seed=3, **changes):
    preset = replace(find_preset(name), **changes)
    return observe(prepare_geometry(preset), preset.noise, np.random.default_rng(seed))


def attitude_of(simulation, **options):
    return dual_antenna_attitude(*simulation.observations[:2], simulation.ephemerides, **options)


@pytest.fixture(scope="module")
def roof():
    """A minute of the roof."""
    return simulated("static-baseline", duration=60.0, systems="GE")


def test_a_surveyed_roof(campaign):
    real = campaign("matrtklib-static")
    attitude = dual_antenna_attitude(real.base, real.rover, real.ephemerides)
    assert (attitude.status == Status.FIXED).all()
    assert np.degrees(np.median(attitude.heading)) == pytest.approx(193.03, abs=0.06)
    assert np.median(attitude.length) == pytest.approx(0.9902, abs=1 * MM)
    assert np.degrees(np.median(attitude.pitch)) == pytest.approx(0.56, abs=0.3)  # given with the set; 5 mm of height in 1 m
    assert (np.linalg.norm(attitude.baseline_enu - real.facts.baseline_enu, axis=1) < WRONG).all()
    scatter = np.std(attitude.heading), np.std(attitude.pitch)
    assert np.array(scatter) == pytest.approx((np.median(attitude.sigma_heading), np.median(attitude.sigma_pitch)), rel=0.6)


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("static-baseline", {"duration": 100.0}),
        ("paper-a-turntable", {"duration": 140.0, "events": (), "noise": LOW_COST}),  # with its own noise 5 cm of error need no wrong integer
        ("ship-heading", {"duration": 150.0}),
    ],
    ids=["roof", "turntable", "ship"],
)
@pytest.mark.parametrize("known", [False, True], ids=["", "known length"])
def test_simulated_attitude_is_recovered_within_its_sigma(name, changes, known):
    simulation = simulated(name, **changes)
    length = float(np.linalg.norm(simulation.truth.baselines_enu[0, 0])) if known else None
    attitude = attitude_of(simulation, length=length)
    is_fixed = attitude.status == Status.FIXED
    assert is_fixed.mean() > 0.8
    assert (np.linalg.norm(attitude.baseline_enu - simulation.truth.baselines_enu[0], axis=1)[is_fixed] < WRONG).all(), "a wrong fix"
    off_heading = angle_between(attitude.heading, simulation.truth.heading) / attitude.sigma_heading
    off_pitch = (attitude.pitch - simulation.truth.pitch) / attitude.sigma_pitch
    for off in (off_heading[is_fixed], off_pitch[is_fixed]):
        assert (np.abs(off) < 4).mean() >= 0.99  # one in 16 000 if independent; multipath makes neighbours alike
        assert np.std(off) > 0.3, "sigma three times too large is no sigma either"


def test_low_cost_receivers_survive_a_loss_of_all_locks():
    simulation = simulated("paper-a-static", duration=120.0, events=(Slip(60, antennas=(1,)),), noise=LOW_COST)
    attitude = attitude_of(simulation, frequencies=1, length=1.167)
    is_fixed = attitude.status == Status.FIXED
    assert is_fixed[:60].any()
    assert is_fixed[-15:].all()
    off = (attitude.baseline_enu - simulation.truth.baselines_enu[0])[is_fixed]
    assert (np.linalg.norm(off[:, :2], axis=1) < WRONG).all()
    assert (np.abs(off[:, 2]) < 4 * 2.5 * CM).all()  # the paper's multipath: sigma of the height is 2.5 cm with the right integers


def test_attitude_is_the_moving_baselines(roof):
    attitude, relative = attitude_of(roof), solve_moving(*roof.observations, roof.ephemerides)
    np.testing.assert_array_equal(attitude.baseline_enu, relative.baseline_enu)
    np.testing.assert_array_equal(attitude.status, relative.status)
    heading, pitch = heading_pitch_of(relative.baseline_enu)
    np.testing.assert_allclose(attitude.heading, heading)
    np.testing.assert_allclose(attitude.pitch, pitch)
    np.testing.assert_allclose(attitude.length, np.linalg.norm(relative.baseline_enu, axis=1))


def test_the_mount_heading_is_taken_off_and_the_circle_closes(roof):
    plain = attitude_of(roof).heading
    for mount in (90 * DEG, -100 * DEG, 35.0 * DEG, 725 * DEG):
        turned = attitude_of(roof, mount_heading=mount).heading
        assert (turned >= 0).all()
        assert (turned < 2 * np.pi).all()
        np.testing.assert_allclose(angle_between(turned, plain - mount), 0, atol=1e-12)


def test_exchanged_antennas_point_the_other_way(roof):
    there, back = attitude_of(roof), dual_antenna_attitude(*roof.observations[::-1], roof.ephemerides)
    both = (there.status == Status.FIXED) & (back.status == Status.FIXED)
    assert both.mean() > 0.9
    np.testing.assert_allclose(angle_between(back.heading, there.heading + np.pi)[both], 0, atol=0.01 * DEG)
    np.testing.assert_allclose(back.pitch[both], -there.pitch[both], atol=0.01 * DEG)


@pytest.mark.parametrize("length", [0.0, -1.0, float("nan")])
def test_a_length_that_is_none_is_refused(roof, length):
    with pytest.raises(ValueError, match="the length between the antennas must be more than 0 m"):
        attitude_of(roof, length=length)


@pytest.mark.parametrize("length_sigma", [0.0, -0.005, float("nan")])
def test_a_length_sigma_that_is_none_is_refused(roof, length_sigma):
    with pytest.raises(ValueError, match="the sigma of the length must be more than 0 m"):
        attitude_of(roof, length=1.167, length_sigma=length_sigma)


def test_it_reads_aloud(roof):
    attitude = attitude_of(roof)
    fixed = int((attitude.status == Status.FIXED).sum())
    assert repr(attitude).startswith(f"Attitude: 60 epochs, {fixed} fixed, {60 - fixed} float; sigma heading 0.")
    assert repr(attitude).endswith(" deg")
    none = replace(attitude, status=np.zeros(60, dtype=np.int8))
    assert repr(none) == "Attitude: 60 epochs, none solved"
