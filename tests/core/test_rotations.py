"""Rotations: published convention (papers.md, section 0), SciPy as the second implementation, properties."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from gnsslab.core.rotations import heading_pitch_of, heading_pitch_roll, rotation_from_heading_pitch_roll, within_half_turn

ROUNDING = 1e-13
DEG = np.pi / 180

headings = st.floats(0.0, 2 * np.pi, exclude_max=True)
pitches = st.floats(-89.0 * DEG, 89.0 * DEG)
rolls = st.floats(-179.0 * DEG, 179.0 * DEG)


def passive_product(psi, theta, phi):
    """R_y(phi) R_x(theta) R_z(-psi) with the elementary matrices written out: C_bn, whose transpose is R_nb."""
    R_x = np.array([[1, 0, 0], [0, np.cos(theta), np.sin(theta)], [0, -np.sin(theta), np.cos(theta)]])
    R_y = np.array([[np.cos(phi), 0, -np.sin(phi)], [0, 1, 0], [np.sin(phi), 0, np.cos(phi)]])
    R_z = np.array([[np.cos(psi), -np.sin(psi), 0], [np.sin(psi), np.cos(psi), 0], [0, 0, 1]])
    return R_y @ R_x @ R_z


@given(headings, pitches, rolls)
def test_matrix_is_the_product_of_the_elementary_rotations(psi, theta, phi):
    R_nb = rotation_from_heading_pitch_roll(psi, theta, phi)
    assert np.allclose(R_nb, passive_product(psi, theta, phi).T, atol=ROUNDING)


@given(headings, pitches, rolls)
def test_matrix_equals_scipy(psi, theta, phi):
    expected = Rotation.from_euler("ZXY", [-psi, theta, phi]).as_matrix()  # intrinsic: heading, then pitch, then roll
    assert np.allclose(rotation_from_heading_pitch_roll(psi, theta, phi), expected, atol=ROUNDING)


@given(headings, pitches, rolls)
def test_angles_come_back(psi, theta, phi):
    back = heading_pitch_roll(rotation_from_heading_pitch_roll(psi, theta, phi))
    assert np.allclose(np.exp(1j * np.array(back)), np.exp(1j * np.array([psi, theta, phi])), atol=1e-12)


@given(headings, st.sampled_from([-90.0 * DEG, 90.0 * DEG]), rolls)
def test_vertical_nose_still_gives_the_same_matrix_back(psi, theta, phi):
    R_nb = rotation_from_heading_pitch_roll(psi, theta, phi)
    angles = heading_pitch_roll(R_nb)
    assert angles.roll == 0.0
    assert np.allclose(rotation_from_heading_pitch_roll(*angles), R_nb, atol=1e-9)


@given(headings, pitches, rolls)
def test_forward_axis_has_the_heading_and_pitch_of_the_body(psi, theta, phi):
    R_nb = rotation_from_heading_pitch_roll(psi, theta, phi)
    direction = heading_pitch_of(1.167 * R_nb @ [0.0, 1.0, 0.0])
    assert np.allclose(np.exp(1j * np.array(direction)), np.exp(1j * np.array([psi, theta])), atol=1e-12)


def test_signs_by_hand():
    assert np.allclose(rotation_from_heading_pitch_roll(90 * DEG) @ [0, 1, 0], [1, 0, 0])  # heading 90 deg: east
    assert np.allclose(rotation_from_heading_pitch_roll(0, 30 * DEG) @ [0, 2, 0], [0, np.sqrt(3), 1])  # nose up
    assert (rotation_from_heading_pitch_roll(0, 0, 10 * DEG) @ [1, 0, 0])[2] < 0  # right side down


def test_heading_120_degrees_keeps_its_quadrant():
    e, n = np.sin(120 * DEG), np.cos(120 * DEG)  # paper A (5) prints arctan(e / n), which is -60 degrees here
    assert np.isclose(heading_pitch_of([e, n, 0.0]).heading, 120 * DEG)


def test_stacks_broadcast_and_inputs_stay():
    psi = np.linspace(0.0, 6.0, 7)
    psi.flags.writeable = False
    R_nb = rotation_from_heading_pitch_roll(psi, 0.1)
    assert R_nb.shape == (7, 3, 3)
    assert np.allclose(np.linalg.det(R_nb), 1.0)
    assert np.allclose(heading_pitch_roll(R_nb).heading, psi)


def test_heading_never_reaches_the_full_circle():
    assert heading_pitch_of([-1e-20, 1.0, 0.0]).heading == 0.0


def test_no_vector_has_no_direction():
    direction = heading_pitch_of([[0.0, 0.0, 0.0], [np.nan, 1.0, 1.0], [0.0, 0.0, 2.0]])
    assert np.array_equal(np.isnan(direction.heading), [True, True, False])
    assert np.isclose(direction.pitch[2], 90 * DEG)


def test_wrong_shapes_are_explained():
    with pytest.raises(ValueError, match=r"vector_enu must have shape \(\.\.\., 3\); it has shape \(2,\)"):
        heading_pitch_of([1.0, 2.0])
    with pytest.raises(ValueError, match=r"R_nb must have shape \(\.\.\., 3, 3\)"):
        heading_pitch_roll(np.eye(2))


def test_angles_within_half_a_turn():
    np.testing.assert_allclose(within_half_turn(np.radians([190.0, -190.0, 10.0, 720.0])), np.radians([-170.0, 170.0, 10.0, 0.0]), atol=1e-12)
    assert within_half_turn(np.pi) == -np.pi
