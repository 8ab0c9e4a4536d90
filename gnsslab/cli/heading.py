"""`gnsslab heading`: attitude of a two-antenna baseline."""

import math
from typing import Annotated

import typer

from gnsslab.cli import options as o

EXAMPLE = "Example: gnsslab heading master.obs rover.obs broadcast.nav -o heading.csv --length 1.167"

Output = Annotated[str, typer.Option("-o", "--output", metavar="OUT.csv", help="Table to write.")]
Length = Annotated[
    float | None, typer.Option("--length", metavar="M", show_default=False, help="Distance of the antennas [m], used to fix integers.")
]
LengthSigma = Annotated[float, typer.Option("--length-sigma", metavar="M", show_default=False, help="Its standard deviation [0.005].")]
MountHeading = Annotated[
    float, typer.Option("--mount-heading", metavar="DEG", show_default=False, help="Heading of the baseline on the vehicle [0].")
]


def heading(
    context: typer.Context,
    master: o.Master,
    rover: o.Rover,
    navigation: o.Navigation,
    output: Output,
    plot: o.Plot = None,
    length: Length = None,
    length_sigma: LengthSigma = 0.005,
    mount_heading: MountHeading = 0.0,
    mask_deg: o.MaskDeg = 15.0,
    systems: o.Systems = "GECJ",
    frequencies: o.Frequencies = None,
    signals: o.Signals = None,
    single_epoch: o.SingleEpoch = False,
    start: o.Start = None,
    end: o.End = None,
    every: o.Every = None,
):
    """Heading and pitch of the baseline MASTER to ROVER, from two observation files and orbits."""
    solver = o.solver_options(systems, frequencies, signals, mask_deg, single_epoch) | _mount(length, length_sigma, mount_heading)
    _heading(context.params, (master, rover, navigation), o.checked_span(start, end, every), solver, output, plot)


def _mount(length, length_sigma, mount_heading):
    return {
        "length": None if length is None else o.positive("--length", length, "a length in metres"),
        "length_sigma": o.positive("--length-sigma", length_sigma, "metres"),
        "mount_heading": math.radians(o.finite("--mount-heading", mount_heading, "degrees")),
    }


def _heading(given, files, span, solver, output, plot):
    from gnsslab.cli.baseline import finish, open_inputs
    from gnsslab.cli.progress import progress_bar
    from gnsslab.cli.tables import write_attitude_csv

    if output.lower().endswith(".pos"):
        raise ValueError(f"-o {output}: heading writes CSV; end the name in .csv (RTKLIB's format is for `gnsslab rtk`)")
    inputs = open_inputs(files, span, output, plot)
    from gnsslab.systems.dual_antenna import dual_antenna_attitude

    with progress_bar("heading") as progress:
        attitude = dual_antenna_attitude(inputs.master, inputs.rover, inputs.ephemerides, **solver, progress=progress)
    write_attitude_csv(output, attitude, inputs.rover.time)
    inputs = inputs._replace(notes=(*inputs.notes, *_unpaired(inputs.master.time, inputs.rover.time), *attitude.warnings))
    finish("heading", given, inputs, attitude, output, plot, _picture, _method(solver["length"], solver["length_sigma"]))


def _unpaired(time_master, time_rover):
    """Say how many of the rover's epochs have none of the master's, where there are any."""
    from gnsslab.gnss.differences import common_epochs

    common, all_ = len(common_epochs(time_master, time_rover)[0]), len(time_rover)
    return [] if common == all_ else [f"the master has an epoch for {common} of the rover's {all_}: the others have no heading"]


def _method(length, length_sigma):
    """Say for the record what is made of the known length."""
    if length is None:
        return "length not used"
    return f"length {length:g} m, sigma {length_sigma:g} m: in the search for the integers, and as a measurement of the baseline they give"


def _picture(attitude):
    from gnsslab.figures.attitude import plot_attitude

    return plot_attitude(attitude)
