"""How a connection gets from one process to another: over a line, which is a pair of Unix sockets.

On a line come first the orders, one line of JSON, and then connections, each with one byte.
"""

import errno
import json
import socket


def can_hand_over():
    """Return whether this system lets one process hand a connection to another."""
    return hasattr(socket, "send_fds") and hasattr(socket, "AF_UNIX")


def give_orders(orders, line):
    """Send the orders, a dictionary: the first thing on a line."""
    line.sendall(json.dumps(orders).encode() + b"\n")


def orders_from(line):
    """Return the orders of the front: the first line. Nothing beyond it is read, for with it come connections."""
    text = b""
    while not text.endswith(b"\n"):
        byte = line.recv(1)
        if not byte:
            raise SystemExit  # the front is gone already
        text += byte
    return json.loads(text)


def hand(connection, line):
    """Hand a connection over and let go of it; raise OSError where the other end cannot take it."""
    with connection:
        socket.send_fds(line, [b"+"], [connection.fileno()])


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
        if not descriptors:  # this process has as many open as it may: the connection is lost, and the browser asks again
            raise OSError(errno.EMFILE, "too many open files")
        return socket.socket(fileno=descriptors[0]), None
