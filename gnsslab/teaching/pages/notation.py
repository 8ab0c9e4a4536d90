"""The notation page's content: every symbol of the course once, with meaning, unit and the lesson where it first appears."""

import tomllib
from dataclasses import dataclass
from functools import cache
from html import escape
from pathlib import Path

from gnsslab.teaching.lesson_links import lesson_link
from gnsslab.teaching.pages.formulas import html_of


@dataclass(frozen=True)
class Use:
    """One thing that a symbol stands for."""

    meaning: str
    unit: str  # "-": a pure number, or none
    lesson: str  # number of the lesson where it first appears
    relation: str = ""  # a short equation, LaTeX


@dataclass(frozen=True)
class Symbol:
    """One symbol; where the field uses a letter for several things, it has several uses."""

    id: str  # its address is /notation#id
    latex: str
    uses: tuple[Use, ...]


@dataclass(frozen=True)
class Group:
    """Symbols that belong together."""

    name: str
    words: str  # one or two sentences
    symbols: tuple[Symbol, ...]


@cache
def read_notation():
    """Return the groups of symbols, a tuple."""
    with open(Path(__file__).with_name("notation.toml"), "rb") as stream:
        return tuple(_group(entry) for entry in tomllib.load(stream)["group"])


def all_symbols():
    """Return every symbol, in the order of the page."""
    return tuple(symbol for group in read_notation() for symbol in group.symbols)


def notation_body():
    """Return the content of the notation page."""
    groups = read_notation()
    ways = "".join(f'<li><a href="#{_anchor(group)}">{escape(group.name)}</a></li>' for group in groups)
    return (
        '<div class="opening"><h1>Notation</h1><p class="lead">Every symbol of the course, once. A bare letter is in metres, seconds and '
        "radians; a name in code wears any other unit (<code>heading_deg</code>). Each symbol has an address: click it.</p>"
        f'<ul class="ways">{ways}</ul></div>{"".join(map(_section, groups))}'
    )


def _section(group):
    rows = "".join(map(_rows, group.symbols))
    head = '<tr><th scope="col">Symbol</th><th scope="col">Meaning</th><th scope="col">Unit</th><th scope="col">Lesson</th></tr>'
    return (
        f'<section aria-labelledby="{_anchor(group)}"><h2 id="{_anchor(group)}">{escape(group.name)}</h2><p class="lead">{escape(group.words)}</p>'
        f'<table class="symbols"><thead>{head}</thead>{rows}</table></section>'
    )


def _rows(symbol):
    """Return one symbol as a body of table rows, one row a use."""
    name = f'<th scope="rowgroup" rowspan="{len(symbol.uses)}"><a class="formula" href="#{symbol.id}">{html_of(symbol.latex)}</a></th>'
    rows = "".join(f"<tr>{name * (k == 0)}{_cells(use)}</tr>" for k, use in enumerate(symbol.uses))
    return f'<tbody id="{symbol.id}">{rows}</tbody>'


def _cells(use):
    relation = f'<span class="relation formula">{html_of(use.relation)}</span>' if use.relation else ""
    return f"<td>{escape(use.meaning)}{relation}</td><td>{escape(use.unit)}</td><td>{lesson_link(use.lesson, use.lesson) or use.lesson}</td>"


def _anchor(group):
    return "about-" + group.name.lower().replace(" ", "-")


def _group(entry):
    return Group(entry["name"], entry["words"], tuple(_symbol(symbol) for symbol in entry["symbol"]))


def _symbol(entry):
    uses = (entry, *entry.get("also", ()))
    return Symbol(entry["id"], entry["latex"], tuple(Use(u["meaning"], u["unit"], u["lesson"], u.get("relation", "")) for u in uses))
