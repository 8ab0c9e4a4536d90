"""Controls: what a student can move in a lab, as data. A front end draws them; each checks its own range."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np


@dataclass(frozen=True)
class Slider:
    """A number from `start` to `stop` in steps; the unit is chosen so that values read as 0.1 to 1000."""

    name: str  # keyword of the lab's compute
    label: str
    start: float
    stop: float
    step: float
    default: float
    unit: str = ""
    help: str = ""
    more: bool = False  # shown under "more"

    def check(self, value):
        """Return the value as a number, or raise ValueError with the range in words.

        >>> Slider("code_noise", "code noise", 0.05, 1.5, 0.05, 0.3, "m").check(9)
        Traceback (most recent call last):
        ValueError: code noise 9 m is outside 0.05 to 1.5 m
        """
        if isinstance(value, bool) or not isinstance(value, (int, float, np.integer, np.floating)):
            raise ValueError(f"{self.label} is a number from {self.start:g} to {self.stop:g}{self._unit}, not {value!r}")
        if not self.start <= value <= self.stop:
            raise ValueError(f"{self.label} {value:g}{self._unit} is outside {self.start:g} to {self.stop:g}{self._unit}")
        return value

    def parse(self, text):
        """Return the value that stands in a link, whole numbers as int (a seed is one); raise ValueError in words.

        >>> Slider("length", "length", 0.3, 5, 0.1, 1.2, "m").parse("2.5")
        2.5
        """
        try:
            value = self.check(float(text))
            return int(value) if value == int(value) else value
        except ValueError:
            raise ValueError(f"{self.label} is a number from {self.start:g} to {self.stop:g}{self._unit}, not {text!r}") from None

    @property
    def _unit(self):
        return f" {self.unit}" if self.unit else ""

    @property
    def corners(self):
        """Values worth testing: both ends and the default."""
        return (self.start, self.default, self.stop)


@dataclass(frozen=True)
class Choice:
    """One of several named values; `options` maps what the student reads to what compute gets."""

    name: str
    label: str
    options: dict[str, object]
    default: object
    help: str = ""
    more: bool = False

    def check(self, value):
        """Return the value if it is one of the options.

        >>> Choice("frequencies", "frequencies", {"one": 1, "two": 2}, 2).check(5)
        Traceback (most recent call last):
        ValueError: frequencies 5 is none of 1, 2
        """
        if not any(value is known or value == known for known in self.options.values()):
            raise ValueError(f"{self.label} {value} is none of {', '.join(map(str, self.options.values()))}")
        return value

    def parse(self, text):
        """Return the value that stands in a link as its text; raise ValueError in words.

        >>> Choice("frequencies", "frequencies", {"one": 1, "two": 2}, 2).parse("1")
        1
        """
        for value in self.options.values():
            if text in (str(value), f"{value:g}" if isinstance(value, float) else ""):
                return value
        return self.check(text)

    def text_of(self, value):
        """Return what the student reads for a value."""
        return next(text for text, known in self.options.items() if known == value)

    @property
    def corners(self):
        """Every option."""
        return tuple(self.options.values())


@dataclass(frozen=True)
class Switch:
    """On or off."""

    name: str
    label: str
    default: bool = False
    help: str = ""
    more: bool = False

    def check(self, value):
        """Return the value if it is True or False.

        >>> Switch("single_epoch", "each epoch alone").check("yes")
        Traceback (most recent call last):
        ValueError: each epoch alone is on or off (True or False), not 'yes'
        """
        if not isinstance(value, (bool, np.bool_)):
            raise ValueError(f"{self.label} is on or off (True or False), not {value!r}")
        return bool(value)

    def parse(self, text):
        """Return the value that stands in a link as "True" or "False"; raise ValueError in words.

        >>> Switch("single_epoch", "each epoch alone").parse("True")
        True
        """
        return self.check({"True": True, "False": False}.get(text, text))

    @property
    def corners(self):
        """Off and on."""
        return (False, True)


@dataclass(frozen=True)
class FileOrPath:
    """A file of the student's own, uploaded or named by its path; empty until one is given."""

    name: str
    label: str
    default: str = ""
    help: str = ""
    more: bool = False

    def check(self, value):
        """Return the path as text; whether it can be read is the reader's to say.

        >>> FileOrPath("master_file", "master observations").check(7)
        Traceback (most recent call last):
        ValueError: master observations is the path of a file, not 7
        """
        if not isinstance(value, (str, Path)):
            raise ValueError(f"{self.label} is the path of a file, not {value!r}")
        return str(value)

    @property
    def corners(self):
        """Nothing given."""
        return (self.default,)


Control = Slider | Choice | Switch | FileOrPath
