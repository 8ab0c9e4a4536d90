"""Frames: where the messages of an RTCM 3 log stand, found by preamble, length and checksum (RTCM 10403.3, section 4).

A frame is D3, six zero bits, ten bits of length, the message, 24 bits of checksum. Bytes of other protocols may stand
between frames, and a damaged frame may hide a good one behind its wrong length: so every place that looks like a frame
is checked, and the first good one from each place on is taken.
"""

from functools import cache
from typing import NamedTuple

import numpy as np

_PREAMBLE, _HEAD, _CHECKSUM = 0xD3, 3, 3  # bytes
_POLYNOMIAL = 0x1864CFB  # CRC-24Q (Qualcomm)
_AT_ONCE = 1024  # frames whose checksums are computed together: 8 MB


class Frames(NamedTuple):
    """The good frames of a log, in order, and what stands between them."""

    start: np.ndarray  # (n,) int64, first byte of the message, behind the frame's head
    stop: np.ndarray  # (n,) int64, first byte behind the message
    number: np.ndarray  # (n,) int64, message number: 1124
    damaged: int  # frames with a wrong checksum, whose place or length fits the good ones around them
    passed_over: int  # bytes that belong to no good frame
    is_cut_off: bool  # the log ends within a frame


def find_frames(content):
    """Return the `Frames` of a log's bytes.

    >>> find_frames(bytes.fromhex("00 d300043ee0000030d20f")).number.tolist()
    [1006]
    """
    octets = np.frombuffer(content, dtype=np.uint8)
    begin, end = _candidates(octets)
    is_whole = end <= len(octets)
    is_good = is_whole.copy()
    is_good[is_whole] = _checksums(octets, begin[is_whole], end[is_whole]) == 0
    taken = _one_after_another(begin, end, np.flatnonzero(is_good))
    start, stop = begin[taken] + _HEAD, end[taken] - _CHECKSUM
    number = octets[start].astype(np.int64) << 4 | octets[start + 1] >> 4
    return Frames(start, stop, number, *_between(octets, begin, end, begin[taken], end[taken]))


def _candidates(octets):
    """Return first byte and end of everything that has a frame's head and a message of at least a number."""
    head = np.flatnonzero((octets[:-2] == _PREAMBLE) & (octets[1:-1] & 0b1111_1100 == 0)) if len(octets) > _HEAD else np.empty(0, dtype=int)
    length = (octets[head + 1].astype(np.int64) << 8) | octets[head + 2]
    long_enough = length >= 2
    return head[long_enough], (head + _HEAD + length + _CHECKSUM)[long_enough]


def _checksums(octets, begin, end):
    """Return the CRC-24Q of each frame, its own checksum included: 0 where it is right."""
    checksum = np.zeros(len(begin), dtype=np.uint32)
    by_length = np.argsort(end - begin)
    for at in range(0, len(begin), _AT_ONCE):
        group = by_length[at : at + _AT_ONCE]
        checksum[group] = _crc24q(_right_aligned(octets, begin[group], end[group]))
    return checksum


def _right_aligned(octets, begin, end):
    """Return the bytes of frames (n, longest), with zeros in front of the shorter ones: they leave the CRC at its start, 0."""
    place = end[:, None] - np.arange((end - begin).max(), 0, -1)
    return np.where(place >= begin[:, None], octets[np.maximum(place, 0)], 0)


def _crc24q(octets):
    """Return the CRC of each row of bytes (n, width), one column after the other."""
    table = _crc_table()
    crc = np.zeros(len(octets), dtype=np.uint32)
    for column in octets.T:
        crc = (crc << 8 & 0xFFFFFF) ^ table[crc >> 16 ^ column]
    return crc


@cache
def _crc_table():
    """Return the CRC-24Q of each byte (256,): eight steps of the division by the polynomial."""
    crc = np.arange(256, dtype=np.uint32) << 16
    for _ in range(8):
        crc = crc << 1 ^ np.where(crc & 0x800000, _POLYNOMIAL, 0).astype(np.uint32)
    return crc


def _one_after_another(begin, end, good):
    """Return those of the good candidates that do not overlap: what looks like a frame inside a frame is its content."""
    taken, free = [], 0
    for k, first, behind in zip(good.tolist(), begin[good].tolist(), end[good].tolist(), strict=True):
        if first >= free:
            taken.append(k)
            free = behind
    return np.array(taken, dtype=np.int64)


def _between(octets, begin, end, first, behind):
    """Return how many damaged frames lie in the gaps between good ones, how many bytes, and whether the log ends within a frame."""
    gap_from, gap_to = np.append(0, behind), np.append(first, len(octets))
    gap = np.searchsorted(gap_from, begin, side="right") - 1
    fits = (begin < gap_to[gap]) & ((begin == gap_from[gap]) | (end == gap_to[gap]))  # else it only looks like a frame
    is_unfinished = fits & (gap == len(gap_from) - 1) & (end > len(octets))
    damaged = int(fits.sum() - is_unfinished.sum())
    return damaged, int((gap_to - gap_from).sum()), bool(is_unfinished.any() or _ends_in_head(octets[gap_from[-1] :]))


def _ends_in_head(rest):
    """Return whether what is left is the first one or two bytes of a frame."""
    return 0 < len(rest) <= 2 and rest[0] == _PREAMBLE
