"""The command line called in this process, and the real files that travel with the project."""

from pathlib import Path
from typing import NamedTuple

import pytest

from gnsslab.cli import main
from gnsslab.data.locations import project_folder


class Answer(NamedTuple):
    """What a command came back with."""

    status: int
    out: str
    err: str

    @property
    def complaint(self):
        """Lines of stderr that are no notes by the way."""
        return [line for line in self.err.splitlines() if not line.startswith("note: ")]


class Files(NamedTuple):
    """A baseline: 60 s at 1 Hz, 5.3 km."""

    base: Path
    rover: Path
    nav: Path


@pytest.fixture
def run(capsys):
    """Run `gnsslab` with arguments in this process and return its `Answer`."""

    def run(*arguments):
        status = main([str(argument) for argument in arguments])
        return Answer(status, *capsys.readouterr())

    return run


@pytest.fixture(scope="session")
def files():
    """The data set that travels with the project, gzipped as it is."""
    folder = project_folder("datasets") / "cssrlib-078"
    return Files(folder / "3034078M1.21O.gz", folder / "SEPT078M1.21O.gz", folder / "SEPT078M.21P.gz")
