"""The front of a class: takes every connection, looks whose it is, and hands the socket itself to the worker of that browser.

Nothing is passed on by the front: once handed over, worker and browser speak directly. A lesson is CPU work in Python, of
which one process does one at a time; so there are as many workers as cores.
"""

import asyncio
import os
import re
import signal
import socket
import subprocess
import sys
import time
from collections import Counter
from contextlib import suppress
from itertools import count

from gnsslab.teaching.server.handing import give_orders, hand
from gnsslab.teaching.server.seats import seat_number
from gnsslab.teaching.visitor import BROWSER_COOKIE, browser_of

PATIENCE = 75.0  # [s]; browsers open connections in advance, and some never speak
HEAD = 65_536  # bytes of a request's head that are looked at
WHOLE_HEAD = 5.0  # [s] in which all of a head must come
GLANCE = 0.02  # [s] between two looks at a head that comes in pieces
FAREWELL = 6.0  # [s] that a worker has to end its lessons
EARLY = 30.0  # [s]; a worker that ends sooner has not served anybody
EARLY_ENDS = 3  # after so many it is not started again
ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")  # the cores are taken by workers already
WORKER = ("-m", "gnsslab.teaching.server.worker")  # what Python runs in a worker
_BROWSER = re.compile(rb"^cookie:(?:[^\r\n]*;)?[ \t]*" + BROWSER_COOKIE.encode() + rb"=([^;\r\n]*)", re.IGNORECASE | re.MULTILINE)


def serve_with_workers(listener, workers, orders, say):
    """Serve the connections of a listening socket with so many worker processes until Ctrl-C.

    Raises ValueError where a worker ends again and again as soon as it is started.
    """
    front = Front([Worker({**orders, "seat": number, "seats": workers}) for number in range(workers)], say)
    try:
        with suppress(KeyboardInterrupt):
            asyncio.run(front.serve(listener))
    finally:
        front.close()


class Worker:
    """A worker process and the line to it."""

    def __init__(self, orders):
        self.orders = orders
        self.started = time.monotonic()
        self.line, end = socket.socketpair()
        with end:  # a session of its own: Ctrl-C in the terminal is for the front alone
            self.process = subprocess.Popen([sys.executable, *WORKER], stdin=end, env=ONE_THREAD | os.environ, start_new_session=True)
        give_orders(orders, self.line)
        self.line.setblocking(False)

    def take(self, connection):
        """Hand a connection to the worker; where it cannot take it, the browser finds it closed and asks again."""
        with suppress(OSError):
            hand(connection, self.line)

    def dismiss(self):
        """Close the line: the worker ends its lessons and then itself."""
        self.line.close()

    def wait(self):
        """Wait for the end; after a while, force it. Return the exit status."""
        try:
            return self.process.wait(FAREWELL)
        except subprocess.TimeoutExpired:
            self.process.kill()
            return self.process.wait()


class Front:
    """Hands connections to workers, and starts a worker anew that ended by itself."""

    def __init__(self, workers, say):
        self.workers = workers
        self.say = say
        self._turn = count()
        self._early_ends = Counter()  # seat -> how often in a row
        self._tasks = set()

    async def serve(self, listener):
        """Take connections until Ctrl-C; raise ValueError where workers do not stay."""
        loop = asyncio.get_running_loop()
        listener.setblocking(False)
        self._over = loop.create_future()
        loop.add_signal_handler(signal.SIGINT, self._stop)  # also where a shell started us in the background, which switches Ctrl-C off
        for worker in self.workers:
            self._watch(worker)
        self._begin(self._take_all(listener))
        await self._over

    def close(self):
        """End all workers and wait for them."""
        for worker in self.workers:
            worker.dismiss()
        for worker in self.workers:
            worker.wait()

    def _stop(self):
        if not self._over.done():
            self._over.set_result(None)

    async def _take_all(self, listener):
        while True:
            try:
                connection, _ = await asyncio.get_running_loop().sock_accept(listener)
            except OSError:  # too many are open: some will close
                await asyncio.sleep(GLANCE)
            else:
                self._begin(self._hand_over(connection))

    async def _hand_over(self, connection):
        try:
            head = await asyncio.wait_for(_head(connection), PATIENCE)
        except (TimeoutError, OSError):
            connection.close()
        else:
            self._worker_of(head).take(connection)

    def _worker_of(self, head):
        """Return the worker of the browser that sent a head; those without an id take turns."""
        found = _BROWSER.search(head.partition(b"\r\n\r\n")[0])
        browser = browser_of({BROWSER_COOKIE: found[1].decode("latin-1")}) if found else None
        number = next(self._turn) if browser is None else seat_number(browser, len(self.workers))
        return self.workers[number % len(self.workers)]

    def _begin(self, work):
        task = asyncio.ensure_future(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    def _watch(self, worker):
        """Notice when a worker ends: nothing ever comes on its line but the end."""
        asyncio.get_running_loop().add_reader(worker.line, self._ended, worker)

    def _ended(self, worker):
        asyncio.get_running_loop().remove_reader(worker.line)
        worker.dismiss()
        self._begin(self._replace(worker))

    async def _replace(self, worker):
        number, status = worker.orders["seat"], await asyncio.to_thread(worker.wait)
        self._early_ends[number] = self._early_ends[number] + 1 if time.monotonic() - worker.started < EARLY else 0
        if self._early_ends[number] >= EARLY_ENDS:
            if not self._over.done():
                self._over.set_exception(ValueError(f"worker {number + 1} ended at once, again and again: see above why, or try --workers 1"))
            return
        self.say(f"worker {number + 1} ended by itself (exit status {status}) and is started again; the lessons of its students begin anew")
        self.workers[number] = Worker(worker.orders)
        self._watch(self.workers[number])


async def _head(connection):
    """Return the head of the first request on a connection, and leave it there to be read. Raise ConnectionError where none comes."""
    connection.setblocking(False)
    await _readable(connection)
    until = time.monotonic() + WHOLE_HEAD
    while True:
        head = connection.recv(HEAD, socket.MSG_PEEK)
        if not head:
            raise ConnectionError
        if b"\r\n\r\n" in head or len(head) == HEAD or time.monotonic() > until:
            return head
        await asyncio.sleep(GLANCE)


async def _readable(connection):
    loop = asyncio.get_running_loop()
    ready = asyncio.Event()
    loop.add_reader(connection, ready.set)
    try:
        await ready.wait()
    finally:
        loop.remove_reader(connection)
