"""Lab of lesson 00: every corner of every control computes or explains itself; presets show what they promise."""

import numpy as np
import pytest

from gnsslab.labs import north
from gnsslab.labs.north import FIXED, north_lab

LAB = "north"


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


def test_own_files_missing_are_named(lab):
    assert "your master, rover and navigation files are missing" in lab.run(data="mine").problem
    assert "your rover file is missing" in lab.run(data="mine", master_file="a.obs", navigation_file="b.nav").problem


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
