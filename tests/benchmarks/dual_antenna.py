"""Paper A's filter and the whole way to a heading, timed: run `python tests/benchmarks/dual_antenna.py [rounds]`.

First the filter with its integers, 650 epochs of fifteen satellites (preset paper-a-static), for each use of the known length:
milliseconds of processor time, after compilation and after preparation. Then a whole run beside RTKLIB's `rnx2rtkp` on the files
that `gnsslab simulate paper-a-static` writes: read, solve, write. RTKLIB runs in its moving-base mode with the length and its
sigma and ratio 3, in a process of its own; ours in this one. Its heading and ours are compared with the truth, beside how much
each has fixed; its linearised row of the length does harm here, so its other modes are shown too. Needs Debian's package rtklib.
"""

import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from gnsslab.cli.tables import write_attitude_csv
from gnsslab.core.rotations import heading_pitch_of
from gnsslab.gnss.differences import common_epochs
from gnsslab.gnss.preparation import prepare_moving
from gnsslab.gnss.relative import Status
from gnsslab.gnss.rinex import read_rinex_nav, read_rinex_obs
from gnsslab.simulate import find_preset, simulate, write_simulation
from gnsslab.systems.constrained_filter import run_filter, steady_path
from gnsslab.systems.dual_antenna import A_STATIC, dual_antenna_attitude
from gnsslab.systems.length_row import LengthUse

ROUNDS, ASKED_MS, ASKED_RATIO, SEED = 11, 25.0, 1.0, 1
LENGTH, SIGMA = 1.167, 0.005  # [m]
QUALITY = {1: Status.FIXED, 2: Status.FLOAT}  # RTKLIB's numbers
CONFIGURATION = f"""pos1-posmode =movingbase
pos1-frequency =l1
pos1-elmask =15
pos1-navsys =33
pos1-ionoopt =brdc
pos1-tropopt =saas
pos1-dynamics =on
pos2-armode =fix-and-hold
pos2-bdsarmode =on
pos2-arthres =3
pos2-baselen ={LENGTH}
pos2-basesig ={SIGMA}
out-solformat =enu
out-timesys =gpst
out-timeform =hms
ant2-postype =single
"""
MODES = {  # of RTKLIB, to see what its row of the length does; the time is that of the first
    "moving base with the length": CONFIGURATION,
    "moving base without it": CONFIGURATION.replace(f"baselen ={LENGTH}", "baselen =0"),
    "kinematic": CONFIGURATION.replace("movingbase", "kinematic"),
}


def filter_times(simulation, rounds):
    """Print how long the filter takes for each use of the length; return whether all keep what is asked."""
    prepared = prepare_moving(*simulation.observations, simulation.ephemerides, A_STATIC.settings)
    path, kept = steady_path(prepared, A_STATIC.velocity_noise), True
    print(f"{'length goes':18} {'ms':>7} {'asked':>6} {'fixed %':>8}   of {len(path.F)} epochs, {prepared.model.usable[0].sum()} satellites")
    for use in LengthUse:
        settings = replace(A_STATIC.filter, length_use=use)
        run = run_filter(prepared, path, settings)
        milliseconds = 1e3 * statistics.median(processor_time(lambda settings=settings: run_filter(prepared, path, settings)) for _ in range(rounds))
        kept &= milliseconds <= ASKED_MS
        print(f"{use.name:18} {milliseconds:7.1f} {ASKED_MS:6.0f} {100 * run.is_fixed.mean():8.1f}", flush=True)
    return kept


def processor_time(function):
    """Return the processor time [s] of one call in this thread."""
    start = time.thread_time()
    function()
    return time.thread_time() - start


def wall_time(function):
    """Return how long one call takes [s]."""
    start = time.perf_counter()
    function()
    return time.perf_counter() - start


def run_ours(folder):
    """Read, solve and write in this process; return the Attitude."""
    master, rover = (read_rinex_obs(folder / name) for name in ("master.obs", "rover.obs"))
    attitude = dual_antenna_attitude(
        master, rover, read_rinex_nav(folder / "broadcast.nav"), length=LENGTH, length_sigma=SIGMA, systems="GC", frequencies=1
    )
    write_attitude_csv(folder / "ours.csv", attitude, rover.time)
    return attitude


def run_theirs(folder, configuration=CONFIGURATION):
    """Run rnx2rtkp on the same files; return the time (k,), status (k,) and heading (k,) of its solution."""
    (folder / "theirs.conf").write_text(configuration)
    names = ("rover.obs", "master.obs", "broadcast.nav")
    command = ["rnx2rtkp", "-k", folder / "theirs.conf", "-o", folder / "theirs.pos", *(folder / name for name in names)]
    subprocess.run([str(part) for part in command], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=True)
    rows = [line.split() for line in (folder / "theirs.pos").read_text().splitlines() if line and not line.startswith("%")]
    labels = [f"{row[0].replace('/', '-')}T{row[1]}" for row in rows]
    status = np.array([QUALITY.get(int(row[5]), Status.NONE) for row in rows])
    return (
        np.array(labels, dtype="datetime64[ns]"),
        status,
        heading_pitch_of(np.array([row[2:5] for row in rows], dtype=float).reshape(-1, 3)).heading,
    )


def said(name, truth, when, status, heading):
    """Return in words how much one program has fixed and how far off its headings are."""
    i, j = common_epochs(truth.time, when)
    off = np.degrees((heading[j] - truth.heading[i] + np.pi) % (2 * np.pi) - np.pi)
    solved = status[j] > Status.NONE
    rms = np.sqrt(np.mean(off[solved] ** 2)) if solved.any() else np.nan
    return f"{name}: {100 * np.mean(status == Status.FIXED):.1f} % fixed, heading rms {rms:.2f} deg over {int(solved.sum())} epochs"


def whole_runs(simulation, rounds):
    """Print the times of whole runs, ours and theirs, and what they find; return whether what is asked is kept."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_simulation(folder, simulation)
        first = wall_time(lambda: run_ours(folder))
        times = [(wall_time(lambda: run_ours(folder)), wall_time(lambda: run_theirs(folder))) for _ in range(rounds)]
        ours, theirs = (statistics.median(column) for column in zip(*times, strict=True))
        print(f"\nwhole run [ms]: first {1e3 * first:.0f}, then {1e3 * ours:.0f}; rnx2rtkp {1e3 * theirs:.0f}")
        print(f"ratio {ours / theirs:.2f}, asked {ASKED_RATIO}")
        attitude = run_ours(folder)
        print(said("ours", simulation.truth, attitude.time, attitude.status, attitude.heading))
        for mode, text in MODES.items():
            print(said(f"rnx2rtkp, {mode}", simulation.truth, *run_theirs(folder, text)))
    return ours <= ASKED_RATIO * theirs


def main(rounds):
    """Report on filter and whole runs; return 1 where what is asked is not kept."""
    simulation = simulate(find_preset(A_STATIC.preset), np.random.default_rng(SEED))
    kept = filter_times(simulation, rounds)
    if not shutil.which("rnx2rtkp"):
        raise SystemExit("rnx2rtkp is not here to compare with: install Debian's package rtklib")
    return 0 if whole_runs(simulation, rounds) and kept else 1


if __name__ == "__main__":
    sys.exit(main(int(sys.argv[1]) if len(sys.argv) > 1 else ROUNDS))
