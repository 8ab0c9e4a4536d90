"""A table on disk as lines of text: unpacked, decoded, and in pieces, so that a million rows need no more memory than their numbers."""

import gzip
import io
import os
import zlib
from contextlib import contextmanager
from itertools import islice
from typing import NamedTuple

PIECE = 1_000_000  # [characters] of one piece: some 10 000 rows, long enough for speed, small beside the numbers of a million
HEAD = 200  # lines looked at to find out what stands where

_GZIP, _ZIP = b"\x1f\x8b", b"PK\x03\x04"
_UTF16 = (b"\xff\xfe", b"\xfe\xff")


class Piece(NamedTuple):
    """Lines that are not blank, each with its number in the file."""

    numbers: list
    texts: list
    is_last: bool


class SeriesError(ValueError):
    """A table that cannot be used: names the file, the line, what was expected and what stands there."""

    def __init__(self, path, problem, line=None):
        super().__init__(f"{path}: {problem}" if line is None else f"{path}, line {line}: {problem}")


def read_pieces(path, progress=None):
    """Yield the lines of a file as Pieces; `progress(done, total)` counts bytes of the file on disk.

    Plain and gzipped files, UTF-8 and UTF-16 with a byte order mark, all line ends. Raises SeriesError where there is no text.
    """
    with _opened(path) as (stream, done):
        total, first, block = os.path.getsize(path), 1, _next_block(stream, path)
        while block:
            following = _next_block(stream, path)
            kept = [(number, text) for number, text in enumerate(block, first) if text.strip()]
            first += len(block)
            if kept:
                numbers, texts = zip(*kept, strict=True)
                yield Piece(list(numbers), [text.rstrip("\n") for text in texts], not following)
            if progress:
                progress(done(), total)
            block = following


def read_head(path):
    """Return the first lines of a file that are not blank, as one Piece; raise SeriesError where there are none."""
    with _opened(path) as (stream, _):
        kept = [(number, text.rstrip("\n")) for number, text in enumerate(_few_lines(stream, path), 1) if text.strip()]
    if not kept:
        raise SeriesError(path, "the file is empty; expected a table of positions")
    return Piece(*map(list, zip(*kept, strict=True)), is_last=False)


@contextmanager
def _opened(path):
    """Give a text stream of the file, and a function that says how many of its bytes are read."""
    if os.path.isdir(path):
        raise SeriesError(path, "this is a folder; name a file in it")
    with open(path, "rb") as raw:
        start = raw.read(4)
        raw.seek(0)
        if start.startswith(_ZIP):
            raise SeriesError(path, "a zip archive or spreadsheet; save the table as CSV and give that")
        plain = gzip.GzipFile(fileobj=raw) if start.startswith(_GZIP) else raw
        encoding = "utf-16" if start.startswith(_UTF16) else "utf-8-sig"
        yield io.TextIOWrapper(plain, encoding=encoding, errors="replace"), raw.tell


def _next_block(stream, path):
    with _damage_said(path):
        return _text_only(stream.readlines(PIECE), path)


def _few_lines(stream, path):
    with _damage_said(path):
        return _text_only(list(islice(stream, HEAD)), path)


@contextmanager
def _damage_said(path):
    try:
        yield
    except (EOFError, zlib.error, gzip.BadGzipFile) as error:
        raise SeriesError(path, f"the compressed data are damaged or cut short ({error}); fetch the file again") from None


def _text_only(lines, path):
    if lines and any("\0" in line for line in lines[:HEAD]):
        raise SeriesError(path, "not a text file; expected a table of positions: CSV, or RTKLIB's .pos")
    return lines
