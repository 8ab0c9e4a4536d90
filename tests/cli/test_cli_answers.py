"""`gnsslab answers`: the instructor's key in a terminal, and as JSON."""

import json
import subprocess
import sys

import pytest

from gnsslab.teaching.catalogue import LESSONS
from gnsslab.teaching.questions import judge


@pytest.mark.parametrize("lesson", LESSONS, ids=lambda lesson: lesson.number)
@pytest.mark.parametrize("columns", [60, 80, 200])
def test_key_holds_every_question_and_fits_the_terminal(run, monkeypatch, lesson, columns):
    monkeypatch.setenv("COLUMNS", str(columns))
    answer = run("answers", lesson.number)
    assert answer.status == 0, answer.err
    lines = answer.out.splitlines()
    assert max(map(len, lines)) <= min(columns, 100)
    assert lines[0] == f"Lesson {lesson.number}: {lesson.title}"
    for question in lesson.exercises.QUESTIONS:
        assert question.name in answer.out
        assert f"Answer: {question.answer_text}" in answer.out
    assert f"* {lesson.exercises.PREDICTION.answer}" in answer.out


def test_every_solution_and_mistake_is_printed_whole(run):
    words = " ".join(run("answers", "0").out.replace("\u2022", "").split())
    for question in LESSONS[0].exercises.QUESTIONS:
        assert words.count(f"{question.mistakes[0].value:.4g} {question.unit}: ") >= 1
    assert "From east the beam turns a further 29.7° towards south" in words


@pytest.mark.parametrize("typed", ["00", "0"])
def test_a_lesson_is_found_by_its_number(run, typed):
    assert run("answers", typed).out.startswith("Lesson 00")


@pytest.mark.parametrize("typed", ["99", "north", "", "-1.5"])
def test_unknown_lessons_are_refused_with_those_that_exist(run, typed):
    answer = run("answers", "--", typed)
    assert answer.status == 1
    assert len(answer.err.splitlines()) == 1
    assert f"the course has {', '.join(lesson.number for lesson in LESSONS)}" in answer.err


def test_json_says_the_same(run):
    key = json.loads(run("answers", "00", "--json").out)
    assert key["lesson"] == "00"
    for told, question in zip(key["questions"], LESSONS[0].exercises.QUESTIONS, strict=True):
        assert judge(question, repr(told["answer"])).is_right
        assert told["hints"] == list(question.hints)


def test_a_terminal_without_greek_is_served():
    done = subprocess.run(
        [sys.executable, "-X", "utf8=0", "-m", "gnsslab", "answers", "00"],
        capture_output=True, text=True, encoding="ascii", env={"PYTHONIOENCODING": "ascii", "PATH": ""}, check=False,
    )  # fmt: skip
    assert (done.returncode, done.stderr) == (0, "")
    assert "?" in done.stdout
