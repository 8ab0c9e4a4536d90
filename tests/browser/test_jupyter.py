"""A lesson in a real JupyterLab, started as a student starts it."""

import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path
from urllib.request import urlopen

import pytest

PATIENCE = 90_000  # [ms], the first run of a lab compiles kernels
QUIET_LOOKS = 16  # in a row, four a second
HARMLESS = ("favicon",)  # console errors that change nothing


@pytest.fixture(scope="module")
def started(tmp_path_factory):
    """A `gnsslab course --jupyter` in an empty folder: its process, and the address that it says."""
    folder = tmp_path_factory.mktemp("student")
    process = subprocess.Popen(
        [sys.executable, "-u", "-m", "gnsslab", "course", "--jupyter", "--no-browser", "--port", "24880"],
        cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
        env=os.environ | {"PYTHONPATH": str(Path(__file__).resolve().parents[2]), "GNSSLAB_PROGRESS": str(folder / "progress")},
    )  # fmt: skip
    try:
        yield process, folder, _address(process)
    finally:
        process.kill()
        process.wait()
        process.stdout.close()


def _address(process):
    said = []
    for line in process.stdout:
        said.append(line)
        if "the notebooks are at " in line:
            return line.split("the notebooks are at ")[1].split()[0]
    pytest.fail(f"no JupyterLab: {''.join(said)}")


@pytest.fixture
def lesson(chromium, started):
    """A function that opens lesson 00 in a fresh browser context and runs all its cells.

    When the test ends, no console error and no request that left the machine may stand in the page's records.
    """
    contexts, troubles = [], []
    own = started[2].split("/lab")[0]

    def open_lesson(width=1280, height=1000, scheme="light"):
        context = chromium.new_context(viewport={"width": width, "height": height}, color_scheme=scheme)
        contexts.append(context)
        page = context.new_page()
        page.on("console", lambda message: troubles.append(f"console: {message.text}") if _matters(message) else None)
        page.on("pageerror", lambda error: troubles.append(f"page error: {error}"))
        page.on("request", lambda request: troubles.append(f"left the machine: {request.url}") if _is_foreign(request.url, own) else None)
        page.goto(started[2] + "&reset")  # without the cells of the test before
        _run_all(page)
        return page

    yield open_lesson
    for context in contexts:
        context.close()
    assert not troubles


def _matters(message):
    return message.type == "error" and not any(word in message.text for word in HARMLESS)


def _is_foreign(url, own):
    return not url.startswith((own, own.replace("http:", "ws:"), "data:", "blob:"))


def _run_all(page):
    page.get_by_text("| Idle").wait_for(timeout=PATIENCE)
    page.get_by_role("menuitem", name="Run", exact=True).click()
    page.locator(".lm-Menu-itemLabel").get_by_text("Run All Cells", exact=True).click()
    page.get_by_role("radio", name="to about 2 degrees").wait_for(timeout=PATIENCE)


def _opened(page):
    """Predict, and wait for the lab."""
    page.get_by_role("radio", name="to about 2 degrees").check()
    _north(page).locator(".gl-readouts").wait_for(timeout=PATIENCE)
    return page


def _north(page):
    """Return the first lab of the lesson."""
    return page.locator(".gl-lab").first


def _readouts(page):
    return _north(page).locator(".gl-readouts").inner_text()


def _changed(page, before):
    page.wait_for_function("before => document.querySelector('.gl-lab .gl-readouts')?.innerText !== before", arg=before, timeout=PATIENCE)
    return _readouts(page)


def _slider(page, label):
    return _north(page).locator(".gl-control", has_text=label).get_by_role("slider")


def test_a_lesson_from_the_first_cell_to_an_answer(lesson, started):
    page = lesson()
    page.get_by_text("Choose an answer under Predict to open the lab.").first.wait_for()
    assert page.locator(".gl-pictures").count() == 0
    _opened(page)
    before = _readouts(page)
    _slider(page, "Baseline length").press("End")
    after = _changed(page, before)
    assert "5.00" in after
    page.get_by_role("button", name="Arm's length").click()
    assert "0.30" in _changed(page, after)
    page.get_by_text("The same millimetres on a shorter lever").wait_for()
    answer = page.get_by_placeholder("a number").first
    answer.press_sequentially("-60.26")
    answer.press("Enter")
    page.get_by_text("Not yet.", exact=False).last.wait_for(timeout=PATIENCE)
    _north(page).get_by_role("button", name="Save this").click()
    page.get_by_text("Saved north.png, north.svg, north.csv").wait_for(timeout=PATIENCE)
    assert (started[1] / "gnsslab-course" / "north.csv").is_file()


def test_own_files_by_upload(lesson, tmp_path):
    import numpy as np

    from gnsslab.simulate import find_preset, simulate, write_simulation

    write_simulation(tmp_path, simulate(find_preset("static-baseline"), np.random.default_rng(3)))
    page = _opened(lesson())
    _north(page).get_by_role("radio", name="my files").check()
    page.get_by_text("your master, rover and navigation files are missing").wait_for(timeout=PATIENCE)
    for number, name in enumerate(("master.obs", "rover.obs", "broadcast.nav")):
        with page.expect_file_chooser() as chooser:
            _north(page).get_by_role("button", name="Upload it").nth(number).click()
        chooser.value.set_files(tmp_path / name)
        page.get_by_text(f"{name} is kept").wait_for(timeout=PATIENCE)
    _north(page).locator(".gl-readouts").wait_for(timeout=PATIENCE)
    assert re.search(r"Length\s+1\.1[67]\d\s+m", _readouts(page)), "the simulated beam is 1.167 m long"


def test_formulas_and_folded_text_are_rendered(lesson):
    page = lesson()
    folded = page.locator("details", has=page.get_by_text("After your prediction")).last
    inside = folded.get_by_text("What you see.")
    assert not inside.is_visible()
    folded.locator("summary").click()
    assert inside.is_visible()
    assert page.locator("mjx-container").count() > 10
    assert page.get_by_text("\\operatorname").filter(visible=True).count() == 0


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_the_theme_follows_the_system_and_the_lab_fits(lesson, scheme, tmp_path):
    page = _opened(lesson(scheme=scheme))
    assert page.locator("body").get_attribute("data-jp-theme-light") == ("true" if scheme == "light" else "false")
    page.keyboard.press("Control+b")  # puts the list of files away, which leaves a phone no room
    lab = _north(page)
    for width, least, most in ((1280, 700, 1280), (390, 200, 390)):
        page.set_viewport_size({"width": width, "height": 1000})
        page.wait_for_function(f"(w => {least} < w && w < {most})(document.querySelector('.gl-lab').clientWidth)", timeout=PATIENCE)
        lab.scroll_into_view_if_needed()
        assert lab.evaluate("e => e.scrollWidth <= e.clientWidth + 1"), "nothing in the lab is wider than the lab"
        page.screenshot(path=tmp_path / f"jupyter-{scheme}-{width}.png")


def test_ctrl_c_ends_it_with_its_kernels(started):
    process, _, address = started
    _await_idle(address)  # a kernel that is ended within a cell says so itself
    process.send_signal(signal.SIGINT)
    said, _ = process.communicate(timeout=30)
    assert process.returncode == 0
    assert said.rstrip().endswith("stopped")
    assert "Traceback" not in said, said
    assert "Parent appears to have exited" not in said


def _await_idle(address):
    """Wait until no kernel has worked on a cell for a while: between two cells it is idle for a moment."""
    own, token = address.split("/lab")[0], address.split("token=")[1]
    deadline, quiet = time.monotonic() + PATIENCE / 1000, 0
    while quiet < QUIET_LOOKS:
        assert time.monotonic() < deadline, "a kernel is still busy"
        with urlopen(f"{own}/api/kernels?token={token}", timeout=30) as answer:
            quiet = quiet + 1 if all(kernel["execution_state"] == "idle" for kernel in json.load(answer)) else 0
        time.sleep(0.25)
