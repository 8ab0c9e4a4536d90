"""A lesson's steps, read from its marimo file: all of them in order, and nothing passed over."""

import pytest
from small_lesson import LAB, OPENING, WHOLE, cell

from gnsslab.teaching.catalogue import LESSONS
from gnsslab.teaching.steps import Step, steps_of


def test_every_kind_of_step_is_read_in_order():
    assert steps_of(WHOLE) == [
        Step("opening", name="00"),
        Step("text", text="## The scene\n\nHeading is $\\psi$, see the [notation](/notation#psi)."),
        Step("prediction"),
        Step("lab", name="north", variable="north"),
        Step("later text", text="## Play\n\nBlue is *fixed*."),
        Step("goal", name="sharp", variable="north"),
        Step("question", name="heading-of-a-beam", variable="lesson"),
    ]


def test_labs_go_by_the_variable_that_the_lesson_gives_them():
    second = LAB.replace('north = lesson.lab("north")', 'sky = lesson.lab("sky")').replace("north.", "sky.")
    labs = [step for step in steps_of(OPENING + LAB + second) if step.kind == "lab"]
    assert [(lab.variable, lab.name) for lab in labs] == [("north", "north"), ("sky", "sky")]


@pytest.mark.parametrize(
    "body",
    [
        'mo.callout("Mind this")',
        "lesson.dance()",
        "north.dance()",  # no lab of that name was opened
        "mo.md(f'{lesson}')",
        "mo.md(words)",
        "x = 3",
        "print('hello')",
        "lesson.text(prediction, words)",
        "lesson.sheet(name, beam)",
        "assert lesson",
        "mo.md(text='by keyword')",
    ],
)
def test_a_cell_that_is_not_understood_is_refused_with_its_text(body):
    with pytest.raises(ValueError, match="a notebook has nothing for this cell") as refusal:
        steps_of(cell(body))
    assert body.split("(")[0] in str(refusal.value)


def test_functions_that_are_no_cells_are_left_alone():
    assert steps_of("def helper():\n    print('not shown')\n") == []


def test_every_lesson_is_understood_and_has_what_a_lesson_has():
    assert LESSONS
    for lesson in LESSONS:
        steps = steps_of(lesson.path.read_text("utf-8"))
        assert {"opening", "text", "prediction", "lab", "goal", "question"} <= {step.kind for step in steps}, lesson.number
        assert [step.name for step in steps if step.kind == "opening"] == [lesson.number]
        assert {step.name for step in steps if step.kind == "lab"} <= set(lesson.open_labs())
        assert [step.name for step in steps if step.kind == "question"] == [question.name for question in lesson.exercises.QUESTIONS]
