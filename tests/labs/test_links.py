"""Links to a lab's settings: there and back again, and what a broken one is told."""

from urllib.parse import parse_qsl

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gnsslab.labs.controls import Choice, FileOrPath, Slider, Switch
from gnsslab.labs.lab import Lab, Preset
from gnsslab.labs.links import preset_of, query_of, settings_of

CONTROLS = (
    Slider("length", "Length", 0.5, 5, 0.5, 1, "m"),
    Slider("seed", "Seed", 1, 100, 1, 1),
    Choice("systems", "Systems", {"GPS": "G", "two": "GE"}, "G"),
    Choice("bands", "Bands", {"one": 1, "two": 2}, 2),
    Switch("alone", "Alone"),
    FileOrPath("file", "File"),
)
LAB = Lab("toy", "Toy", CONTROLS, *[None] * 6, presets=(Preset("long", "Long", {"length": 5}, "It is long."),))


def _query(text):
    return dict(parse_qsl(text))


@given(length=st.integers(1, 10), seed=st.integers(1, 100), systems=st.sampled_from(["G", "GE"]), bands=st.sampled_from([1, 2]), alone=st.booleans())
def test_a_link_brings_back_what_it_was_made_of(**drawn):
    drawn["length"] /= 2
    sent = LAB.defaults | drawn | {"file": "/home/me/secret.obs"}
    text = query_of(LAB, sent)
    settings, problems = settings_of(LAB, _query(text))
    assert problems == []
    assert settings == drawn
    assert type(settings["seed"]) is int  # a seed of another type would not do
    assert "secret" not in text


@pytest.mark.parametrize(
    ("query", "words"),
    [
        ("length=9", "Length is a number from 0.5 to 5 m, not '9'"),
        ("length=nan", "not 'nan'"),
        ("length=inf", "not 'inf'"),
        ("length=long", "not 'long'"),
        ("systems=X", "Systems X is none of G, GE"),
        ("alone=maybe", "Alone is on or off"),
    ],
)
def test_what_cannot_be_is_left_out_and_said(query, words):
    settings, problems = settings_of(LAB, _query(query))
    assert settings == {}
    assert len(problems) == 1
    assert words in problems[0]


def test_what_is_not_of_this_lab_is_left_alone():
    assert settings_of(LAB, {"mode": "present", "token": "x"}) == ({}, [])


def test_presets_go_by_name():
    assert preset_of(LAB, {"preset": "long"}) is LAB.presets[0]
    assert preset_of(LAB, {"preset": "short"}) is None
    assert preset_of(LAB, {}) is None
