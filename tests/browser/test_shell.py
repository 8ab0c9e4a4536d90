"""What every lesson has from the shell, in a real browser: questions, saving, links, presenting, progress."""

import csv
import re
from functools import partial

import pytest

from gnsslab.teaching.catalogue import find_lesson

PATIENCE = 60_000  # [ms]
LESSON = find_lesson("00")
ASKED = LESSON.exercises.QUESTIONS[0]


def _open(visit, path="/lesson/00/", **how):
    page = visit(path, **how)
    page.get_by_role("radio", name=LESSON.exercises.PREDICTION.options[2]).click(timeout=PATIENCE)
    page.wait_for_selector(".gl-pictures img", timeout=PATIENCE)
    page.get_by_text("save this").nth(1).wait_for(timeout=PATIENCE)  # both labs stand
    return page


@pytest.fixture
def lesson(open_labs):
    """The lesson as it opens."""
    return partial(open_labs, LESSON.number, LESSON.exercises.PREDICTION.options[2])


def _answer(page, text):
    field = page.get_by_role("textbox", name="Your answer").first
    field.fill(text)
    page.get_by_role("button", name="Check").first.click()
    return page.locator(".gl-verdict").first


def test_a_wrong_answer_and_a_right_one_get_their_words(visit):
    page = _open(visit)
    mistake = ASKED.mistakes[0]
    _answer(page, f"{mistake.value:g}").wait_for(timeout=PATIENCE)
    page.locator(".gl-verdict.gl-wrong").first.wait_for(timeout=PATIENCE)
    _answer(page, "north")
    page.locator(".gl-verdict").get_by_text("north").first.wait_for(timeout=PATIENCE)
    _answer(page, f"{ASKED.answer:.4g} {ASKED.unit}".replace(".", ","))
    page.locator(".gl-verdict.gl-right").first.wait_for(timeout=PATIENCE)


def test_hints_come_one_by_one_and_the_solution_after_a_try(visit):
    page = _open(visit)
    page.get_by_role("button", name="Solution").first.click()
    page.get_by_text("Try once, or take both hints").wait_for(timeout=PATIENCE)
    page.get_by_role("button", name="Hint").first.click()
    page.get_by_text("Hint 1", exact=True).wait_for(timeout=PATIENCE)
    assert page.get_by_text("Hint 2", exact=True).count() == 0
    page.get_by_role("button", name="Hint").first.click()
    page.get_by_text("Hint 2", exact=True).wait_for(timeout=PATIENCE)
    page.get_by_text("Try once, or take both hints").wait_for(state="detached", timeout=PATIENCE)


def test_answers_stand_there_again_and_on_the_home_page(visit):
    page = _open(visit)
    _answer(page, f"{ASKED.answer:.4g}")
    page.locator(".gl-verdict.gl-right").first.wait_for(timeout=PATIENCE)
    page.reload()
    page.locator(".gl-verdict.gl-right").first.wait_for(timeout=PATIENCE)
    page.wait_for_selector(".gl-pictures img", timeout=PATIENCE)  # the prediction stands too: the lab is open
    page.get_by_role("link", name="All lessons").click()
    page.get_by_text(re.compile(r"1 of \d+ questions")).first.wait_for(timeout=PATIENCE)


@pytest.mark.parametrize("kind", ["PNG", "SVG", "CSV"])
def test_saved_files_arrive(lesson, kind):
    page = lesson()
    if not page.get_by_role("link", name=kind).first.is_visible():  # folded
        page.get_by_text("save this").first.click()
    with page.expect_download(timeout=PATIENCE) as download:
        page.get_by_role("link", name=kind).first.click()
    assert download.value.suggested_filename == f"north.{kind.lower()}"
    content = download.value.path().read_bytes()
    if kind == "CSV":
        assert len(list(csv.DictReader(content.decode("utf-8").splitlines()))) == 300
    else:
        assert content[:8] == b"\x89PNG\r\n\x1a\n" if kind == "PNG" else b"<svg" in content


def test_a_link_brings_the_controls_back(visit):
    page = _open(visit)
    page.get_by_role("button", name="Arm's length").click()
    page.get_by_text("The same millimetres on a shorter lever").wait_for(timeout=PATIENCE)
    page.get_by_text("save this").first.click()
    page.get_by_role("button", name="Link").first.click()
    address = page.locator(".gl-note a").first.get_attribute("href", timeout=PATIENCE)
    again = _open(visit, address)
    length = again.locator('[data-lab="north"]').get_by_role("slider", name="Baseline length")
    assert float(length.get_attribute("aria-valuenow")) == pytest.approx(0.3)


def test_a_preset_is_reached_by_link_and_marked(visit):
    page = _open(visit, "/lesson/00/?preset=city")
    page.get_by_text("High walls hide all below 45 degrees").wait_for(timeout=PATIENCE)
    line = "getComputedStyle(document.querySelector('.gl-preset[data-preset=\"{}\"]')).borderBottomColor"
    assert page.evaluate(line.format("city")) != page.evaluate(line.format("start"))


def test_a_broken_link_is_told_and_the_lesson_opens(visit):
    page = _open(visit, "/lesson/00/?preset=moon&length=99")
    page.get_by_text("this lesson has start, survey").wait_for(timeout=PATIENCE)
    page.get_by_text("Baseline length is a number from 0.3 to 5 m, not '99'").wait_for(timeout=PATIENCE)


def test_presenting_shows_one_large_picture_and_number_keys_press_presets(visit):
    page = visit("/lesson/00/?mode=present", width=1920, height=1080)
    page.wait_for_selector(".gl-pictures img", timeout=PATIENCE)  # no prediction is asked of a class
    visible = page.locator(".gl-pictures img:visible")
    assert visible.count() == 1
    box = visible.bounding_box()
    assert box["width"] > 600
    assert box["y"] + box["height"] <= 1080, "the whole picture is in sight without scrolling"
    for hidden in ("The scene", "Check yourself"):
        assert page.get_by_role("heading", name=hidden).is_hidden()
    page.keyboard.press("7")
    page.get_by_text("The same millimetres on a shorter lever").wait_for(timeout=PATIENCE)
    page.keyboard.press("2")
    page.get_by_text("Half the carrier noise").wait_for(timeout=PATIENCE)
