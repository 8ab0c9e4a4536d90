"""`gnsslab monitor`: a coordinate series filtered, its outliers and steps found, an alarm given."""

from typing import Annotated

import typer

from gnsslab.cli import options as o

EXAMPLE = "Example: gnsslab monitor rover.csv -o filtered.csv --plot filtered.png"

Series = Annotated[str, typer.Argument(metavar="SERIES", hidden=True)]
Output = Annotated[str, typer.Option("-o", "--output", metavar="OUT.csv", help="Table to write.")]
Columns = Annotated[str | None, typer.Option("--columns", metavar="NAMES", show_default=False, help="What SERIES's columns are: time,north,east,up.")]
Unit = Annotated[str | None, typer.Option("--unit", metavar="mm", show_default=False, help="Unit of its positions: m, cm or mm [m].")]
Alarm = Annotated[float | None, typer.Option("--alarm", metavar="M", show_default=False, help="Displacement that the alarm is for [0.02 m].")]
Memory = Annotated[
    float | None, typer.Option("--memory", metavar="N", show_default=False, help="Epochs that the level is taken from: more, smoother.")
]


def monitor(
    context: typer.Context,
    series: Series,
    output: Output,
    plot: o.Plot = None,
    columns: Columns = None,
    unit: Unit = None,
    alarm: Alarm = None,
    memory: Memory = None,
    start: o.Start = None,
    end: o.End = None,
):
    """Filter SERIES (our CSV, RTKLIB's .pos, or a table of time, east, north, up); find outliers and steps."""
    chosen = _chosen(alarm=(alarm, "metres"), memory=(memory, "a number of epochs"))
    _monitor(context.params, series, o.checked_span(start, end, None), (columns, unit), chosen, output, plot)


def _chosen(**options):
    """Return the settings that were given; of the others the filter knows its own."""
    return {name: o.positive(f"--{name}", value, unit) for name, (value, unit) in options.items() if value is not None}


def _monitor(given, path, span, naming, chosen, output, plot):
    from gnsslab.cli.baseline import say_notes
    from gnsslab.cli.monitored import summary, write_monitored_csv
    from gnsslab.cli.outputs import write_provenance
    from gnsslab.cli.progress import progress_bar

    _check_outputs(path, output, plot)
    series, notes = _read(path, naming, span)
    from gnsslab.systems.monitoring import MonitorSettings
    from gnsslab.systems.monitoring import monitor as monitored_series

    settings = MonitorSettings(**chosen)
    with progress_bar("monitor") as progress:
        monitored = monitored_series(series, settings, progress)
    write_monitored_csv(output, monitored)
    if plot:
        _picture(monitored).savefig(plot)
    write_provenance([output, plot] if plot else [output], "monitor", given, [path], notes, repr(settings))
    say_notes(notes)
    print("\n".join([*summary(monitored), f"written to {output}"]))


def _check_outputs(path, output, plot):
    from pathlib import Path

    from gnsslab.cli.outputs import PICTURES, check_output, check_picture

    if Path(output).suffix.lower() in (*PICTURES, ".pos"):
        raise ValueError(f"-o {output}: monitor writes CSV; end the name in .csv (a picture's name stands after --plot)")
    check_output(output, [path])
    check_picture(plot, [path])


def _read(path, naming, span):
    """Return the Series of the file in the span, and notes; raise ValueError where it has no position there."""
    from gnsslab.cli.progress import progress_bar
    from gnsslab.gnss.selection import in_span
    from gnsslab.gnss.series_files import read_series
    from gnsslab.gnss.times import iso_text

    columns, unit = naming
    with progress_bar("read") as progress:
        series, notes = read_series(path, columns=columns, unit=unit, progress=progress)
    chosen = series.at(in_span(series.time, span.start, span.end))
    if not len(chosen):
        first, last = iso_text(series.time[0]), iso_text(series.time[-1])
        raise ValueError(f"{path} has no epochs between --from and --to: it spans {first} to {last} (GPS time)")
    if not chosen.is_solved.any():
        raise ValueError(f"{path} has no position at any of its {len(chosen)} epochs: nothing to monitor")
    return chosen, notes


def _picture(monitored):
    from gnsslab.figures.monitored import plot_monitored

    return plot_monitored(monitored)
