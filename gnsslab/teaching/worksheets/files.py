"""Worksheets as they come back: notebooks filled in by students, read without running anything."""

import ast
import json
import re
from dataclasses import dataclass
from pathlib import Path

from gnsslab.teaching.catalogue import find_lesson

LONGEST = 2000  # characters of a cell that is read; a longer one is more than a typed answer
_UNREADABLE = (SyntaxError, ValueError, RecursionError, MemoryError)  # what the parser of Python makes of other texts


@dataclass(frozen=True)
class Worksheet:
    """A notebook that came back: its lesson, the student's name, and its code cells; or the problem that there is."""

    file: str
    lesson: object = None  # Lesson, None where there is a problem
    student: str = ""
    cells: tuple[str, ...] = ()  # source of the code cells, in order
    asked: tuple[tuple[str, int], ...] = ()  # name of a question and the place of its cell among the code cells
    problem: str = ""


def read_worksheet(path):
    """Return the Worksheet of a file; what is no worksheet has a problem, in words."""
    try:
        notebook = json.loads(Path(path).read_text("utf-8-sig"))
        return _worksheet(str(path), notebook)
    except OSError as error:
        return Worksheet(str(path), problem=f"cannot be read: {error.strerror or error}")
    except (UnicodeDecodeError, json.JSONDecodeError, RecursionError):
        return Worksheet(str(path), problem="no notebook: its text is not JSON")
    except ValueError as refusal:
        return Worksheet(str(path), problem=str(refusal))


def typed_answer(source):
    """Return what was typed after "answer =", "" for a blank; None where the cell holds more than that and must be run.

    >>> typed_answer("# in deg\\nanswer = -3.5"), typed_answer("answer = 0,05"), typed_answer("answer = ...")
    ('-3.5', '0,05', '')
    >>> typed_answer("answer = 3 / 1.2") is None
    True
    """
    if len(source) > LONGEST:
        return None
    try:
        return _literal(source, ast.parse(source).body, "answer")
    except _UNREADABLE:  # like 12 deg or 0,05
        return _as_typed(source, "answer")


def assigns_answer(source):
    """Return whether a cell gives a value to the name `answer`; one that is not Python says so itself when it is run."""
    try:
        nodes = ast.walk(ast.parse(source))
    except _UNREADABLE:
        return True
    return any(isinstance(node, ast.Name) and node.id == "answer" and isinstance(node.ctx, ast.Store) for node in nodes)


def _worksheet(file, notebook):
    """Return the Worksheet of a notebook as read from JSON; raise ValueError where it is none."""
    if not isinstance(notebook, dict) or not isinstance(notebook.get("cells"), list):
        raise ValueError("no notebook: it has no list of cells (notebook format 4)")
    number = _about(notebook).get("worksheet")
    if number is None:
        raise ValueError("no worksheet: make one with `gnsslab worksheet`")
    cells = [cell for cell in notebook["cells"] if isinstance(cell, dict) and cell.get("cell_type") == "code"]
    sources = tuple(_source(cell) for cell in cells)
    asked = tuple((str(_about(cell)["question"]), place) for place, cell in enumerate(cells) if "question" in _about(cell))
    names = [_name(source) for cell, source in zip(cells, sources, strict=True) if _about(cell).get("student")]
    return Worksheet(file, find_lesson(str(number)), next(filter(None, names), ""), sources, asked)


def _about(thing):
    """Return what a notebook or a cell says of itself under "gnsslab"."""
    metadata = thing.get("metadata")
    about = metadata.get("gnsslab") if isinstance(metadata, dict) else None
    return about if isinstance(about, dict) else {}


def _source(cell):
    source = cell.get("source", "")
    return "".join(map(str, source)) if isinstance(source, list) else str(source)


def _name(source):
    """Return the name a student filled in, in one line, with or without quotes; "" where there is none to read."""
    try:
        name = _literal(source, ast.parse(source).body, "name")
    except _UNREADABLE:
        name = None
    name = _as_typed(source, "name") or "" if name is None else name
    return " ".join(name.split())[:LONGEST]


def _literal(source, body, name):
    """Return the text of the only statement `name = literal`, "" for a blank, None for any other code."""
    if len(body) != 1 or not isinstance(body[0], ast.Assign):
        return None
    target, value = body[0].targets[-1], body[0].value
    if not isinstance(target, ast.Name) or target.id != name or len(body[0].targets) > 1:
        return None
    if isinstance(value, ast.Constant) and (value.value is ... or value.value is None or isinstance(value.value, str)):
        return value.value if isinstance(value.value, str) else ""
    return ast.get_source_segment(source, value) if _is_number(value) else None


def _is_number(value):
    """Return whether an expression is a number, -number, or number,number: a decimal comma."""
    if isinstance(value, ast.Tuple):
        return len(value.elts) == 2 and all(map(_is_number, value.elts))
    if isinstance(value, ast.UnaryOp) and isinstance(value.op, (ast.USub, ast.UAdd)):
        value = value.operand
    return isinstance(value, ast.Constant) and isinstance(value.value, (int, float)) and not isinstance(value.value, bool)


def _as_typed(source, name):
    """Return what stands after "name =" in a cell with no other line, without comment; None where there are others."""
    lines = [line.strip() for line in source.splitlines() if line.strip() and not line.strip().startswith("#")]
    found = re.fullmatch(rf"{name}\s*=(.*)", lines[0]) if len(lines) == 1 else None
    return found[1].partition("#")[0].strip() if found else None
