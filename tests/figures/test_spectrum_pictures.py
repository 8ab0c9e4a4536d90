"""Pictures of the spectrum of conditional sigmas and of the nodes."""

from types import SimpleNamespace

import numpy as np
import pytest

from gnsslab.figures.kept import KeptPicture, new_figure
from gnsslab.figures.spectrum import build_nodes, build_spectrum, describe_spectrum, plot_spectrum


def _result(n=7, with_after=True):
    before = SimpleNamespace(sigma=np.concatenate([[8.0, 6.0, 3.0], np.full(n - 3, 0.05)]), nodes=np.full(10, 20_000))
    adop = np.exp(np.mean(np.log(before.sigma)))
    after = SimpleNamespace(sigma=np.full(n, adop), nodes=np.full(10, 30)) if with_after else None
    return SimpleNamespace(n=n, before=before, after=after, adop=adop, node_limit=500_000)


@pytest.mark.parametrize(("n", "with_after"), [(4, True), (7, True), (30, True), (7, False)])
def test_every_result_gives_a_picture(tmp_path, n, with_after):
    plot_spectrum(_result(n, with_after)).savefig(tmp_path / "a.png")
    assert (tmp_path / "a.png").stat().st_size > 5000


def test_all_sigmas_are_within_the_axis():
    figure = new_figure(520, 400)
    scene = build_spectrum(figure)
    for n in (4, 30):
        result = _result(n)
        scene.show(result)
        lowest, highest = figure.axes[0].get_ylim()
        assert lowest <= result.before.sigma.min() < result.before.sigma.max() <= highest


def test_nodes_never_leave_the_axis():
    """From straight down with four ambiguities to the limit."""
    figure = new_figure(350, 360)
    scene = build_nodes(figure)
    for nodes in (9, 500_000):
        result = _result(4)
        result.before.nodes[:] = nodes
        scene.show(result)
        lowest, highest = figure.axes[0].get_ylim()
        assert lowest < nodes < highest


def test_nothing_of_after_is_left_when_decorrelation_goes_off():
    for build in (build_spectrum, build_nodes):
        kept = KeptPicture(build, 400, 380, sharpness=0.5)
        kept.png(_result())
        assert kept.png(_result(with_after=False)) == KeptPicture(build, 400, 380, sharpness=0.5).png(_result(with_after=False))


def test_words_for_the_pictures():
    words = describe_spectrum(_result())
    assert "7 conditional standard deviations" in words
    assert "8, 6, 3 cycles and the others 0.05 to 0.05" in words
    assert "20000 nodes in the median before, 30 after decorrelation" in words
    assert "decorrelation is off" in describe_spectrum(_result(with_after=False))
