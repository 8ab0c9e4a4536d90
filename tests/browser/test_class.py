"""A class in real browsers: let in by its token, each with its own progress, on the workers that a class has."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from gnsslab.teaching.catalogue import find_lesson
from gnsslab.teaching.server.tokens import new_token

PATIENCE = 60_000  # [ms]
LESSON = find_lesson("00")
PREDICTION = LESSON.exercises.PREDICTION
TOKEN = new_token()


@pytest.fixture(scope="module")
def link(tmp_path_factory):
    """The link to a class, served in a process of its own with two workers."""
    folder = tmp_path_factory.mktemp("class")
    process = subprocess.Popen(
        [sys.executable, "-u", "-m", "gnsslab", "course", "--host", "0.0.0.0", "--no-browser", "--port", "24880", "--token", TOKEN, "--workers", "2"],
        cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
        env=os.environ | {"PYTHONPATH": str(Path(__file__).resolve().parents[2]), "GNSSLAB_PROGRESS": str(folder)},
    )  # fmt: skip
    try:
        yield next(line for line in process.stdout if "the course is at " in line).split("the course is at ")[1].split()[0]
        process.send_signal(signal.SIGINT)
        said, _ = process.communicate(timeout=30)
    finally:
        process.kill()  # its workers end with it
        process.wait()
        process.stdout.close()
    assert process.returncode == 0
    assert said.endswith("stopped\n")
    assert "Traceback" not in said


@pytest.fixture
def student(chromium, link):
    """A function that opens a path of the class in a browser of its own: through the link, then by its address."""
    contexts, troubles = [], []

    def open_page(path="", token=True):
        context = chromium.new_context()
        contexts.append(context)
        page = context.new_page()
        page.on("pageerror", lambda error: troubles.append(f"page error: {error}"))
        if token:
            page.goto(link)
            assert "token" not in page.url
        page.goto(link.partition("?")[0] + path)
        return page

    yield open_page
    for context in contexts:
        context.close()
    assert not troubles


def _predict(page, option):
    page.get_by_role("radio", name=option).click(timeout=PATIENCE)
    page.get_by_text("You said:").wait_for(timeout=PATIENCE)  # it is kept
    page.wait_for_selector(".gl-pictures img", timeout=PATIENCE)


def _answers(page):
    answer = page.request.get(f"{page.url.partition('/lesson')[0].rstrip('/')}/progress.json")
    return [entry["answer"] for entry in json.loads(answer.text())["entries"] if entry["kind"] == "prediction"]


def test_two_students_play_and_never_share_progress(student):
    first, second = student("lesson/00/"), student("lesson/00/")
    _predict(first, PREDICTION.options[0])
    assert _answers(second) == []
    _predict(second, PREDICTION.options[1])
    assert _answers(first) == [PREDICTION.options[0]]
    assert _answers(second) == [PREDICTION.options[1]]
    slider = second.get_by_role("slider", name="Baseline length").first
    before = second.locator(".gl-pictures img").first.get_attribute("src")
    slider.press("ArrowRight")
    second.wait_for_function("before => document.querySelector('.gl-pictures img').src !== before", arg=before, timeout=PATIENCE)


def test_a_student_who_reloads_finds_the_prediction_again(student):
    page = student("lesson/00/")
    _predict(page, PREDICTION.options[2])
    page.reload()
    page.get_by_text("You said:").wait_for(timeout=PATIENCE)
    assert page.get_by_text(PREDICTION.options[2]).count() > 0


def test_without_the_token_there_is_a_form_which_opens(student):
    page = student("lesson/00/?mode=present", token=False)
    field = page.get_by_label("Token")
    assert page.get_by_role("radio").count() == 0
    field.fill("k7mx-0000")
    page.get_by_role("button", name="Open").click()
    page.get_by_text("That token is not the one of this class").wait_for(timeout=PATIENCE)
    page.get_by_label("Token").fill(TOKEN.upper())
    page.get_by_role("button", name="Open").click()
    page.wait_for_selector(".gl-pictures img", timeout=PATIENCE)
    assert page.url.endswith("/lesson/00/?mode=present")


def test_a_preset_opens_by_link(student, link):
    preset = LESSON.open_labs()["north"].presets[1]
    page = student(token=False)
    page.goto(f"{link.partition('?')[0]}lesson/00/?preset={preset.name}&token={TOKEN}")
    _predict(page, PREDICTION.options[0])
    page.locator(".gl-look").get_by_text(preset.look_at[:30]).wait_for(timeout=PATIENCE)
