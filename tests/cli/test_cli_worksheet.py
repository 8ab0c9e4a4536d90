"""`gnsslab worksheet`: writes a notebook, overwrites none, and its marks come back."""

import json

import nbformat
import pytest


def test_writes_a_notebook_and_what_made_it(run, tmp_path):
    answer = run("worksheet", "00", "-o", tmp_path / "roof.ipynb")
    assert (answer.status, answer.err) == (0, "")
    assert "lesson 00 with 6 questions" in answer.out
    assert nbformat.read(tmp_path / "roof.ipynb", 4).metadata["gnsslab"]["worksheet"] == "00"
    assert json.loads((tmp_path / "roof.ipynb.json").read_text())["command"] == "worksheet"


def test_overwrites_only_when_told_so(run, tmp_path):
    path = tmp_path / "roof.ipynb"
    path.write_text("a student's work")
    refused = run("worksheet", "00", "-o", path)
    assert refused.status == 1
    assert refused.complaint == [f"gnsslab: {path} exists: give another name, or --force to overwrite it"]
    assert path.read_text() == "a student's work"
    assert run("worksheet", "00", "-o", path, "--force").status == 0
    assert path.read_text().startswith("{")


@pytest.mark.parametrize(
    ("lesson", "output", "words"),
    [
        ("99", "roof.ipynb", "there is no lesson 99"),
        ("00", "roof.txt", "expected a name that ends in .ipynb"),
        ("00", "", "the output has no name"),
        ("00", "nowhere/roof.ipynb", "does not exist: create it first"),
        ("00", "folder.ipynb", "is a folder"),
    ],
)
def test_bad_input_gets_one_sentence(run, tmp_path, monkeypatch, lesson, output, words):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder.ipynb").mkdir()
    answer = run("worksheet", lesson, "-o", output)
    assert answer.status == 1
    assert len(answer.complaint) == 1
    assert words in answer.complaint[0]
    assert [path.name for path in tmp_path.iterdir()] == ["folder.ipynb"]


def test_a_filled_worksheet_is_marked(run, tmp_path):
    run("worksheet", "00", "-o", tmp_path / "ada.ipynb")
    sheet = nbformat.read(tmp_path / "ada.ipynb", 4)
    fill(sheet, "heading-of-a-beam", "answer = 119.7")  # atan2(0.70, -0.40) in degrees
    fill(sheet, "sigma-of-heading", "import math\nanswer = math.degrees(3 / 1200)")
    fill(sheet, "length-for-a-sigma", "answer = 0.06")
    nbformat.write(sheet, tmp_path / "ada.ipynb")
    assert run("grade", tmp_path / "ada.ipynb", "-o", tmp_path / "marks.csv").status == 0
    header, row = (line.split(",") for line in (tmp_path / "marks.csv").read_text().splitlines())
    marks = dict(zip(header, row, strict=False))
    assert (marks["heading-of-a-beam"], marks["sigma-of-heading"], marks["length-for-a-sigma"]) == ("1", "1", "0")
    assert (marks["points"], marks["of"]) == ("2", "6")


def fill(sheet, question, source):
    """Put an answer into a blank."""
    (blank,) = [cell for cell in sheet.cells if cell.metadata.get("gnsslab", {}).get("question") == question]
    blank.source = source
