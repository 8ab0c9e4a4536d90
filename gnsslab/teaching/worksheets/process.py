"""The process in which a student's cells run: started by `worksheet_runs`, limited, and killed by it at any time.

It reads a job from stdin, runs the cells in order, and says on stdout, one JSON line each, which cell starts and what the
name `answer` was after it. Whatever the cells print goes nowhere. Only the standard library is used here.
"""

import json
import os
import sys

OTHER_PROGRAMS = ("os.fork", "os.forkpty", "os.posix_spawn", "os.spawn", "os.exec", "os.system", "os.startfile", "subprocess.Popen", "pty.spawn")
OTHER_PROCESSES = ("os.kill", "os.killpg")
LARGEST_FILE = 100_000_000  # [bytes]
SHOWN = 200  # characters of an answer or of an error that are handed on


def main():
    """Run the job of stdin and leave at once, whatever threads and exit functions the cells left behind."""
    job = json.load(sys.stdin)
    tell = _channel()
    _limit(job["seconds"], job["memory"])
    sys.addaudithook(_refuse)
    names = {"__name__": "__main__", "display": lambda *shown, **options: None}
    for place, source in job["cells"]:
        tell(start=place)
        tell(done=place, **_outcome(source, names))
    tell(end=True)
    os._exit(0)


def _channel():
    """Return a function that writes one message to what was stdout; stdin, stdout and stderr lead nowhere from here on."""
    nowhere = os.open(os.devnull, os.O_RDWR)
    messages = os.fdopen(os.dup(1), "w", encoding="utf-8")
    for standard in (0, 1, 2):
        os.dup2(nowhere, standard)

    def tell(dumps=json.dumps, **message):
        messages.write(dumps(message) + "\n")
        messages.flush()

    return tell


def _limit(seconds, memory):
    """Limit processor time [s], memory and files [bytes], where the system has such limits."""
    try:
        import resource
    except ImportError:  # Windows
        return
    for what, most in (("RLIMIT_CPU", seconds), ("RLIMIT_AS", memory), ("RLIMIT_FSIZE", LARGEST_FILE), ("RLIMIT_CORE", 0)):
        kind = getattr(resource, what)
        allowed = resource.getrlimit(kind)[1]
        most = most if allowed == resource.RLIM_INFINITY else min(most, allowed)
        resource.setrlimit(kind, (most, allowed))


def _refuse(event, arguments):
    """Refuse to start other programs and to end other processes; an OSError, as where the system forbids it."""
    if event in OTHER_PROGRAMS:
        raise PermissionError("a worksheet may not start other programs")
    if event in OTHER_PROCESSES:
        raise PermissionError("a worksheet may not end processes")


def _outcome(source, names):
    """Run a cell and return what `answer` is then, or what went wrong, as texts."""
    try:
        exec(_compiled(source), names)
        return {"answer": _text_of(names.get("answer")), "problem": ""}
    except BaseException as error:  # a cell that fails, exits or is interrupted does not stop the others
        return {"answer": "", "problem": f"{type(error).__name__}: {error}"[:SHOWN]}


def _compiled(source):
    """Return the cell compiled; lines for the notebook only, %magic and !command, are left out where Python knows no better."""
    try:
        return compile(source, "<cell>", "exec")
    except SyntaxError:
        lines = ["" if line.lstrip().startswith(("%", "!")) else line for line in source.splitlines()]
        return compile("\n".join(lines), "<cell>", "exec")


def _text_of(answer):
    """Return an answer as text: numbers as Python writes them, blank where there is none."""
    if answer is None or answer is Ellipsis:
        return ""
    if isinstance(answer, str):
        return answer[:SHOWN]
    number = answer.item() if getattr(answer, "size", 0) == 1 else answer  # an array of one number
    return repr(float(number)) if isinstance(number, (int, float)) and not isinstance(number, bool) else repr(answer)[:SHOWN]


if __name__ == "__main__":
    main()
