"""The glossary's content: the words of the field in English and Chinese, each with its meaning in one plain sentence."""

import re
import tomllib
from dataclasses import dataclass
from functools import cache
from html import escape
from itertools import groupby
from pathlib import Path

from gnsslab.teaching.lesson_links import lesson_link

HERE = Path(__file__).parent


@dataclass(frozen=True)
class Term:
    """One word of the field."""

    english: str
    chinese: str  # simplified; several words, the usual one first, stand with commas between
    pinyin: str
    meaning: str  # one sentence
    lesson: str  # number of the lesson where it first matters

    @property
    def id(self):
        """Its address is /glossary#id.

        >>> Term("Kalman filter", "", "", "", "").id
        'kalman-filter'
        """
        return re.sub("[^a-z]+", "-", self.english.lower()).strip("-")

    @property
    def initial(self):
        """The letter under which it stands."""
        return self.english[0].upper()


@cache
def read_glossary():
    """Return the terms, a tuple in alphabetical order."""
    with open(HERE / "glossary.toml", "rb") as stream:
        return tuple(Term(**entry) for entry in tomllib.load(stream)["term"])


def glossary_body():
    """Return the content of the glossary."""
    letters = [(letter, "".join(map(_entry, terms))) for letter, terms in groupby(read_glossary(), lambda term: term.initial)]
    ways = "".join(f'<li><a href="#letter-{letter}">{letter}</a></li>' for letter, _ in letters)
    sections = "".join(f'<section><h2 id="letter-{letter}">{letter}</h2><dl>{entries}</dl></section>' for letter, entries in letters)
    return (
        '<div class="opening"><h1>Glossary</h1>'
        f'<p class="lead">{len(read_glossary())} words of the field, in English and <span lang="zh-Hans">中文</span>, each in one plain sentence. '
        f'The papers behind this course are Chinese.</p>{_FILTER}<ul class="ways letters">{ways}</ul></div>'
        f'<div class="glossary">{sections}</div><script>{(HERE / "glossary.js").read_text("utf-8")}</script>'
    )


_FILTER = (  # shown by the script, so that nobody meets a field that does nothing
    '<p class="filter" hidden><label for="filter">Find</label> '
    '<input id="filter" type="search" autocomplete="off" placeholder="baseline, 基线, jixian"> <span role="status"></span></p>'
)


def _entry(term):
    return (
        f'<div class="term" id="{term.id}"><dt><a href="#{term.id}">{escape(term.english)}</a> '
        f'<span lang="zh-Hans">{escape(term.chinese)}</span> <span class="pinyin" lang="zh-Latn">{escape(term.pinyin)}</span></dt>'
        f"<dd>{escape(term.meaning)} {lesson_link(term.lesson, f'Lesson {term.lesson}')}</dd></div>"
    )
