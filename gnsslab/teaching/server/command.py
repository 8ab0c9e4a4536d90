"""`gnsslab course`: the course on one port, for this machine's user or for a class, until Ctrl-C."""

import os
import threading
import webbrowser
from urllib.parse import urlencode

from gnsslab.teaching.server.front import serve_with_workers
from gnsslab.teaching.server.handing import can_hand_over
from gnsslab.teaching.server.network import LOOPBACK, free_socket, names_of
from gnsslab.teaching.server.serving import serve_here
from gnsslab.teaching.server.tokens import chosen_token, new_token
from gnsslab.teaching.visitor import open_class

BROWSER_AFTER = 1.0  # [s], by then the server answers
WORKERS_AT_MOST = 8  # by default: each takes 0.3 GB before its first student, and two serve thirty students


def serve(host="127.0.0.1", port=8000, open_browser=True, token=None, workers=None, present=False, say=print):
    """Serve the course until Ctrl-C; a taken port means the next free one, and `say` tells.

    A host that other machines can reach serves a class: its token is drawn (None), chosen (a text) or none at all (""), and
    it has as many worker processes as asked for, or as there are cores.
    Raises ValueError where the host is no address of this machine, no port is free or the token is none.
    """
    token, workers = _token_for(host, token), _workers_for(host, workers)
    with free_socket(host, port) as listener:
        links = [f"http://{name}:{listener.getsockname()[1]}/{_query(token)}" for name in names_of(host)]
        _say_where(links, listener, port, say)
        if host not in LOOPBACK:
            _say_class(token, open_class(), workers, say)
        if open_browser:
            threading.Timer(BROWSER_AFTER, webbrowser.open, (links[0],)).start()
        _serve(listener, token, workers, present, say)
    say("stopped")


def _serve(listener, token, workers, present, say):
    if workers == 1:
        serve_here(listener, token, present)
    else:
        serve_with_workers(listener, workers, {"token": token, "present": present}, say)


def _token_for(host, token):
    """Return the token that opens the course, "" for none; raise ValueError where it makes no sense."""
    if host not in LOOPBACK:
        return new_token() if token is None else token and chosen_token(token)
    if token is not None:
        raise ValueError("a token is for a course that is open to the network: give --host 0.0.0.0 too")
    return ""


def _workers_for(host, workers):
    """Return how many processes serve; raise ValueError where more than one makes no sense."""
    if host in LOOPBACK and workers not in (None, 1):
        raise ValueError("a course on this machine is served by one process; --workers is for a class: give --host 0.0.0.0 too")
    if host in LOOPBACK or not can_hand_over():
        return 1
    return min(_cores(), WORKERS_AT_MOST) if workers is None else workers


def _cores():
    """Return how many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _query(token):
    return f"?{urlencode({'token': token})}" if token else ""


def _say_where(links, listener, port, say):
    taken = listener.getsockname()[1]
    if taken != port:
        say(f"port {port} is taken; using {taken}")
    say(f"the course is at {links[0]} (stop it with Ctrl-C)")
    for link in links[1:]:
        say(f"or at {link}")


def _say_class(token, folder, workers, say):
    """Say who is let in, where answers are kept, and how many processes serve."""
    say("share this link with the class: whoever has it is let in" if token else "there is no token: whoever reaches this machine is let in")
    say(f"what students answer is kept in {folder}, one file a browser")
    if workers > 1:
        say(f"{workers} worker processes serve it")
    elif not can_hand_over():
        say("one process serves it: this system cannot share a class among several")
