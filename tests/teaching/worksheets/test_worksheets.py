"""Worksheets: every question is a blank that the grader finds, and nothing gives an answer away."""

import nbformat
import pytest

from gnsslab import __version__
from gnsslab.teaching.catalogue import LESSONS
from gnsslab.teaching.jupyter.notebooks import as_text, twin
from gnsslab.teaching.worksheets.files import read_worksheet, typed_answer
from gnsslab.teaching.worksheets.writing import worksheet


@pytest.fixture(params=LESSONS, ids=lambda lesson: lesson.number)
def lesson(request):
    """Each lesson of the course."""
    return request.param


def test_the_grader_reads_it_as_blank(lesson, tmp_path):
    (tmp_path / "sheet.ipynb").write_text(as_text(worksheet(lesson)), "utf-8")
    read = read_worksheet(tmp_path / "sheet.ipynb")
    assert (read.problem, read.lesson, read.student) == ("", lesson, "")
    assert [name for name, _ in read.asked] == [question.name for question in lesson.exercises.QUESTIONS]
    assert [typed_answer(read.cells[place]) for _, place in read.asked] == [""] * len(read.asked)


def test_each_blank_stands_below_its_question_and_says_the_unit(lesson):
    cells = worksheet(lesson).cells
    for question in lesson.exercises.QUESTIONS:
        (place,) = [k for k, cell in enumerate(cells) if cell.metadata.get("gnsslab", {}).get("question") == question.name]
        assert cells[place - 1].source == question.text
        assert cells[place].source.endswith("\nanswer = ...")
        assert question.unit in cells[place].source


def test_nothing_gives_an_answer_away(lesson):
    text = "\n".join(cell.source for cell in worksheet(lesson).cells)
    for question in lesson.exercises.QUESTIONS:
        for told in (question.solution, *question.hints, *(mistake.words for mistake in question.mistakes)):
            assert told not in text
        assert f'lesson.question("{question.name}")' not in text


def test_it_is_valid_and_has_the_lesson_s_text_and_labs(lesson):
    sheet = worksheet(lesson)
    nbformat.validate(sheet)
    assert sheet.metadata["gnsslab"] == {"worksheet": lesson.number, "version": __version__}
    asked = {f'lesson.question("{question.name}")' for question in lesson.exercises.QUESTIONS}
    left_out = [c.source for c in twin(lesson).cells if c.source not in {cell.source for cell in sheet.cells}]
    assert {source for source in left_out if not source.startswith("## Check yourself")} == asked


def test_the_name_is_asked_for_first(lesson):
    first = next(cell for cell in worksheet(lesson).cells if cell.cell_type == "code")
    assert (first.source, first.metadata["gnsslab"]) == ('name = ""', {"student": True})
