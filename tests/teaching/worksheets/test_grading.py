"""Worksheets are marked: right, wrong, blank, worked out by code, stopped; nothing handed in is lost."""

import csv

import pytest
from filled_worksheets import NAMES, QUESTIONS, all_right, code, filled, write

from gnsslab.teaching.spreadsheets import harmless
from gnsslab.teaching.worksheets import grading
from gnsslab.teaching.worksheets.files import read_worksheet
from gnsslab.teaching.worksheets.grading import grade, grade_files

FIRST, SECOND = NAMES[:2]
SECONDS = 3.0


@pytest.fixture
def marks_of(tmp_path):
    """Mark one notebook."""
    return lambda notebook, seconds=60.0: grade(read_worksheet(write(tmp_path / "one.ipynb", notebook)), seconds)


@pytest.fixture
def never_run(monkeypatch):
    """Fail where a cell is run."""
    monkeypatch.setattr(grading, "run_cells", lambda *given: pytest.fail("a cell was run"))


@pytest.mark.usefixtures("never_run")
def test_typed_numbers_are_marked_without_running_anything(marks_of):
    marks = marks_of(filled(all_right(), before=["import os; os.remove('all')"]))
    assert marks.points == dict.fromkeys(NAMES, 1)
    assert (marks.of, marks.student, marks.lesson, marks.remarks) == (len(QUESTIONS), "Ann Lee", "00", ())


@pytest.mark.usefixtures("never_run")
def test_wrong_and_blank_are_told_apart(marks_of):
    marks = marks_of(filled({FIRST: "answer = -60.3", SECOND: 'answer = "0,143 deg"'}))
    assert marks.points == {FIRST: 0, SECOND: 1}
    assert marks.answers == {FIRST: "-60.3", SECOND: "0,143 deg"}
    assert marks.remarks == ()


@pytest.mark.usefixtures("never_run")
def test_what_cannot_be_judged_is_said(marks_of):
    marks = marks_of(filled({SECOND: "answer = 0.0025 rad"}, student="name = ''"))
    assert marks.points == {SECOND: 0}
    assert marks.remarks == ("no name", f'{SECOND}: The answer is asked in deg, not in "rad": type it in deg.')


def test_worked_out_answers_are_marked(marks_of):
    answers = {
        FIRST: "import numpy as np\nanswer = np.degrees(np.arctan2(0.70, -0.40))",
        SECOND: "answer = sigma / length * 180 / np.pi",
        NAMES[2]: "answer = 3.44",
        NAMES[3]: "answer = 35 - 180 + 360 + 1e-9j",
    }
    marks = marks_of(filled(answers, before=["sigma, length = 0.003, 1.2"]))
    assert marks.points == {FIRST: 1, SECOND: 1, NAMES[2]: 1, NAMES[3]: 0}
    assert marks.remarks == (f'{NAMES[3]}: "(215+1e-09j)" is not understood: type one number, such as 12.5 or 1.25e-3.',)


def test_an_answer_is_not_taken_from_the_cell_before(marks_of):
    answers = {FIRST: "answer = 100 + 19.7449", SECOND: "1 / 0\nanswer = 0.143", NAMES[2]: "print(answer)"}
    marks = marks_of(filled(answers))
    assert marks.points == {FIRST: 1}
    assert marks.remarks == (f'{NAMES[2]}: no "answer = ..." in its cell', f"{SECOND}: ZeroDivisionError: division by zero")


def test_an_endless_cell_costs_only_itself(marks_of):
    marks = marks_of(filled(all_right() | {FIRST: "while True: pass\nanswer = 1"}), SECONDS)
    assert marks.points == dict.fromkeys(NAMES[1:], 1)
    assert marks.remarks == (f"{FIRST}: stopped after 2 s",)


def test_other_cells_that_fail_are_named(marks_of):
    marks = marks_of(filled({FIRST: "answer = 119 + 0.7"}, before=["x = 1", "lab.show()"]))
    assert marks.points == {FIRST: 1}
    assert marks.remarks == ("code cell 2: NameError: name 'lab' is not defined",)


@pytest.mark.usefixtures("never_run")
def test_missing_and_copied_cells(marks_of):
    notebook = filled({FIRST: "answer = 119.7"})
    notebook["cells"] = [*notebook["cells"][:3], code("answer = 1", question=SECOND), code("answer = 0.143", question=SECOND)]
    notebook["cells"] += [code("answer = ...", question=SECOND), code("answer = 5", question="of-another-course")]
    marks = marks_of(notebook)
    assert marks.points == {FIRST: 1, SECOND: 1}  # of the copies the last filled one counts
    assert marks.remarks == tuple(f"{name}: its cell is missing" for name in NAMES[2:])


def table_of(path):
    """Return the rows of a CSV file as dictionaries."""
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_table_has_a_row_for_each_file_whatever_it_is(tmp_path):
    good = write(tmp_path / "good.ipynb", filled(all_right()))
    half = write(tmp_path / "half.ipynb", filled({FIRST: "answer = 119.7", SECOND: "answer = 9"}, student='name = "王小明"'))
    twin = write(tmp_path / "twin.ipynb", {"cells": [], "metadata": {"gnsslab": {"lesson": "00"}}})
    marked = grade_files([good, half, twin, tmp_path / "none.ipynb"], tmp_path / "marks.csv")
    rows = table_of(tmp_path / "marks.csv")
    assert list(rows[0]) == ["file", "name", "lesson", *NAMES, *(f"{name}_answer" for name in NAMES), "points", "of", "remarks"]
    assert [row["file"] for row in rows] == [marks.file for marks in marked] == [str(p) for p in (good, half, twin, tmp_path / "none.ipynb")]
    assert [(row["points"], row["of"]) for row in rows] == [(str(len(NAMES)), str(len(NAMES))), ("1", str(len(NAMES))), ("", ""), ("", "")]
    assert [rows[1][name] for name in NAMES[:3]] == ["1", "0", ""]
    assert (rows[1]["name"], rows[1][f"{SECOND}_answer"], rows[1][f"{NAMES[2]}_answer"]) == ("王小明", "9", "")
    assert rows[2]["remarks"].startswith("no worksheet")
    assert rows[3]["remarks"].startswith("cannot be read")


def test_rows_are_written_as_they_come(tmp_path):
    seen = []
    paths = [write(tmp_path / f"{k}.ipynb", filled(all_right())) for k in range(3)]
    grade_files(paths, tmp_path / "marks.csv", progress=lambda done, total: seen.append((done, total, len(table_of(tmp_path / "marks.csv")))))
    assert seen == [(1, 3, 1), (2, 3, 2), (3, 3, 3)]


@pytest.mark.parametrize("text", ["=1+1", "+1+1", "-1+1", "@SUM(A1)", "\t=1", "  =1", "\uff1d1", '=HYPERLINK("http://x")', "-3 mm"])
def test_spreadsheets_run_no_name(tmp_path, text):
    assert harmless(text) == f"'{text}"
    path = write(tmp_path / "a.ipynb", filled({FIRST: f"answer = {text!r}"}, student=f"name = {text!r}"))
    grade_files([path], tmp_path / "marks.csv")
    (row,) = table_of(tmp_path / "marks.csv")
    assert row["name"] == row[f"{FIRST}_answer"] == f"'{' '.join(text.split())}"


@pytest.mark.parametrize("text", ["", "Ann", "-3.5", "+2", "1e-3", 'O\'Neil, "Jo"'])
def test_harmless_texts_stay(text):
    assert harmless(text) == text


def test_odd_letters_do_not_stop_the_table(tmp_path):
    path = write(tmp_path / "a.ipynb", filled(student='name = "\ud800 Ann"'))
    grade_files([path], tmp_path / "marks.csv")
    assert "\\ud800 Ann" in table_of(tmp_path / "marks.csv")[0]["name"]
