"""Starting the course: what is said, and what is refused in words."""

import pytest

from gnsslab.teaching.server import command as course
from gnsslab.teaching.visitor import CLASS


@pytest.fixture
def start(monkeypatch, tmp_path):
    """A function that starts the course without serving anything, and returns what was said, the token and how many processes."""
    monkeypatch.setenv("GNSSLAB_PROGRESS", str(tmp_path))
    monkeypatch.setenv(CLASS, "")

    def start(**options):
        said, served = [], []
        monkeypatch.setattr(course, "_serve", lambda listener, token, workers, present, say: served.append((token, workers)))
        course.serve(port=23_600, open_browser=False, say=said.append, **options)
        return "\n".join(said), *served[0]

    return start


def test_a_course_on_this_machine_has_no_token(start):
    said, token, _ = start()
    assert token == ""
    assert "the course is at http://127.0.0.1:236" in said
    assert "token" not in said


def test_a_class_has_a_token_of_its_own_and_says_where_answers_are_kept(start, tmp_path):
    said, token, _ = start(host="0.0.0.0")
    assert len(token) == 9
    assert f"/?token={token} " in said
    assert str(tmp_path / "class") in said
    assert start(host="0.0.0.0")[1] != token


def test_a_token_can_be_chosen_or_left_out(start):
    assert start(host="0.0.0.0", token="autumn-26")[1] == "autumn-26"
    said, token, _ = start(host="0.0.0.0", token="")
    assert token == ""
    assert "there is no token: whoever reaches this machine is let in" in said


def test_tokens_that_make_no_sense_are_refused_in_words(start):
    with pytest.raises(ValueError, match="expected 6 to 64"):
        start(host="0.0.0.0", token="short")
    for token in ("autumn-26", ""):
        with pytest.raises(ValueError, match=r"give --host 0\.0\.0\.0 too"):
            start(token=token)


@pytest.mark.parametrize(("cores", "workers"), [(1, 1), (2, 2), (64, course.WORKERS_AT_MOST)])
def test_a_class_has_a_worker_a_core(start, monkeypatch, cores, workers):
    monkeypatch.setattr(course, "_cores", lambda: cores)
    said, _, started = start(host="0.0.0.0")
    assert started == workers
    assert (f"{workers} worker processes" in said) == (workers > 1)
    assert start(host="0.0.0.0", workers=3)[2] == 3


def test_this_machines_own_course_is_one_process(start):
    assert start()[2] == start(workers=1)[2] == 1
    with pytest.raises(ValueError, match="served by one process"):
        start(workers=2)


def test_where_connections_cannot_be_handed_over_one_process_serves_and_says_so(start, monkeypatch):
    monkeypatch.setattr(course, "can_hand_over", lambda: False)
    said, _, started = start(host="0.0.0.0", workers=2)
    assert started == 1
    assert "one process serves it" in said
