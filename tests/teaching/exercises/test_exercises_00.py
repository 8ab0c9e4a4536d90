"""Exercises of lesson 00, worked out by a second route."""

import math

import numpy as np
import pytest

from gnsslab.core.rotations import heading_pitch_of
from gnsslab.systems.dual_antenna import angle_sigmas
from gnsslab.teaching.exercises.lesson_00 import PREDICTION, QUESTIONS

ASKED = {question.name: question for question in QUESTIONS}
DRAWS = 200_000
SIGMA_OF_SIGMA = 1 / math.sqrt(2 * DRAWS)  # relative, of a standard deviation counted from so many draws


def answer(name, **also):
    """Return what a second route must give: the answer, to the digits written down."""
    return pytest.approx(ASKED[name].answer, rel=2e-5, **also)


def mistakes(name):
    """Return the values of the usual mistakes of a question."""
    return [mistake.value for mistake in ASKED[name].mistakes]


def tilted(heading, pitch, length=1.0):
    """Return a baseline (3,) ENU of two angles [rad]."""
    return length * np.array([math.cos(pitch) * math.sin(heading), math.cos(pitch) * math.cos(heading), math.sin(pitch)])


def test_heading_of_a_beam_from_the_library_and_from_a_sketch():
    assert np.degrees(heading_pitch_of([0.70, -0.40, 0.0]).heading) == answer("heading-of-a-beam")
    assert 90 + math.degrees(math.atan(0.40 / 0.70)) == answer("heading-of-a-beam")


def test_mistakes_of_the_heading():
    radians = math.atan2(0.70, -0.40)
    slips = [math.atan(0.70 / -0.40), math.atan2(0.70, 0.40), math.atan2(-0.40, 0.70), -radians]
    assert mistakes("heading-of-a-beam") == pytest.approx([*map(math.degrees, slips), radians], rel=1e-4)


def test_sigma_of_heading_is_the_scatter_of_drawn_ends(rng):
    drawn = np.array([0.0, 1.2, 0.0]) + rng.standard_normal((DRAWS, 3)) * [0.003, 0, 0]
    heading = heading_pitch_of(drawn).heading
    scatter = np.degrees(np.std((heading + np.pi) % (2 * np.pi)))
    assert scatter == pytest.approx(ASKED["sigma-of-heading"].answer, rel=4 * SIGMA_OF_SIGMA)
    assert np.degrees(angle_sigmas(np.array([0.0, 1.2, 0.0]), np.diag([0.003, 0, 0]) ** 2)[0]) == answer("sigma-of-heading")


def test_mistakes_of_the_sigma_of_heading():
    assert mistakes("sigma-of-heading") == pytest.approx([0.003 / 1.2, 3 / 1.2, math.degrees(3 / 1.2)], rel=1e-5)


def test_length_for_a_sigma_gives_that_sigma_in_the_library():
    length = ASKED["length-for-a-sigma"].answer
    sigma, _ = angle_sigmas(np.array([0.0, length, 0.0]), np.diag([0.003, 0, 0]) ** 2)
    assert np.degrees(sigma) == pytest.approx(0.05, rel=1e-5)
    assert 1.2 * ASKED["sigma-of-heading"].answer / 0.05 == answer("length-for-a-sigma")  # sigma goes with one over length


def test_mistakes_of_the_length():
    gain = ASKED["sigma-of-heading"].answer / 0.05
    assert mistakes("length-for-a-sigma") == pytest.approx(
        [0.003 / 0.05, 3 / 0.05, 1000 * ASKED["length-for-a-sigma"].answer, 1.2 * gain**2], rel=1e-4
    )


def test_swapped_cables_turn_the_baseline_of_the_library():
    before = tilted(math.radians(35), math.radians(4))
    after = heading_pitch_of(-before)
    assert np.degrees(after.heading) == answer("swapped-cables")
    assert np.degrees(after.pitch) == pytest.approx(-4)  # as the solution says
    e, n = before[:2]
    slips = [heading_pitch_of([*enu, 0.0]).heading for enu in ((e, n), (-e, n), (e, -n))]
    assert np.degrees(slips) == pytest.approx(np.array(mistakes("swapped-cables")) % 360)


def test_sigma_of_a_tilted_beam_is_the_scatter_of_drawn_ends(rng):
    b, sigmas = tilted(math.radians(60), math.radians(30), 1.5), np.array([0.005, 0.008, 0.012])
    scatter = np.degrees(np.std(heading_pitch_of(b + rng.standard_normal((DRAWS, 3)) * sigmas).heading))
    assert scatter == pytest.approx(ASKED["sigma-of-a-tilted-beam"].answer, rel=5 * SIGMA_OF_SIGMA + 1e-4)  # and the bend of atan2
    assert np.degrees(angle_sigmas(b, np.diag(sigmas) ** 2)[0]) == answer("sigma-of-a-tilted-beam")


def test_mistakes_of_the_sigma_of_a_tilted_beam():
    c, s, level = math.cos(math.radians(60)), math.sin(math.radians(60)), 1.5 * math.cos(math.radians(30))
    across, swapped = math.hypot(5 * c, 8 * s), math.hypot(8 * c, 5 * s)
    radians = across / 1000 / level
    degrees = [math.degrees(mm / 1000 / metres) for mm, metres in ((across, 1.5), (swapped, level), (across**2, level))]
    assert mistakes("sigma-of-a-tilted-beam") == pytest.approx([radians, *degrees], rel=2e-4)


def test_pitch_as_printed_on_a_mast_of_the_library():
    e, n, u = tilted(math.radians(70), math.radians(25), 3.0)
    printed = math.asin(u / math.hypot(e, n))
    assert math.degrees(printed) == answer("pitch-as-printed")
    slips = [25.0, math.degrees(math.atan(math.sin(math.radians(25)))), printed]
    assert mistakes("pitch-as-printed") == pytest.approx(slips, rel=1e-4)


def test_the_prediction_is_what_a_second_gives():
    """Between 0.1 and 1 degree: carrier noise and multipath of 2 mm, doubled by differencing twice, on 1.2 m."""
    across = math.hypot(2, 2) * 2
    assert 0.1 < math.degrees(across / 1200) < 1
    assert PREDICTION.answer == "to a few tenths of a degree"
