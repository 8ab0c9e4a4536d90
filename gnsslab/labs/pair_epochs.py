"""Epochs of two receivers at rest, as measurements of the mixed model: double differences about a known baseline."""

from dataclasses import dataclass

import numpy as np

from gnsslab.gnss.differences import difference_operator, pair_receivers
from gnsslab.gnss.frames import enu_rotation
from gnsslab.gnss.modelling import Model, build_model
from gnsslab.gnss.weighting import NoiseModel
from gnsslab.labs.static_pairs import static_pair

LOWEST = np.radians(5.0)  # nothing below is used
FEWEST = 20  # epochs that must have all satellites


@dataclass(frozen=True, eq=False)
class PairModel:
    """What two receivers at rest measured on f carriers of one system, modelled about the baseline that the engine found."""

    model: Model
    R_ne: np.ndarray  # (3, 3), from ECEF to east, north, up
    frequencies: int  # f, that both receivers have


@dataclass(frozen=True, eq=False)
class PairEpochs:
    """T epochs, or means of some consecutive ones, with the same m satellites on f carriers in all of them."""

    y: np.ndarray  # (T, 2 f (m - 1)) [m], double differences: codes first, then carriers, frequency by frequency
    u: np.ndarray  # (1, m, 3) or (T, m, 3) unit vectors to the satellites, east, north, up
    wavelengths: np.ndarray  # (f,) [m]
    integers: np.ndarray  # (f (m - 1),) int [cycles], the true ones, counted from those that the first epoch's codes suggest
    satellites: tuple[str, ...]  # (m,) highest first

    @property
    def elevation(self):
        """Elevations (m,) [rad] in the middle of the span."""
        return np.arcsin(self.u[len(self.u) // 2, :, 2])


def model_pair(base, rover, ephemerides, frequencies):
    """Return the PairModel of two receivers' Observations on up to that many frequencies; ValueError where the rover moves or is not fixed."""
    found = static_pair(base, rover, ephemerides)
    pair = pair_receivers(base, rover, found.pair.satellites[0][0], frequencies)
    T = len(pair.time)
    ends = (np.broadcast_to(end, (T, 3)) for end in (found.master_ecef, found.rover_ecef))
    model = build_model(pair, *ends, ephemerides, LOWEST, NoiseModel(), np.zeros(T, dtype=bool))
    return PairModel(model, enu_rotation(found.master_ecef), len(set(pair.band)))


def choose_epochs(pair_model, satellites, mask, together):
    """Return the PairEpochs of the satellites tracked longest above a mask [rad]; each is a mean over `together` consecutive epochs."""
    model = pair_model.model
    usable, channels = _by_satellite(pair_model, mask)
    longest = np.argsort(-usable.sum(axis=0), kind="stable")
    chosen = longest[: _most_together(usable[:, longest], satellites)]
    rows = np.flatnonzero(usable[:, chosen].all(axis=1))
    if len(rows) < together:
        raise ValueError(f"only {len(rows)} epochs have all {len(chosen)} satellites, fewer than {together}: use fewer epochs together")
    u = -np.nan_to_num(model.design[rows][:, channels[0, chosen]]) @ pair_model.R_ne.T
    order = np.argsort(-u[len(u) // 2, :, 2])
    chosen, u = chosen[order], u[:, order]
    code, phase = (values[rows][:, channels[:, chosen]] for values in (model.code, model.phase))  # (T, f, m)
    wavelengths = model.pair.wavelength[channels[:, chosen[0]]]
    phase -= wavelengths[:, None] * np.rint((phase[0] - code[0]) / wavelengths[:, None])  # receivers count from anywhere: 1e7 m would cost digits
    integers = np.rint(np.median((phase - phase[..., :1]) / wavelengths[:, None], axis=0)).astype(np.int64)  # (f, m)
    D = difference_operator(len(chosen), 0)
    return PairEpochs(
        y=_moving_mean(np.concatenate([_stacked(code @ D.T), _stacked(phase @ D.T)], axis=1), together),
        u=_moving_mean(u, together),
        wavelengths=wavelengths,
        integers=(integers @ D.T.astype(np.int64)).ravel(),
        satellites=tuple(model.pair.satellites[k] for k in chosen),
    )


def _by_satellite(pair_model, mask):
    """Return which satellites (T, s) are above the mask and usable on all carriers, and the channels (f, s) of each, -1 where it lacks one."""
    model, f = pair_model.model, pair_model.frequencies
    channels = np.full((f, len(model.pair.satellites)), -1)
    channels[model.pair.band, model.pair.satellite] = np.arange(len(model.pair.band))
    high = -(model.design @ pair_model.R_ne.T)[..., 2] >= np.sin(mask)
    usable = (model.usable & high)[:, channels].all(axis=1)  # (T, s)
    return usable & (channels >= 0).all(axis=0), channels


def _most_together(usable, wanted):
    """Return how many of the first columns of usable (T, s), `wanted` at most, are True together for long enough."""
    for count in range(min(wanted, usable.shape[1]), 3, -1):
        if usable[:, :count].all(axis=1).sum() >= FEWEST:
            return count
    raise ValueError(f"fewer than four satellites were tracked together for {FEWEST} epochs: lower the mask, or give a longer span of open sky")


def _stacked(values):
    return values.reshape(len(values), -1)


def _moving_mean(values, window):
    """Return the means (T - window + 1, ...) of all consecutive `window` rows.

    >>> _moving_mean(np.array([1.0, 3.0, 8.0]), 2).tolist()
    [2.0, 5.5]
    """
    total = np.cumsum(np.concatenate([np.zeros((1, *values.shape[1:])), values]), axis=0)
    return (total[window:] - total[:-window]) / window
