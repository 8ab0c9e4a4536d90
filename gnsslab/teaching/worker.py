"""One worker process of a class: `python -m gnsslab.teaching.worker`, started by the front, which hands it connections.

Its standard input is a Unix socket. On it come its orders, one line of JSON, and then connections that browsers have opened.
When the line is closed the worker ends: so it never outlives the front.
"""

import json
import os
import signal
import socket

from gnsslab.teaching.seats import Seat, Usher
from gnsslab.teaching.serving import course_server
from gnsslab.teaching.site import course_app


class HandedOver(socket.socket):
    """The line to the front in the shape of a listening socket: what it accepts are the connections handed over."""

    on_end = None  # called when the front has gone

    def listen(self, backlog=0):
        """Do nothing: others listen."""

    def accept(self):
        """Return the next connection and no address; BlockingIOError where there is none."""
        mark, descriptors, _, _ = socket.recv_fds(self, 1, 1)
        if not mark:
            self.on_end()
            raise BlockingIOError
        return socket.socket(fileno=descriptors[0]), None


def main():
    """Serve the connections that the front hands over until it closes the line."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the front's
    line = HandedOver(fileno=os.dup(0))
    orders = json.loads(_first_line(line))
    seat = Seat(orders["seat"], orders["seats"])
    server = course_server(Usher(course_app(orders["token"], orders["present"], seat.new_browser), seat))
    line.on_end = lambda: setattr(server, "should_exit", True)
    server.run(sockets=[line])


def _first_line(line):
    """Return what comes before the first newline; nothing beyond it is read, for with it come connections."""
    text = b""
    while not text.endswith(b"\n"):
        byte = line.recv(1)
        if not byte:
            raise SystemExit  # the front is gone already
        text += byte
    return text


if __name__ == "__main__":
    main()
