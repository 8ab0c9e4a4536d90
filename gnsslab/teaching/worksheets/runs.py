"""Runs a student's cells in a process of its own, which is stopped for good at the limits of time.

This protects the grader from mistakes: endless loops, full memory, forks, exits. It is no wall against malice: the process
may read what the grader's user may read.
"""

import json
import math
import os
import queue
import signal
import subprocess
import sys
import threading
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from time import monotonic

PROGRAM = Path(__file__).with_name("process.py")
MEMORY = 2 << 30  # [bytes] of address space: four times what a lab with its pictures takes
CELL_SHARE = 0.5  # of the notebook's time: one endless cell leaves time for the others
NEEDED = ("PATH", "HOME", "LANG", "LC_ALL", "PYTHONPATH", "SYSTEMROOT", "TMPDIR")  # of the environment; the rest may hold secrets
QUIET = {"MPLBACKEND": "Agg", "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1", "NUMBA_NUM_THREADS": "1"}


@dataclass(frozen=True)
class Outcome:
    """What a cell left behind."""

    answer: str = ""  # the name `answer` after the cell, as text; "" where there is none
    problem: str = ""  # one line: an error, or why the cell was stopped


def run_cells(sources, seconds):
    """Return the Outcome of each cell, run in order within so many seconds altogether.

    A cell that fails does not stop the others. One that takes half of the time, or ends the process, is left out, and the
    others are run again without it. What could not be run until the end of the time has the problem "not run".
    """
    end, done, stopped = monotonic() + seconds, {}, {}
    while True:
        cells = [(place, source) for place, source in enumerate(sources) if place not in stopped]
        outcomes, place, reason = _run_once(cells, end, CELL_SHARE * seconds)
        done |= outcomes
        if place is not None:
            stopped[place] = Outcome(problem=reason)
        if place is None or monotonic() >= end:
            not_run = dict.fromkeys(range(len(sources)), Outcome(problem=f"not run: {reason}"))
            return list((not_run | done | stopped).values())


def _run_once(cells, end, cell_seconds):
    """Run cells in one process; return outcomes by place, the cell that had to be stopped or None, and why."""
    outcomes, place, began = {}, None, monotonic()
    with _process(cells, end) as messages:
        while True:
            deadline = min(end, began + cell_seconds)
            message = _next(messages, deadline)
            if message is None:
                is_late = monotonic() >= deadline
                return outcomes, place, f"stopped after {monotonic() - began:.0f} s" if is_late else "it ended the process"
            if "end" in message:
                return outcomes, None, ""
            if "start" in message:
                place, began = message["start"], monotonic()
            else:
                outcomes[message["done"]] = Outcome(message["answer"], message["problem"])


def _next(messages, deadline):
    """Return the next message, None where the process has ended or the deadline comes first."""
    try:
        return messages.get(timeout=max(0.0, deadline - monotonic()))
    except queue.Empty:
        return None


@contextmanager
def _process(cells, end):
    """Start the process in an empty folder and give the queue of its messages; kill it, and all it started, at the end."""
    job = {"cells": cells, "seconds": max(1, math.ceil(end - monotonic()) + 1), "memory": MEMORY}
    with TemporaryDirectory(prefix="gnsslab-worksheet-", ignore_cleanup_errors=True) as folder:
        kept = {name: value for name, value in os.environ.items() if name in NEEDED or name.startswith(("GNSSLAB_", "NUMBA_"))}
        quiet = kept | QUIET | {"GNSSLAB_PROGRESS": folder}
        process = subprocess.Popen(
            [sys.executable, "-P", PROGRAM], cwd=folder, env=quiet, start_new_session=True,
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, encoding="utf-8",
        )  # fmt: skip
        try:
            with suppress(OSError), process.stdin:  # it may have ended already
                process.stdin.write(json.dumps(job))
            yield _messages_of(process)
        finally:
            _kill(process)


def _messages_of(process):
    """Return a queue that a thread fills with the messages of a process, None at their end or before one that is none of ours."""
    messages = queue.Queue()

    def listen():
        with process.stdout, suppress(ValueError, RecursionError):  # a line cut short, or written by a cell
            for line in process.stdout:
                messages.put(_message(line))
        messages.put(None)

    threading.Thread(target=listen, daemon=True).start()
    return messages


def _message(line):
    """Return a message of `worksheet_process`; raise ValueError for any other line: a cell may have found the way out."""
    message = json.loads(line)
    if not isinstance(message, dict) or {name: type(value) for name, value in message.items()} not in _MESSAGES:
        raise ValueError("no message of ours")
    return message


_MESSAGES = ({"start": int}, {"done": int, "answer": str, "problem": str}, {"end": bool})


def _kill(process):
    """End a process and its group for good; its number is not given to another one before it is waited for."""
    with suppress(ProcessLookupError, PermissionError):
        if hasattr(os, "killpg"):
            os.killpg(process.pid, signal.SIGKILL)
    process.kill()
    process.wait()
