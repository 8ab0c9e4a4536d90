"""What both fronts show as HTML: the head of a lesson, readouts, pictures, goals, verdicts. Everything is escaped here."""

import base64
from html import escape
from pathlib import Path

STYLE = Path(__file__).with_name("style.css").read_text("utf-8")


def head(lesson, home="/"):
    """Return the head of a lesson: the way home, title, time, what it needs and what it gives."""
    gives = "".join(f"<li>{escape(text)}</li>" for text in lesson.gives)
    ways = f'<nav><a href="{home}" target="_self">All lessons</a> · <a href="{home}notation" target="_blank">Notation</a></nav>' if home else ""
    return (
        f'<div class="gl-head">{ways}<h1>{escape(lesson.title)}</h1>'
        f'<p class="gl-meta">Lesson {lesson.number} · about {lesson.minutes} minutes · needs {escape(lesson.needs)}</p>'
        f'<p class="gl-gives">Afterwards you can</p><ul>{gives}</ul></div>'
    )


def view(desk, result):
    """Return what a result shows: what to look at, notes, readouts, how the goals stand, pictures; or the sentence why there are none."""
    note = _look_at(desk, result) + (f'<p class="gl-note">{escape(result.note)}</p>' if result.note else "")
    if result.problem:
        return f'{note}<p class="gl-problem" role="status">{escape(result.problem)}</p>'
    return note + readouts(desk.lab.readouts(result)) + _goals_in_short(desk.lab, result) + pictures(desk, result)


def readouts(numbers):
    """Return the readouts side by side."""
    cells = "".join(
        f"<div><dt>{escape(r.label)}</dt><dd>{escape(r.value)} <span>{escape(r.unit)}</span></dd><small>{escape(r.note)}</small></div>"
        for r in numbers
    )
    return f'<dl class="gl-readouts" aria-live="polite">{cells}</dl>'


def pictures(desk, result):
    """Return the pictures side by side; the first carries the description in words."""
    drawn = desk.pictures(result)
    words = [desk.lab.describe(result)] + [""] * len(drawn)
    images = [
        f'<img src="{data_url(png)}" alt="{escape(alt)}" width="{d.width}" height="{d.height}" '
        f'class="{"gl-beside" if d.presented else ""}" style="--gl-ratio:{d.width / d.height:.3f}">'
        for (d, png), alt in zip(drawn, words, strict=False)
    ]
    return f'<div class="gl-pictures">{"".join(images)}</div>'


def goal(goal, result):
    """Return a goal, judged: reached or not yet, and where you stand."""
    is_reached, state = goal.judge(result)
    word, kind = ("Reached.", " gl-reached") if is_reached else ("Not yet.", "")
    judged = f"<strong>{word}</strong> {escape(state)}"
    return f'<div class="gl-goal{kind}" id="goal-{goal.name}" role="status">{escape(goal.text)}<br>{judged}</div>'


def verdict(is_right, words):
    """Return what is said of an answer; the words are HTML."""
    return f'<div class="gl-verdict {"gl-right" if is_right else "gl-wrong"}" role="status">{words}</div>'


def control_help(control, reason):
    """Return the line below a control: its help, or the reason why it has no effect now."""
    return f"<small>{escape(reason or control.help)}</small>"


def data_url(png):
    """Return PNG bytes as a data: address, so that no second request is needed."""
    return "data:image/png;base64," + base64.b64encode(png).decode("ascii")


def _look_at(desk, result):
    """Return the pressed preset's sentence; none once a control was moved, or where other data stand in for the preset's."""
    if desk.pressed is None or result.note:
        return ""
    return f'<p class="gl-look" data-preset="{escape(desk.pressed.name)}" role="status">{escape(desk.pressed.look_at)}</p>'


def _goals_in_short(lab, result):
    """Return one mark a goal, so that reaching it is seen where the controls are."""
    if not lab.goals:
        return ""
    spans = [_goal_in_short(number, goal, goal.judge(result)[0]) for number, goal in enumerate(lab.goals, 1)]
    return f'<p class="gl-goals">{"".join(spans)}</p>'


def _goal_in_short(number, goal, is_reached):
    state = "reached" if is_reached else "not yet"
    return f'<span class="{"gl-on" if is_reached else ""}" title="{escape(goal.text)}">Goal {number}: {state}</span>'


def present_style(lab):
    """Return the rules that leave only one lab's stage on the page: presets, readouts, picture, controls."""
    stage = f'.gl-stage[data-lab="{lab}"]'
    return f".marimo-cell:not(:has({stage}, .gl-head)), .fixed.right-8{{display:none}}"


def present_head(lesson, labs):
    """Return what stands above the stage: the other labs of the lesson, and the way back to the text."""
    others = "".join(f'<a href="{lesson.address}?mode=present&amp;lab={name}" target="_self">{escape(lab.title)}</a>' for name, lab in labs.items())
    return f'<p class="gl-ways">{others if len(labs) > 1 else ""}<a href="{lesson.address}" target="_self">the lesson with its text</a></p>'
