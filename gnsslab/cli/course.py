"""`gnsslab course`: the lessons in the browser."""

from typing import Annotated

import typer

from gnsslab.cli.options import within

EXAMPLE = "Example: gnsslab course --port 8080"

Host = Annotated[str, typer.Option("--host", metavar="ADDRESS", show_default=False, help="Address to serve on [127.0.0.1].")]
Port = Annotated[int, typer.Option("--port", metavar="N", show_default=False, help="Port; taken: the next free one [8000].")]
NoBrowser = Annotated[bool, typer.Option("--no-browser", help="Serve only, open nothing.")]


def course(host: Host = "127.0.0.1", port: Port = 8000, no_browser: NoBrowser = False):
    """Open the course in your browser: all lessons on one page, until you press Ctrl-C."""
    within("--port", port, 1, 65535, "a port number")
    from gnsslab.teaching.course import serve

    serve(host, port, open_browser=not no_browser)
