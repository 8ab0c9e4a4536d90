"""Controls check their own range, in words."""

import re

import numpy as np
import pytest

from gnsslab.labs.controls import Choice, FileOrPath, Slider, Switch

NOISE = Slider("code_noise", "code noise", 0.05, 1.5, 0.05, 0.3, "m")
SEED = Slider("seed", "seed", 1, 9, 1, 1)
BANDS = Choice("frequencies", "frequencies", {"one": 1, "two": 2}, 2)
ALONE = Switch("single_epoch", "each second alone")
FILE = FileOrPath("master_file", "master observations")


@pytest.mark.parametrize("value", [0.05, 0.3, 1.5, 1, np.float64(0.7)])
def test_slider_takes_what_is_in_range(value):
    assert NOISE.check(value) == value


@pytest.mark.parametrize(
    ("control", "value", "sentence"),
    [
        (NOISE, 9, "code noise 9 m is outside 0.05 to 1.5 m"),
        (NOISE, float("nan"), "code noise nan m is outside 0.05 to 1.5 m"),
        (NOISE, "0.3", "code noise is a number from 0.05 to 1.5 m, not '0.3'"),
        (NOISE, True, "code noise is a number from 0.05 to 1.5 m, not True"),
        (SEED, 0, "seed 0 is outside 1 to 9"),
        (BANDS, 3, "frequencies 3 is none of 1, 2"),
        (ALONE, 1, "each second alone is on or off (True or False), not 1"),
        (FILE, None, "master observations is the path of a file, not None"),
    ],
)
def test_controls_refuse_in_words(control, value, sentence):
    with pytest.raises(ValueError, match=f"^{re.escape(sentence)}$"):
        control.check(value)


def test_choice_reads_back_what_the_student_saw():
    assert BANDS.text_of(1) == "one"


@pytest.mark.parametrize("control", [NOISE, SEED, BANDS, ALONE, FILE])
def test_corners_and_default_are_allowed(control):
    for value in (*control.corners, control.default):
        assert control.check(value) == value
