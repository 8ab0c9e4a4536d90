"""Lesson 04 in a real browser, through the real server: four labs on one page."""

from functools import partial

import pytest
from stages import await_change, readouts, stage

PATIENCE = 90_000  # [ms], the very first load compiles kernels
LABS = ("trust", "soft-fixing", "known-length", "fewer-satellites")


@pytest.fixture
def lesson(open_labs):
    """The lesson with all labs open."""
    return partial(open_labs, "04", "four")


def test_the_stairs_have_a_slider_of_their_own(lesson):
    """It moves no readout: the picture and its words change."""
    page = lesson()
    picture = stage(page, "soft-fixing").locator(".gl-pictures img").first
    stage(page, "soft-fixing").get_by_role("slider", name="Sigma of one ambiguity").press("End")
    page.locator('.gl-stage[data-lab="soft-fixing"] .gl-pictures img[alt*="sigma 0.80 cycles"]').wait_for(timeout=PATIENCE)
    assert "best equivariant" in picture.get_attribute("alt")


def test_presets_by_their_buttons_leave_the_other_labs_alone(lesson):
    page = lesson()
    others = {lab: readouts(page, lab) for lab in LABS if lab != "trust"}
    before = readouts(page, "trust")
    page.get_by_role("button", name="Multipath", exact=True).click()
    assert "55.7" in await_change(page, "trust", before, PATIENCE)
    assert {lab: readouts(page, lab) for lab in others} == others


def test_a_preset_by_link(lesson):
    page = lesson("?preset=trees")
    page.get_by_text("One noisy satellite, and").wait_for(timeout=PATIENCE)
    assert "13 of 14" in readouts(page, "soft-fixing")


def test_the_fixed_failure_rate_switches_the_threshold_off(lesson):
    page = lesson()
    before = readouts(page, "trust")
    stage(page, "trust").get_by_role("combobox", name="Test").select_option(label="fixed failure rate")
    assert "threshold 1.54" in await_change(page, "trust", before, PATIENCE)
    stage(page, "trust").get_by_text("no effect: the tolerated failures set the threshold").wait_for(timeout=PATIENCE)


def test_the_printed_error_is_switched_in(lesson):
    page = lesson()
    before = readouts(page, "trust")
    stage(page, "trust").get_by_text("more", exact=True).click()
    stage(page, "trust").get_by_role("radio", name="upside down").click()
    after = await_change(page, "trust", before, PATIENCE)
    assert "59.9" in after
    assert "6.4" in after


def test_the_length_is_used_once_and_twice(lesson):
    page = lesson()
    before = readouts(page, "known-length")
    assert "96.0" in before
    stage(page, "known-length").get_by_role("combobox", name="Length goes into").select_option(label="row and search: twice")
    assert "22.0" in await_change(page, "known-length", before, PATIENCE)


def test_real_epochs_break_with_five_satellites(lesson, dataset):
    dataset("matrtklib-static")
    page = lesson()
    before = readouts(page, "fewer-satellites")
    stage(page, "fewer-satellites").get_by_role("slider", name="Satellites left").press("ArrowLeft")
    assert "25.7" in await_change(page, "fewer-satellites", before, PATIENCE)


def test_a_wrong_and_a_right_answer_get_the_right_word(lesson):
    page = lesson()
    field = page.get_by_role("textbox", name="Your answer [cycles]")
    for typed, words in (("0.4", "it forgets that the truth is an integer"), ("0,248", "Right: 0.248 cycles")):
        field.fill(typed)
        field.press("Tab")
        page.get_by_text(words).wait_for(timeout=PATIENCE)


def test_goal_is_reached_live(lesson):
    page = lesson("?lab=soft-fixing&satellites=8&code_noise=0.3")
    page.locator(".gl-reached").get_by_text("Reached.").wait_for(timeout=PATIENCE)


def test_pictures_have_words(lesson):
    page = lesson()
    for lab, words in (
        ("trust", "Counted in 10000 epochs"),
        ("soft-fixing", "2000 epochs"),
        ("known-length", "map"),
        ("fewer-satellites", "satellites"),
    ):
        assert words in stage(page, lab).locator(".gl-pictures img").first.get_attribute("alt")
