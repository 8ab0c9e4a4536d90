"""Broadcast orbits and the light path, one satellite and one instant at a time, written for comparison only.

Written differently on purpose: plain floats; the Earth's turn while the signal travels is met by going to inertial axes and never
rotating a satellite "to reception"; light time by bisection-free fixed-point iteration there.
"""

import math

C = 299_792_458.0
WEEK = 604_800.0
GPS_EPOCH_NS = 315_964_800 * 10**9  # 1980-01-06 after 1970-01-01


def seconds_of_week(label, behind=0.0):
    """Return the seconds of the week of a datetime64[ns] label, `behind` seconds behind GPS time."""
    nanoseconds = int(label.astype("int64")) - GPS_EPOCH_NS - int(behind * 1e9)
    return (nanoseconds % int(WEEK * 1e9)) * 1e-9


def after(label, reference):
    """Return label - reference [s] of two datetime64[ns] labels."""
    return (int(label.astype("int64")) - int(reference.astype("int64"))) * 1e-9


def satellite_ecef(eph, row, t):
    """Return the ECEF position [m] at t [s] after toe (IS-GPS-200 table 20-IV; BDS-SIS-ICD table 5-11 for GEO)."""
    name = str(eph.satellite[row])
    is_beidou = name[0] == "C"
    mu = 3.986005e14 if name[0] in "GJ" else 3.986004418e14
    rate = 7.292115e-5 if is_beidou else 7.2921151467e-5
    a = eph.sqrt_a[row] ** 2
    M = eph.m0[row] + (math.sqrt(mu / a**3) + eph.delta_n[row]) * t
    e = eph.e[row]
    E = M
    for _ in range(60):
        E = M + e * math.sin(E)  # contracts by e <= 0.13 a round
    nu = 2 * math.atan(math.sqrt((1 + e) / (1 - e)) * math.tan(E / 2))
    phi = nu + eph.omega[row]
    s2, c2 = math.sin(2 * phi), math.cos(2 * phi)
    u = phi + eph.cus[row] * s2 + eph.cuc[row] * c2
    r = a * (1 - e * math.cos(E)) + eph.crs[row] * s2 + eph.crc[row] * c2
    i = eph.i0[row] + eph.idot[row] * t + eph.cis[row] * s2 + eph.cic[row] * c2
    toe = seconds_of_week(eph.toe[row], 14.0 if is_beidou else 0.0)
    is_geo = is_beidou and (int(name[1:]) <= 5 or int(name[1:]) >= 59)
    node = eph.omega0[row] - rate * toe + (eph.omega_dot[row] - (0.0 if is_geo else rate)) * t
    xo, yo = r * math.cos(u), r * math.sin(u)
    x = xo * math.cos(node) - yo * math.cos(i) * math.sin(node)
    y = xo * math.sin(node) + yo * math.cos(i) * math.cos(node)
    z = yo * math.sin(i)
    if is_geo:
        tilt = math.radians(-5.0)
        y, z = y * math.cos(tilt) + z * math.sin(tilt), -y * math.sin(tilt) + z * math.cos(tilt)
        angle = rate * t
        x, y = x * math.cos(angle) + y * math.sin(angle), -x * math.sin(angle) + y * math.cos(angle)
    return x, y, z


def clock(eph, row, label, seconds):
    """Return the satellite clock's error [s] with relativity at label + seconds."""
    t = after(label, eph.toc[row]) + seconds
    mu = 3.986005e14 if str(eph.satellite[row])[0] in "GJ" else 3.986004418e14
    M = eph.m0[row] + (math.sqrt(mu) / eph.sqrt_a[row] ** 3 + eph.delta_n[row]) * (after(label, eph.toe[row]) + seconds)
    E = M
    for _ in range(60):
        E = M + eph.e[row] * math.sin(E)
    relativity = -2 * math.sqrt(mu) / C**2 * eph.e[row] * eph.sqrt_a[row] * math.sin(E)
    return eph.af0[row] + eph.af1[row] * t + eph.af2[row] * t * t + relativity


def distance(eph, row, label, seconds, receiver):
    """Return the length [m] of the light path that ends at label + seconds at an ECEF place, and the travel time [s]."""
    travel = 0.08
    for _ in range(6):
        sent = seconds - travel
        x, y, z = satellite_ecef(eph, row, after(label, eph.toe[row]) + sent)
        turn = 7.2921151467e-5 * -travel  # inertial axes: those of ECEF at reception
        xi = x * math.cos(turn) - y * math.sin(turn)
        yi = x * math.sin(turn) + y * math.cos(turn)
        rho = math.dist((xi, yi, z), tuple(receiver))
        travel = rho / C
    return rho, travel


def pseudorange(eph, row, label, receiver_clock, receiver):
    """Return c (t_r - clock reading at transmission) [m] of a receiver that stamps `label` and is at an ECEF place when it measures."""
    rho, travel = distance(eph, row, label, -receiver_clock, receiver)
    return rho + C * (receiver_clock - clock(eph, row, label, -receiver_clock - travel))
