"""The course in the browser: our own home page, and each lesson as a marimo app, on one port."""

import os
import socket
import threading
import webbrowser
from contextlib import asynccontextmanager, chdir

from gnsslab.data.locations import project_folder
from gnsslab.teaching.catalogue import LESSONS
from gnsslab.teaching.pages import home_page

LOOPBACK = ("127.0.0.1", "localhost", "::1")
PORTS_TRIED = 50  # a taken port means the next free one, up to this many further on
LAST_PORT = 65_535
BROWSER_AFTER = 1.0  # [s], by then the server answers
SHUTDOWN_SECONDS = 2  # open lessons are given this long when the server is stopped


def serve(host="127.0.0.1", port=8000, open_browser=True, say=print):
    """Serve the course until Ctrl-C; a taken port means the next free one, and `say` tells.

    Raises ValueError where the host is no address of this machine or no port is free.
    """
    import uvicorn

    if host not in LOOPBACK:
        os.environ["GNSSLAB_COURSE_SHARED"] = "1"  # uploads only: no visitor names a path on this machine
    listener = free_socket(host, port)
    taken = listener.getsockname()[1]
    try:
        config = uvicorn.Config(course_app(), log_level="warning", timeout_graceful_shutdown=SHUTDOWN_SECONDS)
        if taken != port:
            say(f"port {port} is taken; using {taken}")
        address = f"http://{_shown(host)}:{taken}/"
        say(f"the course is at {address} (stop it with Ctrl-C)")
        threading.Thread(target=warm_up, daemon=True).start()
        if open_browser:
            threading.Timer(BROWSER_AFTER, webbrowser.open, (address,)).start()
        uvicorn.Server(config).run(sockets=[listener])
    except KeyboardInterrupt:
        pass  # uvicorn hands Ctrl-C on once it has closed everything, unless a lesson took the signal for itself
    finally:
        listener.close()
    say("stopped")


def warm_up():
    """Load engine and figures and compile the kernels, so that the first student need not wait (20 s right after installing)."""
    from gnsslab.figures.kept import KeptPicture
    from gnsslab.labs.north import north_lab

    lab = north_lab()
    result = lab.run()
    for drawing in lab.drawings():
        KeptPicture(drawing.build, drawing.width, drawing.height).png(result)


def course_app():
    """Return the whole course as an ASGI app: "/" is the home page, "/lesson/NN" a lesson."""
    import marimo
    from starlette.applications import Starlette
    from starlette.responses import HTMLResponse, RedirectResponse
    from starlette.routing import Mount, Route

    with chdir(project_folder("lessons")):  # where marimo looks for its display settings, once
        lessons = marimo.create_asgi_app(quiet=True, include_code=False)
    for lesson in LESSONS:
        lessons = lessons.with_app(path=lesson.address.rstrip("/"), root=str(lesson.path))

    async def home(request):
        return HTMLResponse(home_page())

    async def with_slash(request):
        return RedirectResponse(request.url.path + "/")

    slashless = [Route(lesson.address.rstrip("/"), with_slash) for lesson in LESSONS]
    apps = lessons.build()
    return Starlette(routes=[Route("/", home), *slashless, Mount("/", apps)], lifespan=lambda _: _sessions_end_with(apps))


@asynccontextmanager
async def _sessions_end_with(apps):
    """End every open lesson when the server stops: mounted apps are not told of it, and their threads would keep the process alive."""
    yield
    for route in apps.routes:
        manager = getattr(getattr(getattr(route, "app", None), "state", None), "session_manager", None)
        if manager is not None:
            await manager.shutdown()


def free_socket(host, port):
    """Return a listening socket at the port, or at the next free one.

    Raises ValueError where the host is no address of this machine or no port is free.
    """
    family = _address_family(host)
    problem = "ports end at 65535"
    for candidate in range(port, min(port + PORTS_TRIED, LAST_PORT + 1)):
        try:
            return socket.create_server((host, candidate), family=family)
        except OSError as error:
            problem = error.strerror
    raise ValueError(f"no free port from {port} to {port + PORTS_TRIED - 1} at {host} ({problem}): try another with --port")


def _address_family(host):
    try:
        return socket.getaddrinfo(host, None, type=socket.SOCK_STREAM)[0][0]
    except socket.gaierror:
        raise ValueError(f"{host} is no address of this machine: try 127.0.0.1, or 0.0.0.0 to serve a class") from None


def _shown(host):
    if host in ("0.0.0.0", "::"):
        return "127.0.0.1" if host == "0.0.0.0" else "[::1]"
    return f"[{host}]" if ":" in host else host
