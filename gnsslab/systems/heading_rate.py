"""Heading rate from two antennas: how fast the heading turns, from epoch to epoch, and how well that is known."""

from typing import NamedTuple

import numpy as np

from gnsslab.core.rotations import within_half_turn
from gnsslab.gnss.relative import Status
from gnsslab.gnss.times import seconds_between, usual_step
from gnsslab.gnss.weighting import NoiseModel

_LONGEST_STEP = 1.5  # usual steps: after a longer one nobody knows how often the body has turned meanwhile


class HeadingRate(NamedTuple):
    """Mean rates of turn since the epoch before, at T epochs; NaN at the first one and after a gap."""

    rate: np.ndarray  # (T,) [rad/s], clockwise positive
    sigma: np.ndarray  # (T,) [rad/s]


def heading_rate(attitude, noise=None):
    """Return the HeadingRate of an Attitude: r = (psi_t - psi_t-1) / dt, by the shorter way round.

    sigma_r^2 dt^2 = (sigma_t - sigma_t-1)^2 + 2 (1 - rho) sigma_t sigma_t-1,   rho = s exp(-dt / tau)

    A share s of the carrier's variance is multipath that lasts for tau, and cancels for the most part; `noise` is the NoiseModel
    with both (its own values if none is given). Only fixed epochs have errors that are those of their own carriers; between
    others rho is taken as 0, which is too much rather than too little. The rate is that of the middle of the step.

    >>> from types import SimpleNamespace
    >>> time = np.datetime64("2024-01-01", "ns") + np.arange(3) * np.timedelta64(1, "s")
    >>> fixed = np.full(3, Status.FIXED)
    >>> turning = SimpleNamespace(time=time, status=fixed, heading=np.radians([358.0, 1.0, 4.0]), sigma_heading=np.radians([0.2, 0.2, 0.2]))
    >>> np.degrees(heading_rate(turning)).round(3).tolist()
    [[nan, 3.0, 3.0], [nan, 0.145, 0.145]]
    """
    noise = noise or NoiseModel()
    dt, before = _steps(attitude.time), slice(None, -1)
    turned = within_half_turn(np.diff(attitude.heading))
    both_fixed = (attitude.status[1:] == Status.FIXED) & (attitude.status[before] == Status.FIXED)
    rho = np.where(both_fixed, noise.correlated_share * np.exp(-dt / noise.correlation_time), 0.0)
    sigma, sigma_before = attitude.sigma_heading[1:], attitude.sigma_heading[before]
    variance = (sigma - sigma_before) ** 2 + 2 * (1 - rho) * sigma * sigma_before
    return HeadingRate(*(np.concatenate([[np.nan], values / dt]) for values in (turned, np.sqrt(variance))))


def _steps(time):
    """Return the steps (T - 1,) [s] between epochs, NaN where there is a gap."""
    dt = seconds_between(time[1:], time[:-1])
    return np.where(dt > _LONGEST_STEP * usual_step(time), np.nan, dt)
