"""`gnsslab reproduce`: the papers' stated numbers, claims and figures against ours, as a report."""

from typing import Annotated

import typer

EXAMPLE = "Example: gnsslab reproduce A -o report.html --seeds 20"

Papers = Annotated[list[str] | None, typer.Argument(metavar="PAPER", hidden=True)]
Output = Annotated[str, typer.Option("-o", "--output", metavar="REPORT.html", show_default=False, help="The report; REPORT.json has its numbers.")]
Seeds = Annotated[int | None, typer.Option("--seeds", metavar="N", show_default=False, help="How many draws of the noise [A 20, B 30].")]
Seed = Annotated[int, typer.Option("--seed", metavar="N", show_default=False, help="The first of them [0]: same seeds, same report.")]

_MOST_SEEDS = 10_000


def reproduce(context: typer.Context, output: Output, papers: Papers = None, seeds: Seeds = None, seed: Seed = 0):
    """Reproduce PAPERs, A to E, or all there are: verdicts, tables, figures."""
    from gnsslab.cli.options import within
    from gnsslab.reproduce.papers import checked_letters

    if seeds is not None:
        within("--seeds", seeds, 1, _MOST_SEEDS, "a whole number")
    if seed < 0:
        raise ValueError(f"--seed {seed}: expected a whole number, zero or above")
    letters = checked_letters(papers or ())
    _reproduce(context.params, letters, _outputs(output), seed, seeds)


def _outputs(report):
    """Return the paths of the report and of its numbers, both found writable."""
    from pathlib import Path

    from gnsslab.cli.outputs import check_output

    if Path(report).suffix.lower() not in (".html", ".htm"):
        raise ValueError(f"-o {report}: expected a name that ends in .html")
    numbers = str(Path(report).with_suffix(".json"))
    for path in (report, numbers):
        check_output(path)
    return report, numbers


def _reproduce(given, letters, outputs, first, count):
    from pathlib import Path

    from gnsslab.cli.outputs import write_provenance
    from gnsslab.cli.progress import progress_bar
    from gnsslab.reproduce.papers import reproduced, usual_seeds
    from gnsslab.reproduce.report import report_html, report_json, tally
    from gnsslab.reproduce.rule import RULE

    found = []
    for letter in letters:
        seeds = range(first, first + (count or usual_seeds(letter)))
        with progress_bar(f"paper {letter}") as progress:
            found.append(reproduced(letter, seeds, progress))
    typed = f"gnsslab reproduce {' '.join(letters)} -o {Path(outputs[0]).name}{f' --seeds {count}' if count else ''} --seed {first}"
    for path, text in zip(outputs, (report_html(found, typed), report_json(found)), strict=True):
        Path(path).write_text(text, encoding="utf-8")
    write_provenance(outputs[:1], "reproduce", given | {"papers": list(letters)}, notes=[RULE, *(note for one in found for note in one.notes)])
    for one in found:
        print(f"paper {one.letter}: {tally(one.lines)}")
    print(f"written to {outputs[0]} and {outputs[1]}")
