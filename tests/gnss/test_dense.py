"""Dense arrays against a plain loop over the tables' rows, and the choice of signals by hand-made counts."""

import numpy as np
import pytest

from gnsslab.gnss.dense import choose_signals, dense, signal_arrays, signal_counts, single_frequency_codes
from gnsslab.gnss.observations import ObservationHeader, Observations, SystemTable

SECOND = np.timedelta64(1, "s")


def observations_of(tables, T):
    time = np.datetime64("2024-06-24T08:20:00", "ns") + np.arange(T) * SECOND
    return Observations(time, {table.system: table for table in tables}, ObservationHeader(), np.zeros(T, dtype=bool))


def random_table(rng, system="G", codes=("C1C", "L1C", "D1C", "S1C", "C1W", "L1W", "C2W"), T=20, numbers=(3, 8, 31)):
    rows = [(epoch, number) for epoch in range(T) for number in numbers if rng.uniform() < 0.7]
    epoch, number = np.array(rows, dtype=np.int32).T
    value = rng.normal(2e7, 1e6, size=(len(rows), len(codes)))
    value[rng.uniform(size=value.shape) < 0.3] = np.nan
    lli = rng.integers(0, 4, size=value.shape, dtype=np.uint8)
    for array in (epoch, value, lli):
        array.flags.writeable = False
    return SystemTable(system, codes, epoch, number.astype(np.int16), value, lli, np.zeros_like(lli))


def looped(observations, name, signal):
    """One satellite and signal by a loop over rows and codes: code, phase, Doppler, C/N0 and flags (T,) each."""
    T = len(observations.time)
    arrays = [np.full(T, np.nan) for _ in range(4)] + [np.zeros(T, dtype=np.uint8)]
    table = observations.tables[name[0]]
    for row, (epoch, number) in enumerate(zip(table.epoch, table.number, strict=True)):
        if number != int(name[1:]):
            continue
        for array, kind in zip(arrays, "CLDS", strict=False):
            if kind + signal in table.codes:
                array[epoch] = table.value[row, table.codes.index(kind + signal)]
        if "L" + signal in table.codes:
            arrays[4][epoch] = table.lli[row, table.codes.index("L" + signal)]
    return arrays


def test_arrays_are_what_a_loop_over_the_rows_finds(rng):
    observations = observations_of([random_table(rng), random_table(rng, "E", ("L1X", "C1X", "S1X", "C5X"), numbers=(1, 36))], T=20)
    satellites, signals = ["E36", "G08", "G03", "G31", "G08"], ["1X", "1C", "1W", "2W", "1W"]
    arrays = signal_arrays(observations, satellites, signals)
    for column, (name, signal) in enumerate(zip(satellites, signals, strict=True)):
        for array, expected in zip(arrays, looped(observations, name, signal), strict=True):
            assert array.shape == (20, 5)
            np.testing.assert_array_equal(array[:, column], expected)
    assert arrays.lli.dtype == np.uint8


def test_what_was_never_recorded_is_missing(rng):
    observations = observations_of([random_table(rng)], T=20)
    arrays = signal_arrays(observations, ["G03", "G17", "C11", "G03"], ["5Q", "1C", "2I", "1C"])
    assert np.isnan(arrays.code[:, :3]).all()
    assert not arrays.lli[:, :3].any()
    assert np.isfinite(arrays.code[:, 3]).any()


def test_the_signal_seen_most_often_is_chosen_and_ties_go_to_the_better_letter():
    value = np.full((8, 4), 2e7)
    value[0:2, 0] = np.nan  # G01: two of its four C1C are missing
    table = SystemTable(
        "G", ("C1C", "L1C", "C1W", "L1W"), np.repeat(np.arange(4, dtype=np.int32), 2)[np.argsort(np.tile([0, 1], 4), kind="stable")],
        np.repeat(np.array([1, 2], dtype=np.int16), 4), value, np.zeros((8, 4), np.uint8), np.zeros((8, 4), np.uint8),
    )  # fmt: skip
    signals, numbers, counts = signal_counts(table, "1")
    assert (signals, numbers.tolist(), counts.tolist()) == (["1C", "1W"], [1, 2], [[6, 8], [8, 8]])
    assert choose_signals(table, "1") == {"G01": "1W", "G02": "1C"}


def test_beidou_falls_back_from_b1i_to_b1c_satellite_by_satellite():
    value = np.array([[2e7, np.nan], [np.nan, 3e7], [2e7, 2e7], [np.nan, np.nan]])
    flags = np.zeros(value.shape, np.uint8)
    table = SystemTable("C", ("C2I", "C1P"), np.zeros(4, np.int32), np.array([6, 20, 30, 40], np.int16), value, flags, flags)
    chosen = dense(observations_of([table], T=1), "C")
    assert (chosen.satellites, chosen.signals) == (("C06", "C20", "C30"), ("2I", "1P", "2I"))
    np.testing.assert_allclose(chosen.wavelength, [0.192039, 0.190294, 0.192039], atol=1e-6)
    np.testing.assert_allclose(chosen.frequency * chosen.wavelength, 299_792_458.0)


def test_a_phase_alone_does_not_make_a_signal_for_codes():
    value = np.array([[np.nan, 1e8, 2e7, np.nan]])
    flags = np.zeros(value.shape, np.uint8)
    table = SystemTable("G", ("C1C", "L1C", "C1W", "L1W"), np.zeros(1, np.int32), np.array([5], np.int16), value, flags, flags)
    assert choose_signals(table, "1") == {"G05": "1W"}


@pytest.mark.parametrize("systems", ["", "G", "RS"])
def test_no_satellites_give_empty_arrays(systems):
    nothing = single_frequency_codes(observations_of([], T=3), systems)
    assert nothing.satellites == ()
    assert nothing.code.shape == (3, 0)
    assert nothing.wavelength.shape == (0,)


def test_systems_stand_in_the_order_asked_for(rng):
    observations = observations_of([random_table(rng), random_table(rng, "E", ("C1X", "L1X"), numbers=(2, 11))], T=20)
    assert [name[0] for name in single_frequency_codes(observations, "EG").satellites] == ["E", "E", "G", "G", "G"]
    assert dense(observations, "G", band_rank=1).signals == ("2W",) * 3
    assert dense(observations, "G", band_rank=5).satellites == ()
