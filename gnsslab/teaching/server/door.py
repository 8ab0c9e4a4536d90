"""The door of the course: who is let in, and what those who are not are told. It stands before every page, file and websocket.

A guard looks at a connection and hands back a response that turns it away, or None. On this machine's own course the
guards keep out pages of other sites that are open in the same browser; a class asks for its token besides.
"""

from urllib.parse import urlsplit

from starlette.requests import HTTPConnection
from starlette.responses import HTMLResponse, RedirectResponse
from starlette.websockets import WebSocketClose

from gnsslab.teaching.server import refusals
from gnsslab.teaching.server.network import LOOPBACK
from gnsslab.teaching.server.tokens import is_same_token
from gnsslab.teaching.visitor import BROWSER_COOKIE, browser_of, new_browser

TOKEN_COOKIE = "gnsslab-token"
TERM = 200 * 24 * 3600  # [s], how long a browser keeps its token and its id
UPLOAD_AT_MOST = 40_000_000  # bytes of one request in a class: a file of 30 MB as the browser packs it
REFUSED = 1008  # close code of a websocket: against the rules
READING = ("GET", "HEAD", "OPTIONS")


class Door:
    """An ASGI app behind guards."""

    def __init__(self, app, guards):
        self.app = app
        self.guards = guards

    async def __call__(self, scope, receive, send):
        answer = self.app if scope["type"] == "lifespan" else self._refusal(scope) or self.app
        await answer(scope, receive, send)

    def _refusal(self, scope):
        connection = HTTPConnection(scope)
        refusal = next(filter(None, (guard(connection) for guard in self.guards)), None)
        return WebSocketClose(code=REFUSED) if refusal and scope["type"] == "websocket" else refusal


def guards_of_own_course():
    """Return the guards of a course on this machine for its user."""
    return (only_this_machine, same_site)


def guards_of_class(token):
    """Return the guards of a course that is open to the network; with no token, whoever finds it is let in."""
    return (same_site, *([TokenGuard(token)] if token else []), small_enough)


def only_this_machine(connection):
    """Turn away whoever calls this machine by a name of the outer world: a foreign page may have pointed its own name at us."""
    host = connection.headers.get("host", "")
    return None if _host_name(host) in LOOPBACK else _page(refusals.foreign_host(host), 403)


def same_site(connection):
    """Turn away what a page of another site sends: answers, resets and websockets come from our own pages only."""
    origin = connection.headers.get("origin")
    is_reading = connection.scope.get("method") in READING  # a websocket has no method
    if origin is None or is_reading or origin.partition("://")[2] == connection.headers.get("host"):
        return None
    return _page(refusals.foreign_site(origin), 403)


def small_enough(connection):
    """Turn away what is too large to keep in memory for thirty students."""
    if "chunked" in connection.headers.get("transfer-encoding", ""):
        return _page(refusals.unknown_length(), 411)
    length = connection.headers.get("content-length", "0")
    return _page(refusals.too_large(int(length), UPLOAD_AT_MOST), 413) if int(length) > UPLOAD_AT_MOST else None


class TokenGuard:
    """Lets in who has the token: from a link, or typed once; a cookie remembers it."""

    def __init__(self, token):
        self.token = token

    def __call__(self, connection):
        typed = connection.query_params.get("token")
        if typed is None:
            knows = is_same_token(connection.cookies.get(TOKEN_COOKIE, ""), self.token)
            return None if knows else _page(refusals.ask_for_token(connection.query_params), 401)
        if not is_same_token(typed, self.token):
            return _page(refusals.wrong_token(connection.query_params), 403)
        return self._let_in(connection)

    def _let_in(self, connection):
        """Return to the same address without the token, which the browser now keeps for itself."""
        welcome = RedirectResponse(connection.url.remove_query_params("token"), 303)
        _keep(welcome, TOKEN_COOKIE, self.token)
        return welcome


class BrowserIds:
    """An ASGI app whose visitors each have an id, given with the first answer and kept in a cookie."""

    def __init__(self, app, new_id=new_browser):
        self.app = app
        self.new_id = new_id

    async def __call__(self, scope, receive, send):
        is_new = scope["type"] == "http" and browser_of(HTTPConnection(scope).cookies) is None
        await self.app(scope, receive, self._naming(send) if is_new else send)

    def _naming(self, send):
        """Return `send` with an id in the answer. The next request comes on a new connection: that one shows who is calling."""
        card = HTMLResponse()
        _keep(card, BROWSER_COOKIE, self.new_id())
        extra = [(b"connection", b"close"), *((name, value) for name, value in card.raw_headers if name == b"set-cookie")]

        async def send_named(message):
            if message["type"] == "http.response.start":
                message = message | {"headers": [*message.get("headers", []), *extra]}
            await send(message)

        return send_named


def _keep(response, name, value):
    response.set_cookie(name, value, max_age=TERM, httponly=True, samesite="lax")


def _page(text, status):
    return HTMLResponse(text, status, {"cache-control": "no-store"})


def _host_name(host):
    """Return the name in a Host header, without its port.

    >>> _host_name("localhost:8000"), _host_name("[::1]:8000"), _host_name("[::1")
    ('localhost', '::1', '')
    """
    try:
        return urlsplit(f"//{host}").hostname or ""
    except ValueError:  # brackets that do not close
        return ""
