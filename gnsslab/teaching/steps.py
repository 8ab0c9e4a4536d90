"""What a lesson consists of, read from the cells of its marimo file: text, prediction, labs, goals, questions.

Each statement of a cell is looked up by what it calls (`mo.md`, `lesson.ask`, `north.goal`). What stands in no table is
refused, so that no part of a lesson is lost unseen.
"""

import ast
from inspect import cleandoc
from typing import NamedTuple


class Step(NamedTuple):
    """One part of a lesson, in the order of the lesson."""

    kind: str  # "opening", "text", "later text" (waits for the prediction), "prediction", "lab", "goal" or "question"
    name: str = ""  # number of the lesson; name of the lab, goal or question
    variable: str = ""  # what the lesson calls the lab
    text: str = ""  # Markdown


class Call(NamedTuple):
    """One statement of a cell: `target = owner.verb(arguments)`."""

    target: str
    owner: str
    verb: str
    arguments: tuple[str | None, ...]  # text as it stands there; None for anything computed


def steps_of(source):
    """Return the steps of a marimo file's text; raise ValueError with the text of a cell that is not understood."""
    labs = set()  # variables that hold a lab
    return [step for cell in _cells(ast.parse(source)) for step in _steps_of_cell(cell, labs)]


def _cells(tree):
    """Return the functions of a marimo file that are its cells."""
    return [node for node in tree.body if isinstance(node, ast.FunctionDef) and any("app.cell" in ast.unparse(d) for d in node.decorator_list)]


def _steps_of_cell(cell, labs):
    try:
        found = [_step_of(statement, labs) for statement in cell.body if not _says_nothing(statement)]
    except ValueError as reason:
        text = "\n".join(map(ast.unparse, cell.body))
        raise ValueError(f"a notebook has nothing for this cell ({reason}):\n{text}") from None
    return [step for step in found if step is not None]


def _says_nothing(statement):
    """Return whether a statement only imports, returns, or shows a variable that another statement made."""
    is_name = isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Name)
    return is_name or isinstance(statement, (ast.Return, ast.Import, ast.ImportFrom))


def _step_of(statement, labs):
    """Return the step of a statement, None where a notebook needs none for it."""
    call = _call_of(statement)
    owner = "LAB" if call.owner in labs else call.owner
    if (owner, call.verb) not in _MEANING:
        raise ValueError(f"unknown call of {call.verb}")
    step = _MEANING[owner, call.verb](call)
    if step is not None and step.kind == "lab":
        labs.add(step.variable)
    return step


def _call_of(statement):
    value = getattr(statement, "value", None)
    if not isinstance(value, ast.Call) or value.keywords:
        raise ValueError(f"no plain call: {ast.unparse(statement)}")
    target = ast.unparse(statement.targets[0]) if isinstance(statement, ast.Assign) else ""
    owner, _, verb = ast.unparse(value.func).rpartition(".")
    return Call(target, owner, verb, tuple(argument.value if _is_text(argument) else None for argument in value.args))


def _is_text(argument):
    return isinstance(argument, ast.Constant) and isinstance(argument.value, str)


def _text_of(call, place=0):
    """Return an argument of a call that has to be text as it stands."""
    if len(call.arguments) <= place or call.arguments[place] is None:
        raise ValueError(f"{call.verb} of something computed, where plain text is expected")
    return call.arguments[place]


def _nothing(call):
    return None


def _named(kind):
    return lambda call: Step(kind, name=_text_of(call), variable=call.owner)


_OF_A_LAB = ("presets", "preset_row", "steering", "controls", "panel", "run", "view", "saving", "saving_row", "link")  # one object in a notebook
_MEANING = {
    ("", "open_lesson"): lambda call: Step("opening", name=_text_of(call)),
    ("mo", "md"): lambda call: Step("text", text=cleandoc(_text_of(call))),
    ("mo", "state"): _nothing,
    ("lesson", "head"): _nothing,  # a notebook has a head of its own
    ("lesson", "prediction"): lambda call: Step("prediction"),
    ("lesson", "predicted"): _nothing,
    ("lesson", "wait"): _nothing,
    ("lesson", "text"): lambda call: Step("later text", text=cleandoc(_text_of(call, 1))),
    ("lesson", "lab"): lambda call: Step("lab", name=_text_of(call), variable=call.target),
    ("lesson", "ask"): _nothing,
    ("lesson", "sheet"): _named("question"),
    ("lesson", "check"): _nothing,
    ("LAB", "goal"): _named("goal"),
} | {("LAB", part): _nothing for part in _OF_A_LAB}
