"""Weeks: RTCM 3 counts time within the week (GLONASS: the day), so the week comes from ephemerides, the user or the file's date.

    GPS time = GPS, Galileo, QZSS time of week = BeiDou time of week + 14 s = GLONASS time of day - 3 h + leap seconds

Times are integers [ms] here until all is known. A log may run over the end of a week; gaps must be shorter than half of one.
"""

from collections import Counter
from typing import NamedTuple

import numpy as np

from gnsslab.gnss.times import BDT_BEHIND_GPS, GPS_EPOCH, SECONDS_PER_WEEK, leap_seconds

WEEK, DAY = SECONDS_PER_WEEK * 1000, 86_400_000  # [ms]
_GLONASS_AHEAD = 3 * 3_600_000  # [ms], of UTC
_GLONASS_CLOCK = (1 << 27) - 1  # DF034, behind three bits for the day of the week, which may be unknown
_MILLISECOND = np.timedelta64(1, "ms")
_BDT_BEHIND = int(BDT_BEHIND_GPS / _MILLISECOND)


class Clue(NamedTuple):
    """What one ephemeris message says about the week."""

    week: int  # GPS week as broadcast
    modulus: int  # the week is known up to multiples of this
    toe: int  # [ms] of the week, GPS time
    received: int  # [ms] since the beginning of the log's first week


class Hint(NamedTuple):
    """What is known of the date outside the log."""

    label: np.datetime64  # noon of the day it was recorded, or the date of the file
    is_given: bool  # by the user

    @property
    def day(self):
        """The date as text."""
        return str(self.label.astype("M8[D]"))


def is_possible(system, clock):
    """Return whether the 30 bits of a message's clock are a time.

    >>> is_possible("G", 604_800_000), is_possible("C", 604_799_999)
    (False, True)
    """
    return clock & _GLONASS_CLOCK < DAY + 1000 if system == "R" else clock < WEEK


def own_clock(system, clock):
    """Return GPS time of week [ms] of a message's clock; GLONASS: its own time of day [ms].

    >>> own_clock("C", 604_799_000)
    13000
    """
    if system == "R":
        return clock & _GLONASS_CLOCK
    return (clock + _BDT_BEHIND) % WEEK if system == "C" else clock


def unrolled(clock, period=WEEK):
    """Return clock readings (n,) [ms] without jumps back at the end of a period: each within half a period of the one before.

    >>> unrolled(np.array([604_799_000, 0, 1000])).tolist()
    [604799000, 604800000, 604801000]
    """
    step = (np.diff(clock) + period // 2) % period - period // 2
    return clock[0] + np.append(0, np.cumsum(step))


def first_week(relative, clues, hint):
    """Return the GPS week in which the log begins, and notes.

    relative (n,): times [ms] since the beginning of that week. Clues decide by majority, those that name the whole
    week before those that repeat after 1024; without any, the day that was given, else the date of the file, which must
    not lie before the log's end.
    """
    whole = [clue for clue in clues if clue.modulus > 1024]
    votes = Counter(_vote(clue, hint) for clue in whole or clues)
    if votes:
        week = votes.most_common(1)[0][0]
        return week, _contradiction(label_of(int(relative[0]) + week * WEEK), hint)
    outside = _milliseconds(hint.label)
    if hint.is_given:
        return round((outside - int(relative[0])) / WEEK), ()
    said = f"no message says in which week the log was recorded; the date of the file serves ({hint.day}): where that is wrong, give --start"
    return (outside - int(relative.max())) // WEEK, (said,)


def _vote(clue, hint):
    """Return the week in which the log begins if the clue's toe lies within half a week of when it was received."""
    toe = whole_week(clue.week, clue.modulus, hint) * WEEK + clue.toe
    return round((toe - clue.received) / WEEK)


def whole_week(week, modulus, hint):
    """Return a week that is known up to multiples of a modulus: nearest to the day that was given, or the last one not after the file's date.

    >>> whole_week(381, 1024, Hint(np.datetime64("2026-11-25T12:00"), False))
    2429
    """
    turns = (_milliseconds(hint.label) / WEEK - week) / modulus
    return week + modulus * max(round(turns) if hint.is_given else int(np.floor(turns)), 0)


def _contradiction(begin, hint):
    if hint.is_given and abs(begin - hint.label) > np.timedelta64(36, "h"):  # noon of the day: its hours, and a day of doubt
        return (f"the ephemerides in the log say that it begins on {begin.astype('M8[D]')}; --start {hint.day} was not used",)
    return ()


def glonass_times(time_of_day, reference):
    """Return GPS time labels (n,) of GLONASS times of day [ms], each within half a day of its reference label (n,)."""
    leap = leap_seconds(reference).astype(np.int64) * 1000
    own = time_of_day - _GLONASS_AHEAD + leap
    ahead = (own - _milliseconds(reference) + DAY // 2) % DAY - DAY // 2
    return label_of(_milliseconds(reference) + ahead)


def label_of(milliseconds):
    """Return the GPS time label of milliseconds since the GPS epoch.

    >>> print(label_of(WEEK))
    1980-01-13T00:00:00.000000000
    """
    return GPS_EPOCH + np.asarray(milliseconds, dtype=np.int64).astype("timedelta64[ms]")


def _milliseconds(label):
    since = (np.asarray(label, dtype="M8[ns]") - GPS_EPOCH) // _MILLISECOND
    return since if since.ndim else int(since)
