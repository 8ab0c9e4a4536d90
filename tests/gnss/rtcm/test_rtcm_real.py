"""A day of two real logs against RTKLIB's conversion of them (the mirror's RINEX files): every value, time and ephemeris."""

import numpy as np
import pytest

from gnsslab.gnss.ephemerides import ARRAY_FIELDS
from gnsslab.gnss.observations import HALF_CYCLE, SLIP
from gnsslab.gnss.rinex import read_rinex_nav, read_rinex_obs
from gnsslab.gnss.rtcm import read_rtcm

HALF_A_DIGIT = 0.5005e-3  # RINEX has three digits; RTKLIB forms the same phase in another order, which moves 2e8 by 3e-8
SIGNALS = ("2I", "6I", "7I")  # all that this RTKLIB (2.4.3) knows of BeiDou; the logs have 5P, 7D and 1P too


@pytest.fixture(scope="module", params=["base_all", "rover_all"])
def both(request, dataset):
    """Ours and RTKLIB's of one receiver."""
    folder = dataset("beidou-slope")
    if (folder / f"{request.param}.nav.json").exists():
        pytest.skip("the RINEX files here are our own")
    theirs = read_rinex_obs(folder / f"{request.param}.obs.gz"), read_rinex_nav(folder / f"{request.param}.nav")
    return read_rtcm(folder / f"{request.param}.rtcm3"), *theirs


def test_no_epoch_is_missing_and_those_beyond_are_few(both):
    """Of an epoch in two messages of which one is damaged RTKLIB drops both, or those after it too; here the good ones stay."""
    ours, theirs, _ = both
    assert set(theirs.time) <= set(ours.observations.time)
    beyond = len(ours.observations.time) - len(theirs.time)
    damaged = int(ours.warnings[0].rsplit(maxsplit=1)[1])
    assert 0 < beyond <= damaged + 1


def test_every_value_is_equal(both):
    ours, theirs, rows = common_rows(*both[:2])
    compared = 0
    for code in (kind + signal for signal in SIGNALS for kind in "CLS"):
        a, b = (table.value[row, table.column(code)] for table, row in zip((ours, theirs), rows, strict=True))
        assert np.array_equal(np.isnan(a), np.isnan(b)), code
        both_given = np.isfinite(a)
        assert np.abs(a - b)[both_given].max() < HALF_A_DIGIT, code
        compared += both_given.sum()
    assert compared > 400_000


def common_rows(log, theirs):
    """Return our table, theirs, and the rows of the satellites and epochs of theirs in both."""
    tables = log.observations.tables["C"], theirs.tables["C"]
    keys = [
        time[table.epoch].astype(np.int64) // 10**9 * 100 + table.number
        for time, table in zip((log.observations.time, theirs.time), tables, strict=True)
    ]
    common, *rows = np.intersect1d(*keys, return_indices=True)
    assert len(common) == len(keys[1])  # each row of theirs is there
    return *tables, rows


def test_slips_are_rtklibs_and_a_few_that_the_lock_times_prove(both):
    """RTKLIB also flags the first phase of each satellite, to which there is no phase before, and flags without a phase."""
    ours, theirs, rows = common_rows(*both[:2])
    for signal in SIGNALS:
        a, b = (table.lli[row, table.column("L" + signal)] for table, row in zip((ours, theirs), rows, strict=True))
        number, phase = ours.number[rows[0]], ours.value[rows[0], ours.column("L" + signal)]
        assert not (a & HALF_CYCLE).any()
        later = np.isfinite(phase)
        for satellite in np.unique(number):
            own = np.flatnonzero((number == satellite) & np.isfinite(phase))
            later[own[:1]] = False
        slip, slip_there = (a[later] & SLIP) > 0, (b[later] & SLIP) > 0
        assert not (slip_there & ~slip).any(), signal
        assert (slip & ~slip_there).sum() <= 5, signal
    assert slip_there.any()


def test_every_ephemeris_is_equal(both):
    """RINEX has 13 digits."""
    ours, theirs = both[0].ephemerides, both[2]
    assert len(ours.toe) == len(theirs.toe) > 300
    for name in ARRAY_FIELDS:
        a, b = getattr(ours, name), getattr(theirs, name)
        if a.dtype.kind == "f":
            np.testing.assert_allclose(a, b, rtol=5.1e-12, atol=0, err_msg=name)
        else:
            np.testing.assert_array_equal(a, b, err_msg=name)


def test_the_station_is_the_same(both):
    ours, theirs, _ = both
    assert ours.observations.header.position_ecef == pytest.approx(theirs.header.position_ecef, abs=1e-4)
    assert ours.observations.header.marker == theirs.header.marker
    assert ours.messages == {1006: ours.messages[1006], 1042: ours.messages[1042], 1124: ours.messages[1124]}
