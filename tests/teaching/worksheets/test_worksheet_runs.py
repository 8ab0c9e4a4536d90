"""Students' cells run where they can be stopped: endless, deaf, forking, leaving, greedy, loud. Times are limits, never measured."""

import os
import subprocess
import sys
from time import monotonic, sleep

import pytest

from gnsslab.teaching.worksheets.runs import run_cells

SECONDS = 3.0
DEAF = """
import signal
for number in (signal.SIGINT, signal.SIGTERM):
    signal.signal(number, signal.SIG_IGN)
while True:
    try:
        while True: pass
    except BaseException:
        pass
"""
FORGED = """
import os
for way_out in range(3, 20):
    try:
        os.write(way_out, b{line!r})
    except OSError:
        pass
"""
GREEDY = "kept = []\nwhile True:\n    kept.append(bytearray(100_000_000))"
posix_only = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such limits")


def outcomes(*sources, seconds=60.0):
    """Run cells, the last of which must still be reached; return the others' outcomes."""
    *others, last = run_cells([*sources, "answer = 2 * 21"], seconds)
    assert (last.answer, last.problem) == ("42.0", "")
    return others


def test_cells_share_their_names():
    first, second, third = outcomes("import math", "answer = math.degrees(math.pi)", "answer = answer / 2")
    assert (first.answer, second.answer, third.answer) == ("", "180.0", "90.0")


@pytest.mark.parametrize(
    ("source", "answer"),
    [
        ("answer = 1", "1.0"),
        ("answer = '3 mm'", "3 mm"),
        ("answer = ...", ""),
        ("import numpy as np\nanswer = np.float32(0.5)", "0.5"),
        ("import numpy as np\nanswer = np.array([[2.5]])", "2.5"),
        ("answer = [1, 2]", "[1, 2]"),
        ("answer = True", "True"),
        ("answer = 'x' * 10_000", "x" * 200),
        ("%matplotlib inline\n!ls\nanswer = 7", "7.0"),
        ("x = 700\nanswer = (x\n  % 360)", "340.0"),  # a line that starts with % is a magic only where Python is at a loss
        ("import matplotlib.pyplot as plt\nplt.plot([1])\nplt.show()\ndisplay(plt.gcf())\nanswer = 1", "1.0"),
    ],
)
def test_answers_come_back_as_text(source, answer):
    (outcome,) = outcomes(source)
    assert (outcome.answer, outcome.problem) == (answer, "")


@pytest.mark.parametrize(
    ("source", "problem"),
    [
        ("1 / 0", "ZeroDivisionError: division by zero"),
        ("answer = 5 deg", "SyntaxError: "),
        ("import sys; sys.exit('done')", "SystemExit: done"),
        ("raise KeyboardInterrupt", "KeyboardInterrupt"),
        ("answer = float(input())", "EOFError"),
        ("def f(): f()\nf()", "RecursionError"),
        ("import os; os._exit(1)", "it ended the process"),
        ("import os; os.abort()", "it ended the process"),
        ("class Odd(Exception):\n    def __str__(self): raise Odd\nraise Odd", "it ended the process"),
        pytest.param("import os; os.fork()", "PermissionError: a worksheet may not start other programs", marks=posix_only),
        ("import subprocess; subprocess.run(['sleep', '60'])", "PermissionError: a worksheet may not start other programs"),
        ("import os, signal; os.kill(os.getppid(), signal.SIGTERM)", "PermissionError: a worksheet may not end processes"),
        pytest.param(GREEDY, "MemoryError", marks=posix_only),
    ],
)
def test_a_failing_cell_does_not_stop_the_others(source, problem):
    (outcome,) = outcomes(source)
    assert outcome.answer == ""
    assert outcome.problem.startswith(problem)


@pytest.mark.parametrize("line", ['{"done": 0}', "5", '{"done": 0, "answer": [1], "problem": ""}', "[" * 20_000])
def test_a_cell_that_writes_messages_of_its_own_is_left_out(line):
    (forger,) = outcomes(FORGED.replace("{line!r}", repr(line + "\n")))
    assert (forger.answer, forger.problem) == ("", "it ended the process")


@pytest.mark.parametrize("source", ["while True: pass", DEAF, "while True: print('x' * 10_000)", "import time\ntime.sleep(3600)"])
def test_an_endless_cell_is_stopped_and_the_others_go_on(source):
    before, endless = outcomes("answer = 1", source, seconds=SECONDS)
    assert before.answer == "1.0"
    assert endless.problem == f"stopped after {SECONDS / 2:.0f} s"


def test_the_whole_notebook_is_stopped():
    began = monotonic()
    *others, last = run_cells(["answer = 1", DEAF, DEAF, DEAF, "answer = 2"], SECONDS)
    assert monotonic() - began < 10 * SECONDS  # an order of magnitude for a busy machine: it would never end by itself
    assert others[0].answer == "1.0"
    assert last.problem.startswith("not run: ")


def test_no_cells_no_outcomes():
    assert run_cells([], SECONDS) == []


@posix_only
def test_nothing_is_left_running():
    """A fork behind Python's back stays in the group, and goes with it."""
    (forked,) = outcomes("import ctypes\nanswer = ctypes.CDLL(None).fork()\nif answer == 0:\n    while True: pass")
    child = int(float(forked.answer))
    assert child > 1
    deadline = monotonic() + 30
    while _state(child) not in ("", "Z"):  # gone, or dead and not yet collected; on a busy machine a killed process needs its turn to die
        assert monotonic() < deadline, "the fork is still running"
        sleep(0.05)


def _state(process):
    return subprocess.run(["ps", "-o", "state=", "-p", str(process)], capture_output=True, text=True, check=False).stdout.strip()


def test_cells_start_in_an_empty_folder_of_their_own(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    listed, written, progress = outcomes(
        "import os\nanswer = len(os.listdir())",
        "open('mine.txt', 'w').write('x')\nanswer = os.getcwd()",
        "answer = os.environ['GNSSLAB_PROGRESS']",
    )
    assert listed.answer == "0.0"
    assert not os.path.exists(written.answer)
    assert progress.answer == written.answer  # no student writes into the teacher's progress
    assert list(tmp_path.iterdir()) == []


def test_labs_run_in_a_worksheet():
    (outcome,) = outcomes("from gnsslab.labs.north import north_lab\nanswer = len(north_lab().run().attitude.status)")
    assert (outcome.answer, outcome.problem) == ("300.0", "")
