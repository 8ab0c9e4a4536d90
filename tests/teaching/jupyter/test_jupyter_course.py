"""The course as notebooks: what is copied, what is left alone, and who is refused."""

import importlib.util
import json

import pytest

from gnsslab.teaching.jupyter import command as jupyter_course
from gnsslab.teaching.jupyter.command import SETTINGS, copy_notebooks, serve_notebooks, words_of


@pytest.fixture
def lessons(tmp_path, monkeypatch):
    """A folder of lessons with two notebooks, in the place of the project's."""
    folder = tmp_path / "lessons" / "jupyter"
    folder.mkdir(parents=True)
    for name in ("00_a.ipynb", "01_b.ipynb"):
        (folder / name).write_text(f"first {name}")
    monkeypatch.setattr(jupyter_course, "project_folder", lambda name: tmp_path / name)
    return folder


@pytest.fixture
def own(tmp_path):
    """The student's folder, not there yet."""
    return tmp_path / "gnsslab-course"


def test_all_are_new_at_first_and_nothing_happens_the_second_time(lessons, own):
    assert copy_notebooks(own).new == ["00_a.ipynb", "01_b.ipynb"]
    assert (own / "00_a.ipynb").read_text() == "first 00_a.ipynb"
    assert copy_notebooks(own) == ([], [], [])


def test_a_new_lesson_is_added(lessons, own):
    copy_notebooks(own)
    (lessons / "02_c.ipynb").write_text("first")
    assert copy_notebooks(own) == (["02_c.ipynb"], [], [])


def test_what_the_student_left_alone_follows_the_course(lessons, own):
    copy_notebooks(own)
    (lessons / "00_a.ipynb").write_text("second")
    assert copy_notebooks(own) == ([], ["00_a.ipynb"], [])
    assert (own / "00_a.ipynb").read_text() == "second"


def test_what_the_student_changed_stays(lessons, own):
    copy_notebooks(own)
    (own / "00_a.ipynb").write_text("my work")
    assert copy_notebooks(own) == ([], [], []), "the course has nothing newer, so there is nothing to say"
    (lessons / "00_a.ipynb").write_text("second")
    for _ in range(2):
        assert copy_notebooks(own) == ([], [], ["00_a.ipynb"])
        assert (own / "00_a.ipynb").read_text() == "my work"
    assert "00_a.ipynb" in words_of(copy_notebooks(own))[0]


@pytest.mark.parametrize("record", [None, "{torn", "[1, 2]"])
def test_without_its_record_nothing_is_overwritten(lessons, own, record):
    copy_notebooks(own)
    (own / "00_a.ipynb").write_text("my work")
    place = own / ".gnsslab" / "copied.json"
    place.unlink() if record is None else place.write_text(record)
    assert copy_notebooks(own) == ([], [], ["00_a.ipynb"])
    assert (own / "00_a.ipynb").read_text() == "my work"


def test_a_notebook_that_was_deleted_comes_back(lessons, own):
    copy_notebooks(own)
    (own / "01_b.ipynb").unlink()
    assert copy_notebooks(own).new == ["01_b.ipynb"]


@pytest.mark.parametrize("host", ["0.0.0.0", "192.168.1.7", "::"])
def test_others_than_this_machine_are_refused_before_anything_is_written(host, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ValueError, match=f"this machine only, not for {host}"):
        serve_notebooks(host)
    assert list(tmp_path.iterdir()) == []


def test_missing_jupyterlab_is_said_in_words(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(ValueError, match="JupyterLab is not installed: type `pip install jupyterlab ipywidgets`"):
        serve_notebooks()
    assert list(tmp_path.iterdir()) == []


def test_jupyterlab_is_told_to_ask_nothing_of_the_network():
    overrides = json.loads((SETTINGS / "overrides.json").read_text("utf-8"))
    assert overrides["@jupyterlab/apputils-extension:notification"] == {"fetchNews": "false", "checkForUpdates": False}
    known = schema_names()
    assert known, "no schema of JupyterLab found"
    assert set(overrides) <= known


def schema_names():
    """Return the names of the settings that this JupyterLab knows."""
    from pathlib import Path

    import jupyterlab

    folder = Path(jupyterlab.__file__).parent / "schemas"
    return {f"{path.parent.relative_to(folder)}:{path.stem}" for path in folder.rglob("*.json")}
