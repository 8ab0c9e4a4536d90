"""Moving base: master and rover measure at instants of their own, and in between the master moves on (paper A, equation 29)."""

from dataclasses import replace

import numpy as np

from gnsslab.gnss.frames import enu_rotation
from gnsslab.gnss.times import seconds_between

SIGMA_UNKNOWN = 30.0  # [m/s] on each axis, of a master whose velocity is not known: a car's on a motorway


def at_rover_instants(prepared):
    """Return the Prepared epochs with the master where it was when the rover measured, and the baseline that ends there.

    r_m(t_s) = r_m(t_m) + v_m (t_s - t_m),    b(t_s) = [r_s(t_s) - r_m(t_m)] - v_m (t_s - t_m)

    The brackets hold what two receivers measure, whatever they do afterwards. So the residuals stay as they are and get
    another baseline as their origin; a master moved before they are formed would take the rover along, and the baseline
    between the two would still be that of the brackets. With the velocity's mean between the instants, as here, a steady
    acceleration is right too; the paper's, that of t_m, leaves a (t_s - t_m)^2 / 2. An unknown velocity shifts nothing.
    Source: Wang, Li, Sun and Ji (2019), equation 29.
    """
    shift = np.nan_to_num(prepared.velocity_master) * _offset(prepared)
    model = replace(prepared.model, near=prepared.model.near - shift)
    return prepared._replace(model=model, master_ecef=prepared.master_ecef + shift)


def mean_velocity(time, velocity, epoch, time_offset):
    """Return a receiver's mean velocity (T, 3) [m/s] from some of its epochs to `time_offset` (T,) [s] later: v + a (t_s - t_m) / 2.

    `velocity` (T_all, 3) [m/s] belongs to its tags `time` (T_all,), whose differences give the acceleration a; `epoch` (T,) picks.
    NaN where the epoch itself has no velocity.

    >>> time = np.datetime64("2024-01-01", "ns") + np.arange(2) * np.timedelta64(1, "s")
    >>> mean_velocity(time, np.array([[10.0, 0, 0], [14.0, 0, 0]]), np.array([0]), np.array([0.5])).tolist()
    [[11.0, 0.0, 0.0]]
    """
    known = np.flatnonzero(np.isfinite(velocity[:, 0]))
    acceleration = np.zeros_like(velocity)
    if len(known) > 1:
        acceleration[known] = np.gradient(velocity[known], seconds_between(time[known], time[0]), axis=0)
    return velocity[epoch] + acceleration[epoch] * np.nan_to_num(time_offset)[:, None] / 2


def shift_covariance(prepared):
    """Return what the velocity's error adds to the covariance of the baseline (T, 3, 3) [m^2], axes at the master: (t_s - t_m)^2 Q_v.

    A velocity that is not known is zero with a sigma of 30 m/s: a microsecond makes that 0.03 mm, a millisecond 3 cm.
    """
    is_known = np.isfinite(prepared.velocity_master[:, :1, None])
    Q_velocity = np.where(is_known, prepared.Q_velocity, SIGMA_UNKNOWN**2 * np.eye(3))
    R_ne = enu_rotation(prepared.master_ecef)
    return _offset(prepared)[..., None] ** 2 * (R_ne @ Q_velocity @ R_ne.swapaxes(-1, -2))


def _offset(prepared):
    """Return the time offset (T, 1) [s], 0 where nothing could be measured at all."""
    return np.nan_to_num(prepared.time_offset)[:, None]
