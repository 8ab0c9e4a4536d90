"""Write the newest versions that resolve together into [tool.uv] constraint-dependencies of pyproject.toml.

    python tools/pins.py            # resolve anew, write, and check Python 3.11 to 3.14
    python tools/pins.py --check    # only check that the versions written down resolve for each Python

Needs uv and the package index it is set up for; nothing of the index is written down.
"""

import re
import subprocess
import sys
import tempfile
from pathlib import Path

PROJECT = Path(__file__).resolve().parent.parent / "pyproject.toml"
PYTHONS = ("3.11", "3.12", "3.13", "3.14")
LIST = re.compile(r"^constraint-dependencies = \[\n.*?^\]\n", re.MULTILINE | re.DOTALL)
GROUPS = ("--group", "dev", "--group", "benchmarks")


def main():
    if "--check" not in sys.argv[1:]:
        PROJECT.write_text(with_pins(PROJECT.read_text(), resolve()))
    for python in PYTHONS:
        count = len(compiled(PROJECT.parent, "--python-version", python))
        print(f"Python {python}: {count} packages resolve")


def resolve():
    """Return the lines `name==version ; marker` that hold for all Pythons and systems, from a project without pins."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "pyproject.toml").write_text(with_pins(PROJECT.read_text(), []))
        return compiled(folder, "--universal", "--python-version", PYTHONS[0])


def compiled(folder, *options):
    command = ["uv", "pip", "compile", "-q", "pyproject.toml", *GROUPS, "--no-annotate", "--no-header", *options]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    if done.returncode:
        sys.exit(done.stderr)
    return [line for line in done.stdout.splitlines() if "==" in line]


def with_pins(text, pins):
    """Return the project file's text with another list of pins."""
    new = "constraint-dependencies = [\n" + "".join(f'    "{pin}",\n' for pin in pins) + "]\n"
    text, count = LIST.subn(lambda _: new, text)
    if count != 1:
        sys.exit(f"{PROJECT} has {count} lists `constraint-dependencies`: expected one")
    return text


if __name__ == "__main__":
    main()
