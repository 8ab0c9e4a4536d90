"""From an RTCM 3 log to the records that RINEX files give: `Observations` and `Ephemerides`."""

import gzip
import zlib
from collections import Counter
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from gnsslab.gnss.ephemerides import Ephemerides
from gnsslab.gnss.observations import Observations
from gnsslab.gnss.rinex.errors import quoted
from gnsslab.gnss.rtcm.ephemeris_messages import EPHEMERIS_MESSAGES, ephemerides_of, read_broadcast
from gnsslab.gnss.rtcm.errors import RtcmError
from gnsslab.gnss.rtcm.frames import find_frames
from gnsslab.gnss.rtcm.glonass import GLONASS_EPHEMERIS, frequency_channels
from gnsslab.gnss.rtcm.message_times import hint_of, message_times
from gnsslab.gnss.rtcm.msm import msm_system, read_cells
from gnsslab.gnss.rtcm.observed import find_observed
from gnsslab.gnss.rtcm.station_messages import STATION_MESSAGES, station_header
from gnsslab.gnss.rtcm.tables import observation_table

_BEGINNING = 65_536  # bytes
_GZIP = b"\x1f\x8b"


@dataclass(frozen=True, eq=False)
class RtcmLog:
    """What an RTCM 3 log holds."""

    observations: Observations
    ephemerides: Ephemerides
    messages: dict[int, int]  # message number -> how many, of all good frames

    @property
    def warnings(self):
        """What was set aside while reading, in words."""
        return (*self.observations.warnings, *self.ephemerides.warnings)

    def __repr__(self):
        return f"RtcmLog: {sum(self.messages.values())} messages; {self.observations}; {self.ephemerides}"


def read_rtcm(path, start=None, progress=None):
    """Return the `RtcmLog` of a file of RTCM 3 messages, plain or gzipped: the same records as of RINEX files.

    Read are MSM4 to MSM7 of GPS, Galileo, BeiDou, QZSS and GLONASS, the ephemerides 1019, 1042, 1044, 1045 and 1046, and
    of the station 1005 to 1008 and 1033. Messages of the same time are one epoch, whether or not the last of them, which
    the multiple message bit (DF393) announces, arrived. The week is that of the ephemerides, else the one nearest to
    `start` (the day it was recorded, "2026-06-26"), else that of the file's date, with a warning. Bit SLIP stands where
    lock times say that lock was lost, HALF_CYCLE where the half-cycle indicator is set. `progress(done, total)` is called
    with messages.

    `.warnings` says what was damaged, unknown or passed over. Raises RtcmError where there is no RTCM 3 message.
    """
    content = _content(path)
    frames = find_frames(content)
    if not len(frames.start):
        raise RtcmError(path, f"no RTCM 3 message was found; expected a binary log of them, it begins with {quoted(content[:20])}")
    numbers = frames.number.tolist()
    payloads = [content[a:b] for a, b in zip(frames.start.tolist(), frames.stop.tolist(), strict=True)]
    return _log(path, numbers, payloads, hint_of(path, start), progress, _frame_notes(frames))


def is_rtcm(path):
    """Return whether a file begins like an RTCM 3 log: a good message within its first 64 kB."""
    return len(find_frames(_content(path)[:_BEGINNING]).start) > 0


def _content(path):
    try:
        content = Path(path).read_bytes()
        content = gzip.decompress(content) if content.startswith(_GZIP) else content
    except IsADirectoryError:
        raise RtcmError(path, "this is a folder; name an RTCM 3 log in it") from None
    except (EOFError, zlib.error, gzip.BadGzipFile) as error:
        raise RtcmError(path, f"the gzip data are damaged ({error}); fetch the file again") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise RtcmError(path, f"the file cannot be read ({reason}); check the name and the folder") from None
    if not content:
        raise RtcmError(path, "the file is empty; expected an RTCM 3 log")
    return content


def _frame_notes(frames):
    if frames.damaged:
        yield f"damaged messages (wrong checksum) that were passed over: {frames.damaged}"
    if frames.is_cut_off:
        yield "the log ends within a message; that one is left out"
    if frames.passed_over:
        yield f"bytes that belong to no good message: {frames.passed_over}"


def _log(path, numbers, payloads, hint, progress, frame_notes):
    """Return the `RtcmLog` of messages."""
    observed, odd = find_observed(numbers, payloads)
    places, broadcasts, no_orbits = _broadcasts(numbers, payloads)
    times = message_times(observed, broadcasts, places, hint)
    cells = read_cells(observed.payloads, observed.layouts, progress)
    channels = frequency_channels(cells.get("R"), _of_kinds(numbers, payloads, (GLONASS_EPHEMERIS,)))
    names = {f"R{number:02d}": channel for number, channel in channels.items()}
    header, moved = station_header(_of_kinds(numbers, payloads, STATION_MESSAGES), observed.station, names)
    time, tables, said = _tables(cells, times.observed, channels)
    observations = Observations(
        time=time,
        tables=tables,
        header=header,
        power_failure=np.zeros(len(time), dtype=bool),
        warnings=(*frame_notes, *odd, *times.notes, *_backward_note(times.observed), *said, *moved, *_passed_over(numbers)),
        source=str(path),
    )
    ephemerides = replace(ephemerides_of(broadcasts, times.near, times.received), warnings=no_orbits, source=str(path))
    return RtcmLog(observations, ephemerides, dict(sorted(Counter(numbers).items())))


def _broadcasts(numbers, payloads):
    """Return places (b,) and `Broadcast` of the ephemeris messages, each content once, and a note on those that are no orbit."""
    first = {}
    for k, number in enumerate(numbers):
        if number in EPHEMERIS_MESSAGES:
            first.setdefault(payloads[k], k)
    found = {k: read_broadcast(numbers[k], payload) for payload, k in first.items()}
    good = {k: broadcast for k, broadcast in found.items() if broadcast is not None}
    bad = len(found) - len(good)
    note = (f"ephemeris messages left out, too short or no orbit of a navigation satellite: {bad}",) if bad else ()
    return np.array(list(good), dtype=np.int64), list(good.values()), note


def _of_kinds(numbers, payloads, kinds):
    """Return the (number, payload) pairs of some kinds of messages, each content once."""
    return list(dict.fromkeys((number, payload) for number, payload in zip(numbers, payloads, strict=True) if number in kinds))


def _tables(cells, message_time, channels):
    """Return the times of the epochs, the tables by system, and notes."""
    seen = np.zeros(len(message_time), dtype=bool)
    for each in cells.values():
        seen[each.message] = True
    time = np.unique(message_time[seen])
    epoch = np.searchsorted(time, message_time)
    made = {system: observation_table(system, each, epoch, time, channels) for system, each in sorted(cells.items())}
    tables = {system: table for system, (table, _) in made.items() if len(table.epoch)}
    return time, tables, [note for _, notes in made.values() for note in notes]


def _backward_note(time):
    back = int((np.diff(time) < np.timedelta64(0)).sum())
    return [f"observation messages earlier than the one before them: {back}; the epochs were put in order of time"] if back else []


def _passed_over(numbers):
    """Say which messages were not read."""
    read = {*EPHEMERIS_MESSAGES, *STATION_MESSAGES, GLONASS_EPHEMERIS}
    others = Counter(number for number in numbers if number not in read and not msm_system(number))
    words = ", ".join(f"{number} ({count})" for number, count in sorted(others.items()))
    return [f"messages that are not used here were passed over: {words}"] if words else []
