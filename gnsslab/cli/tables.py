"""Solutions as tables: CSV with one row a rover epoch, and RTKLIB's solution format."""

from pathlib import Path

import numpy as np

from gnsslab.gnss.frames import geodetic_from_ecef
from gnsslab.gnss.times import iso_text

STATUS_NAMES = ("none", "float", "fixed")
QUALITY = ("0", "2", "1")  # RTKLIB's numbers for float and fixed
SAME_EPOCH = np.timedelta64(25, "ms")  # a solution's label may differ from the rover's tag by the receivers' clocks

ATTITUDE_COLUMNS = "time,status,heading_deg,pitch_deg,length_m,east_m,north_m,up_m,sigma_heading_deg,sigma_pitch_deg,ratio,satellites"
RELATIVE_COLUMNS = "time,status,x_m,y_m,z_m,lat_deg,lon_deg,height_m,east_m,north_m,up_m,sigma_east_m,sigma_north_m,sigma_up_m,ratio,satellites"


def write_attitude_csv(path, attitude, time):
    """Write an attitude, one row for each of the rover's epochs `time`."""
    east, north, up = attitude.baseline_enu.T
    columns = [
        heading_texts(attitude.heading),
        texts(np.degrees(attitude.pitch), 4),
        *(texts(values, 4) for values in (attitude.length, east, north, up)),
        texts(np.degrees(attitude.sigma_heading), 4),
        texts(np.degrees(attitude.sigma_pitch), 4),
        texts(attitude.ratio, 2),
        texts(attitude.satellites, 0),
    ]
    _write_csv(path, ATTITUDE_COLUMNS, columns, attitude, time)


def write_relative_csv(path, relative, time):
    """Write a relative solution, one row for each of the rover's epochs `time`."""
    lat, lon, height = geodetic_from_ecef(relative.position_ecef).T
    columns = [
        *(texts(values, 4) for values in relative.position_ecef.T),
        texts(np.degrees(lat), 9),
        texts(np.degrees(lon), 9),
        texts(height, 4),
        *(texts(values, 4) for values in relative.baseline_enu.T),
        *(texts(values, 4) for values in sigmas(relative.Q_enu).T),
        texts(relative.ratio, 2),
        texts(relative.satellites, 0),
    ]
    _write_csv(path, RELATIVE_COLUMNS, columns, relative, time)


def write_relative_pos(path, relative, inputs=()):
    """Write a relative solution in RTKLIB's format (.pos): one line for each epoch with a solution, as RTKLIB does."""
    solved = np.flatnonzero(relative.status)
    geodetic = geodetic_from_ecef(relative.position_ecef[solved])
    lines = [*_pos_header(inputs), *(_pos_line(relative, k, place) for k, place in zip(solved, geodetic, strict=True))]
    Path(path).write_text("\n".join(lines) + "\n", encoding="utf-8")


def texts(values, decimals):
    """Return numbers as text with so many decimals; empty where a number is not finite.

    >>> texts([1.25, float("nan")], 1)
    ['1.2', '']
    """
    return [f"{value:.{decimals}f}" if finite else "" for value, finite in zip(values, np.isfinite(values), strict=True)]


def heading_texts(heading):
    """Return headings [rad] in degrees, in [0, 360) also after rounding.

    >>> heading_texts([2 * np.pi - 1e-9])
    ['0.0000']
    """
    return texts(np.round(np.degrees(heading), 4) % 360.0, 4)


def sigmas(Q_enu):
    """Return standard deviations (T, 3) of covariances (T, 3, 3)."""
    return np.sqrt(np.diagonal(Q_enu, axis1=-2, axis2=-1))


def _write_csv(path, header, columns, solution, time):
    names = [STATUS_NAMES[status] for status in solution.status]
    rows = list(zip(names, *columns, strict=True))
    empty = ("none",) + ("",) * len(columns)
    found = row_of_epoch(time, solution.time)
    lines = [",".join((iso_text(t), *(rows[k] if k >= 0 and solution.status[k] else empty))) for t, k in zip(time, found, strict=True)]
    Path(path).write_text("\n".join([header, *lines]) + "\n", encoding="utf-8")


def row_of_epoch(time, solution_time):
    """Return for each label of `time` the row of the solution at that epoch, -1 where there is none."""
    if not len(solution_time):
        return np.full(len(time), -1)
    after = np.clip(np.searchsorted(solution_time, time), 1, max(len(solution_time) - 1, 1))
    before = after - 1
    after = np.minimum(after, len(solution_time) - 1)
    nearest = np.where(time - solution_time[before] <= solution_time[after] - time, before, after)
    return np.where(np.abs(solution_time[nearest] - time) <= SAME_EPOCH, nearest, -1)


def _pos_header(inputs):
    from gnsslab import __version__

    return [
        f"% program   : gnsslab {__version__}",
        *(f"% inp file  : {name}" for name in inputs),
        "% (lat/lon/height=WGS84/ellipsoidal,Q=1:fix,2:float,3:sbas,4:dgps,5:single,6:ppp,ns=# of satellites)",
        f"%  {'GPST':22}latitude(deg) longitude(deg)  height(m)   Q  ns   sdn(m)   sde(m)   sdu(m)  sdne(m)  sdeu(m)  sdun(m) age(s)  ratio",
    ]


def _pos_line(relative, k, geodetic):
    lat, lon, height = geodetic
    Q = relative.Q_enu[k]
    spread = [signed_root(Q[i, j]) for i, j in ((1, 1), (0, 0), (2, 2), (1, 0), (0, 2), (2, 1))]
    time = iso_text(relative.time[k]).replace("-", "/").replace("T", " ")
    ratio = relative.ratio[k] if np.isfinite(relative.ratio[k]) else 0.0
    place = f"{np.degrees(lat):14.9f} {np.degrees(lon):14.9f} {height:10.4f}"
    quality = f"{QUALITY[relative.status[k]]:>3} {int(relative.satellites[k]):3d}"
    return f"{time} {place} {quality} {' '.join(f'{s:8.4f}' for s in spread)} {0.0:6.2f} {min(ratio, 9999.9):6.1f}"


def signed_root(q):
    """Return the root of a covariance with its sign, as RTKLIB writes it.

    >>> float(signed_root(-4.0))
    -2.0
    """
    return np.sign(q) * np.sqrt(np.abs(q))
