"""A lesson in JupyterLab: its prediction, labs and questions as widgets, one displayable object a cell.

lesson = open_lesson("00")
lesson.predict()
north = lesson.lab("north")
north
"""

from gnsslab.teaching.catalogue import find_lesson
from gnsslab.teaching.jupyter.lab import NotebookLab
from gnsslab.teaching.jupyter.questions import PredictionSheet, QuestionSheet
from gnsslab.teaching.jupyter.shown import Refusal
from gnsslab.teaching.progress import own_progress


def open_lesson(number):
    """Return the lesson of that number, with what this user answered before."""
    try:
        return NotebookLesson(find_lesson(number), own_progress())
    except ValueError as refusal:
        raise Refusal(str(refusal)) from None


class NotebookLesson:
    """One student's visit of one lesson: what was predicted and answered, and a front for each lab."""

    def __init__(self, lesson, progress):
        self.lesson = lesson
        self.progress = progress
        self._labs = lesson.open_labs()
        self._questions = {question.name: question for question in lesson.exercises.QUESTIONS}
        self._waiting = []  # functions to call once there is a prediction
        self._sheet = PredictionSheet(self)

    def predict(self):
        """Return the options to commit to, the earlier choice marked."""
        return self._sheet

    def lab(self, name, link=""):
        """Return the lab of that name, set as a link that was saved asks."""
        return NotebookLab(self, self._named("lab", self._labs, name), link)

    def question(self, name):
        """Return a question with its fields."""
        return QuestionSheet(self, self._named("question", self._questions, name))

    def record(self, item, kind, answer, **how):
        """Keep an answer of this lesson."""
        self.progress.record(self.lesson.number, item, kind, answer, **how)

    def entry(self, item):
        """Return what was answered before, or None."""
        return self.progress.entry(self.lesson.number, item)

    def when_predicted(self, work):
        """Call a function as soon as there is a prediction."""
        if self._sheet.is_chosen:
            work()
        else:
            self._waiting.append(work)

    def predicted(self):
        """Open what waits for the prediction."""
        waiting, self._waiting = self._waiting, []
        for work in waiting:
            work()

    def _named(self, kind, known, name):
        if name not in known:
            raise Refusal(f"lesson {self.lesson.number} has no {kind} {name!r}: it has {', '.join(known)}")
        return known[name]
