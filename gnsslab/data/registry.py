"""The registry: which data sets there are, whose they are, what is known of them."""

import tomllib
from dataclasses import dataclass
from functools import cache

import numpy as np

from gnsslab.data.locations import project_folder
from gnsslab.gnss.frames import ecef_from_geodetic


@dataclass(frozen=True)
class DataFile:
    """One file of a data set: either it has a public address, or a word on how it was made."""

    name: str
    size: int  # [bytes]
    sha256: str
    url: str = ""  # public address at a fixed commit
    made_from: str = ""  # how it was made, where it has no address
    converted_from: str = ""  # name of the log of the same set from which it can be made here


@dataclass(frozen=True, eq=False)
class Dataset:
    """One data set of the registry; absent entries are empty or None."""

    name: str
    title: str
    licence: str
    truth: str  # what is known of the answer, in words
    use: str
    files: tuple[DataFile, ...]
    base: str = ""  # file name of the base's, or master's, observations
    rover: str = ""
    nav: tuple[str, ...] = ()
    base_position: np.ndarray | None = None  # (3,) ECEF [m], antenna reference point
    rover_position: np.ndarray | None = None  # (3,) ECEF [m]
    baseline_enu: np.ndarray | None = None  # (3,) [m], base to rover, axes at the base
    place: str = ""
    span: str = ""  # from when to when
    receivers: str = ""
    credit: str = ""  # whose it is

    @property
    def size(self):
        """Size of all files [bytes]."""
        return sum(file.size for file in self.files)

    def file(self, name):
        """Return the record of one file; raise ValueError with the names there are."""
        for file in self.files:
            if file.name == name:
                return file
        raise ValueError(f"the data set {self.name} has no file {name!r}: it has {', '.join(f.name for f in self.files)}")

    def __repr__(self):
        return f"Dataset {self.name}: {self.title}; {len(self.files)} files, {self.size / 1e6:.1f} MB"


@cache
def read_registry():
    """Return all data sets, a dict by name, from the registry that travels with the project.

    >>> read_registry()["matrtklib-static"].rover
    'rover.obs'
    """
    with open(project_folder("datasets") / "registry.toml", "rb") as stream:
        return {name: _dataset(name, entry) for name, entry in tomllib.load(stream).items()}


def find_dataset(name):
    """Return the data set of a name; raise ValueError with the names there are."""
    try:
        return read_registry()[name]
    except KeyError:
        raise ValueError(f"there is no data set {name!r}: expected one of {', '.join(read_registry())}") from None


def _dataset(name, entry):
    return Dataset(
        name=name,
        title=entry["title"],
        licence=entry["licence"],
        truth=entry["truth"],
        use=entry["use"],
        files=tuple(_data_file(file, facts) for file, facts in entry["files"].items()),
        base=entry.get("base", ""),
        rover=entry.get("rover", ""),
        nav=tuple(entry.get("nav", ())),
        base_position=_base_position(entry),
        rover_position=_array(entry.get("rover_ecef")),
        baseline_enu=_array(entry.get("baseline_enu")),
        place=entry["place"],
        span=entry["span"],
        receivers=entry["receivers"],
        credit=entry["credit"],
    )


def _data_file(name, facts):
    return DataFile(name, facts["bytes"], facts["sha256"], facts.get("url", ""), facts.get("made_from", ""), facts.get("converted_from", ""))


def _base_position(entry):
    if "base_llh_deg_m" not in entry:
        return _array(entry.get("base_ecef"))
    latitude_deg, longitude_deg, height = entry["base_llh_deg_m"]
    return ecef_from_geodetic([np.radians(latitude_deg), np.radians(longitude_deg), height])


def _array(values):
    return None if values is None else np.array(values, dtype=float)
