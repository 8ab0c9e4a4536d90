"""One worker process of a class: `python -m gnsslab.teaching.server.worker`, started by the front, which hands it connections.

Its standard input is a Unix socket. On it come its orders, one line of JSON, and then connections that browsers have opened.
When the line is closed the worker ends: so it never outlives the front.
"""

import os

from gnsslab.teaching.ending import end_process
from gnsslab.teaching.server.handing import HandedOver, orders_from
from gnsslab.teaching.server.seats import Seat, Usher
from gnsslab.teaching.server.serving import course_server
from gnsslab.teaching.server.site import course_app


def main():
    """Serve the connections that the front hands over until it closes the line."""
    line = HandedOver(fileno=os.dup(0))
    orders = orders_from(line)
    seat = Seat(orders["seat"], orders["seats"])
    server = course_server(Usher(course_app(orders["token"], orders["present"], seat.new_browser), seat))
    line.on_end = lambda: setattr(server, "should_exit", True)
    server.run(sockets=[line])


if __name__ == "__main__":
    main()
    end_process(0)
