"""The doctor: what is missing on this machine, in words, and what to type."""

import re
import sys
import tomllib
from importlib import metadata
from typing import NamedTuple

from gnsslab.data.locations import cache_folder, mirror_folder, project_file, project_folder

OLDEST_PYTHON = (3, 11)


class Finding(NamedTuple):
    """One check: its state is `well`, `hint` (works, with something to know) or `broken`; the words say what to type."""

    state: str
    words: str


def examine():
    """Return the findings of all checks."""
    return [python(), *packages(), kernels(), browser(), lessons(), cache(), *data_sets()]


def python():
    """Check the version of Python."""
    version = ".".join(map(str, sys.version_info[:3]))
    if sys.version_info < OLDEST_PYTHON:
        return Finding("broken", f"Python {version}: gnsslab needs 3.11 or newer; install it from python.org")
    return Finding("well", f"Python {version}")


def packages():
    """Check each package that gnsslab needs: there, new enough, and whether this version was tested."""
    project = tomllib.loads(project_file("pyproject.toml").read_text(encoding="utf-8"))
    tested = versions_tested(project["tool"]["uv"]["constraint-dependencies"])
    needed = [re.split(r"[ ;><=~!]", requirement)[0] for requirement in project["project"]["dependencies"]]
    return [package(name, tested.get(name, ())) for name in needed]


def package(name, tested):
    """Check one package against the versions it was tested with."""
    try:
        installed = metadata.version(name)
    except metadata.PackageNotFoundError:
        return Finding("broken", f"{name} is not installed: type `pip install {name}`")
    if tested and installed not in tested:
        wanted = tested[-1]
        return Finding("hint", f"{name} {installed}: tested with {' and '.join(tested)}; if something fails, type `pip install {name}=={wanted}`")
    return Finding("well", f"{name} {installed}, as tested")


def versions_tested(pins):
    """Return the versions of each package among lines `name==version ; marker`.

    >>> versions_tested(["numpy==2.4.6 ; python_full_version < '3.12'", "numpy==2.5.5"])
    {'numpy': ('2.4.6', '2.5.5')}
    """
    tested = {}
    for pin in pins:
        name, version = re.match(r"([^=\s]+)==([^;\s]+)", pin).groups()
        tested[name] = (*tested.get(name, ()), version)
    return tested


def kernels():
    """Check that numba compiles."""
    try:
        import numba

        numba.njit(lambda x: x + 1)(1)
    except Exception as error:  # whatever numba or its LLVM raises on a foreign system: the kernels run without it
        return Finding("hint", f"numba does not compile ({type(error).__name__}): all works, 30 times slower; type `pip install -U numba`")
    return Finding("well", "numba compiles the kernels")


def browser():
    """Check that a browser can be opened for the course."""
    import webbrowser

    try:
        name = webbrowser.get().name
    except webbrowser.Error:
        return Finding("hint", "no browser found: type `gnsslab course --no-browser` and open the address it says in any browser")
    return Finding("well", f"browser: {name}")


def lessons():
    """Check that the lessons came along."""
    try:
        count = len(list(project_folder("lessons").glob("[0-9][0-9]_*.py")))
    except FileNotFoundError as error:
        return Finding("broken", str(error))
    return Finding("well" if count else "broken", f"{count} lesson{'s' * (count > 1)}" if count else "no lessons found: install gnsslab again")


def cache():
    """Check that downloaded data can be kept."""
    folder = cache_folder()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        (folder / ".can-write").touch()
        (folder / ".can-write").unlink()
    except OSError as error:
        return Finding("broken", f"the cache {folder} cannot be written ({error.strerror}): name another folder in GNSSLAB_CACHE")
    return Finding("well", f"cache for data: {folder}")


def data_sets():
    """Check the mirror and each real data set."""
    from gnsslab.data import read_registry, verify

    try:
        mirror = mirror_folder()
    except OSError as error:
        return [Finding("broken", str(error))]
    first = Finding("well", f"mirror for data: {mirror}" if mirror else "no mirror (GNSSLAB_DATA_MIRROR is not set): data are downloaded")
    return [first, *(_data_set(name, verify(name).values()) for name in read_registry())]


def _data_set(name, states):
    if all(state == "ok" for state in states):
        return Finding("well", f"data set {name}")
    return Finding("hint", f"data set {name} is not here: type `gnsslab data get {name}`; without it its lessons go on with simulated data")
