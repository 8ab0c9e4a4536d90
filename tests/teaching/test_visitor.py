"""Whose progress it is: one's own on a local course, each browser's in a class."""

from types import SimpleNamespace

import pytest

from gnsslab.teaching.visitor import BROWSER_COOKIE, CLASS, browser_of, class_folder, is_class, new_browser, open_class, progress_of


def request_of(browser):
    return SimpleNamespace(cookies={BROWSER_COOKIE: browser, "other": "cookie"})


@pytest.fixture
def in_class(monkeypatch, tmp_path):
    monkeypatch.setenv("GNSSLAB_PROGRESS", str(tmp_path))
    monkeypatch.setenv(CLASS, "")
    open_class()
    return tmp_path


def test_a_local_course_is_this_users(monkeypatch, tmp_path):
    monkeypatch.setenv("GNSSLAB_PROGRESS", str(tmp_path))
    monkeypatch.delenv(CLASS, raising=False)
    assert not is_class()
    progress_of(None).record("00", "beam", "question", "1")
    assert progress_of(request_of(new_browser())).entry("00", "beam").answer == "1"


def test_in_a_class_browsers_share_nothing(in_class):
    first, second = request_of(new_browser()), request_of(new_browser())
    progress_of(first).record("00", "beam", "question", "1")
    assert progress_of(first).entry("00", "beam").answer == "1"
    assert progress_of(second).entries() == ()
    assert is_class()
    assert class_folder() == in_class / "class"


@pytest.mark.parametrize("request_", [None, SimpleNamespace(cookies={}), request_of("../../own"), request_of("")])
def test_in_a_class_nobody_without_an_id_gets_a_file(in_class, request_):
    progress_of(request_).record("00", "beam", "question", "1")
    assert progress_of(request_).entries() == ()
    assert list(in_class.rglob("*")) == []


def test_ids_are_ours_and_all_different():
    ids = {new_browser() for _ in range(1000)}
    assert len(ids) == 1000
    assert all(browser_of({BROWSER_COOKIE: browser}) == browser for browser in ids)
