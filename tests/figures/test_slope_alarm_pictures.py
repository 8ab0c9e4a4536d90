"""Pictures of the alarm above a village: alarms stand where they were given, and the student where the numbers say."""

import numpy as np
import pytest
from matplotlib.figure import Figure

from gnsslab.figures.slope_alarm import MISSED, build_slope, build_trade_off, plot_slope_alarm
from gnsslab.labs.slope_alarm import slope_alarm_lab


@pytest.fixture(scope="module")
def lab():
    """A lab of this module's own."""
    return slope_alarm_lab()


def shown(build, result):
    """Return the axes of a picture of a result."""
    figure = Figure(figsize=(4, 4))
    build(figure).show(result)
    return figure.axes


def rectangles(axes, place):
    """Return first and last time of each alarm of the panel's false (-2) or right ones (-1)."""
    return [(path.vertices[:, 0].min(), path.vertices[:, 0].max()) for path in axes.collections[place].get_paths()]


def test_false_alarms_stand_before_the_motion_and_right_ones_after(lab):
    result = lab.run(wait=2)
    whole, near = shown(build_slope, result)
    moves = result.x[result.at]
    false, right = rectangles(whole, -2), rectangles(whole, -1)
    assert false
    assert right
    assert max(first for first, _ in false) < moves <= min(first for first, _ in right)
    assert len(false) == np.sum(np.diff(result.alarm[: result.at].astype(int), prepend=0) == 1)
    assert min(first for first, _ in rectangles(near, -1)) == pytest.approx(result.lag, abs=1e-6)


def test_nothing_is_drawn_of_a_motion_that_is_missed_or_is_none(lab):
    for name in ("threshold-too-high", "quiet-night"):
        result = lab.run(**lab.preset(name).settings)
        whole, _ = shown(build_slope, result)
        assert not rectangles(whole, -1)
        lines = {line.get_label(): line.get_xdata() for line in whole.lines}
        assert len(lines["you know"]) == 0
        assert len(lines["it moves"]) == (2 if name == "threshold-too-high" else 0)


@pytest.mark.parametrize(("name", "height"), [("late-average", 43.5), ("threshold-too-high", MISSED), ("quiet-night", 6)])
def test_the_student_stands_on_his_own_curve(lab, name, height):
    result = lab.run(**lab.preset(name).settings)
    (axes,) = shown(build_trade_off, result)
    *curves, here = axes.lines
    point = np.array([here.get_xdata()[0], here.get_ydata()[0]])
    assert point[1] == pytest.approx(height)
    own = np.column_stack(curves[list(result.curves).index(result.settings["alarm"])].get_data())
    assert np.abs(own - point).sum(axis=1).min() < 1e-6


def test_the_whole_picture_has_both_parts(lab):
    assert len(plot_slope_alarm(lab.run()).axes) == 3
