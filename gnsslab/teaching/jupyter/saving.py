""" "Save this" in JupyterLab: the picture and its numbers as files beside the notebook, and the link that brings the controls back."""

from html import escape
from itertools import count
from pathlib import Path

from ipywidgets import HTML, Button, HBox, Layout

from gnsslab.teaching.saving import MIME_TYPES, link_of, saved

NOTHING = "There is no picture at the present controls, so there is nothing to save."


class SavingRow:
    """The button, and what it said last."""

    def __init__(self, lesson, desk):
        self._lesson = lesson
        self._desk = desk
        self.button = Button(description="Save this", tooltip="Picture as PNG and SVG, numbers as CSV, into the folder of this notebook")
        self.said = HTML()
        self.button.on_click(lambda _: self._save())
        self.box = HBox([self.button, self.said], layout=Layout(flex_flow="row wrap"))

    def _save(self):
        if self._desk.result is None or self._desk.result.problem:
            self.said.value = NOTHING
            return
        try:
            names = save_files(self._desk, Path.cwd())
        except OSError as error:
            self.said.value = escape(f"Nothing saved: {Path.cwd()} cannot be written ({error.strerror}).")
            return
        self.said.value = f"Saved {escape(', '.join(names))}. {self._way_back()}"

    def _way_back(self):
        link = link_of(self._lesson.lesson, self._desk).partition("?")[2]
        return f'All controls come back with <code>lesson.lab("{self._desk.lab.name}", "{escape(link)}")</code>'


def save_files(desk, folder):
    """Write the desk's picture and numbers into a folder, under names that no file has; return the names."""
    contents = {kind: saved(desk, kind) for kind in MIME_TYPES}
    stem = _free_stem(folder, desk.lab.name)
    for kind, content in contents.items():
        with open(folder / f"{stem}.{kind}", "xb") as file:
            file.write(content)
    return [f"{stem}.{kind}" for kind in contents]


def _free_stem(folder, name):
    """Return the name, or the name with the first number, under which no file of these kinds exists."""
    stems = (name if number == 1 else f"{name}-{number}" for number in count(1))
    return next(stem for stem in stems if not any((folder / f"{stem}.{kind}").exists() for kind in MIME_TYPES))
