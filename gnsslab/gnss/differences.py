"""Differences: what two receivers measured together, and the operators that take clocks out of it.

A channel is one carrier of one satellite. Between receivers the satellite's clock cancels (single difference); between
channels of one group, the same system and the same carrier, the receivers' clocks cancel too (double difference).
"""

from dataclasses import dataclass

import numpy as np

from gnsslab.gnss.dense import signal_arrays
from gnsslab.gnss.observations import SLIP
from gnsslab.gnss.signals import BANDS, USED_SYSTEMS, check_systems, tracking_letters, wavelength
from gnsslab.gnss.times import iso_text, seconds_between

TAG_TOLERANCE = np.timedelta64(25, "ms")  # two receivers' tags of one epoch differ by their clocks: up to some milliseconds


@dataclass(frozen=True, eq=False)
class Tracks:
    """Measurements of one receiver on c channels over T epochs; NaN where nothing was measured."""

    code: np.ndarray  # (T, c) [m]
    phase: np.ndarray  # (T, c) [cycles]
    doppler: np.ndarray  # (T, c) [Hz]
    cn0: np.ndarray  # (T, c) [dB-Hz]
    lli: np.ndarray  # (T, c) uint8, loss-of-lock bits of the carrier


@dataclass(frozen=True, eq=False)
class Pair:
    """What master and rover measured together: T epochs, m satellites, c channels, sorted by group."""

    time: np.ndarray  # (T,) datetime64[ns], the rover's tags
    time_master: np.ndarray  # (T,) datetime64[ns]
    epoch: np.ndarray  # (T,) int, index into the rover's epochs
    epoch_master: np.ndarray  # (T,) int
    satellites: tuple[str, ...]  # (m,)
    satellite: np.ndarray  # (c,) int, index into satellites
    band: np.ndarray  # (c,) int, 0 first, 1 second, 2 third frequency of the system
    group: np.ndarray  # (c,) int, channels that may be differenced with each other
    signal_master: tuple[str, ...]  # (c,) band digit and tracking letter, "1C"
    signal_rover: tuple[str, ...]  # (c,)
    wavelength: np.ndarray  # (c,) [m]
    master: Tracks
    rover: Tracks


def difference_operator(m, reference):
    """Return D (m - 1, m): every one of m measurements minus the reference one.

    Rows sum to zero, so whatever is common to all (a receiver's clock) cancels; D D' has 2 on and 1 off the diagonal
    (paper A, equation 13 with its size mended).

    >>> difference_operator(3, 0).astype(int).tolist()
    [[-1, 1, 0], [-1, 0, 1]]
    """
    if not 0 <= reference < m:
        raise ValueError(f"reference {reference} is not one of the {m} measurements: give an index from 0 to {m - 1}")
    D = np.delete(np.eye(m), reference, axis=0)
    D[:, reference] = -1.0
    return D


def grouped_difference_operator(group, goodness):
    """Return D (c - g, c) for c channels in g groups: in each group, every channel minus the one of greatest goodness.

    A group with one channel has no difference. `group` and `goodness` are (c,), for instance elevations.

    >>> grouped_difference_operator(np.array([0, 0, 7]), np.array([0.2, 0.9, 0.5])).astype(int).tolist()
    [[1, -1, 0]]
    """
    channel, reference = difference_pairs(group, goodness)
    D = np.zeros((len(channel), len(group)))
    D[np.arange(len(channel)), channel] = 1.0
    D[np.arange(len(channel)), reference] = -1.0
    return D


def difference_pairs(group, goodness):
    """Return the rows of D as index arrays (channel, reference), each (c - g,): a difference is channel minus reference.

    >>> [index.tolist() for index in difference_pairs(np.array([0, 0, 7, 0]), np.array([0.2, 0.9, 0.5, 0.1]))]
    [[0, 3], [1, 1]]
    """
    best = {}
    for i in np.argsort(goodness, kind="stable"):
        best[group[i]] = i
    reference = np.array([best[label] for label in group], dtype=np.int64)
    channel = np.flatnonzero(reference != np.arange(len(group)))
    return channel, reference[channel]


def pair_receivers(master, rover, systems=USED_SYSTEMS, frequencies=2, signals=None, longest_age=0.0):
    """Return the Pair of two receivers' Observations: common epochs by time tag, and on each band of each satellite a signal both track.

    `frequencies` counts the bands of each system, in the order of signals.BANDS, leaving out what a receiver lacks; `signals`,
    RINEX observation codes such as "C2I", names them instead. The same tracking letter at both ends is preferred, as it
    leaves no code bias. With `longest_age` [s] an epoch of the rover's alone is paired with the master's last one, see `paired_epochs`.
    Raises ValueError when there is no epoch or no satellite to pair, for a system without orbits, or an age below zero.
    """
    check_systems(systems)
    epoch_master, epoch = paired_epochs(master.time, rover.time, longest_age)
    if not len(epoch):
        raise ValueError(
            f"no common epochs ({_tolerated(longest_age)}): the master has {_span(master)}, the rover {_span(rover)}; "
            "give two files of one session, sampled at the same instants"
        )
    channels = _common_channels(master, rover, systems, frequencies, signals)
    if not channels:
        raise ValueError(
            f"no common satellites: master and rover share no code and carrier of systems {systems} on the bands asked for; "
            "look at both files with `gnsslab info`"
        )
    satellites = tuple(sorted({c.satellite for c in channels}))
    return Pair(
        time=rover.time[epoch],
        time_master=master.time[epoch_master],
        epoch=epoch,
        epoch_master=epoch_master,
        satellites=satellites,
        satellite=np.array([satellites.index(c.satellite) for c in channels]),
        band=np.array([c.band for c in channels]),
        group=_group_numbers(channels),
        signal_master=tuple(c.signal_master for c in channels),
        signal_rover=tuple(c.signal_rover for c in channels),
        wavelength=np.array([wavelength(c.satellite[0], c.signal_rover[0]) for c in channels]),
        master=_tracks(master, epoch_master, channels, "signal_master"),
        rover=_tracks(rover, epoch, channels, "signal_rover"),
    )


def common_epochs(time_a, time_b, tolerance=TAG_TOLERANCE):
    """Return index arrays (i_a, i_b) of epochs whose tags agree within the tolerance, each epoch used at most once.

    >>> ms = np.array([0, 1000, 3000]), np.array([1001, 2001, 3001])
    >>> i_a, i_b = common_epochs(*(np.datetime64("2024-01-01", "ns") + t.astype("timedelta64[ms]") for t in ms))
    >>> i_a.tolist(), i_b.tolist()
    ([1, 2], [0, 2])
    """
    if not len(time_a) or not len(time_b):
        return np.zeros(0, int), np.zeros(0, int)
    after = np.searchsorted(time_a, time_b).clip(0, len(time_a) - 1)
    before = (after - 1).clip(0)
    nearest = np.where(np.abs(time_a[after] - time_b) < np.abs(time_a[before] - time_b), after, before)
    apart = np.abs(time_a[nearest] - time_b)
    i_b = np.argsort(apart, kind="stable")
    i_b = i_b[apart[i_b] <= tolerance]
    i_a, first = np.unique(nearest[i_b], return_index=True)  # of several near the same epoch the nearest
    return i_a, i_b[first]


def paired_epochs(time_master, time_rover, longest_age):
    """Return index arrays (i_master, i_rover), the rover's increasing: common epochs, and the last master epoch for the rover's others.

    The age of the master's data is the rover's tag minus the master's; those of more than `longest_age` [s] serve no longer, and
    with 0 the common epochs are all there are. A master epoch may serve several epochs of a faster rover.

    >>> master, rover = np.array([0, 1, 4]), np.array([0, 1, 2, 3, 4])
    >>> tags = [np.datetime64("2024-01-01", "ns") + t.astype("timedelta64[s]") for t in (master, rover)]
    >>> [index.tolist() for index in paired_epochs(*tags, longest_age=1.0)]
    [[0, 1, 1, 2], [0, 1, 2, 4]]
    """
    if not 0 <= longest_age < np.inf:
        raise ValueError(f"the longest age of the master's data must be 0 s (common epochs only) or more, not {longest_age:g}")
    i_master, i_rover = common_epochs(time_master, time_rover)
    source = np.searchsorted(time_master, time_rover, side="right") - 1
    is_served = (source >= 0) & (longest_age > 0)
    is_served[is_served] = seconds_between(time_rover[is_served], time_master[source[is_served]]) <= longest_age
    source[i_rover], is_served[i_rover] = i_master, True
    return source[is_served], np.flatnonzero(is_served)


@dataclass(frozen=True)
class _Channel:
    satellite: str
    band: int
    signal_master: str
    signal_rover: str


def _common_channels(master, rover, systems, frequencies, signals):
    """Return the channels of all systems, sorted by system, carrier and satellite."""
    channels = []
    for system in dict.fromkeys(systems):
        if system in master.tables and system in rover.tables:
            tables = master.tables[system], rover.tables[system]
            channels += _channels_of_signals(*tables, signals) if signals else _channels_of_bands(*tables, frequencies)
    return sorted(channels, key=lambda c: (c.satellite[0], c.band, c.signal_rover[0], c.satellite))


def _channels_of_bands(master, rover, frequencies):
    """Return a channel for each satellite on each of the first `frequencies` bands that both receivers have at all."""
    channels, band = [], 0
    for alternatives in BANDS[master.system]:
        found = _channels_of_band(master, rover, band, alternatives) if band < frequencies else []
        channels += found
        band += bool(found)
    return channels


def _channels_of_band(master, rover, band, alternatives):
    """Return a channel for each satellite; of alternative carriers ("21") the first one that it has."""
    chosen = {}
    for digit in alternatives:
        wanted = [digit + letter for letter in tracking_letters(master.system, digit)]
        for channel in _best_pairs(master, rover, band, wanted):
            chosen.setdefault(channel.satellite, channel)
    return list(chosen.values())


def _channels_of_signals(master, rover, signals):
    """Return a channel for each satellite and each band among the signals named."""
    wanted = [code[1:] for code in signals]
    digits = list(dict.fromkeys(signal[0] for signal in wanted))
    by_band = [[signal for signal in wanted if signal[0] == digit] for digit in digits]
    return [channel for band, group in enumerate(by_band) for channel in _best_pairs(master, rover, band, group)]


def _best_pairs(master, rover, band, wanted):
    """Return for each satellite the pair of wanted signals with most epochs; one letter at both ends unless that costs half of them."""
    count_master, count_rover = _signal_counts(master, wanted), _signal_counts(rover, wanted)
    channels = []
    for number in sorted(set(master.number.tolist()) & set(rover.number.tolist())):
        epochs = {
            (a, b): min(count_master[a][number], count_rover[b][number]) * (1 if a == b else 0.5)
            for a in count_master for b in count_rover
        }  # fmt: skip
        best = max(epochs, key=epochs.get, default=None)  # the first of equals: wanted stands best first
        if best and epochs[best] > 0:
            channels.append(_Channel(f"{master.system}{number:02d}", band, *best))
    return channels


def _signal_counts(table, wanted):
    """Return {signal: epochs with both code and carrier, by satellite number (256,)} of the wanted signals that the table has."""
    counts = {}
    for signal in wanted:
        code, phase = table.column("C" + signal), table.column("L" + signal)
        if code is not None and phase is not None:
            both = np.isfinite(table.value[:, code]) & np.isfinite(table.value[:, phase])
            counts[signal] = np.bincount(table.number[both], minlength=256)
    return counts


def _group_numbers(channels):
    keys = [(c.satellite[0], c.signal_rover[0]) for c in channels]
    order = list(dict.fromkeys(keys))
    return np.array([order.index(key) for key in keys])


def _tracks(observations, epochs, channels, end):
    *arrays, lli = signal_arrays(observations, [c.satellite for c in channels], [getattr(c, end) for c in channels])
    lli = lli | SLIP * observations.power_failure[:, None].astype(np.uint8)
    return Tracks(*(array[epochs] for array in arrays), lli[epochs] & ~np.uint8(SLIP) | _slips_on_the_way(lli, epochs))


def _slips_on_the_way(lli, epochs):
    """Return SLIP (T, c) where a receiver lost lock since the paired epoch before, also at epochs that the other one does not have.

    An epoch that serves again has lost nothing since.
    """
    losses = np.cumsum(lli & SLIP, axis=0, dtype=np.int32)[epochs]
    return SLIP * (np.diff(losses, axis=0, prepend=0) > 0).astype(np.uint8)


def _tolerated(longest_age):
    """Return in words how far the tags of two epochs may lie apart."""
    return f"tags within {TAG_TOLERANCE.astype(int)} ms" + (f", or the master's up to {longest_age:g} s older" if longest_age else "")


def _span(observations):
    if not len(observations.time):
        return "no epochs"
    return f"{iso_text(observations.time[0])} to {iso_text(observations.time[-1])}"
