"""Paper A's three solutions of one campaign: direct, with the length, with the length and the position correction; and their errors."""

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from gnsslab.core.rotations import heading_pitch_of, within_half_turn
from gnsslab.gnss.moving_base import at_rover_instants
from gnsslab.gnss.preparation import Prepared, prepare_moving
from gnsslab.simulate import Gap, Slip, draw, find_preset, idealise, instants, observe_drawn, prepare_geometry, true_motion, with_length
from gnsslab.systems.constrained_filter import direct_path, run_filter, steady_path
from gnsslab.systems.dual_antenna import A_STATIC, A_TURNTABLE, angle_sigmas
from gnsslab.systems.length_row import LengthUse
from gnsslab.systems.printed_attitude import pitch_as_printed, sigma_heading_as_printed, sigma_pitch_as_printed

KEPT_GEOMETRIES, KEPT_CAMPAIGNS, KEPT_RUNS = 4, 6, 24
SYSTEMS = {"static": A_STATIC, "turntable": A_TURNTABLE}
MODES = ("direct", "length", "position")  # the last with the length and the position correction (29)
SETTLED = 100  # [s], errors count from here on: the first fix has come by then, as in the paper's figures
MM, CM = 1e-3, 1e-2


@dataclass(frozen=True)
class Scene:
    """What stands or turns, and when its receivers measure: all that is known before any noise."""

    name: str  # of SYSTEMS
    length: float  # [m]
    pitch_deg: float
    rate_deg_s: float  # of the turntable
    missing: int  # epochs of the master, from the preset's gap on
    late: float  # [s], how much later than the master the rover measures


@dataclass(frozen=True, eq=False)
class Campaign:
    """One scene, measured: T epochs of two receivers, ready for the filters, and the truth at the rover's instants."""

    prepared: Prepared
    corrected: Prepared  # by equation (29)
    seconds: np.ndarray  # (T,) [s], of the rover's tags since the start
    truth: np.ndarray  # (T, 3) [m] east, north, up
    lost: tuple  # [s], when every satellite loses lock
    missing: np.ndarray  # (k,) [s], at which the master has no epoch


class Solution(NamedTuple):
    """One mode's baselines and what is wrong with them; NaN where the filter has none."""

    baseline: np.ndarray  # (T, 3) [m] east, north, up
    length: np.ndarray  # (T,) [m]
    heading_error: np.ndarray  # (T,) [deg]
    pitch_error: np.ndarray  # (T,) [deg]
    sigma_heading: np.ndarray  # (T,) [deg], as claimed
    sigma_pitch: np.ndarray  # (T,) [deg]
    is_fixed: np.ndarray  # (T,) bool


class FilterModes:
    """Campaigns and filter runs of one lab instance, kept by all that they depend on."""

    def __init__(self):
        self._ideal = lru_cache(KEPT_GEOMETRIES)(_without_noise)
        self.campaign = lru_cache(KEPT_CAMPAIGNS)(self._measure)
        self._run = lru_cache(KEPT_RUNS)(_run)

    def _measure(self, scene, multipath, doppler, seed):
        """Return the Campaign of a Scene with carrier multipath [m] and Doppler noise [m/s]: 0.1 s, most of it for the preparation."""
        geometry, ideals = self._ideal(scene)
        preset, system = geometry.preset, SYSTEMS[scene.name]
        noise = replace(preset.noise, carrier_multipath=multipath, doppler=doppler)
        simulation = observe_drawn(geometry, ideals, draw(geometry, np.random.default_rng(seed)), noise)
        settings = replace(system.settings, longest_age=float(max(scene.missing, 1)))
        prepared = prepare_moving(*simulation.observations, simulation.ephemerides, settings)
        epoch = prepared.model.pair.epoch
        truth = true_motion(preset, instants(preset, 1)).baselines_enu[0, epoch]
        lost = tuple(event.epoch for event in preset.events if isinstance(event, Slip))
        gaps = [np.arange(event.first, event.last + 1) for event in preset.events if isinstance(event, Gap)]
        return Campaign(prepared, at_rover_instants(prepared), epoch * preset.interval, truth, lost, np.concatenate([np.zeros(0, int), *gaps]))

    def solve(self, campaign, velocity_noise, settings, printed):
        """Return the Solution of each of MODES, angles and their sigma by the printed equation where it is one of (6), (33), (34).

        `velocity_noise` [m/s per sqrt(s)] east and north, a third of it up; `settings` are FilterSettings.
        """
        runs = {mode: self._run(campaign, mode, 0.0 if mode == "direct" else velocity_noise, _of_mode(mode, settings)) for mode in MODES}
        return {mode: _solution(run, campaign.truth, settings.length, printed) for mode, run in runs.items()}


def _without_noise(scene):
    """Return the Geometry of a Scene and its ideal measurements."""
    geometry = prepare_geometry(_preset(scene))
    return geometry, idealise(geometry)


def _preset(scene):
    """Return the paper's preset, changed as the Scene says."""
    preset = with_length(find_preset(SYSTEMS[scene.name].preset), scene.length)
    trajectory = replace(preset.trajectory, pitch_deg=scene.pitch_deg)
    if scene.name == "static":
        return replace(preset, trajectory=trajectory)
    master, rover = preset.clocks
    return replace(
        preset,
        trajectory=replace(trajectory, rate_deg_s=scene.rate_deg_s),
        clocks=(master, replace(rover, offset=rover.offset - scene.late)),
        events=tuple(event for event in (_as_long(event, scene.missing) for event in preset.events) if event),
    )


def _as_long(event, missing):
    """Return an event, a gap made as long as that many epochs; None where that is none."""
    if not isinstance(event, Gap):
        return event
    return replace(event, last=event.first + missing - 1) if missing else None


def _of_mode(mode, settings):
    """Return the FilterSettings of a mode: direct has no length, and all that concerns one is left as it is, so that runs are found again."""
    return replace(settings, length_use=LengthUse.NOWHERE, length=1.0, length_sigma=1.0) if mode == "direct" else settings


def _run(campaign, mode, velocity_noise, settings):
    prepared = campaign.corrected if mode == "position" else campaign.prepared
    path = direct_path(prepared) if mode == "direct" else steady_path(prepared, velocity_noise * np.array([1, 1, 1 / 3]))
    return run_filter(prepared, path, settings)


def _solution(run, truth, length, printed):
    heading, pitch = heading_pitch_of(run.baseline)
    sigma_heading, sigma_pitch = angle_sigmas(run.baseline, run.Q)
    with np.errstate(invalid="ignore"):  # where the filter has broken down
        sigma_enu = np.sqrt(np.diagonal(run.Q, axis1=-2, axis2=-1))
    if printed == "33":
        sigma_heading = sigma_heading_as_printed(heading, pitch, length, sigma_enu)
    if printed == "34":
        sigma_pitch = sigma_pitch_as_printed(heading, pitch, length, sigma_enu)
    if printed == "6":
        with np.errstate(invalid="ignore"):  # above 45 degrees it has no answer
            pitch = pitch_as_printed(run.baseline)
    true_heading, true_pitch = heading_pitch_of(truth)
    return Solution(
        baseline=run.baseline, length=np.linalg.norm(run.baseline, axis=-1),
        heading_error=np.degrees(within_half_turn(heading - true_heading)), pitch_error=np.degrees(pitch - true_pitch),
        sigma_heading=np.degrees(sigma_heading), sigma_pitch=np.degrees(sigma_pitch), is_fixed=run.is_fixed,
    )  # fmt: skip


def rms(values):
    """Return the root mean square of the finite ones, NaN without any.

    >>> round(rms(np.array([3.0, np.nan, 4.0])) ** 2, 9)
    12.5
    """
    finite = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(finite**2))) if finite.size else float("nan")
