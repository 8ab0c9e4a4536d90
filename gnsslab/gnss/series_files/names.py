"""What the columns of a plain table mean, by their names: `time`, `east_m`, `dN(mm)`, `sigma_up_m`, `ratio`."""

import re
from typing import NamedTuple

AXES = ("east", "north", "up")
SIGMAS = ("sigma_east", "sigma_north", "sigma_up")
UNITS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3}

_AXIS_WORDS = {
    "east": ("east", "e", "easting", "de", "dx_east"),
    "north": ("north", "n", "northing", "dn"),
    "up": ("up", "u", "upward", "du", "vertical", "vert"),
    "height": ("height", "h", "hgt", "dh"),  # taken as up where no column is called up
}
_SIGMA_WORDS = ("sigma", "sig", "sd", "std", "stdev", "stddev", "error", "err", "uncertainty", "unc")
_OTHER_WORDS = {
    "time": ("time", "t", "epoch", "datetime", "timestamp", "date time", "time gps", "gps time", "time gpst", "gpst"),
    "time_utc": ("utc", "time utc", "utc time", "date time utc", "datetime utc"),
    "date": ("date", "day"),
    "clock": ("clock", "time of day", "tod"),
    "week": ("week", "gps week", "wn"),
    "tow": ("tow", "gps tow", "sow", "time of week", "gpst tow"),
    "mjd": ("mjd", "modified julian date"),
    "decimal_year": ("decimal year", "decyear", "dyear", "decimal date", "year"),
    "seconds": ("seconds", "sec", "s", "gps seconds", "time s", "t s"),
    "unix": ("unix", "unix time", "posix", "unix seconds"),
    "status": ("status", "quality", "q", "fix", "solution"),
    "ratio": ("ratio",),
}
_NOISE = {"d", "delta", "displacement", "disp", "baseline", "coordinate", "coord", "component", "position", "pos", "rel", "relative"}
_UNIT_WORDS = {"m": "m", "meter": "m", "meters": "m", "metre": "m", "metres": "m", "cm": "cm", "mm": "mm"}
_AXIS_OF = {word: axis for axis, words in _AXIS_WORDS.items() for word in words}
_SIGMA_OF = {prefix + letter: axis for prefix in ("sd", "sig", "std", "sigma") for letter, axis in zip("enu", AXES, strict=True)}
_OTHER_OF = {word: quantity for quantity, words in _OTHER_WORDS.items() for word in words}


class Meaning(NamedTuple):
    """What one column holds, and the unit its name states ("" where it states none)."""

    quantity: str
    unit: str


def meaning(name):
    """Return the Meaning of a column's name, None where it is none that is looked for.

    >>> meaning("dE (mm)"), meaning("sigma_up_m").quantity, meaning("satellites")
    (Meaning(quantity='east', unit='mm'), 'sigma_up', None)
    """
    words = re.findall(r"[a-z]+\d*", name.lower())
    if " ".join(words) in _OTHER_OF:
        return Meaning(_OTHER_OF[" ".join(words)], "")
    unit = _UNIT_WORDS[words.pop()] if len(words) > 1 and words[-1] in _UNIT_WORDS else ""
    is_sigma = any(word in _SIGMA_WORDS for word in words)
    words = [word for word in words if word not in _NOISE and word not in _SIGMA_WORDS] or words[:1]
    if len(words) != 1:
        return None
    if words[0] in _SIGMA_OF:
        return Meaning("sigma_" + _SIGMA_OF[words[0]], unit)
    axis = _AXIS_OF.get(words[0])
    return axis and Meaning(("sigma_" if is_sigma else "") + axis, unit)
