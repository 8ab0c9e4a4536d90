"""Simulations: a preset and random numbers in, observations, ephemerides and the truth out; and the files of them."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gnsslab.gnss import rinex
from gnsslab.gnss.ephemerides import Ephemerides
from gnsslab.gnss.frames import enu_rotation
from gnsslab.gnss.observations import Observations
from gnsslab.gnss.times import add_seconds, iso_text
from gnsslab.simulate.geometry import antenna_position, prepare_geometry
from gnsslab.simulate.measurements import disturb, draw, idealise
from gnsslab.simulate.recording import record

TRUTH_COLUMNS = "time,east_m,north_m,up_m,heading_deg,pitch_deg,roll_deg"


@dataclass(frozen=True, eq=False)
class Truth:
    """What really was, at T GPS times (in a `Simulation` those of the receivers' tags): the preset alone decides it."""

    time: np.ndarray  # (T,) datetime64[ns]
    baselines_enu: np.ndarray  # (R - 1, T, 3) [m], from master to each other antenna, axes at the master
    heading: np.ndarray  # (T,) [rad] in [0, 2 pi), of the body
    pitch: np.ndarray  # (T,) [rad]
    roll: np.ndarray  # (T,) [rad]
    position_ecef: np.ndarray  # (T, 3) [m], of the master


@dataclass(frozen=True, eq=False)
class Simulation:
    """Everything of one simulated campaign: R receivers over T epochs."""

    preset: str
    observations: tuple[Observations, ...]  # (R,) master first
    ephemerides: Ephemerides
    truth: Truth
    satellites: dict[str, tuple[str, ...]]  # system letter -> m names
    signals: dict[str, tuple[str, ...]]  # system letter -> b names
    integers: dict[str, np.ndarray]  # system letter -> (R, T, m, b) int64, the true ambiguities [cycles], slips included

    def __repr__(self):
        count = sum(len(names) for names in self.satellites.values())
        return f"Simulation: {self.preset}, {len(self.observations)} receivers, {len(self.truth.time)} epochs, {count} satellites"


def simulate(preset, rng):
    """Simulate a preset with random numbers from `rng`, a numpy Generator; the same preset and seed give the same data.

    >>> from gnsslab.simulate import find_preset
    >>> simulate(find_preset("static-baseline"), np.random.default_rng(1)).truth.baselines_enu.shape
    (1, 300, 3)
    """
    return observe(prepare_geometry(preset), preset.noise, rng)


def observe(geometry, noise, rng):
    """Return the `Simulation` of a geometry already prepared, with this noise: for what is run again and again."""
    return observe_drawn(geometry, idealise(geometry), draw(geometry, rng), noise)


def observe_drawn(geometry, ideals, draws, noise):
    """Return the `Simulation` of a geometry, its ideal measurements and the errors drawn, as large as `noise` has them.

    For a slider of noise: all else is ready. `draws` may be of more systems than the geometry, with the same satellites.
    """
    preset = geometry.preset
    measured = disturb(ideals, draws, noise)
    return Simulation(
        preset.name,
        tuple(record(preset, measured, receiver) for receiver in range(preset.receivers)),
        geometry.tracks.ephemerides,
        true_motion(preset, np.arange(preset.epochs) * preset.interval),
        {system: one.satellites for system, one in measured.items()},
        {system: one.signals for system, one in measured.items()},
        {system: one.integers for system, one in measured.items()},
    )


def true_motion(preset, seconds):
    """Return the `Truth` of a preset at GPS times (T,) [s] after its start, for instance at the `instants` of a receiver with a bad clock."""
    pose = preset.trajectory.at(seconds)
    master, *others = (antenna_position(preset, receiver, seconds) for receiver in range(preset.receivers))
    R_ne = enu_rotation(master)
    baselines = np.stack([np.matvec(R_ne, other - master) for other in others])
    return Truth(
        add_seconds(np.datetime64(preset.start, "ns"), seconds), baselines, pose.heading % (2 * np.pi), pose.pitch, pose.roll, np.array(master)
    )


def write_simulation(folder, simulation):
    """Write master.obs, rover.obs (antenna3.obs, antenna4.obs), broadcast.nav and truth.csv into a folder, made if need be; return the paths."""
    folder = Path(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        return _write_files(folder, simulation)
    except OSError as error:
        reason = error.strerror or error
        raise ValueError(f"the simulation cannot be written to {folder}: {reason}; choose a folder that can be written") from None


def _write_files(folder, simulation):
    names = ["master.obs", "rover.obs", "antenna3.obs", "antenna4.obs", "antenna5.obs"][: len(simulation.observations)]
    paths = [folder / name for name in (*names, "broadcast.nav", "truth.csv")]
    for path, observations in zip(paths, simulation.observations, strict=False):
        rinex.write_rinex_obs(path, observations)
    rinex.write_rinex_nav(folder / "broadcast.nav", simulation.ephemerides)
    (folder / "truth.csv").write_text(truth_text(simulation.truth), encoding="ascii")
    return tuple(paths)


def truth_text(truth):
    """Return the truth as CSV: the first baseline in metres to 0.01 mm, the angles in degrees to 1e-6."""
    angles = np.degrees(np.stack([truth.heading, truth.pitch, truth.roll], axis=-1))
    baselines, angles = np.round(truth.baselines_enu[0], 5) + 0.0, np.round(angles, 6) + 0.0  # without negative zeros
    rows = zip(truth.time, baselines, angles, strict=True)
    lines = (",".join([iso_text(time), *(f"{x:.5f}" for x in baseline), *(f"{x:.6f}" for x in angle)]) for time, baseline, angle in rows)
    return "\n".join([TRUTH_COLUMNS, *lines]) + "\n"
