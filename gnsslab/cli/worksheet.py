"""`gnsslab worksheet`: a lesson's notebook with blanks, for students to fill in."""

from pathlib import Path
from typing import Annotated

import typer

EXAMPLE = "Example: gnsslab worksheet 00 -o roof.ipynb     (mark what comes back with gnsslab grade)"

Number = Annotated[str, typer.Argument(metavar="LESSON", hidden=True)]
Output = Annotated[str, typer.Option("-o", "--output", metavar="FILE.ipynb", show_default=False, help="Notebook to write.")]
Force = Annotated[bool, typer.Option("--force", help="Overwrite a file that is there already.")]


def worksheet(context: typer.Context, lesson: Number, output: Output, force: Force = False):
    """Write the notebook of LESSON with its questions as blanks: no answers, no hints, no solutions."""
    from gnsslab.cli.outputs import check_output, write_provenance
    from gnsslab.teaching.catalogue import find_lesson

    found = find_lesson(lesson)
    _check_name(output, force)
    check_output(output)
    from gnsslab.teaching.jupyter.notebooks import as_text
    from gnsslab.teaching.worksheets.writing import worksheet

    Path(output).write_text(as_text(worksheet(found)), "utf-8")
    write_provenance([output], "worksheet", context.params)
    print(f"written to {output}: lesson {found.number} with {len(found.exercises.QUESTIONS)} questions to answer")


def _check_name(output, force):
    if output.strip() and not output.endswith(".ipynb"):
        raise ValueError(f"-o {output}: expected a name that ends in .ipynb")
    if Path(output).is_file() and not force:
        raise ValueError(f"{output} exists: give another name, or --force to overwrite it")
