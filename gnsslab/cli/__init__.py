"""The command line `gnsslab`: one file a command; this one is the frame that turns errors into one plain line."""

import os
import sys
from typing import Annotated

import typer

from gnsslab.cli import answers, convert, course, data, doctor, grade, heading, info, monitor, reproduce, rtk, simulate, worksheet

SETTINGS = {"help_option_names": ["-h", "--help"], "max_content_width": 100}
app = typer.Typer(
    rich_markup_mode=None,  # plain help: half the time of a decorated one
    pretty_exceptions_enable=False,
    add_completion=False,
    no_args_is_help=True,
    context_settings=SETTINGS,
    epilog="Example: gnsslab course     (opens the lessons in your browser)",
)
app.command("course", epilog=course.EXAMPLE)(course.course)
app.command("answers", epilog=answers.EXAMPLE)(answers.answers)
app.command("worksheet", epilog=worksheet.EXAMPLE)(worksheet.worksheet)
app.command("grade", epilog=grade.EXAMPLE)(grade.grade)
app.command("info", epilog=info.EXAMPLE)(info.info)
app.command("heading", epilog=heading.EXAMPLE)(heading.heading)
app.command("rtk", epilog=rtk.EXAMPLE)(rtk.rtk)
app.command("convert", epilog=convert.EXAMPLE)(convert.convert)
app.command("monitor", epilog=monitor.EXAMPLE)(monitor.monitor)
app.command("simulate", epilog=simulate.EXAMPLE)(simulate.simulate)
app.command("reproduce", epilog=reproduce.EXAMPLE)(reproduce.reproduce)
app.add_typer(data.app, name="data", epilog=data.EXAMPLE)
app.command("doctor", epilog=doctor.EXAMPLE)(doctor.doctor)


def main(argv=None):
    """Run the command line and return its exit status: 0; 1 something given is wrong; 2 the command is not understood."""
    try:
        app(args=argv, prog_name="gnsslab")
    except SystemExit as end:
        return end.code or 0
    except (ValueError, OSError) as error:
        return _fail(plain_line(error))
    except Exception as error:  # a mistake of ours: one line for the user, the whole story for whoever mends it
        if os.environ.get("GNSSLAB_TRACEBACK"):
            raise
        name = type(error).__name__
        return _fail(f"a mistake in gnsslab ({name}: {plain_line(error)}): set GNSSLAB_TRACEBACK=1, try again, and report what is shown")
    return 0


def _fail(words):
    print(f"gnsslab: {words}", file=sys.stderr)
    return 1


def plain_line(error):
    """Return an error as one line for the user.

    >>> plain_line(FileNotFoundError(2, "No such file or directory", "a.obs"))
    'a.obs: no such file or directory'
    """
    if isinstance(error, OSError) and error.strerror:
        place = f"{error.filename}: " if error.filename else ""
        return f"{place}{error.strerror[0].lower()}{error.strerror[1:]}"
    return " ".join(str(error).split()) or type(error).__name__


def _say_version(wanted):
    if wanted:
        from gnsslab import __version__

        print(f"gnsslab {__version__}")
        raise typer.Exit


@app.callback()
def gnsslab(
    version: Annotated[bool, typer.Option("--version", callback=_say_version, is_eager=True, help="Say the version and stop.")] = False,
):
    """Precise GNSS by hand: carrier phase, integers, attitude; a course and tools."""
