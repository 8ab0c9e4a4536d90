"""Series for the lab of alarms: simulated, a slope, stations at the earthquake of 2011, or a file; and what is put into them."""

import hashlib
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple
from zipfile import BadZipFile

import numpy as np

from gnsslab.data import DataUnavailable, find_dataset
from gnsslab.data.locations import cache_folder
from gnsslab.gnss.relative import solve_relative
from gnsslab.gnss.series import Series, series_of
from gnsslab.gnss.series_files import read_series
from gnsslab.gnss.times import seconds_between
from gnsslab.labs.campaigns import FileReader, require_files, simulated_instead
from gnsslab.simulate.series import simulate_series
from gnsslab.simulate.series_presets import SeriesPreset, find_series_preset
from gnsslab.systems.monitoring import usable

CM = 1e-2
PAPER = find_series_preset("b-fixed")
A_DAY = 5760  # epochs of 15 s
SLOPE, QUAKE = "beidou-slope", "geonet-tohoku-neu"
SIGNALS = ("C2I", "C6I")  # of BeiDou, on the slope
QUAKE_DAY = np.datetime64("2011-03-11", "ns")
STATIONS = {"J188": "J188neu9818.csv", "USUD": "USUDneu9818.csv"}
DOWNHILL = np.array([-2.0, -3.0, 0.0]) / np.sqrt(13.0)  # where paper B's platform moves
LONGEST = 20_000  # epochs of a file: more would take seconds at each move
BURSTS = 5
FIRST_BURST = 0.125  # of the series: three in the morning of a day
KEPT = 8
ARRAYS = ("time", "enu", "sigma", "status", "ratio")


class Motion(NamedTuple):
    """What is put into a series from an epoch on."""

    at: int
    step: float  # [m] downhill
    slide: float  # [m/h] downhill


class WrongFixes(NamedTuple):
    """Bursts of solutions that are off by the same in each of their epochs."""

    length: int  # epochs
    size: float  # [m]
    seed: int


@dataclass(frozen=True, eq=False)
class Measured:
    """A series of T solutions as it came, and what is said of it."""

    series: Series
    note: str
    quake: int | None = None  # epoch at which the ground itself moved


class SlopeData:
    """The series of one lab, each made once."""

    def __init__(self):
        self._files = FileReader()
        self._simulated = lru_cache(KEPT)(_simulated)
        self._solved = lru_cache(1)(self._solve)
        self._station = lru_cache(len(STATIONS))(_station)
        self._own = lru_cache(2)(_own)
        self.with_wrong_fixes = lru_cache(KEPT)(with_wrong_fixes)
        self.with_motion = lru_cache(KEPT)(with_motion)

    def measured(self, settings):
        """Return the Measured series that the settings ask for; a simulated one, with the reason, where real data cannot be had."""
        noise = settings["noise"], settings["gross"], settings["seed"]
        if settings["data"] == "mine":
            require_files(series=settings["file"])
            return self._own(settings["file"], _stamp(settings["file"]))
        try:
            if settings["data"] == "slope":
                return self._solved()
            if settings["data"] in STATIONS:
                return self._station(self._files.folder(QUAKE) / STATIONS[settings["data"]])
        except DataUnavailable as reason:
            return replace(self._simulated(*noise), note=simulated_instead(reason))
        return self._simulated(*noise)

    def _solve(self):
        series = solved_slope(self._files)
        used = series.at(usable(series, 0.0))
        return Measured(used, f"24 hours through our own BeiDou RTK: {len(used)} of {len(series)} epochs fixed, the others are left out. "
                              "Solving them takes a while the first time; after that they are kept.")  # fmt: skip


def solved_slope(files):
    """Return the Series of the slope's 24 hours, solved by `solve_relative` and kept on disk until the solver changes; raise DataUnavailable."""
    folder, kept = files.folder(SLOPE), cache_folder() / SLOPE / f"solved-{_text_of_the_solver()}.npz"
    return _read_kept(kept) or _solve_and_keep(files, folder, kept)


def _read_kept(path):
    """Return the Series in a file of ours, or None where there is none that can be read."""
    try:
        with path.open("rb") as file, np.load(file) as arrays:
            return Series(*(arrays[name] for name in ARRAYS))
    except (OSError, ValueError, KeyError, EOFError, BadZipFile):
        return None


def _solve_and_keep(files, folder, path):
    facts = find_dataset(SLOPE)
    solved = solve_relative(*files.data_set(SLOPE), base_position=facts.base_position, systems="C", signals=SIGNALS)
    series = series_of(solved)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        half = path.with_suffix(f".{id(series)}.npz")
        np.savez(half, **{name: getattr(series, name) for name in ARRAYS})
        half.replace(path)  # all of it or nothing: another process may be reading
    except OSError:
        pass  # then it is solved again next time
    return series


def _text_of_the_solver():
    """Return a short digest of all that a solution depends on: the text of the solver."""
    package = Path(__file__).parents[1]
    texts = [path.read_bytes() for folder in ("core", "gnss") for path in sorted(package.glob(f"{folder}/**/*.py"))]
    return hashlib.sha256(b"".join(texts)).hexdigest()[:16]


def _simulated(noise, gross, seed):
    """Return a Measured day with the paper's noise, `noise` percent of it, `gross` percent of gross errors."""
    part = noise / 100
    errors = replace(PAPER.noise, white=part * PAPER.noise.white, coloured=part * PAPER.noise.coloured, gross_share=gross / 100)
    preset = SeriesPreset("slope", "A slope", "", "2021-07-06T00:00:00", PAPER.interval, A_DAY, PAPER.baseline_enu, errors)
    return Measured(simulate_series(preset, np.random.default_rng(seed)).series, "")


def _station(path):
    series, _ = read_series(path, columns="time,north,east,up", unit="mm")
    quake = int(np.searchsorted(series.time, QUAKE_DAY))
    return Measured(series, f"Daily positions; the ground moved by itself, on 11 March 2011, day {quake} of {len(series)}.", quake)


def _own(path, stamp):
    try:
        series, notes = read_series(path)
    except OSError as error:
        raise ValueError(f"{path} cannot be read ({error.strerror or error}): give the path of a table of time, east, north, up") from None
    used = series.at(usable(series, 0.0))
    if len(used) < 32:
        raise ValueError(f"{path} has {len(used)} positions, and an alarm is set on 32 or more: give a longer series")
    cut = [f"Only the first {LONGEST} of {len(used)} positions are shown."] if len(used) > LONGEST else []
    return Measured(used.at(slice(LONGEST)), " ".join([*notes, *cut]))


def _stamp(path):
    """Return time of change and size of a file, so that a file that changed is read again."""
    file = Path(path)
    return (file.stat().st_mtime_ns, file.stat().st_size) if file.is_file() else None


def with_wrong_fixes(series, wrong):
    """Return the Series with bursts of WrongFixes, the first at an eighth of it, the others anywhere later."""
    rng, T = np.random.default_rng([wrong.seed, 2]), len(series)
    later = rng.uniform(FIRST_BURST, 1.0, BURSTS - 1)
    enu = series.enu.copy()
    for place, azimuth in zip([FIRST_BURST, *later], rng.uniform(0, 2 * np.pi, BURSTS), strict=True):
        first = int(place * T)
        enu[first : first + wrong.length] += wrong.size * np.array([np.sin(azimuth), np.cos(azimuth), 0.0])
    return replace(series, enu=enu)


def with_motion(series, motion):
    """Return the Series of a point that moves."""
    return replace(series, enu=series.enu + true_motion(series.time, motion)[:, None] * DOWNHILL)


def true_motion(time, motion):
    """Return how far a point has moved (T,) [m]: a step at an epoch, and a slide from there on.

    >>> time = np.datetime64("2024-01-01T00:00:00", "ns") + np.arange(4) * np.timedelta64(30, "m")
    >>> true_motion(time, Motion(1, 0.05, 0.02)).round(3).tolist()
    [0.0, 0.05, 0.06, 0.07]
    """
    hours = seconds_between(time, time[motion.at : motion.at + 1]) / 3600
    return np.where(np.arange(len(time)) >= motion.at, motion.step + motion.slide * hours, 0.0)
