"""Preparation: two receivers' observations made ready for a filter, whatever filter it is.

Observations of two receivers -> Pair (common epochs and channels) -> Model (ranges, weights, slips), with the master's place,
its velocity, and how much later the rover measured.
"""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from gnsslab.gnss import motion
from gnsslab.gnss.differences import pair_receivers
from gnsslab.gnss.modelling import Model, build_model
from gnsslab.gnss.moving_base import mean_velocity
from gnsslab.gnss.points import solve_points, solve_positions
from gnsslab.gnss.screening import row_medians
from gnsslab.gnss.signals import SPEED_OF_LIGHT, USED_SYSTEMS
from gnsslab.gnss.times import seconds_between
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
    longest_age: float = 0.0  # [s] of a master epoch that serves a later epoch of the rover; 0: common epochs only
    position_correction: bool = True  # of a moving master, for the time between the receivers' measurements (paper A, equation 29)

    def __post_init__(self):
        for claim, sentence in _claims(self):
            if not claim:
                raise ValueError(sentence)


def _claims(settings):
    """Yield what must be true of Settings, and the sentence to say where it is not."""
    yield settings.frequencies in (1, 2, 3), f"frequencies is how many bands of each system are used, 1, 2 or 3; it is {settings.frequencies!r}"
    is_text = isinstance(settings.signals, str)
    yield not is_text, f'signals are RINEX names one by one, such as ("C1C", "C2W"); they are the text {settings.signals!r}'
    yield 0 <= settings.mask_deg < 90, f"mask_deg is an elevation from 0 to below 90 degrees; it is {settings.mask_deg!r}"
    yield 0 < settings.acceleration < np.inf, f"acceleration is that of the rover, above 0 m/s^2 per sqrt(Hz); it is {settings.acceleration!r}"
    yield settings.acceptance >= 0, f"acceptance is the c of the ratio's threshold 1 + c / n, 0 or more; it is {settings.acceptance!r}"
    yield 0 <= settings.longest_age < np.inf, f"longest_age is 0 s or more of a master's epoch; it is {settings.longest_age!r}"


class Prepared(NamedTuple):
    """T common epochs of two receivers, ready for a filter."""

    model: Model
    master_ecef: np.ndarray  # (T, 3) [m], where the master was when it measured
    time_offset: np.ndarray  # (T,) [s], how much later the rover measured than the master; NaN without a usable code
    velocity_master: np.ndarray  # (T, 3) ECEF [m/s], its mean between the two instants; NaN where not known
    Q_velocity: np.ndarray  # (T, 3, 3) [m^2/s^2], of the master


def prepare_moving(master, rover, ephemerides, settings):
    """Return the Prepared epochs of a master that may move itself: its codes place it, at each epoch anew, its Dopplers tell its velocity."""
    found = solve_points(master, ephemerides, systems=settings.systems, mask_deg=min(settings.mask_deg, _POINT_MASK_DEG))
    prepared = prepare(master, rover, without_gaps(found), ephemerides, settings)
    used = prepared.model.pair.epoch_master
    velocity = mean_velocity(found.time, found.velocity_ecef, used, prepared.time_offset)
    return prepared._replace(velocity_master=velocity, Q_velocity=found.Q_velocity[used])


def prepare(master, rover, master_ecef, ephemerides, settings):
    """Return the Prepared epochs of a master without velocity, given its position (T_master, 3) [m] at all of its own epochs.

    Raises ValueError without common epochs or satellites, or where the navigation data are of another day.
    """
    pair = pair_receivers(master, rover, settings.systems, settings.frequencies, settings.signals, settings.longest_age)
    letters = "".join(sorted({name[0] for name in pair.satellites}))
    found = solve_positions(rover, ephemerides, systems=letters, mask_deg=min(settings.mask_deg, _POINT_MASK_DEG), epochs=pair.epoch)
    master_ecef = master_ecef[pair.epoch_master]
    forgets = np.full(len(pair.time), settings.single_epoch)
    model = build_model(pair, master_ecef, without_gaps(found), ephemerides, np.radians(settings.mask_deg), settings.noise, forgets)
    T = len(pair.time)
    return Prepared(model, master_ecef, time_offset(model), np.zeros((T, 3)), np.zeros((T, 3, 3)))


def time_offset(model):
    """Return t_s - t_m (T,) [s], how much later the rover measured than the master, in true GPS time; NaN without a usable code.

    A receiver stamps t' and measures at t = t' - dt, so t_s - t_m = (t'_s - t'_m) - (dt_s - dt_m). What the codes' difference
    leaves when all is modelled is c (dt_s - dt_m), within metres: 1e-8 s, in which an aircraft flies 3 um.
    """
    pair = model.pair
    clocks_apart = row_medians(np.where(model.usable, model.code, np.nan)) / SPEED_OF_LIGHT
    return seconds_between(pair.time, pair.time_master) - clocks_apart


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
        raise ValueError(f"no position at any epoch: {found.main_reason() or 'there are no epochs'}")
    source = np.maximum.accumulate(np.where(solved, np.arange(len(solved)), -1))
    source[source < 0] = np.argmax(solved)
    return found.position_ecef[source]
