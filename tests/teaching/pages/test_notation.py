"""The notation page: every symbol once, and none of the lessons' symbols missing."""

import re
from html.entities import html5

import pytest
from html_outline import Outline

from gnsslab.teaching.catalogue import LESSONS
from gnsslab.teaching.pages.formulas import ENTITIES
from gnsslab.teaching.pages.notation import all_symbols, read_notation
from gnsslab.teaching.pages.pages import notation_page

SYMBOLS = all_symbols()
USES = [(symbol, use) for symbol in SYMBOLS for use in symbol.uses]
LESSONS_PLANNED = {f"{number:02d}" for number in range(12)} | {"-"}

FORMULA = re.compile(r"\$\$(.+?)\$\$|(?<!\\)\$([^$\n]+?)\$", re.DOTALL)
CODE = re.compile(r"```.*?```|`[^`\n]+`", re.DOTALL)
WORDS = re.compile(r"\\(?:text|mathrm|operatorname|begin|end|mathbf)\s*\{([^{}]*)\}")
INDEX = r"(?:\{\s*\\mathsf\s*\{?T\}?\s*\}|\{[^{}]*\}|\\[A-Za-z]+|[A-Za-z0-9])"
LETTER = r"dt(?=[_^])|\\[A-Za-z]+|[A-Za-z]"
SYMBOL = re.compile(
    rf"(?:\\(?P<accent>hat|check|bar|dot|tilde)\s*(?:\{{\s*(?P<braced>{LETTER})\s*\}}|(?P<bare>{LETTER}))|(?P<plain>{LETTER}))"
    rf"(?P<indices>(?:\s*[_^]\s*{INDEX})*)"
)
ONE_SATELLITE = {"i", "j", "s", "m"}
WHOLE = {r"\sigma", "Q"}  # of these the index says what is meant: each needs an entry of its own


def formulas_in(text):
    """Return the formulas of a Markdown text."""
    return [first or second for first, second in FORMULA.findall(CODE.sub("", text))]


def symbols_in(formula):
    """Return the symbols of a formula as (accent, letter, indices): indices without powers, transposes, words and digits."""
    found = [_symbol(match) for match in SYMBOL.finditer(WORDS.sub(_abbreviation, formula))]
    return [symbol for symbol in found if symbol is not None]


def _abbreviation(match):
    """Words in a formula are no symbols, but for those that the page has: el, az, PDOP."""
    return rf"\ABBR{match[1]} " if match[1] in ABBREVIATIONS else " "


def _symbol(match):
    letter = match["braced"] or match["bare"] or match["plain"]
    if letter.startswith("\\") and not (_is_letter(letter[1:]) or letter.startswith(r"\ABBR")):
        return None  # a command: \frac, \left, \cos
    below = re.findall(rf"_\s*({INDEX})", match["indices"])
    above = [index for index in re.findall(rf"\^\s*({INDEX})", match["indices"]) if not _is_power(index)]
    letters = re.findall(r"\\[A-Za-z]+|[A-Za-z]{3,}|[A-Za-z]", " ".join(below + above))
    return match["accent"] or "", letter, tuple(index for index in letters if index[0] == "\\" or len(index) < 3)  # ion, trop: words


def _is_letter(name):
    return html5.get(f"{ENTITIES.get(name, name)};", "").isalpha() or name == "nabla"


def _is_power(index):
    return re.fullmatch(r"\{?\s*(-?\d+.*|T|\\mathsf\s*\{?T\}?|\\top)\s*\}?", index) is not None


ABBREVIATIONS = {re.sub(r"\\mathrm\{(.*)\}", r"\1", symbol.latex) for symbol in SYMBOLS if symbol.latex.startswith(r"\mathrm")}
ON_PAGE = {found for symbol in SYMBOLS for found in symbols_in(symbol.latex)}


def is_on_page(symbol):
    """Whether a symbol stands on the page, either whole, or its letter and each letter of its indices."""
    accent, letter, indices = symbol
    if symbol in ON_PAGE:
        return True
    if letter == r"\sigma" and len(indices) == 1 and indices[0] in ONE_SATELLITE:
        return ("", r"\sigma", ("i",)) in ON_PAGE
    if accent == "dot":  # a rate of change: the dot stands on the page by itself
        return ("dot", "x", ()) in ON_PAGE and is_on_page(("", letter, indices))
    return letter not in WHOLE and (accent, letter, ()) in ON_PAGE and all(("", index, ()) in ON_PAGE for index in indices)


def words_of(lesson):
    """Return all texts of a lesson: its file, its prediction and its questions."""
    asked = lesson.exercises
    texts = [lesson.path.read_text("utf-8"), asked.PREDICTION.text, *asked.PREDICTION.options]
    for question in asked.QUESTIONS:
        texts += [question.text, *question.hints, question.solution, *(mistake.words for mistake in question.mistakes)]
    return "\n\n".join(texts)


def test_scanner_finds_symbols_and_nothing_else():
    assert symbols_in(r"\sigma_\psi^2 = \frac{\cos^2\!\psi\,\sigma_{en}}{\ell}") == [
        ("", r"\sigma", (r"\psi",)),
        ("", r"\psi", ()),
        ("", r"\sigma", ("e", "n")),
        ("", r"\ell", ()),
    ]
    assert symbols_in(r"Q_y = 2 D \operatorname{diag}(\sigma^2) D^\top") == [("", "Q", ("y",)), ("", "D", ()), ("", r"\sigma", ()), ("", "D", ())]
    assert symbols_in(r"\hat{a} - \check b + c\,dt_r") == [("hat", "a", ()), ("check", "b", ()), ("", "c", ()), ("", "dt", ("r",))]
    assert formulas_in("a price of \\$3, `$HOME`, $x$ and\n$$y$$") == ["x", "y"]


def test_page_knows_what_is_missing():
    assert is_on_page(("", r"\sigma", (r"\psi",)))
    assert is_on_page(("", r"\Phi", ("r", "s")))
    assert not is_on_page(("", r"\sigma", (r"\omega",)))
    assert not is_on_page(("", r"\xi", ()))


@pytest.mark.parametrize("lesson", LESSONS, ids=lambda lesson: lesson.number)
def test_every_symbol_of_a_lesson_stands_on_the_page(lesson):
    found = {symbol for formula in formulas_in(words_of(lesson)) for symbol in symbols_in(formula)}
    assert len(found) > 5
    assert sorted(symbol for symbol in found if not is_on_page(symbol)) == []


@pytest.mark.parametrize("lesson", LESSONS, ids=lambda lesson: lesson.number)
def test_symbols_said_to_begin_in_a_lesson_are_in_it(lesson):
    text = words_of(lesson)
    found = {symbol for formula in formulas_in(text) for symbol in symbols_in(formula)}
    begun = {symbol.id: symbols_in(symbol.latex) for symbol, use in USES if use.lesson == lesson.number}
    assert {name for name, symbol in begun.items() if symbol and not _is_among(symbol[0], found, text)} == set()


def _is_among(symbol, found, text):
    """Whether a symbol of the page occurs: as it is, as a word (PDOP), or as a letter, with any index or as one."""
    accent, letter, indices = symbol
    if accent or indices or letter in WHOLE:
        return symbol in found or (accent == "dot" and any(other[0] == "dot" for other in found))
    return letter.removeprefix(r"\ABBR") in text if letter.startswith(r"\ABBR") else any(letter in (other[1], *other[2]) for other in found)


@pytest.mark.parametrize("lesson", LESSONS, ids=lambda lesson: lesson.number)
def test_links_from_lessons_lead_to_a_symbol(lesson):
    linked = set(re.findall(r"/notation#([\w-]+)", words_of(lesson)))
    assert linked <= set(Outline(notation_page()).ids)


def test_symbols_stand_once():
    assert len({symbol.latex for symbol in SYMBOLS}) == len(SYMBOLS)
    assert len({symbol.id for symbol in SYMBOLS}) == len(SYMBOLS)
    assert len({use.meaning for _, use in USES}) == len(USES)


def test_ids_are_as_code_would_name_them():
    assert all(re.fullmatch("[A-Za-z][A-Za-z0-9_]*", symbol.id) for symbol in SYMBOLS)
    by_id = {symbol.id: symbol.latex for symbol in SYMBOLS}
    assert (by_id["sigma_phi"], by_id["a_hat"], by_id["Phi"]) == (r"\sigma_\phi", r"\hat a", r"\Phi")


@pytest.mark.parametrize(("symbol", "use"), USES, ids=lambda part: getattr(part, "id", ""))
def test_use_is_whole(symbol, use):
    assert use.meaning
    assert use.unit == "-" or re.search("[a-zA-Z]", use.unit)
    assert use.lesson in LESSONS_PLANNED
    assert {found for found in symbols_in(use.relation) if not is_on_page(found)} == set()


def test_page_shows_every_symbol_in_its_group():
    outline = Outline(notation_page())
    assert {symbol.id for symbol in SYMBOLS} <= set(outline.ids)
    assert [group.name for group in read_notation()] == [
        "Measurements",
        "Geometry",
        "Differences",
        "Ambiguities",
        "Statistics",
        "Attitude",
        "Frames and shapes",
    ]
    assert sum(tag == "tbody" for tag, _ in outline.elements) == len(SYMBOLS)
