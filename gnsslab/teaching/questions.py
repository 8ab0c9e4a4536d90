"""Questions as data: what is asked, what is right, which wrong answers are usual, and what to say of them."""

from dataclasses import dataclass


@dataclass(frozen=True)
class UsualMistake:
    """A wrong answer that many give, and the sentence that shows where it comes from."""

    value: float  # in the question's unit
    words: str


@dataclass(frozen=True)
class Question:
    """A question whose answer is a number. Texts are Markdown with $...$ for formulas."""

    name: str  # "heading-of-a-beam", the same in progress, worksheets and marks
    text: str
    answer: float
    tolerance: float  # in the unit
    unit: str  # "" for a pure number
    hints: tuple[str, str]
    solution: str
    mistakes: tuple[UsualMistake, ...] = ()
    period: float = 0.0  # 360 for an angle in degrees: answers that differ by whole turns are the same


@dataclass(frozen=True)
class Prediction:
    """What the student commits to before the lab opens."""

    name: str
    text: str
    options: tuple[str, ...]
    answer: str  # the option that turns out to be right


@dataclass(frozen=True)
class Verdict:
    """What to say to an answer."""

    is_number: bool  # False: nothing that can be judged was given; it does not count as a try
    is_right: bool
    words: str
