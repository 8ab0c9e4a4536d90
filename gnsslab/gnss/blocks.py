"""Blocks: consecutive epochs with the same channels, run one after the other through the filter."""

from typing import NamedTuple

import numpy as np

from gnsslab.gnss.ambiguity_filter import filter_block
from gnsslab.gnss.differences import difference_pairs
from gnsslab.gnss.filter_steps import Block
from gnsslab.gnss.screening import LONGEST_GAP

LONGEST_BLOCK = 600  # epochs: a day of one set of satellites comes in parts, so that memory stays small and progress is seen


class Solution(NamedTuple):
    """The filter's results at T common epochs."""

    outcome: NamedTuple  # what the filter says, each field (T, ...); Outcome of ambiguity_filter
    satellites: np.ndarray  # (T,) int, in at least one double difference


class _State(NamedTuple):
    """What the filter knows between two blocks."""

    x: np.ndarray  # (p + n,) motion, then ambiguities [cycles]
    P: np.ndarray  # (p + n, p + n)
    channels: np.ndarray  # (n,) int, whose ambiguities they are


def run_blocks(model, path, progress=None, run=filter_block):
    """Return the Solution of a Model along a Path; ambiguities go on from block to block while their carrier does.

    `run(x, P, block)` is the filter: it returns x and P after the block's last epoch, and what it found.
    `progress(done, total)` is called after each block with the number of epochs done.
    """
    T, c = model.usable.shape
    p = path.offset.shape[1]
    state = _State(np.zeros(p), np.zeros((p, p)), np.zeros(0, int))
    last_seen = np.full(c, -1)
    outcomes, satellites = [], np.zeros(T, int)
    for first, end in _spans(model.usable):
        channels = np.flatnonzero(model.usable[first])
        block = _block(model, path, slice(first, end), channels)
        block.slip[0] |= ~np.isin(channels, state.channels)
        waiting = _waiting(state, channels, last_seen, first)
        x, P, outcome = run(*_rearranged(state, np.concatenate([channels, waiting]), p), block)
        state = _State(x, P, np.concatenate([channels, waiting]))
        last_seen[channels] = end - 1
        outcomes.append(outcome)
        satellites[first:end] = len(np.unique(model.pair.satellite[channels[[*block.channel, *block.reference]]]))
        if progress:
            progress(end, T)
    return Solution(type(outcomes[0])(*map(np.concatenate, zip(*outcomes, strict=True))), satellites)


def _spans(usable):
    """Return (first, end) of each run of epochs with the same channels, the long ones in parts."""
    changes = (np.flatnonzero((usable[1:] != usable[:-1]).any(axis=1)) + 1).tolist()
    for first, end in zip([0, *changes], [*changes, len(usable)], strict=True):
        for start in range(first, end, LONGEST_BLOCK):
            yield start, min(start + LONGEST_BLOCK, end)


def _block(model, path, span, channels):
    """Return the Block of a span of epochs; the channel of each group with the best carrier in the middle of it is the reference."""
    middle = (span.start + span.stop) // 2
    dense = np.ix_(range(span.start, span.stop), channels)
    channel, reference = difference_pairs(model.pair.group[channels], -model.sigma_phase[middle, channels])
    return Block(
        F=path.F[span],
        Q=path.Q[span],
        offset=path.offset[span],
        near=model.near[span],
        design=model.design[dense],
        code=model.code[dense],
        phase=model.phase[dense],
        sigma_code=model.sigma_code[dense],
        sigma_phase=model.sigma_phase[dense],
        novelty=model.novelty[dense],
        slip=model.slip[dense],
        drift=path.drift[span],
        wavelength=model.pair.wavelength[channels],
        channel=channel,
        reference=reference,
        channels=channels,
    )


def _waiting(state, channels, last_seen, epoch):
    """Return the channels without measurements now whose ambiguities are still kept, as they may come back."""
    is_recent = epoch - last_seen[state.channels] <= LONGEST_GAP
    return state.channels[is_recent & ~np.isin(state.channels, channels)]


def _rearranged(state, channels, p):
    """Return x, P for the ambiguities of the given channels; those not in the state yet are zero."""
    place = {channel: p + i for i, channel in enumerate(state.channels.tolist())}
    source = np.array([*range(p), *(place.get(channel, -1) for channel in channels.tolist())])
    known = source >= 0
    x = np.where(known, state.x[source], 0.0)
    P = np.where(known[:, None] & known, state.P[np.ix_(source, source)], 0.0)
    return x, P
