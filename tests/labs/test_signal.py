"""Lab of one satellite: every corner of every control computes or explains itself; presets show what they promise."""

import numpy as np
import pytest

from gnsslab.gnss.signals import SPEED_OF_LIGHT, wavelength
from gnsslab.labs import signal
from gnsslab.labs.signal import signal_lab
from gnsslab.simulate.receivers import white_factor

LAB = "signal"

L1 = wavelength("G", "1")
MM = 1e-3
QUIET = {"multipath": 0, "code_noise": 0.1}


def test_table_has_one_row_an_epoch(lab):
    columns = lab.table(lab.run())
    assert {len(column) for column in columns.values()} == {300}
    assert all(np.isfinite(columns[name]).sum() >= 299 for name in columns if name not in ("time_gps", "slip_found"))


@pytest.mark.parametrize("cycles", [-10, -3, 1, 2, 8])
def test_a_slip_is_that_many_wavelengths(lab, cycles):
    """Up in the carrier to the millimetre, down in code minus carrier to the code's noise."""
    track = lab.run(slip_cycles=cycles, **QUIET).track
    before, after = track.carrier[: track.placed], track.carrier[track.placed :]
    noise_of_mean = np.sqrt(2 / 150)  # the difference of two means of 150 readings
    assert np.mean(after) - np.mean(before) == pytest.approx(cycles * L1, abs=4 * 3 * MM * noise_of_mean + 2 * MM)
    assert track.step == pytest.approx(-cycles * L1, abs=4 * 0.15 * noise_of_mean)
    assert track.found[track.placed]


@pytest.mark.parametrize("clock", ["free", "jumping"])
def test_the_receiver_clock_cancels_in_code_minus_carrier_and_nowhere_else(lab, clock):
    steered, other = lab.run().track, lab.run(clock=clock).track
    np.testing.assert_allclose(other.code_minus_carrier, steered.code_minus_carrier, atol=3 * MM)  # rounded as in a file
    drift = SPEED_OF_LIGHT * (signal.CLOCKS[clock].drift - signal.CLOCKS["steered"].drift)
    assert np.median(other.range_rate - steered.range_rate) == pytest.approx(drift, rel=0.01)
    assert not other.found.any()


def test_a_clock_jump_moves_code_and_carrier_by_300_km(lab):
    track = lab.run(clock="jumping").track
    for rate in (track.code_rate, track.carrier_rate):
        assert np.nanmin(rate) == pytest.approx(-1e-3 * SPEED_OF_LIGHT, rel=0.01)


def test_the_ionosphere_counts_twice(lab):
    """The slope of code minus carrier, fitted here on its own, against the delays the simulator put in."""
    track = lab.run(ionosphere=4, elevation_deg=20, **QUIET).track
    geometry = signal._geometry("steered", 4)
    delay = geometry.ionosphere[0][:, geometry.tracks.satellites.index(track.satellite)]
    growth = 2 * (delay[-1] - delay[0])
    assert abs(growth) > 2.0  # [m], else there is nothing to see
    fitted = np.polyfit(track.seconds, track.code_minus_carrier, 1)[0] * track.seconds[-1]
    assert fitted == pytest.approx(growth, abs=4 * 0.3 * np.sqrt(12 / 300))  # sigma of a slope, code of 0.3 m at 15 deg
    assert track.ionosphere_twice[-1] == pytest.approx(growth, rel=0.03)
    none = lab.run(ionosphere=0, elevation_deg=20, **QUIET).track
    assert abs(none.ionosphere_twice[-1]) < 0.1


@pytest.mark.parametrize("elevation_deg", [20, 50, 75])
def test_scatter_is_that_of_the_simulated_law(lab, elevation_deg):
    """Without multipath: sigma times sqrt(1/2 + 1/(2 sin^2 el)), to four sigma of a standard deviation of 300 readings."""
    track = lab.run(elevation_deg=elevation_deg, multipath=0, code_noise=0.5, carrier_noise=2).track
    grown = white_factor(track.elevation)
    assert track.sigma_code == pytest.approx(0.5 * grown, rel=4 / np.sqrt(600))
    assert track.sigma_carrier == pytest.approx(2 * MM * grown, rel=4 / np.sqrt(600))


def test_the_corrected_equation_leaves_a_constant_and_the_printed_one_runs_away(lab):
    corrected, printed = (lab.run(clock="free", equation=name).track.left for name in ("corrected", "printed"))
    assert np.ptp(corrected) < 0.03  # [m]: the carrier's noise
    run = 2 * SPEED_OF_LIGHT * 1e-7 * 299
    assert printed[-1] - printed[0] == pytest.approx(run, rel=1e-3)
    told = [lab.readouts(lab.run(clock="free", equation=name))[4] for name in ("corrected", "printed")]
    assert [(one.value, one.unit) for one in told] == [("0.01", "m"), ("17.9", "km")]  # 2 c 1e-7 299 s, and the carrier's noise


def test_presets_show_what_they_promise(lab):
    track = {p.name: lab.run(**p.settings).track for p in lab.presets if "data" not in p.settings}
    ratio = {name: signal._ratio(one) for name, one in track.items()}
    assert ratio["start"] > 100
    assert ratio["cheap"] > 100
    assert track["cheap"].sigma_code / track["start"].sigma_code > 3
    assert track["multipath"].sigma_code > 3 * track["start"].sigma_code
    assert track["cycle-slip"].step == pytest.approx(-0.95, abs=0.15)
    assert track["cycle-slip"].seconds[track["cycle-slip"].found] == pytest.approx([150.0], abs=1.0)
    assert track["small-slip"].found.sum() == 1
    assert abs(track["small-slip"].step) < track["small-slip"].sigma_code
    assert np.degrees(track["horizon"].elevation) < 12
    zenith = lab.run(elevation_deg=80).track
    for name in ("sigma_code", "sigma_carrier"):
        assert 2.5 < getattr(track["horizon"], name) / getattr(zenith, name) < 6
    assert track["ionosphere"].ionosphere_twice[-1] > 2
    assert track["printed"].left[-1] == pytest.approx(18_000, rel=0.02)


@pytest.mark.parametrize(
    ("settings", "name", "reached"),
    [
        ({}, "hidden", False),
        ({"slip_cycles": 1}, "hidden", False),
        ({"slip_cycles": 1, "slip_second": 1, "elevation_deg": 75}, "hidden", False),  # 54 mm above a threshold of 50
        ({"slip_cycles": 1, "slip_second": 1, "elevation_deg": 15}, "hidden", True),  # the threshold grows with the noise near the horizon
        ({"data": "station", "slip_cycles": 4, "slip_second": 3}, "hidden", False),  # against the rules
        ({"elevation_deg": 15}, "finer", False),
        ({"elevation_deg": 15, "carrier_noise": 0.5, "multipath": 0, "code_noise": 0.3}, "finer", True),
        ({"elevation_deg": 60, "carrier_noise": 0.5, "multipath": 0}, "finer", False),
    ],
)
def test_goals_are_judged(lab, settings, name, reached):
    is_reached, state = lab.goal(name).judge(lab.run(**settings))
    assert is_reached == reached, state
    assert state.startswith("Now: ")


def test_controls_without_effect_say_why(lab):
    assert set(lab.blocked(lab.settings())) == set(signal.FILES)
    for data in ("real", "station"):
        reasons = lab.blocked(lab.settings(data=data))
        assert set(signal.SIMULATION_ONLY) <= set(reasons)
        assert all(reasons.values())
    assert not set(signal.FILES) & set(lab.blocked(lab.settings(data="mine")))


def test_real_roof_carrier_is_a_hundred_times_finer(lab, dataset):
    dataset("matrtklib-static")
    for elevation_deg in (15, 25, 55, 70):
        track = lab.run(data="real", elevation_deg=elevation_deg).track
        assert signal._ratio(track) > 100
        assert 0.02 < track.sigma_code < 1.0  # [m], a survey antenna
        assert track.sigma_carrier < 3 * MM
        assert track.has_doppler
    assert np.nanstd(track.left) < 1.0  # [m]: the equation holds to the noise of the receiver's clock


def test_printed_equation_shows_on_real_data_too(lab, dataset):
    """That receiver's clock drifts by 34 m/s: as printed the equation leaves twice that."""
    dataset("matrtklib-static")
    left = lab.run(data="real", equation="printed").track.left
    assert abs(left[-1]) == pytest.approx(2 * 33.7 * 300, rel=0.02)


def test_the_set_that_travels_along_needs_no_network(lab, monkeypatch, tmp_path):
    monkeypatch.delenv("GNSSLAB_DATA_MIRROR", raising=False)
    monkeypatch.setenv("GNSSLAB_CACHE", str(tmp_path))
    result = signal_lab().run(data="station", slip_cycles=2)
    assert result.note == ""
    assert result.track.found[result.track.placed]
    assert not result.track.has_doppler
    assert "no Doppler" in lab.readouts(result)[3].note


def test_own_files_missing_are_named(lab):
    assert "your observation and navigation files are missing" in lab.run(data="mine").problem
    assert "your navigation file is missing" in lab.run(data="mine", observation_file="a.obs").problem


def test_of_a_long_file_of_ones_own_the_beginning_is_shown(lab, dataset):
    """A day at 15 s, BeiDou alone: a quarter of an hour of it, in which the carrier is still a line."""
    folder = dataset("beidou-slope")
    result = lab.run(data="mine", observation_file=folder / "base_all.obs.gz", navigation_file=folder / "base_all.nav")
    assert "the first 60 are shown" in result.note
    assert result.track.satellite.startswith("C")
    assert signal._ratio(result.track) > 50


@pytest.mark.parametrize("bands", [1, 2])
def test_own_files_give_the_noise_of_the_simulation_they_came_from(lab, tmp_path, bands):
    """The loop through RINEX; with one band there is nothing to hold the carrier against."""
    from dataclasses import replace

    from gnsslab.simulate import Noise, find_preset, simulate, write_simulation

    noise = Noise(code=0.5, carrier=0.002, code_multipath=0.0, carrier_multipath=0.0)
    write_simulation(tmp_path, simulate(replace(find_preset("static-baseline"), noise=noise, bands=bands), np.random.default_rng(5)))
    result = lab.run(data="mine", observation_file=tmp_path / "rover.obs", navigation_file=tmp_path / "broadcast.nav")
    grown = white_factor(result.track.elevation)
    assert result.track.sigma_code == pytest.approx(0.5 * grown, rel=0.2)
    if bands == 2:
        assert result.track.sigma_carrier == pytest.approx(2 * MM * grown, rel=0.2)
    else:
        assert lab.readouts(result)[1].value == "none"
