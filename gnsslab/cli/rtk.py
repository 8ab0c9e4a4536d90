"""`gnsslab rtk`: relative positioning, base to rover."""

from typing import Annotated

import typer

from gnsslab.cli import options as o

EXAMPLE = "Example: gnsslab rtk master.obs rover.obs broadcast.nav -o rover.csv --static"
MISPLACED = 30.0  # [m], more than single points err
EARTH_RADIUS_RANGE = 6.33e6, 6.40e6  # [m] from the lowest shore at the poles to the highest mountain at the equator, with room

Output = Annotated[str, typer.Option("-o", "--output", metavar="OUT.csv", help="Table to write; OUT.pos: RTKLIB's format.")]
BasePosition = Annotated[str | None, typer.Option("--base-position", metavar="X,Y,Z", show_default=False, help="Of the base's antenna, ECEF [m].")]
Static = Annotated[bool, typer.Option("--static", help="The rover does not move.")]


def rtk(
    context: typer.Context,
    base: o.Base,
    rover: o.Rover,
    navigation: o.Navigation,
    output: Output,
    base_position: BasePosition = None,
    static: Static = False,
    plot: o.Plot = None,
    mask_deg: o.MaskDeg = 15.0,
    systems: o.Systems = "GECJ",
    frequencies: o.Frequencies = None,
    signals: o.Signals = None,
    single_epoch: o.SingleEpoch = False,
    start: o.Start = None,
    end: o.End = None,
    every: o.Every = None,
):
    """Position of ROVER relative to BASE, from two observation files and orbits."""
    solver = o.solver_options(systems, frequencies, signals, mask_deg, single_epoch)
    solver |= {"static": static, "base_position": checked_position(base_position)}
    _rtk(context.params, (base, rover, navigation), o.checked_span(start, end, every), solver, output, plot)


def checked_position(text):
    """Return the ECEF position (3,) [m] of "X,Y,Z", None for None; raise ValueError where it is no place on the ground."""
    if text is None:
        return None
    import numpy as np

    try:
        position = np.array([float(part) for part in text.split(",")])
    except ValueError:
        position = np.empty(0)
    if position.shape != (3,):
        raise ValueError(f"--base-position {text}: expected three ECEF coordinates in metres, like -3959400.631,3385704.533,3667523.111")
    if not EARTH_RADIUS_RANGE[0] < np.linalg.norm(position) < EARTH_RADIUS_RANGE[1]:
        raise ValueError(f"--base-position {text} is not on the ground: expected ECEF coordinates in metres, about 6.37e6 from the origin")
    return position


def _rtk(given, files, span, solver, output, plot):
    from gnsslab.cli.baseline import finish, open_inputs
    from gnsslab.cli.progress import progress_bar

    inputs = with_base_position(open_inputs(files, span, output, plot), solver)
    from gnsslab.gnss.relative import solve_relative

    with progress_bar("rtk") as progress:
        relative = solve_relative(inputs.master, inputs.rover, inputs.ephemerides, **solver, progress=progress)
    _write(output, relative, inputs)
    finish("rtk", given, inputs, relative, output, plot, _picture)


def _write(output, relative, inputs):
    from gnsslab.cli.tables import write_relative_csv, write_relative_pos

    if output.lower().endswith(".pos"):
        write_relative_pos(output, relative, inputs.files)
    else:
        write_relative_csv(output, relative, inputs.rover.time)


def with_base_position(inputs, solver):
    """Fill in the base's position where none was given; return the inputs with notes on where it comes from and whether it fits."""
    from gnsslab.gnss.relative import distance_from_codes, header_position, station_position

    notes = inputs.notes
    if solver["base_position"] is None:
        solver["base_position"] = station_position(inputs.master, inputs.ephemerides)
        source = _source(solver["base_position"], header_position(inputs.master))
        notes = (*notes, "base at {:.4f},{:.4f},{:.4f}, from {}".format(*solver["base_position"], source))
    apart = distance_from_codes(solver["base_position"], inputs.master, inputs.ephemerides)
    if apart > MISPLACED:
        notes = (*notes, f"the base position is {apart:.0f} m from where the base's own codes place it; all positions are off by as much")
    return inputs._replace(notes=notes)


def _source(position, in_header):
    """Say in words where the base's position comes from."""
    if in_header is None:
        return "the mean of its single-point positions"
    if (position == in_header).all():
        return "its RINEX header (marker plus antenna delta)"
    return "the mean of its single-point positions, which contradict its RINEX header"


def _picture(relative):
    from gnsslab.figures.relative import plot_relative

    return plot_relative(relative)
