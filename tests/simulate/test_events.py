from dataclasses import replace

import numpy as np
import pytest

from gnsslab.gnss.observations import HALF_CYCLE, SLIP
from gnsslab.gnss.points import solve_points
from gnsslab.simulate import PRESETS, Static, prepare_geometry, simulate, true_motion
from gnsslab.simulate.events import Axes, Gap, GrossError, HalfCycle, Outage, Slip, Street, hidden_by_streets, locked_anew
from gnsslab.simulate.measurements import measure
from gnsslab.simulate.receivers import NO_NOISE


def changed_by(*events, epochs=40):
    """Return measurements of GPS with these events and without, of the same seed and no noise."""
    quiet = replace(PRESETS["static-baseline"], systems="G", duration=float(epochs), noise=NO_NOISE)
    pair = (measure(prepare_geometry(preset), NO_NOISE, np.random.default_rng(3))["G"] for preset in (replace(quiet, events=events), quiet))
    return *pair, np.array(quiet.time)


def test_a_slip_of_a_given_size_stays_and_is_flagged_once():
    with_event, without, _ = changed_by(Slip(10, antennas=(1,), satellites=("G11",), signals=("2W",), cycles=-7))
    m, b = with_event.satellites.index("G11"), with_event.signals.index("2W")
    step = with_event.value[1] - without.value[1]
    assert np.allclose(step[1, 10:, m, b], -7, atol=1e-6)
    step[1, 10:, m, b] = 0
    assert np.nanmax(np.abs(step)) < 1e-6  # nothing else moved
    assert np.argwhere(with_event.lli).tolist() == [[1, 10, m, b]]
    assert with_event.lli[1, 10, m, b] == SLIP
    assert (with_event.integers[1, 10:, m, b] - without.integers[1, 10:, m, b] == -7).all()


def test_slips_at_random_are_whole_cycles_of_each_signals_own():
    with_event, without, _ = changed_by(Slip(10))
    cycles = with_event.value[1] - without.value[1]
    cycles = cycles[:, 10:][np.isfinite(cycles[:, 10:])]
    whole = np.round(cycles)
    assert np.abs(cycles - whole).max() < 1e-6
    assert (np.abs(whole) >= 1).all()
    assert (np.abs(whole) <= 20).all()
    assert len(np.unique(whole)) > 10
    assert np.array_equal(with_event.integers[:, :10], without.integers[:, :10])
    assert (with_event.integers[:, 10:] != without.integers[:, 10:]).all()


def test_an_unflagged_slip_says_nothing():
    with_event, without, _ = changed_by(Slip(10, cycles=3, is_flagged=False))
    assert not with_event.lli.any()
    assert np.nanmin(np.abs(with_event.value[1] - without.value[1])[:, 10:]) == pytest.approx(3, abs=1e-6)


def test_half_cycles_are_flagged_while_they_last_and_slips_at_both_ends():
    with_event, without, _ = changed_by(HalfCycle(10, 19, antennas=(0,), satellites=("G11",)))
    m = with_event.satellites.index("G11")
    step = (with_event.value[1] - without.value[1])[0, :, m, 0]
    assert np.allclose(step, np.where((np.arange(40) >= 10) & (np.arange(40) <= 19), 0.5, 0), atol=1e-6)
    flags = with_event.lli[0, :, m, 0]
    assert flags[10] == flags[9 + 1] == HALF_CYCLE | SLIP
    assert (flags[11:20] == HALF_CYCLE).all()
    assert flags[20] == SLIP
    assert not with_event.lli[1].any()


def test_an_outage_hides_and_comes_back_with_new_integers():
    with_event, without, _ = changed_by(Outage(10, 14, antennas=(1,)))
    assert np.isnan(with_event.value[:, 1, 10:15]).all()
    assert np.array_equal(np.isnan(with_event.value[:, 0]), np.isnan(without.value[:, 0]))
    back = np.isfinite(with_event.value[1, 1, 15])
    assert back.sum() > 10
    assert (with_event.lli[1, 15][back] == SLIP).all()
    assert (with_event.integers[1, 15:] != without.integers[1, 15:]).all()


def test_an_outage_to_the_end_has_no_return():
    with_event, _, _ = changed_by(Outage(10, 39))
    assert np.isnan(with_event.value[0, :, 10:]).all()
    assert not with_event.lli.any()


def test_a_gap_hides_and_the_phase_goes_on():
    with_event, without, _ = changed_by(Gap(10, 14, antennas=(0,)))
    assert np.isnan(with_event.value[:, 0, 10:15]).all()
    assert not with_event.lli.any()
    assert np.array_equal(with_event.integers, without.integers)


def test_an_epoch_without_any_measurement_is_not_in_the_file():
    preset = replace(PRESETS["static-baseline"], duration=20.0, events=(Gap(5, 7, antennas=(0,)),))
    master, rover = simulate(preset, np.random.default_rng(1)).observations
    assert len(rover.time) == 20
    assert np.array_equal(master.time, np.delete(rover.time, [5, 6, 7]))
    assert all(np.array_equal(np.unique(table.epoch), np.arange(17)) for table in master.tables.values())


def test_everything_out_leaves_empty_observations():
    preset = replace(PRESETS["static-baseline"], duration=5.0, events=(Gap(0, 4),))
    master, _ = simulate(preset, np.random.default_rng(1)).observations
    assert len(master.time) == 0
    assert master.tables == {}


@pytest.mark.parametrize(("code", "kind"), [("C1C", 0), ("L1C", 1), ("D1C", 2), ("S1C", 3)])
def test_a_gross_error_is_in_one_number_only(code, kind):
    with_event, without, _ = changed_by(GrossError(12, code, 25.0, satellites=("G11",)))
    step = with_event.value - without.value
    m = with_event.satellites.index("G11")
    assert step[kind, 1, 12, m, 0] == pytest.approx(25.0, abs=1e-6)
    step[kind, 1, 12, m, 0] = 0
    assert np.nanmax(np.abs(step)) < 1e-6


@pytest.mark.parametrize(
    ("event", "words"),
    [
        (Slip(300), "outside the epochs 0 to 299"),
        (Slip(-1), "outside the epochs"),
        (Outage(20, 10), "outside the epochs"),
        (Gap(0, 400), "outside the epochs"),
        (Slip(1, antennas=(2,)), "an antenna that is not there; they are 0 to 1"),
        (Slip(1, satellites=("R01",)), "a satellite of none of the systems GECJ"),
        (GrossError(1, "X1C", 1.0), "an observation code is C, L, D or S"),
    ],
)
def test_events_that_cannot_be_are_refused_in_words(event, words):
    with pytest.raises(ValueError, match=words):
        replace(PRESETS["static-baseline"], events=(event,))


def in_a_street(roofs_deg=60.0, **changes):
    """Return a preset, driving north at first, and its measurements of GPS in a street from epoch 10 to 29 and without it."""
    quiet = replace(PRESETS["city-heading"], systems="G", duration=40.0, noise=NO_NOISE, events=(), **changes)
    inside = replace(quiet, events=(Street(10, 29, roofs_deg=roofs_deg),))
    return inside, *(measure(prepare_geometry(preset), NO_NOISE, np.random.default_rng(3))["G"] for preset in (inside, quiet))


def test_a_street_hides_what_its_roofs_hide_and_shows_what_stands_along_it():
    preset, inside, quiet = in_a_street(trajectory=Static(heading_deg=30.0))
    lost = np.isfinite(quiet.value[0]) & ~np.isfinite(inside.value[0])  # (R, T, m, b)
    assert not lost[:, [*range(10), *range(30, 40)]].any()
    place, ephemerides = true_motion(preset, np.zeros(1)).position_ecef, prepare_geometry(preset).tracks.ephemerides
    points = solve_points(simulate(replace(preset, events=()), np.random.default_rng(1)).observations[0], ephemerides, mask_deg=0.0)
    assert np.linalg.norm(points.position_ecef[0] - place[0]) < 10.0
    expected = np.zeros(len(inside.satellites), dtype=bool)
    for m, name in enumerate(inside.satellites):
        azimuth, elevation = (getattr(points, angle)[20, points.names.index(name)] for angle in ("azimuth", "elevation"))
        to_the_side = np.arcsin(np.abs(np.sin(azimuth - np.radians(30.0))))  # a house 10 m away has its roof 10 tan(60 deg) up
        expected[m] = np.tan(elevation) * 10.0 < 10.0 * np.tan(np.radians(60.0)) * np.sin(to_the_side)
    assert 0 < expected.sum() < len(expected)
    assert (lost[:, 20].all(axis=(0, 2)) == expected).all()
    assert (lost[:, 20].any(axis=(0, 2)) == expected).all()


def test_after_a_street_lock_is_new():
    _, inside, quiet = in_a_street()
    back = np.isfinite(inside.value[1][:, 1:]) & ~np.isfinite(inside.value[1][:, :-1]) & np.isfinite(quiet.value[1][:, :-1])
    assert back[:, 29].any(), "at the end of the street"
    assert ((inside.lli[:, 1:] == SLIP) == back).all()
    step = inside.integers - quiet.integers
    moved = np.diff(step, axis=1)[back]
    assert (np.abs(moved) >= 1).all()
    assert (np.abs(moved) <= 20).all()
    assert not np.diff(step, axis=1)[~back & np.isfinite(inside.value[1][:, 1:])].any()


def test_a_street_of_one_antenna_is_none_of_the_others():
    event = Street(0, 0, antennas=(1,))
    sight = np.array([[np.pi / 2]]), np.array([[0.1]])
    assert [hidden_by_streets((event,), receiver, np.zeros(1), *sight).item() for receiver in (0, 1)] == [False, True]


def test_without_a_street_chance_is_the_same_as_ever(rng):
    """Random numbers drawn for streets would change every other simulation."""
    axes = Axes(2, 3, ("G01",), ("1C",))
    cycles, flags = locked_anew(np.zeros((2, 3, 1), dtype=bool), axes, rng)
    assert not cycles.any()
    assert not flags.any()
    assert rng.random() == np.random.default_rng(20240624).random()


@pytest.mark.parametrize("roofs_deg", [-1.0, 90.0, np.nan])
def test_roofs_that_are_none_are_refused(roofs_deg):
    with pytest.raises(ValueError, match="the elevation of the roofs is from 0 to below 90 degrees"):
        replace(PRESETS["city-heading"], events=(Street(0, 1, roofs_deg=roofs_deg),))
