"""The door: who is let in, over HTTP and websockets alike."""

import pytest
from small_browser import SmallBrowser
from starlette.applications import Starlette
from starlette.responses import PlainTextResponse
from starlette.routing import Route, WebSocketRoute

from gnsslab.teaching.server.door import TOKEN_COOKIE, UPLOAD_AT_MOST, BrowserIds, Door, guards_of_class, guards_of_own_course, only_this_machine
from gnsslab.teaching.visitor import BROWSER_COOKIE, browser_of, new_browser

TOKEN = "k7mx-2fqp"


async def _inside(request):
    return PlainTextResponse(f"within, as {request.cookies.get(BROWSER_COOKIE)}")


async def _talk(websocket):
    await websocket.accept()
    await websocket.send_text("within")
    await websocket.close()


ROOM = Starlette(routes=[Route("/room", _inside, methods=["GET", "POST"]), WebSocketRoute("/talk", _talk)])


def own():
    return SmallBrowser(Door(ROOM, guards_of_own_course()), "http://localhost:8000")


def class_(token=TOKEN):
    return SmallBrowser(BrowserIds(Door(ROOM, guards_of_class(token))), "http://192.168.1.5:8000")


@pytest.mark.parametrize("host", ["localhost:8000", "127.0.0.1:8000", "127.0.0.1", "[::1]:8000", "LOCALHOST:9"])
def test_own_course_is_open_on_its_own_machine(host):
    assert own().get("/room", {"host": host}).status == 200
    assert own().is_heard("/talk", {"host": host})


@pytest.mark.parametrize("host", ["evil.example", "evil.example:8000", "localhost.evil.example", "192.168.1.5:8000", ""])
def test_own_course_is_not_called_by_other_names(host):
    answer = own().get("/room", {"host": host})
    assert answer.status == 403
    assert "127.0.0.1" in answer.text
    assert not own().is_heard("/talk", {"host": host})


@pytest.mark.parametrize("client", [own(), class_("")])
def test_other_sites_may_not_send(client):
    for origin in ("http://evil.example", "null", "http://localhost:9999", "http://192.168.1.5"):
        answer = client.post("/room", {"origin": origin})
        assert (answer.status, "another site" in answer.text) == (403, True)
        assert not client.is_heard("/talk", {"origin": origin})


@pytest.mark.parametrize(("client", "origin"), [(own(), "http://localhost:8000"), (class_(""), "http://192.168.1.5:8000")])
def test_own_pages_and_scripts_may_send(client, origin):
    assert client.post("/room", {"origin": origin}).status == 200
    assert client.post("/room").status == 200
    assert client.is_heard("/talk", {"origin": origin})


def test_a_link_from_another_site_is_followed():
    assert own().get("/room", {"origin": "http://evil.example"}).status == 200


def test_without_the_token_there_is_a_form_only():
    client = class_()
    for method in ("GET", "POST", "PUT"):
        answer = client.send(method, "/room?preset=far&lab=north")
        assert answer.status == 401
        assert "within, as" not in answer.text
        assert 'name="token"' in answer.text
        assert 'name="preset" value="far"' in answer.text
    assert not client.is_heard("/talk")


def test_the_link_lets_in_and_leaves_no_token_in_the_address():
    client = class_()
    answer = client.get(f"/room?token={TOKEN}&preset=far")
    assert (answer.status, answer.headers["location"]) == (303, "http://192.168.1.5:8000/room?preset=far")
    cookies = {cookie.split("=")[0]: cookie for cookie in answer.headers["set-cookie"]}
    assert set(cookies) == {TOKEN_COOKIE, BROWSER_COOKIE}
    assert all("HttpOnly" in cookie and "SameSite=lax" in cookie for cookie in cookies.values())
    assert client.get("/room").status == 200
    assert client.is_heard("/talk")


@pytest.mark.parametrize("typed", ["", "k7mx-2fqq", "k7mx", "пароль", "k7mx-2fqp-"[:-2]])
def test_a_wrong_token_is_said_to_be_wrong(typed):
    client = class_()
    answer = client.get("/room", query={"token": typed})
    assert (answer.status, "not the one of this class" in answer.text) == (403, True)
    assert client.get("/room").status == 401


@pytest.mark.parametrize("cookie", ["", "guess", "k7mx-2fqq"])
def test_a_wrong_cookie_is_no_token(cookie):
    client = class_()
    assert client.get("/room", {"cookie": f"{TOKEN_COOKIE}={cookie}"}).status == 401
    assert not client.is_heard("/talk", {"cookie": f"{TOKEN_COOKIE}={cookie}"})


def test_what_an_address_asks_for_is_shown_as_text_only():
    assert "<script>" not in class_().get("/room", query={'"><script>': '"><script>alert(1)</script>'}).text


def test_no_redirect_leaves_the_course():
    answer = class_().get(f"//evil.example/?token={TOKEN}")
    assert answer.headers["location"].startswith("http://192.168.1.5:8000/")


def test_every_browser_of_a_class_has_an_id_of_its_own_and_keeps_it():
    clients = [class_("") for _ in range(3)]
    for client in clients:
        first = client.get("/room")
        assert first.headers["connection"] == "close"
        assert "set-cookie" not in client.get("/room").headers
    ids = {browser_of(client.cookies) for client in clients}
    assert len(ids - {None}) == 3


def test_an_id_that_is_none_of_ours_is_replaced():
    answer = class_("").get("/room", {"cookie": f"{BROWSER_COOKIE}=../../x"})
    assert answer.headers["set-cookie"][0].startswith(f"{BROWSER_COOKIE}=")
    kept = class_("").get("/room", {"cookie": f"{BROWSER_COOKIE}={new_browser()}"})
    assert "set-cookie" not in kept.headers


def test_an_upload_too_large_for_a_class_is_refused_in_words():
    answer = class_("").post("/room", {"content-length": str(UPLOAD_AT_MOST + 1)})
    assert (answer.status, "at most 40 MB" in answer.text) == (413, True)
    assert class_("").post("/room", {"transfer-encoding": "chunked"}).status == 411
    assert class_("").post("/room", {"content-length": str(UPLOAD_AT_MOST)}).status == 200


@pytest.mark.parametrize("host", ["[::1", "[", "::::"])
def test_a_host_that_is_none_is_turned_away_in_words(host):
    from starlette.requests import Request

    request = Request({"type": "http", "method": "GET", "path": "/", "query_string": b"", "headers": [(b"host", host.encode())]})
    assert only_this_machine(request).status_code == 403
