"""The glossary: enough words, each whole, each once, in order."""

import re
import unicodedata

import pytest
from html_outline import Outline

from gnsslab.teaching.pages.glossary import read_glossary
from gnsslab.teaching.pages.pages import glossary_page

TERMS = read_glossary()
LESSONS_PLANNED = {f"{number:02d}" for number in range(12)}
LATIN = "Ratio"  # the one English word that Chinese texts keep
TONES = "\u0300\u0301\u0304\u030c"  # fourth, second, first and third; no syllable here is without


def test_there_are_enough_words():
    assert len(TERMS) >= 90


def test_words_stand_once_and_in_order():
    english = [term.english.lower() for term in TERMS]
    assert english == sorted(english)
    assert len(set(english)) == len(english)
    assert len({term.id for term in TERMS}) == len(TERMS)
    chinese = [word for term in TERMS for word in term.chinese.split(", ")]
    assert len(set(chinese)) == len(chinese)


@pytest.mark.parametrize("term", TERMS, ids=lambda term: term.id)
def test_word_is_whole(term):
    assert all(unicodedata.name(sign).startswith("CJK UNIFIED") for sign in term.chinese.replace(LATIN, "") if sign not in ", -")
    assert re.fullmatch(r"[A-Z0-9\"'].*\.", term.meaning)
    assert len(term.meaning) < 150
    assert term.lesson in LESSONS_PLANNED


@pytest.mark.parametrize("term", TERMS, ids=lambda term: term.id)
def test_pinyin_has_one_tone_a_sign(term):
    for chinese, pinyin in zip(term.chinese.split(", "), term.pinyin.split(", "), strict=True):
        signs = len(re.sub(f"{LATIN}|[ -]", "", chinese))
        assert sum(mark in TONES for mark in unicodedata.normalize("NFD", pinyin)) == signs


def test_words_the_course_cannot_do_without():
    expected = {
        "double difference": "\u53cc\u5dee",
        "integer ambiguity": "\u6574\u5468\u6a21\u7cca\u5ea6",
        "cycle slip": "\u5468\u8df3",
        "carrier phase": "\u8f7d\u6ce2\u76f8\u4f4d",
        "baseline": "\u57fa\u7ebf",
        "heading": "\u822a\u5411\u89d2",
    }
    found = {term.english: term.chinese for term in TERMS}
    assert {word: found[word] for word in expected} == expected


def test_page_marks_its_languages_and_hides_the_field_until_the_script_runs():
    outline = Outline(glossary_page())
    languages = [found.get("lang") for _, found in outline.elements]
    assert languages.count("zh-Hans") == len(TERMS) + 1  # and the word for Chinese itself
    assert languages.count("zh-Latn") == len(TERMS)
    assert ("p", {"class": "filter", "hidden": None}) in outline.elements
    assert outline.count("script") == 1
    assert {term.id for term in TERMS} <= set(outline.ids)
