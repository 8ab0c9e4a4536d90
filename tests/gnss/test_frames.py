"""Frames against published coordinates, an independent inverse (Bowring), and round trips."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gnsslab.gnss.frames import azimuth_elevation, ecef_from_geodetic, enu_rotation, geodetic_from_ecef

ROWS = json.loads((Path(__file__).parents[1] / "reference" / "satellites.json").read_text())["coordinates"]["rows"]
MICROMETRE = 1e-6
ON_THE_GROUND = 1e-13  # [rad], 0.6 um on the ground

latitudes, longitudes = st.floats(-math.pi / 2, math.pi / 2), st.floats(-math.pi, math.pi)
heights = st.floats(-10_000, 36_000_000)  # from the deepest sea to the geostationary orbit


def test_published_point_of_pymap3d():
    latitude, longitude, height = ROWS[0]["lla_deg_m"]
    position = ecef_from_geodetic([math.radians(latitude), math.radians(longitude), height])
    np.testing.assert_allclose(position, ROWS[0]["ecef"], atol=ROWS[0]["max_diff_m"] * 2)


def test_published_point_of_rtklib():
    latitude, longitude, height = geodetic_from_ecef(ROWS[1]["ecef"])
    got = [math.degrees(latitude), math.degrees(longitude), height]
    assert np.all(np.abs(np.subtract(got, ROWS[1]["lla_deg_m"])) < ROWS[1]["tol"])


def test_published_rotation_of_rtklib():
    here = ecef_from_geodetic([math.radians(35), math.radians(140), 0.0])
    np.testing.assert_allclose(enu_rotation(here) @ [0.3, 0.4, 0.5], ROWS[2]["enu"], atol=ROWS[2]["tol"])


@given(latitudes, longitudes, heights)
def test_geodetic_and_back(latitude, longitude, height):
    position = ecef_from_geodetic([latitude, longitude, height])
    again = geodetic_from_ecef(position)
    assert again[0] == pytest.approx(latitude, abs=ON_THE_GROUND)
    assert again[2] == pytest.approx(height, abs=MICROMETRE)
    np.testing.assert_allclose(ecef_from_geodetic(again), position, atol=MICROMETRE)


def bowring(x, y, z):
    """Bowring 1976: one step from the reduced latitude; good to 1e-9 rad near the ground."""
    a, f = 6_378_137.0, 1 / 298.257223563
    b, e2 = a * (1 - f), f * (2 - f)
    p = math.hypot(x, y)
    beta = math.atan2(z * a, p * b)
    return math.atan2(z + e2 / (1 - e2) * b * math.sin(beta) ** 3, p - e2 * a * math.cos(beta) ** 3)


@given(latitudes, longitudes, st.floats(-5000, 9000))
def test_latitude_is_bowrings(latitude, longitude, height):
    position = ecef_from_geodetic([latitude, longitude, height])
    assert geodetic_from_ecef(position)[0] == pytest.approx(bowring(*position), abs=1e-11)


@given(latitudes, longitudes)
def test_height_is_along_the_normal_and_the_foot_on_the_ellipsoid(latitude, longitude):
    foot, above = ecef_from_geodetic([[latitude, longitude, 0.0], [latitude, longitude, 1000.0]])
    assert (foot[0] ** 2 + foot[1] ** 2) / 6_378_137.0**2 + (foot[2] / 6_356_752.314245179) ** 2 == pytest.approx(1, abs=1e-14)
    np.testing.assert_allclose(enu_rotation(foot) @ (above - foot), [0, 0, 1000], atol=MICROMETRE)


@given(latitudes, longitudes, heights)
def test_enu_rotation_is_a_rotation(latitude, longitude, height):
    R_ne = enu_rotation(ecef_from_geodetic([latitude, longitude, height]))
    np.testing.assert_allclose(R_ne @ R_ne.T, np.eye(3), atol=1e-14)
    assert np.linalg.det(R_ne) == pytest.approx(1, abs=1e-14)


def test_poles_and_the_centre_of_the_earth_are_finite():
    geodetic = geodetic_from_ecef([[0.0, 0.0, 6_356_752.314245179], [0.0, 0.0, -7e6], [0.0, 0.0, 0.0]])
    assert np.isfinite(geodetic).all()
    np.testing.assert_allclose(geodetic[:2, 0], [math.pi / 2, -math.pi / 2])
    assert geodetic[0, 2] == pytest.approx(0, abs=MICROMETRE)


def test_stacks_keep_their_shape_and_nan_stays_nan():
    stack = np.full((4, 3, 3), 6_378_137.0)
    stack[2, 1] = np.nan
    stack.flags.writeable = False
    assert enu_rotation(stack).shape == (4, 3, 3, 3)
    assert np.isnan(geodetic_from_ecef(stack)[2, 1]).all()
    assert np.isfinite(np.delete(geodetic_from_ecef(stack).reshape(12, 3), 7, axis=0)).all()


@given(st.floats(0, 6.283), st.floats(-1.57, 1.57), st.floats(0.1, 1e8))
def test_azimuth_and_elevation_and_back(azimuth, elevation, distance):
    east, north = math.sin(azimuth) * math.cos(elevation), math.cos(azimuth) * math.cos(elevation)
    got = azimuth_elevation(distance * np.array([east, north, math.sin(elevation)]))
    turn = (got[0] - azimuth + math.pi) % (2 * math.pi) - math.pi
    assert abs(turn) * math.cos(elevation) < 1e-14 * 7
    assert got[1] == pytest.approx(elevation, abs=1e-14)
    assert 0 <= got[0] < 2 * math.pi or azimuth < 1e-15


def test_azimuth_runs_clockwise_from_north():
    azimuth, elevation = azimuth_elevation([[0, 1, 0], [1, 0, 0], [0, -1, 0], [-1, 0, 0], [0, 0, 1]])
    np.testing.assert_allclose(np.degrees(azimuth[:4]), [0, 90, 180, 270])
    np.testing.assert_allclose(np.degrees(elevation), [0, 0, 0, 0, 90])
