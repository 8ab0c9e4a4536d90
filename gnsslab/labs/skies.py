"""One moment's satellites over an open field, for labs that need directions and no recording."""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from gnsslab.gnss.frames import enu_rotation
from gnsslab.simulate import find_preset, prepare_geometry
from gnsslab.simulate.geometry import antenna_position

_SITUATION = replace(find_preset("static-rtk-5km"), duration=1.0, mask_deg=5.0)
_MORNING = "2024-06-24T09:00:00"  # ten GPS satellites are up


@dataclass(frozen=True, eq=False)
class Sky:
    """Satellites, the highest first."""

    names: tuple[str, ...]
    elevation: np.ndarray  # (m,) [rad]
    u: np.ndarray  # (m, 3) unit vectors from the receiver, east, north, up

    def first(self, count):
        """Return the Sky of the `count` highest satellites."""
        return Sky(self.names[:count], self.elevation[:count], self.u[:count])

    def spread(self, count):
        """Return the Sky of `count` satellites spread from the highest to the lowest."""
        chosen = np.linspace(0, len(self.names) - 1, count).round().astype(int)
        return Sky(tuple(self.names[k] for k in chosen), self.elevation[chosen], self.u[chosen])


@lru_cache(16)
def open_sky(systems="G", mask_deg=5.0, start=_MORNING):
    """Return the Sky of all satellites of the systems above the mask [deg], 5 at least, at a GPS time."""
    geometry = prepare_geometry(replace(_SITUATION, systems=systems, start=start))
    place = antenna_position(_SITUATION, 0, np.zeros(1))[0]
    sight = geometry.tracks.position[0] - place
    u = sight / np.linalg.norm(sight, axis=1, keepdims=True) @ enu_rotation(place).T
    elevation = geometry.elevation[0, 0]
    order = np.argsort(-elevation)
    order = order[elevation[order] >= np.radians(mask_deg)]
    return Sky(tuple(geometry.tracks.satellites[k] for k in order), elevation[order], u[order])
