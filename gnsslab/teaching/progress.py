"""What a student has answered: a journal in one small file, one JSON line an event, on the disk before the next step.

Nothing in the file is ever changed, so a crash costs at most the line that was being written. What stands for a question
now (the last answer, how many tries) is worked out from its events whenever it is asked for.
"""

import csv
import io
import json
import os
import re
from contextlib import suppress
from dataclasses import asdict, dataclass, fields
from datetime import UTC, datetime
from pathlib import Path

from gnsslab import __version__
from gnsslab.teaching.spreadsheets import harmless

try:
    import fcntl
except ImportError:  # Windows, where one process serves the course
    fcntl = None

KINDS = ("prediction", "question", "goal")
BROWSER_ID = re.compile(r"[0-9a-z][0-9a-z-]{7,63}")  # it names a file, so nothing else may stand in it


@dataclass(frozen=True)
class Entry:
    """What stands for one item of a lesson."""

    lesson: str  # "00"
    item: str  # name of the prediction, question or goal
    kind: str  # one of KINDS
    answer: str  # as typed or chosen last; "" where only a hint was asked for
    is_right: bool | None  # None: not judged
    tries: int  # different answers in a row
    hints: int  # seen so far
    solution_seen: bool
    time: str  # of the last event, UTC: "2026-03-02T09:15:00Z"


class Progress:
    """The answers of one student, kept in a file; with no path, in memory only.

    Where the file cannot be read or written the course goes on with what it remembers, and `problem` says so.
    """

    def __init__(self, path=None):
        self.path = None if path is None else Path(path)
        self.problem = ""
        self._unwritten = []  # lines that are in no file (yet)

    def entries(self):
        """Return what stands for each item, in the order in which they were first met."""
        standing = {}
        for event in _events([*self._written(), *self._unwritten]):
            place = event["lesson"], event["item"]
            standing[place] = _after(standing.get(place), event)
        return tuple(standing.values())

    def entry(self, lesson, item):
        """Return what stands for one item, or None."""
        return next((entry for entry in self.entries() if (entry.lesson, entry.item) == (lesson, item)), None)

    def record(self, lesson, item, kind, answer, is_right=None, hints=0, solution_seen=False):
        """Keep an answer. The same answer again is no new try; an empty one leaves the last answer standing."""
        if kind not in KINDS:
            raise ValueError(f"a kind of answer is one of {', '.join(KINDS)}; {kind!r} is none of them")
        event = {
            "lesson": lesson, "item": item, "kind": kind, "answer": answer,
            "is_right": is_right, "hints": hints, "solution_seen": solution_seen, "time": _now(),
        }  # fmt: skip
        before = self.entry(lesson, item)
        if before is None or _tells_more(before, event):
            self._append(json.dumps(event, ensure_ascii=False))

    def reset(self):
        """Begin anew; the old file stays beside the new one under the name of the day."""
        self._unwritten = []
        try:
            if self.path is not None and self.path.exists():
                self.path.rename(_free_name(self.path))
        except OSError as error:
            self.problem = _sentence("put away", self.path, error)

    def as_json(self):
        """Return all entries as JSON, with the version that made it."""
        return json.dumps({"made_by": f"gnsslab {__version__}", "entries": [asdict(entry) for entry in self.entries()]}, ensure_ascii=False, indent=1)

    def as_csv(self):
        """Return all entries as CSV, one row an item; what was not judged is an empty cell."""
        text = io.StringIO()
        table = csv.DictWriter(text, [field.name for field in fields(Entry)], lineterminator="\n")
        table.writeheader()
        table.writerows(asdict(entry) | {"answer": harmless(entry.answer)} for entry in self.entries())
        return text.getvalue()

    def _written(self):
        if self.path is None:
            return []
        try:
            return self.path.read_text("utf-8", errors="replace").split("\n")
        except FileNotFoundError:
            return []
        except OSError as error:
            self.problem = _sentence("read", self.path, error)
            return []

    def _append(self, line):
        self._unwritten.append(line)
        if self.path is None:
            return
        try:
            _append_lines(self.path, self._unwritten)
        except OSError as error:
            self.problem = _sentence("written", self.path, error)
        else:
            self._unwritten, self.problem = [], ""


def own_progress():
    """Return the progress of this machine's user: in the user's data folder, or in the folder that GNSSLAB_PROGRESS names."""
    return Progress(progress_folder() / "progress.jsonl")


def progress_of_browser(folder, browser_id):
    """Return the progress of one browser of a class, kept in the folder of the class."""
    if not BROWSER_ID.fullmatch(browser_id):
        raise ValueError(f"{browser_id!r} names no browser: expected 8 to 64 small letters, digits and hyphens")
    return Progress(Path(folder) / f"{browser_id}.jsonl")


def progress_folder():
    """Return the folder where progress is kept (it may not exist yet)."""
    if os.environ.get("GNSSLAB_PROGRESS"):
        return Path(os.environ["GNSSLAB_PROGRESS"])
    import platformdirs

    return platformdirs.user_data_path("gnsslab")


def _events(lines):
    """Return the events that the lines tell; a torn line, or one that somebody else wrote, tells none."""
    return [event for event in map(_event, lines) if event is not None]


def _event(line):
    try:
        event = json.loads(line)
    except (ValueError, RecursionError):
        return None
    is_ours = isinstance(event, dict) and all(type(event.get(name)) in types for name, types in _TYPES.items())
    return event if is_ours and event["kind"] in KINDS else None


_TYPES = dict.fromkeys(("lesson", "item", "kind", "answer", "time"), (str,)) | {
    "is_right": (bool, type(None)),
    "hints": (int,),
    "solution_seen": (bool,),
}


def _after(before, event):
    """Return what stands for an item after one more event."""
    last = before or Entry(event["lesson"], event["item"], event["kind"], "", None, 0, 0, False, "")
    is_try = event["answer"] not in ("", last.answer)
    return Entry(
        lesson=event["lesson"],
        item=event["item"],
        kind=event["kind"],
        answer=event["answer"] or last.answer,
        is_right=event["is_right"] if event["answer"] or event["is_right"] is not None else last.is_right,
        tries=last.tries + is_try,
        hints=max(last.hints, event["hints"]),
        solution_seen=last.solution_seen or event["solution_seen"],
        time=event["time"],
    )


def _tells_more(before, event):
    """Return whether an event changes what stands: cells of a lesson run again and again with the same answer."""
    now = _after(before, event)
    return asdict(now) | {"time": ""} != asdict(before) | {"time": ""}


def _append_lines(path, lines):
    """Add lines and wait until the disk has them. One write, at the end of the file: two processes do not tear each other's lines."""
    path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
    with open(path, "ab+") as file:
        _wait_for_others(file)
        text = ("" if _ends_whole(file) else "\n") + "".join(f"{line}\n" for line in lines)
        file.write(text.encode("utf-8"))
        file.flush()
        os.fsync(file.fileno())


def _wait_for_others(file):
    """Keep other processes from the file until it is closed: a line that is half written looks like one that a crash has torn."""
    if fcntl is not None:
        with suppress(OSError):  # a file system without locks: at worst an empty line, which readers pass over
            fcntl.flock(file, fcntl.LOCK_EX)


def _ends_whole(file):
    """Return whether a file is empty or ends with a whole line: after a crash it may not."""
    if file.seek(0, os.SEEK_END) == 0:
        return True
    file.seek(-1, os.SEEK_END)
    return file.read(1) == b"\n"


def _free_name(path):
    """Return a name beside the path that no file has: progress-until-20260302-091500.jsonl."""
    stem = f"{path.stem}-until-{datetime.now(UTC):%Y%m%d-%H%M%S}"
    names = (path.with_name(f"{stem}{more}{path.suffix}") for more in ("", *(f"-{n}" for n in range(2, 1000))))
    return next(name for name in names if not name.exists())


def _now():
    return datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%SZ")


def _sentence(done, path, error):
    return f"Your answers are kept only until you close this page: {path} could not be {done} ({error.strerror})."
