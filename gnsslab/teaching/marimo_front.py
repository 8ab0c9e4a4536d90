"""Any lab in marimo: controls as mo.ui elements, presets as buttons, readouts and kept pictures as HTML.

A lesson uses it in cells of one to three lines:

    front = LabFront(north_lab())
    chosen, choose = mo.state(None)
    presets = front.presets(choose)
    steering = front.steering(chosen())
    controls = front.controls(steering.value, chosen())
    result = front.run(steering.value, controls.value)
"""

import os
import shutil
import tempfile
import weakref
from html import escape
from pathlib import Path

import marimo as mo

from gnsslab.labs.controls import Choice, FileOrPath, Slider, Switch

STYLE = (Path(__file__).with_name("style.css")).read_text("utf-8")
SHARED = "GNSSLAB_COURSE_SHARED"  # set where others than this machine's user are served: they may not name its files
RADIO_AT_MOST = 3  # options that stand side by side; more go into a list


class LabFront:
    """One student's view of one lab: keeps the pictures, the uploads and the last settings of this session."""

    def __init__(self, lab):
        self.lab = lab
        self._last = dict(lab.defaults)
        self._pressed = None
        self._pictures = None
        self._uploads = None

    def presets(self, choose):
        """Return the presets as buttons; a press hands (preset, count) to `choose`, the setter of a mo.state."""
        return mo.ui.array([self._preset_button(preset, choose) for preset in self.lab.presets])

    def preset_row(self, buttons):
        """Return the row of preset buttons."""
        return mo.Html(f'<div class="gl-presets">{"".join(button.text for button in buttons)}</div>')

    def steering(self, pressed):
        """Return the controls that decide which others have an effect."""
        self._take_preset(pressed)
        return mo.ui.dictionary({c.name: self._element(c, "") for c in self.lab.controls if c.name in self.lab.steering})

    def controls(self, steering, pressed):
        """Return all other controls; those without effect under the steering values are disabled and say why."""
        self._take_preset(pressed)
        reasons = self.lab.blocked(self._last | steering)
        return mo.ui.dictionary({c.name: self._element(c, reasons.get(c.name, "")) for c in self._others})

    def panel(self, steering, controls):
        """Return the steering controls and the others as one panel, the rarer ones under "more"."""
        reasons = self.lab.blocked(self._last | steering.value)
        shown = [*steering.items(), *controls.items()]
        cells = {True: "", False: ""}
        for name, element in shown:
            control = self.lab.control(name)
            if not (isinstance(control, FileOrPath) and name in reasons):
                cells[control.more] += _cell(control, element, reasons.get(name, ""))
        more = f'<details class="gl-more"><summary>more</summary><div class="gl-controls">{cells[True]}</div></details>'
        return mo.Html(f'<div class="gl-controls">{cells[False]}</div>{more if cells[True] else ""}')

    def run(self, steering, controls):
        """Return the lab's result at the values of the controls."""
        settings = {name: self._setting(name, value) for name, value in (steering | controls).items()}
        self._last |= {name: value for name, value in settings.items() if not isinstance(self.lab.control(name), FileOrPath)}
        return self.lab.run(**settings)

    def view(self, result):
        """Return readouts and pictures of a result, or the sentence that says why there are none.

        Above them stands what to look at, as long as the controls are those of the preset pressed last.
        """
        note = self._look_at(result) + (f'<p class="gl-note">{escape(result.note)}</p>' if result.note else "")
        if result.problem:
            return mo.Html(f'{note}<p class="gl-problem" role="status">{escape(result.problem)}</p>')
        return mo.Html(note + _readouts(self.lab.readouts(result)) + self._images(result))

    def goal(self, name, result):
        """Return a goal of the lab, judged: reached or not yet, and where you stand."""
        goal = self.lab.goal(name)
        is_reached, state = goal.judge(result)
        word, kind = ("Reached.", " gl-reached") if is_reached else ("Not yet.", "")
        judged = f"<strong>{word}</strong> {escape(state)}"
        return mo.Html(f'<div class="gl-goal{kind}" role="status">{escape(goal.text)}<br>{judged}</div>')

    @property
    def _others(self):
        return [control for control in self.lab.controls if control.name not in self.lab.steering]

    def _take_preset(self, pressed):
        if pressed is not None and pressed is not self._pressed:
            self._pressed = pressed
            self._last = self.lab.defaults | dict(pressed[0].settings)

    def _look_at(self, result):
        """Return the pressed preset's sentence; none once a control was moved, or where other data stand in for the preset's."""
        if self._pressed is None or result.note or self._last != self.lab.defaults | dict(self._pressed[0].settings):
            return ""
        return f'<p class="gl-look" role="status">{escape(self._pressed[0].look_at)}</p>'

    def _preset_button(self, preset, choose):
        return mo.ui.button(value=0, on_click=lambda n: n + 1, on_change=lambda n: choose((preset, n)), label=preset.label)

    def _element(self, control, blocked):
        value = self._last[control.name]
        return _ELEMENTS[type(control)](control, value, bool(blocked))

    def _setting(self, name, value):
        control = self.lab.control(name)
        return self._file(name, value) if isinstance(control, FileOrPath) else value

    def _file(self, name, value):
        """Return the path of an upload, written to this session's folder, or the path that was typed."""
        if not value["upload"]:
            return "" if SHARED in os.environ else value["path"].strip()
        upload = value["upload"][0]
        folder = self._upload_folder() / name
        folder.mkdir(exist_ok=True)
        path = folder / Path(upload.name).name
        if not path.is_file() or path.stat().st_size != len(upload.contents) or path.read_bytes() != upload.contents:
            path.write_bytes(upload.contents)
        return str(path)

    def _upload_folder(self):
        """Return this session's folder for uploads, which goes when the session goes."""
        if self._uploads is None:
            self._uploads = tempfile.mkdtemp(prefix="gnsslab-")
            weakref.finalize(self, shutil.rmtree, self._uploads, ignore_errors=True)
        return Path(self._uploads)

    def _images(self, result):
        from gnsslab.figures.kept import KeptPicture, data_url

        if self._pictures is None:
            self._pictures = [(d, KeptPicture(d.build, d.width, d.height)) for d in self.lab.drawings()]
        words = [self.lab.describe(result)] + [""] * len(self._pictures)
        images = [
            f'<img src="{data_url(picture.png(result))}" alt="{escape(alt)}" width="{d.width}" height="{d.height}">'
            for (d, picture), alt in zip(self._pictures, words, strict=False)
        ]
        return f'<div class="gl-pictures">{"".join(images)}</div>'


def lesson_head(lesson):
    """Return the head of a lesson: the way home, title, time, what it needs and what it gives."""
    gives = "".join(f"<li>{escape(text)}</li>" for text in lesson.gives)
    return mo.Html(
        f'<style>{STYLE}</style><div class="gl-head"><nav><a href="/" target="_self">All lessons</a></nav>'
        f"<h1>{escape(lesson.title)}</h1>"
        f'<p class="gl-meta">Lesson {lesson.number} · about {lesson.minutes} minutes · needs {escape(lesson.needs)}</p>'
        f'<p class="gl-gives">Afterwards you can</p><ul>{gives}</ul></div>'
    )


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
    path = mo.ui.text(label="or its path", full_width=True, disabled=SHARED in os.environ)
    return mo.ui.dictionary({"upload": mo.ui.file(label="upload"), "path": path})


_ELEMENTS = {Slider: _slider, Choice: _choice, Switch: _switch, FileOrPath: _file_or_path}


def _cell(control, element, reason):
    """Return one control with its help, or with the reason why it has no effect."""
    inner = f"{control.label}<br>{element['upload'].text}{element['path'].text}" if isinstance(control, FileOrPath) else element.text
    kind = " gl-blocked" if reason else ""
    return f'<div class="gl-control{kind}">{inner}<small>{escape(reason or control.help)}</small></div>'


def _readouts(readouts):
    cells = "".join(
        f"<div><dt>{escape(r.label)}</dt><dd>{escape(r.value)} <span>{escape(r.unit)}</span></dd><small>{escape(r.note)}</small></div>"
        for r in readouts
    )
    return f'<dl class="gl-readouts" aria-live="polite">{cells}</dl>'
