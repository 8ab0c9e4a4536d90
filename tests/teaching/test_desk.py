"""The desk: what stays when data, presets and files change, and how a student's files are called."""

from dataclasses import dataclass
from pathlib import Path

import pytest

from gnsslab.labs.controls import Choice, FileOrPath, Slider
from gnsslab.labs.lab import Lab, Preset
from gnsslab.teaching.desk import Desk


@dataclass(frozen=True)
class Result:
    settings: dict
    problem: str = ""
    note: str = ""


def _compute(**settings):
    return Result(settings, problem=f"line 7 of {settings['file']} is too short" if settings["data"] == "mine" else "")


def _lab():
    controls = (
        Choice("data", "Data", {"simulated": "simulated", "mine": "mine"}, "simulated"),
        Slider("noise", "Noise", 0, 5, 1, 1),
        FileOrPath("file", "Rover"),
    )
    presets = (Preset("loud", "Loud", {"noise": 5}, "It is loud."),)
    return Lab(
        "toy", "Toy", controls, _compute, *[None] * 5, presets=presets, blocked=lambda s: {"noise": "no effect"} if s["data"] == "mine" else {}
    )


@pytest.fixture
def desk():
    return Desk(_lab())


def test_a_preset_counts_as_pressed_until_a_control_moves(desk):
    desk.press(desk.lab.preset("loud"))
    assert desk.settings["noise"] == 5
    assert desk.pressed is desk.lab.preset("loud")
    desk.run({"noise": 4})
    assert desk.pressed is None
    desk.run({"noise": 5})
    assert desk.pressed is desk.lab.preset("loud")


def test_a_preset_leaves_the_own_files(desk):
    desk.run({"file": "mine.obs"})
    desk.press(desk.lab.preset("loud"))
    assert desk.settings["file"] == "mine.obs"
    assert desk.pressed is not None


def test_an_upload_stays_when_its_field_is_built_anew(desk):
    path = desk.given_file("file", "", ("rover.obs", b"contents"))
    assert Path(path).read_bytes() == b"contents"
    assert desk.given_file("file", "") == path  # the field was empty: data had been switched away and back
    assert desk.uploaded_name("file") == "rover.obs"


def test_what_is_typed_takes_the_place_of_an_upload(desk):
    desk.given_file("file", "", ("rover.obs", b"contents"))
    assert desk.given_file("file", "/data/other.obs") == "/data/other.obs"
    assert desk.given_file("file", "") == ""


def test_a_second_upload_of_the_same_name_is_read_anew(desk):
    first = desk.given_file("file", "", ("rover.obs", b"one"))
    second = desk.given_file("file", "", ("rover.obs", b"two"))
    assert first == second
    assert Path(second).read_bytes() == b"two"


@pytest.mark.parametrize(
    ("filename", "kept"),
    [("../../evil.obs", "evil.obs"), ("..", "file"), ("", "file"), ("a\0.obs", "a.obs"), ("站" * 300 + ".obs", "站" * 56 + ".obs")],
)
def test_an_upload_cannot_leave_its_folder(desk, filename, kept):
    path = Path(desk.given_file("file", "", (filename, b"x")))
    assert path.name == kept
    assert path.parent.name == "file"
    assert path.read_bytes() == b"x"


def test_a_desk_keeps_one_upload_for_each_control(desk):
    first = Path(desk.given_file("file", "", ("one.obs", b"one")))
    second = Path(desk.given_file("file", "", ("two.obs", b"two")))
    assert not first.exists()
    assert second.read_bytes() == b"two"


def test_problems_name_an_upload_as_the_student_does(desk):
    path = desk.given_file("file", "", ("rover.obs", b"x"))
    result = desk.run({"data": "mine", "file": path})
    assert result.problem == "line 7 of Rover (rover.obs) is too short"


def test_uploads_go_with_the_desk():
    desk = Desk(_lab())
    path = Path(desk.given_file("file", "", ("rover.obs", b"x")))
    assert path.is_file()
    del desk
    assert not path.exists()


def test_blocked_controls_follow_the_settings(desk):
    assert desk.blocked == {}
    desk.settings |= {"data": "mine"}
    assert desk.blocked == {"noise": "no effect"}
