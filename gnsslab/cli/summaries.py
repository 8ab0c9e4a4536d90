"""What is in a RINEX file or an RTCM 3 log, in lines of text for `gnsslab info`."""

import numpy as np

from gnsslab.gnss.observations import HALF_CYCLE, SLIP
from gnsslab.gnss.orbits import is_healthy
from gnsslab.gnss.rinex.errors import RinexError, quoted
from gnsslab.gnss.rinex.text import read_bytes
from gnsslab.gnss.rtcm import is_rtcm
from gnsslab.gnss.signals import SYSTEM_NAMES, USED_SYSTEMS
from gnsslab.gnss.times import iso_text

SECOND = np.timedelta64(1_000_000_000, "ns")
MEASURED = "CLDS"  # code, carrier phase, Doppler, signal strength; X (receiver channel) and I (ionosphere) are no measurements


def summary(path):
    """Return what is in a RINEX file or an RTCM 3 log as lines of text; raise RinexError where it is none that is read here."""
    first_line = read_bytes(path).split(b"\n", 1)[0].decode("latin-1")
    kind = first_line[20:21] if first_line[60:].startswith("RINEX VERSION") else ""
    if kind == "O":
        return observation_summary(path)
    if kind == "N":
        return navigation_summary(path, first_line[:9].strip())
    if kind:
        raise RinexError(path, f"expected RINEX observations (O) or navigation (N), found {quoted(first_line[20:40])}", line=1)
    if is_rtcm(path):
        return rtcm_summary(path)
    raise RinexError(path, f"expected an RTCM 3 log or a RINEX file (`RINEX VERSION / TYPE` in columns 61-80), found {quoted(first_line)}", line=1)


def observation_summary(path):
    """Return what is in a file of observations as lines of text."""
    from gnsslab.gnss.rinex import read_rinex_obs

    observations = read_rinex_obs(path)
    header = observations.header
    return [
        f"{path}: RINEX {header.version:.2f} observations",
        f"marker       {header.marker or 'not given'}",
        *_station(header),
        *_epochs(observations),
        *([f"power fails  {int(observations.power_failure.sum())}"] if len(observations.time) else []),
        *_signals(observations),
        *_listed("event", observations.events),
        *_listed("warning", observations.warnings),
    ]


def rtcm_summary(path):
    """Return what is in an RTCM 3 log as lines of text."""
    from gnsslab.gnss.rtcm import read_rtcm

    log = read_rtcm(path)
    header = log.observations.header
    return [
        f"{path}: RTCM 3 log",
        f"messages     {', '.join(f'{number} ({count})' for number, count in log.messages.items())}",
        f"station      {header.marker}",
        *_station(header),
        "",
        *_epochs(log.observations),
        *_signals(log.observations),
        "",
        "ephemerides",
        *_data_sets(log.ephemerides),
        *_listed("warning", log.warnings),
    ]


def navigation_summary(path, version):
    """Return what is in a navigation file as lines of text."""
    from gnsslab.gnss.rinex import read_rinex_nav

    ephemerides = read_rinex_nav(path)
    return [
        f"{path}: RINEX {version} navigation",
        *_data_sets(ephemerides),
        f"ionosphere   {', '.join(SYSTEM_NAMES.get(s, s) for s in sorted(ephemerides.ionosphere)) or 'no coefficients'}",
        f"leap seconds {'not given' if ephemerides.leap_seconds is None else ephemerides.leap_seconds}",
        *_listed("warning", ephemerides.warnings),
    ]


def _station(header):
    return [
        f"receiver     {header.receiver or 'not given'}",
        f"antenna      {header.antenna or 'not given'}{_delta(header.antenna_delta_enu)}",
        f"position     {_position(header.position_ecef)}",
    ]


def _delta(delta_enu):
    east, north, up = delta_enu
    return f" ({up:.4f} m above the marker, {east:.4f} m east, {north:.4f} m north)" if np.any(delta_enu) else ""


def _position(position):
    return "not given" if position is None else "{:.4f} {:.4f} {:.4f} m (ECEF, approximate)".format(*position)


def _epochs(observations):
    time = observations.time
    if not len(time):
        return ["epochs       none"]
    return [
        f"span         {iso_text(time[0])} to {iso_text(time[-1])} (GPS time; written in {observations.header.time_scale})",
        f"epochs       {len(time)}, one every {observations.interval:g} s",
        f"gaps         {_gaps(observations)}",
    ]


def _gaps(observations):
    steps = np.diff(observations.time) / SECOND
    gaps = np.flatnonzero(steps > 1.5 * observations.interval) if len(steps) else []
    if not len(gaps):
        return "none"
    longest = gaps[np.argmax(steps[gaps])]
    return f"{len(gaps)}; the longest {steps[longest]:g} s from {iso_text(observations.time[longest])}"


def _signals(observations):
    lines = ["", "system   signal  measured  satellites  phases    share  slips  half-cycle"]
    for system in _in_order(observations.tables):
        table = observations.tables[system]
        for signal in dict.fromkeys(code[1:] for code in table.codes if code[0] in MEASURED):
            lines.append(f"{SYSTEM_NAMES.get(system, system):8} {signal:6}  {_signal_row(table, signal)}")
    names = [f"{SYSTEM_NAMES.get(s, s):8} {' '.join(observations.tables[s].satellites)}" for s in _in_order(observations.tables)]
    return [*lines, "", *names]


def _signal_row(table, signal):
    columns = [k for k, code in enumerate(table.codes) if code[1:] == signal]
    measured = np.isfinite(table.value[:, columns])
    kinds = "".join(table.codes[k][0] for k, any_ in zip(columns, measured.any(axis=0), strict=True) if any_)
    satellites = len(np.unique(table.number[measured.any(axis=1)]))
    phase = np.isfinite(_phase(table.value, table, signal, np.nan))
    lli = np.where(phase, _phase(table.lli, table, signal, 0), 0)
    slips, halves = (int(((lli & bit) != 0).sum()) for bit in (SLIP, HALF_CYCLE))
    share = f"{100 * phase.mean():.1f} %"
    return f"{kinds or '-':8}  {satellites:10}  {int(phase.sum()):6}  {share:>7}  {slips:5}  {halves:10}"


def _phase(values, table, signal, absent):
    column = table.column("L" + signal)
    return np.full(len(values), absent) if column is None else values[:, column]


def _data_sets(ephemerides):
    if not len(ephemerides.toe):
        return ["data sets    none"]
    systems = np.array([name[0] for name in ephemerides.satellite])
    lines = [f"span         {iso_text(ephemerides.toe.min())} to {iso_text(ephemerides.toe.max())} (reference times, GPS time)", ""]
    for system in _in_order(set(systems.tolist())):
        own = systems == system
        names = dict.fromkeys(ephemerides.satellite[own].tolist())
        unhealthy = dict.fromkeys(ephemerides.satellite[own & ~is_healthy(ephemerides)].tolist())
        lines.append(f"{SYSTEM_NAMES[system]:8} {own.sum():4} data sets of {len(names)} satellites: {' '.join(names)}")
        if unhealthy:
            lines.append(f"{'':8}      unhealthy at some time: {' '.join(unhealthy)}")
    return [*lines, ""]


def _in_order(systems):
    return sorted(systems, key=lambda s: (USED_SYSTEMS + "RSI").find(s))


def _listed(word, lines):
    return [f"{word + 's':12} none"] if not lines else [f"{word + 's':12} {len(lines)}", *(f"  {line}" for line in lines[:20])]
