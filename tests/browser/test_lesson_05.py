"""Lesson 05 in a real browser, through the real server: what only this lesson has."""

from functools import partial

import pytest
from stages import await_change, readouts, stage

PATIENCE = 90_000  # [ms], the very first load compiles kernels
LABS = ("three-filters", "filter-health", "length-forms", "platforms")


@pytest.fixture
def lesson(open_labs):
    """The lesson with all labs open."""
    return partial(open_labs, "05", "both")


def test_a_preset_by_its_button_leaves_the_other_labs_alone(lesson):
    page = lesson()
    others = {lab: readouts(page, lab) for lab in LABS if lab != "three-filters"}
    before = readouts(page, "three-filters")
    page.get_by_role("button", name="Row as printed", exact=True).click()
    after = await_change(page, "three-filters", before, PATIENCE)
    assert "5.46" in after
    assert {lab: readouts(page, lab) for lab in others} == others


def test_a_printed_error_is_switched_in(lesson):
    page = lesson()
    before = readouts(page, "three-filters")
    stage(page, "three-filters").get_by_role("combobox", name="Formula as printed").select_option(label="(25) prediction")
    assert "0.02" in await_change(page, "three-filters", before, PATIENCE)


def test_the_length_moves_from_the_row_to_the_search(lesson, dataset):
    dataset("matrtklib-static")
    page = lesson()
    before = readouts(page, "length-forms")
    assert "0.0" in before
    stage(page, "length-forms").get_by_role("combobox", name="Shown over time").select_option(label="search")
    assert "100.0" in await_change(page, "length-forms", before, PATIENCE)


def test_the_position_correction_is_switched_on(lesson):
    page = lesson("?preset=offset")
    before = readouts(page, "platforms")
    assert "250 wrong" in before
    stage(page, "platforms").get_by_text("Correct the master's position").click()
    assert "none wrong" in await_change(page, "platforms", before, PATIENCE)


def test_a_wrong_and_a_right_answer_get_the_right_word(lesson):
    page = lesson()
    field = page.get_by_role("textbox", name="Your answer [mm]")
    for typed, words in (("20", "That is the variance"), ("4,47", "Right: 4.47 mm")):
        field.fill(typed)
        field.press("Tab")
        page.get_by_text(words).wait_for(timeout=PATIENCE)


def test_goal_is_reached_live(lesson):
    page = lesson("?lab=three-filters&velocity_noise=0&length=3")
    page.locator(".gl-reached").get_by_text("Reached.").wait_for(timeout=PATIENCE)
