"""Pictures of float and fixed positions and of the share of right integers."""

from types import SimpleNamespace

import numpy as np
import pytest

from gnsslab.figures.centimetres import build_plane, build_span, describe_centimetres, plot_centimetres
from gnsslab.figures.kept import KeptPicture, new_figure


def _result(rng, scale=1.0, share=0.8, T=300):
    is_right = rng.random(T) < share
    floats, small = scale * 0.5 * rng.standard_normal((T, 3)), scale * 0.005 * rng.standard_normal((T, 3))
    span = np.array([1, 10, 60])
    return SimpleNamespace(
        settings={"epochs": 10}, float_enu=floats, fixed_enu=np.where(is_right[:, None], small, floats + small), is_right=is_right,
        Q_float=scale**2 * 0.25 * np.eye(3), Q_fixed=scale**2 * 25e-6 * np.eye(3), span=span, promised_over_span=np.array([0.3, 0.9, 1.0]),
    )  # fmt: skip


@pytest.mark.parametrize(("scale", "share", "T"), [(1, 0.8, 300), (1, 0.0, 300), (1, 1.0, 300), (30, 0.5, 300), (0.05, 0.5, 300), (1, 1.0, 1)])
def test_every_result_gives_a_picture(rng, tmp_path, scale, share, T):
    plot_centimetres(_result(rng, scale, share, T)).savefig(tmp_path / "a.png")
    assert (tmp_path / "a.png").stat().st_size > 5000


def test_axes_hold_still_under_small_changes(rng):
    scene = build_plane(new_figure(460, 540))
    assert len({scene.show(_result(rng, 1 + k / 200)) for k in range(10)}) <= 2


@pytest.mark.parametrize("scale", [0.1, 1, 5])
def test_claimed_ellipses_are_never_cut(rng, scale):
    figure = new_figure(460, 540)
    build_plane(figure).show(_result(rng, scale))
    plane, window = figure.axes
    reach = np.sqrt(5.991) * scale
    assert plane.get_ylim()[1] >= 0.5 * reach
    assert window.get_ylim()[1] >= 5 * reach  # [mm]


def test_counted_share_stands_at_its_epochs_with_two_sigma(rng):
    figure, result = new_figure(350, 360), _result(rng)
    build_span(figure).show(result)
    promised, bar, counted = figure.axes[0].lines
    share, T = 100 * np.mean(result.is_right), len(result.is_right)
    assert counted.get_xydata().tolist() == [[10, pytest.approx(share)]]
    assert np.ptp(bar.get_ydata()) == pytest.approx(4 * np.sqrt(share * (100 - share) / T))
    assert promised.get_ydata().tolist() == [30, 90, 100]


def test_moves_leave_nothing_behind(rng):
    results = [_result(rng, scale) for scale in (1, 3, 2)]
    kept = KeptPicture(build_plane, 460, 540, sharpness=0.5)
    for result in results:
        moved = kept.png(result)
    assert moved == KeptPicture(build_plane, 460, 540, sharpness=0.5).png(results[-1])


def test_words_for_the_pictures(rng):
    words = describe_centimetres(_result(rng))
    assert "300 positions on the map" in words
    assert "drawn as crosses" in words
    assert "promises 30 % at one epoch and 100 % at sixty" in words
    assert "crosses" not in describe_centimetres(_result(rng, share=1.0))
