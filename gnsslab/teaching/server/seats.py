"""Which worker process serves which browser: its id says so, so that a lesson and all that is asked of it meet in one process."""

from typing import NamedTuple
from zlib import crc32

from starlette.requests import HTTPConnection
from starlette.responses import RedirectResponse

from gnsslab.teaching.visitor import browser_of, new_browser


class Seat(NamedTuple):
    """One worker among all."""

    number: int  # from 0
    of: int  # how many workers there are

    def is_of(self, browser):
        """Return whether a browser belongs to this worker."""
        return seat_number(browser, self.of) == self.number

    def new_browser(self):
        """Return an id for a browser that belongs to this worker."""
        return next(browser for browser in iter(new_browser, None) if self.is_of(browser))


def seat_number(browser, of):
    """Return the worker of a browser, 0 to of-1; the same in every process and after a restart."""
    return crc32(browser.encode("ascii")) % of


class Usher:
    """An ASGI app that sends browsers of other workers away to ask again, on a new connection.

    A browser may ask on a connection that it opened before it had its id; the new one is seen to by the front.
    """

    def __init__(self, app, seat):
        self.app = app
        self.seat = seat

    async def __call__(self, scope, receive, send):
        answer = self._elsewhere(scope) if scope["type"] == "http" else None
        await (answer or self.app)(scope, receive, send)

    def _elsewhere(self, scope):
        connection = HTTPConnection(scope)
        browser = browser_of(connection.cookies)
        if browser is None or self.seat.is_of(browser):
            return None
        return RedirectResponse(connection.url, 307, {"connection": "close", "cache-control": "no-store"})
