"""Ports and addresses: where the course listens, and what to type on another machine to reach it."""

import errno
import ipaddress
import socket

LOOPBACK = ("127.0.0.1", "localhost", "::1")
EVERYWHERE = ("0.0.0.0", "::")
PORTS_TRIED = 50  # a taken port means the next free one, up to this many further on
LAST_PORT = 65_535
ELSEWHERE = ("192.0.2.1", 9)  # an address that belongs to nobody (RFC 5737); nothing is sent to it


def free_socket(host, port):
    """Return a listening socket at the port, or at the next free one.

    Raises ValueError where the host is no address of this machine or no port is free.
    """
    family = _address_family(host)
    problem = "ports end at 65535"
    for candidate in range(port, min(port + PORTS_TRIED, LAST_PORT + 1)):
        try:
            return socket.create_server((host, candidate), family=family, backlog=1024)
        except OSError as error:
            if error.errno == errno.EADDRNOTAVAIL:
                raise _no_address(host) from None
            problem = error.strerror
    raise ValueError(f"no free port from {port} to {port + PORTS_TRIED - 1} at {host} ({problem}): try another with --port")


def names_of(host):
    """Return the addresses to type on another machine, best first; for a host that serves one address only, that one.

    >>> names_of("192.168.1.5"), names_of("::1")
    (['192.168.1.5'], ['[::1]'])
    """
    if host not in EVERYWHERE:
        return [f"[{host}]" if ":" in host else host]
    found = dict.fromkeys([*_on_the_way_out(), *_on_interfaces()])
    return [address for address in found if _can_be_reached(address)] or ["127.0.0.1"]


def _address_family(host):
    try:
        return socket.getaddrinfo(host, None, type=socket.SOCK_STREAM)[0][0]
    except socket.gaierror:
        raise _no_address(host) from None


def _no_address(host):
    return ValueError(f"{host} is no address of this machine: try 127.0.0.1, or 0.0.0.0 to serve a class")


def _on_the_way_out():
    """Return the address this machine would send from: the one the others in its network see."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(ELSEWHERE)  # asks the routing table only
        except OSError:
            return []
        return [probe.getsockname()[0]]


def _on_interfaces():
    import psutil

    return [card.address for cards in psutil.net_if_addrs().values() for card in cards if card.family == socket.AF_INET]


def _can_be_reached(address):
    address = ipaddress.ip_address(address)
    return not (address.is_loopback or address.is_link_local or address.is_unspecified)
