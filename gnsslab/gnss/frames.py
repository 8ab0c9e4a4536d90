"""Frames: ECEF (e), local level East-North-Up (n) and geodetic coordinates on WGS84."""

import numpy as np

SEMI_MAJOR_AXIS = 6_378_137.0  # WGS84 [m]
FLATTENING = 1 / 298.257223563  # WGS84
ECCENTRICITY_SQUARED = FLATTENING * (2 - FLATTENING)


def ecef_from_geodetic(geodetic):
    """Return ECEF coordinates (..., 3) [m] of latitude, longitude [rad] and ellipsoidal height [m] (..., 3).

    N = a / sqrt(1 - e2 sin^2 lat);  x = (N + h) cos lat cos lon,  y = (N + h) cos lat sin lon,  z = (N (1 - e2) + h) sin lat

    >>> ecef_from_geodetic([0.0, 0.0, 100.0]).tolist()
    [6378237.0, 0.0, 0.0]
    """
    lat, lon, height = np.moveaxis(np.asarray(geodetic, dtype=float), -1, 0)
    N = SEMI_MAJOR_AXIS / np.sqrt(1 - ECCENTRICITY_SQUARED * np.sin(lat) ** 2)
    from_axis = (N + height) * np.cos(lat)
    up = (N * (1 - ECCENTRICITY_SQUARED) + height) * np.sin(lat)
    return np.stack([from_axis * np.cos(lon), from_axis * np.sin(lon), up], axis=-1)


def geodetic_from_ecef(position):
    """Return latitude, longitude [rad] and ellipsoidal height [m] (..., 3) of ECEF coordinates (..., 3) [m].

    Fixed-point iteration on the height of the ellipsoid's normal at the axis: z + e2 N sin lat; five rounds
    reach 1e-9 m from the ground to the satellites. At the centre of the Earth the latitude is taken as zero.

    >>> np.round(geodetic_from_ecef([6378237.0, 0.0, 0.0]), 6).tolist()
    [0.0, 0.0, 100.0]
    """
    x, y, z = np.moveaxis(np.asarray(position, dtype=float), -1, 0)
    from_axis = np.hypot(x, y)
    axis_cut = z
    for _ in range(5):
        slant = np.hypot(from_axis, axis_cut)
        sin_lat = np.divide(axis_cut, slant, out=np.zeros_like(slant), where=slant > 0)
        N = SEMI_MAJOR_AXIS / np.sqrt(1 - ECCENTRICITY_SQUARED * sin_lat**2)
        axis_cut = z + ECCENTRICITY_SQUARED * N * sin_lat
    lat = np.arctan2(axis_cut, from_axis)
    return np.stack([lat, np.arctan2(y, x), np.hypot(from_axis, axis_cut) - N], axis=-1)


def enu_rotation(position):
    """Return R_ne (..., 3, 3), the matrix that takes ECEF vectors to East-North-Up at ECEF positions (..., 3) [m].

    Rows are the unit vectors east [-sin lon, cos lon, 0], north and up (paper A, equation 4 with its first row mended).

    >>> (enu_rotation([6378137.0, 0.0, 0.0]) @ [10.0, 20.0, 30.0]).tolist()
    [20.0, 30.0, 10.0]
    """
    lat, lon, _ = np.moveaxis(geodetic_from_ecef(position), -1, 0)
    return enu_rotation_at(lat, lon)


def enu_rotation_at(lat, lon):
    """Return R_ne (..., 3, 3) as `enu_rotation` does, at latitudes and longitudes (...) [rad] already known.

    >>> (enu_rotation_at(np.pi / 2, 0.0) @ [0.0, 0.0, 1.0]).round(9).tolist()
    [0.0, 0.0, 1.0]
    """
    sin_lat, cos_lat, sin_lon, cos_lon = np.sin(lat), np.cos(lat), np.sin(lon), np.cos(lon)
    east = np.stack([-sin_lon, cos_lon, np.zeros_like(lon)], axis=-1)
    north = np.stack([-sin_lat * cos_lon, -sin_lat * sin_lon, cos_lat], axis=-1)
    up = np.stack([cos_lat * cos_lon, cos_lat * sin_lon, sin_lat], axis=-1)
    return np.stack([east, north, up], axis=-2)


def azimuth_elevation(u_enu):
    """Return azimuth [rad, clockwise from north, 0 to 2 pi) and elevation [rad] of ENU direction vectors (..., 3).

    >>> azimuth, elevation = azimuth_elevation([1.0, 0.0, 1.0])
    >>> float(np.degrees(azimuth)), float(np.degrees(elevation))
    (90.0, 45.0)
    """
    east, north, up = np.moveaxis(np.asarray(u_enu, dtype=float), -1, 0)
    return np.arctan2(east, north) % (2 * np.pi), np.arctan2(up, np.hypot(east, north))
