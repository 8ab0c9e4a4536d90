"""Markdown and formulas as plain text."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gnsslab.teaching.catalogue import LESSONS
from gnsslab.teaching.plain_text import plain, wrapped

TEXTS = [text for lesson in LESSONS for question in lesson.exercises.QUESTIONS for text in (question.text, *question.hints, question.solution)]


@pytest.mark.parametrize(
    ("markdown", "text"),
    [
        ("a **bold** and an *oblique* word, `code`", "a bold and an oblique word, code"),
        ("2 * 3 * 4", "2 * 3 * 4"),
        ("[home](/)", "home"),
        (r"$\psi = \operatorname{atan2}(e,\ n)$", "\u03c8 = atan2(e, n)"),
        (r"$\sqrt{\cos^2\!\psi\,\sigma_e^2 + 1}$", "√(cos²\u03c8 \u03c3_e² + 1)"),
        (r"$\frac{a}{b}$", "(a)/(b)"),
        (r"$\tfrac12 + x$", "1/2 + x"),
        (r"$\frac{\sqrt{a^2}}{b_{12}}$", "(√(a²))/(b_12)"),
        (r"$10^{-3}\ \text{m}$", "10⁻³ m"),
        (r"$e^{x+y}$", "e^(x+y)"),
        (r"$x^2+y^2$", "x²+y²"),
        (r"$Q = L^T D L$", "Q = Lᵀ D L"),
        (r"$$\hat{a} \cdot b \le c$$", "a · b ≤ c"),
        ("costs 5 $", "costs 5 $"),
    ],
)
def test_marks_and_commands_go(markdown, text):
    assert plain(markdown) == text


def test_texts_of_the_course_leave_no_command_behind():
    assert TEXTS
    for text in TEXTS:
        assert not set(plain(text)) & set("\\{}$"), text


@given(st.text())
def test_any_text_is_taken(text):
    assert isinstance(plain(text), str)


def test_lines_fit_and_paragraphs_stay_apart():
    lines = wrapped("one two three four\n\nfive six", 10, "  ")
    assert lines == ["  one two", "  three", "  four", "  five six"]
