"""Screening: each kind of broken carrier put into simulated data must be found, where it is and nowhere else."""

from dataclasses import replace

import numpy as np
import pytest
from small_observations import receiver, short_preset, with_flag

from gnsslab.gnss.differences import pair_receivers
from gnsslab.gnss.observations import HALF_CYCLE, SLIP
from gnsslab.gnss.screening import LONGEST_GAP, SHADOW_LOSS, cycle_slips, has_half_cycle, is_shadowed, row_medians
from gnsslab.gnss.selection import keep_epochs
from gnsslab.simulate import LOW_COST, Clock, Gap, GrossError, HalfCycle, Outage, Slip, Turntable, observe, prepare_geometry

SATELLITES = ("G05", "G06")
K = 30  # the epoch at which things happen
MILLIMETRE = 1e-3
LOWEST_KEPT = 15.0  # [deg]: below, multipath of a low-cost antenna comes near the thresholds


def simulated_pair(rng, frequencies=2, **changes):
    """Return the Pair of a minute of simulated data, its satellites' names by channel and what was measured at both ends."""
    preset = short_preset(mask_deg=LOWEST_KEPT, **changes)
    master, rover = observe(prepare_geometry(preset), preset.noise, rng).observations
    pair = pair_receivers(master, rover, preset.systems, frequencies)
    return pair, np.isfinite(pair.master.phase + pair.rover.phase)


@pytest.fixture(scope="module")
def some_satellite():
    """Name of a satellite of the simulated sky that is seen at every epoch."""
    pair, measured = simulated_pair(np.random.default_rng(0))
    return pair.satellites[pair.satellite[np.flatnonzero(measured.all(axis=0))[0]]]


def slips_of(pair, usable):
    """Return the cycle slips at carriers of 5 mm: single differences of a good receiver at medium heights."""
    return cycle_slips(pair, usable, np.full(usable.shape, 5 * MILLIMETRE))


def found(pair, slips):
    """Return the slips as (epoch, satellite, band)."""
    return {(int(t), pair.satellites[pair.satellite[i]], int(pair.band[i])) for t, i in np.argwhere(slips)}


@pytest.mark.parametrize("noise", [{}, {"noise": LOW_COST}], ids=["survey", "low-cost"])
def test_undisturbed_data_have_no_slip(rng, noise):
    pair, measured = simulated_pair(rng, **noise)
    assert measured.sum() > 500
    assert not slips_of(pair, measured).any()


def test_noisy_carriers_are_allowed_larger_steps_between_bands(rng, some_satellite):
    """Where multipath of decimetres is expected, a step of one cycle proves nothing."""
    slip = Slip(K, (1,), (some_satellite,), ("1C",), 1, is_flagged=False)
    pair, measured = simulated_pair(rng, events=(slip,))
    assert not cycle_slips(pair, measured, np.full(measured.shape, 100 * MILLIMETRE)).any()


@pytest.mark.parametrize("antenna", [0, 1])
def test_a_flagged_slip_of_either_receiver_is_found_on_its_signal_only(rng, some_satellite, antenna):
    """One band and one cycle under the mask of the geometry-free check are taken away, so that the flag alone must tell."""
    pair, measured = simulated_pair(rng, frequencies=1, events=(Slip(K, (antenna,), (some_satellite,), cycles=1),))
    assert found(pair, slips_of(pair, measured)) == {(K, some_satellite, 0)}


@pytest.mark.parametrize("signal", ["1C", "2W"])
@pytest.mark.parametrize("cycles", [1, -1, 3])
def test_an_unflagged_slip_on_one_band_makes_the_geometry_free_combination_jump(rng, some_satellite, signal, cycles):
    slip = Slip(K, (1,), (some_satellite,), (signal,), cycles, is_flagged=False)
    pair, measured = simulated_pair(rng, events=(slip,))
    assert found(pair, slips_of(pair, measured)) == {(K, some_satellite, 0), (K, some_satellite, 1)}


@pytest.mark.parametrize("antenna", [0, 1])
def test_an_unflagged_slip_on_a_single_band_is_found_by_the_doppler(rng, some_satellite, antenna):
    slip = Slip(K, (antenna,), (some_satellite,), cycles=3, is_flagged=False)
    pair, measured = simulated_pair(rng, frequencies=1, events=(slip,))
    assert found(pair, slips_of(pair, measured)) == {(K, some_satellite, 0)}


def test_slips_equal_on_both_bands_are_found_by_the_doppler_too(rng, some_satellite):
    slip = Slip(K, (1,), (some_satellite,), cycles=9, is_flagged=False)
    pair, measured = simulated_pair(rng, events=(slip,))
    assert found(pair, slips_of(pair, measured)) == {(K, some_satellite, 0), (K, some_satellite, 1)}


def test_without_doppler_a_single_bands_slip_goes_unseen_here(rng, some_satellite):
    """What the screening cannot know is left to the filter's own test."""
    slip = Slip(K, (1,), (some_satellite,), cycles=3, is_flagged=False)
    pair, measured = simulated_pair(rng, frequencies=1, events=(slip,))
    blind = [replace(tracks, doppler=np.full_like(tracks.doppler, np.nan)) for tracks in (pair.master, pair.rover)]
    assert not slips_of(replace(pair, master=blind[0], rover=blind[1]), measured).any()


@pytest.mark.parametrize("clocks", [(Clock(drift=1e-4, jump=1e-3), Clock()), (Clock(), Clock(4e-4, -3e-5, jump=1e-3))])
def test_clock_jumps_of_a_millisecond_are_no_slips(rng, clocks):
    """A millisecond is 300 km, 1.6 million cycles: common to all channels of the receiver."""
    pair, measured = simulated_pair(rng, clocks=clocks)
    steps = np.abs(np.diff(pair.rover.phase - pair.master.phase, axis=0))
    assert np.nanmax(steps) > 1e6, "no jump in the data, nothing tested"
    assert not slips_of(pair, measured).any()


def test_a_turning_antenna_is_no_slip(rng):
    """At 30 degrees a second on an arm of 0.58 m the antenna accelerates by 0.16 m/s^2 only: the Doppler follows."""
    pair, measured = simulated_pair(rng, trajectory=Turntable(still=10.0, rate_deg_s=30.0), antennas=((0.0, -0.58, 0.0), (0.0, 0.58, 0.0)))
    assert not slips_of(pair, measured).any()


def test_a_gross_code_error_is_no_slip(rng, some_satellite):
    pair, measured = simulated_pair(rng, events=(GrossError(K, "C1C", 100.0, (1,), (some_satellite,)),))
    assert not slips_of(pair, measured).any()


@pytest.mark.parametrize(("missing", "slips"), [(LONGEST_GAP, False), (LONGEST_GAP + 1, True)])
def test_a_short_gap_continues_the_count_and_a_long_one_ends_it(rng, some_satellite, missing, slips):
    gap = Gap(K, K + missing - 1, (1,), (some_satellite,))
    pair, measured = simulated_pair(rng, events=(gap,))
    expected = {(K + missing, some_satellite, band) for band in (0, 1)} if slips else set()
    assert found(pair, slips_of(pair, measured)) == expected


def test_an_outage_ends_the_count_by_its_flag(rng, some_satellite):
    pair, measured = simulated_pair(rng, events=(Outage(K, K + 1, (1,), (some_satellite,)),))
    assert found(pair, slips_of(pair, measured)) == {(K + 2, some_satellite, band) for band in (0, 1)}


def test_a_flag_at_an_epoch_that_is_not_usable_counts_at_the_next_usable_one():
    both = {"G05": ("1C",), "G06": ("1C",)}
    pair = pair_receivers(receiver(both, T=6), with_flag(receiver(both, T=6), "G05", "L1C", 2, SLIP))
    usable = np.ones((6, 2), dtype=bool)
    usable[1:4, 0] = False  # a mask, a shadow: whatever kept it out
    assert np.argwhere(slips_of(pair, usable)).tolist() == [[4, 0]]


def test_a_flag_at_an_epoch_that_is_not_common_counts_at_the_next_common_one(rng, some_satellite):
    """A base at 0.2 Hz under a rover at 1 Hz: the flag of epoch 32 stands between its epochs."""
    preset = short_preset(events=(Slip(32, (1,), (some_satellite,)),), mask_deg=LOWEST_KEPT)
    master, rover = observe(prepare_geometry(preset), preset.noise, rng).observations
    pair = pair_receivers(keep_epochs(master, np.arange(60) % 5 == 0), rover, "G", 1)
    assert found(pair, slips_of(pair, np.isfinite(pair.master.phase + pair.rover.phase))) == {(7, some_satellite, 0)}


def test_half_cycles_of_either_receiver_are_in_doubt(rng, some_satellite):
    pair, _ = simulated_pair(rng, events=(HalfCycle(10, 12, (0,), (some_satellite,)), HalfCycle(20, 20, (1,), (some_satellite,), ("2W",))))
    expected = {(t, some_satellite, band) for t in (10, 11, 12) for band in (0, 1)} | {(20, some_satellite, 1)}
    assert found(pair, has_half_cycle(pair)) == expected
    assert not has_half_cycle(replace(pair, master=replace(pair.master, lli=pair.master.lli & ~np.uint8(HALF_CYCLE)))).any(axis=1)[10]


@pytest.mark.parametrize(("loss", "shadowed"), [(SHADOW_LOSS + 3, True), (SHADOW_LOSS - 3, False)])
@pytest.mark.parametrize("antenna", [0, 1])
def test_a_signal_weaker_by_a_diffraction_at_one_antenna_is_in_the_shadow(rng, some_satellite, antenna, loss, shadowed):
    pair, _ = simulated_pair(rng, events=(GrossError(K, "S1C", -loss, (antenna,), (some_satellite,)),))
    assert found(pair, is_shadowed(pair)) == ({(K, some_satellite, 0)} if shadowed else set())


def test_semi_codeless_tracking_at_one_end_is_no_shadow(rng, some_satellite):
    """W at the master and L at the rover differ by more the lower the satellite, with nothing in the way."""
    pair, _ = simulated_pair(rng, events=(GrossError(K, "S2W", -SHADOW_LOSS - 3, (0,), (some_satellite,)),))
    assert found(pair, is_shadowed(pair)) == {(K, some_satellite, 1)}
    unlike = replace(pair, signal_rover=tuple(signal.replace("2W", "2L") for signal in pair.signal_rover))
    assert not is_shadowed(unlike).any()


def test_an_antenna_that_is_weaker_for_all_satellites_casts_no_shadow(rng):
    pair, _ = simulated_pair(rng)
    deaf = replace(pair, rover=replace(pair.rover, cn0=pair.rover.cn0 - 10.0))
    assert not is_shadowed(deaf).any()


def test_without_strengths_there_is_no_shadow(rng):
    pair, _ = simulated_pair(rng)
    silent = replace(pair, rover=replace(pair.rover, cn0=np.full_like(pair.rover.cn0, np.nan)))
    assert not is_shadowed(silent).any()


@pytest.mark.parametrize("channels", [1, 4, 7])
def test_row_medians_are_numpys(rng, channels):
    values = np.where(rng.random((50, channels)) < 0.3, np.nan, rng.standard_normal((50, channels)))
    some = np.isfinite(values).any(axis=1)
    np.testing.assert_array_equal(row_medians(values)[some], np.nanmedian(values[some], axis=1))
    assert np.isnan(row_medians(values)[~some]).all()
