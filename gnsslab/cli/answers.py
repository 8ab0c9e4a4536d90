"""`gnsslab answers`: the instructor's key of a lesson."""

import shutil
import sys
from typing import Annotated

import typer

EXAMPLE = "Example: gnsslab answers 00     or: gnsslab answers 00 --json > key.json"

Number = Annotated[str, typer.Argument(metavar="LESSON", hidden=True)]
AsJson = Annotated[bool, typer.Option("--json", help="As JSON, for other programs.")]


def answers(lesson: Number, json: AsJson = False):
    """Print the instructor's key of LESSON: answers, tolerances, hints, solutions, usual mistakes."""
    from gnsslab.teaching.answers import key_lines, key_record
    from gnsslab.teaching.catalogue import find_lesson

    found = find_lesson(lesson)
    sys.stdout.reconfigure(errors="replace")  # a terminal without Greek letters shows question marks
    print(_as_json(key_record(found)) if json else "\n".join(key_lines(found, shutil.get_terminal_size().columns)))


def _as_json(record):
    import json

    return json.dumps(record, indent=2)
