"""Kept pictures: what a move draws equals what a whole draw gives."""

import io
import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from matplotlib import rcParams
from PIL import Image

from gnsslab.figures.kept import KeptPicture, Scene, new_figure, png_bytes


def _build(figure):
    axes = figure.add_axes((0.1, 0.1, 0.8, 0.8))
    (line,) = axes.plot([], [], "o-")

    def show(heights):
        line.set_data(range(len(heights)), heights)
        top = 2 ** np.ceil(np.log2(max(heights)))
        axes.set_xlim(-1, 5)
        axes.set_ylim(0, top)
        return float(top)

    return Scene((line,), show)


def _pixels(png):
    return np.asarray(Image.open(io.BytesIO(png)))


@pytest.mark.parametrize("moves", [([1, 2, 3], [3, 2, 1]), ([1, 2, 3], [1, 2, 9]), ([9, 1], [1, 2, 3], [9, 1])])
def test_moves_leave_nothing_behind(moves):
    kept = KeptPicture(_build, 200, 100)
    for heights in moves:
        moved = kept.png(heights)
    np.testing.assert_array_equal(_pixels(moved), _pixels(KeptPicture(_build, 200, 100).png(moves[-1])))


def test_frame_is_drawn_again_only_when_it_changes(monkeypatch):
    kept, drawn = KeptPicture(_build, 200, 100), []
    whole = kept._draw_background
    monkeypatch.setattr(kept, "_draw_background", lambda: (drawn.append(1), whole()))
    for heights in ([1, 2, 3], [3, 2, 4], [1, 2, 9], [1, 9, 9]):
        kept.png(heights)
    assert len(drawn) == 2


def test_two_sessions_do_not_share_a_picture():
    one, two = KeptPicture(_build, 200, 100), KeptPicture(_build, 200, 100)
    first = one.png([1, 2, 3])
    two.png([3, 1, 1])
    assert one.png([1, 2, 3]) == first


def test_png_is_what_the_canvas_shows():
    figure = new_figure(60, 40)
    figure.add_axes((0, 0, 1, 1)).plot([0, 1], [0, 1])
    figure.canvas.draw()
    np.testing.assert_array_equal(_pixels(png_bytes(figure.canvas)), np.asarray(figure.canvas.buffer_rgba())[:, :, :3])


def test_many_threads_draw_what_one_draws():
    """A class has thirty sessions in the threads of few processes; matplotlib has one style for all of them."""
    alone, style = KeptPicture(_build, 200, 100).png([1, 2, 3]), dict(rcParams)
    switching = sys.getswitchinterval()
    sys.setswitchinterval(1e-5)  # [s], so that threads meet in the middle of a picture
    try:
        with ThreadPoolExecutor(8) as pool:
            drawn = list(pool.map(lambda _: KeptPicture(_build, 200, 100).png([1, 2, 3]), range(32)))
    finally:
        sys.setswitchinterval(switching)
    assert set(drawn) == {alone}
    assert dict(rcParams) == style
