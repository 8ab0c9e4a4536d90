"""Output files: found writable before the long work, and each with a `.json` beside it that says what made it."""

import json
import os
from pathlib import Path

PICTURES = (".png", ".svg", ".pdf")
AS_TYPED = {"start": "from", "end": "to"}  # options whose names on the command line are words of Python


def check_output(path, inputs=()):
    """Raise ValueError where a file cannot be written at `path`, or where that would overwrite an input."""
    if not str(path).strip():
        raise ValueError("the output has no name: give the name of a file after -o")
    path = Path(path)
    if path.is_dir():
        raise ValueError(f"the output {path} is a folder: give the name of a file in it")
    if not path.parent.is_dir():
        raise ValueError(f"the folder of the output {path} does not exist: create it first")
    if any(os.path.exists(path) and os.path.exists(file) and os.path.samefile(path, file) for file in inputs):
        raise ValueError(f"the output {path} is one of the inputs: give another name")
    _try_to_write(path)


def check_picture(path, inputs=()):
    """Raise ValueError where no picture can be written at `path`; None is well."""
    if path is None:
        return
    if Path(path).suffix.lower() not in PICTURES:
        raise ValueError(f"--plot {path}: expected a name that ends in {', '.join(PICTURES)}")
    check_output(path, inputs)


def check_folder(path):
    """Make the folder where it is missing; raise ValueError where files cannot be written in it."""
    if not str(path).strip():
        raise ValueError("the output folder has no name: give one after -o")
    try:
        Path(path).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ValueError(f"the output folder {path} cannot be made ({error.strerror}): give another name") from None
    _try_to_write(Path(path) / ".gnsslab-can-write")


def write_provenance(outputs, command, options, inputs=(), notes=(), method="", as_typed=AS_TYPED):
    """Write beside each output a file `OUTPUT.json`: version, command, options, the method in words if any, inputs with checksums, notes."""
    from gnsslab import __version__

    record = {
        "program": "gnsslab",
        "version": __version__,
        "command": command,
        "options": {as_typed.get(name, name.replace("_", "-")): value for name, value in options.items()},
        **({"method": method} if method else {}),
        "inputs": [input_record(path) for path in inputs],
        "notes": list(notes),
    }
    for output in outputs:
        text = json.dumps({"output": Path(output).name} | record, indent=2)
        Path(f"{output}.json").write_text(text + "\n", encoding="utf-8")


def input_record(path):
    """Return what identifies an input file: its name, size [bytes] and sha256."""
    from gnsslab.data.checksums import sha256_of

    return {"file": str(path), "bytes": os.path.getsize(path), "sha256": sha256_of(path)}


def _try_to_write(path):
    existed = path.exists()
    try:
        with open(path, "ab"):
            pass
    except OSError as error:
        raise ValueError(f"the output {path} cannot be written ({error.strerror}): give another name") from None
    if not existed:
        path.unlink()
