"""Pictures of five ways to treat float ambiguities."""

import numpy as np
import pytest

from gnsslab.figures.kept import KeptPicture, new_figure
from gnsslab.figures.soft_fixing import NAMES, build_errors, build_single, describe_soft_fixing, plot_soft_fixing
from gnsslab.labs.soft_fixing import soft_fixing_lab


@pytest.fixture(scope="module")
def results():
    """Results of all presets, by name."""
    lab = soft_fixing_lab()
    return {preset.name: lab.run(**preset.settings) for preset in lab.presets}


def test_every_preset_gives_a_picture(results, tmp_path):
    for result in results.values():
        plot_soft_fixing(result).savefig(tmp_path / "a.png")
        assert (tmp_path / "a.png").stat().st_size > 5000


def test_shares_end_at_one_hundred_and_marks_stand_at_the_rms(results):
    figure = new_figure(500, 520)
    build_errors(figure).show(results["soft"])
    lines = [line for line in figure.axes[0].lines if len(line.get_xdata()) > 1]
    marks = [line for line in figure.axes[0].lines if len(line.get_xdata()) == 1]
    assert len(lines) == len(marks) == len(NAMES)
    assert all(line.get_ydata()[-1] == 100 for line in lines)
    assert sorted(mark.get_xdata()[0] for mark in marks) == pytest.approx(sorted(results["soft"].rms.values()))


def test_bar_of_the_number_fixed_is_coloured(results):
    figure = new_figure(500, 520)
    scene = build_errors(figure)
    for result in results.values():
        scene.show(result)
        colors = figure.axes[2].collections[0].get_facecolor()
        assert len(colors) == len(result.risks)
        orange = np.flatnonzero(colors[:, 0] > colors[:, 2] + 0.1) + 1
        assert orange.tolist() == ([result.fixed] if result.fixed else [])


def test_moves_leave_nothing_behind(results):
    kept = KeptPicture(build_errors, 500, 520, sharpness=0.5)
    for result in results.values():
        moved = kept.png(result)
    assert moved == KeptPicture(build_errors, 500, 520, sharpness=0.5).png(list(results.values())[-1])


def test_single_ambiguity_is_marked_at_its_sigma():
    figure = new_figure(330, 330)
    build_single(figure).show(soft_fixing_lab().run(sigma=0.6))
    marks = [line for line in figure.axes[0].lines if len(line.get_xdata()) == 1]
    assert [mark.get_xdata()[0] for mark in marks] == [0.6] * 3
    assert max(mark.get_ydata()[0] for mark in marks) > 1.1  # rounding is worse than float there


def test_words_for_the_pictures(results):
    words = describe_soft_fixing(results["trees"])
    assert "2000 epochs" in words
    assert "13 are fixed" in words
    assert all(name in words for name in NAMES.values())
