"""Times of messages: the label of each observation message, and when each ephemeris message came."""

import os
from typing import NamedTuple

import numpy as np

from gnsslab.gnss.rtcm.weeks import DAY, WEEK, Hint, first_week, glonass_times, label_of, unrolled, whole_week

_EARLIEST = label_of(WEEK)  # archives can give a file any date
_NOON = np.timedelta64(12, "h")
_NEVER = np.datetime64("NaT", "ns")


class Times(NamedTuple):
    """GPS time labels, datetime64[ns]."""

    observed: np.ndarray  # (M,) of the observation messages
    received: np.ndarray  # (b,) of the ephemeris messages: epoch observed last before it; NaT where there is none
    near: np.ndarray  # (b,) some time within half a week of each ephemeris message's reference times
    notes: tuple


def hint_of(path, start):
    """Return what is known of the date outside the log: the day the user says, else the date of the file."""
    if start is None:
        changed = np.datetime64(int(os.path.getmtime(path)), "s").astype("M8[ns]")
        return Hint(max(changed, _EARLIEST), is_given=False)
    try:
        day = np.datetime64(start).astype("M8[D]")
    except ValueError:
        day = _NEVER
    if np.isnat(day) or day < _EARLIEST:
        raise ValueError(f"start {start!r}: expected a date like 2026-06-26")
    return Hint(day.astype("M8[ns]") + _NOON, is_given=True)


def message_times(observed, broadcasts, places, hint):
    """Return the `Times` of observation messages and of `Broadcast` messages that stand at `places` (b,) of the log."""
    weekly = observed.system != "R"
    if not weekly.any():
        return _without_weeks(observed, broadcasts, hint)
    relative = unrolled(observed.clock[weekly])
    before = np.searchsorted(observed.place[weekly], places) - 1  # the observation message before each broadcast, -1: none
    clues = [broadcast.clue(int(relative[max(k, 0)])) for broadcast, k in zip(broadcasts, before.tolist(), strict=True)]
    week, notes = first_week(relative, clues, hint)
    time = np.empty(len(weekly), dtype="M8[ns]")
    time[weekly] = label_of(relative + week * WEEK)
    if not weekly.all():
        reference = np.maximum(np.searchsorted(observed.place[weekly], observed.place[~weekly]) - 1, 0)
        time[~weekly] = glonass_times(observed.clock[~weekly], time[weekly][reference])
    near = time[weekly][np.maximum(before, 0)]
    return Times(time, np.where(before >= 0, near, _NEVER), near, notes)


def _without_weeks(observed, broadcasts, hint):
    """Return the `Times` of a log without observations, or with such of GLONASS only, which count the day, not the week."""
    near = [label_of(whole_week(each.week, each.modulus, hint) * WEEK + round(each.toe * 1000)) for each in broadcasts]
    time, notes = np.empty(0, dtype="M8[ns]"), ()
    if len(observed.clock):
        since_first = unrolled(observed.clock, DAY) - observed.clock[0]
        time = glonass_times(observed.clock[:1], np.array([hint.label])) + since_first.astype("timedelta64[ms]")
        notes = (
            ()
            if hint.is_given
            else (f"GLONASS alone does not say the day: the date of the file serves ({hint.label.astype('M8[D]')}); else give --start",)
        )
    return Times(time, np.full(len(broadcasts), _NEVER), np.array(near, dtype="M8[ns]"), notes)
