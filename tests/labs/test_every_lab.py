"""What every lab of the course keeps to, at all its corners and presets, with data and without."""

import itertools
import re
from collections.abc import Callable
from dataclasses import fields, is_dataclass
from functools import cache
from typing import NamedTuple

import numpy as np
import pytest
from coming_labs import COMING

from gnsslab.data import DataUnavailable
from gnsslab.figures.kept import KeptPicture
from gnsslab.labs import campaigns
from gnsslab.labs.cells import ESTIMATORS
from gnsslab.labs.controls import Choice, FileOrPath, Slider, Switch
from gnsslab.teaching.catalogue import LESSONS

LESSON_OF = {name: lesson for lesson in (*LESSONS, COMING) for name in lesson.open_labs()}
LABS = {name: lesson.open_labs()[name] for name, lesson in LESSON_OF.items()}  # for names of controls and presets; tests run those of `labs`
each_lab = pytest.mark.parametrize("name", LABS)

# settings to move from, one control at a time: where each has an effect, and where a move is quick
STARTS = {
    "signal": ({"slip_second": 1}, {"slip_second": 1, "data": "station"}),
    "sky": ({}, {"data": "station"}),
    "cells": (
        {},
        {"ambiguities": 3, "covariance": "frequencies", "epochs": 2},
        {"ambiguities": 3, "covariance": "satellites", "epochs": 2, "decorrelated": True},
    ),
    "soft-fixing": ({}, {"satellites": 8, "frequencies": 2, "code_noise": 0.2, "trees": 1, "risk": 0.001}),
    "known-length": ({"direction": "set", "epochs": 100},),
    "fewer-satellites": ({"data": "simulated", "acceptance": "rate"},),
    "platforms": ({"time_offset": 500},),
    "three-filters": ({}, {"scene": "turntable", "mode": "position"}),
    "filter-health": ({"seed": 3},),
    "length-forms": ({"data": "simulated", "satellites": 6, "multipath": 0.2, "seed": 2},),
    "step-response": ({"direction": "across"},),
    "slope-alarm": ({"alarm": "average", "threshold": 2},),
}

# corners of several controls at once, and what the others are set to; the lab of the printed error has its own
TOGETHER = {
    "north": (
        {"systems": ("E", "GE"), "frequencies": (1, 3), "mask_deg": (5, 60), "single_epoch": (True, False), "known_length": (True, False)},
        {"length": 0.3, "carrier_noise": 4, "code_noise": 1.5},
    ),
    "signal": (
        {"elevation_deg": (10, 85), "slip_cycles": (-10, 10), "slip_second": (-10, 10), "slip_at": (10, 90), "clock": ("free", "jumping")},
        {"code_noise": 1.5, "multipath": 2, "carrier_noise": 5, "ionosphere": 4},
    ),
    "sky": (
        {"systems": ("E", "GE"), "mask_deg": (0, 60), "latitude_deg": (-90, 0, 90), "hour": (0, 24), "ionosphere": (1, 2)},
        {"multipath": 3, "code_noise": 1.5},
    ),
    "cancelling": (
        {"observable": ("carrier", "code"), "clocks": (True, False), "length": (0, 10), "rover_clock": (0, 1), "transmission": ("code", "tags"),
         "satellite": ("high", "low"), "reference": ("middle", "low")},
        {},
    ),
    "correlation": (
        {"belief": ("respected", "ignored", "doubled", "unsquared"), "satellites": (5, 9), "reference": ("high", "low"), "growing": (True, False),
         "code_noise": (0.1, 1), "carrier_noise": (1, 10)},
        {},
    ),
    "centimetres": (
        {"satellites": (4, 10), "frequencies": (1, 3), "code_noise": (0.1, 1), "carrier_noise": (1, 10), "epochs": (1, 60), "mask": (10, 40),
         "belief": ("all", "diagonal", "printed", "carrier")},
        {},
    ),
    "cells": (
        {"ambiguities": (2, 3), "covariance": ("textbook", "satellites", "frequencies", "independent"), "decorrelated": (False, True),
         "epochs": (1, 100), "code_noise": (0.05, 1), "carrier_noise": (1, 15), "float_1": (-4, 4), "float_2": (-4, 4)},
        {},
    ),
    "spectrum": (
        {"sats": (5, 11), "bands": (1, 3), "code": (0.1, 1), "carrier": (1, 10), "together": (1, 60), "lowest": (5, 30),
         "decorrelated": (True, False)},
        {},
    ),
    "trust": (
        {"test": ("ratio", "tolerated", "difference", "projector"), "written": ("right", "upside-down", "mixed"), "satellites": (5, 9),
         "frequencies": (1, 2), "code_noise": (0.1, 1), "code_bias": (0, 5)},
        {"samples": 1000},
    ),
    "soft-fixing": (
        {"satellites": (5, 10), "frequencies": (1, 2), "code_noise": (0.05, 0.6), "trees": (0, 3), "subset": ("combinations", "single")},
        {},
    ),
    "known-length": (
        {"length": (0.3, 5), "length_error": (-10, 10), "satellites": (4, 9), "code_noise": (0.05, 0.5), "carrier_noise": (1, 10)},
        {"epochs": 100},
    ),
    "fewer-satellites": (
        {"frequencies": (1, 2), "order": ("highest", "south"), "acceptance": ("all", "rate"), "known_length": (True, False), "code_noise": (0.05, 1)},
        {"data": "simulated"},
    ),
    "filter-health": (
        {"motion": ("rest", "turning"), "carrier_sigma": (1, 16), "velocity_noise": (1, 100), "multipath": (0, 12), "hold_after": (0, 1),
         "ratio": (1, 10)},
        {"slip_at": 290},
    ),
    "length-forms": (
        {"memory": ("single", "filter"), "satellites": (4, 15), "length_error": (-10, 10), "noise": (4.0, "learnt"), "multipath": (0, 1.5)},
        {"data": "simulated", "systems": "GECJ"},
    ),
    "platforms": (
        {"platform": ("car", "ship", "turntable", "city"), "length": (0.3, 5), "time_offset": (0, 1000), "correction": (True, False),
         "mount": ("along", "across")},
        {"systems": "G"},
    ),
    "three-filters": (
        {"scene": ("static", "turntable"), "printed": ("none", "16", "25", "31"), "velocity_noise": (0, 1000), "length": (0.3, 5), "pitch": (0, 40)},
        {"multipath": 12, "missing": 5, "late": 1000},
    ),
    "denoising": (
        {"method": ("joint", "average", "smoother"), "step": (0, 10), "counted": (1, 30), "q": (0.005, 5), "correlation": (0.5, 120),
         "thresholds": ("none", "paper")},
        {"window": 120, "gross": 4, "average": 120},
    ),
    "slope-alarm": (
        {"alarm": ("raw", "average", "joint", "monitor"), "wrong_fixes": (True, False), "threshold": (0.5, 15), "step": (0, 20)},
        {"slide": 5, "moves_at": 95, "burst_length": 40, "burst_size": 50, "average": 240, "noise": 120, "gross": 4, "wait": 40},
    ),
    "step-response": (
        {"method": ("joint", "kalman", "cusum"), "beside": ("raw", "adjustment"), "noise": ("none", "b-fixed"), "step": (0, 15), "lasts": (0, 10),
         "seen": ("position", "length"), "direction": ("along", "across")},
        {"q": 20, "gross": 4, "later": 600},
    ),
}  # fmt: skip

# data sets of the choices of data that are real
DATA_SETS = {
    ("north", "real"): "matrtklib-static",
    ("signal", "real"): "matrtklib-static",
    ("signal", "station"): "cssrlib-078",
    ("sky", "real"): "matrtklib-static",
    ("sky", "station"): "cssrlib-078",
    ("cancelling", "real"): "geonet-0759-3040",
    ("correlation", "real"): "geonet-0759-3040",
    ("centimetres", "real"): "geonet-0759-3040",
    ("fewer-satellites", "roof"): "matrtklib-static",
    ("fewer-satellites", "stations"): "geonet-0759-3040",
    ("length-forms", "roof"): "matrtklib-static",
    ("slope-alarm", "slope"): "beidou-slope",
    ("slope-alarm", "J188"): "geonet-tohoku-neu",
    ("slope-alarm", "USUD"): "geonet-tohoku-neu",
}
TRAVELS_ALONG = "cssrlib-078"
WITHOUT_DATA_SET = {"simulated", "paper", "mine"}

REFUSES_TOGETHER = {"north", "sky", "cancelling", "centimetres", "fewer-satellites"}  # some of the corners above have no answer
REFUSES = {("sky", "mask_deg"), ("cancelling", "reference"), ("centimetres", "belief"), ("centimetres", "mask")}  # an end of these has none
PICTURE_ONLY = {("cells", "draws"), ("cells", "estimator"), ("soft-fixing", "sigma"), ("known-length", "row_sigma")}  # no readout shows these
ONE_END_ONLY = {  # not at the other
    ("signal", "slip_second"),
    ("signal", "ionosphere"),
    ("soft-fixing", "risk"),
    ("fewer-satellites", "mask"),
    ("filter-health", "length_use"),
    ("denoising", "average"),
    ("step-response", "patience"),
}
NOT_FINITE = {  # parts of a result with NaN where something was not measured or has no answer, infinity where there is no limit
    "north": {"attitude"},
    "printed": {"pitch", "pitch_errors"},
    "signal": {"step", "code_rate", "carrier_rate", "range_rate"},
    "sky": {"residual", "azimuth", "elevation", "error_enu"},
    "cells": {"bound"},
    "trust": {"accepted_range"},
    "known-length": {"norms"},
    "three-filters": {"pitch_error"},
    "platforms": {"attitude", "rate"},
    "denoising": {"lags"},
    "slope-alarm": {"sigma", "lag", "truth"},
    "step-response": {"lags", "found", "response", "curve"},
}


class Answer(NamedTuple):
    """What is to be found in each result of a lab."""

    rows: Callable  # of its table
    words: Callable  # each in the description of its pictures
    holds: Callable = lambda result: True  # what else is so
    readouts: int = 4


def _solved_are_finite(result):
    solved = result.attitude.status > 0
    return np.isfinite(result.attitude.heading[solved]).all() and np.isfinite(result.attitude.sigma_heading[solved]).all()


def _claims_are_shares(result):
    return all(0 < fixes.claimed <= 1 for fixes in result.counted.fixes.values())


ANSWERS = {
    "north": Answer(lambda r: len(r.attitude.status), lambda r: [f"{len(r.attitude.status)}"], _solved_are_finite),
    "printed": Answer(lambda r: len(r.drawn_heading), lambda r: ["Heading: ", "pitch: "]),
    "signal": Answer(lambda r: len(r.track.time), lambda r: [r.track.satellite], lambda r: np.isfinite(r.track.left).any(), 5),
    "sky": Answer(lambda r: np.isfinite(r.view.elevation).sum(), lambda r: ["HDOP"], readouts=5),
    "cancelling": Answer(lambda r: len(r.seconds), lambda r: [f"{len(r.seconds)} epochs"]),
    "correlation": Answer(lambda r: len(r.solved.ratio), lambda r: [f"{len(r.solved.ratio)} epochs"]),
    "centimetres": Answer(lambda r: len(r.is_right), lambda r: [f"{len(r.is_right)} positions"]),
    "cells": Answer(lambda r: len(r.tree.nodes), lambda r: [f"{estimator} says" for estimator in ESTIMATORS], readouts=5),
    "spectrum": Answer(lambda r: r.n, lambda r: [f"{r.n} conditional standard deviations"], lambda r: min(*r.before.sigma, r.adop) > 0),
    "trust": Answer(
        lambda r: len(r.is_right), lambda r: [f"{len(r.is_right)} epochs"], lambda r: np.allclose([sum(one.shares) for one in r.judged], 1)
    ),
    "soft-fixing": Answer(lambda r: len(r.is_right), lambda r: [f"{len(r.is_right)} epochs"], readouts=5),
    "known-length": Answer(lambda r: len(r.counted.truth), lambda r: ["length"], _claims_are_shares),
    "fewer-satellites": Answer(lambda r: len(r.off), lambda r: [f"{len(r.off)} epochs"], lambda r: np.allclose([sum(one) for one in r.shares], 1)),
    "filter-health": Answer(lambda r: len(r.health.seconds), lambda r: [f"{len(r.health.seconds)} epochs"], readouts=6),
    "length-forms": Answer(lambda r: len(r.seconds), lambda r: [f"{len(r.seconds)} epochs"], readouts=5),
    "platforms": Answer(lambda r: len(r.attitude.status), lambda r: [f"{len(r.attitude.status)} seconds"], readouts=5),
    "three-filters": Answer(
        lambda r: len(r.seconds), lambda r: [f"{len(r.seconds)} epochs"], lambda r: set(r.solutions) == {"direct", "length", "position"}, 6
    ),
    "denoising": Answer(
        lambda r: len(r.truth), lambda r: [f"{len(r.truth)} epochs"], lambda r: {"joint", "hampel"} <= set(r.lengths) and r.weight <= 0.6, 5
    ),
    "slope-alarm": Answer(lambda r: len(r.raw), lambda r: [f"{len(r.raw)} epochs"], lambda r: len(r.curves) == 4 and r.line.distance.max() > 0),
    "step-response": Answer(lambda r: len(r.truth), lambda r: [f"{len(r.truth)} epochs", r.shown.label], lambda r: len(r.raw) == len(r.epochs), 5),
}


def _numbers(record, path=()):
    """Return all numbers of a result, {path of names: array}, but for its settings; a kind of thing that is not known fails."""
    if record is None or isinstance(record, str):
        return {}
    if isinstance(record, int | float | np.generic | np.ndarray):
        return {path: np.asarray(record)}
    return {place: values for name, part in _parts(record) if name != "settings" for place, values in _numbers(part, (*path, name)).items()}


def _parts(record):
    if is_dataclass(record):
        return [(field.name, getattr(record, field.name)) for field in fields(record)]
    if isinstance(record, dict):
        return record.items()
    return zip(getattr(record, "_fields", range(len(record))), record, strict=True)


def _odd_numbers(name, result):
    """Return where in a result a number is not finite that should be."""
    floats = {path: values for path, values in _numbers(result).items() if values.dtype.kind == "f"}
    assert floats or result.problem
    return [path for path, values in floats.items() if not NOT_FINITE.get(name, set()) & set(path) and not np.isfinite(values).all()]


def _told(lab, result):
    """Return what the readouts say, but for the time that something took; or the problem."""
    return result.problem or [readout for readout in lab.readouts(result) if readout.label != "Time"]


def _check_answer(lab, result, may_refuse):
    """Check that a result has finite numbers, readouts and words, or one sentence where it may refuse."""
    if result.problem:
        assert may_refuse, result.problem
        assert re.fullmatch(r"No answer: .{10,}\.", result.problem)
        return
    answer, readouts, words = ANSWERS[lab.name], lab.readouts(result), lab.describe(result)
    assert not _odd_numbers(lab.name, result)
    assert len(readouts) == answer.readouts
    assert not re.search(r"\b(nan|inf)\b", f"{readouts} {words}")
    assert all(said in words for said in answer.words(result)), words
    assert answer.holds(result)


def _pictures(lab):
    return [KeptPicture(drawing.build, drawing.width, drawing.height, sharpness=0.5) for drawing in lab.drawings()]


def _drawn(pictures, result):
    shots = [picture.png(result) for picture in pictures]
    assert all(shot.startswith(b"\x89PNG") for shot in shots)
    return shots


def test_no_lab_is_left_out():
    assert set(ANSWERS) == set(LABS)
    assert set(TOGETHER) == set(LABS) - {"printed"}


# --- one control at a time, and several


class Move(NamedTuple):
    """One control moved to each of its corners."""

    lab: object
    control: object
    start: object  # result
    ends: dict  # result by value


def _moves():
    for name, lab in LABS.items():
        for start in STARTS.get(name, ({},)):
            for control in lab.controls:
                if control.name != "data" and not isinstance(control, FileOrPath):
                    yield pytest.param((name, start, control), id=f"{name}-{'-'.join(map(str, start.values()))}-{control.name}")


@pytest.fixture(scope="module", params=list(_moves()))
def move(labs, request):
    """A lab's results at all corners of one control."""
    name, start, control = request.param
    lab = labs[name]
    return Move(lab, control, lab.run(**start), {value: lab.run(**start | {control.name: value}) for value in control.corners})


def test_each_corner_computes_or_explains_itself(move):
    for result in move.ends.values():
        _check_answer(move.lab, result, may_refuse=(move.lab.name, move.control.name) in REFUSES)


def test_each_control_has_an_effect_or_is_blocked(move):
    which, settings = (move.lab.name, move.control.name), move.start.settings
    others = [result for value, result in move.ends.items() if value != settings[move.control.name]]
    changed = [_told(move.lab, result) != _told(move.lab, move.start) for result in others]
    if move.control.name in move.lab.blocked(settings) or which in PICTURE_ONLY:
        assert not any(changed)
    else:
        assert any(changed) if which in ONE_END_ONLY else all(changed)


@pytest.mark.parametrize(("name", "control"), sorted(PICTURE_ONLY))
def test_what_no_readout_shows_is_in_a_picture(labs, name, control):
    lab, pictures = labs[name], _pictures(labs[name])
    shots = {tuple(_drawn(pictures, lab.run(**{control: value}))) for value in lab.control(control).corners}
    assert len(shots) == len(set(lab.control(control).corners))


@pytest.mark.parametrize("name", TOGETHER)
def test_corners_of_several_controls_at_once(labs, name):
    corners, others = TOGETHER[name]
    for values in itertools.product(*corners.values()):
        _check_answer(labs[name], labs[name].run(**others, **dict(zip(corners, values, strict=True))), name in REFUSES_TOGETHER)


def _choices_that_steer():
    for name, lab in LABS.items():
        for steering in lab.steering:
            for value in lab.control(steering).corners:
                if (steering, value) != ("data", "mine"):
                    yield pytest.param(name, {steering: value}, id=f"{name}-{steering}-{value}")


@pytest.mark.parametrize(("name", "choice"), list(_choices_that_steer()))
def test_what_is_blocked_says_why_and_has_no_effect(labs, dataset, name, choice):
    lab, start = labs[name], labs[name].settings(**STARTS.get(name, ({},))[0] | choice)
    before = _told(lab, _run(labs, dataset, name, start))
    for blocked, reason in lab.blocked(start).items():
        assert len(reason) > 20
        control = lab.control(blocked)
        for value in ("absent.obs",) if isinstance(control, FileOrPath) else control.corners:
            assert _told(lab, lab.run(**start | {blocked: value})) == before, blocked


def _run(labs, dataset, name, settings):
    """Return a lab's result, of real data where the settings ask for them; skips where they cannot be had."""
    data = labs[name].settings(**settings).get("data", "simulated")
    if data not in WITHOUT_DATA_SET:
        dataset(DATA_SETS[name, data])
    result = labs[name].run(**settings)
    assert "this is simulated" not in result.note
    return result


# --- presets


def _presets():
    return [pytest.param(name, preset.name, id=f"{name}-{preset.name}") for name, lab in LABS.items() for preset in lab.presets]


@pytest.mark.parametrize(("name", "preset"), _presets())
def test_each_preset_has_its_pictures_and_a_table(labs, dataset, pictures, name, preset):
    result = _run(labs, dataset, name, labs[name].preset(preset).settings)
    _check_answer(labs[name], result, may_refuse=(name, preset) in REFUSES)
    if not result.problem:
        _drawn(pictures(name), result)
        assert {len(column) for column in labs[name].table(result).values()} == {ANSWERS[name].rows(result)}
        assert ANSWERS[name].rows(result) > 0


@pytest.fixture(scope="module")
def pictures(labs):
    """A function from a lab's name to its kept pictures, coarse."""
    return cache(lambda name: _pictures(labs[name]))


@each_lab
def test_presets_are_within_range_and_told_apart(labs, name):
    lab = labs[name]
    assert len(lab.presets) >= 6
    for preset in lab.presets:
        assert lab.settings(**preset.settings)
        assert preset.look_at.endswith(".")
    assert len({preset.label for preset in lab.presets}) == len(lab.presets)
    of_the_lesson = [preset.name for other in LESSON_OF[name].open_labs().values() for preset in other.presets]
    assert len(set(of_the_lesson)) == len(of_the_lesson)
    with pytest.raises(ValueError, match="has no preset 'the one that nobody made'"):
        lab.preset("the one that nobody made")


# --- draws, goals, values out of range


@each_lab
def test_same_settings_same_answer_from_another_lab(name):
    start, seed = STARTS.get(name, ({},))[0], "draw" if name == "spectrum" else "seed"
    one, two, other = (_numbers(_fresh(name).run(**start | {seed: value})) for value in (7, 7, 8))
    assert all(_is_same(one[path], two[path]) for path in one | two if path[-1] != "seconds")  # of a search, by the clock
    assert not all(_is_same(one[path], other.get(path)) for path in one if path[-1] != "seconds")


def _is_same(one, other):
    return np.array_equal(one, other, equal_nan=one.dtype.kind == "f")


def _fresh(name):
    return LESSON_OF[name].open_labs()[name]


@each_lab
def test_goals_are_not_reached_by_themselves(labs, name):
    lab = labs[name]
    assert lab.goals
    for goal, start in itertools.product(lab.goals, STARTS.get(name, ({},))):
        is_reached, words = goal.judge(lab.run(**start))
        assert not is_reached
        assert re.fullmatch(r"(Now: |The rules ).*\.", words)
        assert "nan" not in words


@each_lab
def test_values_out_of_range_are_refused_in_words(labs, name):
    lab = labs[name]
    for control in lab.controls:
        value, words = _refused(control)
        with pytest.raises(ValueError, match=words):
            lab.run(**{control.name: value})
    with pytest.raises(ValueError, match="has no control 'noise_of_the_neighbours'"):
        lab.run(noise_of_the_neighbours=1)


def _refused(control):
    """Return a value that a control does not have, and the words for it."""
    label = re.escape(control.label)
    if isinstance(control, Slider):
        unit, value = f" {control.unit}" if control.unit else "", control.stop + control.step
        return value, f"^{label} {value:g}{unit} is outside {control.start:g} to {control.stop:g}{unit}$"
    words = {Choice: "{} .* is none of ", Switch: "{} is on or off", FileOrPath: "{} is the path of a file"}[type(control)]
    return object(), words.format(label)


# --- without data, and with bad ones

WITH_FILES = [name for name, lab in LABS.items() if any(isinstance(control, FileOrPath) for control in lab.controls)]


@pytest.mark.parametrize(("name", "data"), [key for key, data_set in DATA_SETS.items() if data_set != TRAVELS_ALONG])
def test_without_network_and_mirror_the_lab_goes_on(monkeypatch, name, data):
    def refuse(name):
        raise DataUnavailable(f"the data set {name} is not on this machine")

    monkeypatch.setattr(campaigns, "fetch", refuse)
    lab = _fresh(name)
    result = lab.run(data=data)
    _check_answer(lab, result, may_refuse=False)
    assert "so this is simulated: the data set " in result.note


@pytest.mark.parametrize("name", WITH_FILES)
def test_own_files_missing_are_named(labs, name):
    result = labs[name].run(data="mine")
    assert re.search("files? (is|are) missing", result.problem)
    assert not any(goal.judge(result)[0] for goal in labs[name].goals)


@pytest.mark.parametrize("name", WITH_FILES)
def test_own_files_that_cannot_be_read_get_a_sentence(labs, tmp_path, name):
    (tmp_path / "empty.obs").write_bytes(b"")
    files = [control.name for control in labs[name].controls if isinstance(control, FileOrPath)]
    for path in (tmp_path / "empty.obs", tmp_path / "absent.obs", tmp_path):
        result = labs[name].run(data="mine", **dict.fromkeys(files, path))
        _check_answer(labs[name], result, may_refuse=True)
        assert result.problem
        assert "Traceback" not in result.problem
