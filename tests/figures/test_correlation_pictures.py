"""Pictures of a covariance and of what came of it."""

from types import SimpleNamespace

import numpy as np
import pytest

from gnsslab.figures.correlation import build_cloud, build_pattern, describe_correlation, plot_correlation
from gnsslab.figures.kept import KeptPicture, new_figure
from gnsslab.figures.numbers import NumberPaths


def _result(rng, n=7, factor=1.0, T=200):
    Q = 2.0 * (np.eye(n) + 1)
    solved = SimpleNamespace(
        ratio=1 + rng.exponential(3.0, T), is_right=rng.random(T) < 0.8, threshold=3.0,
        baseline=0.005 * rng.standard_normal((T, 3)), Q_baseline=factor * 0.005**2 * np.eye(3),
    )  # fmt: skip
    return SimpleNamespace(sampled=Q, believed=factor * Q, solved=solved, best=solved)


@pytest.mark.parametrize(("n", "factor", "T"), [(1, 1, 50), (4, 1, 200), (8, 300, 200), (7, 1e-6, 2)])
def test_every_result_gives_a_picture(rng, tmp_path, n, factor, T):
    plot_correlation(_result(rng, n, factor, T)).savefig(tmp_path / "a.png")
    assert (tmp_path / "a.png").stat().st_size > 5000


def test_axes_hold_still_under_small_changes(rng):
    scene = build_cloud(new_figure(350, 360))
    assert len({scene.show(_result(rng, factor=1 + k / 100)) for k in range(10)}) <= 2


def test_the_claimed_ellipse_is_never_cut(rng):
    figure = new_figure(350, 360)
    scene = build_cloud(figure)
    for factor in (0.1, 1, 100, 10_000):
        scene.show(_result(rng, factor=factor))
        half = 5 * np.sqrt(5.991 * factor)  # mm
        assert figure.axes[0].get_xlim()[1] >= half


def test_every_ratio_is_in_the_picture(rng):
    """Shares of right and wrong integers add up to all epochs, ratios beyond the axis included."""
    result = _result(rng)
    result.solved.ratio[:5] = [1.0, 1e9, np.inf, 150.0, 100.0]
    figure = new_figure(460, 540)
    build_pattern(figure).show(result)
    total = figure.axes[2].patches[0].get_xy()
    assert np.sum(total[1:-1:2, 1][: len(total) // 2]) == pytest.approx(100.0)


def test_moves_leave_nothing_behind(rng):
    results = [_result(rng, n) for n in (7, 3, 5)]
    kept = KeptPicture(build_pattern, 460, 540, sharpness=0.5)
    for result in results:
        moved = kept.png(result)
    assert moved == KeptPicture(build_pattern, 460, 540, sharpness=0.5).png(results[-1])


def test_words_for_the_pictures(rng):
    words = describe_correlation(_result(rng, factor=2.0))
    assert "7 double differences" in words
    assert "4 on the diagonal and 2 beside it as the noise has it, 8 on the diagonal and 4 beside it as the solver believes" in words
    assert "200 epochs" in words


def test_numbers_stand_centred_on_their_places():
    axes = new_figure(200, 200).add_axes((0, 0, 1, 1))
    numbers = NumberPaths(axes)
    numbers.show(["8", "8"], np.array([[0.25, 0.5], [0.75, 0.5]]), np.array([True, False]), 0.2)
    for patch, middle in ((numbers.light, 0.25), (numbers.dark, 0.75)):
        box = patch.get_path().get_extents()
        assert (box.x0 + box.x1) / 2 == pytest.approx(middle, abs=1e-6)
        assert box.height == pytest.approx(0.2, rel=0.05)  # a digit is about as high as asked
