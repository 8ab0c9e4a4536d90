"""Progress: what was answered survives a crash, another process, a foreign line and a folder that cannot be written."""

import csv
import io
import json
import signal
import subprocess
import sys
from dataclasses import asdict, replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gnsslab.teaching.progress import KINDS, Entry, Progress, own_progress, progress_of_browser
from gnsslab.teaching.spreadsheets import harmless

ANSWERS = st.lists(st.tuples(st.sampled_from("abc"), st.text(max_size=12)), min_size=1, max_size=12)


@pytest.fixture
def progress(tmp_path):
    return Progress(tmp_path / "folder" / "progress.jsonl")


def test_an_answer_is_kept(progress):
    progress.record("00", "heading-of-a-beam", "question", "119,7", is_right=True)
    entry = Progress(progress.path).entry("00", "heading-of-a-beam")
    assert (entry.answer, entry.is_right, entry.tries, entry.hints, entry.solution_seen) == ("119,7", True, 1, 0, False)
    assert entry.time.endswith("Z")
    assert progress.problem == ""


def test_tries_are_counted_and_the_same_answer_is_no_new_try(progress):
    for answer in ("1", "1", "2", "1", "1"):
        progress.record("00", "beam", "question", answer, is_right=answer == "2")
    assert progress.entry("00", "beam").tries == 3
    assert progress.entry("00", "beam").is_right is False
    assert len(progress.path.read_text().splitlines()) == 3


def test_hints_and_the_solution_are_remembered_and_leave_the_answer_standing(progress):
    progress.record("00", "beam", "question", "7", is_right=False)
    progress.record("00", "beam", "question", "", hints=2)
    progress.record("00", "beam", "question", "", hints=1, solution_seen=True)
    entry = progress.entry("00", "beam")
    assert (entry.answer, entry.is_right, entry.tries, entry.hints, entry.solution_seen) == ("7", False, 1, 2, True)


def test_a_hint_before_any_answer_is_no_try(progress):
    progress.record("00", "beam", "question", "", hints=1)
    assert (progress.entry("00", "beam").tries, progress.entry("00", "beam").is_right) == (0, None)


def test_items_of_two_lessons_are_apart(progress):
    progress.record("00", "sharp", "goal", "reached", True)
    progress.record("01", "sharp", "goal", "reached", True)
    assert [entry.lesson for entry in progress.entries()] == ["00", "01"]
    assert progress.entry("02", "sharp") is None


@given(ANSWERS)
def test_file_and_memory_tell_the_same(tmp_path_factory, answers):
    kept, remembered = Progress(tmp_path_factory.mktemp("progress") / "p.jsonl"), Progress()
    for item, answer in answers:
        for progress in (kept, remembered):
            progress.record("00", item, "question", answer)
    assert [asdict(entry) | {"time": ""} for entry in kept.entries()] == [asdict(entry) | {"time": ""} for entry in remembered.entries()]
    for item, _ in answers:
        assert kept.entry("00", item).tries == _tries([answer for other, answer in answers if other == item])


def _tries(answers):
    """Count the changes of answer, the second way: by what is left when empty ones and repetitions are struck out."""
    given_ = [answer for answer in answers if answer]
    return sum(1 for k, answer in enumerate(given_) if k == 0 or answer != given_[k - 1])


def test_an_unknown_kind_is_refused(progress):
    with pytest.raises(ValueError, match="prediction, question, goal; 'exam' is none"):
        progress.record("00", "beam", "exam", "1")


def test_a_torn_last_line_costs_only_itself(progress):
    progress.record("00", "first", "question", "1")
    progress.record("00", "second", "question", "2")
    whole = progress.path.read_bytes()
    for end in range(len(whole) - 1, whole.index(b"\n") + 1, -1):
        progress.path.write_bytes(whole[:end])
        assert progress.entry("00", "first").answer == "1"
        progress.record("00", "third", "question", "3")
        assert progress.entry("00", "third").answer == "3"


@pytest.mark.parametrize(
    "line",
    [
        "",
        "no JSON",
        "[]",
        "[" * 100_000,
        "null",
        "17",
        '{"lesson": "00"}',
        "\x00\x00",
        '{"lesson": 0, "item": "a", "kind": "goal", "answer": "", "is_right": null}',
    ],
)
def test_foreign_lines_are_passed_over(progress, line):
    progress.record("00", "first", "question", "1")
    with open(progress.path, "a") as file:
        file.write(line + "\n")
    progress.record("00", "last", "question", "2")
    assert [entry.item for entry in progress.entries()] == ["first", "last"]


def test_bytes_that_are_no_text_are_passed_over(progress):
    progress.record("00", "first", "question", "1")
    with open(progress.path, "ab") as file:
        file.write(b"\xff\xfe\x80 torn")
    progress.record("00", "last", "question", "2")
    assert [entry.item for entry in progress.entries()] == ["first", "last"]


_WRITER = """
import sys
from gnsslab.teaching.progress import Progress
progress = Progress(sys.argv[1])
for n in range(int(sys.argv[3])):
    progress.record("00", f"{sys.argv[2]}-{n}", "question", "long " * 50)
    print(n, flush=True)
"""


def _writer(path, name, count):
    return subprocess.Popen([sys.executable, "-c", _WRITER, str(path), name, str(count)], stdout=subprocess.PIPE, text=True)


def test_two_processes_append_at_once(progress):
    writers = [_writer(progress.path, name, 100) for name in "ab"]
    for writer in writers:
        writer.communicate(timeout=60)
        assert writer.returncode == 0
    assert {entry.item for entry in progress.entries()} == {f"{name}-{n}" for name in "ab" for n in range(100)}
    assert len(progress.path.read_text().splitlines()) == 200


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="this system cannot kill a process in mid-write")
def test_a_killed_process_loses_nothing_that_it_said_was_kept(progress):
    with _writer(progress.path, "a", 100_000) as writer:
        said = [writer.stdout.readline() for _ in range(20)]
        writer.send_signal(signal.SIGKILL)
        said += writer.stdout.readlines()
    kept = {entry.item for entry in Progress(progress.path).entries()}
    assert len(said) >= 20
    assert {f"a-{n.strip()}" for n in said if n.endswith("\n")} <= kept


def test_reset_keeps_the_old_file_beside(progress):
    for answer in ("1", "2", "3"):
        progress.record("00", "beam", "question", answer)
        progress.reset()
        assert progress.entries() == ()
    old = sorted(progress.path.parent.iterdir())
    assert sorted(Progress(path).entry("00", "beam").answer for path in old) == ["1", "2", "3"]
    assert all("-until-" in path.name for path in old)


def test_reset_of_nothing_is_nothing(progress):
    progress.reset()
    assert (progress.entries(), progress.problem) == ((), "")
    memory = Progress()
    memory.record("00", "beam", "question", "1")
    memory.reset()
    assert memory.entries() == ()


TRICKY = ('a "quote", a comma', "two\nlines", "角度 0,14°", "=1+1")


def test_json_and_csv_bring_back_the_same_entries(progress):
    for n, answer in enumerate(TRICKY):
        progress.record("00", f"item {n}", KINDS[n % 3], answer, is_right=(None, True, False)[n % 3], hints=n)
    entries = progress.entries()
    assert len(entries) == len(TRICKY)
    assert tuple(Entry(**row) for row in json.loads(progress.as_json())["entries"]) == entries
    safe = tuple(replace(entry, answer=harmless(entry.answer)) for entry in entries)
    assert tuple(_from_csv(row) for row in csv.DictReader(io.StringIO(progress.as_csv()))) == safe


def _from_csv(row):
    truth = {"True": True, "False": False, "": None}
    judged = {name: truth[row[name]] for name in ("is_right", "solution_seen")}
    return Entry(**row | judged | {name: int(row[name]) for name in ("tries", "hints")})


def test_a_folder_that_cannot_be_written_costs_a_sentence_only(tmp_path):
    (tmp_path / "file").write_text("no folder")
    progress = Progress(tmp_path / "file" / "progress.jsonl")
    progress.record("00", "beam", "question", "1", is_right=True)
    assert progress.entry("00", "beam").is_right
    assert "could not be written" in progress.problem or "could not be read" in progress.problem
    (tmp_path / "file").unlink()
    progress.record("00", "next", "question", "2")
    assert [entry.item for entry in Progress(progress.path).entries()] == ["beam", "next"]
    assert progress.problem == ""


def test_a_file_that_is_none_costs_a_sentence_only(progress):
    progress.path.mkdir(parents=True)
    progress.record("00", "beam", "question", "1")
    assert progress.entry("00", "beam").answer == "1"
    assert str(progress.path) in progress.problem


def test_own_progress_lies_where_the_variable_says(tmp_path, monkeypatch):
    monkeypatch.setenv("GNSSLAB_PROGRESS", str(tmp_path))
    own_progress().record("00", "beam", "question", "1")
    assert (tmp_path / "progress.jsonl").is_file()
    monkeypatch.delenv("GNSSLAB_PROGRESS")
    assert own_progress().path.parent.name == "gnsslab"


def test_browsers_are_apart(tmp_path):
    first, second = (progress_of_browser(tmp_path, f"browser-{n}") for n in (1, 2))
    first.record("00", "beam", "question", "1")
    assert second.entries() == ()


@pytest.mark.parametrize("browser", ["", "../../etc/passwd", "a/b-c-d-e-f", "UPPER-CASE", "x" * 65, "abcdefgh\n"])
def test_an_id_that_names_no_browser_is_refused(tmp_path, browser):
    with pytest.raises(ValueError, match="names no browser"):
        progress_of_browser(tmp_path, browser)
