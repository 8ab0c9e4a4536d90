"""Lab of what cancels and what grows: every corner computes or explains itself; presets and real data show what they promise."""

from dataclasses import replace

import numpy as np
import pytest

from gnsslab.gnss.delays import klobuchar
from gnsslab.gnss.frames import azimuth_elevation, enu_rotation, geodetic_from_ecef
from gnsslab.gnss.times import add_seconds
from gnsslab.labs import cancelling
from gnsslab.simulate import Clock, Static, find_preset, prepare_geometry, simulate, write_simulation
from gnsslab.simulate.geometry import antenna_position
from gnsslab.simulate.sky import NOMINAL_IONOSPHERE

LAB = "cancelling"
MM, KM = 1e-3, 1e3


def _rms(level):
    return float(np.sqrt(np.nanmean(np.square(level))))


def test_a_satellite_less_itself_is_explained(lab):
    assert "a satellite less itself is zero" in lab.run(satellite="low", reference="low").problem


def test_rovers_clock_cancels_in_the_double_difference_only(lab):
    near, far = (lab.run(rover_clock=ms) for ms in (0, 1))
    np.testing.assert_allclose(far.levels.double, near.levels.double, atol=0.01 * MM)  # a low satellite's troposphere changes by 2 mm/s
    moved = far.levels.single - near.levels.single
    np.testing.assert_allclose(moved, 299_792.458, atol=0.01)  # c times a millisecond
    np.testing.assert_allclose(far.levels.undifferenced[:2], near.levels.undifferenced[:2], atol=1e-6)  # the master's


def test_believed_tags_leave_the_range_rates_times_the_clock_error(lab):
    """Second route: the simulator's own range rates, differenced twice, times the rover's clock error at each epoch."""
    settings = {"rover_clock": 1, "atmosphere": ""}
    by_code, by_tags = (lab.run(transmission=way, **settings) for way in ("code", "tags"))
    rover = Clock(1e-3, cancelling.DRIFT)
    geometry = prepare_geometry(_situation(1 * KM, (cancelling.STEADY, rover)))
    s, r = (geometry.tracks.satellites.index(name) for name in by_code.names)
    seconds = by_code.seconds
    errors = np.stack([cancelling.STEADY.error(seconds), rover.error(seconds)])
    rate = geometry.rate[:, :, s] - geometry.rate[:, :, r]
    rate += 299_792_458.0 * (geometry.tracks.clock_drift[:, s] - geometry.tracks.clock_drift[:, r])
    expected = -(errors[1] * rate[1] - errors[0] * rate[0])
    np.testing.assert_allclose((by_tags.levels.double - by_code.levels.double)[0], expected, atol=0.1 * MM)
    assert np.abs(expected).min() > 0.2


def test_ionosphere_left_is_the_difference_of_klobuchars_model(lab):
    """Second route: the model called at both ends for both satellites, at the middle epoch; it changes by 0.2 mm in 150 s."""
    result = lab.run(atmosphere="I", length=10)
    preset = _situation(10 * KM, (Clock(), Clock()))
    tracks, middle = prepare_geometry(preset).tracks, 150
    columns = [tracks.satellites.index(name) for name in result.names]
    delays = [_delays(preset, tracks.position[middle, columns], receiver, middle) for receiver in range(2)]
    on_carriers = -((delays[1] - delays[0])[0] - (delays[1] - delays[0])[1])
    assert result.atmosphere == pytest.approx(on_carriers, abs=0.3 * MM)
    assert lab.run(atmosphere="I", length=10, observable="code").atmosphere == pytest.approx(-result.atmosphere, rel=1e-9)


def _delays(preset, satellites, receiver, epoch):
    """Return Klobuchar's delays (2,) [m] on L1 of two satellites (2, 3) at one receiver."""
    place = antenna_position(preset, receiver, np.array([float(epoch)]))[0]
    azimuth, elevation = azimuth_elevation((satellites - place) @ enu_rotation(place).T)
    latitude, longitude, _ = geodetic_from_ecef(place)
    time = add_seconds(np.datetime64(preset.start, "ns"), float(epoch))
    return klobuchar(np.array(NOMINAL_IONOSPHERE), time, latitude, longitude, azimuth, elevation)


def _situation(length, clocks):
    east, north = cancelling.DIRECTION * length
    return replace(cancelling.SITUATION, trajectory=Static(place_enu=(east, north, 0.0)), clocks=clocks)


def test_atmosphere_grows_with_the_length(lab):
    """The ionosphere in proportion; the troposphere faster: ten kilometres along the tangent are eight metres up."""
    for kinds, rel in (("I", 0.03), ("IT", 0.15)):
        left = [lab.run(length=length, atmosphere=kinds).atmosphere for length in (0, 5, 10)]
        assert left[0] == pytest.approx(0.0, abs=0.001 * MM)
        assert left[2] / left[1] == pytest.approx(2.0, rel=rel)
        assert abs(left[2]) > 10 * MM


def test_whole_atmosphere_is_the_sum_of_its_parts(lab):
    both, ionosphere, troposphere = (lab.run(length=10, atmosphere=kinds).atmosphere for kinds in ("IT", "I", "T"))
    assert both == pytest.approx(ionosphere + troposphere, abs=0.001 * MM)
    assert lab.run(length=10, atmosphere="").atmosphere == 0.0


def test_the_average_of_a_long_baseline_is_what_the_atmosphere_left(lab):
    """The rest is multipath: 300 s hold five of its correlation times, so its average is at most some millimetres."""
    with_air, without = (lab.run(length=10, atmosphere=kinds) for kinds in ("IT", ""))
    np.testing.assert_allclose((with_air.levels.double - without.levels.double).mean(), with_air.atmosphere, atol=0.01 * MM)


def test_presets_show_what_they_promise(lab, dataset):
    dataset("geonet-0759-3040")
    result = {p.name: lab.run(**p.settings) for p in lab.presets}
    size = {name: [_rms(level) for level in one.levels] for name, one in result.items()}
    assert size["start"][0] > 50 * KM > 5 * KM > size["start"][1] > 1 * KM
    assert size["start"][2] < 10 * MM
    assert size["millisecond"][1] > 290 * KM
    assert size["millisecond"][2] == pytest.approx(size["start"][2], abs=0.01 * MM)
    assert 0.1 < size["tags"][2] < 0.8
    assert size["zero"][2] < size["start"][2] < 10 * MM < 30 * MM < size["ten"][2]
    assert all(one < 10 * MM for one in size["grain"])
    assert 0.5 < size["code"][2] < 3
    assert size["real"][0] > 100 * KM
    assert size["real"][2] < 20 * MM


def test_noise_grows_by_the_square_root_of_two_and_by_two(lab):
    """Pooled over twenty seeds: multipath of 60 s leaves some hundred independent values of the low satellite, so 8 % at 3 sigma."""
    grains = np.array([[sigma for sigma, _ in lab.run(clocks=False, atmosphere="", length=0, seed=seed).grains] for seed in range(1, 21)])
    pooled = np.sqrt(np.mean(grains**2, axis=0))
    np.testing.assert_allclose(pooled / pooled[0], [1, np.sqrt(2), 2], rtol=0.08)


@pytest.mark.parametrize(
    ("settings", "reached"),
    [
        ({}, False),
        ({"length": 5, "rover_clock": 0.5}, False),
        ({"length": 5, "rover_clock": 0.5, "satellite": "high"}, True),
        ({"length": 5, "rover_clock": 0.5, "satellite": "high", "transmission": "tags"}, False),
        ({"length": 4, "rover_clock": 0.5, "satellite": "high"}, False),  # against the rules
        ({"data": "mine"}, False),
    ],
)
def test_goal_is_judged(lab, settings, reached):
    assert lab.goal("calm").judge(lab.run(**settings))[0] == reached


def test_controls_without_effect_say_why(lab):
    assert set(lab.blocked(lab.settings())) == set(cancelling.FILES)
    assert {"rover_clock", "transmission"} <= set(lab.blocked(lab.settings(clocks=False)))
    assert set(cancelling.SIMULATION_ONLY) <= set(lab.blocked(lab.settings(data="real")))
    assert set(lab.blocked(lab.settings(data="mine"))) == set(cancelling.SIMULATION_ONLY)


@pytest.mark.parametrize("observable", ["carrier", "code"])
def test_what_is_blocked_has_no_effect_and_the_rest_has(lab, observable):
    """On perfect clocks every control moves the numbers, but those that are said not to."""
    start = lab.run(clocks=False, length=5, observable=observable)
    blocked = lab.blocked(start.settings)
    for control in cancelling.CONTROLS:
        if control.name in ("data", "clocks", "observable", *cancelling.FILES):
            continue
        other = next(value for value in control.corners if value not in (start.settings[control.name], "high"))
        moved = lab.run(**start.settings | {control.name: other})
        is_same = bool(moved.levels) and np.allclose(moved.levels.double, start.levels.double, atol=0.01 * MM, rtol=0)
        assert is_same == (control.name in blocked), control.name


def test_real_stations(lab, dataset):
    dataset("geonet-0759-3040")
    result = lab.run(data="real")
    assert result.length == pytest.approx(3335.39, abs=0.01)  # registry, by RTKLIB
    assert result.levels.double.shape == (1, 120)
    assert np.nanmax(np.abs(result.levels.double)) < result.wavelength / 4  # on the right cycle throughout
    code = lab.run(data="real", observable="code")
    assert code.cycles == 0
    assert _rms(code.levels.double) < 3


def test_whole_cycles_of_real_carriers_add_up(lab, dataset):
    """Satellite s less reference, and the reference less s: the same number with the other sign."""
    dataset("geonet-0759-3040")
    one, other = (lab.run(data="real", satellite=s, reference=r) for s, r in (("low", "middle"), ("middle", "low")))
    assert one.cycles == -other.cycles != 0


def test_own_files(lab, tmp_path):
    assert "your master, rover and navigation files are missing" in lab.run(data="mine").problem
    preset = replace(find_preset("static-rtk-5km"), duration=60.0, systems="G")
    write_simulation(tmp_path, simulate(preset, np.random.default_rng(5)))
    names = dict(zip(cancelling.FILES, ("master.obs", "rover.obs", "broadcast.nav"), strict=True))
    result = lab.run(data="mine", **{k: str(tmp_path / v) for k, v in names.items()})
    assert result.problem == ""
    assert result.length == pytest.approx(5000, abs=1)
    assert _rms(result.levels.double) < 50 * MM
    broken = lab.run(data="mine", **dict.fromkeys(cancelling.FILES, str(tmp_path / "truth.csv")))
    assert broken.problem.startswith("No answer: ")
