"""Formulas as printed in paper A: their published errors, and where they agree with the mended ones."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gnsslab.core.rotations import heading_pitch_of, rotation_from_heading_pitch_roll
from gnsslab.systems.dual_antenna import angle_sigmas
from gnsslab.systems.printed_attitude import heading_as_printed, pitch_as_printed, sigma_heading_as_printed, sigma_pitch_as_printed

MM = 1e-3  # [m]
DEG = np.pi / 180
CASE = {"heading": 50 * DEG, "pitch": 25 * DEG, "length": 1.167, "sigma_enu": np.array([6, 9, 16]) * MM}


def beam(heading, pitch, length=1.0):
    """Return the baseline (..., 3) ENU of two angles [rad]."""
    return length * rotation_from_heading_pitch_roll(heading, pitch)[..., :, 1]


def test_heading_of_120_degrees_comes_out_as_minus_60():
    assert np.degrees(heading_as_printed(beam(120 * DEG, 0.3))) == pytest.approx(-60)


@given(heading=st.floats(0.0, 360.0), pitch=st.floats(-80, 80))
def test_heading_is_right_or_half_a_turn_off(heading, pitch):
    off = np.degrees(heading_as_printed(beam(heading * DEG, pitch * DEG))) - heading
    halves = off / 180
    assert halves == pytest.approx(round(halves), abs=1e-9)
    if abs((heading + 180) % 360 - 180) < 89.99:
        assert round(halves) % 2 == 0
    elif abs((heading + 180) % 360 - 180) > 90.01:
        assert round(halves) % 2 == 1


@pytest.mark.parametrize(
    ("pitch_deg", "error_deg", "digits"),
    [(2, 0.0012, 5e-5), (5, 0.019, 5e-4), (10, 0.156, 5e-4), (20, 1.344, 5e-4), (30, 5.264, 5e-4), (40, 17.05, 5e-3)],
)
def test_pitch_errs_as_worked_out(pitch_deg, error_deg, digits):
    for sign in (1, -1):
        printed = np.degrees(pitch_as_printed(beam(1.0, sign * pitch_deg * DEG, 2.0)))
        assert sign * printed - pitch_deg == pytest.approx(error_deg, abs=digits)


@given(st.floats(-0.2, 0.2), st.floats(0, 6.28))
def test_pitch_errs_by_half_its_cube(pitch, heading):
    """arcsin(tan x) = x + x^3 / 2 + 3 x^5 / 8 + ..."""
    error = pitch_as_printed(beam(heading, pitch)) - pitch
    assert error == pytest.approx(pitch**3 / 2, abs=abs(pitch) ** 5 + 1e-12)


@given(st.floats(45.01, 89.9))
def test_pitch_has_no_answer_above_45_degrees(pitch_deg):
    assert np.isnan(pitch_as_printed(beam(1.0, np.array([-pitch_deg, pitch_deg]) * DEG))).all()


def test_sigma_of_heading_as_worked_out_for_the_paper():
    """3.24 degrees where drawn beams scatter by 0.43."""
    assert np.degrees(sigma_heading_as_printed(**CASE)) == pytest.approx(3.24, abs=5e-3)


def test_sigma_of_heading_changes_with_the_unit():
    """In millimetres the same formula says sqrt(0.4132 * 36 + 0.5868 * 9) / 1167 * 0.9063 = 0.20 degrees: no square, no meaning."""
    in_mm = sigma_heading_as_printed(**CASE | {"length": 1167.0, "sigma_enu": np.array([6, 9, 16])})
    assert np.degrees(in_mm) == pytest.approx(0.20, abs=5e-3)


def test_sigma_of_pitch_by_hand():
    """sqrt(0.8214 * 256 + 0.1786 * (36 + 0.5868 * 81)) = 15.0 mm on 1.167 m: 0.737 degrees.

    With the square of the last term left out as in (33) it would be 1.67 degrees; the scan of the paper has the square here.
    """
    assert np.degrees(sigma_pitch_as_printed(**CASE)) == pytest.approx(np.degrees(15.006e-3 / 1.167), abs=1e-4)
    unsquared = (np.cos(25 * DEG) * 0.016) ** 2 + np.sin(25 * DEG) ** 2 * (0.006**2 + np.sin(50 * DEG) ** 2 * 0.009)
    assert np.degrees(np.sqrt(unsquared) / 1.167) == pytest.approx(1.67, abs=5e-3)


@given(pitch=st.floats(-0.7, 0.7), sigma_e=st.floats(0.001, 0.02), sigma_u=st.floats(0.001, 0.04))
def test_printed_sigmas_are_right_where_the_slips_do_not_show(pitch, sigma_e, sigma_u):
    """Heading: a level beam to the north. Pitch: a level beam, or one to the north with equal sigmas."""
    sigma = np.array([sigma_e, 0.005, sigma_u])
    level = angle_sigmas(beam(0.0, 0.0, 2.0), np.diag(sigma**2))
    assert sigma_heading_as_printed(0.0, 0.0, 2.0, sigma) == pytest.approx(level[0])
    assert sigma_pitch_as_printed(1.0, 0.0, 2.0, sigma) == pytest.approx(angle_sigmas(beam(1.0, 0.0, 2.0), np.diag(sigma**2))[1])
    alike = np.array([0.005, 0.005, sigma_u])
    right = angle_sigmas(beam(0.0, pitch, 2.0), np.diag(alike**2))[1]
    assert sigma_pitch_as_printed(0.0, pitch, 2.0, alike) == pytest.approx(right)  # equal sigmas hide the swap, psi = 0 the lost cosine


def test_stacks_and_read_only_arrays_serve():
    b = beam(np.array([0.1, 2.0]), np.array([0.2, 0.3]))
    b.setflags(write=False)
    assert heading_as_printed(b).shape == pitch_as_printed(b).shape == (2,)
    sigmas = np.full((2, 3), 0.01)
    sigmas.setflags(write=False)
    assert sigma_heading_as_printed(*heading_pitch_of(b), 1.0, sigmas).shape == (2,)
    assert sigma_pitch_as_printed(*heading_pitch_of(b), 1.0, sigmas).shape == (2,)
