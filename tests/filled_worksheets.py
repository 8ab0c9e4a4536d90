"""Worksheets filled in, as JSON: what students hand in."""

import json

from gnsslab.teaching.catalogue import find_lesson

QUESTIONS = find_lesson("00").exercises.QUESTIONS
NAMES = [question.name for question in QUESTIONS]


def filled(answers=None, student='name = "Ann Lee"', before=(), lesson="00"):
    """Return a notebook: the source of each question's cell by name, blank where none is given, after other code cells."""
    answers = answers or {}
    cells = [code(source) for source in before]
    cells += [code(student, student=True), {"cell_type": "markdown", "metadata": {}, "source": "Now answer."}]
    cells += [code(answers.get(name, "# unit\nanswer = ..."), question=name) for name in NAMES]
    return {"cells": cells, "metadata": {"gnsslab": {"worksheet": lesson, "version": "0.1.0"}}, "nbformat": 4, "nbformat_minor": 5}


def code(source, **about):
    """Return a code cell; `about` stands under "gnsslab" in its metadata. JupyterLab keeps the source as lines."""
    return {"cell_type": "code", "metadata": {"gnsslab": about} if about else {}, "source": source.splitlines(keepends=True), "outputs": []}


def all_right():
    """Return cells that answer every question rightly, as numbers."""
    return {question.name: f"# in {question.unit}\nanswer = {question.answer!r}" for question in QUESTIONS}


def write(path, notebook):
    """Write a notebook and return its path."""
    path.write_text(json.dumps(notebook), encoding="utf-8")
    return path
