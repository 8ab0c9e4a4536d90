"""Numbers as people type them."""

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gnsslab.teaching.typed_numbers import read_number


@pytest.mark.parametrize(
    ("typed", "unit", "value"),
    [
        ("0,14", "deg", 0.14),
        ("0.14", "", 0.14),
        ("0.14 deg", "deg", 0.14),
        ("0.14°", "deg", 0.14),
        ("119.7 Degrees", "deg", 119.7),
        ("1.2e-3", "m", 1.2e-3),
        ("1,2E-3 m", "m", 1.2e-3),
        ("\u22123", "mm", -3.0),  # true minus
        ("- 3 mm", "mm", -3.0),
        ("+.5", "", 0.5),
        ("5.", "", 5.0),
        ("  7  ", "m", 7.0),
        ("1 000", "m", 1000.0),
        ("12\u202f345,6 m", "m", 12_345.6),  # narrow no-break space, as French and SI print it
        ("\uff11\uff12\uff0e\uff15", "deg", 12.5),  # wide digits and point of a Chinese keyboard
        ("\uff0d3\uff0c5", "m", -3.5),
        ("0,140", "deg", 0.14),
        ("36 mm²", "mm^2", 36.0),
        ("3.4meters", "m", 3.4),
        ("2 cycles", "cyc", 2.0),
        ("95%", "%", 95.0),
    ],
)
def test_what_is_understood(typed, unit, value):
    assert read_number(typed, unit) == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize(
    ("typed", "unit", "words"),
    [
        ("", "m", "nothing is typed yet"),
        ("   ", "m", "nothing is typed yet"),
        ("nan", "m", '"nan" is not understood'),
        ("-inf", "m", '"-inf" is not understood'),
        ("about three", "m", "is not understood: type one number"),
        ("1e999", "m", '"1e999" is larger than any number here'),
        ("1,167", "m", "1,167 can mean 1.167 or 1167: type a point, or leave the comma out"),
        ("1,234.5", "m", "is not understood"),
        ("1 00", "m", "is not understood"),
        ("3 4", "m", "is not understood"),
        ("1.2 x 10^-3", "m", "is not understood"),
        ("3/1200", "m", "is not understood"),
        ("--3", "m", "is not understood"),
        ("14 mm", "m", 'the answer is asked in m, not in "mm": type it in m'),
        ("0.0025 rad", "deg", 'the answer is asked in deg, not in "rad"'),
        ("5 m", "", 'the answer is a pure number, without "m"'),
        ("9" * 400 + "z" * 400, "m", 'not in "zzzzzzzzzzzzzzzzzzzzzzzzzzz..."'),
        (None, "m", '"None" is not understood'),
    ],
)
def test_what_is_not_understood_is_said(typed, unit, words):
    with pytest.raises(ValueError, match=re.escape(words)):
        read_number(typed, unit)


@given(st.floats(allow_nan=False, allow_infinity=False), st.sampled_from(["m", "deg", "", "%"]), st.booleans())
def test_every_number_that_python_writes_is_read_back(value, unit, with_unit):
    assert read_number(f"{value!r} {unit if with_unit else ''}", unit) == value


@given(st.floats(-1e6, 1e6))
def test_comma_or_point_is_the_same(value):
    text = f"{value:.4f}"
    assert read_number(text.replace(".", ","), "m") == read_number(text, "m")


@given(st.text())
def test_any_text_is_read_or_refused_in_words(text):
    said = value_or_words(text)
    assert abs(said) < float("inf") if isinstance(said, float) else "could not convert" not in said


def value_or_words(text):
    """Return the number, or the words of the refusal."""
    try:
        return read_number(text, "m")
    except ValueError as refusal:
        return str(refusal)
