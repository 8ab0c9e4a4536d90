"""The measurements against a second implementation, one satellite at a time, and against the statistics they promise."""

from dataclasses import replace

import numpy as np
import pytest
from scalar_orbits import pseudorange

from gnsslab.gnss.frames import ecef_from_geodetic, enu_rotation
from gnsslab.gnss.signals import SPEED_OF_LIGHT, wavelength
from gnsslab.simulate import PRESETS, prepare_geometry
from gnsslab.simulate.geometry import antenna_position
from gnsslab.simulate.measurements import measure
from gnsslab.simulate.receivers import NO_NOISE, Clock, Noise, hardware_delay, white_factor
from gnsslab.simulate.trajectories import Ship

MM = 1e-3
SIGMA = 4  # a statistic further than 4 of its own standard deviations off fails
MILLISECONDS = (Clock(0.4e-3, 1e-6), Clock(-0.5e-3, -2e-7))


def without_air(preset, **changes):
    return replace(preset, **{"ionosphere": None, "humidity": None, "clocks": MILLISECONDS, "bands": 3} | changes)


def measured(preset, noise=NO_NOISE, seed=1):
    geometry = prepare_geometry(preset)
    return geometry, measure(geometry, noise, np.random.default_rng(seed))


def scalar_pseudoranges(preset, geometry, column, epochs):
    """Return pseudoranges (R, k) [m] of one satellite by the second implementation."""
    eph = geometry.tracks.ephemerides
    result = np.zeros((preset.receivers, len(epochs)))
    for receiver in range(preset.receivers):
        for j, k in enumerate(epochs):
            clock = preset.clocks[receiver].offset + preset.clocks[receiver].drift * k * preset.interval
            place = antenna_position(preset, receiver, np.array([k * preset.interval - clock]))[0]
            result[receiver, j] = pseudorange(eph, geometry.tracks.index[k, column], preset.time[k], clock, place)
    return result


@pytest.mark.parametrize("name", ["static-baseline", "car-rtk", "ship-heading", "static-rtk-5km"])
def test_pseudoranges_and_double_differences_equal_the_second_implementation(name):
    preset = without_air(PRESETS[name], events=())
    geometry, systems = measured(preset)
    epochs = [0, 113, 299]
    for system, one in systems.items():
        columns = [geometry.tracks.satellites.index(satellite) for satellite in one.satellites]
        truth = np.stack([scalar_pseudoranges(preset, geometry, column, epochs) for column in columns], axis=-1)  # (R, k, m)
        assert np.abs(geometry.pseudorange[:, epochs][..., columns] - truth).max() < 0.01 * MM
        for b, signal in enumerate(one.signals):
            phase = (one.value[1] - one.integers)[..., b][:, epochs] * wavelength(system, signal[0])
            seen = np.isfinite(phase).all(axis=(0, 1))
            difference = double_difference(phase[..., seen]) - double_difference(truth[..., seen])
            assert seen.sum() >= 2
            assert np.abs(difference).max() < 0.1 * MM


def double_difference(values):
    """Return rover - master, satellite - first satellite, of (R, T, m)."""
    single = values[1] - values[0]
    return single - single[:, :1]


def test_a_clock_error_moves_the_moment_of_measurement():
    """A ship at 6 m/s with a clock 0.5 ms late has been measured 3 mm from where it is at the tag: seen against the truth at the tag."""
    preset = without_air(PRESETS["ship-heading"], trajectory=Ship(heave=0.0, roll_deg=0.0, pitch_deg=0.0))
    seconds = np.zeros(1)
    place = antenna_position(preset, 0, seconds)
    early = antenna_position(preset, 0, seconds - 0.5e-3)
    assert np.linalg.norm(place - early) == pytest.approx(3 * MM, rel=0.05)  # the lever arm swings a little too


def test_code_minus_phase_is_the_ambiguity_alone_without_air():
    preset = without_air(PRESETS["static-baseline"])
    _, systems = measured(preset)
    for system, one in systems.items():
        for b, signal in enumerate(one.signals):
            ambiguity = one.integers[..., b] + one.fractions[:, np.newaxis, np.newaxis, b]
            left = one.value[0][..., b] - wavelength(system, signal[0]) * (one.value[1][..., b] - ambiguity)
            left = left[..., np.isfinite(left).all(axis=(0, 1))]
            assert left.shape[-1] >= 2
            assert np.ptp(left, axis=1).max() < 0.01 * MM  # the same at all epochs
            assert np.ptp(left[1] - left[0]) < 0.01 * MM  # the satellites' delays are the same for both receivers, a system's delay remains
            assert np.abs(left).max() < 20  # [m]: 33 ns of group delay, 12 m in the receiver


def test_ionosphere_delays_the_code_and_advances_the_phase():
    preset = replace(PRESETS["static-baseline"], humidity=None, clocks=MILLISECONDS)
    geometry, systems = measured(preset)
    _, without = measured(replace(preset, ionosphere=None))
    one, bare = systems["G"], without["G"]
    columns = [geometry.tracks.satellites.index(satellite) for satellite in one.satellites]
    for b, scale in enumerate((1.0, (1575.42 / 1227.60) ** 2)):
        code = (one.value[0] - bare.value[0])[..., b]
        phase = (one.value[1] - bare.value[1])[..., b] * wavelength("G", one.signals[b][0])
        assert np.nanmax(np.abs(code + phase)) < 0.01 * MM
        assert np.nanmax(np.abs(code - scale * geometry.ionosphere[..., columns])) < 0.01 * MM
        assert np.nanmin(code) > 1.0  # [m]: the night term alone is 1.5 m


def test_troposphere_delays_both_and_grows_towards_the_horizon():
    preset = replace(PRESETS["static-baseline"], ionosphere=None, clocks=MILLISECONDS)
    geometry, systems = measured(preset)
    _, without = measured(replace(preset, humidity=None))
    delay = np.concatenate([(one.value[0] - without[system].value[0])[0, 0, :, 0] for system, one in systems.items()])
    elevation = np.concatenate([geometry.elevation[0, 0, [geometry.tracks.satellites.index(s) for s in one.satellites]] for one in systems.values()])
    seen = np.isfinite(delay)
    expected = 2.4 / np.sin(elevation[seen])
    assert np.abs(delay[seen] / expected - 1).max() < 0.2
    phase = (systems["G"].value[1] - without["G"].value[1])[..., 0] * wavelength("G", "1")
    assert np.nanmax(np.abs(phase - (systems["G"].value[0] - without["G"].value[0])[..., 0])) < 0.01 * MM


@pytest.mark.parametrize(
    ("name", "limit"), [("static-baseline", 0.02 * MM), ("car-rtk", 0.1 * MM), ("ship-heading", 0.1 * MM), ("drone-hop", 0.1 * MM)]
)
def test_doppler_is_the_rate_of_the_phase(name, limit):
    preset = without_air(PRESETS[name], interval=0.02, duration=2.0, start="2024-06-24T08:20:00", events=())
    if name == "drone-hop":
        preset = replace(preset, trajectory=replace(preset.trajectory, ground=-45.0))  # starts within the turn
    _, systems = measured(preset)
    for system, one in systems.items():
        lam = np.array([wavelength(system, signal[0]) for signal in one.signals])
        rate = (one.value[1][:, 2:] - one.value[1][:, :-2]) / (2 * preset.interval)
        difference = (rate + one.value[2][:, 1:-1]) * lam  # [m/s]
        assert np.nanmax(np.abs(difference)) < limit


def test_doppler_contains_the_change_of_the_delays():
    preset = replace(PRESETS["static-baseline"], clocks=MILLISECONDS)
    _, systems = measured(preset)
    for one in systems.values():
        rate = (one.value[1][:, 2:] - one.value[1][:, :-2]) / (2 * preset.interval)
        assert np.nanmax(np.abs(rate + one.value[2][:, 1:-1])) < 0.001  # [Hz]


def noise_of(preset, noise, seed=7):
    """Return elevations (R, T, m) and the noise (4, R, T, m, b) of one system in metres, metres, m/s and dB-Hz."""
    geometry, noisy = measured(preset, noise, seed)
    _, clean = measured(preset, NO_NOISE, seed)
    columns = [geometry.tracks.satellites.index(satellite) for satellite in noisy["C"].satellites]
    lam = np.array([wavelength("C", signal[0]) for signal in noisy["C"].signals])
    scale = np.ones((4, 1, 1, 1, len(lam)))
    scale[1:3] = lam
    return geometry.elevation[..., columns], (noisy["C"].value - clean["C"].value) * scale


@pytest.mark.parametrize(("kind", "field", "sigma"), [(0, "code", 0.5), (1, "carrier", 0.003), (2, "doppler", 0.05), (3, "cn0", 0.8)])
def test_white_noise_has_its_sigma_at_every_elevation(kind, field, sigma):
    preset = replace(PRESETS["static-baseline"], systems="C", duration=600.0)
    elevation, noise = noise_of(preset, replace(NO_NOISE, **{field: sigma}))
    unit = noise[kind] / sigma / (white_factor(elevation)[..., np.newaxis] if kind < 3 else 1.0)
    others = np.delete(noise, kind, axis=0)
    assert np.nanmax(np.abs(others)) < 1e-6  # the other kinds stay free of noise
    checked = 0
    for low, high in ((5, 20), (20, 40), (40, 90)):
        chosen = unit[(elevation > np.radians(low)) & (elevation <= np.radians(high))]
        chosen = chosen[np.isfinite(chosen)]
        assert abs(np.mean(chosen**2) - 1) < SIGMA * np.sqrt(2 / len(chosen))
        assert abs(np.mean(chosen)) < SIGMA / np.sqrt(len(chosen))
        checked += len(chosen)
    assert checked > 10_000
    once, next_one = unit[:, 1:], unit[:, :-1]
    product = (once * next_one)[np.isfinite(once * next_one)]
    assert abs(product.mean()) < SIGMA / np.sqrt(len(product))  # white


@pytest.mark.parametrize(("kind", "field", "sigma"), [(0, "code_multipath", 0.4), (1, "carrier_multipath", 0.0045)])
def test_multipath_has_its_sigma_and_memory(kind, field, sigma):
    tau, interval = 20.0, 30.0
    preset = replace(PRESETS["static-baseline"], systems="C", duration=9000.0, interval=interval)
    elevation, noise = noise_of(preset, replace(NO_NOISE, **{field: sigma, f"{field}_time": tau}))
    unit = noise[kind] * np.sin(elevation)[..., np.newaxis] / sigma
    a = np.exp(-interval / tau)
    product = (unit[:, 1:] * unit[:, :-1])[np.isfinite(unit[:, 1:] * unit[:, :-1])]
    squares = unit[np.isfinite(unit)] ** 2
    independent = len(squares) * (1 - a**2) / (1 + a**2)
    assert abs(squares.mean() - 1) < SIGMA * np.sqrt(2 / independent)
    assert abs(product.mean() - a) < SIGMA * np.sqrt(2 / independent)


def test_noise_of_receivers_signals_and_satellites_is_independent():
    preset = replace(PRESETS["static-baseline"], systems="C", duration=600.0)
    _, noise = noise_of(preset, replace(NO_NOISE, code=1.0, carrier=0.01))
    code, carrier = noise[:2]
    pairs = (code[0] * code[1], code[..., 0] * code[..., 1], code * carrier * 100, code[:, :, 1:] * code[:, :, :-1])
    for pair in pairs:
        good = pair[np.isfinite(pair)]
        assert abs(good.mean()) < SIGMA * good.std() / np.sqrt(len(good))


def test_integers_do_not_depend_on_the_noise_and_differ_between_signals():
    preset = PRESETS["static-baseline"]
    _, quiet = measured(preset, NO_NOISE)
    _, loud = measured(preset, Noise(code=2.0))
    for system in quiet:
        assert np.array_equal(quiet[system].integers, loud[system].integers)
        assert len(np.unique(quiet[system].integers[:, 0])) == quiet[system].integers[:, 0].size


def test_the_mask_is_kept_by_each_receiver_itself():
    preset = PRESETS["static-rtk-5km"]
    geometry, systems = measured(preset)
    columns = [geometry.tracks.satellites.index(satellite) for satellite in systems["G"].satellites]
    is_up = geometry.elevation[..., columns] > np.radians(preset.mask_deg)
    assert np.array_equal(np.isfinite(systems["G"].value[0, ..., 0]), is_up)
    assert 0 < is_up.mean() < 1


def test_the_tangent_plane_of_the_site_and_the_level_of_the_body():
    """The rover 5 km off stands 3000, 4000, 35 m from the base along the axes of the site, and is level where it is."""
    preset = PRESETS["static-rtk-5km"]
    site = ecef_from_geodetic([*np.radians(preset.site[:2]), preset.site[2]])
    baseline = enu_rotation(site) @ (antenna_position(preset, 1, np.zeros(1))[0] - antenna_position(preset, 0, np.zeros(1))[0])
    assert np.allclose(baseline, [3000.0, 4000.0, 35.0], atol=1e-6)


def test_receivers_delay_the_systems_differently():
    """Without this nothing would tell an engine with one clock for all systems from one with a clock for each."""
    delays = [[hardware_delay(system, receiver) for system in "GECJ"] for receiver in (0, 1)]
    _, systems = measured(without_air(PRESETS["static-baseline"]))
    assert len({delay for row in delays for delay in row}) == 7  # GPS is zero in both
    for system, expected in zip("GECJ", np.subtract(*delays[::-1]), strict=True):
        one = systems[system]
        code = one.value[0] - geometry_of(one, system)
        step = np.diff(code, axis=0)[np.isfinite(np.diff(code, axis=0))]
        assert step == pytest.approx(expected, abs=0.01 * MM)


def geometry_of(one, system):
    """Return what code and carrier share (R, T, m, b): the carrier [m] without its ambiguity."""
    lam = np.array([wavelength(system, signal[0]) for signal in one.signals])
    return (one.value[1] - one.integers - one.fractions[:, np.newaxis, np.newaxis]) * lam


def test_no_satellite_at_all_is_said():
    with pytest.raises(ValueError, match="no satellite rises above"):
        prepare_geometry(replace(PRESETS["static-baseline"], satellites=("G99",)))


def test_group_delays_are_in_the_code_and_of_the_right_signal():
    preset = without_air(PRESETS["static-baseline"], bands=2)
    geometry, systems = measured(preset)
    eph = geometry.tracks.ephemerides
    gamma = (1575.42 / 1227.60) ** 2
    one = systems["G"]
    for m, satellite in enumerate(one.satellites):
        column = geometry.tracks.satellites.index(satellite)
        extra = one.value[0][0, 0, m] - geometry.pseudorange[0, 0, column]
        tgd = SPEED_OF_LIGHT * eph.group_delay[geometry.tracks.index[0, column], 0]
        if np.isfinite(extra).all():
            assert extra == pytest.approx([tgd, gamma * tgd], abs=1e-6)
