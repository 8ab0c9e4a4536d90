r"""Symbols from LaTeX to plain HTML: italics, indices and hats, with no script and no font from elsewhere.

Understood is what symbols and short relations need: letters, Greek, indices, hats, upright words and a few signs.
"""

import re
from html import escape
from html.entities import html5
from unicodedata import normalize

ENTITIES = {
    ",": "thinsp",
    " ": "nbsp",
    "epsilon": "epsiv",
    "varepsilon": "epsilon",
    "phi": "straightphi",
    "varphi": "phi",
    "cdot": "middot",
}  # HTML's names, where not LaTeX's
ACCENTS = {"hat": "\u0302", "check": "\u030c", "bar": "\u0304", "dot": "\u0307", "tilde": "\u0303"}
SPACED = {"=": "=", "+": "+", "-": "\N{MINUS SIGN}", r"\sim": "\N{TILDE OPERATOR}"}
WORDS = ("mathrm", "text", "operatorname")  # their argument is set upright
_SIGN = re.compile("(^|= |\\(|<sup>) *(\N{MINUS SIGN}) ")  # a minus that takes nothing away from anything
_TOKEN = re.compile(r"\\[A-Za-z]+|\\.|[{}_^]|\s+|.")


def html_of(latex):
    r"""Return a symbol or a short relation as HTML; raise ValueError where it is not understood.

    >>> html_of(r"\hat a"), html_of(r"Q_{ba}")
    ('<i>â</i>', '<i>Q</i><sub><i>b</i><i>a</i></sub>')
    """
    rest = _TOKEN.findall(latex.strip())[::-1]  # the next token last, for pop()
    parts = []
    while rest:
        parts.append(_piece(rest, latex))
    return _SIGN.sub(r"\1\2", "".join(parts))


def _piece(rest, latex):
    """Take one atom with its indices and return it as HTML."""
    base, indices = _atom(rest, latex), {}
    while rest and rest[-1] in ("_", "^"):
        mark = rest.pop()
        indices[mark] = _atom(rest, latex)
    if len(indices) == 2:
        return f'{base}<span class="both"><sup>{indices["^"]}</sup><sub>{indices["_"]}</sub></span>'
    return base + "".join(f"<{_TAG[mark]}>{html}</{_TAG[mark]}>" for mark, html in indices.items())


_TAG = {"_": "sub", "^": "sup"}


def _atom(rest, latex):
    """Take one letter, sign, word or group and return it as HTML."""
    token = _next(rest, latex)
    name = token.lstrip("\\")
    if token == "{":
        return _group(rest, latex)
    if token.startswith("\\") and name in ACCENTS:
        return _accented(_atom(rest, latex), ACCENTS[name])
    if token.startswith("\\") and name in WORDS:
        return re.sub("</?i>", "", _atom(rest, latex))
    return _sign(token, name, latex)


def _next(rest, latex):
    while rest and rest[-1].isspace():
        rest.pop()
    if not rest:
        raise ValueError(f"the symbol {latex!r} ends too early")
    return rest.pop()


def _group(rest, latex):
    parts = []
    while rest and rest[-1] != "}":
        parts.append(_piece(rest, latex))
    _next(rest, latex)  # the brace
    return "".join(parts)


def _accented(html, accent):
    """Return the HTML of one letter with its accent."""
    return normalize("NFC", re.sub(r"(<i>)?(\w)(</i>)?$", rf"\1\2{accent}\3", html))


def _sign(token, name, latex):
    if token in SPACED:
        return f" {SPACED[token]} "
    letter = html5.get(f"{ENTITIES.get(name, name)};") if token.startswith("\\") else token
    if letter is None or token in "}_^":
        raise ValueError(f"{token} in the symbol {latex!r} is not understood")
    return f"<i>{letter}</i>" if letter.islower() or token.isalpha() else escape(letter)
