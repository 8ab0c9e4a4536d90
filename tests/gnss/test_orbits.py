"""Broadcast orbits and clocks: precise orbits, a second implementation, RTKLIB, and what must hold by itself."""

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gnsslab.gnss import orbits
from gnsslab.gnss.ephemerides import ARRAY_FIELDS, Ephemerides
from gnsslab.gnss.orbits import (
    Elements,
    group_delay,
    is_healthy,
    kepler_states,
    rotate_to_reception,
    satellite_states,
    select_ephemerides,
)
from gnsslab.gnss.rinex.navigation_reader import merge_ephemerides
from gnsslab.gnss.signals import SPEED_OF_LIGHT, frequency
from gnsslab.gnss.times import BDT_BEHIND_GPS, BDT_WEEK_ZERO, gps_time

MILLIMETRE, MICROMETRE = 1e-3, 1e-6
REFERENCE = json.loads((Path(__file__).parents[1] / "reference" / "satellites.json").read_text())
TOE = np.datetime64("2024-06-24T10:00:00", "ns")
HOUR = np.timedelta64(3600, "s")


def data_set(satellite, toe=TOE, **values):
    """Return an Ephemerides of one data set: a quiet circular orbit unless told otherwise."""
    zeros = dict.fromkeys(ARRAY_FIELDS[4:], np.zeros(1))
    integers = dict.fromkeys(("issue", "clock_issue", "health"), np.zeros(1, dtype=np.int64))
    fields = zeros | integers | {name: np.array([value]) for name, value in values.items()}
    defaults = {"sqrt_a": np.array([5153.6]), "i0": np.array([0.96]), "group_delay": np.zeros((1, 2))}
    times = dict.fromkeys(("toe", "toc", "transmission"), np.array([toe], dtype="datetime64[ns]"))
    return Ephemerides(
        satellite=np.array([satellite], dtype="<U3"), **times, **(fields | {k: fields[k] if k in values else v for k, v in defaults.items()})
    )


def at(ephemerides, satellite, time, transit=0.0):
    return satellite_states(ephemerides, [satellite], np.atleast_1d(time), np.full((np.size(time), 1), transit))


# Against precise orbits (published numbers) ---------------------------------------------------------------------------

_OF_CASE = {"sqrt_a": "sqrtA", "delta_n": "deltaN", "omega0": "Omega0", "omega_dot": "OmegaDot", "m0": "M0"}
_SAME_NAME = ("e", "i0", "idot", "omega", "cuc", "cus", "crc", "crs", "cic", "cis")


@pytest.mark.parametrize("case", REFERENCE["satellite_orbit"]["cases"], ids=lambda case: case["sys"])
def test_orbit_is_that_of_the_precise_ephemeris(case):
    """The tolerance is the accuracy of broadcast orbits; BeiDou with its 14 s taken the other way is 34 km off."""
    values = {ours: case[theirs] for ours, theirs in _OF_CASE.items()} | {name: case[name] for name in _SAME_NAME}
    if case["sys"] == "BDS":
        toe, epoch = gps_time(case["week_bdt"] + BDT_WEEK_ZERO, case["toe_bdt"]) + BDT_BEHIND_GPS, gps_time(2069, case["toe_bdt"])
    else:
        toe = epoch = gps_time(1024, case["toe"])
    name = {"GPS": "G", "GAL": "E", "BDS": "C"}[case["sys"]] + f"{case['prn']:02d}"
    states = at(data_set(name, toe, **values), name, epoch)
    assert np.linalg.norm(states.position[0, 0] - case["sp3_xyz_m"]) < case["tol_m"]


# Against a second implementation --------------------------------------------------------------------------------------


def scalar_position(system, is_geo, v, t):
    """The same orbit in plain floats: Kepler's equation by bisection, planes and frames by rotation matrices."""
    mu, w = orbits.GRAVITATION[system], orbits.EARTH_RATE[system]
    M = v["m0"] + (math.sqrt(mu / v["sqrt_a"] ** 6) + v["delta_n"]) * t
    low, high = M - 1, M + 1
    while high - low > 4e-16 * max(abs(M), 1):
        E = (low + high) / 2
        low, high = (E, high) if E - v["e"] * math.sin(E) < M else (low, E)
        if E in (low, high) and (low + high) / 2 in (low, high):
            break
    nu = 2 * math.atan2(math.sqrt(1 + v["e"]) * math.sin(E / 2), math.sqrt(1 - v["e"]) * math.cos(E / 2))
    phi = nu + v["omega"]
    second = np.array([math.cos(2 * phi), math.sin(2 * phi)])
    u = phi + second @ [v["cuc"], v["cus"]]
    r = v["sqrt_a"] ** 2 * (1 - v["e"] ** 2) / (1 + v["e"] * math.cos(nu)) + second @ [v["crc"], v["crs"]]
    i = v["i0"] + v["idot"] * t + second @ [v["cic"], v["cis"]]
    node = v["omega0"] + v["omega_dot"] * t - w * v["toe_s"] - (0 if is_geo else w * t)
    p = rotation(2, node).T @ rotation(0, i).T @ rotation(2, u).T @ [r, 0, 0]
    return rotation(2, w * t) @ rotation(0, math.radians(-5)) @ p if is_geo else p


def rotation(axis, angle):
    """Rotate the frame about axis 0 (x) or 2 (z)."""
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[1, 0, 0], [0, c, s], [0, -s, c]]) if axis == 0 else np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])


def angles(limit):
    return st.floats(-limit, limit)


ORBITS = st.fixed_dictionaries({
    "sqrt_a": st.floats(5050, 6500), "e": st.floats(0, 0.2), "i0": st.floats(0, 1.2), "omega0": angles(3.2), "omega": angles(3.2),
    "m0": angles(3.2), "delta_n": angles(1e-8), "idot": angles(1e-9), "omega_dot": angles(1e-8), "cuc": angles(3e-5), "cus": angles(3e-5),
    "crc": angles(1e3), "crs": angles(1e3), "cic": angles(3e-6), "cis": angles(3e-6), "toe_s": st.integers(0, 604_784).map(float),
})  # fmt: skip
SYSTEMS = st.sampled_from([("G", False), ("J", False), ("E", False), ("C", False), ("C", True)])


def elements_of(system, is_geo, v, n=1):
    mu, w = orbits.GRAVITATION[system], orbits.EARTH_RATE[system]
    derived = {"n": math.sqrt(mu / v["sqrt_a"] ** 6) + v["delta_n"], "turned": w * v["toe_s"], "mu": mu, "earth_rate": w, "is_geo": is_geo}
    values = {"af0": 0.0, "af1": 0.0, "af2": 0.0} | v | derived
    return Elements(*(np.full(n, float(values[name])) for name in Elements._fields))


@given(SYSTEMS, ORBITS, st.floats(-21_600, 21_600))
@settings(max_examples=200, deadline=None)
def test_orbit_equals_a_scalar_one_written_differently(system, values, t):
    """At 44 rad, the Earth's turn in a week, floats are 7e-15 rad apart: 0.4 um at 5e7 m, met twice."""
    position = kepler_states(elements_of(*system, values), np.array([t]))[0][0]
    assert np.linalg.norm(position - scalar_position(*system, values, t)) < 2 * MICROMETRE


@given(SYSTEMS, ORBITS, st.floats(-21_600, 21_600))
@settings(max_examples=100, deadline=None)
def test_velocity_and_relativity_rate_are_the_derivatives(system, values, t):
    """Central differences of fourth order over 5 s: what they leave out is below 1e-9 m/s, rounding of 1e-6 m gives 2e-7 m/s."""
    h = 5.0
    p, v, relativity, rate = kepler_states(elements_of(*system, values, n=5), t + h * np.arange(-2, 3))
    difference = np.array([1, -8, 0, 8, -1]) / (12 * h)
    assert np.abs(difference @ p - v[2]).max() < 1e-6
    assert abs(difference @ relativity - rate[2]) < 1e-18


@given(ORBITS, st.floats(-7200, 7200))
@settings(max_examples=50, deadline=None)
def test_relativity_is_minus_two_r_dot_v_over_c_squared(values, t):
    """IS-GPS-200N 20.3.3.3.3.1 gives both forms; the inertial velocity of the unperturbed ellipse is meant."""
    still = {name: 0.0 for name in ("delta_n", "idot", "omega_dot", "cuc", "cus", "crc", "crs", "cic", "cis")}
    p, v, relativity, _ = kepler_states(elements_of("G", False, values | still), np.array([t]))
    inertial = v[0] + np.cross([0, 0, orbits.EARTH_RATE["G"]], p[0])
    assert abs(relativity[0] + 2 * p[0] @ inertial / SPEED_OF_LIGHT**2) < 1e-17


def test_circular_orbit_without_inclination_is_a_circle_by_hand():
    values = {name: 0.0 for name in (*_SAME_NAME, *_OF_CASE, "toe_s")} | {"sqrt_a": 5153.6}
    position, velocity, relativity, _ = kepler_states(elements_of("G", False, values), np.array([0.0]))
    a = 5153.6**2
    speed = math.sqrt(orbits.GRAVITATION["G"] / a) - orbits.EARTH_RATE["G"] * a
    np.testing.assert_allclose(position[0], [a, 0, 0], atol=MICROMETRE)
    np.testing.assert_allclose(velocity[0], [0, speed, 0], atol=1e-9)
    assert relativity[0] == 0


# Times of transmission and clocks -------------------------------------------------------------------------------------


def test_satellite_is_taken_at_transmission_by_its_own_clock():
    """A clock 1 ms ahead read tag - transit one millisecond of system time earlier: 3.9 m of flight."""
    right = at(data_set("G01"), "G01", TOE + HOUR, transit=0.07)
    ahead = at(data_set("G01", af0=1e-3), "G01", TOE + HOUR, transit=0.07 - 1e-3)
    np.testing.assert_allclose(ahead.position, right.position, atol=MICROMETRE)
    assert ahead.clock[0, 0] == pytest.approx(1e-3, abs=1e-15)


@given(st.floats(-1e-3, 1e-3), angles(1e-9), angles(1e-15), st.floats(-7000, 7000), st.floats(0.06, 0.13))
@settings(max_examples=50, deadline=None)
def test_clock_satisfies_its_own_equation(af0, af1, af2, after, transit):
    """The reading tag - transit equals t + dt(t) at the system time t that comes out, and the drift is the polynomial's slope."""
    eph = data_set("G01", af0=af0, af1=af1, af2=af2)
    tag = TOE + np.timedelta64(round(after), "s")
    states = at(eph, "G01", tag, transit)
    t = (round(after) - transit) - states.clock[0, 0]
    assert states.clock[0, 0] == pytest.approx(af0 + af1 * t + af2 * t**2, abs=1e-17)
    assert states.clock_drift[0, 0] == pytest.approx(af1 + 2 * af2 * t, abs=1e-18)


def test_each_receiver_has_its_own_time_of_transmission():
    """Pseudoranges that share a receiver clock error of 1 ms with the tag give the same satellite positions."""
    eph = data_set("E11", e=0.0002)
    on_time = at(eph, "E11", TOE, transit=0.08)
    late = at(eph, "E11", TOE + np.timedelta64(1, "ms"), transit=0.081)
    np.testing.assert_allclose(late.position, on_time.position, atol=MICROMETRE)


def test_missing_things_are_nan_without_a_warning():
    eph = merge_ephemerides([data_set("G01"), data_set("G02", health=63)])
    times = TOE + HOUR * np.arange(4)
    transit = np.array([[0.07, 0.07, 0.07], [np.nan] * 3, [np.inf, 0.07, 0.07], [0.07] * 3])
    states = satellite_states(eph, ["G01", "G02", "G07"], times, transit)
    assert states.index.tolist() == [[0, -1, -1], [0, -1, -1], [0, -1, -1], [-1, -1, -1]]
    assert np.isfinite(states.clock).tolist() == [[True, False, False]] + [[False] * 3] * 3
    assert (
        np.isfinite(states.position).all(axis=-1).tolist() == np.isfinite(states.velocity).all(axis=-1).tolist() == np.isfinite(states.clock).tolist()
    )
    assert repr(states) == "SatelliteStates: 4 epochs of 3 satellites, 3 with orbits"


def test_nothing_to_compute_gives_empty_arrays():
    empty = replace(data_set("G01"), **{name: getattr(data_set("G01"), name)[:0] for name in ARRAY_FIELDS})
    assert satellite_states(empty, ["G01"], np.array([TOE]), np.array([[0.07]])).index.tolist() == [[-1]]
    assert satellite_states(data_set("G01"), [], np.array([TOE]), np.zeros((1, 0))).position.shape == (1, 0, 3)
    assert satellite_states(data_set("G01"), ["G01"], np.array([], dtype="M8[ns]"), np.zeros((0, 1))).velocity.shape == (0, 1, 3)
    assert np.isnan(group_delay(empty, np.array([[-1]]), "G", "1")).all()


def test_transit_of_another_shape_is_refused():
    with pytest.raises(ValueError, match=r"expected transit times of shape \(epochs, satellites\) = \(1, 1\), came \(1, 2\)"):
        satellite_states(data_set("G01"), ["G01"], np.array([TOE]), np.zeros((1, 2)))


def test_caller_arrays_stay_as_they_are():
    eph, time, transit = data_set("C01"), np.array([TOE]), np.array([[0.13]])
    for array in (time, transit, *(getattr(eph, name) for name in ARRAY_FIELDS)):
        array.flags.writeable = False
    states = satellite_states(eph, ("C01",), time, transit)
    position = states.position
    position.flags.writeable = False
    assert np.isfinite(rotate_to_reception(position, transit)).all()


# The choice of data sets ----------------------------------------------------------------------------------------------


def test_nearest_toe_serves_the_later_of_two_equally_near():
    eph = merge_ephemerides([data_set("G01", TOE), data_set("G01", TOE + 2 * HOUR)])
    minutes = np.array([-119, 0, 59, 60, 61, 120, 240, 241]) * np.timedelta64(60, "s")
    assert select_ephemerides(eph, ["G01"], TOE + minutes)[:, 0].tolist() == [0, 0, 0, 1, 1, 1, 1, -1]


@pytest.mark.parametrize(("satellite", "limit"), [("G01", 7200), ("J02", 7200), ("E01", 14_400), ("C01", 21_600), ("C30", 21_600)])
def test_age_limits_of_the_systems(satellite, limit):
    eph = data_set(satellite)
    times = TOE + np.array([-limit - 2, -limit, limit, limit + 2]) * np.timedelta64(1, "s")
    assert select_ephemerides(eph, [satellite], times)[:, 0].tolist() == [-1, 0, 0, -1]


@given(st.lists(st.integers(0, 40), min_size=1, max_size=8), st.integers(-100, 700))
@settings(max_examples=100, deadline=None)
def test_choice_equals_a_search_through_all(quarters, minute):
    """A plain loop over all data sets finds the same toe."""
    eph = merge_ephemerides([data_set("E05", TOE + int(q) * HOUR // 4, issue=k) for k, q in enumerate(quarters)])
    time = TOE + np.timedelta64(minute, "m")
    ages = [abs((time - toe) / np.timedelta64(1, "s")) for toe in eph.toe]
    best = None if min(ages) > 14_401 else max(toe for toe, age in zip(eph.toe, ages, strict=True) if age == min(ages))
    index = select_ephemerides(eph, ["E05"], [time])[0, 0]
    assert (best is None and index == -1) or eph.toe[index] == best


def test_an_unhealthy_data_set_is_not_overruled_by_an_older_healthy_one():
    eph = merge_ephemerides([data_set("G01", TOE), data_set("G01", TOE + 2 * HOUR, health=63)])
    assert select_ephemerides(eph, ["G01"], TOE + np.array([0, 50, 70]) * np.timedelta64(60, "s"))[:, 0].tolist() == [0, 0, -1]


@pytest.mark.parametrize(
    ("satellite", "health", "expected"),
    [("G01", 0, True), ("G01", 1, False), ("G01", 63, False), ("J01", 1, True), ("J01", 32, False), ("C01", 1, False),
     ("E01", 0, True), ("E01", 1, False), ("E01", 0b10, False), ("E01", 0b1000, False), ("E18", 130, False), ("E01", 1 << 9, True)],
)  # fmt: skip
def test_health_bits_that_matter(satellite, health, expected):
    assert is_healthy(data_set(satellite, health=health)).tolist() == [expected]


def test_inav_goes_before_fnav_and_fnav_serves_where_there_is_no_other():
    inav, fnav = data_set("E01", clock_issue=517, issue=7), data_set("E01", clock_issue=258, issue=7)
    only_fnav = data_set("E01", TOE + 4 * HOUR, clock_issue=258, issue=8)
    for parts in ((inav, fnav, only_fnav), (only_fnav, fnav, inav)):
        eph = merge_ephemerides(parts)
        chosen = select_ephemerides(eph, ["E01"], TOE + HOUR * np.array([0, 3, 5]))[:, 0]
        assert eph.clock_issue[chosen].tolist() == [517, 517, 258]


# Corrections ----------------------------------------------------------------------------------------------------------


def test_rotation_to_reception_is_the_sagnac_range():
    """Range in the rotated frame equals the range before plus w/c (x_s y_r - y_s x_r), to (w tau)^2 r / 2 = 0.4 mm."""
    sat, receiver = np.array([6.0e6, 22.0e6, 13.0e6]), np.array([-3.9e6, 3.3e6, 3.7e6])
    before = np.linalg.norm(sat - receiver)
    after = np.linalg.norm(rotate_to_reception(sat, before / SPEED_OF_LIGHT) - receiver)
    sagnac = orbits.EARTH_RATE["G"] / SPEED_OF_LIGHT * (sat[0] * receiver[1] - sat[1] * receiver[0])
    assert abs(after - before - sagnac) < 1 * MILLIMETRE
    assert abs(sagnac) > 20


@given(st.lists(angles(3e7), min_size=3, max_size=3), st.floats(0, 0.2))
def test_rotation_to_reception_keeps_length_and_goes_back(position, travel):
    there = rotate_to_reception(position, travel)
    assert np.linalg.norm(there) == pytest.approx(np.linalg.norm(position), abs=MICROMETRE)
    np.testing.assert_allclose(rotate_to_reception(there, -travel), position, atol=MICROMETRE)


def delays(satellite, bands, **values):
    return [group_delay(data_set(satellite, **values), np.array([[0]]), satellite[:1], band)[0, 0] for band in bands]


@pytest.mark.parametrize(
    ("satellite", "bands", "data_sources"),
    [("G01", "12", 0), ("J01", "12", 0), ("E01", "17", 517), ("E01", "15", 258)],
)
def test_group_delays_cancel_in_the_combination_the_clock_is_made_for(satellite, bands, data_sources):
    """The broadcast clock is that of the ionosphere-free combination: f1^2 d1 - f2^2 d2 = 0."""
    first, second = delays(satellite, bands, group_delay=[3e-9, -5e-9], clock_issue=data_sources)
    f1, f2 = (frequency(satellite[0], band) for band in bands)
    assert abs(f1**2 * first - f2**2 * second) < 1e-12 * f1**2 * 1e-9
    assert first != 0


def test_group_delays_by_hand():
    assert delays("G01", "1", group_delay=[3e-9, 0.0]) == [3e-9]
    assert delays("C06", "276", group_delay=[3e-9, -5e-9]) == [3e-9, -5e-9, 0.0]
    assert delays("E01", "1", group_delay=[3e-9, -5e-9], clock_issue=517) == [-5e-9]
    assert delays("E01", "1", group_delay=[3e-9, -5e-9], clock_issue=258) == [3e-9]


def test_an_inav_clock_serves_e1_e5a_but_for_the_difference_of_the_two_clocks():
    """With the clock of E1/E5b the combination E1/E5a is off by BGD(E1,E5b) - BGD(E1,E5a), as the ICD defines the two."""
    first, second = delays("E01", "15", group_delay=[3e-9, -5e-9], clock_issue=517)
    f1, f5 = frequency("E", "1"), frequency("E", "5")
    assert (f1**2 * first - f5**2 * second) / (f1**2 - f5**2) == pytest.approx(-5e-9 - 3e-9, rel=1e-12)


def test_group_delay_of_several_satellites_follows_the_index():
    eph = merge_ephemerides([data_set("G01", group_delay=[1e-9, 0.0]), data_set("C06", group_delay=[2e-9, 3e-9])])
    c06, g01 = 0, 1
    index = np.array([[g01, c06], [-1, c06]])
    np.testing.assert_array_equal(group_delay(eph, index, "GC", ["1", "7"]), [[1e-9, 3e-9], [np.nan, 3e-9]])
    with pytest.raises(ValueError, match="no carrier frequency"):
        group_delay(eph, index, "GC", "9")
