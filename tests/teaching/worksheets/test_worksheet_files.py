"""Worksheets are read without running them; what is none says so."""

import json

import pytest
from filled_worksheets import NAMES, code, filled, write
from hypothesis import given
from hypothesis import strategies as st

from gnsslab.teaching.worksheets.files import assigns_answer, read_worksheet, typed_answer


@pytest.mark.parametrize(
    ("source", "typed"),
    [
        ("# in deg\nanswer = 119.7", "119.7"),
        ("answer = -3", "-3"),
        ("answer=+3e-2  # so", "+3e-2"),
        ('answer = "0,14 deg"', "0,14 deg"),
        ("answer = 0,14", "0,14"),  # Python reads a pair of numbers: the student meant a decimal comma
        ("answer = 0,05", "0,05"),  # no Python at all
        ("answer = -0,5", "-0,5"),
        ("answer = 119.7 deg", "119.7 deg"),
        ("answer = 119.7°  # from the sketch", "119.7°"),
        ("# in deg\nanswer = ...", ""),
        ("answer =", ""),
        ("answer = None", ""),
        ('answer = ""', ""),
    ],
)
def test_typed_answers_are_read(source, typed):
    assert typed_answer(source) == typed


@pytest.mark.parametrize(
    "source",
    [
        "answer = 3 / 1.2",
        "answer = x",
        "answer = -x",
        "answer = --3",
        "answer = True",
        "x = 3",
        "x = 1\nanswer = 2",
        "import os\nanswer = 3",
        "answer = x = 3",
        "answer += 3",
        "a b c",
        "",
        "# only a comment",
        "answer = " + "(" * 1000 + "1" + ")" * 1000,
        "answer = 1" + " " * 3000,
        "answer = 0x" + "f" * 5000,
        "\0answer = 2",
        "print(1)\nanswer = 5 deg",
    ],
)
def test_what_is_more_than_a_number_is_left_to_be_run(source):
    assert typed_answer(source) is None


@pytest.mark.parametrize(
    ("source", "is_given"),
    [
        ("answer = 1", True),
        ("answer: float = x", True),
        ("answer += 1", True),
        ("if x:\n    answer = 1", True),
        ("a, answer = 1, 2", True),
        ("print(answer)", False),
        ("answer1 = 3", False),
        ("", False),
        ("answer = 5 deg", True),  # no Python: said when it is run
    ],
)
def test_cells_that_give_an_answer_are_told_apart(source, is_given):
    assert assigns_answer(source) == is_given


@given(st.text())
def test_any_cell_can_be_read(source):
    assert typed_answer(source) is None or isinstance(typed_answer(source), str)
    assert isinstance(assigns_answer(source), bool)


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_every_number_that_python_writes_is_read(value):
    assert float(typed_answer(f"answer = {value!r}")) == value


@pytest.mark.parametrize(
    ("source", "student"),
    [
        ('name = "Ann Lee"', "Ann Lee"),
        ("# your name\nname = '王 小明 '", "王 小明"),
        ("name = Ann Lee", "Ann Lee"),  # without quotes
        ("name = Ann", "Ann"),
        ('name = "Ann\\nLee"', "Ann Lee"),
        ('name = ""', ""),
        ("", ""),
        ("print(1)\nname = 2", ""),
    ],
)
def test_name_is_read(tmp_path, source, student):
    assert read_worksheet(write(tmp_path / "a.ipynb", filled(student=source))).student == student


def test_cells_of_questions_are_found(tmp_path):
    worksheet = read_worksheet(write(tmp_path / "a.ipynb", filled({NAMES[0]: "answer = 1"}, before=["x = 1", "y = 2"])))
    assert (worksheet.lesson.number, worksheet.problem) == ("00", "")
    assert [name for name, _ in worksheet.asked] == NAMES
    assert worksheet.cells[dict(worksheet.asked)[NAMES[0]]] == "answer = 1"
    assert worksheet.cells[:2] == ("x = 1", "y = 2")


def other(**changes):
    """Return a filled worksheet with something about it changed."""
    return json.dumps(filled() | changes)


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("", "no notebook: its text is not JSON"),
        ("hello", "no notebook: its text is not JSON"),
        ("[" * 100_000, "no notebook: its text is not JSON"),
        ("[]", "no notebook: it has no list of cells"),
        ('{"cells": 3}', "no notebook: it has no list of cells"),
        ('{"worksheets": []}', "no notebook: it has no list of cells"),  # notebook format 3
        ('{"cells": []}', "no worksheet: make one with `gnsslab worksheet`"),
        (other(metadata=[]), "no worksheet"),
        (other(metadata={"gnsslab": "00"}), "no worksheet"),
        (other(metadata={"gnsslab": {"lesson": "00"}}), "no worksheet"),  # the twin of a lesson
        (other(metadata={"gnsslab": {"worksheet": "77"}}), "there is no lesson 77: the course has 00"),
        (other(metadata={"gnsslab": {"worksheet": ["00"]}}), "there is no lesson"),
    ],
)
def test_what_is_no_worksheet_says_so(tmp_path, text, problem):
    path = tmp_path / "a.ipynb"
    path.write_text(text)
    worksheet = read_worksheet(path)
    assert worksheet.problem.startswith(problem)
    assert worksheet.file == str(path)


def test_what_cannot_be_read_says_so(tmp_path):
    assert read_worksheet(tmp_path / "none.ipynb").problem == "cannot be read: No such file or directory"
    assert read_worksheet(tmp_path).problem.startswith("cannot be read: ")
    (tmp_path / "b.ipynb").write_bytes(b"\xff\xfe\x00")
    assert read_worksheet(tmp_path / "b.ipynb").problem.startswith("no notebook")


def test_odd_cells_are_passed_over(tmp_path):
    odd = filled()
    odd["cells"] += [3, {"cell_type": "code"}, {"cell_type": "code", "metadata": 3, "source": [1, 2]}, code("z = 1", question=7)]
    worksheet = read_worksheet(write(tmp_path / "a.ipynb", odd))
    assert worksheet.problem == ""
    assert worksheet.cells[-3:] == ("", "12", "z = 1")
