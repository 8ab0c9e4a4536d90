"""Lab of lesson 00: every corner of every control computes or explains itself; presets show what they promise."""

import itertools

import numpy as np
import pytest

from gnsslab.data import DataUnavailable
from gnsslab.labs import campaigns, north
from gnsslab.labs.north import FIXED, north_lab


@pytest.fixture(scope="module")
def lab():
    """One lab for all tests, so that its simulations are made once."""
    return north_lab()


def _says_something(lab, result):
    """An answer: numbers in the readouts and a picture in words; or one sentence."""
    if result.problem:
        return result.problem.startswith("No answer: ") and result.problem.endswith(".")
    attitude = result.attitude
    solved = attitude.status > 0
    finite = np.isfinite(attitude.heading[solved]).all() and np.isfinite(attitude.sigma_heading[solved]).all()
    return finite and len(lab.readouts(result)) == 4 and str(len(solved)) in lab.describe(result)


@pytest.mark.parametrize("control", [c for c in north.CONTROLS if c.name not in ("data", *north.FILES)], ids=lambda c: c.name)
def test_each_corner_computes_or_explains_itself(lab, control):
    for value in control.corners:
        assert _says_something(lab, lab.run(**{control.name: value})), f"{control.name} = {value}"


def test_corners_of_several_controls_at_once(lab):
    corners = {"systems": ("E", "GE"), "frequencies": (1, 3), "mask_deg": (5, 60), "single_epoch": (True, False), "known_length": (True, False)}
    for values in itertools.product(*corners.values()):
        settings = dict(zip(corners, values, strict=True)) | {"length": 0.3, "carrier_noise": 4, "code_noise": 1.5}
        assert _says_something(lab, lab.run(**settings)), settings


def test_pictures_can_be_drawn_at_every_preset(lab):
    from gnsslab.figures.kept import KeptPicture

    pictures = [KeptPicture(d.build, d.width, d.height, sharpness=0.5) for d in lab.drawings()]
    for preset in lab.presets:
        result = lab.run(**preset.settings)
        for picture in pictures:
            assert result.problem or picture.png(result).startswith(b"\x89PNG")


def test_same_settings_same_answer_from_another_lab():
    one, two = (north_lab().run(seed=7, length=2.0).attitude for _ in range(2))
    np.testing.assert_array_equal(one.baseline_enu, two.baseline_enu)


def test_another_seed_is_another_draw(lab):
    assert not np.array_equal(lab.run(seed=1).attitude.heading, lab.run(seed=2).attitude.heading)


def test_fixed_epochs_find_the_truth(lab):
    result = lab.run(**lab.preset("survey").settings)
    fixed = result.attitude.status == FIXED
    error = np.linalg.norm(result.attitude.baseline_enu[fixed] - result.truth.baseline_enu, axis=1)
    assert fixed.mean() > 0.99
    assert np.median(error) < 5e-3  # carrier noise of 1 mm and as much multipath, on a difference of differences


def test_a_longer_lever_sharpens_heading_in_proportion(lab):
    """Scatter in degrees goes with one over length: the millimetres stay."""
    scatter = [north._heading_scatter(lab.run(length=length, carrier_noise=1, code_noise=0.3)) for length in (1.0, 4.0)]
    assert scatter[0] / scatter[1] == pytest.approx(4.0, rel=0.1)


def test_presets_show_what_they_promise(lab):
    fixed = {p.name: north._fixed_percent(lab.run(**p.settings)) for p in lab.presets if p.settings.get("data") != "real"}
    assert 40 < fixed["start"] < 95  # both colours are to be seen
    assert fixed["survey"] > 99
    assert fixed["cheap"] < 50 < 90 < fixed["memory"]
    assert fixed["sky"] > 99
    assert fixed["lonely"] < 20


def test_lonely_gps_fixes_wrongly(lab):
    readouts = {r.label: r for r in lab.readouts(lab.run(**lab.preset("lonely").settings))}
    assert "of them wrong" in readouts["Fixed"].note


def test_presets_are_within_range(lab):
    for preset in lab.presets:
        assert lab.settings(**preset.settings)
        assert preset.look_at.endswith(".")
    with pytest.raises(ValueError, match="has no preset 'noon'"):
        lab.preset("noon")


@pytest.mark.parametrize(
    ("settings", "name", "reached"),
    [
        ({}, "sharp", False),
        ({"length": 4.0, "systems": "GE"}, "sharp", True),
        ({"length": 4.0, "systems": "GE", "carrier_noise": 1}, "sharp", False),  # against the rules
        ({"code_noise": 1.0}, "frugal", False),
        ({"code_noise": 1.0, "single_epoch": False}, "frugal", True),
    ],
)
def test_goals_are_judged(lab, settings, name, reached):
    is_reached, state = lab.goal(name).judge(lab.run(**settings))
    assert is_reached == reached, state
    assert state.startswith("Now: ")


def test_goals_are_judged_without_an_answer(lab):
    for goal in lab.goals:
        assert not goal.judge(lab.run(data="mine"))[0]


def test_values_out_of_range_are_refused_in_words(lab):
    with pytest.raises(ValueError, match=r"^Code noise 9 m is outside 0.1 to 1.5 m$"):
        lab.run(code_noise=9)
    with pytest.raises(ValueError, match="has no control 'noise'"):
        lab.run(noise=1)


def test_controls_without_effect_say_why(lab):
    assert set(lab.blocked(lab.settings())) == set(north.FILES)
    on_real_data = lab.blocked(lab.settings(data="real"))
    assert set(north.SIMULATION_ONLY) <= set(on_real_data)
    assert all(on_real_data.values())
    assert set(lab.blocked(lab.settings(data="mine"))) == {*north.SIMULATION_ONLY, "known_length"}


def test_real_roof_points_south_southwest(lab, dataset):
    dataset("matrtklib-static")
    result = lab.run(data="real", systems="GECJ")
    attitude = result.attitude
    fixed = attitude.status == FIXED
    assert fixed.mean() > 0.99
    assert np.degrees(np.median(attitude.heading[fixed])) == pytest.approx(193.03, abs=0.06)  # registry, deg
    assert np.median(attitude.length[fixed]) == pytest.approx(0.9902, abs=0.002)


def test_without_network_and_mirror_the_lab_goes_on(monkeypatch):
    def refuse(name):
        raise DataUnavailable(f"the data set {name} is not on this machine")

    monkeypatch.setattr(campaigns, "fetch", refuse)
    result = north_lab().run(data="real")
    assert result.problem == ""
    assert "so this is simulated" in result.note
    assert result.attitude is not None


def test_own_files_missing_are_named(lab):
    assert "your master, rover and navigation files are missing" in lab.run(data="mine").problem
    assert "your rover file is missing" in lab.run(data="mine", master_file="a.obs", navigation_file="b.nav").problem


def test_own_files_that_cannot_be_read_get_a_sentence(lab, tmp_path):
    empty = tmp_path / "empty.obs"
    empty.write_bytes(b"")
    for path in (empty, tmp_path / "absent.obs", tmp_path):
        result = lab.run(data="mine", master_file=path, rover_file=path, navigation_file=path)
        assert result.problem.startswith("No answer: ")
        assert "Traceback" not in result.problem


def test_own_files_give_the_answer_of_the_simulation_they_came_from(tmp_path):
    """The loop through RINEX: what the simulator writes, the lab reads."""
    from gnsslab.simulate import find_preset, simulate, write_simulation

    simulation = simulate(find_preset("static-baseline"), np.random.default_rng(5))
    write_simulation(tmp_path, simulation)
    names = dict(zip(north.FILES, ("master.obs", "rover.obs", "broadcast.nav"), strict=True))
    result = north_lab().run(data="mine", systems="GE", **{k: tmp_path / v for k, v in names.items()})
    fixed = result.attitude.status == FIXED
    assert fixed.mean() > 0.95
    assert np.degrees(np.median(result.attitude.heading[fixed])) == pytest.approx(35.0, abs=0.2)
