"""Pictures of trust in a fix."""

from types import SimpleNamespace

import numpy as np
import pytest

from gnsslab.core.integers.simulation import SimulatedRate
from gnsslab.figures.kept import KeptPicture, new_figure
from gnsslab.figures.shares import percent
from gnsslab.figures.trust import LEAST_SHARE, LOOKS, build_promised, build_tests, describe_trust, plot_trust

NAMES = ("bootstrapping", "ADOP", "variances and ADOP", "pull-in region", "eigenvalues")


def _claims(low, high):
    lows, highs = (low, low, 0.5 * low, 0.6 * low, 0.7 * low), (low, low, high, high, high)
    return tuple(SimpleNamespace(name=name, low=a, high=b) for name, a, b in zip(NAMES, lows, highs, strict=True))


class _Shares(tuple):
    fixed_right, fixed_wrong, rejected_wrong, rejected_right = (property(lambda shares, k=k: shares[k]) for k in range(4))
    fixed = property(lambda shares: shares[0] + shares[1])


def _result(rng, test="ratio", threshold=3.0, right=0.9, N=500, unbiased=None, written="right"):
    is_right = rng.random(N) < right
    statistic = 1 + rng.exponential(2.0, N)
    accepted_range = (0.0, threshold) if test == "projector" or written == "upside-down" else (threshold, np.inf)
    counted = SimulatedRate(int(is_right.sum()), N)
    shares = _Shares((0.4, 0.05, 0.15, 0.4))
    names = ("chosen", "none", "constant", "of n", "tolerated")
    return SimpleNamespace(
        settings={"test": test, "written": written, "tolerance": 0.5}, is_right=is_right, statistic=statistic, accepted_range=accepted_range,
        counted=counted, unbiased=counted if unbiased is None else SimulatedRate(int(unbiased * N), N),
        model=SimpleNamespace(Q=np.eye(6), claims=_claims(right, 0.99)),
        judged=tuple(SimpleNamespace(name=name, threshold=threshold, shares=shares) for name in names),
    )  # fmt: skip


@pytest.mark.parametrize("test", LOOKS)
@pytest.mark.parametrize("right", [0.0, 0.5, 1.0])
def test_every_result_gives_a_picture(rng, tmp_path, test, right):
    plot_trust(_result(rng, test, right=right)).savefig(tmp_path / "a.png")
    assert (tmp_path / "a.png").stat().st_size > 5000


def test_everything_stays_in_sight(rng):
    """Rates of 0 and of 1, and claims of both, lie on the axis, and their numbers inside the picture."""
    figure = new_figure(400, 400)
    scene = build_promised(figure)
    for right in (0.0, 1e-7, 0.5, 1 - 1e-9, 1.0):
        result = _result(rng, right=right)
        result.model.claims = _claims(right, 1.0)
        scene.show(result)
        figure.canvas.draw()
        axes = figure.axes[0]
        low, high = axes.get_xlim()
        for line in axes.lines:
            x = np.asarray(line.get_xdata(), dtype=float)
            if line in scene.moving:
                assert ((low <= x) & (x <= high)).all()
        for text in (*axes.texts, *axes.get_yticklabels()):
            box = text.get_window_extent()
            assert box.x0 >= 0
            assert box.x1 <= figure.bbox.x1


def test_rows_stand_in_the_order_of_their_rates(rng):
    """A larger rate lies farther to the right, also next to 1; the ring shows only where multipath has moved the count."""
    scene = build_promised(new_figure(400, 400))
    places = []
    for right in (0.01, 0.5, 0.99, 0.999, 0.9999):
        result = _result(rng)
        result.counted = result.unbiased = SimulatedRate(round(10_000 * right), 10_000)
        scene.show(result)
        ring, count = scene.moving[7:9]
        places.append(float(count.get_xdata()[0]))
        assert len(ring.get_xdata()) == 0
    assert (np.diff(places) > 0.5).all()
    scene.show(_result(rng, right=0.5, unbiased=0.99))
    assert ring.get_xdata()[0] > count.get_xdata()[0]


@pytest.mark.parametrize("test", LOOKS)
def test_every_epoch_is_in_the_histogram(rng, test):
    """Right and wrong add up to all epochs, values beyond the axis included."""
    result = _result(rng, test)
    result.statistic[:5] = [1e-9, 1e9, np.inf, 150.0, 1.0]
    figure = new_figure(460, 480)
    scene = build_tests(figure)
    scene.show(result)
    total = 0.0
    for part in (scene.moving[1], scene.moving[3]):  # all right ones, all wrong ones
        heights = part.get_paths()[0].vertices[1:-1:2, 1]
        total += heights[heights > LEAST_SHARE].sum()
    assert total == pytest.approx(100.0, abs=1e-6)


def test_fixed_side_is_the_shaded_one(rng):
    figure = new_figure(460, 480)
    scene = build_tests(figure)
    for result, ends in (
        (_result(rng, threshold=3.0), (3.0, 100.0)),
        (_result(rng, threshold=3.0, written="upside-down"), (1.0, 3.0)),
        (_result(rng, "projector", threshold=2.0), (0.0, 2.0)),
    ):
        scene.show(result)
        x = scene.moving[0].get_paths()[0].vertices[:, 0]
        assert (x.min(), x.max()) == pytest.approx(ends)


def test_moves_leave_nothing_behind(rng):
    results = [
        _result(rng, test, right=right, unbiased=0.99) for test, right in (("ratio", 0.9), ("projector", 0.2), ("difference", 1.0), ("ratio", 0.7))
    ]
    for build, size in ((build_promised, (400, 400)), (build_tests, (460, 480))):
        kept = KeptPicture(build, *size, sharpness=0.5)
        for result in results:
            moved = kept.png(result)
        assert moved == KeptPicture(build, *size, sharpness=0.5).png(results[-1])


def test_words_for_the_pictures(rng):
    result = _result(rng, right=1.0, N=400)
    words = describe_trust(result)
    assert "6 ambiguities" in words
    assert "Counted in 400 epochs: 100 % right" in words
    assert "0.5 % fail: 3: 45.0 % fixed, 5.0 % fixed wrong, 40.0 % right but rejected" in words
    assert "no test" in words
    assert "upside down: 45.0 %" in describe_trust(_result(rng, written="upside-down"))
    assert "projector 3" in describe_trust(_result(rng, "projector"))


@pytest.mark.parametrize("share", [0, 1e-9, 3e-5, 0.0004, 0.012, 0.5, 0.987, 0.9996, 0.99997, 1])
def test_percent_tells_rare_from_never(share):
    text = percent(share)
    assert abs(float(text) - 100 * share) <= 0.06 * min(100 * share, 100 - 100 * share) + 5e-4
    assert len(text) <= 6
