"""How far a student is: counted from what was recorded, and from nothing else."""

import pytest

from gnsslab.teaching.catalogue import LESSONS
from gnsslab.teaching.pages.standing import goals_of, standing_in
from gnsslab.teaching.progress import Progress

LESSON = LESSONS[0]
QUESTIONS = LESSON.exercises.QUESTIONS


def _after(*records):
    progress = Progress()
    for record in records:
        progress.record(*record)
    return standing_in(LESSON, progress.entries())


@pytest.mark.parametrize("lesson", LESSONS, ids=lambda lesson: lesson.number)
def test_goals_read_from_the_file_are_those_of_the_labs(lesson):
    assert goals_of(lesson) == {goal.name for lab in lesson.open_labs().values() for goal in lab.goals}


def test_nothing_recorded_is_not_begun():
    standing = _after()
    assert not standing.is_begun
    assert (standing.taken, standing.steps) == (0, 1 + len(QUESTIONS) + len(goals_of(LESSON)))


def test_steps_are_the_prediction_right_answers_and_goals():
    standing = _after(
        (LESSON.number, "any", "prediction", "x", False),
        (LESSON.number, QUESTIONS[0].name, "question", "1", True),
        (LESSON.number, QUESTIONS[1].name, "question", "1", False),
        (LESSON.number, sorted(goals_of(LESSON))[0], "goal", "so", True),
    )
    assert (standing.is_predicted, standing.right, standing.reached, standing.taken) == (True, 1, 1, 3)
    assert standing.is_begun
    assert not standing.is_done


def test_what_belongs_to_other_lessons_or_to_no_question_does_not_count():
    standing = _after(("77", QUESTIONS[0].name, "question", "1", True), (LESSON.number, "a question of long ago", "question", "1", True))
    assert (standing.right, standing.taken) == (0, 0)


def test_the_last_answer_counts():
    name = QUESTIONS[0].name
    standing = _after((LESSON.number, name, "question", "1", False), (LESSON.number, name, "question", "2", True))
    assert standing.right == 1
