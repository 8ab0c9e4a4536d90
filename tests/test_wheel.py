"""The wheel: built, installed into an empty environment, used in an empty folder."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

PROJECT = Path(__file__).resolve().parent.parent
MINUTES = 5 * 60  # [s] until a step counts as stuck
COMPILED = """
import numpy as np
from gnsslab.core import jit, kalman
S = np.array([[4.0, 2.0], [2.0, 10.0]])
kalman.factor_cholesky(S)
print(jit.COMPILED, np.tril(S).tolist())
"""


def call(*command, cwd, **more):
    """Run a program, with more in its environment, and return its stdout; fail with its stderr."""
    environment = {name: value for name, value in os.environ.items() if name not in ("VIRTUAL_ENV", "PYTHONPATH", "GNSSLAB_DATA_MIRROR")} | more
    done = subprocess.run([str(part) for part in command], cwd=cwd, env=environment, capture_output=True, text=True, timeout=MINUTES)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def uv():
    """The program uv, which builds and installs."""
    program = shutil.which("uv")
    if program is None:
        pytest.skip("uv is not installed: type `pip install uv`")
    return program


@pytest.fixture(scope="module")
def wheel(uv, tmp_path_factory):
    """The wheel of this checkout."""
    folder = tmp_path_factory.mktemp("dist")
    call(uv, "build", "--wheel", "--out-dir", folder, PROJECT, cwd=folder)
    (path,) = folder.glob("gnsslab-*.whl")
    return path


@pytest.fixture(scope="module")
def installed(uv, wheel, tmp_path_factory):
    """The folder of programs of an environment with the wheel and nothing else, versions as pinned."""
    folder = tmp_path_factory.mktemp("installed")
    pins = folder / "pins.txt"
    pins.write_text("\n".join(pinned()))
    call(uv, "venv", "--python", sys.executable, folder / "venv", cwd=folder)
    programs = folder / "venv" / ("Scripts" if os.name == "nt" else "bin")
    call(uv, "pip", "install", "--python", programs / "python", "--constraints", pins, wheel, cwd=folder)
    return programs


def pinned():
    import tomllib

    return tomllib.loads((PROJECT / "pyproject.toml").read_text("utf-8"))["tool"]["uv"]["constraint-dependencies"]


def test_the_wheel_is_small_and_holds_what_travels(wheel):
    import zipfile

    names = zipfile.ZipFile(wheel).namelist()
    assert "gnsslab/share/datasets/registry.toml" in names
    assert "gnsslab/share/datasets/cssrlib-078/SEPT078M.21P.gz" in names
    assert "gnsslab/share/lessons/pyproject.toml" in names
    assert any(name.startswith("gnsslab/share/lessons/00_") for name in names)
    assert {f"gnsslab/share/lessons/jupyter/{path.name}" for path in (PROJECT / "lessons" / "jupyter").glob("*.ipynb")} <= set(names)
    assert "gnsslab/teaching/jupyter/settings/overrides.json" in names
    assert not any(name.startswith("tests/") or "__pycache__" in name or "__marimo__" in name for name in names)
    assert wheel.stat().st_size < 1_250_000  # of which the data set is 200 kB: a second one would show


def test_the_installed_program_works_in_an_empty_folder(installed, tmp_path):
    import gnsslab
    from gnsslab.teaching.catalogue import LESSONS

    assert call(installed / "gnsslab", "--version", cwd=tmp_path) == f"gnsslab {gnsslab.__version__}\n"
    where = "from gnsslab.data.locations import project_folder as f; print(f('lessons')); print(f('datasets') / 'cssrlib-078')"
    lessons, data = map(Path, call(installed / "python", "-c", where, cwd=tmp_path).split("\n")[:2])
    assert PROJECT not in lessons.parents
    assert list(lessons.glob("00_*.py"))
    assert "60, one every 1 s" in call(installed / "gnsslab", "info", data / "SEPT078M1.21O.gz", cwd=tmp_path)
    assert f"{len(LESSONS)} lessons\n" in call(installed / "gnsslab", "doctor", cwd=tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_the_installed_engine_and_lesson_run_on_their_dependencies_alone(installed, tmp_path):
    """Kernels as ordinary Python, and one compiled: to compile all of them at a new place takes longer than all else here."""
    plain = {"GNSSLAB_NO_NUMBA": "1"}
    call(installed / "gnsslab", "simulate", "static-baseline", "-o", "roof", cwd=tmp_path, **plain)
    files = [f"roof/{name}" for name in ("master.obs", "rover.obs", "broadcast.nav")]
    answer = call(installed / "gnsslab", "heading", *files, "-o", "heading.csv", "--plot", "heading.png", "--systems", "G", cwd=tmp_path, **plain)
    assert answer.startswith("Attitude: 300 epochs")
    assert (tmp_path / "heading.png").stat().st_size > 10_000
    lesson = "from gnsslab.labs.north import north_lab; print(north_lab().run().problem or 'runs')"
    assert call(installed / "python", "-c", lesson, cwd=tmp_path, **plain) == "runs\n"
    assert call(installed / "python", "-c", COMPILED, cwd=tmp_path) == "True [[2.0, 0.0], [1.0, 3.0]]\n"
