from dataclasses import replace

import numpy as np
import pytest

from gnsslab.simulate import PRESETS, find_preset, instants, prepare_geometry, simulate, true_motion, with_length
from gnsslab.simulate.receivers import Clock

ASKED = {
    "static-baseline", "paper-a-static", "paper-a-turntable", "car-rtk", "ship-heading", "drone-hop", "four-antennas", "static-rtk-5km",
    "car-heading", "car-clocks", "city-heading",
}  # fmt: skip


def test_the_presets_asked_for_are_there():
    assert set(PRESETS) >= ASKED
    assert all(name == preset.name for name, preset in PRESETS.items())


@pytest.mark.parametrize("name", sorted(PRESETS))
def test_every_preset_runs_and_says_what_it_is(name, rng):
    preset = PRESETS[name]
    simulation = simulate(preset, rng)
    assert len(simulation.observations) == preset.receivers
    assert all(len(observations.time) >= preset.epochs - 10 for observations in simulation.observations)
    assert len(simulation.observations[0].satellites) >= 10
    assert preset.title
    assert preset.sentence.rstrip(".?") != preset.sentence
    assert np.isfinite(simulation.truth.baselines_enu).all()


def test_an_unknown_name_lists_the_known_ones():
    with pytest.raises(ValueError, match="no preset 'roof'; the presets are static-baseline, paper-a-static"):
        find_preset("roof")


def test_paper_a_is_as_calibrated():
    """Truth and noise of the papers' calibration: 1.167 m, 35 deg, 15 satellites above 15 deg, 650 epochs, losses of lock at 300 and 500."""
    preset = PRESETS["paper-a-static"]
    simulation = simulate(preset, np.random.default_rng(1))
    truth = simulation.truth
    assert np.degrees(truth.heading) == pytest.approx(35.0)
    assert np.linalg.norm(truth.baselines_enu[0, 0]) == pytest.approx(1.167, abs=1e-6)
    rover = simulation.observations[1]
    assert len(rover.time) == 650
    assert {code for table in rover.tables.values() for code in table.codes if code[0] == "C"} == {"C1C", "C2I"}
    per_epoch = sum(np.bincount(table.epoch, minlength=650) for table in rover.tables.values())
    assert set(per_epoch) <= {14, 15, 16}
    flagged = np.unique(np.concatenate([table.epoch[table.lli.any(axis=1)] for table in rover.tables.values()]))
    assert flagged.tolist() == [300, 500]
    elevation = prepare_geometry(preset).elevation
    assert elevation[elevation > np.radians(15)].size > 14 * 650


def test_paper_a_turns_at_six_degrees_a_second_and_misses_one_epoch_of_the_master():
    simulation = simulate(PRESETS["paper-a-turntable"], np.random.default_rng(1))
    heading = np.unwrap(simulation.truth.heading)
    assert np.degrees(np.diff(heading)[60:]) == pytest.approx(6.0)
    assert np.ptp(heading[:51]) == pytest.approx(0)
    master, rover = simulation.observations
    assert set(rover.time) - set(master.time) == {rover.time[218]}
    middle = simulation.truth.position_ecef.mean(axis=0)
    speed = np.linalg.norm(np.diff(simulation.truth.position_ecef[60:], axis=0), axis=1)
    assert speed == pytest.approx(0.0611, abs=0.0001)  # [m/s], of the master on its circle
    assert np.linalg.norm(simulation.truth.position_ecef - middle, axis=1).max() < 0.7


def test_the_road_of_the_car_is_hilly_and_its_clock_steps():
    truth = simulate(PRESETS["car-heading"], np.random.default_rng(1)).truth
    slope = np.tan(truth.pitch)
    assert (slope.max(), slope.min()) == pytest.approx((0.13, -0.13), abs=0.01)
    apart = np.diff([instants(PRESETS["car-clocks"], receiver) for receiver in (0, 1)], axis=0)
    assert np.abs(apart).max() == pytest.approx(0.5e-3, rel=0.05)
    assert (np.abs(np.diff(apart)) > 0.9e-3).sum() > 5
    speed = np.linalg.norm(np.diff(simulate(PRESETS["car-clocks"], np.random.default_rng(1)).truth.position_ecef, axis=0), axis=1)
    assert speed.max() * 0.5e-3 / 1.0 == pytest.approx(np.radians(0.5), rel=0.2)  # of heading, half a degree


def test_between_houses_the_sky_is_poor_and_comes_back():
    rover = simulate(PRESETS["city-heading"], np.random.default_rng(1)).observations[1]
    seconds = (rover.time - rover.time[0]) / np.timedelta64(1, "s")
    seen = sum(np.bincount(table.epoch, minlength=len(rover.time)) for table in rover.tables.values())
    assert np.setdiff1d(np.arange(300), seconds).tolist() == list(range(150, 157)), "under the bridge"
    streets = [(seconds >= first) & (seconds <= last) for first, last in ((60, 110), (190, 240))]
    usual = np.median(seen[~streets[0] & ~streets[1]])
    assert seen[streets[0]].max() < usual
    assert np.median(seen[streets[1]]) < usual / 2
    assert seen[-1] >= usual - 2


def test_truth_may_be_asked_for_at_the_instants_of_a_receiver():
    preset = replace(PRESETS["car-heading"], duration=20.0, clocks=(Clock(), Clock(offset=-0.5)))
    at_tags, later = (true_motion(preset, seconds) for seconds in (np.arange(20.0), instants(preset, 1)))
    assert instants(preset, 1).tolist() == (np.arange(20.0) + 0.5).tolist()
    assert (later.time - at_tags.time == np.timedelta64(500, "ms")).all()
    np.testing.assert_array_equal(simulate(preset, np.random.default_rng(1)).truth.position_ecef, at_tags.position_ecef)
    between = (at_tags.position_ecef[1:] + at_tags.position_ecef[:-1]) / 2
    assert np.linalg.norm(later.position_ecef[:-1] - between, axis=1).max() < 1.0  # a / 8 of a turning car


def test_the_length_can_be_set_and_the_direction_stays():
    for name in ("static-baseline", "paper-a-turntable", "ship-heading"):
        preset = with_length(PRESETS[name], 3.5)
        baseline = simulate(replace(preset, duration=3.0, events=()), np.random.default_rng(1)).truth.baselines_enu[0]
        assert np.linalg.norm(baseline, axis=-1) == pytest.approx(3.5, abs=1e-6)


@pytest.mark.parametrize("length", [0.0, -1.0, np.nan, np.inf])
def test_a_length_of_nothing_is_refused(length):
    with pytest.raises(ValueError, match="must be above zero"):
        with_length(PRESETS["static-baseline"], length)


def test_one_antenna_has_no_length():
    with pytest.raises(ValueError, match="one antenna on its body"):
        with_length(PRESETS["car-rtk"], 1.0)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"site": (135.0, 35.0, 0.0)}, "site is latitude and longitude in degrees"),
        ({"site": (35.0, 135.0, 6.4e6)}, "the site's height"),
        ({"interval": 0.0}, "interval must be above zero"),
        ({"duration": 0.0}, "duration must hold one interval"),
        ({"systems": "GR"}, "systems are the letters G, E, C and J"),
        ({"systems": ""}, "systems are the letters G, E, C and J"),
        ({"bands": 4}, "bands must be 1, 2 or 3"),
        ({"mask_deg": 90.0}, "mask_deg must be from 0"),
        ({"antennas": ()}, "one to four antennas"),
        ({"antennas": ((0.0, 0.0, 0.0),), "clocks": (Clock(),)}, "a baseline needs two receivers"),
        ({"antennas": ((0.0, 1.0, 0.0), (0.0, 1.0, 0.0))}, "two antennas stand in one place"),
        ({"clocks": (Clock(),)}, "2 receivers need as many clocks; there are 1"),
        ({"start": "yesterday"}, "start is a GPS time such as 2024-06-24T08:20:00; it is 'yesterday'"),
    ],
)
def test_presets_that_cannot_be_are_refused_in_words(changes, words):
    with pytest.raises(ValueError, match=words):
        replace(PRESETS["static-baseline"], **changes)
