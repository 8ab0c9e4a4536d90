"""Pictures of one series and its filters."""

from types import SimpleNamespace

import numpy as np
import pytest

from gnsslab.figures.denoising import build_ranking, build_series, describe_denoising, plot_denoising
from gnsslab.figures.kept import KeptPicture, new_figure
from gnsslab.labs.denoisers import DENOISERS, PRESET, STEP_AT, rows

SETTINGS = {"step": 0, "criterion": "mean", "method": "joint", "average": 15}


def _result(raw=None, lags=None, **settings):
    used = SETTINGS | settings
    T = PRESET.epochs
    truth = 1.2 + 0.01 * used["step"] * (np.arange(T) >= STEP_AT)
    names = [name for name in DENOISERS if name != "eemd" or used["method"] == "eemd"]
    values = {name: truth + 0.002 * (k + 1) * np.sin(np.arange(T) / (k + 3.0)) for k, name in enumerate(names)}
    if raw is not None:
        values["raw"] = raw
    errors = {name: 0.2 * (k + 1) for k, name in enumerate(names)}
    by_truth = {name: 0.3 * (k + 1) for k, name in enumerate(names)}
    return SimpleNamespace(
        settings=used, hours=np.arange(T) * 15 / 3600, truth=truth, lengths=values, lags=lags or {}, chosen=used["method"],
        rows=rows(used), step_at=STEP_AT, counted=errors if used["criterion"] == "mean" else by_truth,
    )  # fmt: skip


CASES = (
    _result(),
    _result(step=5, criterion="truth", lags={"joint": 52.0, "raw": 0.0}),
    _result(step=10, method="adjustment", lags={"adjustment": np.nan}),
    _result(method="eemd"),
)


@pytest.mark.parametrize("result", CASES)
def test_every_result_gives_a_picture(result, tmp_path):
    plot_denoising(result).savefig(tmp_path / "a.png")
    assert (tmp_path / "a.png").stat().st_size > 20000


@pytest.mark.parametrize("build", [build_series, build_ranking])
def test_a_move_leaves_nothing_behind(build):
    kept = KeptPicture(build, 250, 250)
    for result in CASES:
        moved = kept.png(result)
        assert moved == KeptPicture(build, 250, 250).png(result)


def test_every_epoch_is_drawn_and_what_lies_outside_is_counted():
    raw = np.full(PRESET.epochs, 1.2)
    raw[[5, STEP_AT + 3]] = 1.5, 0.8  # 30 cm up, 40 down; the second within the lower panel
    figure = new_figure(450, 470)
    scene = build_series(figure)
    scene.show(_result(raw=raw))
    upper, lower = figure.axes
    assert len(_line(upper, "raw solutions").get_xdata()) == PRESET.epochs
    assert len(_line(lower, "raw solutions").get_xdata()) == 75 * 4 + 1  # minutes
    assert [axes.texts[0].get_text() for axes in (upper, lower)] == ["2 raw further out", "1 raw further out"]


def _line(axes, label):
    return next(line for line in axes.lines if line.get_label() == label)


def test_truth_steps_at_the_epoch_of_the_step():
    figure = new_figure(450, 470)
    build_series(figure).show(_result(step=5))
    truth = _line(figure.axes[1], "truth")
    minutes, height = truth.get_data()
    assert height[minutes < 0].max() == pytest.approx(0)
    assert height[minutes >= 0].min() == pytest.approx(5)


def test_own_mean_is_drawn_where_errors_are_counted_from_it():
    figure = new_figure(450, 470)
    scene = build_series(figure)
    for criterion, count in (("mean", 2), ("truth", 0)):
        result = _result(criterion=criterion)
        scene.show(result)
        means = _line(figure.axes[0], "its own mean").get_ydata()
        assert len(means) == count
        assert np.allclose(means, 100 * (result.lengths["joint"].mean() - 1.2))


def test_line_of_the_lag_stands_where_it_is_reached():
    figure = new_figure(450, 470)
    scene = build_series(figure)
    scene.show(_result(step=3, lags={"joint": 52.0}))
    assert set(_line(figure.axes[1], "90 % of step").get_xdata()) == {13.0}
    scene.show(_result(step=3, lags={"joint": np.nan}))
    assert len(_line(figure.axes[1], "90 % of step").get_xdata()) == 0


def test_bars_are_as_long_as_the_errors_and_diamonds_stand_at_the_papers():
    figure = new_figure(370, 470)
    scene = build_ranking(figure)
    result = _result(step=3, criterion="truth", lags={"joint": 52.0, "adjustment": np.nan})
    scene.show(result)
    axes = figure.axes[0]
    lengths = [path.vertices[:, 0].max() for bars in axes.collections for path in bars.get_paths()]
    assert sorted(lengths) == pytest.approx(sorted(result.counted.values()))
    assert [len(bars.get_paths()) for bars in axes.collections] == [4, 5]  # at once, later; EEMD is not shown
    diamonds = next(line for line in axes.lines if line.get_label() == "printed in the paper").get_xdata()
    assert list(diamonds) == [2.37, 1.00, 1.40, 1.52, 1.52, 1.78, 1.74]  # tables 1 and 2
    texts = [text.get_text() for text in axes.texts]
    assert "if shown" in texts
    assert {"52", "never"} <= set(texts)
    assert axes.get_xlabel() == "RMSE about the known truth [cm]"
    assert axes.get_xlim()[1] * 0.85 > max(lengths)


def test_paper_stands_at_the_edge_where_there_is_no_lag():
    figure = new_figure(370, 470)
    build_ranking(figure).show(_result())
    texts = [text.get_text() for text in figure.axes[0].texts]
    assert {"2.37", "1.74"} <= set(texts)
    assert "paper [cm],\nown mean" in texts


def test_texts_stay_within_the_picture():
    figure = new_figure(370, 470)
    scene = build_ranking(figure)
    scene.show(_result(step=10, criterion="truth", lags=dict.fromkeys(DENOISERS, np.nan)))
    figure.canvas.draw()
    (axes,) = figure.axes
    for text in (*axes.texts, *axes.get_yticklabels()):
        box = text.get_window_extent()
        assert box.x0 >= 0
        assert box.x1 <= figure.bbox.x1


def test_words_for_the_picture():
    assert "over 2256 epochs, nothing moves" in describe_denoising(_result())
    words = describe_denoising(_result(step=3, criterion="truth", lags={"joint": 52.0}))
    assert "a step of 3 cm" in words
    assert "about the known truth" in words
    assert "Epochs until joint has 90 % of the step: 52." in words


def test_read_only_arrays_serve():
    result = _result()
    for values in (result.hours, result.truth, *result.lengths.values()):
        values.setflags(write=False)
    plot_denoising(result)
