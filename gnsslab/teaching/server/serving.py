"""One process that serves the course: the server, what it loads in advance, and a guard against a fault of Python."""

import ast
import threading
from contextlib import suppress

from gnsslab.teaching.catalogue import LESSONS

SHUTDOWN_SECONDS = 2  # open lessons are given this long when the server is stopped
KEEP_ALIVE = 75  # [s], longer than a student thinks between two moves


def serve_here(listener, token, present):
    """Serve the course on a listening socket, in this process, until Ctrl-C."""
    from gnsslab.teaching.server.site import course_app

    server = course_server(course_app(token, present))
    with suppress(KeyboardInterrupt):  # uvicorn hands Ctrl-C on once it has closed everything, unless a lesson took the signal for itself
        server.run(sockets=[listener])


def course_server(app):
    """Return the server of an app of the course, which loads what lessons need while the first student still reads."""
    import uvicorn

    parse_one_at_a_time()
    threading.Thread(target=warm_up, daemon=True).start()
    config = uvicorn.Config(
        app,
        loop="asyncio",  # another one would not take connections that are handed over
        ws_per_message_deflate=False,  # pictures are compressed already: 10 ms of a move for nothing
        log_level="warning",
        server_header=False,
        timeout_keep_alive=KEEP_ALIVE,
        timeout_graceful_shutdown=SHUTDOWN_SECONDS,
    )
    return uvicorn.Server(config)


def warm_up():
    """Load engine and figures and compile the kernels, so that the first student need not wait (a minute right after installing)."""
    from gnsslab.figures.kept import KeptPicture

    for lesson in LESSONS:
        for lab in lesson.open_labs().values():
            result = lab.run()
            for drawing in () if result.problem else lab.drawings():
                KeptPicture(drawing.build, drawing.width, drawing.height).png(result)


def parse_one_at_a_time():
    """Let one thread at a time parse Python source.

    Python 3.11 counts the depth of a parse in one place for all threads: where the lessons of a class open at once, now and
    then one fails with "SystemError: AST constructor recursion depth mismatch".
    """
    if not hasattr(ast.parse, "one_at_a_time"):
        ast.parse = _one_at_a_time(ast.parse)


def _one_at_a_time(parse):
    lock = threading.RLock()  # a finalizer may parse while its own thread does

    def parse_alone(*args, **options):
        with lock:
            return parse(*args, **options)

    parse_alone.one_at_a_time = True
    return parse_alone
