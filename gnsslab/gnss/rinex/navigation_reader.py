"""Reading broadcast navigation files: RINEX 2.x, 3.0x and 4.0x, as published by the IGS and RTCM.

A data set is a line with satellite, time of clock and three numbers, and seven lines of four numbers, 19 columns each.
Orbits are read of GPS, Galileo, BeiDou (D1, D2) and QZSS; data sets of other systems and messages are counted and said.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np

from gnsslab.gnss.ephemerides import ARRAY_FIELDS, Ephemerides
from gnsslab.gnss.rinex.navigation_fields import CLOCK_ISSUE_COLUMN, COLUMNS, FIELDS, is_orbit
from gnsslab.gnss.rinex.navigation_header import read_header
from gnsslab.gnss.rinex.navigation_records import epoch_of, is_blank, read_body, values_of
from gnsslab.gnss.rinex.text import read_text
from gnsslab.gnss.signals import USED_SYSTEMS
from gnsslab.gnss.times import BDT_BEHIND_GPS, SECONDS_PER_WEEK, add_seconds, week_and_tow

UNKNOWN_ACCURACY = 6144.0  # [m]: beyond this, the end of URA index 14, and below zero (Galileo) there is no prediction


def read_rinex_nav(*paths):
    """Read one or several navigation files into one `Ephemerides`; data sets that are repeated stand in it once.

    Week numbers are not trusted: toe and the time of transmission are taken within half a week of toc. The first
    ionosphere coefficients of a system and the first leap seconds serve. `.warnings` says what was left out, and why.
    Raises RinexError (file, line, expected, found) where a file is no navigation file or a number cannot be read.
    """
    if not paths:
        raise ValueError("expected at least one navigation file, came none; give its name")
    return merge_ephemerides([_read_file(path) for path in paths])


def merge_ephemerides(parts):
    """Return one `Ephemerides` of several: sorted by satellite, toe and time of transmission, repeated data sets dropped."""
    columns = {name: np.concatenate([getattr(part, name) for part in parts]) for name in ARRAY_FIELDS}
    order = np.lexsort((columns["transmission"], columns["toe"], columns["satellite"]))
    columns = {name: column[order] for name, column in columns.items()}
    kept = _first_of_equals(columns)
    ionosphere = {}
    for part in reversed(parts):
        ionosphere.update(part.ionosphere)
    return Ephemerides(
        **{name: column[kept] for name, column in columns.items()},
        ionosphere=ionosphere,
        leap_seconds=next((part.leap_seconds for part in parts if part.leap_seconds is not None), None),
        warnings=tuple(warning for part in parts for warning in part.warnings),
        source=", ".join(part.source for part in parts if part.source),
    )


def _first_of_equals(columns):
    """Return the rows that repeat no earlier one: same satellite, toe, toc, issue, health and Galileo message."""
    is_inav = (columns["satellite"].astype("<U1") == "E") & (columns["clock_issue"] & 0b101 > 0)
    names = ("satellite", "toe", "toc", "issue", "health")
    keys = zip(*(columns[name].tolist() for name in names), is_inav.tolist(), strict=True)
    first = {}
    for row, key in enumerate(keys):
        first.setdefault(key, row)
    return np.array(list(first.values()), dtype=int)


def _read_file(path):
    text, complaints = read_text(path)
    lines = text.rstrip(b"\x1a\x00").decode("latin-1").split("\n")  # DOS programs end a file with 1A
    header = read_header(lines, path)
    body = read_body(lines, header, path)
    kept, odd = _without_odd([(record, values_of(record, path)) for record in body.records])
    toc = [epoch_of(record, path) for record, _ in kept]
    warnings = [*complaints, *header.warnings, *body.warnings, *odd]
    return replace(
        _ephemerides_of(kept, toc),
        ionosphere={**{name: np.array(eight) for name, eight in body.ionosphere.items()}, **header.ionosphere},
        leap_seconds=header.leap_seconds,
        warnings=tuple(f"{Path(path).name}: {warning}" for warning in warnings),
        source=str(path),
    )


def _without_odd(rows):
    """Return the rows whose orbit is one of a navigation satellite, and what is to be said of the others."""
    said = []
    for record, values in rows:
        if not is_orbit(values):
            sqrt_a, e, toe = (values[COLUMNS[name]] for name in ("sqrt_a", "e", "toe"))
            what = f"root of the semi-major axis {sqrt_a:g}, eccentricity {e:g}, toe {toe:g} s, clock {values[0]:g} s"
            said.append(f"line {record.line}: the data set of {record.satellite} is no orbit ({what}) and is left out")
    return [row for row in rows if is_orbit(row[1])], said


_TAKEN_AS_WRITTEN = ARRAY_FIELDS[4:22]  # sqrt_a to af2


def _ephemerides_of(rows, toc):
    """Return the `Ephemerides` of (record, 31 numbers) and their times of clock [ns since 1970, own time scale]."""
    satellite = np.array([record.satellite for record, _ in rows], dtype="<U3")
    toc = np.array(toc, dtype=np.int64).astype("datetime64[ns]")
    table = np.array([values for _, values in rows], dtype=float).reshape(-1, FIELDS)
    column = {name: table[:, place] for name, place in COLUMNS.items()}
    letters = satellite.astype("<U1")
    to_gps = np.where(letters == "C", BDT_BEHIND_GPS, np.timedelta64(0, "s"))
    clock_issue = np.select([letters == s for s in USED_SYSTEMS], [table[:, CLOCK_ISSUE_COLUMN[s]] for s in USED_SYSTEMS])
    is_promised = (column["accuracy"] >= 0) & (column["accuracy"] <= UNKNOWN_ACCURACY)
    return Ephemerides(
        satellite=satellite,
        toe=within_half_a_week(toc, column["toe"]) + to_gps,
        toc=toc + to_gps,
        transmission=_transmission(rows, toc, column["transmission"]) + to_gps,
        group_delay=np.stack([column["delay_1"], np.where(np.isin(letters, ["E", "C"]), column["delay_2"], 0.0)], axis=-1),
        issue=_integers(column["issue"]),
        clock_issue=_integers(clock_issue),
        accuracy=np.where(is_promised, column["accuracy"], np.nan),
        health=_integers(column["health"]),
        **{name: column[name].copy() for name in _TAKEN_AS_WRITTEN},
    )


def _transmission(rows, toc, tow):
    """Return times of transmission; NaT where the field is blank or holds the 0.9999E9 that RINEX has for unknown."""
    is_written = np.array([not is_blank(record, COLUMNS["transmission"]) for record, _ in rows], dtype=bool)
    is_known = is_written & (np.abs(tow) <= SECONDS_PER_WEEK)
    return np.where(is_known, within_half_a_week(toc, tow), np.datetime64("NaT", "ns"))


def within_half_a_week(time, tow):
    """Return the time label with time of week tow [s] that is nearest to a time label.

    >>> print(within_half_a_week(np.datetime64("2024-06-22T23:59:44"), 0.0))
    2024-06-23T00:00:00.000000000
    """
    ahead = (tow - week_and_tow(time)[1] + SECONDS_PER_WEEK / 2) % SECONDS_PER_WEEK - SECONDS_PER_WEEK / 2
    return add_seconds(time, ahead)


def _integers(values):
    return np.round(values).astype(np.int64)
