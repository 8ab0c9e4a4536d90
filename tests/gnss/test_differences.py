"""Differences: the operators by their algebra, common epochs by what they promise, signals by hand-made and real receivers."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from small_observations import MILLISECOND, receiver, times, with_flag

from gnsslab.gnss.differences import (
    TAG_TOLERANCE,
    common_epochs,
    difference_operator,
    difference_pairs,
    grouped_difference_operator,
    pair_receivers,
    paired_epochs,
)  # fmt: skip
from gnsslab.gnss.observations import HALF_CYCLE, SLIP
from gnsslab.gnss.selection import keep_epochs
from gnsslab.gnss.signals import wavelength
from gnsslab.simulate import find_preset, simulate

LABELS = st.lists(st.tuples(st.integers(0, 3), st.floats(0.1, 1.5)), min_size=1, max_size=12)
TAGS = st.lists(st.integers(0, 500), max_size=30, unique=True).map(sorted)  # [ms]


@given(m=st.integers(1, 12), data=st.data())
def test_differences_take_out_what_is_common_and_correlate_by_half(m, data):
    D = difference_operator(m, data.draw(st.integers(0, m - 1)))
    assert D.shape == (m - 1, m)
    assert not (D @ np.ones(m)).any()
    assert np.array_equal(D @ D.T, np.eye(m - 1) + np.ones((m - 1, m - 1)))  # 2 on the diagonal, 1 off


@pytest.mark.parametrize("reference", [-1, 3])
def test_a_reference_that_is_not_there_is_refused(reference):
    with pytest.raises(ValueError, match=f"reference {reference} is not one of the 3 measurements"):
        difference_operator(3, reference)


@given(channels=LABELS)
def test_grouped_operator_is_one_operator_a_group_with_its_best_channel_as_reference(channels):
    group, goodness = (np.array(column) for column in zip(*channels, strict=True))
    D = grouped_difference_operator(group, goodness)
    clocks = {label: 10.0**label for label in range(4)}
    assert not (D @ np.array([clocks[label] for label in group])).any(), "a clock a group must cancel"
    assert len(D) == len(group) - len(set(group.tolist()))
    for row in D:
        (plus,), (minus,) = np.flatnonzero(row == 1), np.flatnonzero(row == -1)
        assert group[plus] == group[minus]
        assert goodness[minus] == goodness[group == group[plus]].max()
    assert np.linalg.matrix_rank(D) == len(D) if len(D) else True


@given(channels=LABELS)
def test_index_pairs_are_the_rows_of_the_operator(channels):
    group, goodness = (np.array(column) for column in zip(*channels, strict=True))
    values = np.random.default_rng(0).standard_normal(len(group))
    channel, reference = difference_pairs(group, goodness)
    np.testing.assert_array_equal(values[channel] - values[reference], grouped_difference_operator(group, goodness) @ values)


@settings(max_examples=300)
@given(a=TAGS, b=TAGS)
def test_common_epochs_are_pairs_within_the_tolerance_each_used_once(a, b):
    i_a, i_b = common_epochs(times(np.array(a, int)), times(np.array(b, int)))
    assert len(i_a) == len(i_b) == len(set(i_a.tolist())) == len(set(i_b.tolist()))
    assert (np.diff(i_a) > 0).all()
    assert (np.diff(i_b) > 0).all()
    assert all(abs(a[i] - b[j]) * MILLISECOND <= TAG_TOLERANCE for i, j in zip(i_a, i_b, strict=True))
    for j, tag in enumerate(b):  # two that have nobody else within the tolerance are found
        near = [i for i in range(len(a)) if abs(a[i] - tag) * MILLISECOND <= TAG_TOLERANCE]
        if len(near) == 1 and sum(abs(a[near[0]] - other) * MILLISECOND <= TAG_TOLERANCE for other in b) == 1:
            assert (near[0], j) in zip(i_a.tolist(), i_b.tolist(), strict=True)


@given(tags=TAGS, step=st.sampled_from([20, 50]))
def test_equal_tags_are_always_paired_even_beside_others_within_the_tolerance(tags, step):
    """A rover at 50 Hz has three epochs within 25 ms of each of the base's: the one of the same tag is meant."""
    rover = np.arange(0, 501, step)
    i_a, i_b = common_epochs(times(rover[np.isin(rover, tags)]), times(rover))
    assert rover[np.isin(rover, tags)][i_a].tolist() == rover[i_b].tolist() == sorted(set(tags) & set(rover.tolist()))


@settings(max_examples=300)
@given(master=TAGS, rover=TAGS)
def test_without_an_age_the_common_epochs_are_all_there_are(master, rover):
    tags = times(np.array(master, int)), times(np.array(rover, int))
    for paired, common in zip(paired_epochs(*tags, 0.0), common_epochs(*tags), strict=True):
        assert paired.tolist() == common.tolist()


@settings(max_examples=300)
@given(master=TAGS, rover=TAGS, longest_age=st.floats(0.001, 0.6))
def test_other_epochs_of_the_rover_get_the_last_one_of_the_master_while_it_is_young_enough(master, rover, longest_age):
    tags = times(np.array(master, int)), times(np.array(rover, int))
    common = dict(zip(*(index.tolist() for index in common_epochs(*tags)[::-1]), strict=True))
    i_master, i_rover = (index.tolist() for index in paired_epochs(*tags, longest_age))
    expected = {}
    for j, tag in enumerate(rover):
        young = [i for i, other in enumerate(master) if 0 <= tag - other <= longest_age * 1000 + 1e-9]
        if j in common or young:
            expected[j] = common.get(j, young[-1] if young else None)
    assert dict(zip(i_rover, i_master, strict=True)) == expected
    assert i_rover == sorted(i_rover)
    assert i_master == sorted(i_master), "the filter meets the master's epochs in their order"


@pytest.mark.parametrize("longest_age", [-1.0, float("nan"), float("inf")])
def test_an_age_that_is_none_is_refused(longest_age):
    with pytest.raises(ValueError, match=r"longest age of the master's data must be 0 s .common epochs only. or more"):
        pair_receivers(receiver({"G05": ("1C",)}), receiver({"G05": ("1C",)}), longest_age=longest_age)


def test_without_any_young_epoch_the_age_is_told():
    late = receiver({"G05": ("1C",)}, milliseconds=[10_000, 11_000])
    with pytest.raises(ValueError, match=r"tags within 25 ms, or the master's up to 1\.5 s older"):
        pair_receivers(receiver({"G05": ("1C",)}), late, longest_age=1.5)


def test_a_slip_between_the_masters_epochs_that_serve_is_told_once():
    """The master slips at its second epoch (1 s), which the rover does not have, and again at its fourth, which serves three times."""
    both = {"G05": ("1C",), "G06": ("1C",)}
    master = with_flag(receiver(both, milliseconds=[0, 1000, 2000, 4000]), "G05", "L1C", 1, SLIP)
    master = with_flag(with_flag(master, "G06", "L1C", 3, SLIP), "G05", "L1C", 3, HALF_CYCLE)
    pair = pair_receivers(master, receiver(both, milliseconds=[0, 2000, 3000, 4000, 4500, 5000]), longest_age=1.0)
    assert pair.epoch_master.tolist() == [0, 2, 2, 3, 3, 3]
    assert pair.master.lli.tolist() == [[0, 0], [SLIP, 0], [0, 0], [HALF_CYCLE, SLIP], [HALF_CYCLE, 0], [HALF_CYCLE, 0]]
    assert not pair.rover.lli.any()


def signals_of(pair):
    return {pair.satellites[s]: [] for s in pair.satellite} | {
        name: [(pair.signal_master[i], pair.signal_rover[i]) for i in range(len(pair.band)) if pair.satellites[pair.satellite[i]] == name]
        for name in pair.satellites
    }


@pytest.mark.parametrize(
    ("master", "rover", "chosen"),
    [
        (("1C", "2W", "2L"), ("1C", "2L"), [("1C", "1C"), ("2L", "2L")]),  # the only letter that both have
        (("1C", "2W", "2L"), ("1C", "2W", "2L"), [("1C", "1C"), ("2W", "2W")]),  # W first: every satellite has it
        (("1C", "2W"), ("1C", "2L"), [("1C", "1C"), ("2W", "2L")]),  # no common letter: another one rather than no band
        (("1C", ("2W", (0,)), "2L"), ("1C", "2W", "2L"), [("1C", "1C"), ("2L", "2L")]),  # W at one epoch of four only
        (("1C", ("2L", (0,))), ("1C", "2L", "2W"), [("1C", "1C"), ("2L", "2L")]),
        (("1C", "2W"), ("1C", "5Q"), [("1C", "1C")]),
    ],
)
def test_signals_of_gps(master, rover, chosen):
    pair = pair_receivers(receiver({"G05": master}), receiver({"G05": rover}))
    assert signals_of(pair) == {"G05": chosen}


def test_a_data_and_pilot_channel_pairs_with_a_combined_one():
    pair = pair_receivers(receiver({"E11": ("1C", "5Q")}), receiver({"E11": ("1X", "5X")}))
    assert signals_of(pair) == {"E11": [("1C", "1X"), ("5Q", "5X")]}


def test_beidou_without_b1i_is_taken_by_b1c_in_a_group_of_its_own():
    signals = {"C10": ("2I", "6I"), "C25": ("1P", "2I"), "C40": ("1P", "6I")}
    pair = pair_receivers(receiver(signals), receiver(signals), frequencies=1)
    assert signals_of(pair) == {"C10": [("2I", "2I")], "C25": [("2I", "2I")], "C40": [("1P", "1P")]}
    of = {pair.satellites[s]: i for i, s in enumerate(pair.satellite)}
    assert pair.group[of["C10"]] == pair.group[of["C25"]] != pair.group[of["C40"]]
    assert pair.wavelength[of["C40"]] == wavelength("C", "1") == wavelength("G", "1")
    assert pair.wavelength[of["C25"]] == wavelength("C", "2")


def test_named_signals_are_the_only_ones():
    signals = {"C10": ("2I", "6I", "7I"), "G05": ("1C", "2W")}
    pair = pair_receivers(receiver(signals), receiver(signals), signals=("C2I", "C7I"))
    assert signals_of(pair) == {"C10": [("2I", "2I"), ("7I", "7I")]}
    assert pair.band.tolist() == [0, 1]


@pytest.mark.parametrize("frequencies", [1, 2, 3])
def test_number_of_frequencies_counts_bands(frequencies):
    both = receiver({"G05": ("1C", "2W", "5Q"), "E11": ("1C", "5Q", "7Q")})
    pair = pair_receivers(both, both, frequencies=frequencies)
    assert sorted(set(pair.band.tolist())) == list(range(frequencies))
    assert len(np.unique(pair.group)) == 2 * frequencies  # a group a system and carrier


def test_systems_differ_in_group_even_on_the_same_frequency():
    both = receiver({"G05": ("1C",), "G06": ("1C",), "E11": ("1C",), "J02": ("1C",)})
    pair = pair_receivers(both, both)
    assert {name: pair.group[list(pair.satellite).index(i)] for i, name in enumerate(pair.satellites)} == {"E11": 0, "G05": 1, "G06": 1, "J02": 2}


def test_a_system_named_twice_counts_once():
    both = receiver({"G05": ("1C",), "G06": ("1C",), "E11": ("1C",)})
    assert len(pair_receivers(both, both, systems="GEG").band) == 3


def test_without_common_epochs_the_spans_are_told():
    late = receiver({"G05": ("1C",)}, milliseconds=[10_000, 11_000])
    with pytest.raises(ValueError, match=r"the master has 2024-06-24T08:20:00\.000 to 2024-06-24T08:20:03\.000, the rover 2024-06-24T08:20:10"):
        pair_receivers(receiver({"G05": ("1C",)}), late)
    with pytest.raises(ValueError, match="the rover no epochs"):
        pair_receivers(receiver({"G05": ("1C",)}), keep_epochs(late, np.zeros(2, dtype=bool)))


@pytest.mark.parametrize(
    ("rover", "options"),
    [
        ({"G06": ("1C",)}, {}),
        ({"G05": ("1C",)}, {"systems": "E"}),
        ({"G05": ("5Q",)}, {}),
        ({"G05": ("1C",)}, {"signals": ("C2W",)}),
        ({"G05": (("1C", ()), "2W")}, {}),
    ],
)
def test_without_common_satellites_the_sentence_says_where_to_look(rover, options):
    with pytest.raises(ValueError, match=r"no common satellites: .* look at both files with `gnsslab info`"):
        pair_receivers(receiver({"G05": ("1C",)}), receiver(rover), **options)


def test_flags_of_both_receivers_are_carried(rng):
    both = {"G05": ("1C",), "G06": ("1C",)}
    master = with_flag(receiver(both), "G05", "L1C", 1, SLIP)
    rover = with_flag(with_flag(receiver(both), "G06", "L1C", 2, HALF_CYCLE), "G06", "C1C", 3, SLIP)  # a flag on a code says nothing of the phase
    pair = pair_receivers(master, rover)
    assert np.argwhere(pair.master.lli).tolist() == [[1, 0]]
    assert pair.master.lli[1, 0] == SLIP
    assert np.argwhere(pair.rover.lli).tolist() == [[2, 1]]
    assert pair.rover.lli[2, 1] == HALF_CYCLE


def test_a_slip_at_an_epoch_the_other_receiver_lacks_is_carried_to_the_next_common_one():
    both = {"G05": ("1C",), "G06": ("1C",)}
    rover = with_flag(with_flag(receiver(both, T=7), "G05", "L1C", 4, SLIP), "G06", "L1C", 1, HALF_CYCLE)
    master = receiver(both, milliseconds=[0, 3000, 6000])
    pair = pair_receivers(master, rover)
    assert pair.epoch.tolist() == [0, 3, 6]
    assert pair.rover.lli.tolist() == [[0, 0], [0, 0], [SLIP, 0]]  # the half cycle was resolved meanwhile
    assert not pair.master.lli.any()


def test_a_slip_before_the_first_common_epoch_and_after_the_last_is_no_concern_of_the_rest():
    both = {"G05": ("1C",), "G06": ("1C",)}
    rover = with_flag(with_flag(receiver(both, T=7), "G05", "L1C", 6, SLIP), "G06", "L1C", 2, SLIP)
    pair = pair_receivers(receiver(both, milliseconds=[3000, 5000]), rover)
    assert pair.rover.lli.tolist() == [[0, SLIP], [0, 0]]


def test_a_power_failure_is_a_slip_of_every_carrier():
    both = receiver({"G05": ("1C", "2W"), "E11": ("1C",)})
    failed = replace(both, power_failure=np.array([False, False, True, False]))
    pair = pair_receivers(both, failed)
    assert (pair.rover.lli[2] == SLIP).all()
    assert not pair.rover.lli[[0, 1, 3]].any()


def test_measurements_are_those_of_the_tables_in_a_simulation(rng):
    preset = replace(find_preset("static-baseline"), duration=20.0)
    master, rover = simulate(preset, rng).observations
    check_against_tables(pair_receivers(master, rover, frequencies=3), master, rover, rng)


def test_measurements_are_those_of_the_tables_in_real_data(campaign, rng):
    real = campaign("matrtklib-static")
    pair = pair_receivers(real.base, real.rover)
    assert {name[0] for name in pair.satellites} == set("GECJ")
    check_against_tables(pair, real.base, real.rover, rng)


def check_against_tables(pair, master, rover, rng):
    """Compare 300 measurements at random with what a search by satellite, epoch and code finds."""
    found = 0
    for _ in range(300):
        t, channel = rng.integers(len(pair.time)), rng.integers(len(pair.band))
        name = pair.satellites[pair.satellite[channel]]
        for tracks, receiver_, epochs, signals in (
            (pair.master, master, pair.epoch_master, pair.signal_master),
            (pair.rover, rover, pair.epoch, pair.signal_rover),
        ):
            table = receiver_.tables[name[0]]
            rows = np.flatnonzero((table.epoch == epochs[t]) & (table.number == int(name[1:])))
            for kind, array in zip("CLDS", (tracks.code, tracks.phase, tracks.doppler, tracks.cn0), strict=True):
                column = table.column(kind + signals[channel])
                expected = table.value[rows[0], column] if len(rows) and column is not None else np.nan
                np.testing.assert_equal(array[t, channel], expected)
                found += np.isfinite(expected)
    assert found > 1000


def test_read_only_observations_are_enough():
    both = receiver({"G05": ("1C",), "G06": ("1C",)})
    for table in both.tables.values():
        for array in (table.epoch, table.number, table.value, table.lli, table.ssi):
            array.flags.writeable = False
    both.time.flags.writeable = both.power_failure.flags.writeable = False
    assert len(pair_receivers(both, both).time) == 4


def test_bands_that_a_receiver_lacks_are_left_out():
    """A receiver of E1 and E5b, B1I and B2I: two frequencies are these two, though E5a and B3I stand between them in the order."""
    signals = {"E01": ("1C", "7Q"), "E02": ("1C", "7Q"), "C06": ("2I", "7I"), "C07": ("2I", "7I")}
    pair = pair_receivers(receiver(signals), receiver(signals), "EC", 2)
    assert set(zip(pair.band.tolist(), pair.signal_rover, strict=True)) == {(0, "1C"), (1, "7Q"), (0, "2I"), (1, "7I")}
    assert set(pair_receivers(receiver(signals), receiver(signals), "EC", 1).signal_rover) == {"1C", "2I"}
