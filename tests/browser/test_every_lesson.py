"""What every lesson keeps to in a real browser: a prediction opens its labs, which fit the screen, have words, and follow their sliders."""

import itertools
import re
import time
from typing import NamedTuple
from urllib.parse import urlencode

import pytest
from stages import shown, stage

from gnsslab.labs.controls import Slider
from gnsslab.teaching.catalogue import LESSONS

PATIENCE = 90_000  # [ms], the very first load compiles kernels
START = {  # lab and settings with which a lesson is opened
    "01": ("signal", {"slip_cycles": 1}),  # without a slip its place has no effect
    "05": ("platforms", {"time_offset": 50}),  # receivers in step need no velocity, so its noise has none
}
LEFT_LOW = {"mask_deg", "mask", "lowest"}  # a high mask leaves nothing for the other sliders to change
RESET_AFTER = {("filter-health", "multipath"), ("length-forms", "multipath")}  # with so much nothing is fixed, and nothing to be held
IS_DARK = "document.body.classList.contains('dark') || document.documentElement.classList.contains('dark')"
PARTS = ".gl-pictures, .gl-controls, .gl-readouts, .gl-head"
WIDEST = f"Math.max(...[...document.querySelectorAll('{PARTS}')].map(part => part.getBoundingClientRect().right))"


class Opened(NamedTuple):
    """A lesson's page with all its labs open."""

    page: object
    lesson: object
    words: dict  # words of each picture when the page was opened, by lab


@pytest.fixture(scope="module", params=LESSONS, ids=lambda lesson: lesson.number)
def opened(request, visitor):
    """Every lesson in turn: its first lab waits for a prediction, and with it all its labs open."""
    lesson = request.param
    lab, settings = START.get(lesson.number, (None, {}))
    page = visitor.open(f"{lesson.address}?{urlencode({'lab': lab, **settings})}" if lab else lesson.address)
    page.get_by_role("heading", name=lesson.title).wait_for(timeout=PATIENCE)
    page.get_by_text("Choose an answer above to open the lab").first.wait_for(timeout=PATIENCE)
    assert stage(page, next(iter(lesson.open_labs()))).locator(".gl-pictures").count() == 0
    page.get_by_role("radio", name=lesson.exercises.PREDICTION.options[-1], exact=True).click(timeout=PATIENCE)
    for name in lesson.open_labs():
        stage(page, name).locator(".gl-pictures img").first.wait_for(timeout=PATIENCE)
    yield Opened(page, lesson, {name: _words(page, name) for name in lesson.open_labs()})
    page.close()
    assert not visitor.troubles


def _words(page, lab):
    return [picture.get_attribute("alt") for picture in stage(page, lab).locator(".gl-pictures img").all()]


def test_nothing_overflows_the_theme_is_followed_and_pictures_have_words(opened):
    page, lesson, words = opened
    for width, scheme in itertools.product((390, 1280), ("dark", "light")):
        page.set_viewport_size({"width": width, "height": 900})
        page.emulate_media(color_scheme=scheme)
        page.wait_for_function(f"({IS_DARK}) === {str(scheme == 'dark').lower()}", timeout=PATIENCE)
        assert page.evaluate("document.documentElement.scrollWidth") <= width, (width, scheme)
        assert page.evaluate(WIDEST) <= width, (width, scheme)
    for name, lab in lesson.open_labs().items():
        started, settings = START.get(lesson.number, (None, {}))
        first, *others = words[name]
        assert len(others) == len(lab.drawings()) - 1
        assert first == lab.describe(lab.run(**settings if name == started else {}))
        assert not any(others)  # the first has the words for all


def test_each_slider_changes_what_its_lab_shows(opened, dataset):
    page, lesson, _ = opened
    if lesson.number == "04":  # one of its labs begins with real data
        dataset("matrtklib-static")
    for name, lab in lesson.open_labs().items():
        if any(control.more for control in lab.controls):
            stage(page, name).get_by_text("more", exact=True).click()
        untouched = {other: shown(page, other) for other in lesson.open_labs() if other != name}
        blocked = lab.blocked(lab.settings())
        for control in lab.controls:
            if isinstance(control, Slider):
                _press_to_both_ends(page, name, control, control.name in blocked)
            if (name, control.name) in RESET_AFTER:
                _press_preset(page, name, lab.presets[0])
        assert {other: shown(page, other) for other in untouched} == untouched


def _press_preset(page, lab, preset):
    before = shown(page, lab)
    page.get_by_role("button", name=preset.label, exact=True).click()
    _await_change(page, lab, before, f"{lab}: preset {preset.name}")


def _press_to_both_ends(page, lab, control, is_blocked):
    slider = stage(page, lab).get_by_role("slider", name=re.compile(f"^{re.escape(control.label)}")).first
    assert (slider.get_attribute("data-disabled") is not None) == is_blocked, f"{lab}: {control.name}"
    if is_blocked:
        return
    is_at_home = slider.get_attribute("aria-valuenow") == slider.get_attribute("aria-valuemin")
    for key in ("End", "Home") if is_at_home or control.name in LEFT_LOW else ("Home", "End"):
        before = shown(page, lab)
        slider.press(key)
        _await_change(page, lab, before, f"{lab}: {control.name} to {key}")


def _await_change(page, lab, before, move):
    deadline = time.monotonic() + PATIENCE / 1000
    while shown(page, lab) in (before, ""):
        assert time.monotonic() < deadline, f"nothing changed, {move}"
        page.wait_for_timeout(20)
