"""A lab in JupyterLab: closed until the prediction, then presets, pictures, controls and "save this" in one box; goals in cells of their own."""

from html import escape
from urllib.parse import parse_qsl

from ipywidgets import HTML, Accordion, Button, GridBox, HBox, Layout, VBox

from gnsslab.labs.links import preset_of, settings_of
from gnsslab.teaching import markup
from gnsslab.teaching.desk import Desk
from gnsslab.teaching.jupyter.controls import shown_control
from gnsslab.teaching.jupyter.saving import SavingRow
from gnsslab.teaching.jupyter.shown import STYLE, Refusal, Shown, note, soon
from gnsslab.teaching.saving import link_of

COLUMNS = "repeat(auto-fit, minmax(min(100%, 19rem), 1fr))"
CLOSED = "Choose an answer under Predict to open the lab."
OPENING = "Opening the lab ... The first time on a machine this takes up to half a minute."


class NotebookLab(Shown):
    """One student's view of one lab."""

    def __init__(self, lesson, lab, link=""):
        self.desk = Desk(lab)
        self._lesson = lesson
        self._notes = self._set_as(dict(parse_qsl(link.rpartition("?")[2])))
        self._goals = {}  # name -> widget
        self._is_showing = False  # the controls follow the desk, and not the desk the controls
        self.controls = {}  # name -> control on the screen
        self.view = HTML()
        self.box = VBox([note(CLOSED)]).add_class("gl-lab")
        lesson.when_predicted(self._open_soon)

    def goal(self, name):
        """Return a goal, judged whenever the controls move."""
        try:
            goal = self.desk.lab.goal(name)
        except ValueError as refusal:
            raise Refusal(str(refusal)) from None
        self._goals[name] = HTML(f'<div class="gl-goal">{escape(goal.text)}<br><strong>{escape(CLOSED)}</strong></div>')
        self._judge()
        return self._goals[name]

    def press(self, preset):
        """Set the controls to a preset."""
        self.desk.press(preset)
        self._run({})

    def _set_as(self, query):
        """Set the desk as a link asks; return a sentence for each value that cannot be."""
        preset = preset_of(self.desk.lab, query)
        if preset is not None:
            self.desk.press(preset)
        settings, problems = settings_of(self.desk.lab, query)
        self.desk.settings |= settings
        return problems

    def _open_soon(self):
        self.box.children = [note(OPENING)]
        soon(self._open)

    def _open(self):
        self.controls = {control.name: shown_control(control, self.desk, self._moved) for control in self.desk.lab.controls}
        self._run({})
        above = [HTML(f"<style>{STYLE}</style>"), *map(note, self._notes), self._presets()]
        self.box.children = [*above, self.view, *self._panel(), SavingRow(self._lesson, self.desk).box]

    def _presets(self):
        buttons = [Button(description=preset.label, tooltip=preset.look_at, layout=Layout(width="auto")) for preset in self.desk.lab.presets]
        for preset, button in zip(self.desk.lab.presets, buttons, strict=True):
            button.on_click(lambda _, preset=preset: self.press(preset))
        return HBox(buttons, layout=Layout(flex_flow="row wrap"))

    def _panel(self):
        """Return the controls, the rarer ones under "more"."""
        often, rarely = ([shown.box for shown in self.controls.values() if shown.control.more is more] for more in (False, True))
        panels = [_grid(often)]
        return [*panels, Accordion([_grid(rarely)], titles=("more",))] if rarely else panels

    def _moved(self, name, value):
        if not self._is_showing:
            self._run({name: value})

    def _run(self, changed):
        """Run the lab with the changed settings and show what comes out, or the sentence why nothing does."""
        try:
            result = self.desk.run(changed)
            self.view.value = markup.view(self.desk, result)
        except (ValueError, OSError) as refusal:
            self.view.value = f'<p class="gl-problem" role="status">{escape(str(refusal))}</p>'
        self._show_controls()
        self._judge()

    def _show_controls(self):
        self._is_showing = True
        try:
            for shown in self.controls.values():
                shown.show()
        finally:
            self._is_showing = False

    def _judge(self):
        """Judge all goals that are shown; a goal once reached is kept."""
        if self.desk.result is None:
            return
        for name, widget in self._goals.items():
            goal = self.desk.lab.goal(name)
            widget.value = markup.goal(goal, self.desk.result)
            if goal.judge(self.desk.result)[0] and self._lesson.entry(name) is None:
                self._lesson.record(name, "goal", link_of(self._lesson.lesson, self.desk), is_right=True)


def _grid(boxes):
    return GridBox(boxes, layout=Layout(grid_template_columns=COLUMNS)).add_class("gl-controls")
