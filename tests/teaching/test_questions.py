"""Questions: records that refuse nonsense, and a judge that helps without giving the answer away."""

import re
from dataclasses import replace

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from gnsslab.teaching.questions import Prediction, Question, UsualMistake, judge

BEAM = Question(
    name="scatter",
    text="How far does it scatter?",
    answer=0.143,
    tolerance=0.005,
    unit="deg",
    hints=("Divide.", "Convert."),
    solution="Divide and convert.",
    mistakes=(UsualMistake(0.0025, "That is in radians."), UsualMistake(0.286, "Twice too much.")),
)
TURN = replace(BEAM, answer=120.0, tolerance=1.0, period=360.0, mistakes=(UsualMistake(-60.0, "Look at both signs."),))
CLIMB = replace(BEAM, answer=-3.0, tolerance=0.1, unit="m", mistakes=())
PREDICTION = Prediction("how-well", "How well?", ("badly", "well"), "well")


@pytest.mark.parametrize("typed", ["0.143", "0,14", "0.148 deg", "0.138°", "1.43e-1"])
def test_right_within_the_tolerance(typed):
    verdict = judge(BEAM, typed)
    assert (verdict.is_number, verdict.is_right, verdict.words) == (True, True, "Right: 0.143 deg.")


@pytest.mark.parametrize("typed", ["120", "480.0 deg", "-240", "120.9"])
def test_whole_turns_are_the_same(typed):
    assert judge(TURN, typed).is_right
    assert not judge(replace(TURN, period=0.0), "480").is_right


@pytest.mark.parametrize(
    ("question", "typed", "words"),
    [
        (BEAM, "0.0025", "Not yet. That is in radians."),
        (BEAM, "0.284", "Not yet. Twice too much."),
        (BEAM, "0.006", "Not yet. That is in radians."),  # within the tolerance of the mistake
        (BEAM, "0.27", "Not yet. It is too large."),
        (BEAM, "0.1", "Not yet. It is too small."),
        (BEAM, "-0.143", "Not yet. The sign is the other way."),
        (CLIMB, "3", "Not yet. The sign is the other way."),
        (CLIMB, "-4", "Not yet. The sign is right, but it is too far from zero."),
        (CLIMB, "-2", "Not yet. It is too near to zero."),
        (CLIMB, "0", "Not yet. It is too near to zero."),
        (TURN, "300", "Not yet. Look at both signs."),
        (TURN, "-120", "Not yet. The sign is the other way."),
        (replace(TURN, mistakes=()), "300", "Not yet. It points just the other way."),
        (TURN, "130", "Not yet. It is too far round: turn back."),
        (TURN, "470", "Not yet. It is not far enough round: turn on."),
        (replace(TURN, answer=350.0, mistakes=()), "20", "Not yet. It is too far round: turn back."),
    ],
)
def test_wrong_answers_get_words_that_help(question, typed, words):
    verdict = judge(question, typed)
    assert (verdict.is_number, verdict.is_right, verdict.words) == (True, False, words)


@pytest.mark.parametrize(
    ("typed", "words"),
    [
        ("", "Nothing is typed yet: type a number."),
        ("nan", '"nan" is not understood: type one number, such as 12.5 or 1.25e-3.'),
        ("0.0025 rad", 'The answer is asked in deg, not in "rad": type it in deg.'),
    ],
)
def test_what_cannot_be_judged_is_no_try(typed, words):
    verdict = judge(BEAM, typed)
    assert (verdict.is_number, verdict.is_right, verdict.words) == (False, False, words)


@given(answer=st.floats(-1e6, 1e6), tolerance=st.floats(1e-6, 1e3), share=st.floats(-1, 1))
def test_the_tolerance_is_the_border(answer, tolerance, share):
    assume(tolerance > 1e-9 * abs(answer))
    question = replace(BEAM, answer=answer, tolerance=tolerance, mistakes=())
    assert judge(question, repr(answer + share * tolerance)).is_right
    for wrong in (answer + 1.001 * tolerance, answer - 1.001 * tolerance):
        assert not judge(question, repr(wrong)).is_right


@given(answer=st.floats(-180, 180), turns=st.integers(-5, 5))
def test_no_number_of_turns_matters(answer, turns):
    question = replace(TURN, answer=answer, mistakes=())
    assert judge(question, repr(answer + 360.0 * turns)).is_right
    assert not judge(question, repr(answer + 360.0 * turns + 2.0)).is_right


@given(answer=st.floats(-1e6, 1e6), tolerance=st.floats(1e-6, 1e3))
def test_the_answer_as_shown_is_right(answer, tolerance):
    """A student who types what the key shows is right."""
    question = replace(BEAM, answer=answer, tolerance=tolerance, mistakes=())
    assert judge(question, question.answer_text).is_right


@given(st.floats(-1e3, 1e3))
def test_a_wrong_answer_is_never_told_the_right_one(value):
    verdict = judge(BEAM, repr(value))
    assert verdict.is_right or "0.14" not in verdict.words


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"name": "Heading of a beam"}, "a question is named like heading-of-a-beam"),
        ({"text": " "}, "question scatter needs a text and a solution"),
        ({"solution": ""}, "question scatter needs a text and a solution"),
        ({"hints": ("one",)}, "question scatter needs two hints"),
        ({"hints": ("one", " ")}, "question scatter needs two hints, neither empty"),
        ({"answer": float("nan")}, "the answer is a finite number, not nan"),
        ({"tolerance": 0.0}, "the tolerance is a number above zero, not 0.0"),
        ({"tolerance": float("inf")}, "the tolerance is a number above zero, not inf"),
        ({"period": -1.0}, "the period is zero or a number above it"),
        ({"mistakes": (UsualMistake(0.147, "near"),)}, "the usual mistake 0.147 lies within the tolerance of the answer"),
        ({"mistakes": (UsualMistake(360.143, "a turn"),), "period": 360.0}, "lies within the tolerance of the answer"),
    ],
)
def test_questions_without_sense_are_refused(changes, words):
    with pytest.raises(ValueError, match=re.escape(words)):
        replace(BEAM, **changes)


@pytest.mark.parametrize(("value", "words"), [(float("inf"), "is a finite number, not inf"), (1.0, "the usual mistake 1 has no words")])
def test_mistakes_without_sense_are_refused(value, words):
    with pytest.raises(ValueError, match=words):
        UsualMistake(value, " ")


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"name": ""}, "a prediction is named like"),
        ({"text": ""}, "prediction how-well has no text"),
        ({"options": ("well",)}, "needs two options or more"),
        ({"options": ("well", "well")}, "each once"),
        ({"answer": "perhaps"}, "its answer is none of its options"),
    ],
)
def test_predictions_without_sense_are_refused(changes, words):
    with pytest.raises(ValueError, match=words):
        replace(PREDICTION, **changes)
