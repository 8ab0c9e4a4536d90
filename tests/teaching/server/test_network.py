"""Ports and addresses."""

import ipaddress
import socket

import pytest

from gnsslab.teaching.server.network import free_socket, names_of


def test_taken_port_means_the_next_free_one():
    with free_socket("127.0.0.1", 23_450) as first, free_socket("127.0.0.1", first.getsockname()[1]) as second:
        assert second.getsockname()[1] > first.getsockname()[1]


@pytest.mark.parametrize(("host", "words"), [("no such host", "is no address of this machine"), ("203.0.113.7", "is no address of this machine")])
def test_wrong_hosts_are_refused_in_words(host, words):
    with pytest.raises(ValueError, match=words):
        free_socket(host, 8000)


def test_port_beyond_the_last_is_refused_in_words():
    with pytest.raises(ValueError, match="no free port from 70000"):
        free_socket("127.0.0.1", 70_000)


def test_socket_listens():
    with free_socket("127.0.0.1", 23_500) as listener, socket.create_connection(listener.getsockname(), timeout=5):
        pass


def test_a_class_is_reached_at_every_name_that_is_told():
    with free_socket("0.0.0.0", 23_550) as listener:
        names = names_of("0.0.0.0")
        assert names
        for name in names:
            assert not ipaddress.ip_address(name).is_loopback or names == ["127.0.0.1"]
            socket.create_connection((name, listener.getsockname()[1]), timeout=5).close()


def test_one_address_is_told_as_it_is_typed_into_a_browser():
    assert names_of("192.168.1.5") == ["192.168.1.5"]
    assert names_of("::1") == ["[::1]"]
