"""Ionosphere and troposphere models against published numbers, plain scalar versions, and what must hold by itself."""

import json
import math
from datetime import datetime
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gnsslab.gnss.delays import klobuchar, saastamoinen
from gnsslab.gnss.signals import SPEED_OF_LIGHT, frequency

REFERENCE = json.loads((Path(__file__).parents[1] / "reference" / "satellites.json").read_text())
ROUNDING = 1e-8  # [m], the tolerance of RTKLIB's own unit test
NOON = np.datetime64("2007-01-16T12:00:00", "ns")
COEFFICIENTS = np.array(REFERENCE["klobuchar"]["alpha_beta"])

latitudes, longitudes = st.floats(-math.pi / 2, math.pi / 2), st.floats(-math.pi, math.pi)
azimuths, elevations = st.floats(0, 2 * math.pi), st.floats(0.02, math.pi / 2)


@pytest.mark.parametrize("row", REFERENCE["klobuchar"]["rows"])
def test_klobuchar_gives_the_published_delays(row):
    date, lat, lon, _, azimuth, elevation, expected = row
    got = klobuchar(COEFFICIENTS, np.datetime64(datetime(*date), "ns"), *np.radians([lat, lon, azimuth, elevation]))
    assert got == pytest.approx(expected, abs=ROUNDING)


def test_klobuchar_of_all_rows_at_once():
    rows = REFERENCE["klobuchar"]["rows"]
    times = np.array([np.datetime64(datetime(*row[0]), "ns") for row in rows])
    lat, lon, _, azimuth, elevation, expected = np.array([row[1:] for row in rows]).T
    got = klobuchar(
        COEFFICIENTS, times[:, None], *(np.radians(x)[:, None] for x in (lat, lon)), *(np.radians(x)[:, None] for x in (azimuth, elevation))
    )
    assert got.shape == (len(rows), 1)
    np.testing.assert_allclose(got[:, 0], expected, atol=ROUNDING)


def klobuchar_by_the_book(c, tow, lat, lon, azimuth, elevation):
    """IS-GPS-200N figure 20-4, line by line in semicircles and seconds."""
    E, A, phi_u, lambda_u = elevation / math.pi, azimuth, lat / math.pi, lon / math.pi
    psi = 0.0137 / (E + 0.11) - 0.022
    phi_i = max(-0.416, min(0.416, phi_u + psi * math.cos(A)))
    lambda_i = lambda_u + psi * math.sin(A) / math.cos(phi_i * math.pi)
    phi_m = phi_i + 0.064 * math.cos((lambda_i - 1.617) * math.pi)
    t = math.fmod(4.32e4 * lambda_i + tow, 86400)
    t += 86400 if t < 0 else 0
    F = 1 + 16 * (0.53 - E) ** 3
    PER = max(72000.0, sum(c[4 + n] * phi_m**n for n in range(4)))
    AMP = max(0.0, sum(c[n] * phi_m**n for n in range(4)))
    x = 2 * math.pi * (t - 50400) / PER
    return SPEED_OF_LIGHT * F * (5e-9 + (AMP * (1 - x * x / 2 + x**4 / 24) if abs(x) < 1.57 else 0))


@given(st.integers(0, 604_799), latitudes, longitudes, azimuths, elevations)
def test_klobuchar_equals_the_book_in_plain_floats(tow, lat, lon, azimuth, elevation):
    time = np.datetime64("2007-01-14T00:00:00", "ns") + np.timedelta64(tow, "s")
    got = klobuchar(COEFFICIENTS, time, lat, lon, azimuth, elevation)
    # At |x| = 1.57 the cosine stops 0.0009 A above zero: a rounding of x may fall on either side.
    assert got == pytest.approx(klobuchar_by_the_book(COEFFICIENTS, tow, lat, lon, azimuth, elevation), abs=ROUNDING)


@given(latitudes, longitudes, azimuths, elevations)
def test_klobuchar_repeats_daily_and_scales_with_the_square_of_the_wavelength(lat, lon, azimuth, elevation):
    today = klobuchar(COEFFICIENTS, NOON, lat, lon, azimuth, elevation)
    tomorrow = klobuchar(COEFFICIENTS, NOON + np.timedelta64(1, "D"), lat, lon, azimuth, elevation)
    l2 = klobuchar(COEFFICIENTS, NOON, lat, lon, azimuth, elevation, frequency("G", "2"))
    assert today == pytest.approx(float(tomorrow), abs=ROUNDING)
    assert l2 == pytest.approx(float(today) * (77 / 60) ** 2, rel=1e-12)
    assert today > 1.49  # 5 ns at night are the least


def test_below_the_horizon_there_is_no_delay():
    below = np.radians([-10.0, 0.0])
    assert klobuchar(COEFFICIENTS, NOON, 0.6, 2.4, 1.0, below).tolist() == [0, 0]
    assert saastamoinen(0.6, 100.0, below).tolist() == [0, 0]


def test_nan_stays_nan():
    assert np.isnan(klobuchar(COEFFICIENTS, NOON, 0.6, 2.4, 1.0, np.nan))
    assert np.isnan(saastamoinen(0.6, np.nan, 1.0))


@pytest.mark.parametrize("row", REFERENCE["saastamoinen"]["rows"])
def test_saastamoinen_gives_the_published_delays(row):
    lat, _, height, _, elevation, humidity, expected = row
    assert saastamoinen(math.radians(lat), height, math.radians(elevation), humidity) == pytest.approx(expected, abs=ROUNDING)


@given(latitudes, st.floats(-100, 10_000), elevations, st.floats(0, 1))
def test_saastamoinen_equals_one_in_plain_floats(lat, height, elevation, humidity):
    z, h = math.pi / 2 - elevation, max(height, 0.0)
    T = 288.16 - 0.0065 * h
    p = 1013.25 * math.pow(1 - 0.000022557 * h, 5.2568)
    e = humidity * 6.108 * math.exp((17.15 * T - 4684) / (T - 38.45))
    expected = (0.0022768 * p / (1 - 0.00266 * math.cos(2 * lat) - 2.8e-7 * h) + 0.002277 * (1255 / T + 0.05) * e) / math.cos(z)
    assert saastamoinen(lat, height, elevation, humidity) == pytest.approx(expected, rel=1e-12)


@given(latitudes, st.floats(0, 9000), elevations)
def test_saastamoinen_falls_with_height_and_with_elevation(lat, height, elevation):
    here = saastamoinen(lat, height, elevation)
    assert saastamoinen(lat, height + 500, elevation) < here
    assert saastamoinen(lat, height, elevation / 2) > here
    assert saastamoinen(lat, height, math.pi / 2) < 2.6
