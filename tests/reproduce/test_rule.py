"""The rule of all verdicts: what it says of made-up numbers, and what it must never do."""

import json
from math import inf

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from gnsslab.reproduce.rule import DOES_NOT_HOLD, HOLDS, NEAR, NOT_REPRODUCED, NOT_STATED, REPRODUCED, RULE, Item, judged, measured, verdict

RANKS = {REPRODUCED: 0, NEAR: 1, NOT_REPRODUCED: 2}
values_ = st.lists(st.floats(-100, 100).map(lambda x: round(x, 3)), min_size=1, max_size=9).map(np.array)
number_ = st.floats(-100, 100).map(lambda x: round(x, 3))


@pytest.mark.parametrize(
    ("paper", "ours", "words"),
    [
        (1.0, [1.25], REPRODUCED),
        (1.0, [1.26], NEAR),
        (1.0, [0.75], REPRODUCED),
        (1.0, [0.74], NEAR),
        (1.0, [2.0], NEAR),
        (1.0, [2.01], NOT_REPRODUCED),
        (1.0, [0.49], NOT_REPRODUCED),
        (1.0, [-1.0], NOT_REPRODUCED),
        (-4.0, [-3.1], REPRODUCED),
        (-4.0, [-2.1], NEAR),
        (0.0, [0.0], REPRODUCED),
        (0.0, [0.001], NOT_REPRODUCED),
        (0.0, [-1.0, 2.0, 3.0, 1.0], NOT_REPRODUCED),  # the middle half is 0.5 to 2.25
        (0.0, [-1.0, -0.5, 3.0, 1.0], REPRODUCED),
        ((2.0, 3.0), [3.7], REPRODUCED),
        ((2.0, 3.0), [1.4], NEAR),
        ((2.0, 3.0), [0.9], NOT_REPRODUCED),
        ((3.0, inf), [1e9], REPRODUCED),
        ((3.0, inf), [2.0], NEAR),
        (1.0, [], NOT_REPRODUCED),
    ],
)
def test_what_the_rule_says(paper, ours, words):
    assert verdict(paper, np.array(ours)) == words


@given(number_, values_, st.sampled_from([0.01, 0.5, 3.0, 1000.0]))
def test_another_unit_changes_nothing(paper, ours, scale):
    edges = np.abs(paper) * np.array([0.5, 0.75, 1.25, 2.0])
    median = np.median(ours)
    assume(np.min(np.abs(edges - abs(median))) > 1e-6)  # on an edge rounding decides
    assume(np.min(np.abs(np.percentile(ours, [25, 75]) - paper)) > 1e-6)
    assert verdict(scale * paper, scale * ours) == verdict(paper, ours)
    assert verdict(-paper, -ours) == verdict(paper, ours)


@given(number_.filter(lambda x: abs(x) > 0.01), st.floats(0, 3), st.floats(0, 3))
def test_what_is_nearer_is_never_judged_worse(paper, a, b):
    nearer, farther = sorted([a, b])
    for side in (1, -1):
        ranks = [RANKS[verdict(paper, np.array([paper * (1 + side * off)]))] for off in (nearer, farther)]
        assert ranks[0] <= ranks[1]


@given(st.floats(1, 10), values_)
def test_a_claim_holds_by_the_median_alone(paper, ours):
    holds = verdict(paper, ours, is_claim=True) == HOLDS
    assert holds == (0.75 * paper <= np.median(ours) <= 1.25 * paper)


def test_a_claim_without_numbers_does_not_hold():
    assert verdict(1.0, np.array([]), is_claim=True) == DOES_NOT_HOLD


def test_a_line_says_what_it_was_judged_by():
    item = Item("Fig. 1", "error", "deg", (2.0, inf), "abstract", "key", "too good")
    line = judged("A", item, np.array([1.0, np.nan, 2.0, 0.5]))
    assert json.loads(json.dumps(line, allow_nan=False)) == line
    assert (line["paper_value"], line["seeds"], line["ours_median"]) == ([2.0, None], 3, 1.0)
    assert line["ours_mean"] == pytest.approx(3.5 / 3)
    assert line["ours_sd"] == pytest.approx(np.sqrt(((1 - 3.5 / 3) ** 2 + (2 - 3.5 / 3) ** 2 + (0.5 - 3.5 / 3) ** 2) / 2))
    assert (line["verdict"], line["cause"]) == (NEAR, "too good")
    assert judged("A", item, np.array([2.0]))["cause"] == ""


def test_the_rule_is_told_with_its_numbers():
    assert "25 %" in RULE
    assert "factor of 2" in RULE


def test_what_never_came_is_later_than_all_that_did():
    line = measured("B", "joint", "lag", "epochs", [4.0, np.nan, 2.0, np.nan, 3.0])
    assert (line["ours_median"], line["ours_quartiles"], line["verdict"]) == (4.0, [3.0, None], NOT_STATED)
    assert (line["ours_mean"], line["seeds"]) == (3.0, 5)
    assert set(line) == set(judged("B", Item("joint", "lag", "epochs", 1.0, "s", "k"), [1.0]))
    never = measured("B", "joint", "lag", "epochs", [1.0, np.nan, np.nan])
    assert (never["ours_median"], never["ours_mean"]) == (None, 1.0)
    json.dumps(never, allow_nan=False)
