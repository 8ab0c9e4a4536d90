"""Attitude from two antennas (paper A: Wang, Li, Sun and Ji 2019): heading and pitch of the baseline between them, with their sigma.

The equations are those of the paper with its misprints mended: (5), (6) angles from the baseline, (33), (34) their sigma.
"""

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from gnsslab.core.rotations import heading_pitch_of
from gnsslab.gnss.preparation import Settings
from gnsslab.gnss.relative import Status, solve_moving
from gnsslab.gnss.weighting import NoiseModel
from gnsslab.systems.constrained_filter import FilterSettings
from gnsslab.systems.length_check import checked_by_length
from gnsslab.systems.length_row import SURE


@dataclass(frozen=True)
class PublishedSystem:
    """A dual-antenna system as its paper describes it: what it was tried on, and how its filter (`constrained_filter`) was set."""

    preset: str  # of gnsslab.simulate: truth and noise
    settings: Settings  # of gnss.preparation: satellites and weights
    velocity_noise: tuple[float, float, float]  # [m/s per sqrt(s)] east, north, up
    filter: FilterSettings


_SIGMA_PHASE, _SIGMA_CODE = 0.0081, 2.4  # [m] in the zenith, undifferenced: 1.5 times the carrier's true noise, 3 times the code's
A_STATIC = PublishedSystem(
    preset="paper-a-static",
    settings=Settings(
        systems="GC", frequencies=1, longest_age=1.0,
        noise=NoiseModel(_SIGMA_PHASE / 2**0.5, _SIGMA_PHASE / 2**0.5, _SIGMA_CODE / _SIGMA_PHASE, correlated_share=0.0),
    ),
    velocity_noise=(0.02, 0.02, 0.02 / 3),
    filter=FilterSettings(),
)  # fmt: skip
A_TURNTABLE = replace(A_STATIC, preset="paper-a-turntable", velocity_noise=(0.03, 0.03, 0.01))


@dataclass(frozen=True, eq=False)
class Attitude:
    """Heading and pitch of a two-antenna baseline over T epochs of the rover; NaN where there is no solution."""

    time: np.ndarray  # (T,) datetime64[ns], GPS time
    status: np.ndarray  # (T,) int8 of gnss.relative.Status
    heading: np.ndarray  # (T,) [rad], clockwise from north, 0 to 2 pi
    pitch: np.ndarray  # (T,) [rad], up positive
    length: np.ndarray  # (T,) [m]
    baseline_enu: np.ndarray  # (T, 3) [m], master to rover
    Q_enu: np.ndarray  # (T, 3, 3) [m^2]
    sigma_heading: np.ndarray  # (T,) [rad]
    sigma_pitch: np.ndarray  # (T,) [rad]
    ratio: np.ndarray  # (T,) second best over best squared norm of the integer search
    satellites: np.ndarray  # (T,) int, used
    warnings: tuple[str, ...] = ()  # what there is to say about the known length, in words

    def __repr__(self):
        fixed, floats = (int((self.status == status).sum()) for status in (Status.FIXED, Status.FLOAT))
        if not fixed + floats:
            return f"Attitude: {len(self.time)} epochs, none solved"
        sigma_deg = np.degrees(np.nanmedian(self.sigma_heading[self.status == (Status.FIXED if fixed else Status.FLOAT)]))
        return f"Attitude: {len(self.time)} epochs, {fixed} fixed, {floats} float; sigma heading {sigma_deg:.2g} deg"


def dual_antenna_attitude(master, rover, ephemerides, *, length=None, length_sigma=0.005, mount_heading=0.0, progress=None, **settings):
    """Return the Attitude of the baseline from the master's antenna to the rover's, both of which may move.

    heading = atan2(e, n) - mount heading,   pitch = atan2(u, hypot(e, n))

    `length` [m], with `length_sigma` [m], is the known distance between the antennas. It takes part in the search for the integers
    (`gnss.known_length`), and once they are known it is one more measurement of the baseline;
    `mount_heading` [rad] is where the baseline points when the vehicle heads north. `settings` are those of
    `gnss.preparation.Settings`: systems, frequencies or signals, mask_deg, single_epoch...
    A fixed epoch that the length contradicts becomes float, its baseline as measured: either its integers are wrong or the tape is.
    Where the length fits badly, or leaves most epochs float, `Attitude.warnings` says so.
    Raises ValueError without common epochs or satellites, for a length, sigma or mount heading that makes no sense, or where most fixed epochs
    agree on another length (`systems.length_check`).
    """
    _check(length, length_sigma, mount_heading)
    solve = partial(solve_moving, master, rover, ephemerides, **settings)
    if length is None:
        return _attitude(solve(progress=progress), mount_heading)
    found = solve(length=length, length_sigma=length_sigma, progress=progress)
    relative, warnings = checked_by_length(found, length, length_sigma, solve)
    fits = (relative.status == found.status)[:, None]
    b_known, Q_known = with_known_length(found.baseline_enu, found.Q_enu, length, length_sigma)
    baseline, Q = np.where(fits, b_known, found.baseline_enu), np.where(fits[..., None], Q_known, found.Q_enu)
    return _attitude(replace(relative, baseline_enu=baseline, Q_enu=Q), mount_heading, warnings)


def _attitude(relative, mount_heading, warnings=()):
    """Return the Attitude that a Relative tells."""
    heading, pitch = heading_pitch_of(relative.baseline_enu)
    sigma_heading, sigma_pitch = angle_sigmas(relative.baseline_enu, relative.Q_enu)
    return Attitude(
        time=relative.time,
        status=relative.status,
        heading=(heading - mount_heading) % (2 * np.pi),
        pitch=pitch,
        length=np.linalg.norm(relative.baseline_enu, axis=-1),
        baseline_enu=relative.baseline_enu,
        Q_enu=relative.Q_enu,
        sigma_heading=sigma_heading,
        sigma_pitch=sigma_pitch,
        ratio=relative.ratio,
        satellites=relative.satellites,
        warnings=warnings,
    )


def angle_sigmas(baseline_enu, Q_enu):
    """Return the standard deviations [rad] of heading and pitch of baselines (..., 3) [m] with covariance (..., 3, 3) [m^2].

    sigma_psi^2 = g' Q g with g = (cos psi, -sin psi, 0) / (l cos theta);
    sigma_theta^2 = h' Q h with h = (-sin theta sin psi, -sin theta cos psi, cos theta) / l   (paper A, (33) and (34) mended).

    >>> l, psi, theta = 1.167, np.radians(50), np.radians(25)
    >>> b = l * np.array([np.cos(theta) * np.sin(psi), np.cos(theta) * np.cos(psi), np.sin(theta)])
    >>> [round(float(np.degrees(s)), 3) for s in angle_sigmas(b, np.diag([0.006, 0.009, 0.016]) ** 2)]
    [0.428, 0.728]
    """
    e, n, u = np.moveaxis(np.asarray(baseline_enu, dtype=float), -1, 0)
    across, length = np.hypot(e, n), np.linalg.norm(baseline_enu, axis=-1)
    with np.errstate(divide="ignore", invalid="ignore"):
        g = np.stack([n, -e, 0 * u], axis=-1) / across[..., None] ** 2
        h = np.stack([-u * e / across, -u * n / across, across], axis=-1) / length[..., None] ** 2
    return tuple(np.sqrt(np.einsum("...i,...ij,...j->...", k, Q_enu, k)) for k in (g, h))


def with_known_length(baseline, Q, length, length_sigma):
    """Return baselines (..., 3) and covariances (..., 3, 3) after the pseudo-observation |b| = length [m] (paper A, (14), mended (16), (32)).

    z = l - |b|,  H = b' / |b|,  R = sigma^2. Where the baseline is not known better than a tenth of its length the linearised
    row would point anywhere (the paper's guard: tr Q / 3 < (0.1 l)^2), and the epoch stays as it is.

    >>> b, Q = with_known_length(np.array([0.0, 1.01, 0.0]), np.diag([1e-4, 1e-4, 1e-4]), 1.0, 0.005)
    >>> b.round(4).tolist(), round(float(Q[1, 1]) ** 0.5, 5)
    ([0.0, 1.002, 0.0], 0.00447)
    """
    norm = np.linalg.norm(baseline, axis=-1, keepdims=True)
    with np.errstate(divide="ignore", invalid="ignore"):
        H = baseline / norm
        QH = np.einsum("...ij,...j->...i", Q, H)
        gain = QH / (np.einsum("...i,...i->...", H, QH) + length_sigma**2)[..., None]
        sure = np.trace(Q, axis1=-2, axis2=-1) / 3 < (SURE * length) ** 2
    updated = baseline + gain * (length - norm)
    Q_updated = Q - gain[..., None] * QH[..., None, :]
    return np.where(sure[..., None], updated, baseline), np.where(sure[..., None, None], Q_updated, Q)


def _check(length, length_sigma, mount_heading):
    if length is not None and not 0 < length < np.inf:
        raise ValueError(f"the length between the antennas must be more than 0 m, not {length:g}; leave it out if it is not known")
    if not 0 < length_sigma < np.inf:
        raise ValueError(f"the sigma of the length must be more than 0 m, not {length_sigma:g}; 0.005 is a good tape measure")
    if not np.isfinite(mount_heading):
        raise ValueError(f"the mount heading must be an angle in radians, not {mount_heading:g}")
