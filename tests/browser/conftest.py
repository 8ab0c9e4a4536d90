"""A real server and a real browser."""

import os
import shutil
import signal
import subprocess
import sys
import threading
from functools import cache
from pathlib import Path
from queue import Empty, Queue

import pytest
from stages import SharedLesson, Visitor, stage

from gnsslab.teaching.catalogue import find_lesson

FLAGS = (  # noqa: SIM905 - one line a flag reads no better
    "--no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking --disable-component-update "
    "--disable-sync --disable-dev-shm-usage"
).split()
PATIENCE = 90_000  # [ms], the very first load compiles kernels
START_SECONDS = 60  # for the server to say where it is, on a busy machine


@pytest.fixture(scope="session")
def progress_folder(tmp_path_factory):
    """Where the served course keeps its user's answers."""
    return tmp_path_factory.mktemp("progress")


@pytest.fixture(scope="session")
def course(tmp_path_factory, progress_folder):
    """Address of a course served by `gnsslab course` in a process of its own, from a folder that is not the project's."""
    process = subprocess.Popen(
        [sys.executable, "-u", "-m", "gnsslab", "course", "--no-browser", "--port", "24680"],
        cwd=tmp_path_factory.mktemp("elsewhere"), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
        env=os.environ | {"PYTHONPATH": str(Path(__file__).resolve().parents[2]), "GNSSLAB_PROGRESS": str(progress_folder)},
    )  # fmt: skip
    lines = _lines_of(process)
    try:
        yield _address(lines)
    finally:
        process.send_signal(signal.SIGINT)
        try:
            process.wait(20)
        finally:
            process.kill()
            process.stdout.close()


def _lines_of(process):
    """Return a queue of the lines that the process prints."""
    lines = Queue()
    threading.Thread(target=lambda: [lines.put(line) for line in process.stdout], daemon=True).start()
    return lines


def _address(lines):
    said = []
    while True:
        try:
            said.append(lines.get(timeout=START_SECONDS))
        except Empty:
            pytest.fail(f"the course did not start: {''.join(said)}")
        if "the course is at " in said[-1]:
            return said[-1].split("the course is at ")[1].split()[0]


@pytest.fixture(scope="module")
def chromium():
    """Debian's chromium, driven by playwright; skips with the reason, fails under GNSSLAB_REQUIRE_ALL=1.

    It ends with its file: its event loop would be in the way of tests that need their own.
    """
    path = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if path is None:
        _missing("no chromium on this machine: apt-get install chromium")
    playwright = pytest.importorskip("playwright.sync_api", reason="no playwright here: pip install playwright")
    with playwright.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=path, args=FLAGS)
        yield browser
        browser.close()


def _missing(reason):
    if os.environ.get("GNSSLAB_REQUIRE_ALL") == "1":
        pytest.fail(f"GNSSLAB_REQUIRE_ALL=1, but: {reason}")
    pytest.skip(reason)


@pytest.fixture
def visit(chromium, course, progress_folder):
    """A function that opens an address of the course in a fresh browser context and returns the page; no answer was given before.

    When the test ends, no console error and no request that left the machine may stand in the page's records.
    """
    _forget_answers(progress_folder)
    visitor = Visitor(chromium, course)
    yield visitor.open
    visitor.leave()
    assert not visitor.troubles


@pytest.fixture(scope="module")
def visitor(chromium, course, progress_folder):
    """A `Visitor` for all tests of a file; no answer was given before."""
    _forget_answers(progress_folder)
    visitor = Visitor(chromium, course)
    yield visitor
    visitor.leave()
    assert not visitor.troubles


@pytest.fixture
def open_labs(visit, visitor, shared_labs):
    """A function that opens a lesson, predicts one of its options and returns the page once all labs stand.

    A lesson without a query is opened once for all tests of a file; each finds the labs as they were at first.
    """

    def opened(number, option, query="", **how):
        if query or how:
            return _with_labs(visit(find_lesson(number).address + query, **how), number, option)
        return shared_labs(number, option).restored(PATIENCE)

    yield opened
    assert not visitor.troubles


@pytest.fixture(scope="module")
def shared_labs(visitor):
    """A function from a lesson's number and an option to its `SharedLesson`."""

    @cache
    def opened(number, option):
        page = _with_labs(visitor.open(find_lesson(number).address), number, option)
        return SharedLesson(page, find_lesson(number))

    return opened


def _with_labs(page, number, option):
    """Predict, and return the page once all labs stand."""
    page.get_by_role("radio", name=option, exact=True).click(timeout=PATIENCE)
    for lab in find_lesson(number).open_labs():
        stage(page, lab).locator(".gl-pictures img").first.wait_for(timeout=PATIENCE)
    return page


def _forget_answers(progress_folder):
    for file in progress_folder.iterdir():
        file.unlink()
