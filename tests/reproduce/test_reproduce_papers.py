"""Letters of papers, and the report as a page that stands alone."""

import json
import re

import numpy as np
import pytest

from gnsslab.reproduce.papers import MODULES, PAPERS, Column, Picture, Reproduction, Table, checked_letters, usual_seeds
from gnsslab.reproduce.report import report_html, report_json, tally
from gnsslab.reproduce.rule import RULE, Item, judged


def test_letters_are_taken_once_and_in_any_case():
    assert checked_letters(["a", "A"]) == ("A",)
    assert checked_letters([]) == tuple(MODULES)
    assert set(MODULES) <= set(PAPERS)


@pytest.mark.parametrize(("letter", "words"), [("X", "there is no paper 'X'"), ("AB", "there is no paper 'AB'"), ("", "there is no paper ''")])
def test_what_is_no_paper_is_refused(letter, words):
    with pytest.raises(ValueError, match=words):
        checked_letters([letter])


def test_a_paper_that_cannot_be_reproduced_yet_is_said_so():
    missing = [letter for letter in PAPERS if letter not in MODULES]
    for letter in missing:
        with pytest.raises(ValueError, match=f"paper {letter} cannot be reproduced yet: there is A, B"):
            checked_letters([letter])
    assert missing, "all papers are there: then this test has nothing to check"


@pytest.fixture
def reproduction():
    lines = [judged("A", Item("Fig. 1 <&>", "error", "deg", (2.0, 3.0), "abstract", "k", "too good"), [0.5, 0.6]),
             judged("A", Item("Fig. 2", "error", "m", 1.0, "section 4", "k"), [])]  # fmt: skip
    return Reproduction("A", "A paper", lines, (Picture("Figure 1", 'a "dot"', b"\x89PNG"),), ("a note",))


def test_the_page_needs_nothing_from_elsewhere(reproduction):
    page = report_html([reproduction], "gnsslab reproduce A")
    assert "<script" not in page
    assert re.findall(r'(?:src|href)="(.{10})', page) == ["data:image"]
    assert "http" not in page
    assert "Fig. 1 &lt;&amp;&gt;" in page
    assert 'alt="Figure 1. a &quot;dot&quot;"' in page
    for words in (RULE.split(":")[0], "2 to 3 deg", "0.55 ± 0.0707", "not reproduced", "too good", "a note", "prefers-color-scheme: dark"):
        assert words in page


def test_the_numbers_are_the_lines_as_json(reproduction):
    assert json.loads(report_json([reproduction, reproduction])) == 2 * reproduction.lines


def test_verdicts_are_counted(reproduction):
    assert tally(reproduction.lines) == "2 not reproduced"


def test_tables_of_ours_stand_in_the_page_and_in_the_numbers(reproduction):
    columns = (Column("lag", "epochs"), Column("missed", "%", is_share=True))
    table = Table("At <rest>", "How & why.", columns, {"joint": (np.array([3.0, 5.0, np.nan]), np.array([0.0, 0.0, 100.0]))})
    one = reproduction._replace(tables=(table,))
    page = report_html([one], "gnsslab reproduce A")
    for words in ("At &lt;rest&gt;", "How &amp; why.", "lag [epochs]", ">5<small>4 ± 1.41</small>", ">33.3</td>"):
        assert words in page
    lag, missed = json.loads(report_json([one]))[len(one.lines) :]
    assert (lag["item"], lag["quantity"], lag["ours_median"], lag["paper_value"]) == ("At <rest>: joint", "lag", 5.0, None)
    assert missed["ours_mean"] == pytest.approx(100 / 3)


def test_each_paper_has_its_usual_number_of_seeds():
    assert [usual_seeds(letter) for letter in MODULES] == [20, 30]
