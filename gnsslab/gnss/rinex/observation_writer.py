"""Writing observations as RINEX 3.04 (IGS and RTCM-SC104 2018, tables A2 and A3)."""

import gzip
import os
from contextlib import suppress
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from gnsslab import __version__
from gnsslab.gnss.rinex.errors import RinexError
from gnsslab.gnss.signals import SYSTEM_NAMES

_FLAG_TEXT = " 123456789"
_LARGEST, _SMALLEST = 9_999_999_999.9995, -999_999_999.9995  # beyond these a number needs more than F14.3
_BLANK_NUMBER = " " * 14
_GZIP_LEVEL = 6  # a day of 15 s epochs in 1.2 s; level 9 takes 11 s for 4 % less


def write_rinex_obs(path, observations):
    """Write observations to a RINEX 3.04 file, in GPS time; a name ending in .gz is compressed.

    Values are rounded to 0.001 and times to 100 ns, as the format has it; NaN becomes blank. The file appears whole or
    not at all: it is written beside its place under another name first. Raises RinexError where the path cannot be
    written, a value does not fit into its columns or no satellite was observed.
    """
    if not observations.tables:
        raise RinexError(path, "there is nothing to write: these observations have no satellite")
    lines = [*_header_lines(observations), *_epoch_lines(observations, path), ""]
    write_whole(path, "\n".join(lines).encode("ascii", errors="replace"))


def write_whole(path, content):
    """Write a file so that it appears whole or not at all; RinexError says why where it cannot be written."""
    path = Path(path)
    beside = path.with_name(f".{path.name}.{os.getpid()}.part") if path.name else path
    try:
        beside.write_bytes(gzip.compress(content, _GZIP_LEVEL, mtime=0) if path.suffix.lower() == ".gz" else content)
        os.replace(beside, path)
    except (OSError, ValueError) as error:
        _remove(beside)
        reason = getattr(error, "strerror", None) or error
        raise RinexError(path, f"the file cannot be written ({reason}); check the folder and its permissions") from None


def _remove(beside):
    with suppress(OSError, ValueError):  # the reason why it could not be written is said by the caller
        beside.unlink(missing_ok=True)


def labelled(text, label):
    """Return one header line: up to 60 columns of text, the label from column 61 on.

    >>> labelled("    18", "LEAP SECONDS")
    '    18                                                      LEAP SECONDS'
    """
    plain = "".join(letter if letter.isprintable() else " " for letter in text)
    return f"{plain:<60.60}{label}"


def _header_lines(observations):
    header, systems = observations.header, observations.systems
    kind = systems if len(systems) == 1 else "M"
    made = datetime.now(UTC).strftime("%Y%m%d %H%M%S UTC")
    yield labelled(f"{3.04:9.2f}{'':11}{'OBSERVATION DATA':<20}{kind}", "RINEX VERSION / TYPE")
    yield labelled(f"{'gnsslab ' + __version__:<20.20}{'':20}{made:<20}", "PGM / RUN BY / DATE")
    yield labelled(header.marker, "MARKER NAME")
    yield labelled("", "OBSERVER / AGENCY")
    yield labelled(f"{'':20}{header.receiver:<20.20}", "REC # / TYPE / VERS")
    yield labelled(f"{'':20}{header.antenna:<20.20}", "ANT # / TYPE")
    yield from _place_lines(header)
    for system in _in_order(systems):
        yield from _type_lines(system, observations.tables[system].codes)
    yield from _phase_lines(observations)
    yield from _time_lines(observations)
    yield from _glonass_lines(header.glonass_channels)
    yield labelled("", "END OF HEADER")


def _place_lines(header):
    if header.position_ecef is not None:
        yield labelled("".join(f"{coordinate:14.4f}" for coordinate in header.position_ecef), "APPROX POSITION XYZ")
    east, north, up = header.antenna_delta_enu
    yield labelled(f"{up:14.4f}{east:14.4f}{north:14.4f}", "ANTENNA: DELTA H/E/N")


def _type_lines(system, codes):
    for at in range(0, len(codes), 13):
        start = f"{system}  {len(codes):3d}" if at == 0 else " " * 6
        yield labelled(start + "".join(f" {code:<3}" for code in codes[at : at + 13]), "SYS / # / OBS TYPES")


def _phase_lines(observations):
    """Phases are given as they are: no shift applied, so the correction stays blank (RINEX 3.04, section 9.1)."""
    for system in _in_order(observations.systems):
        for code in observations.tables[system].codes:
            if code.startswith("L"):
                yield labelled(f"{system} {code}", "SYS / PHASE SHIFT")


def _time_lines(observations):
    if observations.header.interval is not None:
        yield labelled(f"{observations.header.interval:10.3f}", "INTERVAL")
    if len(observations.time):
        yield labelled(_first_time(observations.time[0]), "TIME OF FIRST OBS")
        yield labelled(_first_time(observations.time[-1]), "TIME OF LAST OBS")


def _first_time(time):
    year, month, day, hour, minute, second = _calendar(time)
    return f"{year:6d}{month:6d}{day:6d}{hour:6d}{minute:6d}{second // 10**7:5d}.{second % 10**7:07d}     GPS"


def _calendar(time):
    """Return year, month, day, hour, minute and second in units of 100 ns."""
    ticks = (int(time.astype("datetime64[ns]").astype(np.int64)) + 50) // 100
    whole, second = divmod(ticks, 600_000_000)
    label = np.datetime64(whole, "m").item()
    return label.year, label.month, label.day, label.hour, label.minute, second


def _glonass_lines(channels):
    names = sorted(channels)
    for at in range(0, len(names), 8):
        start = f"{len(names):3d} " if at == 0 else " " * 4
        slots = "".join(f"{name} {channels[name]:2d} " for name in names[at : at + 8])
        yield labelled(start + slots, "GLONASS SLOT / FRQ #")


def _in_order(systems):
    return sorted(systems, key=list(SYSTEM_NAMES).index)


def _epoch_lines(observations, path):
    satellites = [[] for _ in observations.time]
    for system in _in_order(observations.systems):
        table = observations.tables[system]
        _refuse_misfits(table, observations.time, path)
        for epoch, text in zip(table.epoch.tolist(), _row_texts(table), strict=True):
            satellites[epoch].append(text)
    for time, failed, rows in zip(observations.time, observations.power_failure, satellites, strict=True):
        year, month, day, hour, minute, second = _calendar(time)
        stamp = f"{year:04d} {month:02d} {day:02d} {hour:02d} {minute:02d} {second // 10**7:2d}.{second % 10**7:07d}"
        yield f"> {stamp}  {int(failed)}{len(rows):3d}"
        yield from rows


def _row_texts(table):
    """Return the line of each row; a field is F14.3 and the two flags, 0 written as blank."""
    shape = table.value.shape
    if not table.value.size:
        return [f"{table.system}{number:02d}" for number in table.number]
    rounded = table.value.ravel() + 0.0
    rounded[np.abs(rounded) < 0.0005] = 0.0  # no "-0.000"
    numbers = ("%14.3f\n" * rounded.size % tuple(rounded.tolist())).split("\n")
    flags = zip(table.lli.ravel().tolist(), table.ssi.ravel().tolist(), strict=True)
    fields = [
        (_BLANK_NUMBER if number.endswith("nan") else number) + _FLAG_TEXT[lli] + _FLAG_TEXT[ssi]
        for number, (lli, ssi) in zip(numbers, flags, strict=False)
    ]
    width = shape[1]
    return [f"{table.system}{number:02d}{''.join(fields[at * width : (at + 1) * width])}".rstrip() for at, number in enumerate(table.number.tolist())]


def _refuse_misfits(table, time, path):
    """Raise RinexError at the first value or flag that does not fit into its columns."""
    misfit = np.isinf(table.value) | (table.value >= _LARGEST) | (table.value <= _SMALLEST)
    misfit |= (table.lli > 9) | (table.ssi > 9)
    if misfit.any():
        row, column = np.argwhere(misfit)[0]
        name = f"{table.codes[column]} of {table.system}{table.number[row]:02d} at {time[table.epoch[row]]}"
        found = f"{table.value[row, column]!s}, flags {table.lli[row, column]} and {table.ssi[row, column]}"
        raise RinexError(path, f"{name} does not fit: expected at most 10 digits before the point and flags 0 to 9, found {found}")
