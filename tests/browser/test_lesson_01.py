"""Lesson 01 in a real browser, through the real server: two labs on one page."""

import re
import time
from functools import partial

import pytest
from stages import readouts, shown, stage

from gnsslab.teaching.catalogue import find_lesson

LABS = find_lesson("01").open_labs()
PATIENCE = 60_000  # [ms], the very first load compiles kernels


@pytest.fixture
def lesson(open_labs):
    """The lesson with its labs open."""
    return partial(open_labs, "01", "100 times or more")


def _await_change(page, lab, before):
    deadline = time.monotonic() + PATIENCE / 1000
    while shown(page, lab) in (before, ""):
        assert time.monotonic() < deadline, "nothing changed"
        page.wait_for_timeout(20)


def _slider(page, lab, name):
    return stage(page, lab).get_by_role("slider", name=name)


def test_a_slip_by_button(lesson):
    page = lesson()
    before = shown(page, "signal")
    page.get_by_role("button", name="Cycle slip", exact=True).click()
    _await_change(page, "signal", before)
    assert re.search(r"Slip\s+found", readouts(page, "signal"))
    page.get_by_text(LABS["signal"].preset("cycle-slip").look_at).wait_for(timeout=PATIENCE)
    assert float(_slider(page, "signal", "Cycle slip on L1").get_attribute("aria-valuenow")) == 5


def test_a_slip_by_link(lesson):
    page = lesson("?preset=cycle-slip")
    assert re.search(r"Slip\s+found", readouts(page, "signal"))
    page.get_by_text(LABS["signal"].preset("cycle-slip").look_at).wait_for(timeout=PATIENCE)


def test_a_preset_of_the_second_lab_by_link_leaves_the_first_alone(lesson):
    page = lesson("?lab=sky&preset=noon")
    page.get_by_text(LABS["sky"].preset("noon").look_at).wait_for(timeout=PATIENCE)
    assert re.search(r"Slip\s+none", readouts(page, "signal"))


def test_a_hidden_slip_reaches_the_goal(lesson):
    page = lesson("?lab=signal&slip_cycles=1&slip_second=1&elevation_deg=15")
    assert re.search(r"Slip\s+missed", readouts(page, "signal"))
    page.locator(".gl-reached").get_by_text("a slip of 1 cycle is missed").wait_for(timeout=PATIENCE)


@pytest.mark.parametrize("lab", LABS)
def test_the_data_that_travel_along(lesson, lab):
    page = lesson()
    before = shown(page, lab)
    stage(page, lab).get_by_role("combobox", name="Data").select_option(label="GEONET")
    _await_change(page, lab, before)
    assert _slider(page, lab, "Multipath").get_attribute("data-disabled") is not None
    assert stage(page, lab).get_by_text("no effect: real data are as they are").first.is_visible()


def test_real_roof(lesson, dataset):
    dataset("matrtklib-static")
    page = lesson()
    before = shown(page, "signal")
    stage(page, "signal").get_by_role("combobox", name="Data").select_option(label="real roof")
    _await_change(page, "signal", before)
    assert "G20 at 49 deg" in readouts(page, "signal")


def test_own_files_by_upload(lesson, tmp_path):
    import numpy as np

    from gnsslab.simulate import find_preset, simulate, write_simulation

    write_simulation(tmp_path, simulate(find_preset("static-baseline"), np.random.default_rng(3)))
    page = lesson()
    for lab in LABS:
        part = stage(page, lab)
        part.get_by_role("combobox", name="Data").select_option(label="my files")
        part.get_by_text("your observation and navigation files are missing").wait_for(timeout=PATIENCE)
        part.locator("input[type=file]").nth(0).set_input_files(tmp_path / "rover.obs")
        part.get_by_text("your navigation file is missing").wait_for(timeout=PATIENCE)
        part.locator("input[type=file]").nth(1).set_input_files(tmp_path / "broadcast.nav")
        part.locator(".gl-readouts").wait_for(timeout=PATIENCE)


def test_a_wrong_answer_and_a_right_one(lesson):
    page = lesson()
    sheet = page.locator(".gl-question").first
    for typed, words in (("1.33", "the carrier has a minus sign"), ("-7", "That is in cycles"), ("-1.33", "Right")):
        field = sheet.get_by_role("textbox")
        field.fill(typed)
        sheet.get_by_role("button", name="Check").click()
        page.locator(".gl-answer").filter(has_text=words).first.wait_for(timeout=PATIENCE)
