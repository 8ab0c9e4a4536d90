"""Pictures of what cancels and what grows."""

from types import SimpleNamespace

import numpy as np
import pytest

from gnsslab.figures.cancelling import LEVEL_STYLE, build_grains, build_sizes, describe_cancelling, length_words, plot_cancelling
from gnsslab.figures.kept import new_figure
from gnsslab.labs.levels import Levels


def _result(scale=(1e5, 2e3, 0.005), wavelength=0.19, epochs=50, noise=(0.002, 0.003, 0.004)):
    series = [np.full((k, epochs), size) for k, size in zip((4, 2, 1), scale, strict=True)]
    return SimpleNamespace(
        seconds=np.arange(epochs, dtype=float), levels=Levels(*series), wavelength=wavelength, names=("G25", "G24"),
        grains=tuple((sigma, sigma * np.sin(np.arange(epochs) * np.ones((k, 1)))) for k, sigma in zip((4, 2, 1), noise, strict=True)),
    )  # fmt: skip


@pytest.mark.parametrize(
    "result",
    [
        _result(),
        _result(wavelength=0.0, noise=(0.8, 1.1, 1.6)),
        _result(scale=(0.0, 0.0, 0.0)),
        _result(epochs=1),
        _result(noise=(80.0, 140.0, 0.004)),
    ],
    ids=["carrier", "code", "nothing", "one epoch", "real clocks"],
)
def test_every_result_gives_a_picture(result, tmp_path):
    plot_cancelling(result).savefig(tmp_path / "a.png")
    assert (tmp_path / "a.png").stat().st_size > 5000


def test_levels_are_told_by_colour_and_by_marker():
    for key in ("color", "marker"):
        assert len({style[key] for style in LEVEL_STYLE}) == 3


def test_all_sizes_stand_on_the_axis():
    figure = new_figure(470, 410)
    build_sizes(figure).show(_result(scale=(3e5, 1e-9, 0.0)))
    low, high = figure.axes[0].get_ylim()
    drawn = np.concatenate([line.get_ydata() for line in figure.axes[0].lines])
    assert ((low < drawn) & (drawn < high)).all()


def test_axes_hold_still_under_small_changes():
    scene = build_grains(new_figure(380, 410))
    assert len({scene.show(_result(noise=(0.002, 0.003, sigma))) for sigma in np.linspace(0.0045, 0.0062, 20)}) == 1


def test_noise_off_the_scale_is_said():
    figure = new_figure(380, 410)
    build_grains(figure).show(_result(noise=(80.0, 140.0, 0.004)))
    words = [text.get_text() for axes in figure.axes for text in axes.texts]
    assert "undifferenced: 80.0 m, far off this scale" in words
    assert "double difference: 1 sigma = 4.0 mm" in words


def test_growth_of_the_noise_is_told():
    figure = new_figure(380, 410)
    build_grains(figure).show(_result(noise=(0.002, 0.0028, 0.004)))
    words = " ".join(text.get_text() for axes in figure.axes for text in axes.texts)
    assert "1.40 times" in words
    assert "2.00 times" in words


def test_words_for_the_pictures():
    words = describe_cancelling(_result())
    assert "G25 and the reference G24 over 50 epochs" in words
    assert "undifferenced 100 km; single difference 2.00 km; double difference 5.0 mm" in words


@pytest.mark.parametrize(("metres", "words"), [(0.0, "0.0 mm"), (0.0999, "99.9 mm"), (0.1, "0.10 m"), (999.0, "999 m"), (12_345.0, "12.3 km")])
def test_lengths_are_told_in_a_fitting_unit(metres, words):
    assert length_words(metres) == words
