"""Questions as data: what is asked, what is right, which wrong answers are usual, and what to say of them."""

import math
import re
from dataclasses import dataclass

from gnsslab.teaching.typed_numbers import read_number

NEAR_MISTAKE = 0.02  # a usual mistake is recognised within 2 % of its value, however roughly it was worked out
EDGE = 1e-9  # of the tolerance: an answer that misses by just the tolerance, but for rounding, is right
_NAME = re.compile(r"[a-z0-9]+(-[a-z0-9]+)*")


@dataclass(frozen=True)
class UsualMistake:
    """A wrong answer that many give, and the sentence that shows where it comes from."""

    value: float  # in the question's unit
    words: str

    def __post_init__(self):
        _check(math.isfinite(self.value), f"the value of a usual mistake is a finite number, not {self.value}")
        _check(self.words.strip(), f"the usual mistake {self.value:g} has no words")


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

    def __post_init__(self):
        _check_name("question", self.name)
        _check(self.text.strip() and self.solution.strip(), f"question {self.name} needs a text and a solution")
        _check(len(self.hints) == 2 and all(hint.strip() for hint in self.hints), f"question {self.name} needs two hints, neither empty")
        _check(math.isfinite(self.answer), f"question {self.name}: the answer is a finite number, not {self.answer}")
        _check(0 < self.tolerance < math.inf, f"question {self.name}: the tolerance is a number above zero, not {self.tolerance}")
        _check(0 <= self.period < math.inf, f"question {self.name}: the period is zero or a number above it, not {self.period}")
        for mistake in self.mistakes:
            is_apart = abs(self.offset(mistake.value)) > self.tolerance
            _check(is_apart, f"question {self.name}: the usual mistake {mistake.value:g} lies within the tolerance of the answer")

    def offset(self, value, of=None):
        """Return how far a value lies from the answer, or from the value `of`, by the shorter way round where there is a period."""
        offset = value - (self.answer if of is None else of)
        return math.remainder(offset, self.period) if self.period else offset

    @property
    def answer_text(self):
        """The answer with its unit, in as many decimals as its tolerance deserves."""
        return f"{_rounded(self.answer, self.tolerance)} {self.unit}".rstrip()

    @property
    def tolerance_text(self):
        """The tolerance with its unit."""
        return f"{self.tolerance:g} {self.unit}".rstrip()


@dataclass(frozen=True)
class Prediction:
    """What the student commits to before the lab opens."""

    name: str
    text: str
    options: tuple[str, ...]
    answer: str  # the option that turns out to be right

    def __post_init__(self):
        _check_name("prediction", self.name)
        _check(self.text.strip(), f"prediction {self.name} has no text")
        _check(len(set(self.options)) == len(self.options) > 1, f"prediction {self.name} needs two options or more, each once")
        _check(self.answer in self.options, f"prediction {self.name}: its answer is none of its options")


@dataclass(frozen=True)
class Verdict:
    """What to say to an answer."""

    is_number: bool  # False: nothing that can be judged was given; it does not count as a try
    is_right: bool
    words: str


def judge(question, text):
    """Return the Verdict on an answer as it was typed.

    Right within the tolerance. A wrong answer near a usual mistake gets that mistake's words; any other gets a direction,
    never the answer. What is no number, or in another unit, gets a sentence and does not count.
    """
    try:
        value = read_number(text, question.unit)
    except ValueError as refusal:
        return Verdict(False, False, f"{_capitalized(str(refusal))}.")
    if abs(question.offset(value)) <= question.tolerance * (1 + EDGE):
        return Verdict(True, True, f"Right: {question.answer_text}.")
    mistake = _mistake_near(question, value)
    return Verdict(True, False, f"Not yet. {mistake.words if mistake else _direction(question, value)}")


def _mistake_near(question, value):
    """Return the usual mistake nearest to the value, None where none is near enough."""

    def distance(mistake):
        return abs(question.offset(value, of=mistake.value))

    near = [m for m in question.mistakes if distance(m) <= max(NEAR_MISTAKE * abs(m.value), question.tolerance)]
    return min(near, key=distance, default=None)


def _direction(question, value):
    """Say on which side of the answer a wrong value lies."""
    if question.period:
        return _direction_round(question, value)
    if value * question.answer < 0:
        return "The sign is the other way."
    if question.answer < 0:
        return "The sign is right, but it is too far from zero." if value < question.answer else "It is too near to zero."
    return "It is too large." if value > question.answer else "It is too small."


def _direction_round(question, value):
    if abs(question.offset(-value)) <= question.tolerance:
        return "The sign is the other way."
    if abs(question.offset(value + question.period / 2)) <= question.tolerance:
        return "It points just the other way."
    return "It is too far round: turn back." if question.offset(value) > 0 else "It is not far enough round: turn on."


def _rounded(value, tolerance):
    """Return a number in as many decimals as its tolerance deserves.

    >>> _rounded(0.14324, 0.005), _rounded(119.745, 0.5), _rounded(12_345.6, 20)
    ('0.143', '119.7', '12346')
    """
    decimals = max(0, -math.floor(math.log10(tolerance)))
    return f"{round(value, decimals) + 0.0:.{decimals}f}"


def _capitalized(sentence):
    return sentence[:1].upper() + sentence[1:]


def _check_name(kind, name):
    _check(_NAME.fullmatch(name), f"a {kind} is named like heading-of-a-beam, in small letters, digits and hyphens, not {name!r}")


def _check(is_well, words):
    if not is_well:
        raise ValueError(words)
