"""Lesson 02 in a real browser, through the real server: two labs on one page."""

from functools import partial

import pytest
from stages import await_change, readouts, stage

PATIENCE = 60_000  # [ms], the very first load compiles kernels
LABS = ("cancelling", "correlation")


@pytest.fixture
def lesson(open_labs):
    """The lesson with both labs open."""
    return partial(open_labs, "02", "decimetres")


def test_a_preset_by_its_button(lesson):
    page = lesson()
    before, other = readouts(page, "cancelling"), readouts(page, "correlation")
    page.get_by_role("button", name="A millisecond off").click()
    assert "299 km" in await_change(page, "cancelling", before, PATIENCE)
    page.locator(".gl-look").get_by_text("the double difference does not care").wait_for()
    assert readouts(page, "correlation") == other


def test_a_preset_by_link(lesson):
    page = lesson("?preset=ignored")
    page.get_by_text("the ratios fall, and up scatters more than the solver admits").wait_for(timeout=PATIENCE)
    assert "claimed 5.4 mm" in readouts(page, "correlation")


def test_real_data_in_both_labs(lesson, dataset):
    dataset("geonet-0759-3040")
    page = lesson()
    for lab, words, blocked in (("cancelling", "61649713", "Baseline length"), ("correlation", "Right integers", "Code noise")):
        before = readouts(page, lab)
        stage(page, lab).get_by_role("radio", name="real pair").click()
        assert words in await_change(page, lab, before, PATIENCE)
        assert stage(page, lab).get_by_role("slider", name=blocked).get_attribute("data-disabled") is not None
        stage(page, lab).get_by_text("no effect: real data are as they are").first.wait_for()


def test_perfect_clocks_switch_off_what_has_no_effect(lesson):
    page = lesson()
    before = readouts(page, "cancelling")
    stage(page, "cancelling").get_by_role("radio", name="all perfect").click()
    await_change(page, "cancelling", before, PATIENCE)
    stage(page, "cancelling").get_by_text("no effect: all clocks are perfect").first.wait_for(timeout=PATIENCE)


def test_the_printed_error_is_switched_in(lesson):
    page = lesson()
    before = readouts(page, "correlation")
    stage(page, "correlation").get_by_role("combobox", name="The solver believes").select_option(label="as printed: 2 V")
    after = await_change(page, "correlation", before, PATIENCE)
    assert "claimed 8.9 mm" in after
    assert "3.63" in before
    assert "3.63" in after  # the ratio does not move


def test_a_wrong_and_a_right_answer_get_the_right_word(lesson):
    page = lesson()
    field = page.get_by_role("textbox", name="Your answer [mm]")
    for typed, words in (("12", "The variance grows four times"), ("6 mm", "Right: 6.00 mm")):
        field.fill(typed)
        field.press("Tab")
        page.get_by_text(words).wait_for(timeout=PATIENCE)


def test_goal_is_reached_live(lesson):
    page = lesson("?lab=cancelling&length=5&rover_clock=0.5&satellite=high")
    page.locator(".gl-reached").get_by_text("Reached.").wait_for(timeout=PATIENCE)
