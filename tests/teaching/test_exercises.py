"""The exercises of all lessons: every answer is right, every usual mistake is recognised, every text is there."""

import re

import pytest

from gnsslab.teaching.catalogue import LESSONS
from gnsslab.teaching.questions import judge

ASKED = [pytest.param(question, id=f"{lesson.number}-{question.name}") for lesson in LESSONS for question in lesson.exercises.QUESTIONS]
QUESTIONS = [asked.values[0] for asked in ASKED]
WRONG_BY = 3  # tolerances


def texts(question):
    """Return everything that a student reads of a question."""
    return (question.text, *question.hints, question.solution, *(mistake.words for mistake in question.mistakes))


def test_every_lesson_asks_four_questions_or_more():
    assert LESSONS
    for lesson in LESSONS:
        assert len(lesson.exercises.QUESTIONS) >= 4, lesson.number
        assert lesson.exercises.PREDICTION.answer in lesson.exercises.PREDICTION.options


def test_a_lesson_of_exercises_shows_nothing_else():
    for lesson in LESSONS:
        public = {name for name in vars(lesson.exercises) if not name.startswith("_")}
        assert {name for name in public if name.isupper()} == {"PREDICTION", "QUESTIONS"}


def test_names_are_unique_over_the_course():
    names = [question.name for question in QUESTIONS] + [lesson.exercises.PREDICTION.name for lesson in LESSONS]
    assert len(set(names)) == len(names)


@pytest.mark.parametrize("question", ASKED)
def test_the_answer_is_right(question):
    for typed in (repr(question.answer), question.answer_text, f"{question.answer!r} {question.unit}"):
        assert judge(question, typed).is_right, typed


@pytest.mark.parametrize("question", ASKED)
def test_every_usual_mistake_is_recognised(question):
    assert question.mistakes
    for mistake in question.mistakes:
        verdict = judge(question, repr(mistake.value))
        assert (verdict.is_number, verdict.is_right) == (True, False)
        assert mistake.words in verdict.words


@pytest.mark.parametrize("question", ASKED)
def test_a_little_beside_is_wrong(question):
    for side in (-WRONG_BY, WRONG_BY):
        verdict = judge(question, repr(question.answer + side * question.tolerance))
        assert verdict.is_number
        assert not verdict.is_right


@pytest.mark.parametrize("question", ASKED)
def test_the_answer_is_not_given_away(question):
    """Neither the question, nor the first hint, nor the words for a mistake hold a number that would be right."""
    for text in (question.text, question.hints[0], *(mistake.words for mistake in question.mistakes)):
        for number in re.findall(r"-?\d+(?:\.\d+)?", text):
            assert not judge(question, number).is_right, (number, text)


@pytest.mark.parametrize("question", ASKED)
def test_the_solution_holds_the_answer(question):
    numbers = re.findall(r"-?\d+(?:\.\d+)?", question.solution)
    assert any(judge(question, number).is_right for number in numbers)


@pytest.mark.parametrize("question", ASKED)
def test_texts_read_well(question):
    for text in texts(question):
        assert "\u2014" not in text  # an em dash
        assert text == text.strip()
        assert text.replace(r"\$", "").count("$") % 2 == 0, f"a formula is not closed: {text}"
        assert text[-1] in ".?!", text
        assert max(map(len, text.splitlines())) < 400, "too long for one paragraph"


@pytest.mark.parametrize("lesson", LESSONS, ids=lambda lesson: lesson.number)
def test_the_lesson_itself_does_not_give_the_answers_away(lesson):
    """No answer, rounded to three digits or more, stands in the lesson's own text: results and printed errors have other numbers."""
    told = {number for number in re.findall(r"\d+\.\d+", lesson.path.read_text("utf-8")) if len(number.replace(".", "").lstrip("0")) >= 3}
    answers = {abs(question.answer): question.name for question in lesson.exercises.QUESTIONS}
    assert told
    assert [(name, number) for answer, name in answers.items() for number in told if is_rounded(number, answer)] == []


def is_rounded(number, answer):
    """Return whether a number in digits is the answer, rounded.

    >>> is_rounded("21.34", 21.3444), is_rounded("1.49", 1.5)
    (True, False)
    """
    return f"{answer:.{len(number.partition('.')[2])}f}" == number
