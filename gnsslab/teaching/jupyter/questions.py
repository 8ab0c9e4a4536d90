"""Prediction and questions of a lesson as widgets; what was answered before stands there again."""

from ipywidgets import Button, HBox, Layout, RadioButtons, Text, VBox

from gnsslab.teaching.jupyter.shown import Markdown, Shown, soon
from gnsslab.teaching.questions import judge

LAST_LETTERS = 0.15  # [s] after the Enter key, by when the last letters typed have arrived as well
FIRST_TRY = "Try once, or take both hints; then the solution opens."


class PredictionSheet(Shown):
    """The options to commit to; the labs open at the first choice."""

    def __init__(self, lesson):
        self._lesson = lesson
        self._asked = lesson.lesson.exercises.PREDICTION
        entry = lesson.entry(self._asked.name)
        earlier = entry.answer if entry is not None and entry.answer in self._asked.options else None
        self.options = RadioButtons(options=self._asked.options, value=earlier, layout=Layout(width="auto"))
        self._said = Markdown()
        self.box = VBox([Markdown(self._asked.text), self.options, self._said])
        self._say()
        self.options.observe(self._chosen, "value")

    @property
    def is_chosen(self):
        """There is a prediction."""
        return self.options.value is not None

    def _chosen(self, change):
        answer = self.options.value
        self._lesson.record(self._asked.name, "prediction", answer, is_right=answer == self._asked.answer)
        self._say()
        self._lesson.predicted()

    def _say(self):
        if self.is_chosen:
            said = f"You said: **{self.options.value}**. Look at the picture, then come back to your answer."
            self._said.say(f"{said}\n\n{self._lesson.progress.problem}")


class QuestionSheet(Shown):
    """One question: its field, hints one after the other, the solution, and what is said of the answer."""

    def __init__(self, lesson, question):
        self._lesson = lesson
        self._question = question
        self._words = ""  # the verdict on the answer checked last
        self._text, self.said = Markdown(question.text), Markdown()
        self.answer = _field(question, self._entry)
        self.check, self.hint, self.solution = (Button(description=label, layout=Layout(width="auto")) for label in ("Check", "Hint", "Solution"))
        fields = HBox([self.answer, self.check, self.hint, self.solution], layout=Layout(flex_flow="row wrap"))
        self.box = VBox([self._text, fields, self.said]).add_class("gl-lab-question")
        self._listen()
        if self.answer.value:
            self._checked()

    @property
    def _entry(self):
        return self._lesson.entry(self._question.name)

    @property
    def _hints(self):
        return self._entry.hints if self._entry else 0

    def _listen(self):
        self.check.on_click(lambda _: self._checked())
        self.hint.on_click(lambda _: self._hinted())
        self.solution.on_click(lambda _: self._solution_asked())
        self.answer.on_msg(self._on_enter)

    def _on_enter(self, field, message, buffers):
        if message.get("event") == "submit":
            soon(self._checked, LAST_LETTERS)

    def _checked(self):
        verdict = judge(self._question, self.answer.value)
        if verdict.is_number:
            self._record(self.answer.value, is_right=verdict.is_right)
        self._words = verdict.words
        self._say()

    def _hinted(self):
        self._record("", hints=min(self._hints + 1, len(self._question.hints)))
        self._say()

    def _solution_asked(self):
        if self._hints == len(self._question.hints) or (self._entry and self._entry.tries):
            self._record("", solution_seen=True)
            self._say()
        else:
            self._say(FIRST_TRY)

    def _record(self, answer, **how):
        self._lesson.record(self._question.name, "question", answer, **how)

    def _say(self, besides=""):
        """Show the verdict, the hints seen so far, the solution once it was opened, and one sentence besides."""
        told = [f"**Hint {k}.** {hint}" for k, hint in enumerate(self._question.hints[: self._hints], 1)]
        if self._entry and self._entry.solution_seen:
            told.append(f"**Solution.** {self._question.solution}")
        self.said.say("\n\n".join(filter(None, [self._words, *told, besides, self._lesson.progress.problem])))


def _field(question, entry):
    """Return the field for the answer, with what was answered before."""
    unit = f" [{question.unit}]" if question.unit else ""
    earlier = entry.answer if entry is not None else ""
    return Text(earlier, description=f"Your answer{unit}", placeholder="a number", style={"description_width": "initial"})
