"""`gnsslab convert`: an RTCM 3 log as RINEX files."""

from typing import Annotated

import typer

EXAMPLE = "Example: gnsslab convert base.rtcm3 -o converted     (writes converted/base.obs and base.nav)"

File = Annotated[str, typer.Argument(metavar="FILE", hidden=True)]
Output = Annotated[str, typer.Option("-o", "--output", metavar="DIR", help="Folder to write into.")]
Start = Annotated[
    str | None,
    typer.Option("--start", metavar="DATE", show_default=False, help="Day it was recorded, 2026-06-26: for logs that do not say their week."),
]


def convert(context: typer.Context, file: File, output: Output, start: Start = None):
    """Convert FILE, a log of RTCM 3 messages, to RINEX: observations and navigation."""
    from gnsslab.cli.options import checked_time
    from gnsslab.cli.outputs import write_provenance
    from gnsslab.cli.progress import progress_bar
    from gnsslab.gnss.rtcm import read_rtcm

    day = checked_time("--start", start)
    with progress_bar("read") as progress:
        log = read_rtcm(file, day, progress)
    _refuse_nothing(log, file)
    written = _write(log, *_places(file, output))
    write_provenance([path for path, _ in written], "convert", context.params, [file], log.warnings, as_typed={})
    _say(log, written)


def _refuse_nothing(log, file):
    if not log.observations.tables and not len(log.ephemerides.satellite):
        found = ", ".join(f"{number} ({count})" for number, count in log.messages.items())
        raise ValueError(f"{file} has nothing to convert: expected observations (MSM4 to MSM7) or ephemerides, found messages {found}")


def _places(file, folder):
    """Return where observations and navigation go, once it is sure that files can be written there."""
    from pathlib import Path

    from gnsslab.cli.outputs import check_folder, check_output

    check_folder(folder)
    stem = Path(file.removesuffix(".gz")).stem
    places = [Path(folder) / f"{stem}{ending}" for ending in (".obs", ".nav")]
    for place in places:
        check_output(place, [file])
    return places


def _write(log, observations, navigation):
    """Write what the log holds; return the paths, each with words on what is in it."""
    from gnsslab.gnss.rinex import write_rinex_nav, write_rinex_obs

    written = []
    if log.observations.tables:
        write_rinex_obs(observations, log.observations)
        written.append((observations, log.observations))
    if len(log.ephemerides.satellite):
        write_rinex_nav(navigation, log.ephemerides)
        written.append((navigation, log.ephemerides))
    return written


def _say(log, written):
    from gnsslab.cli.baseline import say_notes
    from gnsslab.cli.progress import note

    say_notes(log.warnings)
    if not log.observations.tables:
        note("the log has no observations (MSM4 to MSM7)")
    if not len(log.ephemerides.satellite):
        note("the log has no ephemerides: take the navigation file from another source")
    for path, record in written:
        print(f"{record}\nwritten to {path}")
