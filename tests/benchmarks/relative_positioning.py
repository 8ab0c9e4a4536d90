"""Relative positioning timed beside RTKLIB's `rnx2rtkp`: run `python tests/benchmarks/relative_positioning.py [rounds]`.

A whole run at both: three plain files read, every epoch solved, the solution written. Ours runs in this process (what
`gnsslab rtk` does after its imports), theirs as a process of its own, its printing thrown away. Both get the same files, base
position, mask and systems, kinematic, with continuous ambiguity resolution. Ratios are of medians over interleaved rounds;
the first run of ours on each set loads or compiles kernels and is told apart. A ratio counts only where both agree: the
median difference of their fixed baselines is printed beside it, with how much each has fixed, of all common epochs.

RTKLIB 2.4.3 counts BeiDou's B3I as third frequency and Galileo's E5a likewise, so on sets where these are second here it
is given three frequencies on BeiDou alone (its files hold B1I and B3I only) and two elsewhere (E1 and E5b then).
The data sets come from the folder that GNSSLAB_DATA_MIRROR names, or are downloaded. Needs Debian's package rtklib.
"""

import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np

from gnsslab.cli.tables import write_relative_csv
from gnsslab.data import fetch, find_dataset
from gnsslab.gnss.differences import common_epochs
from gnsslab.gnss.relative import Status, solve_relative, station_position
from gnsslab.gnss.rinex import read_rinex_nav, read_rinex_obs
from gnsslab.gnss.rinex.text import read_bytes

ROUNDS, MASK_DEG, ASKED = 5, 15.0, 1.0
AGREE = 0.02  # [m], medians may differ by weights and atmosphere (heights by a centimetre); one wrong integer moves a baseline by decimetres
NAVSYS = {"G": 1, "E": 8, "J": 16, "C": 32}  # RTKLIB's bits
SETS = (  # name, systems, our number of frequencies, RTKLIB's word for theirs
    ("matrtklib-static", "GECJ", 2, "l1+l2"),
    ("geonet-0759-3040", "G", 2, "l1+l2"),
    ("cssrlib-078", "GECJ", 2, "l1+l2"),
    ("beidou-slope", "C", 2, "l1+l2+l5"),
)
CONFIGURATION = """pos1-posmode =kinematic
pos1-frequency ={frequencies}
pos1-elmask ={mask}
pos1-navsys ={navsys}
pos1-ionoopt =brdc
pos1-tropopt =saas
pos2-armode =continuous
pos2-bdsarmode =on
out-solformat =enu
out-timesys =gpst
out-timeform =hms
ant2-postype =xyz
ant2-pos1 ={base[0]:.4f}
ant2-pos2 ={base[1]:.4f}
ant2-pos3 ={base[2]:.4f}
"""


class Case(NamedTuple):
    """One data set prepared for both programs."""

    name: str
    systems: str
    frequencies: int
    base: Path
    rover: Path
    nav: tuple[Path, ...]
    base_position: np.ndarray
    configuration: Path
    folder: Path


class Fixes(NamedTuple):
    """Fixed epochs of one program."""

    time: np.ndarray  # (k,) datetime64[ns]
    baseline_enu: np.ndarray  # (k, 3) [m]


def prepare(folder, name, systems, frequencies, their_frequencies):
    """Unpack the files of a set, find the base's position and write RTKLIB's configuration; return the Case."""
    source, facts = fetch(name), find_dataset(name)
    base, rover, *nav = (plain_copy(source / file, folder) for file in (facts.base, facts.rover, *facts.nav))
    position = facts.base_position if facts.base_position is not None else station_position(read_rinex_obs(base), read_rinex_nav(*nav))
    configuration = folder / "rnx2rtkp.conf"
    navsys = sum(NAVSYS[letter] for letter in systems)
    configuration.write_text(CONFIGURATION.format(frequencies=their_frequencies, mask=MASK_DEG, navsys=navsys, base=position))
    return Case(name, systems, frequencies, base, rover, tuple(nav), position, configuration, folder)


def plain_copy(path, folder):
    """Return the path of the unpacked text of a file."""
    copy = folder / path.name.removesuffix(".gz")
    copy.write_bytes(read_bytes(path))
    return copy


def run_ours(case):
    """Read, solve and write in this process; return rover, base and solution."""
    base, rover, ephemerides = read_rinex_obs(case.base), read_rinex_obs(case.rover), read_rinex_nav(*case.nav)
    options = {"systems": case.systems, "frequencies": case.frequencies, "mask_deg": MASK_DEG}
    relative = solve_relative(base, rover, ephemerides, base_position=case.base_position, **options)
    write_relative_csv(case.folder / "ours.csv", relative, rover.time)
    return base, rover, relative


def run_theirs(case):
    """Run rnx2rtkp to a file; return the file's path."""
    output = case.folder / "theirs.pos"
    command = ["rnx2rtkp", "-k", case.configuration, "-o", output, case.rover, case.base, *case.nav]
    subprocess.run([str(part) for part in command], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=True)
    return output


def seconds_of(function, case):
    """Return how long one call takes [s]."""
    start = time.perf_counter()
    function(case)
    return time.perf_counter() - start


def our_fixes(relative):
    is_fixed = relative.status == Status.FIXED
    return Fixes(relative.time[is_fixed], relative.baseline_enu[is_fixed])


def their_fixes(path):
    """Return the epochs of quality 1 of a solution file."""
    rows = [line.split() for line in path.read_text().splitlines() if line and not line.startswith("%")]
    fixed = [row for row in rows if row[5] == "1"]
    labels = [f"{row[0].replace('/', '-')}T{row[1]}" for row in fixed]
    return Fixes(np.array(labels, dtype="datetime64[ns]"), np.array([row[2:5] for row in fixed], dtype=float).reshape(-1, 3))


def median_difference(ours, theirs):
    """Return the median distance [m] of baselines at epochs that both have fixed, and how many there are."""
    i, j = common_epochs(ours.time, theirs.time)
    distance = np.linalg.norm(ours.baseline_enu[i] - theirs.baseline_enu[j], axis=1)
    return (float(np.median(distance)) if len(i) else np.nan), len(i)


def report(case, rounds):
    """Time, compare and print one line; return whether the ratio counts and is kept."""
    first = seconds_of(run_ours, case)
    times = [(seconds_of(run_ours, case), seconds_of(run_theirs, case)) for _ in range(rounds)]
    mine, their = (statistics.median(column) for column in zip(*times, strict=True))
    base, rover, relative = run_ours(case)
    ours, theirs = our_fixes(relative), their_fixes(run_theirs(case))
    common = len(common_epochs(base.time, rover.time)[0])
    difference, both = median_difference(ours, theirs)
    agree = difference < AGREE
    verdict = "kept" if agree and mine <= ASKED * their else "missed" if agree else "answers differ"
    percents = f"{100 * len(ours.time) / common:8.2f} {100 * len(theirs.time) / common:10.2f}"
    timing = f"{first * 1e3:9.0f} {mine * 1e3:8.1f} {their * 1e3:10.1f} {mine / their:7.3f} {ASKED:6.2f}"
    print(f"{case.name:18} {timing} {percents} {both:6d} {difference * 1e3:8.1f} {verdict}", flush=True)
    return verdict == "kept"


def main(rounds):
    """Report on each set; return 1 where what is asked is not kept."""
    if not shutil.which("rnx2rtkp"):
        raise SystemExit("rnx2rtkp is not here to compare with: install Debian's package rtklib")
    columns = f"{'first ms':>9} {'ours ms':>8} {'theirs ms':>10} {'ratio':>7} {'asked':>6} {'fixed %':>8} {'theirs %':>10} {'both':>6} {'diff mm':>8}"
    print(f"{'set':18} {columns}")
    kept = []
    for name, *options in SETS:
        with tempfile.TemporaryDirectory() as folder:
            kept.append(report(prepare(Path(folder), name, *options), rounds))
    return 0 if all(kept) else 1


if __name__ == "__main__":
    sys.exit(main(int(sys.argv[1]) if len(sys.argv) > 1 else ROUNDS))
