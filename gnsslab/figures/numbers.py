"""Many small numbers in one picture, drawn as two paths: a text of its own for each would cost a tenth of a second a hundred."""

from functools import lru_cache

import numpy as np
from matplotlib.font_manager import FontProperties
from matplotlib.patches import PathPatch
from matplotlib.path import Path
from matplotlib.textpath import TextPath

_FONT = FontProperties(family="DejaVu Sans")
_SIZE = 100.0  # at which outlines are kept
_CAP_HEIGHT = 73.0  # of a digit at that size
_NOTHING = Path(np.zeros((1, 2)), [Path.MOVETO])


class NumberPaths:
    """Numbers centred on places in an axes, dark ones and light ones."""

    def __init__(self, axes):
        self._axes = axes
        self.dark, self.light = (axes.add_patch(PathPatch(_NOTHING, facecolor=color, edgecolor="none")) for color in ("#222222", "white"))

    @property
    def moving(self):
        """The artists that change, lowest first."""
        return (self.dark, self.light)

    def show(self, texts, places, is_light, height):
        """Write texts centred on places (k, 2), `height` in the axes' vertical unit; `is_light` (k,) chooses white."""
        self.dark.set_path(_outlines(texts, places, ~np.asarray(is_light), height))
        self.light.set_path(_outlines(texts, places, np.asarray(is_light), height))


def _outlines(texts, places, chosen, height):
    """Return one path of all chosen texts."""
    parts = [(_outline(text), place) for text, place, is_chosen in zip(texts, places, chosen, strict=True) if is_chosen]
    if not parts:
        return _NOTHING
    vertices = np.concatenate([path.vertices * (height / _CAP_HEIGHT) + place for path, place in parts])
    return Path(vertices, np.concatenate([path.codes for path, _ in parts]))


@lru_cache(4096)
def _outline(text):
    """Return a text's outline about its own middle."""
    path = TextPath((0, 0), text, size=_SIZE, prop=_FONT)
    box = path.get_extents()
    return Path(path.vertices - [(box.x0 + box.x1) / 2, _CAP_HEIGHT / 2], path.codes)
