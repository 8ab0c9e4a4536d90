"""Where the time of a move goes: run `python tests/benchmarks/latency.py [moves]`, by default eight, on an otherwise idle machine.

Serves the course in a process of its own, opens each lesson in chromium and moves each slider in sight of each lab by its keys, one
step up and one step down again, on a fresh page. A move that leaves the pictures as they are does not count. The server notes when it
computes, draws and encodes; the browser when the key went down, when an address of a picture changed and when the next frame was
shown. Both read the same machine's clock. The table holds medians [ms]:

    to server    key press until the lab computes: browser, request, marimo
    compute      the lab's own computation
    draw, encode of all its pictures: matplotlib, and the PNGs
    to browser   last picture until the page has it: marimo, websocket, React
    frame        until the browser shows a frame with it
"""

import json
import os
import shutil
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from gnsslab.labs.controls import Slider
from gnsslab.teaching.catalogue import LESSONS

PORT = 24_880
PATIENCE = 60_000  # [ms], the first lesson may compile kernels
NO_CHANGE = 4_000  # [ms], after which a move is taken to have left the picture as it was
REST = 700  # [ms] without a stamp, after which the course is idle and the next move may come
FLAGS = ["--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-dev-shm-usage"]
COLUMNS = ("key to frame", "to server", "compute", "draw", "encode", "to browser", "frame")
WATCH = """
(pictures) => {
  const now = () => performance.timeOrigin + performance.now();
  const source = () => [...document.querySelectorAll(pictures)].map((picture) => picture.src).join();
  const before = source(), seen = {};
  window.glWatch?.disconnect();
  window.glSeen = null;
  window.addEventListener('keydown', () => { seen.key = now(); }, {capture: true, once: true});
  const watch = window.glWatch = new MutationObserver(() => {
    const current = source();
    if (!current || current === before) return;
    watch.disconnect();
    seen.picture = now();
    requestAnimationFrame(() => { seen.frame = now(); window.glSeen = seen; });
  });
  watch.observe(document.body, {subtree: true, childList: true, attributes: true});
}
"""


def main(moves):
    """Print the table."""
    from playwright.sync_api import sync_playwright

    with tempfile.TemporaryDirectory() as folder, sync_playwright() as driver:
        journal = Path(folder) / "stamps.jsonl"
        browser = driver.chromium.launch(executable_path=shutil.which("chromium"), args=FLAGS)
        server, address = start_server(journal, Path(folder) / "progress")
        print(f"{'lesson and lab':24}{'slider':24}" + "".join(f"{name:>14}" for name in COLUMNS) + "   moves")
        try:
            for lesson in LESSONS:
                time_lesson(browser, address, lesson, journal, moves)
        finally:
            server.send_signal(signal.SIGINT)
            server.wait(20)


def start_server(journal, progress):
    """Return the process of a server that writes its stamps into the journal, and its address."""
    command = [sys.executable, "-u", __file__, "--serve", str(journal)]
    server = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=os.environ | {"GNSSLAB_PROGRESS": str(progress)})
    for line in server.stdout:
        if "the course is at " in line:
            return server, line.split("the course is at ")[1].split()[0].rstrip("/")
    raise SystemExit("the course did not start")


def serve_stamped(journal):
    """Serve the course; computing, drawing and encoding leave stamps."""
    from gnsslab.figures import kept
    from gnsslab.labs.lab import Lab
    from gnsslab.teaching.server.command import serve

    with open(journal, "a", buffering=1) as stamps:
        for owner, function, name in ((Lab, "run", "compute"), (kept.KeptPicture, "png", "picture"), (kept, "png_bytes", "encode")):
            setattr(owner, function, _stamping(getattr(owner, function), name, stamps))
        serve(port=PORT, open_browser=False)


def _stamping(function, name, stamps):
    def stamped(*args, **options):
        start = time.time()
        try:
            return function(*args, **options)
        finally:
            stamps.write(json.dumps([name, 1e3 * start, 1e3 * time.time()]) + "\n")

    return stamped


def time_lesson(browser, address, lesson, journal, moves):
    """Print a row for each slider of a lesson."""
    for lab in lesson.open_labs().values():
        blocked = lab.blocked(lab.defaults)
        for control in lab.controls:
            if isinstance(control, Slider) and not control.more and control.name not in blocked:
                rows = time_slider(open_lesson(browser, address, lesson), lab, control, journal, moves)
                medians = "".join(f"{statistics.median(column):14.0f}" for column in zip(*rows, strict=True))
                print(f"{lesson.number} {lab.name:21}{control.label:24}{medians}   of {len(rows)}", flush=True)


def open_lesson(browser, address, lesson):
    """Return a fresh page with the lesson's labs open."""
    page = browser.new_context(viewport={"width": 1280, "height": 900}).new_page()
    page.goto(address + lesson.address)
    page.get_by_role("radio", name=lesson.exercises.PREDICTION.options[0], exact=True).click(timeout=PATIENCE)
    return page


def time_slider(page, lab, control, journal, moves):
    """Return a row of COLUMNS for each move of a slider that changed the picture; close the page."""
    stage = f'.gl-stage[data-lab="{lab.name}"]'
    page.wait_for_selector(f"{stage} .gl-pictures img", timeout=PATIENCE)
    slider = page.locator(stage).get_by_role("slider", name=control.label)
    up = control.default < control.stop
    rows = []
    for number in range(moves + 1):
        settle(page, journal)
        key = "ArrowRight" if up == (number % 2 == 0) else "ArrowLeft"
        rows.append(time_move(page, slider, key, f"{stage} .gl-pictures img", journal))
    page.context.close()
    return [row for row in rows[1:] if row is not None]  # the first one prepares what later ones find ready


def settle(page, journal):
    """Wait until the server has been idle for a while."""
    size = None
    while size != (size := journal.stat().st_size):
        page.wait_for_timeout(REST)


def time_move(page, slider, key, pictures, journal):
    """Return one row of COLUMNS [ms], None where the pictures stay as they were."""
    from playwright.sync_api import TimeoutError as NothingSeen

    journal.write_text("")
    page.evaluate(WATCH, pictures)
    slider.press(key)
    try:
        page.wait_for_function("window.glSeen !== null", timeout=NO_CHANGE, polling=100)  # polling by frames would itself be work
    except NothingSeen:
        return None
    return _row(page.evaluate("window.glSeen"), [json.loads(line) for line in journal.read_text().splitlines()])


def _row(seen, stamps):
    computed = next(stamp for stamp in stamps if stamp[0] == "compute")
    drawn, encoded = (sum(end - start for name, start, end in stamps if name == kind) for kind in ("picture", "encode"))
    last = max(end for name, _, end in stamps if name == "picture")
    return (
        seen["frame"] - seen["key"], computed[1] - seen["key"], computed[2] - computed[1], drawn - encoded, encoded,
        seen["picture"] - last, seen["frame"] - seen["picture"],
    )  # fmt: skip


if __name__ == "__main__":
    if sys.argv[1:2] == ["--serve"]:
        serve_stamped(sys.argv[2])
    else:
        main(int(sys.argv[1]) if len(sys.argv) > 1 else 8)
