"""Starting the course: what is said, and what is refused in words."""

import pytest

from gnsslab.teaching import course
from gnsslab.teaching.visitor import CLASS


@pytest.fixture
def start(monkeypatch, tmp_path):
    """A function that starts the course without serving anything, and returns what was said and the token."""
    monkeypatch.setenv("GNSSLAB_PROGRESS", str(tmp_path))
    monkeypatch.setenv(CLASS, "")
    monkeypatch.setattr(course, "warm_up", lambda: None)

    def start(**options):
        said, served = [], []
        monkeypatch.setattr(course, "run", lambda listener, token, present: served.append(token))
        course.serve(port=23_600, open_browser=False, say=said.append, **options)
        return "\n".join(said), served[0]

    return start


def test_a_course_on_this_machine_has_no_token(start):
    said, token = start()
    assert token == ""
    assert "the course is at http://127.0.0.1:236" in said
    assert "token" not in said


def test_a_class_has_a_token_of_its_own_and_says_where_answers_are_kept(start, tmp_path):
    said, token = start(host="0.0.0.0")
    assert len(token) == 9
    assert f"/?token={token} " in said
    assert str(tmp_path / "class") in said
    assert start(host="0.0.0.0")[1] != token


def test_a_token_can_be_chosen_or_left_out(start):
    assert start(host="0.0.0.0", token="autumn-26")[1] == "autumn-26"
    said, token = start(host="0.0.0.0", token="")
    assert token == ""
    assert "there is no token: whoever reaches this machine is let in" in said


def test_tokens_that_make_no_sense_are_refused_in_words(start):
    with pytest.raises(ValueError, match="expected 6 to 64"):
        start(host="0.0.0.0", token="short")
    for token in ("autumn-26", ""):
        with pytest.raises(ValueError, match=r"give --host 0\.0\.0\.0 too"):
            start(token=token)


def test_every_lab_is_warmed_up(monkeypatch):
    from gnsslab.labs.lab import Lab

    warmed, run = [], Lab.run
    monkeypatch.setattr(Lab, "run", lambda lab, **given: warmed.append(lab.name) or run(lab, **given))
    course.warm_up()
    assert warmed == [name for lesson in course.LESSONS for name in lesson.open_labs()]
    assert warmed
