"""Exercises of lesson 05, worked out by a second route."""

import math
from statistics import NormalDist

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.stats import chi2

from gnsslab.core.least_squares import least_squares
from gnsslab.core.rotations import heading_pitch_of
from gnsslab.systems.dual_antenna import angle_sigmas
from gnsslab.systems.printed_attitude import pitch_as_printed, sigma_heading_as_printed
from gnsslab.teaching.exercises.lesson_05 import PREDICTION, QUESTIONS

ASKED = {question.name: question for question in QUESTIONS}
DRAWS = 400_000
LENGTH = 1.167  # [m]
MM, MS = 1e-3, 1e-3


def answer(name, rel=1e-3):
    """Return what a second route must give: the answer, to the digits written down."""
    return pytest.approx(ASKED[name].answer, rel=rel)


def mistakes(name, rel=1e-3):
    """Return what the values of the usual mistakes of a question must be."""
    return pytest.approx([mistake.value for mistake in ASKED[name].mistakes], rel=rel)


def level_beam(heading_deg):
    """Return a level baseline of that heading (3,) [m]."""
    heading = np.radians(heading_deg)
    return LENGTH * np.array([np.sin(heading), np.cos(heading), 0.0])


def steep_beam():
    """Return the baseline of the questions, and its sigmas in east, north and up [m]."""
    heading, pitch = np.radians([50, 25])
    level = np.cos(pitch)
    return LENGTH * np.array([level * np.sin(heading), level * np.cos(heading), np.sin(pitch)]), np.array([6, 9, 16]) * MM


def test_pitch_as_printed_by_the_library_and_by_a_triangle():
    e, n, u = 0.0, math.cos(math.radians(20)), math.sin(math.radians(20))
    printed = math.degrees(math.asin(u / math.hypot(e, n)))
    assert printed == answer("a-steep-pitch-as-printed", 1e-5)
    assert np.degrees(pitch_as_printed([e, n, u])) == answer("a-steep-pitch-as-printed", 1e-5)
    assert [20, math.degrees(math.atan(u)), printed - 20, math.radians(printed)] == mistakes("a-steep-pitch-as-printed")


def test_words_about_other_pitches():
    pitches = np.radians([2, 10, 30])
    off = np.degrees(pitch_as_printed(np.stack([0 * pitches, np.cos(pitches), np.sin(pitches)], axis=-1)) - pitches)
    assert [round(float(off[0]), 3), round(float(off[1]), 2), round(float(off[2]), 1)] == [0.001, 0.16, 5.3]
    assert np.isnan(pitch_as_printed([0, 1, 1.001]))


def test_sigmas_of_a_steep_beam_by_drawing(rng):
    """Second route: draw baselines, take their angles, count how far they scatter."""
    b, sigma = steep_beam()
    angles = np.degrees(heading_pitch_of(b + sigma * rng.standard_normal((DRAWS, 3))))
    scatter = 4 / math.sqrt(2 * DRAWS) + 1e-3  # of a standard deviation, and the angles are a little curved
    for name, values, formula in zip(("sigma-of-a-steep-heading", "sigma-of-a-steep-pitch"), angles, angle_sigmas(b, np.diag(sigma**2)), strict=True):
        assert np.std(values) == answer(name, scatter)
        assert np.degrees(formula) == answer(name, 1e-4)


def test_mistakes_of_the_sigma_of_heading():
    _, (e, n, _) = steep_beam()
    c, s, level = math.cos(math.radians(50)), math.sin(math.radians(50)), LENGTH * math.cos(math.radians(25))
    right = math.hypot(c * e, s * n) / level
    printed = sigma_heading_as_printed(*np.radians([50, 25]), LENGTH, [e, n, 0.016])
    wrong = [math.hypot(c * e, s * n) / LENGTH, math.hypot(s * e, c * n) / level, (c * e + s * n) / level]
    assert [*np.degrees(wrong), right, np.degrees(printed)] == mistakes("sigma-of-a-steep-heading")


def test_mistakes_and_words_of_the_sigma_of_pitch():
    _, (e, n, u) = steep_beam()
    c, s = math.cos(math.radians(25)), math.sin(math.radians(25))
    right = math.hypot(c * u, s * math.cos(math.radians(50)) * n, s * math.sin(math.radians(50)) * e) / LENGTH
    assert [*np.degrees([c * u / LENGTH, u / LENGTH, right / c]), right] == mistakes("sigma-of-a-steep-pitch")
    assert ASKED["sigma-of-a-steep-pitch"].answer / ASKED["sigma-of-a-steep-heading"].answer == pytest.approx(1.7, abs=0.05)  # "nearly twice"


def test_a_late_receiver_by_moving_an_antenna():
    """Second route: a beam that points north, its rover driven east for a millisecond, and the heading of what is then measured."""
    late = level_beam(0) + np.array([20.0, 0, 0]) * MS
    assert np.degrees(heading_pitch_of(late)[0]) == answer("a-late-receiver", 1e-5)
    along = level_beam(0) + np.array([0, 20.0, 0]) * MS
    assert heading_pitch_of(along)[0] == 0
    assert np.linalg.norm(along) - LENGTH == pytest.approx(0.02)  # "the 2 cm go into the length"
    shift = 20 * MS
    degrees = [math.degrees(math.atan(x)) for x in (shift / LENGTH / 2, shift / 3.6 / LENGTH, shift)]
    assert [math.atan(shift / LENGTH), *degrees] == mistakes("a-late-receiver", 2e-3)


def test_least_speed_by_trying():
    """Second route: the speed at which the heading of a beam, its rover a millisecond late, is off by half a degree."""

    def excess(speed):
        return np.degrees(heading_pitch_of(level_beam(0) + np.array([speed * MS, 0, 0]))[0]) - 0.5

    speed = brentq(excess, 1, 100)
    assert speed == answer("least-speed")
    assert [speed / 2, LENGTH * 0.5 / MS, 3.6 * speed, speed * MS] == mistakes("least-speed", 1e-2)
    assert speed * MS / 0.061 == pytest.approx(0.17, abs=0.005)


def test_tape_and_prior_by_least_squares_and_by_drawing(rng):
    solved = least_squares(np.ones((2, 1)), np.zeros(2), [10.0, 5.0])
    assert math.sqrt(solved.Q[0, 0]) == answer("tape-and-prior")
    prior, tape = rng.standard_normal((2, DRAWS)) * [[10], [5]]
    assert np.std(0.2 * prior + 0.8 * tape) == answer("tape-and-prior", 4 / math.sqrt(2 * DRAWS))
    assert [20, math.hypot(10, 5), 1 / (1 / 10 + 1 / 5), 10 / math.sqrt(2), 10] == mistakes("tape-and-prior")


def test_row_as_printed_with_a_filters_gain():
    """Second route: the update of a Kalman filter, P - K H P, in place of weights."""
    P, R = 10.0**2, 1167.0**2  # [mm^2]
    left = math.sqrt(P - P * P / (P + R))
    assert 1e3 * (10 - left) == answer("the-row-as-printed")
    share = P / R
    assert [1e3 * 10 * share, 10 - left, 1e3 * 10 * math.sqrt(share) / 2, 1e3 * (10 - math.sqrt(20))] == mistakes("the-row-as-printed", 6e-3)
    hair = 70  # [um]
    assert ASKED["the-row-as-printed"].answer / hair == pytest.approx(1 / 200, abs=1e-3)  # "a two-hundredth of a hair" of 0.07 mm


def test_a_shorter_beam_by_the_sigmas_of_two_beams():
    Q = np.diag([1.0, 1.0, 1.0]) * 1e-6
    short, long = (float(angle_sigmas(length * level_beam(0) / LENGTH, Q)[0]) for length in (0.30, LENGTH))
    assert 0.40 * short / long == answer("a-shorter-beam")
    times = LENGTH / 0.30
    assert [0.4 / times, 0.4 * times**2, 0.4 * math.sqrt(times), 0.4] == mistakes("a-shorter-beam")


def test_bound_of_the_mean_by_chi_square_and_by_drawing(rng):
    low, high = chi2.ppf([0.025, 0.975], 1300) / 100
    assert high == answer("bound-of-the-mean", 3e-3)
    assert (low, high) == pytest.approx((12.02, 14.02), abs=0.005)
    means = rng.chisquare(13, (20_000, 100)).mean(axis=1)
    inside = np.mean((means > low) & (means < high))
    assert inside == pytest.approx(0.95, abs=4 * math.sqrt(0.95 * 0.05 / 20_000))
    assert chi2.ppf([0.025, 0.975], 13) == pytest.approx([5.0, 24.7], abs=0.05)
    sigma, one_sided = math.sqrt(26) / 10, NormalDist().inv_cdf(0.95)
    wrong = [chi2.ppf(0.975, 13), 13 + sigma, 13 + 1.96 * sigma / math.sqrt(2), 13 + one_sided * sigma]
    assert wrong == mistakes("bound-of-the-mean")


def test_what_the_mean_says_by_drawing(rng):
    """Second route: innovations of 13, judged with sigmas that are too large by the answer."""
    z = rng.standard_normal((20_000, 13))
    nis = np.sum((z / ASKED["what-the-mean-says"].answer) ** 2, axis=1)
    assert nis.mean() == pytest.approx(5.2, abs=4 * nis.std() / math.sqrt(len(nis)))
    assert [13 / 5.2, math.sqrt(5.2 / 13), 5.2 / 13, (13 / 5.2) ** 2] == mistakes("what-the-mean-says")


def test_ratio_with_the_length_by_a_search():
    """Second route: both candidates in one table, sorted by cost."""
    candidates = {"first": (4.0, 1.180), "second": (6.0, 1.168)}
    costs = sorted((q + ((length - LENGTH) / 0.005) ** 2, name) for name, (q, length) in candidates.items())
    assert costs[0][1] == "second"
    assert costs[1][0] / costs[0][0] == answer("ratio-with-the-length")
    plain = (4 + 13 / 5) / (6 + 1 / 5)
    assert [6 / 4, costs[0][0] / costs[1][0], plain, 169] == mistakes("ratio-with-the-length", 0.02)


def test_heading_rate_by_drawing(rng):
    shared = 0.3 * rng.standard_normal(DRAWS)
    one, other = shared + 0.2 * rng.standard_normal((2, DRAWS))
    assert np.std(other - one) == answer("heading-rate", 4 / math.sqrt(2 * DRAWS))
    both = math.hypot(0.2, 0.3)
    assert [math.sqrt(2) * both, 0.2, 0.4, both] == mistakes("heading-rate")


def test_prediction_is_what_the_filter_shows():
    """Rms of both angles with and without the length, of the paper's receivers at rest, over three seeds: no more than a tenth apart."""
    from dataclasses import replace

    from gnsslab.gnss.preparation import prepare_moving
    from gnsslab.simulate import find_preset, simulate
    from gnsslab.systems.constrained_filter import run_filter, steady_path
    from gnsslab.systems.dual_antenna import A_STATIC
    from gnsslab.systems.length_row import LengthUse

    for seed in range(3):
        sim = simulate(find_preset(A_STATIC.preset), np.random.default_rng(seed))
        prepared = prepare_moving(*sim.observations, sim.ephemerides, A_STATIC.settings)
        path, after = steady_path(prepared, A_STATIC.velocity_noise), slice(100, None)
        without, with_length = (
            run_filter(prepared, path, replace(A_STATIC.filter, length_use=use)) for use in (LengthUse.NOWHERE, LengthUse.GUARDED_ROW)
        )
        rms = [_rms_of_angles(run.baseline[after]) for run in (without, with_length)]
        np.testing.assert_allclose(rms[1], rms[0], rtol=0.1)
        scatter = [np.std(np.linalg.norm(run.baseline[after], axis=1)) for run in (without, with_length)]
        assert scatter[1] < scatter[0] / 3
    assert PREDICTION.answer == "neither"


def _rms_of_angles(baseline):
    off = np.array(heading_pitch_of(baseline)) - np.radians([[35], [0]])
    return np.sqrt(np.mean(np.square(off), axis=1))
