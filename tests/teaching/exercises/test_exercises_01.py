"""Exercises of lesson 01, worked out by a second route."""

import math
from dataclasses import replace

import numpy as np
import pytest

from gnsslab.gnss.observation_equations import RangeTerms, carrier_range, code_range
from gnsslab.gnss.signals import SPEED_OF_LIGHT, wavelength
from gnsslab.labs.signal import signal_lab
from gnsslab.simulate import NO_NOISE, Clock, find_preset, prepare_geometry
from gnsslab.simulate.measurements import measure
from gnsslab.simulate.receivers import multipath_factor, white_factor
from gnsslab.systems.printed_ranges import carrier_range_as_printed
from gnsslab.teaching.exercises.lesson_01 import PREDICTION, QUESTIONS

ASKED = {question.name: question for question in QUESTIONS}
L1, L2 = wavelength("G", "1"), wavelength("G", "2")
DRAWS = 20_000
NOWHERE = RangeTerms(2.2e7, 0.0, 0.0, 0.0, 0.0)


def answer(name, rel=2e-5):
    """Return what a second route must give: the answer, to the digits written down."""
    return pytest.approx(ASKED[name].answer, rel=rel)


def mistakes(name):
    """Return the values of the usual mistakes of a question."""
    return [mistake.value for mistake in ASKED[name].mistakes]


@pytest.fixture(scope="module")
def noise_free():
    """Code, carrier [cycles] and Doppler (4, T, m) of GPS, of a steered receiver and of one that is 2 microseconds fast."""
    preset = replace(find_preset("static-baseline"), systems="G", bands=1, duration=3.0, base=(0.0, 0.0, 0.0), antennas=((0.0, 0.0, 1e-9),))
    geometry = prepare_geometry(replace(preset, clocks=(Clock(), Clock(offset=2e-6))))
    return measure(geometry, NO_NOISE, np.random.default_rng(1))["G"].value[..., 0]


def test_slip_in_the_lab():
    with_slip, without = (signal_lab().run(slip_cycles=cycles).track for cycles in (7, 0))
    moved = (with_slip.code_minus_carrier - without.code_minus_carrier)[-1]
    first_level = 0.05  # [m], of the stretch before the slip, which is half as long here
    assert moved == pytest.approx(ASKED["slip-in-metres"].answer, abs=first_level)
    assert answer("slip-in-metres") == -7 * L1


def test_mistakes_of_the_slip():
    assert mistakes("slip-in-metres") == pytest.approx([7 * L1, -7, 7, -7 * L2, -7 / L1], rel=1e-5)


def test_ionosphere_by_the_equations():
    grown = ASKED["ionosphere-from-code-minus-carrier"].answer
    before, after = NOWHERE, NOWHERE._replace(ionosphere=grown)
    climbed = (code_range(after) - carrier_range(after)) - (code_range(before) - carrier_range(before))
    assert climbed == pytest.approx(3.4)
    assert mistakes("ionosphere-from-code-minus-carrier") == pytest.approx([3.4, 2 * 3.4, -grown])


def test_microseconds_in_the_simulator(noise_free):
    """Two antennas in one place, one clock fast: it also measures 2 us early, in which a satellite moves 2 mm."""
    late = noise_free[0, 1] - noise_free[0, 0]
    assert np.isfinite(late).sum() > 20
    np.testing.assert_allclose(late[np.isfinite(late)], ASKED["microseconds-of-light"].answer, atol=0.01)


def test_mistakes_of_the_microseconds():
    metres = [0.0, *(SPEED_OF_LIGHT * seconds for seconds in (2e-3, 2e-9, -2e-6, 1e-6))]
    assert mistakes("microseconds-of-light") == pytest.approx(metres, rel=1e-5)


def test_doppler_and_range_in_the_simulator(noise_free):
    """The code of the simulated satellites changes by -lambda D a second; so 2100 Hz are that many metres a second."""
    code, doppler = noise_free[0, 0], noise_free[2, 0]
    seen = np.isfinite(code).all(axis=0)
    rate = (code[2] - code[0])[seen] / 2
    lengths = -rate / doppler[1][seen]
    assert np.median(lengths) * -2100 == pytest.approx(ASKED["speed-from-doppler"].answer, rel=1e-3)
    assert answer("speed-from-doppler") == -L1 * 2100


def test_mistakes_of_the_doppler():
    assert mistakes("speed-from-doppler") == pytest.approx([L1 * 2100, -2100, 2100, -2100 / L1], rel=1e-4)


def test_sigma_of_a_low_satellite_by_the_simulator():
    el = math.radians(10)
    assert 0.3 * white_factor(el) == answer("sigma-of-a-low-satellite")
    slips = [0.3 * white_factor(el) ** 2, 0.3 * multipath_factor(el), 0.3 * math.sqrt(0.5 + 0.5 / math.sin(10) ** 2)]
    assert mistakes("sigma-of-a-low-satellite") == pytest.approx(slips, rel=2e-4)


def test_mean_of_a_hundred_is_drawn(rng):
    means = (0.6 * rng.standard_normal((DRAWS, 100))).mean(axis=1)
    assert np.std(means) == pytest.approx(ASKED["mean-of-a-hundred"].answer, rel=4 / math.sqrt(2 * DRAWS))
    slips = [0.6 / 100, 0.6**2 / 100, 0.6**2, 0.6, 0.6 * math.sqrt(100)]
    assert mistakes("mean-of-a-hundred") == pytest.approx(slips)


def test_the_printed_equation_runs_away():
    clock = NOWHERE._replace(clock_receiver=12.0 * 600)
    run = carrier_range(clock) - carrier_range_as_printed(clock)
    assert run / 1000 == answer("run-away-of-the-printed-equation")
    assert mistakes("run-away-of-the-printed-equation") == pytest.approx([12 * 600 / 1000, run, 2 * 12 / 1000, 0.0])


def test_the_prediction_is_what_the_lab_shows():
    track = signal_lab().run().track
    assert 100 <= track.sigma_code / track.sigma_carrier < 10_000
    assert PREDICTION.answer == "100 times or more"
