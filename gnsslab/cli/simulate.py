"""`gnsslab simulate`: observations, orbits and truth from a preset."""

from typing import Annotated

import typer

EXAMPLE = "Example: gnsslab simulate --list     or: gnsslab simulate PRESET -o mydata --seed 1"

Preset = Annotated[str | None, typer.Argument(metavar="PRESET", hidden=True)]
Output = Annotated[str | None, typer.Option("-o", "--output", metavar="DIR", show_default=False, help="Folder to write into.")]
Seed = Annotated[int, typer.Option("--seed", metavar="N", show_default=False, help="Start of the random numbers [0]: same seed, same data.")]
List = Annotated[bool, typer.Option("--list", help="Say which presets there are, and stop.")]


def simulate(context: typer.Context, preset: Preset = None, output: Output = None, seed: Seed = 0, list_: List = False):
    """Simulate PRESET: master.obs, rover.obs, broadcast.nav and truth.csv."""
    if list_:
        _say_presets()
        return
    if preset is None:
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
        print(f"{name:{width}}  {getattr(preset, 'title', '')}".rstrip())


def _simulate(given, name, folder, seed):
    from gnsslab.cli.outputs import check_folder, write_provenance
    from gnsslab.simulate import PRESETS, write_simulation
    from gnsslab.simulate import simulate as simulated

    if name not in PRESETS:
        raise ValueError(f"there is no preset {name!r}: expected one of {', '.join(PRESETS)}")
    if seed < 0:
        raise ValueError(f"--seed {seed}: expected a whole number, zero or above")
    import numpy as np

    check_folder(folder)
    written = write_simulation(folder, simulated(PRESETS[name], np.random.default_rng(seed)))
    write_provenance([f"{folder}/simulation"], "simulate", {k: v for k, v in given.items() if k != "list_"})
    print(f"written to {folder}: {', '.join(path.name for path in written)}")
