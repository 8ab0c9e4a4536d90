"""`gnsslab course`: the lessons in the browser."""

from typing import Annotated

import typer

from gnsslab.cli.options import within

EXAMPLE = "Examples: gnsslab course --port 8080     gnsslab course --host 0.0.0.0     (a class)"

Host = Annotated[str, typer.Option("--host", metavar="ADDRESS", show_default=False, help="Address to serve on; 0.0.0.0 for a class [127.0.0.1].")]
Port = Annotated[int, typer.Option("--port", metavar="N", show_default=False, help="Port; taken: the next free one [8000].")]
NoBrowser = Annotated[bool, typer.Option("--no-browser", help="Serve only, open nothing.")]
Present = Annotated[bool, typer.Option("--present", help="Lessons as for a projector: large, one picture, no answers.")]
Token = Annotated[str | None, typer.Option("--token", metavar="TEXT", show_default=False, help="Token that opens a class [drawn anew].")]
NoToken = Annotated[bool, typer.Option("--no-token", help="Let in whoever reaches this machine.")]
Jupyter = Annotated[bool, typer.Option("--jupyter", help="The lessons as notebooks in JupyterLab, in ./gnsslab-course.")]
Workers = Annotated[int | None, typer.Option("--workers", metavar="N", show_default=False, help="Processes that serve a class [one a core].")]


def course(
    host: Host = "127.0.0.1",
    port: Port = 8000,
    no_browser: NoBrowser = False,
    present: Present = False,
    token: Token = None,
    no_token: NoToken = False,
    workers: Workers = None,
    jupyter: Jupyter = False,
):
    """Open the course in your browser: all lessons on one page, until you press Ctrl-C."""
    within("--port", port, 1, 65535, "a port number")
    if workers is not None:
        within("--workers", workers, 1, 64, "processes")
    if token is not None and no_token:
        raise ValueError("--token and --no-token exclude each other: give one of them")
    if jupyter:
        _notebooks(
            host, port, no_browser, {"--present": present, "--token": token is not None, "--no-token": no_token, "--workers": workers is not None}
        )
        return
    from gnsslab.teaching.server.command import serve

    serve(host, port, open_browser=not no_browser, token="" if no_token else token, workers=workers, present=present)


def _notebooks(host, port, no_browser, others):
    for option, is_given in others.items():
        if is_given:
            raise ValueError(f"--jupyter and {option} exclude each other: give one of them")
    from gnsslab.teaching.jupyter.command import serve_notebooks

    serve_notebooks(host, port, open_browser=not no_browser)
