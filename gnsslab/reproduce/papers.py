"""Which papers there are, and which of them can be reproduced: a module each, with TITLE, ITEMS and `reproduce(seeds, progress)`."""

from importlib import import_module
from typing import NamedTuple

import numpy as np

from gnsslab.reproduce.rule import judged

PAPERS = "ABCDE"
MODULES = {"A": "gnsslab.reproduce.paper_a"}


class Picture(NamedTuple):
    """One figure of a paper, made again."""

    title: str
    words: str  # what it shows, for those who do not see it
    png: bytes


class Outcome(NamedTuple):
    """What a paper's module found."""

    numbers: dict[str, np.ndarray]  # key of an Item -> (seeds,)
    pictures: tuple[Picture, ...]
    notes: tuple[str, ...]  # sentences on the runs as a whole


class Reproduction(NamedTuple):
    """A paper's part of the report."""

    letter: str
    title: str
    lines: list[dict]  # of `rule.judged`
    pictures: tuple[Picture, ...]
    notes: tuple[str, ...]


def checked_letters(letters):
    """Return the letters of papers to reproduce, each once, all that there are where none is given.

    >>> checked_letters(["a", "A"])
    ('A',)
    """
    wanted = tuple(dict.fromkeys(letter.upper() for letter in letters)) or tuple(MODULES)
    for letter in wanted:
        if len(letter) != 1 or letter not in PAPERS:
            raise ValueError(f"there is no paper {letter!r}: expected letters of {', '.join(PAPERS)}")
        if letter not in MODULES:
            raise ValueError(f"paper {letter} cannot be reproduced yet: there is {', '.join(MODULES)}")
    return wanted


def reproduced(letter, seeds, progress=None):
    """Return the Reproduction of a paper with these seeds of random numbers; progress(done, total) is called on the way."""
    module = import_module(MODULES[letter])
    outcome = module.reproduce(seeds, progress)
    lines = [judged(letter, item, outcome.numbers[item.key]) for item in module.ITEMS]
    return Reproduction(letter, module.TITLE, lines, outcome.pictures, outcome.notes)
