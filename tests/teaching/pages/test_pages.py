"""The pages around the lessons: whole, self-contained, and true of what was recorded."""

import re
import subprocess
import sys

import pytest
from html_outline import Outline

from gnsslab.teaching.catalogue import LESSONS
from gnsslab.teaching.pages.pages import PAGES, data_page, glossary_page, home_page, lost_page, notation_page
from gnsslab.teaching.pages.standing import goals_of
from gnsslab.teaching.progress import Progress, own_progress

STANDING = {"/": home_page, "/notation": notation_page, "/glossary": glossary_page, "/data": data_page}
ALL = {**STANDING, "lost": lambda: lost_page("/nowhere"), "begun": lambda: home_page(_begun()), "presented": lambda: home_page(_begun(), True)}
FIRST = LESSONS[0]
ADDRESSES = {*STANDING, *(lesson.address for lesson in LESSONS), "/progress.csv", "/progress.json"}


def _begun(progress=None):
    progress = progress or Progress()
    progress.record(FIRST.number, FIRST.exercises.PREDICTION.name, "prediction", "x", False)
    progress.record(FIRST.number, FIRST.exercises.QUESTIONS[0].name, "question", "1", True)
    progress.record(FIRST.number, FIRST.exercises.QUESTIONS[1].name, "question", "2", False)
    return progress


def _done(lessons):
    progress = Progress()
    for lesson in lessons:
        progress.record(lesson.number, lesson.exercises.PREDICTION.name, "prediction", "x", False)
        for question in lesson.exercises.QUESTIONS:
            progress.record(lesson.number, question.name, "question", "1", True)
        for goal in goals_of(lesson):
            progress.record(lesson.number, goal, "goal", "where it was reached", True)
    return progress


@pytest.fixture(params=ALL)
def page(request):
    """Each page, as text."""
    return ALL[request.param]()


def test_menu_leads_to_every_page():
    assert set(PAGES) == set(STANDING)
    for address, make in STANDING.items():
        links = [found for tag, found in Outline(make()).elements if tag == "a" and found.get("aria-current")]
        assert {found["href"] for found in links} == {address}


def test_page_is_whole(page):
    outline = Outline(page)
    assert page.startswith("<!doctype html>")
    assert [outline.count(tag) for tag in ("title", "h1", "main", "footer", "nav")] == [1, 1, 1, 1, 1]
    assert ("html", {"lang": "en"}) in outline.elements
    assert any(found.get("name") == "viewport" for _, found in outline.elements)
    assert "/" in outline.links
    assert "$" not in outline.text


def test_page_loads_nothing_from_elsewhere(page):
    outline = Outline(page)
    assert outline.loaded
    assert all(address.startswith("data:") for address in outline.loaded)
    assert not re.search(r"@import|url\(|fetch\(|https?://[^\"<]*\.(js|css|woff2?)", page)


def test_page_follows_the_systems_dark_mode_and_can_be_printed(page):
    assert "@media (prefers-color-scheme: dark)" in page
    assert "@media print" in page


def test_letters_stand_out_from_their_ground():
    light, dark = [dict(re.findall(r"--(\w+): (#\w{6})", block)) for block in re.findall(r":root \{([^}]*)\}", home_page())[:2]]
    for colours in (light, dark):
        for ink in ("ink", "soft", "accent", "needle", "good"):
            for ground in ("paper", "card"):
                assert _contrast(colours[ink], colours[ground]) >= 4.5, (ink, ground)  # WCAG 2.1, level AA


def _contrast(one, other):
    """Return the contrast of two colours as WCAG 2.1 defines it, 1 to 21."""
    brighter, darker = sorted((_luminance(one), _luminance(other)), reverse=True)
    return (brighter + 0.05) / (darker + 0.05)


def _luminance(colour):
    parts = [int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)]
    red, green, blue = [part / 12.92 if part <= 0.03928 else ((part + 0.055) / 1.055) ** 2.4 for part in parts]
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


def test_links_within_the_course_lead_somewhere(page):
    outline = Outline(page)
    assert len(set(outline.ids)) == len(outline.ids)
    for link in outline.links:
        address = link.removesuffix("?mode=present")
        assert link.startswith("https://github.com/") or address in ADDRESSES or link.removeprefix("#") in outline.ids, link


def test_home_page_tells_each_lesson_before_anything_is_done():
    outline = Outline(home_page(Progress()))
    for lesson in LESSONS:
        assert lesson.address in outline.links
        for words in (lesson.title, lesson.teaser, f"About {lesson.minutes} minutes", lesson.needs, *lesson.gives):
            assert words in outline.text
    assert f"Start with lesson {FIRST.number}" in outline.text
    assert "Begin anew" not in outline.text
    assert " questions right" not in outline.text


def test_home_page_leads_back_to_what_was_begun():
    outline = Outline(home_page(_begun()))
    assert f"Continue with lesson {FIRST.number}" in outline.text
    assert f"Prediction made, 1 of {len(FIRST.exercises.QUESTIONS)} questions right" in outline.text
    taken = sum(tag == "i" and found.get("class") == "taken" for tag, found in outline.elements)
    assert taken == 2  # the prediction and one question; a wrong answer is no step


def test_lesson_that_is_done_says_so_and_the_next_is_offered():
    outline = Outline(home_page(_done(LESSONS[:1])))
    assert "Done Prediction made" in outline.text
    following = [f"Go on to lesson {lesson.number}" in outline.text for lesson in LESSONS[1:2]]
    assert all(following)


def test_home_page_when_all_is_done():
    outline = Outline(home_page(_done(LESSONS)))
    assert "All lessons done." in outline.text
    assert outline.text.count("Done Prediction made") == len(LESSONS)
    assert "Continue" not in outline.text


def test_reset_asks_once_more_and_needs_no_script():
    outline = Outline(home_page(_begun()))
    assert ("form", {"method": "post", "action": "/progress/reset"}) in outline.elements
    names = [tag for tag, _ in outline.elements]
    assert names[names.index("details") :][:5] == ["details", "summary", "form", "p", "button"]
    assert outline.count("script") == 0
    assert {"/progress.csv", "/progress.json"} <= set(outline.links)


def test_where_answers_are_kept_is_said(tmp_path, monkeypatch):
    monkeypatch.setenv("GNSSLAB_PROGRESS", str(tmp_path))
    assert "on this machine" in home_page(own_progress())
    assert "for this browser" in home_page(Progress(tmp_path / "class" / "0123456789abcdef.jsonl"))
    assert "are not kept" in home_page(Progress())


def test_trouble_with_the_file_is_said(tmp_path):
    (tmp_path / "file").write_text("no folder", "utf-8")
    page = home_page(_begun(Progress(tmp_path / "file" / "progress.jsonl")))
    assert "Your answers are kept only until you close this page" in page
    assert "on this machine" not in page


def test_presenting_is_said_and_every_lesson_opens_so():
    outline = Outline(home_page(_begun(), present=True))
    assert "lessons open in large type, with the answers hidden" in outline.text
    to_lessons = [link for link in outline.links if link.startswith("/lesson/")]
    assert len(to_lessons) > len(LESSONS)
    assert all(link.endswith("/?mode=present") for link in to_lessons)


def test_unknown_addresses_are_told_without_being_obeyed():
    page = lost_page("/<script>alert(1)</script>")
    assert "<script>" not in page
    assert "/<script>alert(1)</script>" in Outline(page).text


def test_home_page_loads_neither_engine_nor_pictures():
    program = "import sys; from gnsslab.teaching.pages.pages import home_page; home_page(); print(*sys.modules)"
    outcome = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    loaded = set(outcome.stdout.split())
    assert "gnsslab.teaching.exercises" in loaded
    assert not loaded & {"numba", "matplotlib", "scipy", "marimo", "gnsslab.gnss.relative"}
