"""Moving base: master and rover measure at instants of their own, and in between the master moves on (paper A, equation 29)."""

from dataclasses import replace

import numpy as np

from gnsslab.gnss.frames import enu_rotation

SIGMA_UNKNOWN = 30.0  # [m/s] on each axis, of a master whose velocity is not known: a car's on a motorway


def at_rover_instants(prepared):
    """Return the Prepared epochs with the master where it was when the rover measured, and the baseline that ends there.

    r_m(t_s) = r_m(t_m) + v_m (t_s - t_m),    b(t_s) = [r_s(t_s) - r_m(t_m)] - v_m (t_s - t_m)

    The brackets hold what two receivers measure, whatever they do afterwards. So the residuals stay as they are and get
    another baseline as their origin; a master moved before they are formed would take the rover along, and the baseline
    between the two would still be that of the brackets. The error left is a (t_s - t_m)^2 / 2 of an acceleration a, and
    that of the velocity, see `shift_covariance`. An unknown velocity shifts nothing.
    Source: Wang, Li, Sun and Ji (2019), equation 29.
    """
    shift = np.nan_to_num(prepared.velocity_master) * _offset(prepared)
    model = replace(prepared.model, near=prepared.model.near - shift)
    return prepared._replace(model=model, master_ecef=prepared.master_ecef + shift)


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
