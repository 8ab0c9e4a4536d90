"""A lesson in marimo, without a browser: what links ask for and what students type is shown as text, never as markup."""

import pytest

from gnsslab.teaching.catalogue import find_lesson
from gnsslab.teaching.marimo_front import LessonFront
from gnsslab.teaching.progress import Progress

MARKUP = "</style><img src=x onerror=alert(1)>"


def front(**query):
    return LessonFront(find_lesson("00"), Progress(), query)


@pytest.mark.parametrize("asked", ["lab", "preset", "seed", "mode"])
def test_a_link_brings_no_markup_onto_the_page(asked):
    lesson = front(**{"mode": "present", asked: MARKUP})
    lab = lesson.lab("north")
    page = lesson.head().text + lab.preset_row(lab.presets(print)).text
    assert "<img src=x" not in page


def test_an_unknown_lab_leaves_the_first_one_on_the_stage():
    assert '.gl-stage[data-lab="north"]' in front(mode="present", lab="absent").head().text
    assert '.gl-stage[data-lab="north"]' in front(mode="present", preset="city").head().text


def test_what_was_typed_is_no_markup():
    lesson = front()
    said = lesson.check(next(iter(lesson._questions)), {"answer": "<img src=x onerror=a>", "hints": 0, "solution": 0}).text
    assert "is not understood" in said
    assert "<img" not in said
