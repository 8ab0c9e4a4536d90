"""Pictures that are kept: axes and background stay, only the artists that changed are drawn again.

Drawing a fresh figure costs most of a slider's move (about 800 ms for two panels). Here the axes, ticks and labels are
drawn once and saved as pixels; a move restores them and draws the few artists on top. Only when the frame changes
(limits, labels) is everything drawn again. A kept picture belongs to one session.
"""

import struct
import threading
import zlib
from collections.abc import Callable
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
from matplotlib import rc_context
from matplotlib.artist import Artist
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

CSS_DPI = 96  # CSS px an inch, by definition
SHARPNESS = 2  # image px a CSS px: sharp on a projector and on a phone

STYLE = {
    "font.family": "DejaVu Sans",
    "font.size": 10,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": "#666666",
    "axes.labelcolor": "#222222",
    "text.color": "#222222",
    "xtick.color": "#444444",
    "ytick.color": "#444444",
    "axes.grid": True,
    "grid.color": "#e2e2e2",
    "grid.linewidth": 0.8,
    "axes.axisbelow": True,
    "legend.frameon": False,
    "path.simplify_threshold": 1.0,
}
_ONE_AT_A_TIME = threading.RLock()


@contextmanager
def styled():
    """Draw in the style of the course, one thread at a time: matplotlib has one style for the whole process, and a class many threads."""
    with _ONE_AT_A_TIME, rc_context(STYLE):
        yield


@dataclass(frozen=True, eq=False)
class Scene:
    """What a picture's build function hands back.

    `show(result)` sets the moving artists and returns the frame: a value that differs whenever anything else
    (limits, labels) has changed.
    """

    moving: tuple[Artist, ...]  # lowest first
    show: Callable


def new_figure(width, height, sharpness=SHARPNESS):
    """Return an empty white Figure of width x height CSS px, with a canvas to draw on and no pyplot behind it."""
    figure = Figure(figsize=(width / CSS_DPI, height / CSS_DPI), dpi=CSS_DPI * sharpness, facecolor="white")
    FigureCanvasAgg(figure)
    return figure


class KeptPicture:
    """A figure that is built once by `build(figure) -> Scene` and then only updated."""

    def __init__(self, build, width, height, sharpness=SHARPNESS):
        with styled():
            self.figure = new_figure(width, height, sharpness)
            self._scene = build(self.figure)
        for artist in self._scene.moving:
            artist.set_animated(True)
        self._frame = self._background = None

    def png(self, result):
        """Return the picture of a result as PNG bytes."""
        with styled():
            self._show(result)
        return png_bytes(self.figure.canvas)

    def _show(self, result):
        frame = self._scene.show(result)
        if self._background is None or frame != self._frame:
            self._draw_background()
            self._frame = frame
        else:
            self.figure.canvas.restore_region(self._background)
        for artist in self._scene.moving:
            artist.axes.draw_artist(artist)

    def _draw_background(self):
        self.figure.canvas.draw()
        self._background = self.figure.canvas.copy_from_bbox(self.figure.bbox)


def png_bytes(canvas):
    """Return a drawn canvas as PNG without alpha, lightly compressed.

    Rows unfiltered, deflate level 1: flat colours need no better, and it takes half the time of Pillow's level 1
    (7 against 18 ms at 1000 x 840 px). Format: W3C, Portable Network Graphics, third edition, sections 5 and 7.
    """
    rgba = np.asarray(canvas.buffer_rgba())
    height, width, _ = rgba.shape
    rows = np.zeros((height, 1 + 3 * width), np.uint8)  # each row starts with its filter type: 0, none
    for color in range(3):  # one at a time: seven times as fast as all three at once
        rows[:, 1 + color :: 3] = rgba[:, :, color]
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)  # 8 bits a channel, colour type 2: RGB
    chunks = ((b"IHDR", header), (b"IDAT", zlib.compress(rows, 1)), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(_chunk(name, data) for name, data in chunks)


def _chunk(name, data):
    return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
