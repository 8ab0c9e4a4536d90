"""`gnsslab reproduce`: a report and its numbers, the same for the same seeds; what is refused."""

import json

import pytest


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A report of two seeds."""
    from gnsslab.cli import main

    folder = tmp_path_factory.mktemp("report")
    assert main(["reproduce", "A", "-o", str(folder / "report.html"), "--seeds", "2", "--seed", "7"]) == 0
    return folder


def test_report_numbers_and_what_made_them(folder):
    assert {path.name for path in folder.iterdir()} == {"report.html", "report.json", "report.html.json"}
    lines = json.loads((folder / "report.json").read_text("utf-8"))
    assert {line["paper"] for line in lines} == {"A"}
    assert {line["seeds"] for line in lines} <= {0, 1, 2}
    wanted = {"paper", "item", "quantity", "unit", "paper_value", "ours_mean", "ours_sd", "seeds", "verdict", "cause"}
    assert all(wanted <= set(line) for line in lines)
    made = json.loads((folder / "report.html.json").read_text("utf-8"))
    assert made["options"] == {"papers": ["A"], "output": str(folder / "report.html"), "seeds": 2, "seed": 7}
    assert "gnsslab reproduce A -o report.html --seeds 2 --seed 7" in (folder / "report.html").read_text("utf-8")


def test_same_seeds_same_report_and_no_letter_is_all(run, folder, tmp_path, monkeypatch):
    monkeypatch.setattr("gnsslab.reproduce.papers.MODULES", {"A": "gnsslab.reproduce.paper_a"})  # the others take longer
    answer = run("reproduce", "-o", tmp_path / "report.html", "--seeds", 2, "--seed", 7)
    assert (answer.status, answer.err) == (0, "")
    assert answer.out.startswith("paper A: ")
    for name in ("report.html", "report.json"):
        assert (tmp_path / name).read_bytes() == (folder / name).read_bytes()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("X",), "there is no paper 'X': expected letters of A, B, C, D, E"),
        (("A", "C"), "paper C cannot be reproduced yet: there is A, B"),
        (("A", "--seeds", 0), "--seeds 0: expected a whole number from 1"),
        (("A", "--seed", -1), "--seed -1: expected a whole number, zero or above"),
        (("A", "-o", "report.txt"), "expected a name that ends in .html"),
        (("A", "-o", ".html"), "expected a name that ends in .html"),
        (("A", "-o", "no-such-folder/report.html"), "folder of the output"),
    ],
)
def test_what_makes_no_sense_is_one_line_and_status_1(run, tmp_path, monkeypatch, arguments, words):
    monkeypatch.chdir(tmp_path)
    answer = run("reproduce", "-o", "report.html", *arguments)
    assert (answer.status, len(answer.err.splitlines())) == (1, 1)
    assert words in answer.err
    assert not list(tmp_path.iterdir())


def test_without_an_output_it_is_not_understood(run):
    assert run("reproduce", "A").status == 2
