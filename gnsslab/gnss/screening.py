"""Screening: which carriers may be used, and where their cycle count was broken."""

import numpy as np

from gnsslab.gnss.observations import HALF_CYCLE, SLIP
from gnsslab.gnss.signals import SEMI_CODELESS, SPEED_OF_LIGHT
from gnsslab.gnss.times import seconds_between

LONGEST_GAP = 5  # epochs a channel may be missing and still continue its count when no slip is flagged
SHADOW_LOSS = 6.0  # [dB] below the other antenna: what a signal loses when its satellite stands just behind an edge (knife-edge diffraction)
_GEOMETRY_FREE_JUMP = 0.05  # [m]: a cycle on either or both of L1 and L2 moves the combination by 54 mm at least
_GEOMETRY_FREE_SIGMAS = 3.0  # of the combination, where these are more: low satellites of noisy antennas
_LONGEST_IONOSPHERE_STEP = 60.0  # [s]: beyond, the ionosphere itself may move the combination by centimetres
_DOPPLER_JUMP = 1.5  # [cycles]: the mean Doppler of two epochs predicts the phase to about a cycle
_LONGEST_DOPPLER_STEP = 2.0  # [s]: beyond, accelerations spoil that prediction


def has_half_cycle(pair):
    """Return (T, c) bool: the carrier of either receiver may be off by half a cycle."""
    return ((pair.master.lli | pair.rover.lli) & HALF_CYCLE) > 0


def is_shadowed(pair):
    """Return (T, c) bool: one of the two antennas receives the signal so much weaker than the other that it comes round an edge.

    A diffracted carrier is longer by centimetres to decimetres, and changes slowly, so nothing else betrays it (Brunner,
    Hartinger and Troyer 1999). The usual difference of two receivers, the median over channels tracked in the same way, is no
    loss. Where one end tracks without the code (W, Y, D, P) and the other with it, strengths tell nothing of a shadow.
    """
    loss = pair.rover.cn0 - pair.master.cn0
    ways = np.array([f"{group} {a} {b}" for group, a, b in zip(pair.group, pair.signal_master, pair.signal_rover, strict=True)])
    for way in np.unique(ways):
        members = ways == way
        known = loss[:, members][np.isfinite(loss[:, members])]
        loss[:, members] -= np.median(known) if len(known) else 0.0
    with np.errstate(invalid="ignore"):
        return (np.abs(loss) > SHADOW_LOSS) & ~_tracked_unlike(pair)


def _tracked_unlike(pair):
    """Return (c,) bool: one receiver tracks the channel semi-codeless, the other does not."""
    ends = (pair.signal_master, pair.signal_rover)
    master, rover = (np.array([signal[1] in SEMI_CODELESS for signal in signals], dtype=bool) for signals in ends)
    return master != rover


def cycle_slips(pair, usable, sigma):
    """Return (T, c) bool: the ambiguity of the channel is not the one it had when last used.

    `usable` (T, c) bool are the measurements that enter the filter, `sigma` (T, c) [m] belongs to their single-difference
    carriers. Four reasons: a loss-of-lock flag of either receiver since the last usable epoch, a gap longer than LONGEST_GAP
    epochs, a jump of the geometry-free combination between bands, a jump of the carrier against the Doppler. The last two
    look at consecutive usable epochs.
    """
    last = _last_usable(usable)
    slip = _flagged_since(last, ((pair.master.lli | pair.rover.lli) & SLIP) > 0)
    slip |= (last >= 0) & (np.arange(len(usable))[:, None] - last > LONGEST_GAP + 1)
    slip |= _geometry_free_jumps(pair, last, sigma)
    for tracks, time in ((pair.master, pair.time_master), (pair.rover, pair.time)):
        slip |= _doppler_jumps(tracks, time, pair.wavelength, last)
    return slip & usable


def ages(usable, slip):
    """Return (T, c) int: at how many usable epochs, up to and with this one, each channel has had its present ambiguity.

    >>> ages(np.array([[True], [True], [False], [True]]), np.array([[False], [False], [False], [True]])).ravel().tolist()
    [1, 2, 2, 1]
    """
    count = np.cumsum(usable, axis=0)
    before_start = np.maximum.accumulate(np.where(slip, count - 1, 0), axis=0)
    return count - before_start


def row_medians(values):
    """Return the median (T,) of the numbers in each row (T, c), NaN where there is none: np.nanmedian takes ten times as long on short rows.

    >>> row_medians(np.array([[3.0, np.nan, 1.0, 9.0], [np.nan] * 4])).tolist()
    [3.0, nan]
    """
    ordered, count, row = np.sort(values, axis=1), (~np.isnan(values)).sum(axis=1), np.arange(len(values))  # NaN comes last
    return (ordered[row, (count - 1) // 2] + ordered[row, count // 2]) / 2


def _last_usable(usable):
    """Return (T, c) int: index of the usable epoch before each epoch, -1 where there is none."""
    index = np.where(usable, np.arange(len(usable))[:, None], -1)
    before = np.maximum.accumulate(index, axis=0)
    return np.vstack([np.full((1, usable.shape[1]), -1), before[:-1]])


def _flagged_since(last, flagged):
    """Return (T, c) bool: a flag stands at an epoch after `last`, up to and with this one."""
    count = np.cumsum(flagged, axis=0)
    return count > np.take_along_axis(count, last.clip(0), axis=0) * (last >= 0)


def _step(values, last):
    """Return (T, c) the change of values since the last usable epoch, NaN where there is none."""
    return np.where(last >= 0, values - np.take_along_axis(values, last.clip(0), axis=0), np.nan)


def _seconds_since(time, last):
    """Return (T, c) [s] since the last usable epoch."""
    return seconds_between(time[:, None], time[last.clip(0)])


def _geometry_free_jumps(pair, last, sigma):
    """Return (T, c) bool: the difference of two bands' carriers [m], between receivers, jumped; both bands are suspect."""
    change = _step((pair.rover.phase - pair.master.phase) * pair.wavelength, last)
    change[_seconds_since(pair.time, last) > _LONGEST_IONOSPHERE_STEP] = np.nan
    jump = np.zeros(change.shape, dtype=bool)
    for a, b in _band_pairs(pair):
        with np.errstate(invalid="ignore"):
            least = np.maximum(_GEOMETRY_FREE_JUMP, _GEOMETRY_FREE_SIGMAS * np.sqrt(2) * np.hypot(sigma[:, a], sigma[:, b]))
            both = (np.abs(change[:, a] - change[:, b]) > least) & (last[:, a] == last[:, b])
        jump[:, a] |= both
        jump[:, b] |= both
    return jump


def _band_pairs(pair):
    """Return index arrays (a, b) of channels of one satellite on two bands, one pair of arrays for each two bands."""
    channel_of = {(s, band): i for i, (s, band) in enumerate(zip(pair.satellite.tolist(), pair.band.tolist(), strict=True))}
    for first, second in ((0, 1), (0, 2), (1, 2)):
        both = [(channel_of[s, first], channel_of[s, second]) for s in range(len(pair.satellites)) if {(s, first), (s, second)} <= channel_of.keys()]
        if both:
            yield tuple(np.array(both).T)


def _doppler_jumps(tracks, time, wavelength, last):
    """Return (T, c) bool: one receiver's carrier left the path its Doppler foretold, by more than a jump of its clock explains.

    A clock that jumps by J moves the instant of measuring too: every carrier steps by J (c / wavelength + Doppler).
    """
    seconds = _seconds_since(time, last)
    mean_doppler = tracks.doppler - _step(tracks.doppler, last) / 2
    excess = _step(tracks.phase, last) + mean_doppler * seconds
    excess[seconds > _LONGEST_DOPPLER_STEP] = np.nan
    frequency = SPEED_OF_LIGHT / wavelength + mean_doppler
    jump = row_medians(excess / frequency)[:, None]
    with np.errstate(invalid="ignore"):
        return np.abs(excess - jump * frequency) > _DOPPLER_JUMP
