"""The twins run in a real kernel: no cell fails, and once there is a prediction each lab shows its pictures."""

import nbformat
import pytest
from nbclient import NotebookClient

from gnsslab.data.locations import project_folder
from gnsslab.teaching.catalogue import LESSONS
from gnsslab.teaching.jupyter.notebooks import twin_name
from gnsslab.teaching.steps import steps_of

PATIENCE = 300  # [s] a cell, the first compiles kernels
PREDICT = """
import asyncio
lesson.predict().options.value = {option!r}
for lab in ({labs},):
    while lab.desk.result is None:
        await asyncio.sleep(0.1)
"""


@pytest.fixture(params=LESSONS, ids=lambda lesson: lesson.number)
def lesson(request):
    """Each lesson of the course."""
    return request.param


@pytest.fixture
def run(lesson, tmp_path, monkeypatch):
    """A function that runs a lesson's twin, and one more cell where given, and returns it with its outputs."""
    monkeypatch.setenv("GNSSLAB_PROGRESS", str(tmp_path))

    def run(more=""):
        notebook = nbformat.read(project_folder("lessons") / "jupyter" / twin_name(lesson), 4)
        notebook.cells += [nbformat.v4.new_code_cell(more)] if more else []
        return NotebookClient(notebook, timeout=PATIENCE, kernel_name="python3", resources={"metadata": {"path": tmp_path}}).execute()

    return run


def test_no_cell_fails_and_every_widget_is_displayed(run):
    cells = [cell for cell in run().cells if cell.cell_type == "code"]
    outputs = [output for cell in cells for output in cell.outputs]
    assert [output for output in outputs if output.output_type in ("error", "stream")] == []
    displayed = [cell.source for cell in cells if any("application/vnd.jupyter.widget-view+json" in o.get("data", {}) for o in cell.outputs)]
    assert displayed == [cell.source for cell in cells[1:]]  # all but the opening


def test_each_lab_opens_with_its_pictures(run, lesson):
    shown = [step.variable for step in steps_of(lesson.path.read_text("utf-8")) if step.kind == "lab"]
    notebook = run(PREDICT.format(option=lesson.exercises.PREDICTION.options[0], labs=", ".join(shown)))
    widgets = notebook.metadata["widgets"]["application/vnd.jupyter.widget-state+json"]["state"].values()
    views = [text for widget in widgets if "gl-pictures" in (text := str(widget["state"].get("value"))) and not text.startswith("<style>")]
    labs = lesson.open_labs()
    assert len(views) == len(shown) == len(labs)
    assert sum(view.count("data:image/png;base64,") for view in views) == sum(len(lab.drawings()) for lab in labs.values())
