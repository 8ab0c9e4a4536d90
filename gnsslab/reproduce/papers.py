"""Which papers there are, and which of them can be reproduced: a module each, with TITLE, SEEDS, ITEMS and `reproduce(seeds, progress)`."""

from importlib import import_module
from typing import NamedTuple

import numpy as np

from gnsslab.reproduce.rule import judged, measured

PAPERS = "ABCDE"
MODULES = {"A": "gnsslab.reproduce.paper_a", "B": "gnsslab.reproduce.paper_b"}


class Picture(NamedTuple):
    """One figure of a paper, made again."""

    title: str
    words: str  # what it shows, for those who do not see it
    png: bytes


class Column(NamedTuple):
    """One quantity of a Table."""

    quantity: str
    unit: str
    is_share: bool = False  # or a count: its mean is told, not its median


class Table(NamedTuple):
    """Numbers of ours that no paper states: a row for each method, say, and a column for each quantity."""

    title: str
    words: str  # how they were found
    columns: tuple[Column, ...]
    rows: dict[str, tuple[np.ndarray, ...]]  # name -> for each column values (seeds,), NaN: never


class Outcome(NamedTuple):
    """What a paper's module found."""

    numbers: dict[str, np.ndarray]  # key of an Item -> (seeds,)
    pictures: tuple[Picture, ...]
    notes: tuple[str, ...]  # sentences on the runs as a whole
    tables: tuple[Table, ...] = ()


class Reproduction(NamedTuple):
    """A paper's part of the report."""

    letter: str
    title: str
    lines: list[dict]  # of `rule.judged`
    pictures: tuple[Picture, ...]
    notes: tuple[str, ...]
    tables: tuple[Table, ...] = ()

    @property
    def measured(self):
        """The numbers of the tables as lines of `rule.measured`."""
        return [line for table in self.tables for line in table_lines(self.letter, table)]


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


def usual_seeds(letter):
    """Return how many seeds a paper is reproduced with where nothing else is asked."""
    return import_module(MODULES[letter]).SEEDS


def reproduced(letter, seeds, progress=None):
    """Return the Reproduction of a paper with these seeds of random numbers; progress(done, total) is called on the way."""
    module = import_module(MODULES[letter])
    outcome = module.reproduce(seeds, progress)
    lines = [judged(letter, item, outcome.numbers[item.key]) for item in module.ITEMS]
    return Reproduction(letter, module.TITLE, lines, outcome.pictures, outcome.notes, outcome.tables)


def table_lines(letter, table):
    """Return the lines of a table, row by row."""
    return [
        measured(letter, f"{table.title}: {name}", column.quantity, column.unit, values)
        for name, row in table.rows.items()
        for column, values in zip(table.columns, row, strict=True)
    ]
