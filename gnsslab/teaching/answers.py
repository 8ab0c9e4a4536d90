"""The instructor's key of a lesson: answers, tolerances, hints, solutions and usual mistakes."""

from dataclasses import asdict

from gnsslab.teaching.plain_text import wrapped

INDENT = "   "
MOST_WIDTH = 100  # columns: longer lines are hard to read


def key_lines(lesson, width):
    """Return the key of a lesson as lines of text for a terminal of `width` columns."""
    width = min(width, MOST_WIDTH)
    lines = [f"Lesson {lesson.number}: {lesson.title}", "", *_prediction_lines(lesson.exercises.PREDICTION, width)]
    for place, question in enumerate(lesson.exercises.QUESTIONS, 1):
        lines += ["", f"{place}. {question.name}", *_question_lines(question, width)]
    return lines


def key_record(lesson):
    """Return the key of a lesson as a dictionary that JSON can hold."""
    exercises = lesson.exercises
    return {
        "lesson": lesson.number,
        "title": lesson.title,
        "prediction": asdict(exercises.PREDICTION),
        "questions": [asdict(question) for question in exercises.QUESTIONS],
    }


def _prediction_lines(prediction, width):
    options = [f"{INDENT}{'*' if option == prediction.answer else '-'} {option}" for option in prediction.options]
    return ["Prediction (* turns out to be right)", *wrapped(prediction.text, width, INDENT), *options]


def _question_lines(question, width):
    turns = f", whole turns of {question.period:g} {question.unit} do not matter" if question.period else ""
    return [
        *wrapped(question.text, width, INDENT),
        *wrapped(f"Answer: {question.answer_text} (within {question.tolerance_text}{turns})", width, INDENT),
        f"{INDENT}Hints:",
        *(line for hint in question.hints for line in _item(hint, width)),
        f"{INDENT}Solution:",
        *wrapped(question.solution, width, 2 * INDENT),
        f"{INDENT}Usual mistakes:",
        *(line for mistake in question.mistakes for line in _item(f"{_with_unit(mistake.value, question)}: {mistake.words}", width)),
    ]


def _with_unit(value, question):
    return f"{value:.4g} {question.unit}".rstrip()


def _item(markdown, width):
    """Return a text as lines, the first with a dot before it."""
    first, *others = wrapped(markdown, width, 2 * INDENT + "  ")
    return [f"{2 * INDENT}• {first.strip()}", *others]
