"""Writing a file whole or not at all."""

import os
from pathlib import Path

from gnsslab.gnss.rinex.errors import RinexError


def write_atomically(path, text):
    """Write ASCII text to a file beside the target and move it there when complete: no reader meets half a file.

    Raises RinexError with the system's reason where the place cannot be written; an older file then stays as it was.
    """
    target = Path(path)
    part = target.with_name(f".{target.name}.{os.getpid()}.part")
    try:
        part.write_bytes(text.encode("ascii"))
        os.replace(part, target)
    except OSError as error:
        raise RinexError(path, f"the file cannot be written ({error.strerror or error})") from None
    finally:
        part.unlink(missing_ok=True)
