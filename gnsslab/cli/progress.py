"""Progress of long jobs, on stderr, where someone is looking."""

import sys
from contextlib import contextmanager


@contextmanager
def progress_bar(what):
    """Give a function progress(done, total) that moves a bar on stderr, or None where stderr is no terminal."""
    if not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console
    from rich.progress import Progress

    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(what, total=None)
        yield lambda done, total: bar.update(task, completed=done, total=total)


def note(text):
    """Say something by the way, one line on stderr."""
    print(f"note: {text}", file=sys.stderr)
