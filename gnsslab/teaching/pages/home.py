"""The home page's content: a greeting, the lessons with how far the student is, and where that is kept."""

from html import escape
from pathlib import Path
from string import Template

from gnsslab.teaching.catalogue import LESSONS
from gnsslab.teaching.pages.standing import standing_in
from gnsslab.teaching.progress import own_progress

HERE = Path(__file__).parent
PRESENTING = '<p class="present" role="status">For the class: lessons open in large type, with the answers hidden.</p>'


def home_body(progress, present):
    """Return the content of the home page; with no progress, of a course that nobody has begun."""
    entries = progress.entries() if progress else ()
    standings = [(lesson, standing_in(lesson, entries)) for lesson in LESSONS]
    return _filled(
        "home.html",
        hero=_greeting(standings, present),
        presenting=PRESENTING if present else "",
        lessons="\n".join(_card(lesson, standing, present) for lesson, standing in standings),
        record=_record(progress, entries) if progress else "",
    )


def _greeting(standings, present):
    """Return the first page's hero, or a short way back to where the student was."""
    begun = [pair for pair in standings if pair[1].is_begun]
    if not begun:
        return _filled("hero.html", first=_address(LESSONS[0], present), number=LESSONS[0].number)
    if all(standing.is_done for _, standing in standings):
        return _way_back("All lessons done.", "Every prediction, question and goal. Come back to any of them.", "")
    lesson, standing = _next(standings, begun)
    verb = "Continue with" if standing.is_begun else "Go on to"
    button = f'<a class="button" href="{_address(lesson, present)}">{verb} lesson {lesson.number}</a>'
    return _way_back("Welcome back.", f"<strong>{escape(lesson.title)}</strong><br>{_in_words(standing)}", button)


def _next(standings, begun):
    """Return the lesson touched last if it is not done, else the first that is not."""
    last = max(begun, key=lambda pair: pair[1].last)
    return next(pair for pair in (last, *standings) if not pair[1].is_done)


def _way_back(title, words, button):
    return f'<div class="back"><h1>{title}</h1><p>{words}</p>{button}</div>'


def _card(lesson, standing, present):
    gives = "".join(f"<li>{escape(text)}</li>" for text in lesson.gives)
    return (
        f'<li class="lesson{" done" if standing.is_done else ""}"><div class="number" aria-hidden="true">{lesson.number}</div><div>'
        f'<h3><a href="{_address(lesson, present)}">{escape(lesson.title)}</a></h3><p>{escape(lesson.teaser)}</p>'
        f'<p class="meta">About {lesson.minutes} minutes. Needs {escape(lesson.needs)}.</p>{_standing(standing)}</div>'
        f'<div class="gives"><p>Afterwards you can</p><ul>{gives}</ul></div></li>'
    )


def _standing(standing):
    """Return how far a lesson is, in words and as a row of steps; nothing where it is not begun."""
    if not standing.is_begun:
        return ""
    steps = '<i class="taken"></i>' * standing.taken + "<i></i>" * (standing.steps - standing.taken)
    mark = "Done" if standing.is_done else "Continue"
    return f'<div class="standing"><p><strong>{mark}</strong>{_in_words(standing)}</p><div class="steps" aria-hidden="true">{steps}</div></div>'


def _in_words(standing):
    """Return a standing as a sentence.

    >>> from gnsslab.teaching.pages.standing import Standing
    >>> _in_words(Standing(True, 2, 4, 0, 1, "2026-03-02T09:15:00Z"))
    'Prediction made, 2 of 4 questions right, 0 of 1 goal reached.'
    """
    parts = ["Prediction made" if standing.is_predicted else "No prediction yet"]
    parts += [_count(standing.right, standing.questions, "question", "right")] * (standing.questions > 0)
    parts += [_count(standing.reached, standing.goals, "goal", "reached")] * (standing.goals > 0)
    return f"{', '.join(parts)}."


def _count(done, all_, noun, participle):
    return f"{done} of {all_} {noun}{'s' * (all_ != 1)} {participle}"


def _record(progress, entries):
    """Return where the answers are kept; once there are some, how to take them along and how to begin anew."""
    return f'<section class="record" aria-label="Your answers"><p>{_where_kept(progress)}{_TAKE_ALONG if entries else "</p>"}</section>'


_TAKE_ALONG = """ Take them along as <a href="/progress.csv" download>CSV</a> or <a href="/progress.json" download>JSON</a>.</p>
<details><summary>Begin anew</summary><form method="post" action="/progress/reset">
<p>Every lesson will show as not begun. The file so far stays beside the new one, under another name.</p>
<button class="button">Yes, begin anew</button></form></details>"""


def _where_kept(progress):
    if progress.problem:
        return f'<strong role="alert">{escape(progress.problem)}</strong>'
    if progress.path is None:
        return "Your answers are not kept: they are forgotten when you close a lesson."
    if progress.path == own_progress().path:
        return "Your answers are kept on this machine, in a file of your own, and nowhere else."
    return "Your answers are kept for this browser, apart from everyone else's, on the machine that serves the class."


def _address(lesson, present):
    return f"{lesson.address}{'?mode=present' if present else ''}"


def _filled(name, **parts):
    return Template((HERE / name).read_text("utf-8")).substitute(parts)
