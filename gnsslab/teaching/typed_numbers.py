"""Numbers as people type them: "0,14", "0.14°", "-3 mm", "1.2e-3"; what is not understood is said in words."""

import math
import re

_SIGNS = str.maketrans("\u2212\u2013\uff0d\uff0b\uff0c\uff0e", "---+,.")  # true minus, en dash, and the wide signs of a Chinese keyboard
_NUMBER = re.compile(
    r"(?P<sign>[+-]?) ?"
    r"(?P<digits>\d{1,3}(?: \d{3})+(?:[.,]\d*)?|\d+(?:[.,]\d*)?|[.,]\d+)"  # thousands in groups of three, as in SI
    r"(?P<exponent>[eE][+-]?\d+)? ?"
    r"(?P<unit>[^\d\s.,+*/^xX\u00d7\u00b7-].*)?"
)
_AMBIGUOUS = re.compile(r"[1-9]\d{0,2},\d{3}")  # 1,167 is 1.167 in one country and 1167 in another
_SHOWN = 30  # characters of what was typed that a sentence repeats
_SPELLINGS = {
    "deg": ("°", "degree", "degrees", "度"),
    "rad": ("radian", "radians"),
    "m": ("metre", "metres", "meter", "meters"),
    "mm": ("millimetre", "millimetres", "millimeter", "millimeters"),
    "cm": ("centimetre", "centimetres", "centimeter", "centimeters"),
    "km": ("kilometre", "kilometres", "kilometer", "kilometers"),
    "s": ("sec", "second", "seconds"),
    "cyc": ("cycle", "cycles"),
    "%": ("percent", "per cent"),
}
_UNITS = {spelling: unit for unit, spellings in _SPELLINGS.items() for spelling in spellings}


def read_number(text, unit):
    """Return the number that was typed, asked in `unit` ("" for a pure number); the unit may follow it.

    A decimal comma serves as well as a point; blanks may part thousands. Raises ValueError in words for what is no finite
    number, for a comma that may part thousands, and for another unit than the one asked: nothing is converted.

    >>> read_number("0,14 degrees", "deg"), read_number("-1 200", "m")
    (0.14, -1200.0)
    >>> read_number("14 mm", "m")
    Traceback (most recent call last):
    ValueError: the answer is asked in m, not in "mm": type it in m
    """
    text = " ".join(str(text).translate(_SIGNS).split())
    found = _NUMBER.fullmatch(text)
    if not text:
        raise ValueError("nothing is typed yet: type a number")
    if not found:
        raise ValueError(f'"{_shortened(text)}" is not understood: type one number, such as 12.5 or 1.25e-3')
    _check_comma(found)
    _check_unit(found["unit"], unit)
    value = float(found["sign"] + found["digits"].replace(" ", "").replace(",", ".") + (found["exponent"] or ""))
    if not math.isfinite(value):
        raise ValueError(f'"{_shortened(text)}" is larger than any number here')
    return value


def _check_comma(found):
    digits = found["digits"]
    if _AMBIGUOUS.fullmatch(digits) and not found["exponent"]:
        raise ValueError(f"{digits} can mean {digits.replace(',', '.')} or {digits.replace(',', '')}: type a point, or leave the comma out")


def _check_unit(typed, asked):
    """Raise ValueError where a unit was typed and is not the one asked."""
    if not typed or _same_spelling(typed) == _same_spelling(asked):
        return
    if not asked:
        raise ValueError(f'the answer is a pure number, without "{_shortened(typed)}"')
    raise ValueError(f'the answer is asked in {asked}, not in "{_shortened(typed)}": type it in {asked}')


def _same_spelling(unit):
    """Return a unit in one spelling.

    >>> _same_spelling("Degrees"), _same_spelling("m²")
    ('deg', 'm^2')
    """
    plain = unit.strip().casefold().replace("²", "^2").replace("**", "^")
    return _UNITS.get(plain, plain)


def _shortened(text):
    return text if len(text) <= _SHOWN else text[: _SHOWN - 3] + "..."
