"""`gnsslab course`: the course on one port, for this machine's user or for a class, until Ctrl-C."""

import threading
import webbrowser
from contextlib import suppress
from urllib.parse import urlencode

from gnsslab.teaching.catalogue import LESSONS
from gnsslab.teaching.network import LOOPBACK, free_socket, names_of
from gnsslab.teaching.tokens import chosen_token, new_token
from gnsslab.teaching.visitor import open_class

BROWSER_AFTER = 1.0  # [s], by then the server answers
SHUTDOWN_SECONDS = 2  # open lessons are given this long when the server is stopped
KEEP_ALIVE = 75  # [s], longer than a student thinks between two moves


def serve(host="127.0.0.1", port=8000, open_browser=True, token=None, present=False, say=print):
    """Serve the course until Ctrl-C; a taken port means the next free one, and `say` tells.

    A host that other machines can reach serves a class: its token is drawn (None), chosen (a text) or none at all ("").
    Raises ValueError where the host is no address of this machine, no port is free or the token is none.
    """
    token = _token_for(host, token)
    with free_socket(host, port) as listener:
        taken = listener.getsockname()[1]
        if taken != port:
            say(f"port {port} is taken; using {taken}")
        links = [f"http://{name}:{taken}/{_query(token)}" for name in names_of(host)]
        _say_links(links, say)
        if host not in LOOPBACK:
            say(_class_words(token, open_class()))
        threading.Thread(target=warm_up, daemon=True).start()
        if open_browser:
            threading.Timer(BROWSER_AFTER, webbrowser.open, (links[0],)).start()
        run(listener, token, present)
    say("stopped")


def run(listener, token, present):
    """Serve the course on a listening socket, in this process, until Ctrl-C."""
    import uvicorn

    from gnsslab.teaching.site import course_app

    app = course_app(token, present)
    config = uvicorn.Config(app, log_level="warning", timeout_graceful_shutdown=SHUTDOWN_SECONDS, timeout_keep_alive=KEEP_ALIVE, server_header=False)
    with suppress(KeyboardInterrupt):  # uvicorn hands Ctrl-C on once it has closed everything, unless a lesson took the signal for itself
        uvicorn.Server(config).run(sockets=[listener])


def warm_up():
    """Load engine and figures and compile the kernels, so that the first student need not wait (20 s right after installing)."""
    from gnsslab.figures.kept import KeptPicture

    for lesson in LESSONS:
        for lab in lesson.open_labs().values():
            result = lab.run()
            for drawing in () if result.problem else lab.drawings():
                KeptPicture(drawing.build, drawing.width, drawing.height).png(result)


def _token_for(host, token):
    """Return the token that opens the course, "" for none; raise ValueError where it makes no sense."""
    if host not in LOOPBACK:
        return new_token() if token is None else token and chosen_token(token)
    if token is not None:
        raise ValueError("a token is for a course that is open to the network: give --host 0.0.0.0 too")
    return ""


def _query(token):
    return f"?{urlencode({'token': token})}" if token else ""


def _say_links(links, say):
    say(f"the course is at {links[0]} (stop it with Ctrl-C)")
    for link in links[1:]:
        say(f"or at {link}")


def _class_words(token, folder):
    """Return who is let in, and where the answers are kept."""
    who = "share this link with the class: whoever has it is let in" if token else "there is no token: whoever reaches this machine is let in"
    return f"{who}\nwhat students answer is kept in {folder}, one file a browser"
