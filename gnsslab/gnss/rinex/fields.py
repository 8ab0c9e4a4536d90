"""Observation fields: 16 columns each (F14.3, loss-of-lock digit, signal-strength digit), millions at a time.

A field is looked at as two 64-bit words of eight characters, so that one integer operation treats eight characters of
every field in the file at once (the well-known "SWAR" technique). A number in the standard layout becomes an integer
count of thousandths, and that divided by 1000.0 is the float64 nearest to the decimal number, just as float(text) is.
Any other layout is read by float(text) itself.
"""

import re
from typing import NamedTuple

import numpy as np

WIDTH = 16  # columns of a field

_ONES = 0x0101010101010101
_HIGH = 0x80 * _ONES
_LOW7 = 0x7F * _ONES
_BLANKS = 0x20 * _ONES
_ZEROS = 0x30 * _ONES
_MINUS = 0x2D * _ONES
_THREE = 0xFFFFFF  # three characters
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([EeDd][+-]?\d{1,3})?")

# Characters of the first and second word that belong to a field of which only the first 0 to 16 columns exist.
_FIRST = np.array([(1 << 8 * min(room, 8)) - 1 for room in range(17)], dtype=np.uint64)
_SECOND = np.array([(1 << 8 * max(room - 8, 0)) - 1 for room in range(17)], dtype=np.uint64)


class Fields(NamedTuple):
    """What stands in k rows of n fields; `strange` lists those that are no observation at all."""

    value: np.ndarray  # (k, n) float64, NaN where blank
    lli: np.ndarray  # (k, n) uint8
    ssi: np.ndarray  # (k, n) uint8
    strange: np.ndarray  # (j, 2) row and column


def parse_fields(words, room):
    """Return the numbers and flags in fields of 16 characters.

    words (k, n, 2) uint64, the characters, first one in the lowest byte; room (k, n) int, how many of the 16 columns
    the line had (the rest counts as blank).

    >>> text = b"  24767686.37514-123456789.123  "
    >>> fields = parse_fields(np.frombuffer(text, "<u8").reshape(1, 2, 2), np.full((1, 2), 16))
    >>> fields.value.tolist(), fields.lli.tolist(), fields.ssi.tolist()
    ([[24767686.375, -123456789.123]], [[1, 0]], [[4, 0]])
    """
    first, second = _cut_to_room(words, room)
    value, is_standard = _standard_numbers(first, second)
    lli, ssi, has_flags = _flags(second)
    is_blank = (first == _BLANKS) & (second << 16 == _BLANKS << 16 & 0xFFFFFFFFFFFFFFFF)
    value[is_blank] = np.nan
    odd = np.argwhere(~((is_standard | is_blank) & has_flags))
    is_strange = [not _read_odd(value, first, second, at, has_flags) for at in map(tuple, odd)]
    return Fields(value, lli, ssi, odd[is_strange] if len(odd) else odd)


def _cut_to_room(words, room):
    first, second = np.ascontiguousarray(words[..., 0]), np.ascontiguousarray(words[..., 1])
    if room.size and room.min() >= WIDTH:
        return first, second
    kept_first, kept_second = _FIRST[room], _SECOND[room]
    return first & kept_first | _BLANKS & ~kept_first, second & kept_second | _BLANKS & ~kept_second


def _standard_numbers(first, second):
    """Return value (k, n) of numbers laid out as F14.3 and which fields are: blanks, a minus or none, digits, ".ddd"."""
    has_point = second >> 16 & 0xFF == ord(".")
    second = _BLANKS & _THREE | (second & 0xFFFF) << 24 | (second >> 24 & _THREE) << 40  # "   89bcd": point left out
    first, minus_first = _without_minus(first)
    second, minus_second = _without_minus(second)
    gap_first, gap_second = _gap(first), _gap(second)
    minus = minus_first | minus_second
    is_whole = (gap_second == _THREE) | (gap_first == _ONES * 0xFF) & (gap_second <= 0xFFFFFFFFFF)
    is_lead = (minus == 0) | (minus_first == _last(gap_first)) & (gap_second == _THREE) & (minus_second == 0)
    is_lead |= (minus_first == 0) & (minus_second == _last(gap_second))
    good = has_point & is_whole & is_lead & _is_gap_then_digits(first, gap_first) & _is_gap_then_digits(second, gap_second)
    value = (_eight_digits(first) * 100_000 + _eight_digits(second)) / 1000.0
    return np.where(minus != 0, -value, value), good


def _without_minus(word):
    """Return the word with minus signs made blanks, and bit 7 of each character that was one."""
    different = word ^ _MINUS
    mark = ~((different & _LOW7) + _LOW7 | different) & _HIGH
    return word ^ (mark >> 7) * 0x0D, mark  # 0x2D ("-") ^ 0x0D = 0x20 (" ")


def _gap(word):
    """Return 0xFF for each character that lacks bit 4: digits (0x30 to 0x39) have it, a blank (0x20) has not."""
    return (~word >> 4 & _ONES) * 0xFF


def _last(gap):
    """Return bit 7 of the last character of a gap that fills the lowest characters."""
    return gap ^ gap >> 1


def _is_gap_then_digits(word, gap):
    """Tell whether a word is blanks, as `gap` says, and then digits only."""
    digit = (word | 0x10 * _ONES) ^ _ZEROS
    beyond_nine = (digit + 0x76 * _ONES | digit) & _HIGH
    return (gap & gap + 1 == 0) & (word & gap == _BLANKS & gap) & (beyond_nine == 0)


def _eight_digits(word):
    """Return the number that eight characters spell, blanks read as zeros: neighbours are joined three times."""
    digit = (word | 0x10 * _ONES) ^ _ZEROS
    pair = digit * 10 + (digit >> 8) & 0x00FF00FF00FF00FF
    four = pair * 100 + (pair >> 16) & 0x0000FFFF0000FFFF
    return four * 10_000 + (four >> 32) & 0xFFFFFFFF


def _flags(second):
    flags = second.view(np.uint8).reshape(*second.shape, 8)[..., 6:] if second.size else np.zeros((*second.shape, 2), np.uint8)
    is_digit = flags - np.uint8(ord("0")) < 10
    flag = np.where(is_digit, flags & 0x0F, np.uint8(0))
    return flag[..., 0], flag[..., 1], (is_digit | (flags == ord(" "))).all(axis=-1)


def _read_odd(value, first, second, at, has_flags):
    """Read one number that is not laid out as F14.3; False where it is no number or the flags are no digits."""
    text = field_text(first[at], second[at])
    runs_into_flags = text[10] != "." and text[13] != " " and text[14] != " "  # shifted to the right: not to be guessed at
    number = text[:14].strip()
    if runs_into_flags or (number and not _NUMBER.fullmatch(number)) or not has_flags[at]:
        return False
    value[at] = float(number.upper().replace("D", "E")) if number else np.nan
    return True


def field_text(first, second):
    """Return the 16 characters of one field."""
    return np.array([first, second], dtype="<u8").tobytes().decode("latin-1")
