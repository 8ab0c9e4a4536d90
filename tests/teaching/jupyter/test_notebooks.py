"""The JupyterLab twins: what becomes of each step, and that the committed ones are those of the lessons."""

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import nbformat
import pytest
from small_lesson import WHOLE, cell

from gnsslab.data.locations import project_folder
from gnsslab.teaching.catalogue import LESSONS, Lesson, find_lesson
from gnsslab.teaching.jupyter.notebooks import as_text, for_jupyter, twin, twin_name

FOLDER = project_folder("lessons") / "jupyter"


@pytest.fixture
def small(tmp_path):
    """A function that makes a catalogued lesson of a marimo file's text."""

    class Small(Lesson):
        path = property(lambda self: tmp_path / self.file)

    def make(source):
        (tmp_path / "00_small.py").write_text(source, "utf-8")
        return Small(**vars(replace(find_lesson("00"), file="00_small.py")))

    return make


def test_there_are_lessons_and_each_has_its_twin_and_no_other():
    assert LESSONS
    assert sorted(path.name for path in FOLDER.glob("*.ipynb")) == sorted(twin_name(lesson) for lesson in LESSONS)


@pytest.mark.parametrize("lesson", LESSONS, ids=lambda lesson: lesson.number)
def test_committed_twin_is_the_one_made_from_the_lesson(lesson):
    assert (FOLDER / twin_name(lesson)).read_text("utf-8") == as_text(twin(lesson)), "run python tools/twins.py"


def test_the_tool_agrees_that_nothing_differs():
    tool = Path(__file__).resolve().parents[3] / "tools" / "twins.py"
    outcome = subprocess.run([sys.executable, tool, "--check"], capture_output=True, text=True, check=False)
    assert (outcome.returncode, outcome.stderr) == (0, "")


def test_each_step_becomes_a_cell(small):
    cells = twin(small(WHOLE)).cells
    assert [(c.cell_type, c.source) for c in cells[1:]] == [
        ("code", 'from gnsslab.teaching.jupyter.front import open_lesson\n\nlesson = open_lesson("00")'),
        ("markdown", "## The scene\n\nHeading is $\\psi$, see the notation."),
        ("code", "lesson.predict()"),
        ("code", 'north = lesson.lab("north")\nnorth'),
        ("markdown", "## Play\n\n<details><summary>After your prediction</summary>\n\nBlue is *fixed*.\n\n</details>"),
        ("code", 'north.goal("sharp")'),
        ("code", 'lesson.question("heading-of-a-beam")'),
    ]
    assert cells[0].source.startswith("# Which way is north?\n\nLesson 00 · about 25 minutes")


def test_a_twin_is_valid_and_always_the_same(small):
    lesson = small(WHOLE)
    text = as_text(twin(lesson))
    assert text == as_text(twin(lesson))
    made = json.loads(text)
    nbformat.validate(made)
    assert len({c["id"] for c in made["cells"]}) == len(made["cells"])
    code = [c for c in made["cells"] if c["cell_type"] == "code"]
    assert code
    assert all(c["outputs"] == [] and c["execution_count"] is None for c in code)


def test_an_unknown_cell_is_refused_with_its_text(small):
    with pytest.raises(ValueError, match=r"mo\.accordion"):
        twin(small(cell("mo.accordion({})")))


@pytest.mark.parametrize(
    ("markup", "shown"),
    [
        ("[lesson 00](/lesson/00/)", "[lesson 00](00_which_way_is_north.ipynb)"),
        ("[start](/lesson/00/?preset=cheap)", "[start](00_which_way_is_north.ipynb)"),
        (r"[$\sigma_\psi$](/notation#sigma_psi)", r"$\sigma_\psi$"),
        ("[data](/data) and [more](https://example.org/a)", "data and [more](https://example.org/a)"),
        ("a / b, x[1](2)", "a / b, x[1](2)"),
    ],
)
def test_links_lead_where_a_notebook_can_follow(markup, shown):
    assert for_jupyter(markup) == shown


@pytest.mark.parametrize(
    "markup", ["/// tip\nMind this.\n///", "::lucide:rocket::", '<a href="/data">data</a>', "![picture](/a.png)", "<style>b{}</style>"]
)
def test_markup_that_jupyterlab_does_not_show_is_refused(markup):
    with pytest.raises(ValueError, match="JupyterLab does not show the markup"):
        for_jupyter(f"Some text.\n\n{markup}")


def test_a_link_to_a_lesson_that_is_not_there_is_refused():
    with pytest.raises(ValueError, match="there is no lesson 98"):
        for_jupyter("[later](/lesson/98/)")
