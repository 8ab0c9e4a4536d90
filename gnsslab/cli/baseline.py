"""What `heading` and `rtk` share: two observation files and navigation in, the chosen epochs out."""

from pathlib import Path
from typing import NamedTuple

from gnsslab.cli.progress import note

NOTES_SHOWN = 10


class Inputs(NamedTuple):
    """What a baseline is solved from."""

    master: object  # Observations
    rover: object  # Observations
    ephemerides: object
    files: tuple  # names of all input files
    notes: tuple  # what was set aside while reading, in words


def open_inputs(files, span, output, plot):
    """Return the Inputs of master, rover and navigation, once it is sure that the results can be written."""
    from gnsslab.cli.outputs import PICTURES, check_output, check_picture

    if Path(output).suffix.lower() in PICTURES:
        raise ValueError(f"-o {output}: expected the name of a table, such as OUT.csv; a picture's name stands after --plot")
    named = (files[0], files[1], *files[2])
    check_output(output, named)
    check_picture(plot, named)
    return read_inputs(*files, span)


def finish(command, given, inputs, solution, output, plot, draw, method=""):
    """Draw the picture where one is wanted, write what made the outputs beside them, and say how it went."""
    from gnsslab.cli.outputs import write_provenance

    if plot:
        draw(solution).savefig(plot)
    write_provenance([output, plot] if plot else [output], command, given, inputs.files, inputs.notes, method)
    say_notes(inputs.notes)
    if not solution.status.any():
        note("no epoch has a solution: look at both files with `gnsslab info`, and lower --mask-deg or add --systems")
    print(f"{solution}\nwritten to {output}")


def read_inputs(master, rover, navigation, span):
    """Read the files of a baseline and keep the epochs of the span."""
    from gnsslab.gnss.rinex import read_rinex_nav, read_rinex_obs

    readings = read_rinex_obs(master), read_rinex_obs(rover)
    _refuse_same_measurements(*readings, (master, rover))
    ephemerides = read_rinex_nav(*navigation)
    notes = (*_named(readings[0], master), *_named(readings[1], rover), *ephemerides.warnings)
    return Inputs(*_chosen_epochs(readings, span, (master, rover)), ephemerides, (master, rover, *navigation), notes)


def _named(observations, path):
    return tuple(f"{Path(path).name}: {warning}" for warning in observations.warnings)


def say_notes(notes):
    """Say on stderr what was set aside on the way: only once all went well, so that a failure stays one plain line."""
    for text in notes[:NOTES_SHOWN]:
        note(text)
    if len(notes) > NOTES_SHOWN:
        note(f"and {len(notes) - NOTES_SHOWN} more, all in the .json beside the output")


def _refuse_same_measurements(one, other, names):
    """Two receivers never measure the same to the last digit: then it is one file twice, or a copy of it."""
    import numpy as np

    same = one.tables.keys() == other.tables.keys() and all(
        np.array_equal(one.tables[system].value, other.tables[system].value, equal_nan=True) for system in one.tables
    )
    if same and len(one.time):
        raise ValueError(f"{names[0]} and {names[1]} hold the same measurements: give the observations of two receivers")


def _chosen_epochs(readings, span, names):
    """Cut both receivers' epochs to the span, and to the grid of --every."""
    from gnsslab.gnss.selection import in_span, keep_epochs

    inside = [_something(in_span(reading.time, span.start, span.end), reading, name) for reading, name in zip(readings, names, strict=True)]
    chosen = [reading if keep.all() else keep_epochs(reading, keep) for reading, keep in zip(readings, inside, strict=True)]
    return _thinned(*chosen, span.every) if span.every else chosen


def _thinned(master, rover, every):
    """Return both on a grid that starts at the rover's first epoch; where the master has none on it, at the first in common."""
    from gnsslab.gnss.differences import common_epochs
    from gnsslab.gnss.selection import keep_epochs, on_grid

    common = common_epochs(master.time, rover.time)[1]
    if not len(common):
        return master, rover  # the solver says it better than two grids that miss each other
    origin = rover.time[0 if on_grid(master.time, rover.time[0], every).any() else common[0]]
    return [keep_epochs(each, on_grid(each.time, origin, every)) for each in (master, rover)]


def _something(keep, reading, name):
    from gnsslab.gnss.times import iso_text

    if not len(keep):
        raise ValueError(f"{name} has no epochs: give a file with observations")
    if not keep.any():
        first, last = iso_text(reading.time[0]), iso_text(reading.time[-1])
        raise ValueError(f"{name} has no epochs between --from and --to: it spans {first} to {last} (GPS time)")
    return keep
