"""Lesson 00 in a real browser, through the real server."""

import re
import statistics
import time
from functools import partial

import pytest

NORTH = '.gl-stage[data-lab="north"]'  # the parts of the first lab
MOVES = 8
PATIENCE = 60_000  # [ms], the very first load compiles kernels


@pytest.fixture
def lesson(open_labs):
    """The lesson with its labs open."""
    return partial(open_labs, "00", "to about 2 degrees")


def _readouts(page):
    return page.locator(f"{NORTH} .gl-readouts").inner_text()


def _await_change(page, before, of):
    deadline = time.monotonic() + PATIENCE / 1000
    while of(page) == before:
        assert time.monotonic() < deadline, "nothing changed"
        page.wait_for_timeout(20)
    return of(page)


def _await_same(page, wanted):
    deadline = time.monotonic() + PATIENCE / 1000
    while _readouts(page) != wanted:
        assert time.monotonic() < deadline, "the earlier numbers did not come back"
        page.wait_for_timeout(50)


def _slider(page, name):
    return page.locator(NORTH).get_by_role("slider", name=name)


def test_from_the_home_page_into_the_lesson(visit):
    page = visit("/")
    page.get_by_role("link", name="Which way is north?").click()
    page.get_by_role("heading", name="Which way is north?").wait_for(timeout=PATIENCE)
    page.get_by_text("Choose an answer above to open the lab.").wait_for(timeout=PATIENCE)
    assert page.locator(f"{NORTH} .gl-pictures").count() == 0
    page.get_by_role("link", name="All lessons").click()
    page.get_by_role("heading", name="Precise GNSS").wait_for(timeout=PATIENCE)


def test_presets_set_the_controls_and_say_what_to_look_at(lesson):
    page = lesson()
    before = _readouts(page)
    page.get_by_role("button", name="Arm's length").click()
    after = _await_change(page, before, _readouts)
    assert "0.30" in after
    page.get_by_text("The same millimetres on a shorter lever").wait_for()
    assert float(_slider(page, "Baseline length").get_attribute("aria-valuenow")) == pytest.approx(0.3)


def test_goal_is_reached_live(lesson):
    page = lesson()
    assert page.locator(".gl-goal.gl-reached").count() == 0
    before = _readouts(page)
    _slider(page, "Baseline length").press("End")
    before = _await_change(page, before, _readouts)
    page.get_by_role("combobox", name="Systems").select_option(label="GPS + Galileo")
    _await_change(page, before, _readouts)
    page.locator(".gl-goal.gl-reached").get_by_text("Reached.").wait_for(timeout=PATIENCE)


def test_real_data_and_what_is_switched_off(lesson, dataset):
    dataset("matrtklib-static")
    page = lesson()
    before = _readouts(page)
    page.get_by_role("radio", name="real roof").click()
    after = _await_change(page, before, _readouts)
    assert "193." in after
    assert _slider(page, "Carrier noise").get_attribute("data-disabled") is not None
    assert page.get_by_text("no effect: real data are as they are").first.is_visible()


def test_own_files_by_upload(lesson, tmp_path):
    import numpy as np

    from gnsslab.simulate import find_preset, simulate, write_simulation

    write_simulation(tmp_path, simulate(find_preset("static-baseline"), np.random.default_rng(3)))
    page = lesson()
    page.get_by_role("radio", name="my files").click()
    page.get_by_text("your master, rover and navigation files are missing").wait_for(timeout=PATIENCE)
    upload = page.locator("input[type=file]")
    upload.nth(0).set_input_files(tmp_path / "master.obs")
    page.get_by_text("your rover and navigation files are missing").wait_for(timeout=PATIENCE)
    upload.nth(1).set_input_files(tmp_path / "rover.obs")
    page.get_by_text("your navigation file is missing").wait_for(timeout=PATIENCE)
    upload.nth(2).set_input_files(tmp_path / "broadcast.nav")
    page.locator(f"{NORTH} .gl-readouts").wait_for(timeout=PATIENCE)
    mine = _readouts(page)
    assert re.search(r"Heading\s+3[45]\.\d+ deg", mine)
    page.get_by_role("radio", name="simulated").click()
    _await_change(page, mine, _readouts)
    page.get_by_role("radio", name="my files").click()
    page.get_by_text("rover.obs is kept").wait_for(timeout=PATIENCE)
    _await_same(page, mine)


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_home_page_fits_a_phone(visit, scheme):
    page = visit("/", width=390, scheme=scheme)
    assert page.evaluate("document.documentElement.scrollWidth") <= 390


def test_keys_alone_suffice(visit):
    page = visit("/")
    _tab_until(page, "document.activeElement.getAttribute('href') === '/lesson/00/'")
    page.keyboard.press("Enter")
    page.get_by_role("radio").first.wait_for(timeout=PATIENCE)
    _tab_to(page, "radio")
    page.keyboard.press("Space")
    page.wait_for_selector(f"{NORTH} .gl-pictures img", timeout=PATIENCE)
    before = _readouts(page)
    _tab_to(page, "slider")
    page.keyboard.press("End")
    _await_change(page, before, _readouts)


def _tab_to(page, role):
    _tab_until(page, f"({_FOCUSED_ROLE})() === '{role}'")


def _tab_until(page, condition):
    for _ in range(60):
        page.keyboard.press("Tab")
        if page.evaluate(condition):
            return
    pytest.fail(f"the tabulator key never gets to where {condition}")


_FOCUSED_ROLE = """
() => {
  let focused = document.activeElement;
  while (focused.shadowRoot && focused.shadowRoot.activeElement) focused = focused.shadowRoot.activeElement;
  return focused.getAttribute('role');
}
"""


def test_latency_of_a_move(lesson, record_property, capsys):
    """From key press to new picture, for eight moves; told, not judged."""
    page = lesson()
    slider = _slider(page, "Carrier noise")
    before = _readouts(page)
    slider.press("Home")
    _await_change(page, before, _readouts)
    taken = [_timed_press(page, slider) for _ in range(MOVES)]
    record_property("latency_ms", taken)
    with capsys.disabled():
        print(f"\nkey press to new picture: median {statistics.median(taken):.0f} ms, {[round(ms) for ms in taken]}")
    assert len(taken) == MOVES


def _timed_press(page, slider):
    """Return the time [ms] from the key's event to the frame that shows another picture, by the browser's own clock."""
    page.wait_for_timeout(400)
    page.evaluate(_START_WATCH)
    slider.press("ArrowRight" if float(slider.get_attribute("aria-valuenow")) < 4 else "ArrowLeft")
    page.wait_for_function("window.glTaken !== null", timeout=PATIENCE)
    return page.evaluate("window.glTaken")


_START_WATCH = """
() => {
  const source = () => document.querySelector('[data-lab=north] .gl-pictures img')?.src;
  const before = source();
  window.glTaken = null;
  window.addEventListener('keydown', () => {
    const start = performance.now();
    const look = () => {
      const now = source();
      if (now && now !== before) window.glTaken = performance.now() - start;
      else requestAnimationFrame(look);
    };
    look();
  }, {capture: true, once: true});
}
"""
