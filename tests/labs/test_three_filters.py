"""Lab of three filters: paper A's claims, presets, printed formulas against closed forms, and the library called directly."""

from dataclasses import replace

import numpy as np
import pytest

from gnsslab.core.rotations import heading_pitch_of
from gnsslab.gnss.moving_base import at_rover_instants
from gnsslab.gnss.preparation import prepare_moving
from gnsslab.labs.filter_modes import MODES
from gnsslab.labs.three_filters import (
    TURNTABLE_ONLY,
    fixed_percent,
    heading_rms,
    largest_heading_error,
    length_scatter,
    pitch_rms,
    three_filters_lab,
)
from gnsslab.simulate import find_preset, simulate
from gnsslab.systems.constrained_filter import direct_path, run_filter, steady_path
from gnsslab.systems.dual_antenna import A_STATIC, A_TURNTABLE
from gnsslab.systems.length_row import LengthUse

SEEDS = range(1, 9)


@pytest.fixture(scope="module")
def lab():
    """A lab of this module's own."""
    return three_filters_lab()


@pytest.fixture(scope="module")
def at_presets(lab):
    """Results of all presets, by name."""
    return {preset.name: lab.run(**preset.settings) for preset in lab.presets}


@pytest.fixture(scope="module")
def at_rest(lab):
    """The static scene at eight seeds."""
    return [lab.run(seed=seed) for seed in SEEDS]


@pytest.fixture(scope="module")
def turning(lab):
    """The turntable at eight seeds."""
    return [lab.run(scene="turntable", seed=seed) for seed in SEEDS]


def test_no_note_takes_the_place_of_a_presets_sentence(at_presets):
    assert [name for name, result in at_presets.items() if result.note] == []


def _spike(result, mode, second):
    """Return the largest heading error [deg] within 20 s of a loss of lock."""
    near = (result.seconds >= second) & (result.seconds < second + 20)
    return float(np.abs(result.solutions[mode].heading_error[near]).max())


def _at(result, mode, second, angle="heading_error"):
    return float(getattr(result.solutions[mode], angle)[result.seconds == second][0])


@pytest.mark.parametrize(("scene", "system"), [("static", A_STATIC), ("turntable", A_TURNTABLE)])
def test_solutions_are_those_of_the_library(lab, scene, system):
    """The whole chain, without the lab's caches and shortcuts."""
    noise = 3 if scene == "turntable" else 2
    result = lab.run(scene=scene, velocity_noise=noise, seed=3)
    simulation = simulate(find_preset(system.preset), np.random.default_rng(3))
    prepared = prepare_moving(*simulation.observations, simulation.ephemerides, system.settings)
    corrected = at_rover_instants(prepared)
    runs = {
        "direct": run_filter(prepared, direct_path(prepared), replace(system.filter, length_use=LengthUse.NOWHERE)),
        "length": run_filter(prepared, steady_path(prepared, system.velocity_noise), system.filter),
        "position": run_filter(corrected, steady_path(corrected, system.velocity_noise), system.filter),
    }
    heading, pitch = heading_pitch_of(simulation.truth.baselines_enu[0, prepared.model.pair.epoch])
    for mode, run in runs.items():
        found, angles = result.solutions[mode], heading_pitch_of(run.baseline)
        np.testing.assert_allclose(found.baseline, run.baseline, atol=1e-6)
        np.testing.assert_array_equal(found.is_fixed, run.is_fixed)
        apart = np.angle(np.exp(1j * (angles[0] - heading)))
        np.testing.assert_allclose(found.heading_error, np.degrees(apart), atol=1e-3)
        np.testing.assert_allclose(found.pitch_error, np.degrees(angles[1] - pitch), atol=1e-3)


def test_calibrated_errors_at_rest(at_rest):
    """Calibration of paper A, medians of eight seeds: heading 0.30 deg and pitch 0.86 with the length, direct 10; within 25 % and a factor of 2."""
    assert np.median([heading_rms(result, "length") for result in at_rest]) == pytest.approx(0.30, rel=0.25)
    assert np.median([pitch_rms(result, "length") for result in at_rest]) == pytest.approx(0.86, rel=0.25)
    assert 5 < np.median([heading_rms(result, "direct") for result in at_rest]) < 20
    assert np.median([max(_spike(result, "direct", second) for second in (300, 500)) for result in at_rest]) > 26


def test_length_makes_no_jumps_where_direct_does(at_rest):
    for result in at_rest:
        assert max(_spike(result, "direct", second) for second in (300, 500)) > 10
        assert max(_spike(result, "length", second) for second in (300, 500)) < 1.5


def test_missing_epoch_turns_the_heading_not_the_pitch(turning):
    """The master moves at v = w l / 2 across the baseline, so b is w l / 2 dt too far behind: arctan(w dt / 2), dt = 1 s."""
    expected = np.degrees(np.arctan(np.radians(6.0) / 2))
    jumps = [_at(result, "length", 218) - np.mean([_at(result, "length", second) for second in (216, 217)]) for result in turning]
    assert np.mean(jumps) == pytest.approx(-expected, abs=0.3)
    pitch = [_at(result, "length", 218, "pitch_error") - _at(result, "length", 217, "pitch_error") for result in turning]
    assert np.abs(pitch).max() < 1.5


def test_correction_is_right_with_a_perfect_doppler_and_no_better_than_it(lab):
    perfect = [_at(lab.run(scene="turntable", doppler=0, seed=seed), "position", 218) for seed in SEEDS]
    noisy = [_at(lab.run(scene="turntable", seed=seed), "position", 218) for seed in SEEDS]
    assert np.abs(perfect).max() < 1.0
    assert 1.0 < np.std(noisy) < 4.0  # 0.05 m/s of a Doppler, 15 satellites: centimetres a second, 1.167 m away


def test_late_rover_turns_the_heading_by_half_the_way(lab):
    """v dt across: arctan(w dt / 2) all the time it turns; what is true is where the rover measured."""
    result = lab.run(scene="turntable", late=500, doppler=0, missing=0, seed=2)
    turning = result.seconds > 100
    expected = np.degrees(np.arctan(np.radians(6.0) * 0.5 / 2))
    assert abs(np.median(result.solutions["length"].heading_error[turning])) == pytest.approx(expected, abs=0.2)
    assert abs(np.median(result.solutions["position"].heading_error[turning])) < 0.2


def test_at_rest_all_three_see_one_direction_and_the_correction_nothing(at_rest):
    for result in at_rest:
        np.testing.assert_allclose(result.solutions["length"].baseline, result.solutions["position"].baseline, atol=1e-4)


def test_heading_error_goes_with_one_over_length(lab):
    short, long = (heading_rms(lab.run(length=length), "length") for length in (1.167, 5))
    assert short / long == pytest.approx(5 / 1.167, rel=0.1)


@pytest.mark.parametrize("pitch", [20, 40])
def test_printed_pitch_is_the_arcsine_of_a_tangent(lab, pitch):
    right, printed = (lab.run(pitch=pitch, printed=formula).solutions["length"].pitch_error for formula in ("none", "6"))
    expected = np.degrees(np.arcsin(np.tan(np.radians(right + pitch)))) - pitch
    np.testing.assert_allclose(printed, expected, atol=1e-9)


def test_row_as_printed_is_a_row_of_the_lengths_own_sigma(at_presets):
    printed, right = at_presets["row-as-printed"], at_presets["paper-static"]
    assert length_scatter(printed, "length") > 3 * length_scatter(right, "length")
    assert max(_spike(printed, "length", second) for second in (300, 500)) < 1.5  # nor does it bring the jumps back


def test_printed_formula_of_angles_leaves_the_baselines_alone(lab, at_presets):
    for formula in ("6", "33", "34"):
        for mode, found in lab.run(printed=formula).solutions.items():
            np.testing.assert_array_equal(found.baseline, at_presets["paper-static"].solutions[mode].baseline)


def test_claims_of_the_mended_formulas_are_near_the_scatter(at_rest):
    """The filter was told 1.5 times the carrier's noise, and multipath lasts: its claim is right to a factor of two."""
    for result in at_rest:
        found = result.solutions["length"]
        for sigma, error in ((found.sigma_heading, found.heading_error), (found.sigma_pitch, found.pitch_error)):
            assert 0.5 < np.median(sigma[found.is_fixed]) / np.std(error[found.is_fixed]) < 2.5


def test_presets_say_what_is_so(lab, at_presets):
    """Every number of a preset's sentence, from the result."""
    said = {preset.name: preset.look_at for preset in lab.presets}
    rest, turntable = at_presets["paper-static"], at_presets["paper-turntable"]
    found = {
        "paper-static": (f"{_spike(rest, 'direct', 300):.0f} and {_spike(rest, 'direct', 500):.0f} deg",),
        "paper-turntable": (f"{-_at(turntable, 'length', 218):.1f} deg",),
        "row-as-printed": (f"{length_scatter(at_presets['row-as-printed'], 'length'):.1f} mm", f"not {length_scatter(rest, 'length'):.1f}"),
        "no-dynamics": (f"{_spike(at_presets['no-dynamics'], 'length', 300):.0f} deg",),
        "no-hold": (f"{_spike(at_presets['no-hold'], 'length', 300):.0f} deg",),
        "claimed-heading": (f"good to {heading_rms(rest, 'length'):.2f}", f"sigma of {_claimed(lab, at_presets['claimed-heading']):.1f} deg"),
        "too-sure": (f"{_claimed(lab, at_presets['too-sure']):.2f} deg",),
        "mirror-street": (f"{heading_rms(at_presets['mirror-street'], 'length'):.0f} deg rms",),
        "five-metres": (f"{heading_rms(at_presets['five-metres'], 'length'):.2f} deg", f"{pitch_rms(at_presets['five-metres'], 'length'):.2f}"),
        "worse-than-nothing": tuple(f"{abs(_at(at_presets['worse-than-nothing'], mode, 218)):.1f}" for mode in ("position", "length")),
        "left-behind": (f"{heading_rms(at_presets['left-behind'], 'length'):.1f} deg rms",),
    }
    for name, numbers in found.items():
        for number in numbers:
            assert number in said[name], (name, number)


def _claimed(lab, result):
    return float(lab.readouts(result)[-1].value)


def test_presets_show_what_they_promise(lab, at_presets):
    assert largest_heading_error(at_presets["paper-static"], "length")[0] < 1
    assert abs(_at(at_presets["paper-turntable"], "position", 218)) < 1
    assert abs(_at(at_presets["paper-turntable"], "length", 218, "pitch_error")) < 1
    steep = at_presets["steep"].solutions["length"]
    assert np.mean(steep.pitch_error - lab.run(pitch=20).solutions["length"].pitch_error) == pytest.approx(1.344, abs=0.1)
    assert heading_rms(at_presets["too-sure"], "length") / _claimed(lab, at_presets["too-sure"]) == pytest.approx(8, abs=2)
    assert fixed_percent(at_presets["no-range"], "length") < 5
    assert fixed_percent(at_presets["mirror-street"], "length") == 0
    assert fixed_percent(lab.run(multipath=8), "length") > 95
    late = at_presets["half-a-second"]
    late_error = {mode: late.solutions[mode].heading_error[late.seconds > 100] for mode in MODES}
    assert abs(np.median(late_error["length"])) == pytest.approx(1.5, abs=0.2)
    assert abs(np.median(late_error["position"])) < 0.5
    assert np.std(late_error["position"]) > 2 * np.std(late_error["length"])


@pytest.mark.parametrize(
    ("settings", "name", "reached"),
    [
        ({"length": 3}, "sharp", False),
        ({"length": 3, "velocity_noise": 0}, "sharp", True),
        ({"length": 5}, "sharp", False),  # against the rules
        ({"scene": "turntable", "rate": 20, "missing": 0}, "lag", False),
        ({"scene": "turntable", "rate": 20, "missing": 0, "velocity_noise": 10}, "lag", True),
        ({"scene": "turntable", "velocity_noise": 10}, "lag", False),  # against the rules
    ],
)
def test_goals_are_judged(lab, settings, name, reached):
    is_reached, state = lab.goal(name).judge(lab.run(**settings))
    assert is_reached == reached, state


def test_controls_without_effect_say_why(lab):
    assert set(lab.blocked(lab.settings())) == set(TURNTABLE_ONLY)
    assert set(lab.blocked(lab.settings(scene="turntable", printed="16"))) == {"length_sigma"}


def test_more_epochs_missing_are_older_and_worse(lab):
    result = lab.run(scene="turntable", missing=3, doppler=0)
    errors = [abs(_at(result, "length", second)) for second in (218, 219, 220)]
    assert errors == sorted(errors)
    assert errors[2] == pytest.approx(np.degrees(np.arctan(np.radians(9.0))), abs=1)  # the chord of 18 deg, seen from halfway
    assert max(abs(_at(result, "position", second)) for second in (218, 219, 220)) < 2.5  # a straight line for an arc
