"""Campaigns: a lab's observations and orbits, from a real data set or from the student's own files, each file read once."""

from functools import lru_cache
from pathlib import Path

from gnsslab.data import fetch, find_dataset
from gnsslab.gnss.rinex import read_rinex_nav, read_rinex_obs

KEPT = 4  # files kept by one lab: two receivers of two campaigns


class FileReader:
    """RINEX files, kept between the moves of one lab; a file that changed is read again."""

    def __init__(self):
        self._folder = lru_cache(KEPT)(fetch)
        self._read_obs = lru_cache(KEPT)(_read_obs)
        self._read_nav = lru_cache(KEPT)(_read_nav)

    def observations(self, path):
        """Return the Observations in a file; what cannot be read raises ValueError in words."""
        return self._read_obs(*_stamped(path))

    def ephemerides(self, path):
        """Return the Ephemerides in a file; what cannot be read raises ValueError in words."""
        return self._read_nav(*_stamped(path))

    def folder(self, name):
        """Return the folder of a data set; raise DataUnavailable."""
        return self._folder(name)

    def data_set(self, name):
        """Return the base's (or master's) Observations, the rover's, and the Ephemerides of a data set; raise DataUnavailable."""
        facts, folder = find_dataset(name), self.folder(name)
        return self.observations(folder / facts.base), self.observations(folder / facts.rover), self.ephemerides(folder / facts.nav[0])


def require_files(**paths):
    """Raise ValueError that names the student's files which are not given yet.

    >>> require_files(master="a.obs", rover="", navigation="")
    Traceback (most recent call last):
    ValueError: your rover and navigation files are missing: upload them, or type their paths
    """
    missing = [label for label, path in paths.items() if not path]
    if len(missing) == 1:
        raise ValueError(f"your {missing[0]} file is missing: upload it, or type its path")
    if missing:
        raise ValueError(f"your {', '.join(missing[:-1])} and {missing[-1]} files are missing: upload them, or type their paths")


def simulated_instead(reason):
    """Return the note of a lab that has no real data, with the reason.

    >>> simulated_instead("there is no network")
    'No real data here, so this is simulated: there is no network.'
    """
    return f"No real data here, so this is simulated: {reason}."


def no_answer(refusal):
    """Return the problem of a lab whose files or engine refused, with the reason.

    >>> no_answer(ValueError("your rover file is missing: upload it, or type its path"))
    'No answer: your rover file is missing: upload it, or type its path.'
    """
    return f"No answer: {refusal}."


def blocked_by_data(data, simulation_only, files):
    """Return for each control without effect on the chosen data ("simulated", "mine" or a real set) the reason why.

    >>> blocked_by_data("mine", ("seed",), ("rover_file",))
    {'seed': 'no effect: real data are as they are'}
    """
    reasons = {} if data == "simulated" else dict.fromkeys(simulation_only, "no effect: real data are as they are")
    return reasons if data == "mine" else reasons | dict.fromkeys(files, 'choose "my files" first')


def _stamped(path):
    """Return a path with its time of change and size, so that a file that changed is read again."""
    path = Path(path)
    state = path.stat() if path.is_file() else None
    return path, state and (state.st_mtime_ns, state.st_size)


def _read_obs(path, stamp):
    return read_rinex_obs(path)


def _read_nav(path, stamp):
    return read_rinex_nav(path)
