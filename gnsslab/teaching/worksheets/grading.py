"""Marks worksheets: one row a notebook, a point for each right answer, and a remark for whatever a teacher should know."""

import csv
from dataclasses import dataclass, field

from gnsslab.teaching.questions import judge
from gnsslab.teaching.spreadsheets import harmless
from gnsslab.teaching.worksheets.files import assigns_answer, read_worksheet, typed_answer
from gnsslab.teaching.worksheets.runs import Outcome, run_cells


@dataclass(frozen=True)
class Marks:
    """What a worksheet earned."""

    file: str
    student: str = ""
    lesson: str = ""
    points: dict[str, int] = field(default_factory=dict)  # question: 1 right, 0 wrong; a blank one is left out
    answers: dict[str, str] = field(default_factory=dict)  # question: what was given
    of: int = 0  # questions of the lesson
    remarks: tuple[str, ...] = ()
    is_worksheet: bool = True


def grade(worksheet, seconds=60.0):
    """Return the Marks of a Worksheet; its cells are run, for at most so many seconds, only where an answer is more than a number."""
    if worksheet.problem:
        return Marks(worksheet.file, remarks=(worksheet.problem,), is_worksheet=False)
    questions = worksheet.lesson.exercises.QUESTIONS
    given, remarks = _given(worksheet, seconds)
    verdicts = {q.name: judge(q, given[q.name]) for q in questions if given.get(q.name)}
    return Marks(
        file=worksheet.file,
        student=worksheet.student,
        lesson=worksheet.lesson.number,
        points={name: int(verdict.is_right) for name, verdict in verdicts.items()},
        answers={name: given[name] for name in verdicts},
        of=len(questions),
        remarks=(*_about_cells(worksheet, questions), *remarks, *_about_answers(verdicts)),
    )


def grade_files(paths, output, seconds=60.0, progress=None):
    """Mark notebooks into the CSV file `output`, row by row, so that an interruption loses none; return the list of Marks.

    `progress(done, total)` is called after each notebook.
    """
    worksheets = [read_worksheet(path) for path in paths]
    names = _questions_of(worksheets)
    marked = []
    with open(output, "w", newline="", encoding="utf-8", errors="backslashreplace") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["file", "name", "lesson", *names, *(f"{name}_answer" for name in names), "points", "of", "remarks"])
        for worksheet in worksheets:
            marked.append(grade(worksheet, seconds))
            table.writerow(_row(marked[-1], names))
            file.flush()
            if progress:
                progress(len(marked), len(worksheets))
    return marked


def _given(worksheet, seconds):
    """Return the answers given, by question, and remarks on the cells that were run."""
    typed = {place: typed_answer(worksheet.cells[place]) for _, place in worksheet.asked}
    outcomes = run_cells(worksheet.cells, seconds) if None in typed.values() else [Outcome()] * len(worksheet.cells)
    given = {}
    for name, place in worksheet.asked:
        ran = outcomes[place].answer if assigns_answer(worksheet.cells[place]) else ""
        answer = ran if typed[place] is None else typed[place]
        given[name] = " ".join(answer.split()) or given.get(name, "")  # of a cell that was copied the last filled one counts
    names = {place: name for name, place in worksheet.asked}
    ran_wrong = [(place, outcome.problem) for place, outcome in enumerate(outcomes) if outcome.problem and typed.get(place) is None]
    return given, [f"{names.get(place, f'code cell {place + 1}')}: {' '.join(problem.split())}" for place, problem in ran_wrong]


def _about_cells(worksheet, questions):
    """Yield what is to be said of the notebook's cells: no name, no cell for a question, a cell without answer."""
    asked = dict(worksheet.asked)
    if not worksheet.student:
        yield "no name"
    for question in questions:
        if question.name not in asked:
            yield f"{question.name}: its cell is missing"
        elif typed_answer(source := worksheet.cells[asked[question.name]]) is None and not assigns_answer(source):
            yield f'{question.name}: no "answer = ..." in its cell'


def _about_answers(verdicts):
    """Yield the words for answers that could not be judged."""
    for name, verdict in verdicts.items():
        if not verdict.is_number:
            yield f"{name}: {verdict.words}"


def _questions_of(worksheets):
    """Return the names of the questions of all lessons that are there, in the order of the course."""
    lessons = {worksheet.lesson.number: worksheet.lesson for worksheet in worksheets if worksheet.lesson}
    return [question.name for _, lesson in sorted(lessons.items()) for question in lesson.exercises.QUESTIONS]


def _row(marks, names):
    texts = [harmless(text) for text in (marks.file, marks.student, marks.lesson)]
    points = [marks.points.get(name, "") for name in names]
    answers = [harmless(marks.answers.get(name, "")) for name in names]
    total = [sum(marks.points.values()), marks.of] if marks.is_worksheet else ["", ""]
    return [*texts, *points, *answers, *total, harmless("; ".join(marks.remarks))]
