"""Symbols from LaTeX to HTML."""

import pytest

from gnsslab.teaching.pages.formulas import html_of


@pytest.mark.parametrize(
    ("latex", "html"),
    [
        ("P", "<i>P</i>"),
        (r"\Phi", "\N{GREEK CAPITAL LETTER PHI}"),  # capital Greek stands upright
        (r"\sigma_\psi", "<i>\N{GREEK SMALL LETTER SIGMA}</i><sub><i>\N{GREEK SMALL LETTER PSI}</i></sub>"),
        (r"\hat{b}", "<i>b\N{COMBINING CIRCUMFLEX ACCENT}</i>"),
        ("x^2", "<i>x</i><sup>2</sup>"),
        (r"P_r^s", '<i>P</i><span class="both"><sup><i>s</i></sup><sub><i>r</i></sub></span>'),
        (r"\mathrm{PDOP}", "PDOP"),
        ("a - b", "<i>a</i> \N{MINUS SIGN} <i>b</i>"),
        ("a = -b", "<i>a</i> = \N{MINUS SIGN}<i>b</i>"),
        ("Q^{-1}", "<i>Q</i><sup>\N{MINUS SIGN}1</sup>"),
        ("a < b", "<i>a</i>&lt;<i>b</i>"),
        (" b ", "<i>b</i>"),
    ],
)
def test_symbol_becomes_html(latex, html):
    assert html_of(latex) == html


@pytest.mark.parametrize("latex", [r"\nonsense", "a}", "a_", "{a", "_a", r"\hat"])
def test_what_is_not_understood_is_refused_with_the_symbol(latex):
    with pytest.raises(ValueError, match="the symbol") as refusal:
        html_of(latex)
    assert repr(latex) in str(refusal.value)
