"""Pictures of the printed error: what is drawn is what was computed, and the frame holds still."""

import numpy as np
import pytest

from gnsslab.figures.kept import new_figure
from gnsslab.figures.printed_angles import FORMULA_STYLE, build_errors, build_scatter, plot_printed_angles
from gnsslab.labs.printed_angles import printed_angles_lab


@pytest.fixture(scope="module")
def run():
    """Results of the lab."""
    return printed_angles_lab().run


def lines_of(figure, axes):
    """Return the x and y of the lines in one axes."""
    return [line.get_data() for line in figure.axes[axes].lines]


def test_mark_sits_where_the_beam_is(run):
    figure = new_figure(480, 400)
    scene = build_errors(figure)
    scene.show(run(heading_deg=120, pitch_deg=20))
    assert any(np.allclose((x, y), ([120], [180])) for x, y in lines_of(figure, 0) if len(x) == 1)
    assert any(np.allclose((x, y), ([20], [1.344]), atol=1e-3) for x, y in lines_of(figure, 1) if len(x) == 1)


def test_mark_stays_inside_and_goes_where_there_is_no_answer(run):
    figure = new_figure(480, 400)
    scene = build_errors(figure)
    for pitch_deg, is_there in ((44, True), (45, True), (60, False)):
        scene.show(run(pitch_deg=pitch_deg))
        ((_, y),) = [data for data in lines_of(figure, 1) if len(data[0]) == 1]
        low, high = figure.axes[1].get_ylim()
        assert (low <= y[0] <= high) if is_there else np.isnan(y[0])


def test_dashed_lines_stand_at_the_promised_sigma_and_inside(run):
    figure = new_figure(380, 400)
    scene = build_scatter(figure)
    for settings in ({}, {"formula": "corrected"}, {"pitch_deg": 80, "length": 0.3, "sigma_e": 20, "sigma_n": 20, "sigma_u": 40}):
        result = run(**settings)
        scene.show(result)
        for axes, sigma in ((0, result.chosen.sigma_heading), (1, result.chosen.sigma_pitch)):
            edges = sorted(x[0] for x, _ in lines_of(figure, axes))
            assert edges == pytest.approx([-np.degrees(sigma), np.degrees(sigma)])
            assert figure.axes[axes].get_xlim()[1] > np.degrees(sigma)


def test_frame_of_the_errors_never_changes(run):
    scene = build_errors(new_figure(480, 400))
    assert {scene.show(run(heading_deg=h, formula=f)) for h in (0, 200) for f in FORMULA_STYLE} == {None}


def test_whole_picture_can_be_saved(run, tmp_path):
    for name in ("a.png", "a.svg"):
        plot_printed_angles(run()).savefig(tmp_path / name)
        assert (tmp_path / name).stat().st_size > 5000
