"""`gnsslab data`: the real data sets of the lessons."""

from typing import Annotated

import typer

EXAMPLE = "Example: gnsslab data get matrtklib-static"
app = typer.Typer(rich_markup_mode=None, no_args_is_help=True, help="Real data sets: list, download, find, check.")

Name = Annotated[str, typer.Argument(metavar="NAME", hidden=True)]
MaybeName = Annotated[str | None, typer.Argument(metavar="NAME", hidden=True)]
MaybeFile = Annotated[str | None, typer.Argument(metavar="FILE", hidden=True)]


@app.command("list", epilog="Example: gnsslab data list")
def list_():
    """Say which data sets there are, and which of them are on this machine."""
    from gnsslab.data import read_registry

    for name, dataset in read_registry().items():
        print(f"{name:18} {dataset.size / 1e6:5.1f} MB  {_where(name):12} {dataset.title}")


@app.command("get", epilog="Example: gnsslab data get matrtklib-static")
def get(name: Name):
    """Bring the data set NAME to this machine and say its folder."""
    from gnsslab.cli.progress import progress_bar
    from gnsslab.data import fetch

    with progress_bar(name) as progress:
        folder = fetch(name, progress)
    print(folder)


@app.command("path", epilog="Example: gnsslab data path cssrlib-078 SEPT078M.21P")
def path(name: Name, file: MaybeFile = None):
    """Say where the data set NAME, or one FILE of it, is; nothing is downloaded."""
    from gnsslab.data import dataset_path, fetch, find_dataset, verify

    if file is not None:
        find_dataset(name).file(file)
    wanted = verify(name) if file is None else {file: verify(name)[file]}
    for one, state in wanted.items():
        if state != "ok":
            raise ValueError(f"{name}/{one} is not ready ({state}): type `gnsslab data get {name}`")
    print(fetch(name) if file is None else dataset_path(name, file))


@app.command("verify", epilog="Example: gnsslab data verify")
def verify_(name: MaybeName = None):
    """Compare the files of NAME, or of all data sets, with the registry's checksums."""
    from gnsslab.data import read_registry, verify

    states = {f"{one}/{file}": state for one in ([name] if name else read_registry()) for file, state in verify(one).items()}
    for file, state in states.items():
        print(f"{file:45} {state}")
    wrong = [file for file, state in states.items() if state != "ok" and (name or state.startswith("wrong"))]
    if wrong:
        raise ValueError(
            f"{len(wrong)} of {len(states)} files are missing or damaged ({wrong[0]}...): type `gnsslab data get {wrong[0].split('/')[0]}`"
        )


def _where(name):
    from gnsslab.data import verify

    return "here" if all(state == "ok" for state in verify(name).values()) else "not here"
