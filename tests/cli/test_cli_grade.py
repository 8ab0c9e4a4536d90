"""`gnsslab grade`: a table of marks, its provenance, and status 1 where a file is no worksheet."""

import json

import pytest
from filled_worksheets import NAMES, all_right, filled, write


@pytest.fixture
def good(tmp_path):
    """A worksheet with every answer right."""
    return write(tmp_path / "good.ipynb", filled(all_right()))


def test_marks_and_what_made_them(run, good, tmp_path):
    answer = run("grade", good, "-o", tmp_path / "marks.csv", "--timeout", 20)
    assert (answer.status, answer.err) == (0, "")
    assert answer.out == f"written to {tmp_path / 'marks.csv'}: 1 of 1 notebooks marked\n"
    assert f",{len(NAMES)},{len(NAMES)}," in (tmp_path / "marks.csv").read_text().splitlines()[1]
    made = json.loads((tmp_path / "marks.csv.json").read_text())
    assert (made["command"], made["options"]["timeout"], made["notes"]) == ("grade", 20.0, [])
    assert [made_of["file"] for made_of in made["inputs"]] == [str(good)]


def test_two_at_once_by_code(run, tmp_path):
    paths = [write(tmp_path / f"{k}.ipynb", filled({NAMES[0]: f"answer = {k} + 119.7"})) for k in (0, 1)]
    assert run("grade", *paths, "-o", tmp_path / "marks.csv").status == 0
    rows = (tmp_path / "marks.csv").read_text().splitlines()[1:]
    assert [row.split(",")[3] for row in rows] == ["1", "0"]


def test_what_is_no_worksheet_is_counted_and_nothing_is_lost(run, good, tmp_path):
    (tmp_path / "text.ipynb").write_text("hello")
    answer = run("grade", tmp_path / "none.ipynb", good, tmp_path / "text.ipynb", "-o", tmp_path / "marks.csv")
    assert answer.status == 1
    assert answer.err == f"gnsslab: 2 of 3 files are no worksheets ({tmp_path / 'none.ipynb'}...): see the remarks in {tmp_path / 'marks.csv'}\n"
    assert len((tmp_path / "marks.csv").read_text().splitlines()) == 1 + 3
    made = json.loads((tmp_path / "marks.csv.json").read_text())
    assert len(made["inputs"]) == 1
    assert made["notes"][0] == f"{tmp_path / 'none.ipynb'}: cannot be read: No such file or directory"


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("-o", "{folder}"), "is a folder"),
        (("-o", "{folder}/no/marks.csv"), "does not exist"),
        (("-o", "{folder}/good.ipynb"), "is one of the inputs"),
        (("-o", "{folder}/marks.csv", "--timeout", "0"), "--timeout 0: expected seconds above zero"),
        (("-o", "{folder}/marks.csv", "--timeout", "inf"), "--timeout inf: expected seconds above zero"),
    ],
)
def test_wrong_options_are_one_line(run, good, tmp_path, options, words):
    answer = run("grade", good, *(option.format(folder=tmp_path) for option in options))
    assert answer.status == 1
    assert len(answer.err.splitlines()) == 1
    assert words in answer.err
    assert not (tmp_path / "marks.csv").exists()


@pytest.mark.parametrize(
    "arguments", [("grade",), ("grade", "a.ipynb"), ("grade", "-o", "m.csv"), ("grade", "a.ipynb", "-o", "m.csv", "--timeout", "long")]
)
def test_missing_arguments_are_status_2(run, arguments):
    assert run(*arguments).status == 2
