"""Files that are made here: RINEX from the RTCM 3 log beside it, where the registry has an address for the log only.

Such a file cannot have the registry's checksum, which is that of another program's conversion. Instead a `.json` beside
it says from which log it was made and what it was then: both checksums must still hold. That the values are those of
the other program is held by a test.
"""

import json

from gnsslab import __version__
from gnsslab.data.checksums import sha256_of


def make_converted(log, target):
    """Write the observations (`.obs`, `.obs.gz`) or the ephemerides (`.nav`) of an RTCM 3 log to the target, and its proof beside it."""
    from gnsslab.gnss.rinex import write_rinex_nav, write_rinex_obs
    from gnsslab.gnss.rtcm import read_rtcm

    content = read_rtcm(log)
    if target.name.endswith(".nav"):
        write_rinex_nav(target, content.ephemerides)
    else:
        write_rinex_obs(target, content.observations)
    proof = {"program": f"gnsslab {__version__}", "converted_from": log.name, "its_sha256": sha256_of(log), "sha256": sha256_of(target)}
    _proof(target).write_text(json.dumps(proof, indent=2) + "\n", encoding="utf-8")


def is_converted(target, log_sha256):
    """Return whether a file is as it was made here, from the log with this sha256."""
    try:
        proof = json.loads(_proof(target).read_text("utf-8"))
    except (OSError, ValueError):
        return False
    return isinstance(proof, dict) and proof.get("its_sha256") == log_sha256 and proof.get("sha256") == sha256_of(target)


def _proof(target):
    return target.with_name(f"{target.name}.json")
