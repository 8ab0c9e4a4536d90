"""Lessons run, are clean, and are found."""

import re
import runpy
import subprocess
import sys
from types import SimpleNamespace

import pytest

from gnsslab.data.locations import project_folder
from gnsslab.teaching.catalogue import LESSONS, Lesson, find_lesson

FILES = sorted(project_folder("lessons").glob("[0-9][0-9]_*.py"))


def test_there_are_lessons_and_the_catalogue_names_them_all():
    assert FILES, "no lesson found"
    assert [lesson.path for lesson in LESSONS] == FILES


def test_unknown_lessons_are_refused_in_words():
    with pytest.raises(ValueError, match="there is no lesson 99: the course has 00"):
        find_lesson(99)


@pytest.mark.parametrize("lesson", LESSONS, ids=lambda lesson: lesson.number)
def test_catalogue_is_complete(lesson):
    assert all((lesson.title, lesson.teaser, lesson.needs, lesson.gives))
    assert 5 <= lesson.minutes <= 90


def test_lessons_are_clean():
    outcome = subprocess.run([sys.executable, "-m", "marimo", "check", "--strict", *map(str, FILES)], capture_output=True, text=True, check=False)
    assert outcome.returncode == 0, outcome.stdout + outcome.stderr


@pytest.mark.parametrize("lesson", LESSONS, ids=lambda lesson: lesson.number)
def test_lesson_has_the_form_of_a_lesson(lesson: Lesson):
    text = lesson.path.read_text("utf-8")
    parts = (
        "The scene",
        "Predict",
        "Play",
        "Why it works",
        "Reach a goal",
        "Real data",
        "Find the printed error",
        "Check yourself",
        "What can go wrong",
        "Sources",
    )
    places = [text.find(f"## {part}") for part in parts]
    assert -1 not in places, [part for part, place in zip(parts, places, strict=True) if place < 0]
    assert places == sorted(places)
    assert "# /// script" not in text  # it would make marimo ask for a sandbox


def run(lesson, **changed):
    """Run a lesson without a browser, the prediction made and controls of its first lab changed; return its names."""
    app = runpy.run_path(str(lesson.path))["app"]
    predicted = {"prediction": SimpleNamespace(value=lesson.exercises.PREDICTION.options[0])}
    names = app.run(defs=predicted)[1]
    if not changed:
        return names
    moved = SimpleNamespace(value=names["controls"].value | changed, items=names["controls"].items)
    return app.run(defs=predicted | {"controls": moved})[1]


@pytest.mark.parametrize("lesson", LESSONS, ids=lambda lesson: lesson.number)
def test_lab_waits_for_the_prediction(lesson):
    names = runpy.run_path(str(lesson.path))["app"].run()[1]
    assert "result" not in names
    assert "prediction" in names


@pytest.mark.parametrize("lesson", LESSONS, ids=lambda lesson: lesson.number)
def test_lesson_runs_at_its_defaults(lesson):
    result = run(lesson)["result"]
    first = next(iter(lesson.open_labs().values()))
    assert result.problem == ""
    assert result.settings == first.defaults


@pytest.mark.parametrize("lesson", LESSONS, ids=lambda lesson: lesson.number)
def test_every_lab_goal_and_question_stands_in_the_lesson(lesson):
    text = lesson.path.read_text("utf-8")
    labs = lesson.open_labs()
    goals = [goal.name for lab in labs.values() for goal in lab.goals]
    for kind, names in (("lab", labs), ("ask", [question.name for question in lesson.exercises.QUESTIONS])):
        assert re.findall(rf'lesson\.{kind}\("([^"]+)"\)', text) == list(names), kind
    assert goals
    assert re.findall(r'\.goal\("([^"]+)"', text) == goals


@pytest.mark.parametrize("lesson", LESSONS, ids=lambda lesson: lesson.number)
def test_lessons_have_what_every_lesson_has(lesson):
    labs = lesson.open_labs().values()
    assert sum(len(lab.presets) for lab in labs) >= 4
    assert all(preset.look_at.endswith(".") for lab in labs for preset in lab.presets)
    names = [preset.name for lab in labs for preset in lab.presets]
    assert len(set(names)) == len(names), "a link names a preset by its name alone"


def test_moving_a_control_moves_the_result():
    result = run(find_lesson("00"), length=3.0)["result"]
    assert result.settings["length"] == 3.0
    assert result.truth.baseline_enu @ result.truth.baseline_enu == pytest.approx(9.0)


@pytest.mark.parametrize("lesson", LESSONS, ids=lambda lesson: lesson.number)
def test_code_shown_to_students_compiles(lesson):
    text = lesson.path.read_text("utf-8")
    blocks = [part.split("```")[0] for part in text.split("```python")[1:]]
    assert blocks
    for block in blocks:
        compile("\n".join(line.strip() for line in block.splitlines()), "lesson", "exec")
