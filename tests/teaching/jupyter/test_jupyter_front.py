"""A lesson's widgets, moved as a student moves them, without a browser."""

from html import unescape

import pytest
from ipywidgets import Dropdown, FloatSlider, IntSlider, RadioButtons

from gnsslab.labs.controls import FileOrPath
from gnsslab.teaching.catalogue import find_lesson
from gnsslab.teaching.jupyter.front import NotebookLesson, open_lesson
from gnsslab.teaching.jupyter.shown import Refusal
from gnsslab.teaching.progress import Progress

RIGHT = "119.7"  # heading of the beam 0.70 m east, 0.40 m south
USUAL = "-60.26"  # the same by arctan(e/n)


@pytest.fixture
def progress():
    """A student's answers, in memory."""
    return Progress(None)


@pytest.fixture
def lesson(progress):
    """Lesson 00, nothing predicted yet."""
    return NotebookLesson(find_lesson("00"), progress)


def predict(lesson):
    lesson.predict().options.value = "to about 2 degrees"


@pytest.fixture
def north(lesson):
    """The lab of lesson 00, open."""
    north = lesson.lab("north")
    predict(lesson)
    return north


def click(button):
    button.click()


def said(sheet):
    """Return what a question's sheet says of the answer."""
    return "".join(output["data"]["text/markdown"] for output in sheet.said.outputs)


def text_of(box):
    """Return all text in a tree of widgets."""
    return unescape(str(getattr(box, "value", ""))) + "".join(map(text_of, getattr(box, "children", ())))


def test_the_lab_stays_closed_until_there_is_a_prediction(lesson, progress):
    north = lesson.lab("north")
    assert "Choose an answer under Predict" in text_of(north.box)
    assert north.desk.result is None
    predict(lesson)
    assert "gl-readouts" in text_of(north.box)
    entry = progress.entry("00", "how-well-in-one-second")
    assert (entry.kind, entry.answer, entry.is_right) == ("prediction", "to about 2 degrees", False)


def test_an_earlier_prediction_opens_the_lab_at_once(lesson, progress):
    predict(lesson)
    again = NotebookLesson(find_lesson("00"), progress)
    assert again.predict().options.value == "to about 2 degrees"
    assert "gl-readouts" in text_of(again.lab("north").box)


def test_lab_goals_and_questions_are_each_one_displayable_object(lesson, north):
    for shown in (lesson.predict(), north, north.goal("sharp"), lesson.question("heading-of-a-beam")):
        assert "application/vnd.jupyter.widget-view+json" in shown._repr_mimebundle_()


def test_a_slider_moves_picture_and_readouts(north):
    before = north.view.value
    north.controls["length"].widget.value = 3.0
    after = north.view.value
    assert north.desk.result.settings["length"] == 3.0
    assert readouts(before) != readouts(after)
    assert pictures(before) != pictures(after)
    assert 'alt="' in after


def readouts(html):
    return html.split("gl-pictures")[0]


def pictures(html):
    return html.split("data:image/png;base64,")[1:]


def test_every_corner_gives_a_picture_or_a_sentence(north):
    seen = set()
    for name, shown in north.controls.items():
        if isinstance(shown.control, FileOrPath):
            continue
        for value in shown.control.corners:
            shown.widget.value = value
            assert north.desk.result.settings[name] == value
            seen.add("gl-problem" in north.view.value)
            assert ("data:image/png" in north.view.value) != ("gl-problem" in north.view.value)
        shown.widget.value = shown.control.default
    assert seen == {True, False}, "my files, not given, is a sentence; all else a picture"


def test_rounding_errors_of_the_browser_leave_no_range(north):
    north.controls["length"].widget.value = 1.1 + 2.2  # 3.3000000000000003
    assert north.desk.result.settings["length"] == 3.3


def test_controls_are_of_the_kind_and_the_unit_that_the_lab_says(north):
    controls = {name: shown.widget for name, shown in north.controls.items()}
    assert isinstance(controls["seed"], IntSlider)
    assert isinstance(controls["length"], FloatSlider)
    assert isinstance(controls["data"], RadioButtons)
    assert isinstance(controls["systems"], Dropdown)
    assert controls["length"].description == "Baseline length [m]"
    assert controls["length"].readout_format == ".1f"
    assert (controls["length"].min, controls["length"].max, controls["length"].step) == (0.3, 5, 0.1)


def test_a_preset_sets_all_its_controls_and_says_what_to_look_at(north):
    north.controls["mask_deg"].widget.value = 30
    (button,) = [button for button in buttons_of(north.box) if button.description == "Cheap, with memory"]
    runs = count_runs(north)
    click(button)
    assert len(runs) == 1
    assert {name: north.controls[name].widget.value for name in ("carrier_noise", "code_noise", "single_epoch", "mask_deg")} == {
        "carrier_noise": 3, "code_noise": 1.2, "single_epoch": False, "mask_deg": 15,
    }  # fmt: skip
    assert "a filter carries the whole numbers on" in north.view.value
    north.controls["carrier_noise"].widget.value = 2.5
    assert "a filter carries the whole numbers on" not in north.view.value


def count_runs(north):
    """Return a list that gets an entry for each run of the lab from now on."""
    runs, run = [], north.desk.run
    north.desk.run = lambda changed: runs.append(changed) or run(changed)
    return runs


def buttons_of(box):
    own = [box] if hasattr(box, "click") else []
    return own + [button for child in getattr(box, "children", ()) for button in buttons_of(child)]


def test_controls_without_effect_are_disabled_and_say_why(north):
    north.controls["data"].widget.value = "mine"
    assert north.controls["carrier_noise"].widget.disabled
    assert "no effect: real data are as they are" in text_of(north.controls["carrier_noise"].box)
    assert north.controls["master_file"].box.layout.display != "none"
    north.controls["data"].widget.value = "simulated"
    assert not north.controls["carrier_noise"].widget.disabled
    assert north.controls["master_file"].box.layout.display == "none"


@pytest.fixture
def files(tmp_path, rng):
    """Files of a simulated beam of 1.167 m."""
    from gnsslab.simulate import find_preset, simulate, write_simulation

    write_simulation(tmp_path, simulate(find_preset("static-baseline"), rng))
    return {"master_file": tmp_path / "master.obs", "rover_file": tmp_path / "rover.obs", "navigation_file": tmp_path / "broadcast.nav"}


def test_own_files_by_path_and_by_upload(north, files):
    north.controls["data"].widget.value = "mine"
    assert "your master, rover and navigation files are missing" in north.view.value
    north.controls["master_file"].widget.value = f" {files['master_file']} "
    upload(north.controls["rover_file"], files["rover_file"])
    assert "rover.obs is kept" in text_of(north.controls["rover_file"].box)
    upload(north.controls["navigation_file"], files["navigation_file"])
    assert "gl-readouts" in north.view.value
    length = north.desk.result.attitude.length[north.desk.result.attitude.status == 2]
    assert abs(length.mean() - 1.167) < 0.01  # the simulated beam, to a centimetre


def test_a_file_that_is_none_gets_a_sentence_without_its_temporary_place(north, files, tmp_path):
    (tmp_path / "letter.txt").write_text("Dear reader")
    north.controls["data"].widget.value = "mine"
    for name in ("master_file", "rover_file", "navigation_file"):
        upload(north.controls[name], tmp_path / "letter.txt")
    assert "gl-problem" in north.view.value
    assert "Master observations (letter.txt)" in north.view.value


def upload(shown, path):
    """Give a file as the browser does."""
    content = path.read_bytes()
    shown._upload.set_state({"value": [{"name": path.name, "type": "", "size": len(content), "content": memoryview(content), "last_modified": 0}]})


def test_goals_are_judged_live_and_kept_once_reached(lesson, north, progress):
    sharp = north.goal("sharp")
    assert "Not yet." in sharp.value
    assert progress.entry("00", "sharp") is None
    north.controls["length"].widget.value = 5.0
    north.controls["systems"].widget.value = "GE"
    assert "Reached." in sharp.value
    assert progress.entry("00", "sharp").is_right
    assert "length=5" in progress.entry("00", "sharp").answer


def test_a_goal_before_the_lab_is_open_says_so(lesson):
    goal = lesson.lab("north").goal("sharp")
    assert "bring the scatter of heading below" in goal.value
    assert "Choose an answer under Predict" in goal.value


@pytest.mark.parametrize(
    ("typed", "words", "tries"),
    [(RIGHT, "Right:", 1), ("119,7 deg", "Right:", 1), (USUAL, "Use atan2", 1), ("50", "Not yet.", 1), ("north", "", 0), ("", "", 0), ("2 m", "", 0)],
)
def test_an_answer_is_judged_and_kept(lesson, progress, typed, words, tries):
    sheet = lesson.question("heading-of-a-beam")
    sheet.answer.value = typed
    click(sheet.check)
    assert words in said(sheet)
    assert said(sheet), "there is always a sentence"
    entry = progress.entry("00", "heading-of-a-beam")
    assert (entry.tries if entry else 0) == tries
    assert not entry or entry.is_right is (words == "Right:")


def test_enter_checks_as_the_button_does(lesson):
    sheet = lesson.question("heading-of-a-beam")
    sheet.answer.value = RIGHT
    sheet.answer._handle_custom_msg({"event": "submit"}, [])
    assert "Right:" in said(sheet)


def test_hints_come_one_after_the_other_and_the_solution_after_a_try(lesson, progress):
    sheet, question = lesson.question("heading-of-a-beam"), find_lesson("00").exercises.QUESTIONS[0]
    click(sheet.solution)
    assert "Try once" in said(sheet)
    assert question.solution not in said(sheet)
    click(sheet.hint)
    assert [hint in said(sheet) for hint in question.hints] == [True, False]
    click(sheet.hint)
    click(sheet.hint)
    assert [hint in said(sheet) for hint in question.hints] == [True, True]
    click(sheet.solution)
    assert question.solution in said(sheet)
    entry = progress.entry("00", "heading-of-a-beam")
    assert (entry.hints, entry.solution_seen, entry.tries) == (2, True, 0)


def test_one_try_opens_the_solution(lesson):
    sheet = lesson.question("heading-of-a-beam")
    sheet.answer.value = "50"
    click(sheet.check)
    click(sheet.solution)
    assert find_lesson("00").exercises.QUESTIONS[0].solution in said(sheet)


def test_earlier_answers_stand_there_again(lesson, progress):
    sheet = lesson.question("heading-of-a-beam")
    sheet.answer.value = USUAL
    click(sheet.check)
    click(sheet.hint)
    again = NotebookLesson(find_lesson("00"), progress).question("heading-of-a-beam")
    assert again.answer.value == USUAL
    assert said(again) == said(sheet)
    assert progress.entry("00", "heading-of-a-beam").tries == 1


def test_a_link_brings_the_controls_back(lesson):
    predict(lesson)
    for link in ("lab=north&length=2.5&seed=3", "/lesson/00/?lab=north&length=2.5&seed=3"):
        north = lesson.lab("north", link)
        assert (north.controls["length"].widget.value, north.controls["seed"].widget.value) == (2.5, 3)
    assert "the link's value is left out" in text_of(lesson.lab("north", "length=99").box)
    assert lesson.lab("north", "preset=cheap").desk.pressed.name == "cheap"


def test_save_this_writes_three_files_and_overwrites_none(north, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (save,) = [button for button in buttons_of(north.box) if button.description == "Save this"]
    click(save)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["north.csv", "north.png", "north.svg"]
    first = (tmp_path / "north.csv").read_bytes()
    assert first.startswith(b"time_gps,")
    north.controls["length"].widget.value = 3.0
    click(save)
    assert (tmp_path / "north.csv").read_bytes() == first
    assert (tmp_path / "north-2.csv").is_file()
    assert "north-2.png" in text_of(north.box)
    assert 'lesson.lab("north", "lab=north' in text_of(north.box)


def test_nothing_to_save_is_said(north, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    north.controls["data"].widget.value = "mine"
    (save,) = [button for button in buttons_of(north.box) if button.description == "Save this"]
    click(save)
    assert "nothing to save" in text_of(north.box)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda lesson: lesson.lab("nroth"), "lesson 00 has no lab 'nroth': it has north"),
        (lambda lesson: lesson.question("why"), "lesson 00 has no question 'why': it has heading-of-a-beam"),
        (lambda lesson: lesson.lab("north").goal("blunt"), "lab north has no goal 'blunt'"),
        (lambda lesson: open_lesson("98"), "there is no lesson 98"),
    ],
)
def test_a_bad_name_is_one_sentence_without_a_traceback(lesson, call, words):
    with pytest.raises(Refusal, match=words) as refusal:
        call(lesson)
    assert refusal.value._render_traceback_() == [str(refusal.value)]


def test_answers_that_cannot_be_kept_are_said_so(tmp_path):
    (tmp_path / "file").write_text("")
    lesson = NotebookLesson(find_lesson("00"), Progress(tmp_path / "file" / "progress.jsonl"))
    predict(lesson)
    sheet = lesson.question("heading-of-a-beam")
    sheet.answer.value = RIGHT
    click(sheet.check)
    assert "could not be" in said(sheet)
    assert "Right:" in said(sheet)
