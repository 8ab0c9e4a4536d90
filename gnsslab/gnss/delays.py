"""Delays of code by the atmosphere: Klobuchar's ionosphere and Saastamoinen's troposphere; all arguments broadcast."""

import numpy as np

from gnsslab.gnss.signals import SPEED_OF_LIGHT, frequency
from gnsslab.gnss.times import week_and_tow

_L1 = frequency("G", "1")
_NIGHT = 5e-9  # [s], constant vertical delay at night
_LATEST = 50_400.0  # [s], local time of the day's greatest delay: 14 h


def klobuchar(coefficients, time, latitude, longitude, azimuth, elevation, frequency=_L1):
    """Return the ionospheric delay of code [m] after Klobuchar; the carrier is advanced by as much. Zero below the horizon.

    `coefficients` (8,) are alpha 0-3, beta 0-3 as broadcast, `time` GPS time labels, all angles in radians, `frequency` in Hz:
    delay = c F (5e-9 + A cos x) (f1/f)^2, the cosine by its series, for |x| < 1.57, else c F 5e-9 (f1/f)^2.

    Source: IS-GPS-200N section 20.3.3.5.2.5, with its semicircles. At zenith at night 5 ns remain:
    >>> float(klobuchar(np.zeros(8), np.datetime64("2024-01-01T00:00"), 0.0, 0.0, 0.0, np.pi / 2).round(2))
    1.5
    """
    elevation_sc = np.asarray(elevation) / np.pi
    latitude_m, longitude_i = _pierce_point(np.asarray(latitude), np.asarray(longitude), np.asarray(azimuth), elevation_sc)
    local_time = (43_200 * longitude_i + week_and_tow(time)[1]) % 86_400
    powers = latitude_m[..., None] ** np.arange(4)
    amplitude = np.maximum(powers @ np.asarray(coefficients[:4], dtype=float), 0.0)
    period = np.maximum(powers @ np.asarray(coefficients[4:], dtype=float), 72_000.0)
    x = 2 * np.pi * (local_time - _LATEST) / period
    day = np.where(np.abs(x) < 1.57, amplitude * (1 + x**2 * (-0.5 + x**2 / 24)), 0.0)
    slant = 1 + 16 * (0.53 - elevation_sc) ** 3
    delay = SPEED_OF_LIGHT * slant * (_NIGHT + day) * (_L1 / np.asarray(frequency)) ** 2
    return np.where(elevation_sc <= 0, 0.0, delay)


def _pierce_point(latitude, longitude, azimuth, elevation_sc):
    """Return geomagnetic latitude and geographic longitude [semicircles] where the ray meets the ionosphere (350 km)."""
    psi = 0.0137 / (np.maximum(elevation_sc, 0.0) + 0.11) - 0.022
    latitude_i = np.clip(latitude / np.pi + psi * np.cos(azimuth), -0.416, 0.416)
    longitude_i = longitude / np.pi + psi * np.sin(azimuth) / np.cos(latitude_i * np.pi)
    return latitude_i + 0.064 * np.cos((longitude_i - 1.617) * np.pi), longitude_i


def saastamoinen(latitude, height, elevation, humidity=0.7):
    """Return the tropospheric delay [m] after Saastamoinen in the standard atmosphere, at latitude [rad] and height [m].

    T = 15 - 0.0065 h + 273.16 K, P = 1013.25 (1 - 2.2557e-5 h)^5.2568 hPa, e = 6.108 hum exp((17.15 T - 4684)/(T - 38.45)) hPa;
    dry = 0.0022768 P / (1 - 0.00266 cos 2 lat - 0.00028 h/km),  wet = 0.002277 (1255/T + 0.05) e;  delay = (dry + wet) / sin elevation.
    Heights below zero count as zero. Zero below the horizon and outside -100 m to 10 km, where this atmosphere means nothing.

    Source: Saastamoinen 1972, with the constants as RTKLIB's manual 2.4.2 (E.5) gives them. At the zenith at sea level:
    >>> float(saastamoinen(0.0, 0.0, np.pi / 2, humidity=0.0).round(3))
    2.313
    """
    latitude, height, elevation = np.asarray(latitude), np.asarray(height, dtype=float), np.asarray(elevation, dtype=float)
    is_outside = (height < -100) | (height > 10_000) | (elevation <= 0)
    h = np.clip(height, 0.0, 10_000.0)
    pressure = 1013.25 * (1 - 2.2557e-5 * h) ** 5.2568
    temperature = 15 - 6.5e-3 * h + 273.16
    vapour = 6.108 * humidity * np.exp((17.15 * temperature - 4684) / (temperature - 38.45))
    dry = 0.0022768 * pressure / (1 - 0.00266 * np.cos(2 * latitude) - 0.00028 * h / 1e3)
    wet = 0.002277 * (1255 / temperature + 0.05) * vapour
    sine = np.sin(np.where(elevation <= 0, np.pi / 2, elevation))
    return np.where(is_outside, 0.0, (dry + wet) / sine)
