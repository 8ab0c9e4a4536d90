"""Lab of the printed error: every corner answers, the corrected formulas agree with the draws, the printed ones err as the paper's do."""

import itertools

import numpy as np
import pytest

from gnsslab.figures.kept import KeptPicture
from gnsslab.labs.printed_angles import CONTROLS, POINTS

LAB = "printed"
EDGE = 4 / np.sqrt(2 * POINTS)  # 4 sigma of a standard deviation counted from so many draws, relative


@pytest.fixture(scope="module")
def pictures(lab):
    """Its kept pictures, coarse."""
    return [KeptPicture(drawing.build, drawing.width, drawing.height, sharpness=0.5) for drawing in lab.drawings()]


def answers(lab, pictures, result):
    """Return whether a result has readouts, words and pictures, and says "none" exactly where there is no number."""
    values = [readout.value for readout in lab.readouts(result)]
    drawn = all(picture.png(result).startswith(b"\x89PNG") for picture in pictures)
    is_finite = np.isfinite([result.corrected.heading, result.corrected.pitch, *lab.table(result)["drawn_heading_error_deg"]]).all()
    too_steep = result.settings["formula"] == "printed" and abs(result.settings["pitch_deg"]) > 45
    return result.problem == "" and drawn and is_finite and "nan" not in lab.describe(result) and ("none" in values) == too_steep


@pytest.mark.parametrize("control", CONTROLS, ids=lambda control: control.name)
def test_each_corner_answers(lab, pictures, control):
    for value in control.corners:
        assert answers(lab, pictures, lab.run(**{control.name: value})), value


def test_corners_of_several_controls_at_once(lab, pictures):
    steep = {"formula": ("printed", "corrected"), "heading_deg": (0, 90, 180, 270, 360), "pitch_deg": (-80, 0, 45, 80)}
    for values in itertools.product(*steep.values()):
        settings = dict(zip(steep, values, strict=True)) | {"length": 0.3, "sigma_e": 20, "sigma_n": 20, "sigma_u": 40}
        assert answers(lab, pictures, lab.run(**settings)), settings


@pytest.mark.parametrize(("heading_deg", "off"), [(0, 0), (35, 0), (85, 0), (95, 180), (120, 180), (180, 180), (265, 180), (275, 0), (360, 0)])
def test_printed_heading_is_half_a_turn_off_in_the_south(lab, heading_deg, off):
    assert lab.run(heading_deg=heading_deg).heading_error == pytest.approx(off, abs=1e-9)
    assert lab.run(heading_deg=heading_deg, formula="corrected").heading_error == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize(("pitch_deg", "error"), [(2, 0.0012), (10, 0.156), (20, 1.344), (30, 5.264), (-20, -1.344), (0, 0.0)])
def test_printed_pitch_errs_as_worked_out(lab, pitch_deg, error):
    assert lab.run(pitch_deg=pitch_deg).pitch_error == pytest.approx(error, abs=5e-4)
    assert lab.run(pitch_deg=pitch_deg, formula="corrected").pitch_error == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize("settings", [{}, {"heading_deg": 50, "pitch_deg": 25}, {"heading_deg": 300, "pitch_deg": -60, "length": 3}])
def test_corrected_sigmas_are_those_of_the_draws(lab, settings):
    result = lab.run(**settings)
    for sigma, drawn in ((result.corrected.sigma_heading, result.drawn_heading), (result.corrected.sigma_pitch, result.drawn_pitch)):
        assert np.std(drawn) == pytest.approx(np.degrees(sigma), rel=EDGE)


def test_curves_pass_through_the_beam(lab):
    """What the mark shows is what the curve shows: interpolated at the beam's own angle."""
    for formula in ("printed", "corrected"):
        result = lab.run(formula=formula, heading_deg=200, pitch_deg=33)
        at_heading = np.interp(200, result.headings_deg, result.chosen.heading_errors)
        at_pitch = np.interp(33, result.pitches_deg, result.chosen.pitch_errors)
        assert (at_heading, at_pitch) == pytest.approx((result.heading_error, result.pitch_error), abs=2e-4)


def test_presets_show_what_they_promise(lab):
    runs = {preset.name: lab.run(**preset.settings) for preset in lab.presets}
    assert (runs["misprint"].heading_error, runs["misprint"].pitch_error) == pytest.approx((180, 1.344), abs=5e-4)
    assert abs(runs["level"].heading_error) < 1e-9
    assert abs(runs["level"].pitch_error) < 0.002
    assert runs["south"].heading_error == pytest.approx(180)
    assert 40 + runs["steep"].pitch_error == pytest.approx(57, abs=0.1)
    assert np.isnan(runs["none"].pitch_error)
    assert runs["sigma"].printed.sigma_heading / runs["sigma"].corrected.sigma_heading == pytest.approx(16, abs=0.3)
    inside = np.abs(runs["mended"].drawn_pitch) < np.degrees(runs["mended"].chosen.sigma_pitch)
    assert inside.mean() == pytest.approx(0.683, abs=4 * np.sqrt(0.683 * 0.317 / POINTS))


@pytest.mark.parametrize(
    ("settings", "reached"),
    [
        ({}, False),
        ({"heading_deg": 35, "pitch_deg": 3}, True),  # 0.0041 deg
        ({"heading_deg": 35, "pitch_deg": 5}, False),  # 0.019 deg
        ({"heading_deg": 200, "pitch_deg": 3}, False),
        ({"heading_deg": 35, "pitch_deg": 2}, False),  # against the rules
        ({"heading_deg": 35, "pitch_deg": 3, "formula": "corrected"}, False),
        ({"pitch_deg": 80}, False),
    ],
)
def test_goal_is_judged(lab, settings, reached):
    is_reached, standing = lab.goal("unnoticed").judge(lab.run(**settings))
    assert is_reached == reached
    assert standing.startswith("Now: ")
    assert "nan" not in standing


def test_table_holds_what_is_in_the_pictures(lab):
    columns = lab.table(lab.run())
    assert {len(column) for column in columns.values()} == {POINTS}
    assert all(name.endswith("_deg") for name in columns)


def test_words_and_readouts(lab):
    result = lab.run()
    assert "Heading: off by +180 deg; pitch: off by +1.34 deg." in lab.describe(result)
    assert [(readout.label, readout.value) for readout in lab.readouts(result)][:2] == [("Heading", "300.00"), ("Pitch", "21.34")]
    assert "Heading: right; pitch: right." in lab.describe(lab.run(formula="corrected"))
    assert "pitch: no answer." in lab.describe(lab.run(pitch_deg=60))
