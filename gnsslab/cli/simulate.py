"""`gnsslab simulate`: observations, orbits and truth from a preset."""

from typing import Annotated

import typer

EXAMPLE = "Example: gnsslab simulate --list     or: gnsslab simulate static-baseline -o mydata --seed 1"

Preset = Annotated[str | None, typer.Argument(metavar="PRESET", hidden=True)]
Output = Annotated[str | None, typer.Option("-o", "--output", metavar="DIR", show_default=False, help="Folder to write into.")]
Seed = Annotated[int, typer.Option("--seed", metavar="N", show_default=False, help="Start of the random numbers [0]: same seed, same data.")]
List = Annotated[bool, typer.Option("--list", help="Say which presets there are, and stop.")]


def simulate(context: typer.Context, preset: Preset = None, output: Output = None, seed: Seed = 0, list_: List = False):
    """Simulate PRESET: master.obs, rover.obs, broadcast.nav and truth.csv."""
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
    from gnsslab.simulate import PRESETS

    width = max(len(name) for name in PRESETS)
    for name, preset in PRESETS.items():
        print(f"{name:{width}}  {preset.title}")


def _simulate(given, name, folder, seed):
    import numpy as np

    from gnsslab.cli.outputs import check_folder, write_provenance
    from gnsslab.simulate import find_preset, write_simulation
    from gnsslab.simulate import simulate as simulated

    if seed < 0:
        raise ValueError(f"--seed {seed}: expected a whole number, zero or above")
    preset = find_preset(name)
    check_folder(folder)
    written = write_simulation(folder, simulated(preset, np.random.default_rng(seed)))
    names = ", ".join(path.name for path in written)
    options = {key: value for key, value in given.items() if key != "list_"}
    write_provenance([f"{folder}/simulation"], "simulate", options, notes=[f"made {names}"])
    print(f"written to {folder}: {names}")
