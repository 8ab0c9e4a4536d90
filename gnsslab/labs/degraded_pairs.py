"""Two receivers' epochs made worse on purpose: satellites taken away, multipath added, ready for a filter as before."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from gnsslab.gnss.ephemerides import Ephemerides
from gnsslab.gnss.frames import enu_rotation
from gnsslab.gnss.moving_base import at_rover_instants
from gnsslab.gnss.observations import Observations
from gnsslab.gnss.preparation import Prepared, Settings, prepare_moving
from gnsslab.gnss.times import seconds_between, usual_step
from gnsslab.simulate.receivers import gauss_markov, multipath_factor

FEWEST = 4  # satellites
OFTEN = 0.5  # share of the epochs at which a satellite must be used to be counted
MULTIPATH_TIME = 30.0  # [s], correlation time of added multipath: antennas at rest, satellites that move
CARRIER_SHARE = 0.005  # multipath of the carrier over that of the code: a quarter of a cycle at most, against tens of metres


@dataclass(frozen=True, eq=False)
class KnownPair:
    """Observations of two receivers at rest, what is between them, and what a filter assumes of their noise."""

    master: Observations
    rover: Observations
    ephemerides: Ephemerides
    baseline: np.ndarray  # (3,) [m] east, north, up, the true one
    settings: Settings  # of the filter

    @property
    def length(self):
        """The true length [m]."""
        return float(np.linalg.norm(self.baseline))


@dataclass(frozen=True, eq=False)
class PreparedPair:
    """Epochs ready for a filter, the settings they were prepared with, and the satellites in them, highest first."""

    prepared: Prepared
    settings: Settings

    @cached_property
    def elevation(self):
        """Elevations (T, c) [rad] of all channels, NaN where one was not measured."""
        R_ne, model = enu_rotation(self.prepared.master_ecef), self.prepared.model
        up = -np.einsum("ti,tci->tc", R_ne[:, 2], model.design)
        return np.arcsin(np.where(model.usable, np.clip(up, -1, 1), np.nan))

    @cached_property
    def order(self):
        """Indices of the satellites that were used at half the epochs at least, highest first."""
        pair, usable = self.prepared.model.pair, self.prepared.model.usable
        height = {}
        for channel in np.flatnonzero(usable.mean(axis=0) >= OFTEN):
            height.setdefault(int(pair.satellite[channel]), float(np.nanmedian(self.elevation[:, channel])))
        return sorted(height, key=height.get, reverse=True)

    @property
    def satellites(self):
        """Their names."""
        return tuple(self.prepared.model.pair.satellites[index] for index in self.order)


def prepare_pair(known, settings):
    """Return the PreparedPair of a KnownPair; ValueError with fewer than four satellites."""
    pair = PreparedPair(prepare_moving(known.master, known.rover, known.ephemerides, settings), settings)
    if len(pair.order) < FEWEST:
        raise ValueError(f"only {len(pair.order)} satellites were used at half the epochs, and {FEWEST} are needed: take more systems")
    return pair


def at_rover(pair):
    """Return the PreparedPair with baselines at the rover's instants (paper A, equation 29)."""
    return replace(pair, prepared=at_rover_instants(pair.prepared))


def keep_satellites(pair, kept):
    """Return the PreparedPair with some of its satellites only, indices `kept` into their names."""
    model = pair.prepared.model
    stays = model.usable & np.isin(model.pair.satellite, kept)
    return with_model(pair, replace(model, usable=stays, slip=model.slip & stays))


def add_multipath(pair, sigma, rng):
    """Return the PreparedPair with multipath added to the rover's measurements: sigma [m] in the zenith for codes, a 200th for carriers.

    A Gauss-Markov series of 30 s for each channel and kind, growing as 1 / sin(elevation). It is added to the differences, of
    which the rover's measurements are a part; slips have been looked for before.
    """
    model = pair.prepared.model
    white = rng.standard_normal((2, *model.code.shape, 1))
    series = gauss_markov(white, usual_step(model.pair.time), MULTIPATH_TIME)[..., 0]
    code, phase = sigma * multipath_factor(np.nan_to_num(pair.elevation, nan=np.pi / 2)) * series
    return with_model(pair, replace(model, code=model.code + code, phase=model.phase + CARRIER_SHARE * phase))


def seconds_of(pair):
    """Return the epochs' times (T,) [s] since the first."""
    time = pair.prepared.model.pair.time
    return seconds_between(time, time[:1])


def with_model(pair, model):
    """Return the PreparedPair with another Model of the same epochs."""
    return replace(pair, prepared=pair.prepared._replace(model=model))
