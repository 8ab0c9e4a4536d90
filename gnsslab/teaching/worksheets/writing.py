"""Worksheets: the notebook of a lesson whose questions are blanks to fill in, without hints, solutions and verdicts."""

from nbformat import v4

from gnsslab import __version__
from gnsslab.teaching.jupyter.notebooks import cell_of, for_jupyter, head_of, notebook
from gnsslab.teaching.steps import steps_of

QUESTIONS = "## Check yourself"  # the heading that all lessons give their questions
HOW_TO = "**This is a worksheet.** Write your name between the quotation marks below, answer under *Check yourself*, save, and hand in the file."
HOW_TO_ANSWER = "Put a number in the place of the three dots, like `answer = 12.5`, or let Python work it out. Mind the unit."


def worksheet(lesson):
    """Return the notebook to fill in; its metadata say to the grader what each blank is."""
    cells = [head_of(lesson), v4.new_markdown_cell(HOW_TO), _blank('name = ""', student=True)]
    for step in steps_of(lesson.path.read_text("utf-8")):
        cells += _asked(lesson, step.name) if step.kind == "question" else [cell_of(_without_hints(step))]
    return notebook(cells, {"worksheet": lesson.number, "version": __version__})


def _without_hints(step):
    """Return a step as a worksheet has it: how to answer is another matter there, and nothing helps."""
    return step._replace(text=f"{QUESTIONS}\n\n{HOW_TO_ANSWER}") if step.text.startswith(QUESTIONS) else step


def _asked(lesson, name):
    """Return the cells of one question: its text, and the blank for the answer."""
    question = next(question for question in lesson.exercises.QUESTIONS if question.name == name)
    unit = f"in {question.unit}" if question.unit else "(a number without unit)"
    return [v4.new_markdown_cell(for_jupyter(question.text)), _blank(f"# answer {unit}\nanswer = ...", question=name)]


def _blank(source, **about):
    return v4.new_code_cell(source, metadata={"gnsslab": about})
