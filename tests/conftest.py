"""Fixtures for all tests: random numbers with a fixed seed, and real data sets."""

import os
from functools import cache
from typing import NamedTuple

import numpy as np
import pytest
from xdist.scheduler import LoadFileScheduling

import gnsslab
from gnsslab.data import Dataset, DataUnavailable, fetch, find_dataset


@pytest.fixture
def rng():
    """A generator of random numbers, the same in every run."""
    return np.random.default_rng(20240624)


@pytest.fixture(autouse=True)
def progress_elsewhere(tmp_path, monkeypatch):
    """No test writes into the progress of whoever runs it."""
    monkeypatch.setenv("GNSSLAB_PROGRESS", str(tmp_path / "progress"))


@pytest.fixture(scope="session")
def dataset():
    """A function from a data set's name to its folder; skips where the set cannot be had, fails under GNSSLAB_REQUIRE_ALL=1."""
    found = {}  # a name's folder, or the words why it cannot be had: asked once, not in every test

    def folder_of(name):
        if name not in found:
            found[name] = _folder_or_reason(name)
        if isinstance(found[name], str):
            missing(found[name])
        return found[name]

    return folder_of


@pytest.fixture(scope="session")
def campaign(dataset):
    """A function from a data set's name to its `Campaign`, read once; skips or fails as `dataset` does."""

    @cache
    def read(name):
        folder, facts = dataset(name), find_dataset(name)
        base, rover = (gnsslab.read_rinex_obs(folder / file) for file in (facts.base, facts.rover))
        return Campaign(base, rover, gnsslab.read_rinex_nav(*(folder / file for file in facts.nav)), facts)

    return read


@pytest.fixture(scope="session")
def slope_day(dataset):
    """The Series of 24 hours on a slope through our own BeiDou RTK, solved once for all tests; skips or fails as `dataset` does."""
    from gnsslab.labs.campaigns import FileReader
    from gnsslab.labs.slope_data import solved_slope

    dataset("beidou-slope")
    return solved_slope(FileReader())


class Campaign(NamedTuple):
    """A real data set, read."""

    base: gnsslab.Observations
    rover: gnsslab.Observations
    ephemerides: gnsslab.Ephemerides
    facts: Dataset


def _folder_or_reason(name):
    try:
        return fetch(name)
    except (DataUnavailable, OSError) as error:
        return str(error)


def missing(reason):
    """Skip the test with the reason; fail where GNSSLAB_REQUIRE_ALL=1 says that everything must be there."""
    __tracebackhide__ = True
    if os.environ.get("GNSSLAB_REQUIRE_ALL") == "1":
        pytest.fail(f"GNSSLAB_REQUIRE_ALL=1, but: {reason}")
    pytest.skip(reason)


NO_KERNELS = {"rinex", "rtcm", "data", "simulate", "pages"}  # folders whose tests compile none


def pytest_collection_modifyitems(items):
    """Browser tests come first: they take longest, and in one process."""
    items.sort(key=_turn)


def _turn(item):
    """Return the place of a test: the browser's course compiles all kernels, so those who need them too come when it has done so."""
    folders = set(item.path.parts)
    if "browser" in folders:
        return 0, item.path.name == "test_class.py"  # each of its workers would compile them
    return 1, not folders & NO_KERNELS


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    """Give whole files to the processes that run tests side by side, and all browser tests to one of them."""
    return _FilesAtOnce(config, log)


class _FilesAtOnce(LoadFileScheduling):
    """Hands out files, in their order; those with a browser as one."""

    def _split_scope(self, nodeid):
        return "browser" if nodeid.startswith("tests/browser/") else super()._split_scope(nodeid)
