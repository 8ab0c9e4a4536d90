"""HTML of both fronts: escaped, with words for pictures, and honest about goals."""

import base64
import re
from dataclasses import dataclass

import pytest

from gnsslab.labs.controls import Slider
from gnsslab.labs.lab import Drawing, Goal, Lab, Preset, Readout
from gnsslab.teaching import markup
from gnsslab.teaching.catalogue import LESSONS
from gnsslab.teaching.desk import Desk


@dataclass(frozen=True)
class Result:
    settings: dict
    problem: str = ""
    note: str = ""


def _build(figure):
    from gnsslab.figures.kept import Scene

    axes = figure.add_axes((0.1, 0.1, 0.8, 0.8))
    (line,) = axes.plot([], [])

    def show(result):
        line.set_data([0, 1], [0, result.settings["noise"]])
        return 0

    return Scene((line,), show)


def _desk(problem=""):
    lab = Lab(
        "toy", "Toy", (Slider("noise", "Noise", 0, 5, 1, 1),), lambda **settings: Result(settings, problem),
        figure=None, drawings=lambda: (Drawing("one", _build, 60, 40), Drawing("two", _build, 30, 30)), describe=lambda r: 'noise < 2 & "low"',
        readouts=lambda r: [Readout("N<", "1", "m", "a & b")], table=None,
        presets=(Preset("loud", "Loud", {"noise": 5}, "Look <here>."),),
        goals=(Goal("high", "Noise above 3.", lambda r: (r.settings["noise"] > 3, "Now: <3.")),),
    )  # fmt: skip
    return Desk(lab)


def test_everything_is_escaped():
    desk = _desk()
    desk.press(desk.lab.preset("loud"))
    html = markup.view(desk, desk.run({})) + markup.goal(desk.lab.goal("high"), desk.result)
    assert "Look &lt;here&gt;." in html
    assert "N&lt;" in html
    assert "a &amp; b" in html
    assert 'alt="noise &lt; 2 &amp; &quot;low&quot;"' in html
    assert "Now: &lt;3." in html
    assert "<script>" not in markup.view(_desk("<script>"), _desk("<script>").run({}))


def test_pictures_are_png_and_the_first_has_the_words():
    desk = _desk()
    images = re.findall(r'<img src="data:image/png;base64,([^"]+)" alt="([^"]*)"', markup.view(desk, desk.run({})))
    assert [bool(words) for _, words in images] == [True, False]
    assert all(base64.b64decode(data).startswith(b"\x89PNG") for data, _ in images)


def test_a_problem_stands_alone():
    desk = _desk("nothing to see")
    html = markup.view(desk, desk.run({}))
    assert "nothing to see" in html
    assert "<img" not in html
    assert "gl-readouts" not in html


@pytest.mark.parametrize(("noise", "word", "mark"), [(1, "Not yet.", "not yet"), (5, "Reached.", "reached")])
def test_goals_say_where_you_stand(noise, word, mark):
    desk = _desk()
    result = desk.run({"noise": noise})
    assert word in markup.goal(desk.lab.goal("high"), result)
    assert f"Goal 1: {mark}" in markup.view(desk, result)


@pytest.mark.parametrize("lesson", LESSONS, ids=lambda lesson: lesson.number)
def test_head_says_what_the_lesson_gives(lesson):
    html = markup.head(lesson)
    assert all(text.split("'")[0] in html for text in (lesson.title, *lesson.gives))
