"""Recordings of one receiver: simulated and read ones obey the same equation."""

from dataclasses import replace

import numpy as np
import pytest

from gnsslab.gnss.observation_equations import carrier_range, code_range
from gnsslab.labs.recordings import read_recording, shown_epochs, simulated_recording, with_slip
from gnsslab.simulate import NO_NOISE, SURVEY, find_preset, prepare_geometry, simulate

PRESET = replace(find_preset("static-baseline"), systems="G", duration=30.0)


@pytest.fixture(scope="module")
def geometry():
    """GPS over a roof for half a minute."""
    return prepare_geometry(PRESET)


def _first_codes(recording):
    pair = recording.pair
    columns = [np.flatnonzero((pair.satellite == s) & (pair.band == 0))[0] for s in range(len(pair.satellites))]
    return pair.rover.code[:, columns], (pair.rover.phase * pair.wavelength)[:, columns]


def test_simulated_terms_are_the_truth(geometry, rng):
    recording = simulated_recording(geometry, NO_NOISE, rng)
    code, carrier = _first_codes(recording)
    for left in (code - code_range(recording.terms), carrier - carrier_range(recording.terms)):
        assert np.nanmax(np.abs(left - np.nanmedian(left, axis=0))) < 2e-3  # [m], rounded as in a file


def test_the_partner_is_silent(geometry, rng):
    recording = simulated_recording(geometry, SURVEY, rng)
    assert not recording.pair.master.phase.any()
    assert not recording.pair.master.lli.any()
    assert recording.elevation.shape == (30, len(recording.pair.satellites))


def test_a_slip_moves_one_carrier_from_one_epoch_on(geometry, rng):
    before = simulated_recording(geometry, SURVEY, rng)
    after = with_slip(before, [3], 10, [7])
    moved = after.pair.rover.phase - before.pair.rover.phase
    assert (moved[10:, 3] == 7).all()
    moved[10:, 3] -= 7
    assert not moved[np.isfinite(moved)].any()


def test_a_file_read_obeys_the_equation_to_a_metre(rng):
    """The clock comes from single points: code noise of 0.4 m, twice as much in the clock."""
    simulation = simulate(PRESET, rng)
    recording = read_recording(simulation.observations[0], simulation.ephemerides)
    _, carrier = _first_codes(recording)
    left = carrier - carrier_range(recording.terms)
    high = recording.elevation[0] > np.radians(15)
    assert high.sum() >= 6
    assert np.std(left[:, high], axis=0).max() < 1.5
    among_satellites = left[:, high] - left[:, high][:, :1]
    assert np.std(among_satellites, axis=0).max() < 0.02  # [m]: what is left of the clock is common to all


@pytest.mark.parametrize("name", ["cssrlib-078", "matrtklib-static"])
def test_real_codes_obey_the_equation(campaign, name):
    real = campaign(name)
    recording = read_recording(real.rover, real.ephemerides)
    code, _ = _first_codes(recording)
    left = code - code_range(recording.terms)
    high = np.nanmedian(recording.elevation, axis=0) > np.radians(15)
    assert high.sum() >= 5
    assert np.nanmax(np.abs(left[:, high])) < 15.0  # [m]: orbits, ionosphere, group delays; a sign gone wrong would be kilometres


def test_a_long_file_is_cut(rng):
    simulation = simulate(replace(PRESET, duration=620.0), rng)
    assert len(read_recording(simulation.observations[0], simulation.ephemerides).time) == 600


@pytest.mark.parametrize(("epochs", "every", "shown"), [(300, 1, 300), (900, 1, 600), (5000, 0.2, 3000), (2880, 30, 60), (40, 30, 40), (0, 1, 0)])
def test_ten_minutes_are_shown_or_sixty_epochs(epochs, every, shown):
    time = np.datetime64("2024-06-24", "ns") + (np.arange(epochs) * every * 1e9).astype("timedelta64[ns]")
    assert shown_epochs(time).sum() == shown


def test_without_gps_the_other_systems_serve(rng):
    simulation = simulate(replace(PRESET, systems="E"), rng)
    assert {name[0] for name in read_recording(simulation.observations[0], simulation.ephemerides).pair.satellites} == {"E"}


def test_without_any_system_it_is_said(rng):
    simulation = simulate(PRESET, rng)
    empty = replace(simulation.observations[0], tables={})
    with pytest.raises(ValueError, match="the file holds no satellite of G, E, C, J"):
        read_recording(empty, simulation.ephemerides)
