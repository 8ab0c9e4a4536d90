"""The course's server: ports, home page, addresses."""

import re
import socket

import pytest

from gnsslab.teaching.catalogue import LESSONS
from gnsslab.teaching.course import free_socket, home_page


def test_taken_port_means_the_next_free_one():
    with free_socket("127.0.0.1", 23_450) as first, free_socket("127.0.0.1", first.getsockname()[1]) as second:
        assert second.getsockname()[1] > first.getsockname()[1]


@pytest.mark.parametrize(("host", "words"), [("no such host", "is no address of this machine"), ("203.0.113.7", "no free port from 8000")])
def test_wrong_hosts_are_refused_in_words(host, words):
    with pytest.raises(ValueError, match=words):
        free_socket(host, 8000)


def test_port_beyond_the_last_is_refused_in_words():
    with pytest.raises(ValueError, match="no free port from 70000"):
        free_socket("127.0.0.1", 70_000)


def test_home_page_names_every_lesson_and_loads_nothing():
    page = home_page()
    for lesson in LESSONS:
        assert lesson.address in page
        assert lesson.title in page
    assert "$" not in page
    assert not re.search(r"<script|<link[^>]+href=.http|src=.http|@import|url\(", page)
    assert 'name="viewport"' in page
    assert "prefers-color-scheme: dark" in page


def test_socket_listens():
    with free_socket("127.0.0.1", 23_500) as listener, socket.create_connection(listener.getsockname(), timeout=5):
        pass
