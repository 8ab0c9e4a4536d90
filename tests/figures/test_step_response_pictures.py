"""Pictures of how filters follow a step."""

from types import SimpleNamespace

import numpy as np
import pytest

from gnsslab.figures.kept import KeptPicture, new_figure
from gnsslab.figures.step_response import LATEST, build_response, build_series, describe_step_response, plot_step_response

SETTINGS = {"view": "near", "seen": "position", "step": 3.6, "lasts": 0}
EPOCHS = np.arange(-300, 260)
SIZES = np.arange(0.5, 15.25, 0.5)


def _track(label, tau, step=3.6, curve=True, rejected=False, found=np.nan):
    response = np.where(EPOCHS < 0, 0.0, 1 - np.exp(-(EPOCHS + 1.0) / tau))
    lags = tuple(float(np.ceil(-tau * np.log(1 - share))) for share in (0.5, 0.9, 0.99))
    return SimpleNamespace(
        label=label, drawn=step * response, response=response, lags=lags, most=1.25, found=found,
        is_rejected=(np.abs(EPOCHS - 5) < 3) if rejected else None, curve=np.linspace(3, 150, len(SIZES)) if curve else None,
    )  # fmt: skip


def _result(**given):
    used = SETTINGS | {name: value for name, value in given.items() if name in SETTINGS}
    tracks = {"shown": _track("joint", 22), "beside": _track("monitor", 4, curve=False, found=9.0)}
    tracks |= {name: value for name, value in given.items() if name in tracks}
    truth = used["step"] * (EPOCHS >= 0) if used["lasts"] == 0 else np.zeros(len(EPOCHS))
    raw = given.get("raw", truth + np.sin(7.0 * EPOCHS))
    return SimpleNamespace(
        settings=used, epochs=EPOCHS, about=EPOCHS, truth=truth, raw=raw, sizes=SIZES, size=used["step"], is_for_good=used["lasts"] == 0, **tracks
    )


NEVER = _track("adaptive Kalman", 22, curve=False)
NEVER.lags = (np.nan,) * 3
CASES = (
    _result(),
    _result(step=15, shown=_track("robust Kalman", 30, 15, rejected=True), beside=NEVER),
    _result(view="all", seen="length"),
    _result(lasts=3, step=10),
    _result(step=0),
)


@pytest.mark.parametrize("result", CASES)
def test_every_result_gives_a_picture(result, tmp_path):
    plot_step_response(result).savefig(tmp_path / "a.png")
    assert (tmp_path / "a.png").stat().st_size > 20000


@pytest.mark.parametrize("build", [build_series, build_response])
def test_a_move_leaves_nothing_behind(build):
    kept = KeptPicture(build, 250, 250)
    for result in (*CASES, *CASES[::-1]):
        moved = kept.png(result)
        assert moved == KeptPicture(build, 250, 250).png(result)


def _lines(build, result):
    """Return the axes' lines by label, and the figure."""
    figure = new_figure(450, 470)
    build(figure).show(result)
    return {line.get_label(): line for axes in figure.axes for line in axes.lines}, figure


def test_epochs_near_the_step_are_drawn_and_what_lies_outside_is_counted():
    raw = np.zeros(len(EPOCHS))
    raw[[300 - 41, 300 - 40, 300 + 160, 300 + 161]] = 50.0  # 41 and 40 before, 160 and 161 after
    lines, figure = _lines(build_series, _result(raw=raw))
    assert list(lines["raw solutions"].get_xdata()) == list(range(-40, 161))
    assert figure.axes[0].texts[0].get_text() == "2 raw further out"
    assert list(lines["truth"].get_ydata()) == [0.0] * 40 + [3.6] * 161


def test_all_epochs_are_a_line_without_marks():
    lines, figure = _lines(build_series, _result(view="all", shown=_track("robust Kalman", 20, rejected=True)))
    assert len(lines["raw solutions"].get_xdata()) == len(lines["rejected"].get_xdata()) == len(lines["step found"].get_xdata()) == 0
    assert len(lines["filter"].get_xdata()) == len(EPOCHS) == max(len(line.get_xdata()) for line in figure.axes[0].lines)
    assert "all of them" in figure.axes[0].get_xlabel()


def test_rejected_solutions_and_the_finding_are_marked_where_they_are():
    result = _result(shown=_track("robust Kalman", 20, rejected=True))
    lines, figure = _lines(build_series, result)
    assert list(lines["rejected"].get_xdata()) == [3, 4, 5, 6, 7]
    assert list(lines["rejected"].get_ydata()) == list(result.raw[303:308])
    assert list(lines["step found"].get_xdata()) == [9.0]
    assert list(lines["step found"].get_ydata()) == [result.beside.drawn[309]]
    (legend,) = figure.legends
    assert [text.get_text() for text in legend.get_texts()][3:5] == ["robust Kalman", "monitor"]


def test_answers_are_in_percent_with_points_at_three_shares():
    figure = new_figure(370, 470)
    result = _result()
    build_response(figure).show(result)
    answer = figure.axes[0]
    raw, beside, shown, reached = answer.lines
    np.testing.assert_allclose(shown.get_ydata(), 100 * result.shown.response[290:461])
    np.testing.assert_allclose(beside.get_ydata(), 100 * result.beside.response[290:461])
    assert list(reached.get_xdata()) == list(result.shown.lags)
    assert list(reached.get_ydata()) == [50, 90, 99]
    assert [text.get_text() for text in answer.texts] == ["epochs to 50, 90, 99 %", "joint: 16, 51, 102", "monitor: 3, 10, 19"]
    assert raw.get_ydata()[9:12].tolist() == [0, 100, 100]


def test_lags_are_drawn_over_the_size_and_late_ones_at_the_edge():
    figure = new_figure(370, 470)
    build_response(figure).show(_result(beside=NEVER))
    beside, shown, beside_now, shown_now = figure.axes[1].lines
    assert shown.get_ydata().max() == LATEST  # 150 epochs
    assert len(beside.get_xdata()) == 0  # no curve
    assert (beside_now.get_xdata()[0], beside_now.get_ydata()[0]) == (3.6, LATEST)
    assert (shown_now.get_xdata()[0], shown_now.get_ydata()[0]) == (3.6, 16)


def test_wrong_solutions_are_told_by_how_much_they_move():
    figure = new_figure(370, 470)
    build_response(figure).show(_result(lasts=3, step=10))
    answer, sizes = figure.axes
    assert [text.get_text() for text in answer.texts] == ["moved by at most", "joint: 1.25 cm", "monitor: 1.25 cm"]
    assert sizes.get_ylabel() == "moved by at most [cm]"
    assert answer.lines[0].get_ydata().sum() == 300  # three epochs
    assert len(answer.lines[3].get_xdata()) == 0


def test_texts_stay_within_the_picture():
    figure = new_figure(370, 470)
    build_response(figure).show(_result(shown=_track("robust Kalman", 200), beside=NEVER))
    figure.canvas.draw()
    for axes in figure.axes:
        for text in (*axes.texts, *axes.get_yticklabels(), axes.yaxis.label):
            box = text.get_window_extent()
            assert box.x0 >= 0
            assert box.x1 <= figure.bbox.x1


def test_words_for_the_picture():
    words = describe_step_response(_result())
    assert "over 560 epochs with a step of 3.6 cm" in words
    assert "joint: epochs to 50, 90 and 99 % of the step: 16, 51, 102; monitor: " in words
    assert "never, never, never" in describe_step_response(CASES[1])
    assert "10 cm off for 3 epochs" in describe_step_response(CASES[3])
    assert describe_step_response(CASES[4]).endswith("Nothing moves.")


def test_read_only_arrays_serve():
    result = _result()
    for values in (result.epochs, result.truth, result.raw, result.shown.drawn, result.shown.response, result.shown.curve):
        values.setflags(write=False)
    plot_step_response(result)
