"""A browser in miniature: calls an ASGI app as a server would, and keeps cookies."""

import asyncio
import json
from http.cookies import SimpleCookie
from typing import NamedTuple
from urllib.parse import unquote, urlencode, urlsplit


class Answer(NamedTuple):
    """What came back: status, headers by their small names (several of a name in a list) and the text."""

    status: int
    headers: dict
    text: str

    def json(self):
        """Return the text as JSON means it."""
        return json.loads(self.text)


class SmallBrowser:
    """Visits an ASGI app that is served under an address, `http://localhost:8000`."""

    def __init__(self, app, address):
        self.app = app
        self.address = address
        self.cookies = {}

    def get(self, path, headers=None, query=None):
        """Ask for a page; a redirect is handed back, not followed."""
        return self.send("GET", path, headers, query)

    def post(self, path, headers=None):
        """Send nothing to an address."""
        return self.send("POST", path, headers)

    def send(self, method, path, headers=None, query=None):
        """Send a request and return the answer."""
        sent = asyncio.run(self._called(self._scope("http", path, headers, query) | {"method": method}, {"type": "http.request", "body": b""}))
        answer = _answer(sent)
        for cookie in answer.headers.get("set-cookie", []):
            self.cookies |= {name: morsel.value for name, morsel in SimpleCookie(cookie).items()}
        return answer

    def is_heard(self, path, headers=None):
        """Return whether a websocket is accepted."""
        sent = asyncio.run(self._called(self._scope("websocket", path, headers), {"type": "websocket.connect"}))
        assert sent[0]["type"] in ("websocket.accept", "websocket.close")
        return sent[0]["type"] == "websocket.accept"

    def _scope(self, kind, path, headers=None, query=None):
        parts = urlsplit(self.address)
        asked, _, given = path.partition("?")
        cookies = {"cookie": "; ".join(f"{name}={value}" for name, value in self.cookies.items())} if self.cookies else {}
        all_headers = {"host": parts.netloc} | cookies | (headers or {})
        return {
            "type": kind, "asgi": {"version": "3.0"}, "http_version": "1.1", "scheme": "http" if kind == "http" else "ws",
            "path": unquote(asked), "raw_path": asked.encode(), "root_path": "", "query_string": (given + urlencode(query or {})).encode(),
            "headers": [(name.encode(), value.encode("latin-1")) for name, value in all_headers.items()],
            "client": ("192.168.1.77", 50_000), "server": (parts.hostname, parts.port or 80), "state": {}, "subprotocols": [],
        }  # fmt: skip

    async def _called(self, scope, first):
        """Return all messages that the app sends in answer to the first one."""
        received, sent = [first], []

        async def receive():
            return received.pop() if received else {"type": f"{scope['type']}.disconnect"}

        async def send(message):
            sent.append(message)

        await self.app(scope, receive, send)
        return sent


def _answer(sent):
    headers = {}
    for name, value in sent[0]["headers"]:
        headers.setdefault(name.decode(), []).append(value.decode("latin-1"))
    text = b"".join(message.get("body", b"") for message in sent[1:]).decode("utf-8", errors="replace")
    return Answer(sent[0]["status"], {name: values if name == "set-cookie" else values[0] for name, values in headers.items()}, text)
