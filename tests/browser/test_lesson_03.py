"""Lesson 03 in a real browser, through the real server: three labs on one page."""

import time
from functools import partial

import pytest
from stages import readouts, stage

PATIENCE = 60_000  # [ms], the very first load compiles kernels
LABS = ("centimetres", "cells", "spectrum")


@pytest.fixture
def lesson(open_labs):
    """The lesson with all labs open."""
    return partial(open_labs, "03", "ten times")


def _await_change(page, lab, before):
    deadline = time.monotonic() + PATIENCE / 1000
    while _shown(page, lab) in (before, ""):
        assert time.monotonic() < deadline, "nothing changed"
        page.wait_for_timeout(20)
    return _shown(page, lab)


def _shown(page, lab):
    """Return readouts, problem and pictures in words of a lab, all of one moment."""
    parts = ", ".join(f'.gl-stage[data-lab="{lab}"] .gl-{part}' for part in ("readouts", "problem", "pictures img"))
    return page.evaluate("parts => [...document.querySelectorAll(parts)].map(part => part.alt ?? part.innerText).join(' ')", parts)


def test_a_preset_by_its_button(lesson):
    page = lesson()
    before, other = _shown(page, "centimetres"), _shown(page, "spectrum")
    page.get_by_role("button", name="L1 alone").click()
    assert "32.7" in _await_change(page, "centimetres", before)
    page.locator(".gl-look").get_by_text("off by decimetres and more, with nothing between").wait_for()
    assert _shown(page, "spectrum") == other


def test_a_preset_by_link(lesson):
    page = lesson("?preset=thirty")
    page.get_by_text("two nodes for each ambiguity").first.wait_for(timeout=PATIENCE)
    assert "of 30 ambiguities" in readouts(page, "spectrum")
    assert "stopped at 500" in readouts(page, "spectrum")


def test_decorrelation_goes_off(lesson):
    page = lesson()
    before = _shown(page, "spectrum")
    stage(page, "spectrum").get_by_role("switch", name="Decorrelation").click()
    assert "decorrelation is off" in _await_change(page, "spectrum", before)


def test_the_winner_changes_with_the_float_point(lesson):
    page = lesson()
    before = _shown(page, "cells")
    assert "wrong" in readouts(page, "cells")
    page.get_by_role("button", name="All agree").click()
    _await_change(page, "cells", before)
    assert "wrong" not in readouts(page, "cells")


def test_real_data(lesson, dataset):
    dataset("geonet-0759-3040")
    page = lesson()
    before = _shown(page, "centimetres")
    stage(page, "centimetres").get_by_role("radio", name="real pair").click()
    assert "120 positions on the map" in _await_change(page, "centimetres", before)
    stage(page, "centimetres").get_by_text("no effect: real data are as they are").first.wait_for(state="attached")


def test_printed_errors_are_switched_in(lesson):
    page = lesson()
    belief = stage(page, "centimetres").get_by_role("combobox", name="The solver believes")
    for label, words in (("as printed: code 3 cm", "promised: 100.0 %"), ("diagonal alone", "2.492"), ("as printed: carrier alone", "13 unknowns")):
        before = _shown(page, "centimetres")
        belief.select_option(label=label)
        assert words in _await_change(page, "centimetres", before)


def test_a_wrong_and_a_right_answer_get_the_right_word(lesson):
    page = lesson()
    field = page.get_by_role("textbox", name="Your answer [epochs]")
    for typed, words in (("3", "it falls only with the root"), ("9 epochs", "Right: 9.0 epochs")):
        field.fill(typed)
        field.press("Tab")
        page.get_by_text(words).wait_for(timeout=PATIENCE)


def test_goal_is_reached_live(lesson):
    page = lesson("?lab=centimetres&frequencies=1&satellites=7&epochs=12&mask=20")
    page.locator(".gl-reached").get_by_text("Reached.").wait_for(timeout=PATIENCE)


def test_number_keys_press_presets_of_the_lab_in_front_of_the_class(visit):
    page = visit("/lesson/03/?mode=present&lab=cells", width=1280, height=800)
    page.locator('.gl-stage[data-lab="cells"] .gl-pictures img:visible').first.wait_for(timeout=PATIENCE)
    page.keyboard.press("4")
    page.locator(".gl-look:visible").get_by_text("Three satellites, one epoch.").wait_for(timeout=PATIENCE)
    plane, tree = (page.locator(".gl-pictures img:visible").nth(k).bounding_box() for k in (0, 1))
    assert tree["x"] >= plane["x"] + plane["width"], "the tree stands beside the plane"
    assert max(box["y"] + box["height"] for box in (plane, tree)) <= 800, "both are whole in sight without scrolling"
