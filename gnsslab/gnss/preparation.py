"""Preparation: two receivers' observations made ready for a filter, whatever filter it is.

Observations of two receivers -> Pair (common epochs and channels) -> Model (ranges, weights, slips), with the master's place.
"""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from gnsslab.gnss import motion
from gnsslab.gnss.differences import pair_receivers
from gnsslab.gnss.modelling import Model, build_model
from gnsslab.gnss.points import solve_positions
from gnsslab.gnss.signals import USED_SYSTEMS
from gnsslab.gnss.weighting import NoiseModel

_POINT_MASK_DEG = 10.0


@dataclass(frozen=True)
class Settings:
    """What to use and how to weigh it, the same for every kind of relative positioning."""

    systems: str = USED_SYSTEMS
    frequencies: int = 2  # bands of each system, first ones first (signals.BANDS)
    signals: tuple[str, ...] | None = None  # RINEX observation codes such as "C2I", in place of `frequencies`
    mask_deg: float = 15.0
    single_epoch: bool = False  # nothing is carried from one epoch to the next
    noise: NoiseModel = field(default_factory=NoiseModel)
    acceleration: float = 3.0  # [m/s^2 per sqrt(Hz)] of a moving rover, see motion.moving
    acceptance: float = 16.0  # c of `ratio_threshold`


class Prepared(NamedTuple):
    """T common epochs of two receivers, ready for a filter."""

    model: Model
    master_ecef: np.ndarray  # (T, 3) [m], where the master was when it measured


def prepare_moving(master, rover, ephemerides, settings):
    """Return the Prepared epochs of a master that may move itself: its codes place it, at each epoch anew."""
    found = solve_positions(master, ephemerides, systems=settings.systems, mask_deg=min(settings.mask_deg, _POINT_MASK_DEG))
    return prepare(master, rover, without_gaps(found), ephemerides, settings)


def prepare(master, rover, master_ecef, ephemerides, settings):
    """Return the Prepared epochs, given the master's position (T_master, 3) [m] at all of its own epochs.

    Raises ValueError without common epochs or satellites, or where the navigation data are of another day.
    """
    pair = pair_receivers(master, rover, settings.systems, settings.frequencies, settings.signals)
    letters = "".join(sorted({name[0] for name in pair.satellites}))
    found = solve_positions(rover, ephemerides, systems=letters, mask_deg=min(settings.mask_deg, _POINT_MASK_DEG), epochs=pair.epoch)
    master_ecef = master_ecef[pair.epoch_master]
    forgets = np.full(len(pair.time), settings.single_epoch)
    model = build_model(pair, master_ecef, without_gaps(found), ephemerides, np.radians(settings.mask_deg), settings.noise, forgets)
    return Prepared(model, master_ecef)


def path_of(prepared, settings, static=False):
    """Return the Path that the settings assume of the baseline: each epoch alone, at rest, or moving."""
    time, near = prepared.model.pair.time, prepared.model.near
    if settings.single_epoch:
        return motion.forgetful(time, near)
    return motion.static(time, near) if static else motion.moving(time, near, settings.acceleration)


def without_gaps(found):
    """Return single-point positions (T, 3), missing epochs taken from the nearest solved one before, else from the first one."""
    solved = np.isfinite(found.position_ecef[:, 0])
    if not solved.any():
        raise ValueError(f"no position at any epoch: {found.main_reason()}")
    source = np.maximum.accumulate(np.where(solved, np.arange(len(solved)), -1))
    source[source < 0] = np.argmax(solved)
    return found.position_ecef[source]
