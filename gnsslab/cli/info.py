"""`gnsslab info`: what is in a file."""

from typing import Annotated

import typer

EXAMPLE = "Example: gnsslab info rover.obs"

File = Annotated[str, typer.Argument(metavar="FILE", hidden=True)]


def info(file: File):
    """Say what is in a RINEX FILE or an RTCM 3 log: span, receiver, satellites and signals, slips, gaps."""
    from gnsslab.cli.summaries import summary

    print("\n".join(summary(file)))
