"""The JupyterLab twin of a lesson: a notebook made from the lesson's marimo file, where the text stands once."""

import re

from nbformat import v4, validate, writes

from gnsslab.teaching.catalogue import find_lesson
from gnsslab.teaching.steps import steps_of

COURSE_LINK = re.compile(r"(?<!!)\[([^\]]+)\]\((/[^)]*)\)")  # Markdown link to an address of the course's server
LESSON_ADDRESS = re.compile(r"/lesson/(\d\d)/?(?:[?#].*)?")
NOT_FOR_JUPYTER = re.compile(r"^[ ]*///|::[a-z]+:[a-z-]+::|<marimo-|<style|<script|(?:href|src)=[\"']?/|\]\(/", re.MULTILINE)


def twin(lesson):
    """Return the lesson's notebook, always the same for the same lesson: no outputs, no counts, cells named by their place.

    Raises ValueError with the text of a marimo cell or the markup that a notebook has nothing for.
    """
    return notebook([head_of(lesson), *map(cell_of, steps_of(lesson.path.read_text("utf-8")))], {"lesson": lesson.number})


def twin_name(lesson):
    """Return the name of the lesson's notebook file.

    >>> twin_name(find_lesson(0))
    '00_which_way_is_north.ipynb'
    """
    return lesson.file.removesuffix(".py") + ".ipynb"


def notebook(cells, about):
    """Return a valid notebook of the cells; `about` stands under "gnsslab" in its metadata."""
    for place, cell in enumerate(cells):
        cell["id"] = f"cell-{place:02d}"
    kernel = {"display_name": "Python 3 (ipykernel)", "language": "python", "name": "python3"}
    made = v4.new_notebook(cells=cells, metadata={"gnsslab": about, "kernelspec": kernel, "language_info": {"name": "python"}})
    validate(made)
    return made


def as_text(made):
    """Return a notebook as the text of its file."""
    return writes(made).rstrip("\n") + "\n"


def head_of(lesson):
    """Return the first cell: title, time, what the lesson needs and gives, and how to start."""
    gives = "\n".join(f"* {text}" for text in lesson.gives)
    return v4.new_markdown_cell(
        f"# {lesson.title}\n\nLesson {lesson.number} · about {lesson.minutes} minutes · needs {lesson.needs}\n\n"
        f"**Afterwards you can**\n\n{gives}\n\n"
        "*To start, choose **Run All Cells** in the menu **Run**, then scroll back up. "
        "For notation, data and glossary, type `gnsslab course` in a terminal.*"
    )


def cell_of(step):
    """Return the notebook cell of one step of a lesson."""
    return _CELLS[step.kind](step)


def for_jupyter(text):
    """Return Markdown of a marimo cell as JupyterLab shows it.

    Links to lessons lead to their notebooks; a link to another page of the course, which stands in no notebook, becomes
    its text. Raises ValueError for markup that JupyterLab does not show.

    >>> for_jupyter("See [lesson 00](/lesson/00/) and the [notation](/notation#psi).")
    'See [lesson 00](00_which_way_is_north.ipynb) and the notation.'
    """
    text = COURSE_LINK.sub(_link, text)
    if foreign := NOT_FOR_JUPYTER.search(text):
        line = text[text.rfind("\n", 0, foreign.start()) + 1 :].split("\n")[0]
        raise ValueError(f"JupyterLab does not show the markup {foreign[0].strip()!r} in: {line}")
    return text


def _link(match):
    text, address = match.groups()
    lesson = LESSON_ADDRESS.fullmatch(address)
    return f"[{text}]({twin_name(find_lesson(lesson[1]))})" if lesson else text


def _folded(text):
    """Return Markdown that opens at a click, its heading in sight; the blank lines make JupyterLab read the inside as Markdown."""
    heading, text = text.split("\n", 1) if text.startswith("#") else ("", text)
    return f"{heading}\n\n<details><summary>After your prediction</summary>\n\n{text.strip()}\n\n</details>".strip()


def _opening(step):
    return v4.new_code_cell(f'from gnsslab.teaching.jupyter.front import open_lesson\n\nlesson = open_lesson("{step.name}")')


_CELLS = {
    "opening": _opening,
    "text": lambda step: v4.new_markdown_cell(for_jupyter(step.text)),
    "later text": lambda step: v4.new_markdown_cell(_folded(for_jupyter(step.text))),
    "prediction": lambda step: v4.new_code_cell("lesson.predict()"),
    "lab": lambda step: v4.new_code_cell(f'{step.variable} = lesson.lab("{step.name}")\n{step.variable}'),
    "goal": lambda step: v4.new_code_cell(f'{step.variable}.goal("{step.name}")'),
    "question": lambda step: v4.new_code_cell(f'lesson.question("{step.name}")'),
}
