"""The front: every connection of a browser reaches one worker, a dead worker is replaced, nothing is left running."""

import json
import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import pytest

from gnsslab.teaching.server.handing import can_hand_over
from gnsslab.teaching.server.seats import Seat
from gnsslab.teaching.visitor import BROWSER_COOKIE

CAN_TELL = can_hand_over() and Path("/proc/self/stat").exists()
pytestmark = pytest.mark.skipif(not CAN_TELL, reason="needs Linux: connections are handed over, and /proc tells what runs")
PATIENCE = 30.0  # [s] for a process to start, on a busy machine
WORKERS = 2
FRONT = """
import signal, sys
from gnsslab.teaching.server import front
from gnsslab.teaching.server.network import free_socket
front.WORKER = ("-c", sys.argv[1])
if "ignored" in sys.argv:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
try:
    with free_socket("127.0.0.1", 23_700) as listener:
        print(listener.getsockname()[1], flush=True)
        front.serve_with_workers(listener, int(sys.argv[2]), {"token": "k7mx-2fqp"}, lambda words: print(words, flush=True))
except ValueError as error:
    print("refused:", error, flush=True)
print("stopped", flush=True)
"""
WORKER = """
import json, os
from gnsslab.teaching.server.handing import HandedOver, orders_from
line = HandedOver(fileno=os.dup(0))
orders = orders_from(line)
line.on_end = lambda: os._exit(0)
while True:
    connection, _ = line.accept()
    head = connection.recv(65536)
    body = json.dumps({"pid": os.getpid(), **orders, "head": head.decode()}).encode()
    connection.sendall(body)
    connection.close()
"""


class Running:
    """A front in a process of its own, with small workers that say who they are."""

    def __init__(self, worker, *more):
        self.process = subprocess.Popen([sys.executable, "-c", FRONT, worker, str(WORKERS), *more], stdout=subprocess.PIPE, text=True)
        self.port = int(self.process.stdout.readline())

    def connect(self):
        """Return a connection to the front."""
        return socket.create_connection(("127.0.0.1", self.port), timeout=PATIENCE)

    def ask(self, browser=None, pieces=1):
        """Return what a worker answers to a request, which may come in pieces."""
        cookie = f"X-Other: {BROWSER_COOKIE}=nonsense\r\nCookie: a=b; {BROWSER_COOKIE}={browser}; c=d\r\n" if browser else ""
        head = f"GET / HTTP/1.1\r\nHost: localhost\r\n{cookie}\r\n".encode()
        size = -(-len(head) // pieces)
        with self.connect() as connection:
            for start in range(0, len(head), size):
                connection.sendall(head[start : start + size])
                time.sleep(0.05 * (pieces > 1))
            answer = json.loads(b"".join(iter(lambda: connection.recv(65536), b"")))
        assert answer["head"] == head.decode()
        return answer

    def stop(self):
        """End it as Ctrl-C does; return what it printed."""
        self.process.send_signal(signal.SIGINT)
        return self.process.communicate(timeout=PATIENCE)[0]


@pytest.fixture
def front(request):
    running = Running(WORKER, *getattr(request, "param", ()))
    yield running
    running.process.kill()
    running.process.communicate()


def is_running(pid):
    """Return whether a process still works: one that has ended and was not yet looked after does not."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


def test_all_connections_of_a_browser_reach_one_worker(front):
    for number in (*range(WORKERS), 0):
        browser = Seat(number, WORKERS).new_browser()
        answers = [front.ask(browser) for _ in range(3)]
        assert {answer["seat"] for answer in answers} == {number}
        assert answers[0]["token"] == "k7mx-2fqp"


def test_browsers_without_an_id_take_turns(front):
    assert sorted(front.ask()["seat"] for _ in range(2 * WORKERS)) == sorted([*range(WORKERS)] * 2)


def test_a_head_that_comes_in_pieces_is_waited_for(front):
    for number in range(WORKERS):
        assert front.ask(Seat(number, WORKERS).new_browser(), pieces=3)["seat"] == number


def test_silent_and_broken_connections_disturb_nobody(front):
    with front.connect(), front.connect() as other:
        other.sendall(b"GET / HT")
        front.connect().close()
        assert front.ask()["pid"]


def test_a_dead_worker_is_replaced_and_its_browsers_with_it(front):
    browser = Seat(1, WORKERS).new_browser()
    dead = front.ask(browser)["pid"]
    os.kill(dead, signal.SIGKILL)
    assert "worker 2 ended by itself (exit status -9) and is started again" in front.process.stdout.readline()
    answer = front.ask(browser)
    assert (answer["seat"], answer["pid"] != dead) == (1, True)


@pytest.mark.parametrize("front", [(), ("ignored",)], ids=["", "ignored-at-first"], indirect=True)
def test_ctrl_c_ends_all_workers(front):
    """Also where SIGINT was ignored at first, as it is in what a script starts in the background."""
    workers = {front.ask()["pid"] for _ in range(WORKERS)}
    assert front.stop().endswith("stopped\n")
    assert front.process.returncode == 0
    assert not any(map(is_running, workers))


def test_workers_do_not_outlive_a_front_that_was_killed(front):
    workers = {front.ask()["pid"] for _ in range(WORKERS)}
    front.process.kill()
    front.process.wait(PATIENCE)
    until = time.monotonic() + PATIENCE
    while any(map(is_running, workers)) and time.monotonic() < until:
        time.sleep(0.05)
    assert not any(map(is_running, workers))


def test_workers_that_never_start_are_given_up_in_words():
    running = Running("raise SystemExit(3)")
    said = running.process.communicate(timeout=PATIENCE)[0]
    assert "ended at once, again and again" in said
    assert "(exit status 3)" in said
    assert said.endswith("stopped\n")
