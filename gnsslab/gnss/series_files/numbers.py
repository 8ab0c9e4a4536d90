"""Columns of text as numbers, fast where all is well, with the line's number where it is not."""

import numpy as np

from gnsslab.gnss.rinex.errors import quoted
from gnsslab.gnss.series_files.lines import SeriesError

MISSING = {"", "nan", "na", "n/a", "null", "none", "-", "--", "*", "nat"}


def numbers(texts, lines, path, name):
    """Return texts (n,) as floats, NaN where a field is empty; raise SeriesError with the line where one is no number.

    >>> numbers(["1.5", "", "NaN"], [1, 2, 3], "a.csv", "east")
    array([1.5, nan, nan])
    """
    try:
        return np.fromiter(map(float, texts), float, len(texts))
    except ValueError:
        return np.array([_number(text, line, path, name) for text, line in zip(texts, lines, strict=True)])


def is_missing(text):
    """Return whether a field says that there is nothing: empty, nan, none, -."""
    return text.strip().lower() in MISSING


def like_number(text):
    """Return whether a field is a number or begins like one, as a date does.

    >>> like_number("-1.5"), like_number("2024-01-01"), like_number("north")
    (True, True, False)
    """
    return text.strip().lstrip("+-.")[:1].isdigit()


def split_rows(piece, separator, width, path):
    """Return lists of fields, one a line; all have at least `width`. A last line of the file that is cut short is left out.

    The second result says how many lines were left out, 0 or 1. Raises SeriesError with the line of a row that is too short.
    """
    rows = [text.split(separator) for text in piece.texts]
    short = [k for k, row in enumerate(rows) if len(row) < width]
    if short == [len(rows) - 1] and piece.is_last and piece.numbers[-1] > 1:
        return rows[:-1], 1
    if short:
        found = quoted(piece.texts[short[0]], 60)
        problem = f"expected {width} fields, as in the rows before, found {len(rows[short[0]])}: {found}"
        raise SeriesError(path, problem, piece.numbers[short[0]])
    return rows, 0


def _number(text, line, path, name):
    if is_missing(text):
        return np.nan
    try:
        return float(text)
    except ValueError:
        raise SeriesError(path, f"expected a number in column {name}, found {quoted(text)}", line) from None
