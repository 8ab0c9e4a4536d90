r"""Markdown with formulas as plain text for a terminal: no stars, no dollars, Greek and raised digits for their LaTeX."""

import re
from html.entities import html5
from textwrap import wrap

_SIGNS = {"cdot": "·", "circ": "°", "infty": "∞", "phi": "ϕ", "varepsilon": "ε", "sup": "sup"}  # where HTML's names are not LaTeX's
_RAISED = str.maketrans("0123456789+-T", "⁰¹²³⁴⁵⁶⁷⁸⁹⁺⁻ᵀ")
_FORMULA = re.compile(r"\$\$(.+?)\$\$|\$(.+?)\$", re.DOTALL)
_MARKDOWN = (  # pattern, what is left of it
    (re.compile(r"\[([^\]]*)\]\([^)]*\)"), r"\1"),  # a link: its text
    (re.compile(r"(\*\*|\*|`)(\S(?:.*?\S)?)\1"), r"\2"),
)
_LATEX = (  # innermost first: each is tried until nothing changes
    (re.compile(r"\\[td]?frac\{([^{}]*)\}\{([^{}]*)\}"), r"(\1)/(\2)"),
    (re.compile(r"\\[td]?frac(\d)(\d)"), r"\1/\2"),
    (re.compile(r"\\sqrt\{([^{}]*)\}"), r"√(\1)"),
    (re.compile(r"\\(?:operatorname|text|mathrm|mathbf|mathit|mathsf)\{([^{}]*)\}"), r"\1"),
    (re.compile(r"\\(?:hat|check|bar|dot|tilde|vec)\{?(\w)\}?"), r"\1"),
    (re.compile(r"_\{([^{}]*)\}"), r"_\1"),
    (re.compile(r"\^(?:([0-9T])|\{([0-9+-]+|T)\})"), lambda found: (found[1] or found[2]).translate(_RAISED)),
    (re.compile(r"\^\{([^{}]*)\}"), r"^(\1)"),
)
_SPACES = re.compile(r"\\(?:[ ,;:]|quad|qquad)|~")
_DROPPED = re.compile(r"\\(?:!|left|right|big|Big|displaystyle)|[{}]")
_COMMAND = re.compile(r"\\([A-Za-z]+)")


def plain(markdown):
    r"""Return a Markdown text with formulas as plain text.

    >>> plain(r"So $\cos\beta = \sqrt{e^2+n^2}$ is **small**, see [there](/notation).")
    'So cosβ = √(e²+n²) is small, see there.'
    """
    parts = _FORMULA.split(markdown)  # text, formula in $$ or None, formula in $ or None, text...
    texts = [_without_marks(text) for text in parts[::3]]
    formulas = [_of_formula(display or inline) for display, inline in zip(parts[1::3], parts[2::3], strict=True)]
    return "".join(text + formula for text, formula in zip(texts, [*formulas, ""], strict=True))


def wrapped(markdown, width, indent=""):
    """Return a Markdown text as plain lines, at most `width` characters long with their indent; paragraphs stay apart."""
    paragraphs = [wrap(plain(paragraph), width, initial_indent=indent, subsequent_indent=indent) for paragraph in markdown.split("\n\n")]
    return [line for paragraph in paragraphs for line in paragraph]


def _without_marks(text):
    for pattern, left in _MARKDOWN:
        text = pattern.sub(left, text)
    return text


def _of_formula(latex):
    text, before = _SPACES.sub(" ", latex), None
    while text != before:
        before = text
        for pattern, instead in _LATEX:
            text = pattern.sub(instead, text)
    return " ".join(_COMMAND.sub(_sign, _DROPPED.sub("", text)).split())


def _sign(found):
    """Return the sign of a LaTeX command, its name where it has none."""
    name = found[1]
    return _SIGNS.get(name) or html5.get(f"{name};", name)
