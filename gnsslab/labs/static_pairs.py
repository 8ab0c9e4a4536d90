"""Two receivers at rest, from files: what they measured together, and where the engine says they stand."""

from dataclasses import dataclass

import numpy as np

from gnsslab.gnss.differences import Pair, pair_receivers
from gnsslab.gnss.ephemerides import Ephemerides
from gnsslab.gnss.relative import Status, solve_relative, station_position
from gnsslab.gnss.signals import USED_SYSTEMS

_AT_REST = 0.2  # [m]: fixed baselines of receivers at rest scatter less, multipath included
_FEWEST_FIXED = 10  # epochs


@dataclass(frozen=True, eq=False)
class StaticPair:
    """One carrier of one system, measured by two receivers at rest."""

    pair: Pair
    ephemerides: Ephemerides
    master_ecef: np.ndarray  # (3,) [m]
    rover_ecef: np.ndarray  # (3,) [m], the master's plus the median of the fixed baselines

    @property
    def length(self):
        """The baseline's length [m]."""
        return float(np.linalg.norm(self.rover_ecef - self.master_ecef))


def static_pair(base, rover, ephemerides):
    """Return the StaticPair of two receivers' Observations: first frequency, of the first system (GPS if it is there) that both have.

    The baseline comes from the engine, fixed with two frequencies. Raises ValueError where the rover moves, or where
    too few epochs are fixed to say where it stands.
    """
    system = next((letter for letter in USED_SYSTEMS if letter in base.tables and letter in rover.tables), "G")
    master_ecef = station_position(base, ephemerides)
    relative = solve_relative(base, rover, ephemerides, base_position=master_ecef, systems=system)
    fixed = relative.baseline_ecef[relative.status == Status.FIXED]
    _refuse_unknown(fixed)
    return StaticPair(pair_receivers(base, rover, system, 1), ephemerides, master_ecef, master_ecef + np.median(fixed, axis=0))


def _refuse_unknown(fixed):
    """Refuse fixed baselines (F, 3) that are too few, or that move."""
    if len(fixed) < _FEWEST_FIXED:
        raise ValueError(f"only {len(fixed)} epochs could be fixed, so where the rover stands is not known; give ten minutes of open sky")
    apart = np.quantile(np.linalg.norm(fixed - np.median(fixed, axis=0), axis=1), 0.9)
    if apart > _AT_REST:
        raise ValueError(f"the rover moves (by {apart:.1f} m): this lab needs two receivers that stand still")
