import numpy as np
import pytest
from scalar_orbits import clock, satellite_ecef

from gnsslab.gnss.ephemerides import ARRAY_FIELDS
from gnsslab.gnss.frames import azimuth_elevation, ecef_from_geodetic, enu_rotation, geodetic_from_ecef
from gnsslab.gnss.orbits import GEO_SATELLITES, satellite_states
from gnsslab.gnss.times import seconds_between
from gnsslab.simulate.sky import broadcast_ephemerides, constellation

MM = 1e-3
SUNDAY_EVE = np.datetime64("2024-06-22T18:00", "ns")  # the GPS week begins 6 h later: node and toe roll over
DAY = np.timedelta64(24, "h")


@pytest.fixture(scope="module")
def eph():
    return broadcast_ephemerides(SUNDAY_EVE, SUNDAY_EVE + DAY)


@pytest.fixture(scope="module")
def day(eph):
    """Positions (T, m, 3) every 10 min of the day."""
    time = SUNDAY_EVE + np.arange(0, 86_400, 600) * np.timedelta64(1, "s")
    return satellite_states(eph, eph.satellites, time, np.full((len(time), len(eph.satellites)), 0.08)).position


def test_changing_the_data_set_moves_neither_satellite_nor_clock(eph):
    compared = 0
    for row in range(len(eph.satellite) - 1):
        if eph.satellite[row] == eph.satellite[row + 1]:
            half = seconds_between(eph.toe[row + 1], eph.toe[row]) / 2
            old, new = (np.array(satellite_ecef(eph, row + k, t)) for k, t in ((0, half), (1, -half)))
            assert np.linalg.norm(new - old) < 0.2 * MM  # 13 digits of angles of 3 rad, on 42 000 km: 0.04 mm each
            clocks = [clock(eph, row + k, eph.toe[row], half) for k in (0, 1)]
            assert abs(clocks[1] - clocks[0]) * 299_792_458 < 0.2 * MM
            compared += 1
    assert compared > 100 * 10


def test_the_week_rolls_over_within_the_day(eph):
    weeks = (eph.toe - np.datetime64("1980-01-06", "ns")) // np.timedelta64(7, "D")
    assert len(np.unique(weeks)) == 2


def test_numbers_of_satellites():
    counts = {system: len(constellation(system)) for system in "GECJ"}
    assert counts == {"G": 30, "E": 24, "C": 45, "J": 4}  # BeiDou: 8 GEO, 10 inclined, 24 + 3 medium
    names = [orbit.satellite for system in "GECJ" for orbit in constellation(system)]
    assert len(set(names)) == len(names)
    assert {"C01", "C05", "C59", "J07"} <= set(names)


def test_geostationary_satellites_stand_still_in_the_sky(eph, day):
    longitudes = {"C01": 140.0, "C02": 80.0, "C03": 110.5, "C04": 160.0, "C05": 58.75, "C59": 140.0, "J07": 127.0}
    for name, longitude in longitudes.items():
        lat, lon, _ = np.degrees(geodetic_from_ecef(day[:, eph.satellites.index(name)])).T
        assert np.abs(lat).max() < 2.0  # [deg], the inclination
        assert np.abs(lon - longitude).max() < 0.2  # [deg]


def test_synchronous_satellites_repeat_their_ground_track_each_day(eph):
    sidereal_day = 86_164.1  # [s]
    names = [name for name in eph.satellites if name in ("C06", "C16", "C40", "J02", "J03", "J04")]
    time = np.array([SUNDAY_EVE, SUNDAY_EVE + np.timedelta64(round(sidereal_day * 1e9), "ns")])
    positions = satellite_states(eph, names, time, np.full((2, len(names)), 0.08)).position
    assert len(names) == 6
    assert np.linalg.norm(positions[1] - positions[0], axis=-1).max() < 20_000  # [m], of 42 000 km: idot, node rate over a day


@pytest.mark.parametrize(("system", "semi_major_axis", "inclination"), [("G", 26_560e3, 55.0), ("E", 29_600e3, 56.0)])
def test_medium_orbits_are_where_their_documents_say(eph, system, semi_major_axis, inclination):
    rows = np.char.startswith(eph.satellite, system)
    assert np.abs(eph.sqrt_a[rows] ** 2 - semi_major_axis).max() < 1_000  # [m]
    assert np.abs(np.degrees(eph.i0[rows]) - inclination).max() < 1.0


@pytest.mark.parametrize(("place", "least"), [((35.0, 137.0), 30), ((48.0, 11.0), 20), ((-33.0, -70.0), 15), ((80.0, 0.0), 15)])
def test_enough_satellites_are_in_view_all_day(eph, day, place, least):
    site = ecef_from_geodetic([*np.radians(place), 0.0])
    _, elevation = azimuth_elevation((day - site) @ enu_rotation(site).T)
    is_gps = np.char.startswith(np.array(eph.satellites), "G")
    in_view = elevation > np.radians(5)
    assert in_view.sum(axis=1).min() >= least
    assert in_view[:, is_gps].sum(axis=1).min() >= 6
    assert in_view[:, is_gps].sum(axis=1).max() <= 14


def test_data_sets_are_sorted_and_of_the_expected_kind(eph):
    order = np.lexsort((eph.toe, eph.satellite))
    assert np.array_equal(order, np.arange(len(order)))
    assert all(len(getattr(eph, name)) == len(order) for name in ARRAY_FIELDS)
    assert eph.group_delay.shape == (len(order), 2)
    assert np.issubdtype(eph.issue.dtype, np.integer)
    assert np.issubdtype(eph.health.dtype, np.integer)


def test_every_number_has_the_thirteen_digits_of_a_file(eph):
    for name in ("m0", "omega0", "i0", "sqrt_a", "af0", "group_delay"):
        values = getattr(eph, name).ravel()
        assert all(float(f"{value:.12e}") == value for value in values)


def test_every_epoch_has_a_data_set_also_at_the_ends():
    stop = SUNDAY_EVE + np.timedelta64(3, "h")
    eph = broadcast_ephemerides(SUNDAY_EVE, stop)
    states = satellite_states(eph, eph.satellites, np.array([SUNDAY_EVE, stop]), np.full((2, len(eph.satellites)), 0.08))
    assert (states.index >= 0).all()
    assert (eph.transmission[np.unique(eph.satellite, return_index=True)[1]] < SUNDAY_EVE).all()


def test_only_geostationary_beidou_is_in_the_tilted_frame(eph):
    inclination = {name: np.degrees(eph.i0[eph.satellite == name]).mean() for name in eph.satellites if name in GEO_SATELLITES}
    assert len(inclination) == 8
    assert all(3.0 < value < 7.0 for value in inclination.values())  # 5 deg of the frame, and the orbit's own 1.2


@pytest.mark.parametrize("systems", ["", "GR", "X"])
def test_unknown_systems_are_refused_in_words(systems):
    with pytest.raises(ValueError, match="letters G, E, C and J"):
        broadcast_ephemerides(SUNDAY_EVE, SUNDAY_EVE, systems)


def test_a_span_that_ends_before_it_begins_is_refused():
    with pytest.raises(ValueError, match="must not end before it begins"):
        broadcast_ephemerides(SUNDAY_EVE, SUNDAY_EVE - DAY)
