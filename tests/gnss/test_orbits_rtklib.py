"""Orbits and clocks against RTKLIB's own, through pyrtklib, on every navigation file of the real data sets."""

import numpy as np
import pytest

from gnsslab.gnss.orbits import is_galileo_fnav, kepler_states, orbit_elements, satellite_states
from gnsslab.gnss.rinex.navigation_reader import read_rinex_nav
from gnsslab.gnss.signals import SPEED_OF_LIGHT, USED_SYSTEMS

MICROMETRE = 1e-6
CLOCK = 1e-15  # [s], 0.3 um of light; a ms of clock has 2e-19 s of spacing, the age of toc 1e-12 s times 1e-9 s/s
FILES = [
    ("matrtklib-static", "base.nav"), ("beidou-slope", "base_all.nav"), ("beidou-slope", "rover_all.nav"), ("gnssimu-walk", "walk.nav"),
    ("geonet-0759-3040", "07590920.05n"), ("geonet-0759-3040", "30400920.05n"), ("cssrlib-078", "30340780.21q"), ("cssrlib-078", "SEPT078M.21P"),
]  # fmt: skip
KINDS = {"base.nav": {"G", "E", "J", "C", "E18", "C01"}, "base_all.nav": {"C", "C01"}, "SEPT078M.21P": {"G", "E", "J"}}  # C01: GEO, E18: e = 0.16


@pytest.fixture(params=FILES, ids="/".join)
def both(request, dataset, rtk):
    """The same navigation file as RTKLIB and as we read it."""
    path = str(dataset(request.param[0]) / request.param[1])
    nav = rtk.nav_t()
    rtk.readrnx(path, 1, "", rtk.obs_t(), nav, rtk.sta_t())
    return nav, read_rinex_nav(path), KINDS.get(request.param[1], set())


def name_of(rtk, eph):
    buffer = rtk.Arr1Dchar(8)
    rtk.satno2id(eph.sat, buffer)
    return buffer[0]


def label(time):
    """Return the label of RTKLIB's time: whole seconds since 1970 and a fraction."""
    return np.datetime64("1970-01-01", "ns") + np.timedelta64(time.time, "s") + np.timedelta64(round(time.sec * 1e9), "ns")


def data_sets_of_both(rtk, nav, ephemerides):
    """Yield RTKLIB's data sets with name and our row; of Galileo's repeats through E1 and E5b we keep the first."""
    is_fnav = is_galileo_fnav(ephemerides)
    for k in range(nav.n):
        eph = nav.eph[k]
        name = name_of(rtk, eph)
        if name[0] not in USED_SYSTEMS:
            continue
        same = (ephemerides.satellite == name) & (ephemerides.toe == label(eph.toe)) & (ephemerides.toc == label(eph.toc))
        same &= (ephemerides.issue == eph.iode) & (is_fnav == (name[0] == "E" and eph.code & 7 == 2)) & (ephemerides.health == eph.svh)
        rows = np.nonzero(same)[0]
        assert len(rows) == 1, f"{name} {label(eph.toe)}: {len(rows)} rows"
        yield name, eph, rows


def test_every_data_set_gives_rtklibs_orbit_and_clock(rtk, both):
    nav, ephemerides, kinds = both
    compared = set()
    for name, eph, rows in data_sets_of_both(rtk, nav, ephemerides):
        rs, dts, var = rtk.Arr1Ddouble(6), rtk.Arr1Ddouble(2), rtk.Arr1Ddouble(1)
        for t in (-7200.0, -1234.5, 0.0, 600.25, 7200.0):
            rtk.eph2pos(rtk.timeadd(eph.toe, t), eph, rs, dts, var)
            position, _, relativity, _ = kepler_states(orbit_elements(ephemerides, rows), np.array([t]))
            after_toc = rtk.timediff(rtk.timeadd(eph.toe, t), eph.toc)
            clock = ephemerides.af0[rows] + ephemerides.af1[rows] * after_toc + ephemerides.af2[rows] * after_toc**2 + relativity
            assert np.abs(position[0] - [rs[0], rs[1], rs[2]]).max() < MICROMETRE, f"{name} {t}"
            assert abs(clock[0] - dts[0]) < CLOCK, f"{name} {t}"
        compared |= {name, name[0]}
    assert compared.issuperset({*ephemerides.satellites, *kinds})


def satposs(rtk, nav, time, satellite, pseudorange):
    """Return RTKLIB's position, velocity, clock, clock drift and health for one satellite and receiver tag."""
    obs = rtk.Arr1Dobsd_t(1)
    seconds, nanoseconds = divmod(int(time.astype("datetime64[ns]").astype(np.int64)), 10**9)
    tag = rtk.gtime_t()
    tag.time, tag.sec = seconds, nanoseconds * 1e-9
    obs[0].time, obs[0].sat = tag, rtk.satid2no(satellite)
    obs[0].P[0] = pseudorange
    rs, dts, var, svh = rtk.Arr1Ddouble(6), rtk.Arr1Ddouble(2), rtk.Arr1Ddouble(1), rtk.Arr1Dint(1)
    rtk.satposs(tag, obs.ptr, 1, nav, rtk.EPHOPT_BRDC, rs, dts, var, svh)
    return np.array([rs[k] for k in range(6)]), np.array([dts[0], dts[1]]), svh[0]


def rtklib_chooses_alike(ephemerides, index, times):
    """Return where RTKLIB takes the same data set: of Galileo it takes I/NAV only, and none before its toe."""
    is_galileo = ephemerides.satellite.astype("<U1") == "E"
    is_ahead = ephemerides.toe[index] >= times[:, None]
    return (index >= 0) & ~(is_galileo[index] & (is_ahead | is_galileo_fnav(ephemerides)[index]))


def test_states_at_transmission_are_rtklibs(rtk, both):
    """The whole way: choice of data set, time of transmission, clock; RTKLIB's own velocity is a difference over 1 ms."""
    nav, ephemerides, _ = both
    satellites = ephemerides.satellites
    times = np.sort(ephemerides.toe)[len(ephemerides.toe) // 2] + np.array([-5400, -1693, 7, 1234, 4321]) * np.timedelta64(1, "s")
    pseudorange = 2.1e7 + 1.7e7 * np.arange(len(satellites)) / len(satellites)
    states = satellite_states(ephemerides, satellites, times, np.broadcast_to(pseudorange / SPEED_OF_LIGHT, (5, len(satellites))))
    compared = 0
    for epoch, column in zip(*np.nonzero(rtklib_chooses_alike(ephemerides, states.index, times)), strict=True):
        orbit, clock, _ = satposs(rtk, nav, times[epoch], satellites[column], pseudorange[column])
        what = f"{satellites[column]} {times[epoch]}"
        assert np.abs(states.position[epoch, column] - orbit[:3]).max() < MICROMETRE, what
        assert np.abs(states.velocity[epoch, column] - orbit[3:]).max() < 1e-3, what
        assert abs(states.clock[epoch, column] - clock[0]) < CLOCK, what
        compared += 1
    assert compared > 0
