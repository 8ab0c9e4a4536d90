"""`gnsslab simulate`: observations, orbits and truth from a preset."""

from typing import Annotated

import typer

EXAMPLE = "Example: gnsslab simulate --list     or: gnsslab simulate static-baseline -o mydata --seed 1"

Preset = Annotated[str | None, typer.Argument(metavar="PRESET", hidden=True)]
Output = Annotated[str | None, typer.Option("-o", "--output", metavar="DIR", show_default=False, help="Folder to write into.")]
Seed = Annotated[int, typer.Option("--seed", metavar="N", show_default=False, help="Start of the random numbers [0]: same seed, same data.")]
List = Annotated[bool, typer.Option("--list", help="Say which presets there are, and stop.")]


def simulate(context: typer.Context, preset: Preset = None, output: Output = None, seed: Seed = 0, list_: List = False):
    """Simulate PRESET: master.obs, rover.obs, broadcast.nav and truth.csv; of a series of solutions, series.csv and truth.csv."""
    if list_:
        _say_presets()
        return
    if not preset:
        raise _missing("argument 'PRESET' (type `gnsslab simulate --list` for the names)")
    if output is None:
        raise _missing("option '-o'")
    _simulate(context.params, preset, output, seed)


def _missing(what):
    usage_error = typer.BadParameter.__mro__[1]  # ends with status 2, as for any missing argument
    return usage_error(f"Missing {what}.")


def _say_presets():
    from gnsslab.simulate import PRESETS, SERIES_PRESETS

    presets = PRESETS | SERIES_PRESETS
    width = max(len(name) for name in presets)
    for name, preset in presets.items():
        print(f"{name:{width}}  {preset.title}")


def _simulate(given, name, folder, seed):
    import numpy as np

    from gnsslab.cli.outputs import check_folder, write_provenance

    if seed < 0:
        raise ValueError(f"--seed {seed}: expected a whole number, zero or above")
    write = _writer(name, np.random.default_rng(seed))
    check_folder(folder)
    written = write(folder)
    names = ", ".join(path.name for path in written)
    options = {key: value for key, value in given.items() if key != "list_"}
    write_provenance([f"{folder}/simulation"], "simulate", options, notes=[f"made {names}"])
    print(f"written to {folder}: {names}")


def _writer(name, rng):
    """Return the function that simulates the preset of that name and writes it into a folder."""
    from gnsslab import simulate as s

    if name in s.SERIES_PRESETS:
        return lambda folder: s.write_series(folder, s.simulate_series(s.find_series_preset(name), rng))
    if name not in s.PRESETS:
        raise ValueError(f"there is no preset {name!r}; the presets are {', '.join([*s.PRESETS, *s.SERIES_PRESETS])}")
    return lambda folder: s.write_simulation(folder, s.simulate(s.find_preset(name), rng))
