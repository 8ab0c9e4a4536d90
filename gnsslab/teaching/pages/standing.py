"""How far a student is in a lesson: prediction, questions and goals, counted from what was recorded."""

from dataclasses import dataclass

from gnsslab.teaching.steps import steps_of


@dataclass(frozen=True)
class Standing:
    """What of one lesson is done. Its steps are the prediction, each question and each goal."""

    is_predicted: bool
    right: int  # questions answered right
    questions: int
    reached: int  # goals
    goals: int
    last: str  # time of the latest entry, "" where there is none

    @property
    def taken(self):
        """Steps done."""
        return self.is_predicted + self.right + self.reached

    @property
    def steps(self):
        """Steps there are.

        >>> Standing(is_predicted=True, right=2, questions=4, reached=0, goals=2, last="").steps
        7
        """
        return 1 + self.questions + self.goals

    @property
    def is_begun(self):
        """Anything at all was recorded."""
        return bool(self.last)

    @property
    def is_done(self):
        """Every step is done."""
        return self.taken == self.steps


def standing_in(lesson, entries):
    """Return the Standing in a lesson, from the recorded entries of all lessons."""
    own = [entry for entry in entries if entry.lesson == lesson.number]
    questions, goals = {question.name for question in lesson.exercises.QUESTIONS}, goals_of(lesson)
    return Standing(
        is_predicted=any(entry.kind == "prediction" for entry in own),
        right=sum(entry.kind == "question" and entry.is_right is True and entry.item in questions for entry in own),
        questions=len(questions),
        reached=sum(entry.kind == "goal" and entry.is_right is True and entry.item in goals for entry in own),
        goals=len(goals),
        last=max((entry.time for entry in own), default=""),
    )


def goals_of(lesson):
    """Return the names of the goals that a lesson shows, read from its file: opening its labs would load the engine.

    >>> from gnsslab.teaching.catalogue import find_lesson
    >>> sorted(goals_of(find_lesson(0)))
    ['frugal', 'sharp', 'unnoticed']
    """
    return {step.name for step in steps_of(lesson.path.read_text("utf-8")) if step.kind == "goal"}
