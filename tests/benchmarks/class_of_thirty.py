"""A class on one machine: run `python tests/benchmarks/class_of_thirty.py --students 30 --seconds 60 [--every 5] [--server "--workers 2"]`.

Starts `gnsslab course --host 0.0.0.0 --no-browser` and opens lesson 00 for every student at once, through the token door,
with the messages that a browser sends: the page, the websocket, the prediction. Then each student moves one slider every
few seconds and waits for the new picture. Printed: how long it took to open the lesson and to see a move, how many failed,
and what CPU and memory the server took (memory: RSS of all its processes, so what they share is counted several times).

The students' side runs on the same machine and takes CPU of its own, which is told too; a real class brings its own.
Needs nothing beyond what marimo and JupyterLab bring: httpx, psutil, websockets.
"""

import argparse
import asyncio
import json
import os
import random
import re
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from html import unescape
from typing import NamedTuple
from urllib.parse import urlsplit

import httpx
import psutil
import websockets

LESSON = "/lesson/00/"
PATIENCE = 60.0  # [s] for an answer; past that it is an error
WARM = 20.0  # [s] the server is given to load its kernels
MB = 1e6
ELEMENT = re.compile(r"object-id='([^']+)'[^>]*><marimo-(slider|radio)([^>]*)>")
DATA = re.compile(r"data-([a-z-]+)='([^']*)'")
PICTURE = "data:image/png"


class Student:
    """One browser with the lesson open."""

    def __init__(self, link, rng):
        self.rng = rng
        self.http = httpx.AsyncClient(base_url=_root(link), follow_redirects=True, timeout=PATIENCE)
        self.link = link
        self.session = f"s_{rng.getrandbits(32):08x}"
        self.elements = {}  # of each cell: kind, id and data of its sliders and radios
        self.opened = 0.0
        self.moves = []
        self.errors = []

    async def visit(self):
        """Come in by the link, open the lesson, predict, and wait for the first picture."""
        start = time.perf_counter()
        (await self.http.get(self.link)).raise_for_status()
        (await self.http.get(LESSON)).raise_for_status()
        cookies = "; ".join(f"{name}={value}" for name, value in self.http.cookies.items())
        address = f"{_root(self.link).replace('http', 'ws', 1)}{LESSON}ws?session_id={self.session}"
        headers = {"Cookie": cookies, "Origin": _root(self.link)}
        self.socket = await websockets.connect(address, additional_headers=headers, max_size=None, open_timeout=PATIENCE)
        await self._until(lambda message: '"completed-run"' in message)
        prediction, data = next((name, data) for kind, name, data in self._all() if kind == "radio")
        await self._set(prediction, json.loads(data["options"])[0])
        await self._until(lambda message: PICTURE in message)
        self.opened = time.perf_counter() - start

    async def play(self, until, every):
        """Move a slider every so many seconds and time how long the new picture takes."""
        due = time.perf_counter() + self.rng.uniform(0, every)
        while due < until:
            await asyncio.sleep(max(0.0, due - time.perf_counter()))
            start = time.perf_counter()
            await self._set(*self._random_move())
            await self._until(lambda message: PICTURE in message)
            self.moves.append(time.perf_counter() - start)
            due = max(due + every, time.perf_counter())

    async def leave(self):
        """Close the browser."""
        await self.socket.close()
        await self.http.aclose()

    def _random_move(self):
        """Return a slider that has an effect, and another value for it."""
        sliders = [(name, data) for kind, name, data in self._all() if kind == "slider" and data.get("disabled") != "true"]
        name, data = self.rng.choice(sliders)
        start, stop, step = (float(data[part]) for part in ("start", "stop", "step"))
        values = [round(start + k * step, 9) for k in range(round((stop - start) / step) + 1)]
        data["value"] = self.rng.choice([value for value in values if value != data.get("value", float(data["initial-value"]))])
        return name, data["value"]

    async def _set(self, name, value):
        body = {"objectIds": [name], "values": [value]}
        answer = await self.http.post(f"{LESSON}api/kernel/set_ui_element_value", json=body, headers={"Marimo-Session-Id": self.session})
        answer.raise_for_status()

    async def _until(self, is_it):
        """Read messages until the one that is meant, and take note of the controls they bring."""
        async with asyncio.timeout(PATIENCE):
            while True:
                message = await self.socket.recv()
                if "object-id=" in message:
                    self._note(json.loads(message)["data"])
                if is_it(message):
                    return

    def _note(self, cell):
        text = (cell.get("output") or {}).get("data") or ""
        found = [(kind, name, {key: unescape(value) for key, value in DATA.findall(rest)}) for name, kind, rest in ELEMENT.findall(text)]
        self.elements[cell.get("cell_id")] = found

    def _all(self):
        return [element for cell in self.elements.values() for element in cell]


class Used(NamedTuple):
    """What a class took, from the first move to the last."""

    server: float  # CPU [s]
    client: float  # CPU [s]
    seconds: float
    memory: list  # RSS of each process of the server, all lessons open [bytes]


async def hold_class(link, count, every, seconds, server):
    """Return the students after their class, and what it took."""
    students = [Student(link, random.Random(number)) for number in range(count)]
    await asyncio.gather(*(_tried(student, student.visit()) for student in students))
    present = [student for student in students if not student.errors]
    before, own, start = _cpu(server), time.process_time(), time.perf_counter()
    await asyncio.gather(*(_tried(student, student.play(start + seconds, every)) for student in present))
    used = Used(_cpu(server) - before, time.process_time() - own, time.perf_counter() - start, _memory(server))
    await asyncio.gather(*(student.leave() for student in present))
    return students, used


async def _tried(student, doing):
    try:
        await doing
    except Exception as error:  # whatever fails is counted, and told
        student.errors.append(f"{type(error).__name__}: {error}")


def report(students, used, empty):
    """Print what the class saw and what it took."""
    opened = sorted(student.opened for student in students if student.opened)
    moves = sorted(move for student in students for move in student.moves)
    errors = [error for student in students for error in student.errors]
    print(f"students {len(students)}, moves {len(moves)}, errors {len(errors)}", *dict.fromkeys(errors), sep="\n  ")
    print(f"lesson opened by all at once, until the first picture: {_spread(opened)}")
    print(f"move, until the new picture: {_spread(moves)}")
    cores = used.server / used.seconds, used.client / used.seconds
    print(f"CPU during the moves: server {cores[0]:.2f} cores, students' side {cores[1]:.2f}, of {os.cpu_count()}")
    print(f"server's CPU a move: {1000 * used.server / max(1, len(moves)):.0f} ms")
    total, before = sum(used.memory) / MB, sum(empty) / MB
    print(f"memory: {total:.0f} MB in {len(used.memory)} processes; {before:.0f} MB before the class")
    print(f"memory a student: {(total - before) / max(1, len(opened)):.0f} MB")


def _spread(times):
    if not times:
        return "none"
    at = times[min(len(times) - 1, round(0.95 * len(times)))]
    return f"median {statistics.median(times):.2f} s, 95th percentile {at:.2f} s, longest {times[-1]:.2f} s"


def _root(link):
    parts = urlsplit(link)
    return f"{parts.scheme}://{parts.netloc}"


def _processes(server):
    return [server, *server.children(recursive=True)]


def _cpu(server):
    return sum(times.user + times.system for times in (process.cpu_times() for process in _processes(server)))


def _memory(server):
    return [process.memory_info().rss for process in _processes(server)]


def _started(options, folder):
    """Return the server's process and its link."""
    command = [sys.executable, "-u", "-m", "gnsslab", "course", "--host", "0.0.0.0", "--no-browser", "--port", "8123", *options.split()]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=os.environ | {"GNSSLAB_PROGRESS": folder})
    line = next(line for line in process.stdout if "the course is at" in line)
    return process, line.split("the course is at ")[1].split()[0]


def main():
    """Hold a class and say how it went."""
    options = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    options.add_argument("--students", type=int, default=30)
    options.add_argument("--seconds", type=float, default=60)
    options.add_argument("--every", type=float, default=5, help="seconds between two moves of a student")
    options.add_argument("--server", default="", help="further options of gnsslab course, in quotes")
    asked = options.parse_args()
    print("load of this machine before, in processes waiting:", *(f"{load:.2f}" for load in os.getloadavg()))
    with tempfile.TemporaryDirectory() as folder:
        process, link = _started(asked.server, folder)
        try:
            time.sleep(WARM)
            server = psutil.Process(process.pid)
            empty = _memory(server)
            report(*asyncio.run(hold_class(link, asked.students, asked.every, asked.seconds, server)), empty)
        finally:
            process.send_signal(signal.SIGINT)
            print("server:", process.communicate(timeout=30)[0].splitlines()[-1], f"(exit status {process.returncode})")


if __name__ == "__main__":
    main()
