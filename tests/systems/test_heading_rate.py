"""Heading rate: against the truth of simulated bodies, and what its sigma promises."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import gnsslab
from gnsslab.gnss.relative import Status
from gnsslab.gnss.selection import keep_epochs
from gnsslab.gnss.weighting import NoiseModel
from gnsslab.simulate import LOW_COST, SURVEY, Static, find_preset, simulate, with_length
from gnsslab.systems.dual_antenna import dual_antenna_attitude
from gnsslab.systems.heading_rate import heading_rate

DEG = np.radians(1.0)


def attitude_by_hand(heading_deg, seconds=None, sigma_deg=0.2, status=Status.FIXED):
    """Return what heading_rate reads of an Attitude."""
    seconds = np.arange(len(heading_deg)) if seconds is None else np.array(seconds)
    return SimpleNamespace(
        time=np.datetime64("2024-06-24T08:20:00", "ns") + (seconds * 1000).astype("timedelta64[ms]"),
        status=np.broadcast_to(status, len(heading_deg)),
        heading=np.radians(heading_deg) % (2 * np.pi),
        sigma_heading=np.broadcast_to(sigma_deg * DEG, len(heading_deg)),
    )


@given(start=st.floats(0, 360), rate=st.floats(-170, 170), interval=st.sampled_from([0.1, 0.5, 1.0, 5.0]))
def test_a_steady_turn_is_its_rate_across_north_too(start, rate, interval):
    seconds = np.arange(6) * interval
    found = heading_rate(attitude_by_hand(start + rate * np.arange(6), seconds))
    assert np.isnan(found.rate[0])
    np.testing.assert_allclose(np.degrees(found.rate[1:]) * interval, rate, atol=1e-9)


def test_after_a_gap_and_around_an_unsolved_epoch_there_is_none():
    found = heading_rate(attitude_by_hand([0, 1, 2, 3, np.nan, 5, 6], [0, 1, 2, 5, 6, 7, 8]))
    assert np.isnan(found.rate).tolist() == [True, False, False, True, True, True, False]


def test_one_epoch_has_no_rate():
    assert np.isnan(heading_rate(attitude_by_hand([10.0])).rate).tolist() == [True]


def test_what_lasts_cancels_and_what_is_new_does_not():
    two = attitude_by_hand([10.0, 11.0])
    nothing_lasts, everything = (heading_rate(two, NoiseModel(correlated_share=share, correlation_time=1e9)) for share in (0.0, 1.0))
    assert np.degrees(nothing_lasts.sigma[1]) == pytest.approx(0.2 * np.sqrt(2))
    assert everything.sigma[1] == pytest.approx(0.0, abs=1e-5)
    floating = heading_rate(attitude_by_hand([10.0, 11.0], status=Status.FLOAT), NoiseModel(correlated_share=1.0))
    assert np.degrees(floating.sigma[1]) == pytest.approx(0.2 * np.sqrt(2)), "of a filter's own errors nothing is promised"


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("static-baseline", {"noise": SURVEY}),
        ("static-baseline", {"noise": LOW_COST}),
        ("ship-heading", {}),
        ("car-heading", {}),
        ("paper-a-turntable", {"noise": LOW_COST, "events": ()}),
    ],
    ids=["survey", "low cost", "ship", "car", "turntable"],
)
def test_the_rate_is_the_true_one_within_its_sigma(name, changes):
    """Of honest sigmas the errors are one in the mean square: between a half and one and a half is asked of so simple a model of noise."""
    preset = replace(find_preset(name), **{"duration": 200.0, **changes})
    simulation = simulate(preset, np.random.default_rng(5))
    found = heading_rate(dual_antenna_attitude(*simulation.observations, simulation.ephemerides))
    true_rate = np.diff(np.unwrap(simulation.truth.heading)) / preset.interval
    off = ((found.rate[1:] - true_rate) / found.sigma[1:])[30:]
    off = off[np.isfinite(off)]
    assert len(off) > 120
    assert 0.5 < np.sqrt(np.mean(off**2)) < 1.5
    assert np.abs(off).max() < 5


def test_a_longer_baseline_turns_more_surely():
    sigmas = []
    for length in (0.5, 5.0):
        preset = replace(with_length(find_preset("static-baseline"), length), duration=30.0, trajectory=Static())
        simulation = simulate(preset, np.random.default_rng(5))
        sigmas.append(np.nanmedian(heading_rate(dual_antenna_attitude(*simulation.observations, simulation.ephemerides)).sigma))
    assert sigmas[0] / sigmas[1] == pytest.approx(10.0, rel=0.1)


def test_a_roof_does_not_turn(campaign):
    real = campaign("matrtklib-static")
    found = heading_rate(dual_antenna_attitude(real.base, real.rover, real.ephemerides))
    off = found.rate[1:] / found.sigma[1:]
    assert len(off) == 300
    assert 0.3 < np.sqrt(np.mean(off**2)) < 1.5
    assert abs(np.mean(found.rate[1:])) < 4 * np.median(found.sigma[1:]) / np.sqrt(300)


def test_it_is_a_public_name_and_leaves_the_attitude_alone():
    assert gnsslab.heading_rate is heading_rate
    attitude = attitude_by_hand([1.0, 2.0, 3.0])
    for array in (attitude.time, attitude.heading):
        array.flags.writeable = False
    heading_rate(attitude)


def test_epochs_that_a_receiver_lacks_make_a_gap():
    simulation = simulate(replace(find_preset("static-baseline"), duration=30.0), np.random.default_rng(5))
    master, rover = simulation.observations
    keep = ~np.isin(np.arange(30), [12, 13])
    found = heading_rate(dual_antenna_attitude(keep_epochs(master, keep), rover, simulation.ephemerides))
    assert np.flatnonzero(np.isnan(found.rate)).tolist() == [0, 12, 13, 14]
