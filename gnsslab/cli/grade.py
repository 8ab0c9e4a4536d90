"""`gnsslab grade`: marks the worksheets that students hand in."""

from typing import Annotated

import typer

from gnsslab.cli.options import positive

EXAMPLE = "Example: gnsslab grade handed-in/*.ipynb -o marks.csv"

Files = Annotated[list[str], typer.Argument(metavar="FILE.ipynb", hidden=True)]
Output = Annotated[str, typer.Option("-o", "--output", metavar="MARKS.csv", show_default=False, help="Table to write, one row a notebook.")]
Timeout = Annotated[float, typer.Option("--timeout", metavar="S", show_default=False, help="Seconds a notebook may run [60].")]


def grade(context: typer.Context, files: Files, output: Output, timeout: Timeout = 60.0):
    """Mark worksheets (FILE.ipynb...) made by `gnsslab worksheet`: a point for each right answer, remarks where code failed.

    A typed number is only read. Where an answer is worked out by code, the notebook is run in a process of its own, which
    is stopped at the time limit. That stops mistakes, not malice: look at code of people whom you do not know.

    A file that is no worksheet gets a row with the reason. A MARKS.csv that is there already is replaced.
    """
    from gnsslab.cli.outputs import check_output, write_provenance
    from gnsslab.cli.progress import progress_bar
    from gnsslab.teaching.worksheets.grading import grade_files

    positive("--timeout", timeout, "seconds")
    check_output(output, files)
    with progress_bar("marking") as progress:
        marked = grade_files(files, output, timeout, progress)
    refused = [marks for marks in marked if not marks.is_worksheet]
    notes = [f"{marks.file}: {marks.remarks[0]}" for marks in refused]
    write_provenance([output], "grade", context.params, [marks.file for marks in marked if marks.is_worksheet], notes)
    print(f"written to {output}: {len(marked) - len(refused)} of {len(marked)} notebooks marked")
    if refused:
        raise ValueError(f"{len(refused)} of {len(marked)} files are no worksheets ({refused[0].file}...): see the remarks in {output}")
