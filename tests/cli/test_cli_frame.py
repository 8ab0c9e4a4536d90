"""The frame: help that fits a screen, exit status, quick start, what `course` and `simulate` refuse."""

import re
import subprocess
import sys

import pytest

import gnsslab
from gnsslab.cli import main

COMMANDS = (
    "course",
    "answers",
    "worksheet",
    "grade",
    "info",
    "heading",
    "rtk",
    "monitor",
    "convert",
    "simulate",
    "reproduce",
    "data",
    "data list",
    "data get",
    "data path",
    "data verify",
    "doctor",
)
SCREEN_LINES = 24
HEAVY = ("numpy", "matplotlib", "numba", "marimo", "pooch", "rich")


@pytest.mark.parametrize("columns", [80, 100])
@pytest.mark.parametrize("command", ["", *COMMANDS])
def test_help_fits_a_screen_and_has_an_example(run, monkeypatch, command, columns):
    monkeypatch.setenv("COLUMNS", str(columns))
    answer = run(*command.split(), "--help")
    lines = answer.out.splitlines()
    assert answer.status == 0
    assert len(lines) <= SCREEN_LINES
    assert max(map(len, lines)) <= columns
    assert re.search(f"Examples?: gnsslab {command}", answer.out)


def test_help_names_every_command(run):
    text = run("--help").out
    assert all(re.search(rf"^  {command} ", text, re.MULTILINE) for command in COMMANDS if " " not in command)


@pytest.mark.parametrize("arguments", [("--help",), ("heading", "--help"), ("--version",)])
def test_start_loads_nothing_heavy(arguments):
    code = f"import sys; from gnsslab.cli import main; main(sys.argv[1:]); sys.exit(' '.join(set(sys.modules) & set({HEAVY})))"
    done = subprocess.run([sys.executable, "-c", code, *arguments], capture_output=True, text=True)
    assert done.stderr.strip() == ""
    assert done.stdout


def test_the_program_itself():
    done = subprocess.run([sys.executable, "-m", "gnsslab", "--version"], capture_output=True, text=True)
    assert (done.returncode, done.stdout, done.stderr) == (0, f"gnsslab {gnsslab.__version__}\n", "")
    done = subprocess.run([sys.executable, "-m", "gnsslab", "info", "no-such-file.obs"], capture_output=True, text=True)
    assert (done.returncode, done.stdout, len(done.stderr.splitlines())) == (1, "", 1)


@pytest.mark.parametrize(
    "arguments",
    [
        ("nonsense",),
        ("--nonsense",),
        ("info",),
        ("info", "--nonsense", "a.obs"),
        ("heading", "a.obs", "b.obs", "-o", "x.csv"),
        ("heading", "a.obs", "b.obs", "c.nav"),
        ("heading", "a.obs", "b.obs", "c.nav", "-o", "x.csv", "--length", "long"),
        ("rtk", "a.obs", "b.obs", "c.nav", "-o", "x.csv", "--frequencies", "1.5"),
        ("simulate",),
        ("simulate", "turntable"),
        ("data", "get"),
        ("course", "--port", "eighty"),
    ],
)
def test_not_understood_is_status_2(run, arguments):
    answer = run(*arguments)
    assert answer.status == 2
    assert "Traceback" not in answer.err


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("course", "--port", "70000"), "port"),
        (("data", "get", "mars"), "there is no data set 'mars': expected one of cssrlib-078"),
        (("data", "path", "cssrlib-078", "x.obs"), "has no file 'x.obs'"),
        (("data", "verify", "mars"), "there is no data set"),
        (("simulate", "mars", "-o", "x"), "there is no preset 'mars'"),
    ],
)
def test_wrong_value_is_status_1_and_one_line(run, arguments, words):
    answer = run(*arguments)
    assert answer.status == 1
    assert len(answer.err.splitlines()) == 1
    assert words in answer.err


def test_a_mistake_of_ours_is_one_line_too(run, monkeypatch):
    def broken(path):
        raise ZeroDivisionError("division by zero")

    monkeypatch.setattr("gnsslab.cli.summaries.summary", broken)
    answer = run("info", "a.obs")
    assert answer.status == 1
    assert len(answer.err.splitlines()) == 1
    assert "ZeroDivisionError" in answer.err
    monkeypatch.setenv("GNSSLAB_TRACEBACK", "1")
    with pytest.raises(ZeroDivisionError):
        main(["info", "a.obs"])


def test_data_commands_on_the_travelling_set(run, monkeypatch, tmp_path):
    monkeypatch.delenv("GNSSLAB_DATA_MIRROR", raising=False)
    monkeypatch.setenv("GNSSLAB_CACHE", str(tmp_path))
    assert "cssrlib-078" in run("data", "list").out
    assert run("data", "verify", "cssrlib-078").status == 0
    assert run("data", "get", "cssrlib-078").out.strip() == str(tmp_path / "cssrlib-078")
    assert (tmp_path / "cssrlib-078" / "SEPT078M.21P").is_file()
    assert run("data", "path", "cssrlib-078", "SEPT078M.21P").out.strip() == str(tmp_path / "cssrlib-078" / "SEPT078M.21P")


def test_doctor_says_what_there_is(run):
    answer = run("doctor")
    assert answer.status == 0, answer.err
    for word in ("Python", "numpy", "numba", "lesson", "cache", "cssrlib-078"):
        assert word in answer.out
