"""Lessons run, are clean, and are found."""

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


@pytest.fixture
def app():
    """The marimo app of lesson 00."""
    return runpy.run_path(str(find_lesson("00").path))["app"]


def test_lab_waits_for_the_prediction(app):
    _, names = app.run()
    assert "result" not in names


def _answered(app, **controls):
    _, first = app.run(defs={"prediction": SimpleNamespace(value="not at all")})
    if not controls:
        return first
    moved = SimpleNamespace(value=first["controls"].value | controls, items=first["controls"].items)
    return app.run(defs={"prediction": SimpleNamespace(value="not at all"), "controls": moved})[1]


def test_lesson_runs_at_its_defaults(app):
    result = _answered(app)["result"]
    assert result.problem == ""
    assert result.settings == find_defaults()


def find_defaults():
    """Defaults of the lab of lesson 00."""
    from gnsslab.labs.north import north_lab

    return north_lab().defaults


def test_moving_a_control_moves_the_result(app):
    result = _answered(app, length=3.0)["result"]
    assert result.settings["length"] == 3.0
    assert result.truth.baseline_enu @ result.truth.baseline_enu == pytest.approx(9.0)


def test_code_shown_to_students_compiles():
    text = find_lesson("00").path.read_text("utf-8")
    blocks = [part.split("```")[0] for part in text.split("```python")[1:]]
    assert blocks
    for block in blocks:
        compile("\n".join(line.strip() for line in block.splitlines()), "lesson", "exec")
