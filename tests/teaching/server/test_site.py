"""The course as an app: every address answers with a page of ours, and each browser of a class has its own progress."""

import csv
import io

import pytest
from small_browser import SmallBrowser

from gnsslab.teaching.catalogue import LESSONS
from gnsslab.teaching.server.site import course_app
from gnsslab.teaching.visitor import CLASS, open_class, progress_of


@pytest.fixture
def own(monkeypatch, tmp_path):
    """A browser of the course on this machine."""
    monkeypatch.setenv("GNSSLAB_PROGRESS", str(tmp_path))
    monkeypatch.delenv(CLASS, raising=False)
    return SmallBrowser(course_app(), "http://localhost")


@pytest.fixture
def browsers(monkeypatch, tmp_path):
    """Two browsers of a class without a token, each with its id."""
    monkeypatch.setenv("GNSSLAB_PROGRESS", str(tmp_path))
    monkeypatch.setenv(CLASS, "")
    open_class()
    app = course_app()
    clients = [SmallBrowser(app, "http://192.168.1.5") for _ in range(2)]
    assert [client.get("/").status for client in clients] == [200, 200]
    return clients


def answers_of(client):
    return [entry["answer"] for entry in client.get("/progress.json").json()["entries"]]


@pytest.mark.parametrize("path", ["/", "/notation", "/data", "/glossary", *(lesson.address for lesson in LESSONS)])
def test_every_page_answers(own, path):
    answer = own.get(path)
    assert answer.status == 200
    assert answer.headers["content-type"].startswith("text/html")


def test_a_lesson_without_its_slash_is_found_with_what_was_asked(own):
    answer = own.get("/lesson/00?preset=far")
    assert answer.headers["location"].endswith("/lesson/00/?preset=far")


@pytest.mark.parametrize("path", ["/lesson/99/", "/nothing", "/lesson", "/a/b/c", "/notation/x", "/%3Cscript%3E"])
def test_unknown_addresses_get_a_page_with_the_way_home(own, path):
    answer = own.get(path)
    assert answer.status == 404
    assert 'href="/"' in answer.text
    assert "<script>" not in answer.text


def test_progress_is_downloaded_and_put_away(own, tmp_path):
    progress_of(None).record("00", "beam", "question", "119,7", True)
    assert answers_of(own) == ["119,7"]
    table = own.get("/progress.csv")
    assert table.headers["content-disposition"] == 'attachment; filename="gnsslab-progress.csv"'
    assert [row["answer"] for row in csv.DictReader(io.StringIO(table.text))] == ["119,7"]
    assert own.get("/progress/reset").status == 405
    assert answers_of(own) == ["119,7"]
    assert own.post("/progress/reset").headers["location"] == "/"
    assert answers_of(own) == []
    assert len(list(tmp_path.iterdir())) == 1


def test_two_browsers_of_a_class_never_share_progress(browsers):
    for n, client in enumerate(browsers):
        progress_of(client).record("00", "beam", "question", str(n))
    assert [answers_of(client) for client in browsers] == [["0"], ["1"]]
    browsers[0].post("/progress/reset")
    assert [answers_of(client) for client in browsers] == [[], ["1"]]


def test_a_visitor_whose_browser_keeps_no_cookies_sees_nobodys_progress(browsers):
    progress_of(browsers[0]).record("00", "beam", "question", "1")
    stranger = SmallBrowser(course_app(), "http://192.168.1.5")
    assert answers_of(stranger) == []


def test_the_home_page_leads_to_lessons_as_they_are_presented(own):
    assert "?mode=present" not in own.get("/").text
    assert "?mode=present" in own.get("/?mode=present").text
    assert "?mode=present" in SmallBrowser(course_app(present=True), "http://localhost").get("/").text


def test_the_whole_course_stands_behind_the_door(monkeypatch, tmp_path):
    monkeypatch.setenv(CLASS, str(tmp_path))
    stranger = SmallBrowser(course_app("k7mx-2fqp"), "http://192.168.1.5")
    for path in ("/", "/lesson/00/", "/lesson/00/assets/index.js", "/progress.json", "/nothing"):
        assert stranger.get(path).status == 401
