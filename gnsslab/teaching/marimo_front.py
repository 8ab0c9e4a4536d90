"""A lesson in marimo: its labs as mo.ui elements, its questions, goals and prediction, in cells of one to three lines.

lesson = open_lesson("00")
prediction = lesson.prediction()
north = lesson.lab("north")
chosen, choose = mo.state(None)
presets = north.presets(choose)
steering = north.steering(chosen())
controls = north.controls(steering.value, chosen())
result = north.run(steering.value, controls.value)
north.view(result)
"""

from html import escape
from itertools import zip_longest

import marimo as mo

from gnsslab.labs.controls import Choice, FileOrPath, Slider, Switch
from gnsslab.labs.links import preset_of, settings_of
from gnsslab.teaching import markup
from gnsslab.teaching.catalogue import find_lesson
from gnsslab.teaching.desk import Desk
from gnsslab.teaching.questions import judge
from gnsslab.teaching.saving import MIME_TYPES, link_of, saved
from gnsslab.teaching.visitor import is_class, progress_of

RADIO_AT_MOST = 3  # options that stand side by side; more go into a list
UPLOAD_IN_CLASS = 30_000_000  # bytes; a third more on the way, which the door lets pass
CHECK = '<button type="button" class="gl-check">Check</button>'  # takes the focus, whereupon the field hands over what was typed
KEYS = "1234567890"  # press the presets in front of a class
CLOSED = "*Choose an answer above to open the lab.*"


def open_lesson(number):
    """Return the lesson of that number, for the visitor who opened the page."""
    query = {name: values[-1] if isinstance(values, list) else values for name, values in mo.query_params().to_dict().items()}
    return LessonFront(find_lesson(number), progress_of(mo.app_meta().request), query)


class LessonFront:
    """One student's visit of one lesson: what was predicted and answered, and a front for each lab."""

    def __init__(self, lesson, progress, query):
        self.lesson = lesson
        self.progress = progress
        self.is_presented = query.get("mode") == "present"
        self._query = query
        self._labs = lesson.open_labs()
        self._questions = {question.name: question for question in lesson.exercises.QUESTIONS}

    def head(self):
        """Return the head of the lesson and the style of everything below."""
        problem = f'<p class="gl-note">{escape(self.progress.problem)}</p>' if self.progress.problem else ""
        return mo.Html(f"<style>{markup.STYLE}{self._stage_style()}</style>{markup.head(self.lesson)}{problem}{self._stage_head()}")

    def prediction(self):
        """Return the options to commit to, the earlier choice marked."""
        asked = self.lesson.exercises.PREDICTION
        entry = self.progress.entry(self.lesson.number, asked.name)
        chosen = entry.answer if entry is not None and entry.answer in asked.options else None
        return mo.ui.radio(list(asked.options), chosen, label=asked.text)

    def wait(self, prediction):
        """Stop the cell until there is a prediction; in front of a class the lab is open."""
        mo.stop(prediction.value is None and not self.is_presented)

    def predicted(self, prediction):
        """Return what was predicted, which is kept; until then the sentence that asks for it."""
        if self.is_presented:
            return None
        mo.stop(prediction.value is None, mo.md(CLOSED))
        asked = self.lesson.exercises.PREDICTION
        self.progress.record(self.lesson.number, asked.name, "prediction", prediction.value, prediction.value == asked.answer)
        return mo.md(f"You said: **{prediction.value}**. Look at the picture, then come back to your answer.")

    def text(self, prediction, text):
        """Return a text that would give the answer away before the prediction."""
        self.wait(prediction)
        return mo.md(text)

    def lab(self, name):
        """Return the front of the lab of that name, set as the page's link asks."""
        query = self._query if name == self._lab_shown() else {}
        front = LabFront(self, self._labs[name], query)
        if name == next(iter(self._labs)):
            front.notes += self._lost()
        return front

    def reached(self, goal, settings):
        """Keep that a goal was reached."""
        self.progress.record(self.lesson.number, goal.name, "goal", settings, True)

    def ask(self, name):
        """Return the elements of a question: the answer as typed, how many hints, whether the solution is wanted."""
        question = self._questions[name]
        entry = self.progress.entry(self.lesson.number, name)
        unit = f" [{question.unit}]" if question.unit else ""
        return mo.ui.dictionary(
            {
                "answer": mo.ui.text(entry.answer if entry is not None else "", label=f"Your answer{unit}", placeholder="a number"),
                "hints": _counter("Hint"),
                "solution": _counter("Solution"),
            }
        )

    def sheet(self, name, asked):
        """Return a question with its fields."""
        question = self._questions[name]
        number = list(self._questions).index(name) + 1
        parts = [asked["answer"].text, CHECK, asked["hints"].text, asked["solution"].text]
        fields = "".join(f"<span>{part}</span>" for part in parts)
        return mo.Html(f'<div class="gl-question"><b>{number}</b>{mo.md(question.text).text}<div class="gl-fields">{fields}</div></div>')

    def check(self, name, given):
        """Return what is said of an answer, the hints asked for, and the solution once it was tried."""
        question = self._questions[name]
        verdict = judge(question, given["answer"])
        hints = min(given["hints"], len(question.hints))
        has_tried = verdict.is_number or hints == len(question.hints)
        if verdict.is_number:
            self.progress.record(self.lesson.number, name, "question", given["answer"], verdict.is_right, hints, given["solution"] > 0)
        said = markup.verdict(verdict.is_right, _words_of(verdict)) if given["answer"].strip() else ""
        told = "".join(_told(f"Hint {k}", hint) for k, hint in enumerate(question.hints[:hints], 1))
        if given["solution"]:
            told += _told("Solution", question.solution) if has_tried else _told("Solution", "Try once, or take both hints; then it opens.")
        return mo.Html(f'<div class="gl-answer">{said}{told}</div>')

    def _lost(self):
        """Return a sentence for what the link asks for and this lesson does not have."""
        known = {"lab": list(self._labs), "preset": [preset.name for lab in self._labs.values() for preset in lab.presets]}
        return [
            f"The link asks for the {kind} {self._query[kind]!r}; this lesson has {', '.join(names)}."
            for kind, names in known.items()
            if kind in self._query and self._query[kind] not in names
        ]

    def _stage_style(self):
        """Return the rules that leave only the stage on the page, while the lesson is presented."""
        return markup.present_style(self._lab_shown()) if self.is_presented else ""

    def _lab_shown(self):
        """Return the name of the lab that the link asks for, by name or by preset; the first where this lesson does not have it."""
        asked = [name for name in self._labs if name == self._query.get("lab")]
        by_preset = [name for name, lab in self._labs.items() if preset_of(lab, self._query)]
        return next(iter([*asked, *by_preset, *self._labs]))

    def _stage_head(self):
        return markup.present_head(self.lesson, self._labs) if self.is_presented else ""


class LabFront:
    """One student's view of one lab."""

    def __init__(self, lesson, lab, query):
        self.lab = lab
        self.desk = Desk(lab)
        preset = preset_of(lab, query)
        if preset is not None:
            self.desk.press(preset)
        settings, self.notes = settings_of(lab, query)
        self.desk.settings |= settings
        self._lesson = lesson
        self._pressed = None
        self._reached = set()

    def presets(self, choose):
        """Return the presets as buttons; a press hands (preset, count) to `choose`, the setter of a mo.state."""
        return mo.ui.array([self._preset_button(preset, choose) for preset in self.lab.presets])

    def preset_row(self, buttons):
        """Return the row of preset buttons, the pressed one marked as long as its settings stand."""
        names = [preset.name for preset in self.lab.presets]
        shown = "".join(
            f'<span class="gl-preset" data-preset="{name}" data-key="{key}">{button.text}</span>'
            for key, name, button in zip_longest(KEYS[: len(names)], names, buttons, fillvalue="")
        )
        notes = "".join(f'<p class="gl-note">{escape(problem)}</p>' for problem in self.notes)
        return self._staged(f'<style>{"".join(map(_mark_of_pressed, names))}</style>{notes}<div class="gl-presets">{shown}</div>')

    def steering(self, pressed):
        """Return the controls that decide which others have an effect."""
        self._take_preset(pressed)
        return mo.ui.dictionary({c.name: self._element(c) for c in self.lab.controls if c.name in self.lab.steering})

    def controls(self, steering, pressed):
        """Return all other controls; those without effect under the steering values are disabled and say why."""
        self._take_preset(pressed)
        self.desk.settings |= steering
        return mo.ui.dictionary({c.name: self._element(c) for c in self.lab.controls if c.name not in self.lab.steering})

    def panel(self, steering, controls):
        """Return the steering controls and the others as one panel, the rarer ones under "more"."""
        reasons = self.desk.blocked
        cells = {True: "", False: ""}
        for name, element in [*steering.items(), *controls.items()]:
            control = self.lab.control(name)
            if not (isinstance(control, FileOrPath) and name in reasons):
                cells[control.more] += self._cell(control, element, reasons.get(name, ""))
        more = f'<details class="gl-more"><summary>more</summary><div class="gl-controls">{cells[True]}</div></details>'
        return self._staged(f'<div class="gl-controls">{cells[False]}</div>{more if cells[True] else ""}')

    def run(self, steering, controls):
        """Return the lab's result at the values of the controls."""
        return self.desk.run({name: self._setting(name, value) for name, value in (steering | controls).items()})

    def view(self, result):
        """Return readouts and pictures of a result, or the sentence that says why there are none."""
        return self._staged(markup.view(self.desk, result))

    def saving(self):
        """Return the elements of "save this": the files, made when asked for, and the link."""
        files = {
            kind: mo.download(lambda kind=kind: self._saved(kind), f"{self.lab.name}.{kind}", mime, label=kind.upper())
            for kind, mime in MIME_TYPES.items()
        }
        return mo.ui.dictionary({**files, "link": _counter("Link")})

    def saving_row(self, saving):
        """Return "save this", folded."""
        buttons = "".join(f"<span>{element.text}</span>" for element in saving.values())
        return mo.Html(f'<details class="gl-more"><summary>save this</summary><div class="gl-presets">{buttons}</div></details>')

    def link(self, saving):
        """Return the link that brings back the controls as they are now, once it was asked for."""
        if not saving["link"]:
            return None
        address = escape(link_of(self._lesson.lesson, self.desk))
        return mo.Html(f'<p class="gl-note">This link brings back all controls and the seed: <a href="{address}" target="_self">{address}</a></p>')

    def goal(self, name, result):
        """Return a goal of the lab, judged: reached or not yet, and where you stand."""
        goal = self.lab.goal(name)
        if name not in self._reached and goal.judge(result)[0]:
            self._reached.add(name)
            self._lesson.reached(goal, link_of(self._lesson.lesson, self.desk))
        return mo.Html(markup.goal(goal, result))

    def _staged(self, html):
        """Return HTML as a part of the stage, which is all that stands in front of a class."""
        return mo.Html(f'<div class="gl-stage" data-lab="{self.lab.name}">{html}</div>')

    def _take_preset(self, pressed):
        if pressed is not None and pressed is not self._pressed:
            self._pressed = pressed
            self.desk.press(pressed[0])

    def _preset_button(self, preset, choose):
        return mo.ui.button(value=0, on_click=lambda n: n + 1, on_change=lambda n: choose((preset, n)), label=preset.label)

    def _element(self, control):
        return _ELEMENTS[type(control)](control, self.desk.settings[control.name], control.name in self.desk.blocked)

    def _cell(self, control, element, reason):
        """Return one control with its help, or with the reason why it has no effect."""
        inner = self._file_cell(control, element) if isinstance(control, FileOrPath) else element.text
        kind = " gl-blocked" if reason else ""
        return f'<div class="gl-control{kind}">{inner}{markup.control_help(control, reason)}</div>'

    def _file_cell(self, control, element):
        uploaded = self.desk.uploaded_name(control.name)
        kept = f"<em>{escape(uploaded)} is kept</em>" if uploaded else ""
        return f'<div class="gl-file"><b>{escape(control.label)}</b>{element["upload"].text}{element["path"].text}{kept}</div>'

    def _setting(self, name, value):
        if not isinstance(self.lab.control(name), FileOrPath):
            return value
        upload = value["upload"][0] if value["upload"] else None
        typed = "" if is_class() else value["path"].strip()
        return self.desk.given_file(name, typed, upload and (upload.name, upload.contents))

    def _saved(self, kind):
        if self.desk.result is None or self.desk.result.problem:
            return b"There is no picture at the present controls, so there is nothing to save.\n"
        return saved(self.desk, kind)


def _counter(label):
    return mo.ui.button(value=0, on_click=lambda n: n + 1, label=label)


def _words_of(verdict):
    """Return the words of a verdict as HTML; those on what is no number repeat what was typed, in which nothing is markup."""
    return mo.md(verdict.words).text if verdict.is_number else escape(verdict.words)


def _told(title, text):
    return f'<div class="gl-told"><b>{title}</b>{mo.md(text).text}</div>'


def _mark_of_pressed(name):
    """Return the rule that marks a preset's button while its sentence stands below."""
    return f'body:has(.gl-look[data-preset="{name}"]) .gl-preset[data-preset="{name}"]{{border-color:var(--gl-accent)}}'


def _slider(control, value, disabled):
    label = f"{control.label} [{control.unit}]" if control.unit else control.label
    return mo.ui.slider(control.start, control.stop, control.step, value, show_value=True, label=label, disabled=disabled, full_width=True)


def _choice(control, value, disabled):
    text = control.text_of(value)
    if len(control.options) <= RADIO_AT_MOST:
        return mo.ui.radio(control.options, text, inline=True, label=control.label, disabled=disabled)
    return mo.ui.dropdown(control.options, text, allow_select_none=False, label=control.label, disabled=disabled, full_width=True)


def _switch(control, value, disabled):
    return mo.ui.switch(value, label=control.label, disabled=disabled)


def _file_or_path(control, value, disabled):
    path = mo.ui.text(label="or its path", full_width=True, disabled=is_class())
    limit = {"max_size": UPLOAD_IN_CLASS} if is_class() else {}
    return mo.ui.dictionary({"upload": mo.ui.file(label="upload", **limit), "path": path})


_ELEMENTS = {Slider: _slider, Choice: _choice, Switch: _switch, FileOrPath: _file_or_path}
