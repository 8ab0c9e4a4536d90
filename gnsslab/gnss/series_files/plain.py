"""Plain tables of time, east, north, up, also our own: columns found by their names, or named by the caller, or by their place."""

import re
from statistics import mode
from typing import NamedTuple

import numpy as np

from gnsslab.gnss.relative import Status
from gnsslab.gnss.rinex.errors import quoted
from gnsslab.gnss.series_files.clocks import CLOCKS, guess_clock, to_gps_time
from gnsslab.gnss.series_files.gathering import NO_ROWS, NOT_STATED, Rows, gathered, joined
from gnsslab.gnss.series_files.lines import Piece, SeriesError, read_head, read_pieces
from gnsslab.gnss.series_files.names import AXES, SIGMAS, UNITS, meaning
from gnsslab.gnss.series_files.numbers import is_missing, like_number, numbers, split_rows

COMMENTS = ("#", "%")
SEPARATORS = ";\t|,"
STATUS_WORDS = {"fixed": Status.FIXED, "fix": Status.FIXED, "float": Status.FLOAT, "none": Status.NONE, "": NOT_STATED}
QUALITY_WORDS = {"0": Status.NONE, "1": Status.FIXED} | dict.fromkeys("234567", Status.FLOAT)  # RTKLIB's numbers
HEADERLESS = {4: ("time", *AXES), 7: ("time", *AXES, *SIGMAS)}  # number of columns: what they are taken for
WAYS_TO_NAME = "name the columns in their order, as in --columns time,north,east,up"


class Table(NamedTuple):
    """How one file writes its rows, and where in a row each quantity stands."""

    separator: str | None  # None: blanks
    has_decimal_comma: bool
    joins_date: bool  # a date and its clock, parted by a blank, are one column
    header_line: int  # rows begin below; 0 without a header
    width: int  # fields in a row
    column: dict  # quantity: index
    factor: dict  # quantity: metres in its unit
    clock: str  # of CLOCKS
    clock_columns: tuple  # quantities that make the time
    scale: str  # GPST or UTC


def read_plain(path, columns=None, unit=None, progress=None):
    """Return the Series of a plain table, and notes: which time, unit and columns were taken, and what became of odd rows.

    `columns` "time,north,east,up" names the first columns in their order ("-" for one to skip), whatever the header says; `unit`
    (m, cm, mm) holds for columns whose name states none. A row without status is FIXED. Raises SeriesError with the line's number.
    """
    table, notes = find_table(path, read_head(path), columns, unit)
    rows, cut = _all_rows(path, table, progress)
    if not len(rows.time):
        raise SeriesError(path, "a header but no rows; expected one row an epoch")
    series, mended = gathered(rows)
    return series, [*notes, *["the last line is cut short: left out"] * cut, *mended]


# what stands where -------------------------------------------------------------------------------------------------------------------


def find_table(path, head, columns=None, unit=None):
    """Return the Table of a file by its first lines, and notes; raise SeriesError where no time, east, north and up are found."""
    separator = _separator(head.texts[-1])
    is_data = [_is_data(text, separator) for text in head.texts]
    first = is_data.index(True) if True in is_data else len(head.texts)
    if first == len(head.texts):
        raise SeriesError(path, _no_rows(head.texts[-1], separator))
    row, header = _fields(head.texts[first], separator), _header(head.texts[first - 1], separator) if first else []
    joins_date = separator is None and bool(re.match(r"\d{1,2}:\d\d", row[1] if len(row) > 1 else "")) and not _has_date_column(header, columns)
    width = len(header) or _usual_width([text for text, data in zip(head.texts, is_data, strict=True) if data], separator) - joins_date
    names = _names(path, head.numbers[first], columns, header, width)
    column, units = _quantities(path, head.numbers[max(first - 1, 0)], names)
    table = Table(
        separator,
        separator != "," and any(re.search(r"\d,\d", text) for text in head.texts[first:]),
        joins_date,
        head.numbers[first] - 1,
        width,
        column,
        _factors(path, column, units, unit),
        "",
        (),
        "GPST",
    )
    table = _with_clock(path, head.numbers[first], table, _joined_date(row) if joins_date else row)
    return table, _words(table, names, columns or header, unit)


def _no_rows(text, separator):
    if len(_header(text, separator)) > len(AXES):
        return "a header but no rows; expected one row an epoch"
    return f"expected rows of time, east, north, up, found {quoted(text)}"


def _separator(text):
    return next((mark for mark in SEPARATORS if mark in text), None)


def _fields(text, separator):
    fields = [field.strip().strip('"').strip() for field in text.split(separator)]
    return fields[:-1] if len(fields) > 1 and not fields[-1] and separator else fields


def _is_data(text, separator):
    """Return whether a line holds values: at least half of its fields are numbers, dates or empty, and two at least are not empty."""
    if text.startswith(COMMENTS):
        return False
    fields = _fields(text, separator)
    given = [field for field in fields if not is_missing(field)]
    like = sum(map(like_number, given))
    return like > 0 and 2 * (len(fields) - len(given) + like) >= len(fields) and len(fields) > 1


def _header(text, separator):
    """Return the names in the line above the first row; none where it is a comment that names no columns."""
    names = _fields(text.lstrip("#% "), separator)
    return names if not text.startswith(COMMENTS) or sum(meaning(name) is not None for name in names) > 1 else []


def _has_date_column(header, columns):
    named = [meaning(name) for name in (columns.split(",") if columns else header)]
    return any(found and found.quantity == "date" for found in named)


def _usual_width(rows, separator):
    """Return how many fields most rows have; a separator that ends a row parts nothing."""
    return mode(len(_fields(text, separator)) for text in rows)


def _names(path, line, columns, header, width):
    """Return the names of a row's columns: as given, of the header, or by their number."""
    if columns:
        names = [name.strip() for name in columns.split(",")]
        if len(names) > width:
            raise SeriesError(path, f"{len(names)} columns are named, but a row has {width} fields", line)
        return names
    if header:
        return header
    if width not in HEADERLESS:
        raise SeriesError(path, f"no header, and {width} columns are not time, east, north, up and perhaps three sigmas: {WAYS_TO_NAME}", line)
    return list(HEADERLESS[width])


def _quantities(path, line, names):
    """Return where each quantity stands, and the unit that its name states; raise SeriesError where one is missing or there twice."""
    column, units = {}, {}
    for k, name in enumerate(names):
        found = meaning(name)
        if not found:
            continue
        if found.quantity in column:
            raise SeriesError(path, f"columns {names[column[found.quantity]]} and {name} both look like {found.quantity}: {WAYS_TO_NAME}", line)
        column[found.quantity], units[found.quantity] = k, found.unit
    for prefix in ("", "sigma_"):
        if prefix + "up" not in column and prefix + "height" in column:
            column[prefix + "up"], units[prefix + "up"] = column[prefix + "height"], units[prefix + "height"]
    missing = [axis for axis in AXES if axis not in column]
    if missing:
        raise SeriesError(path, f"no column for {', '.join(missing)} among {quoted(', '.join(names), 80)}: {WAYS_TO_NAME}", line)
    if _is_of_monitor(names):
        column = {quantity: k for quantity, k in column.items() if quantity not in SIGMAS}
    return column, units


def _is_of_monitor(names):
    """Return whether a table is one of `gnsslab monitor`: its sigmas are of the filtered positions, not of those read here."""
    return "east_filtered_m" in names


def _factors(path, column, units, unit):
    """Return how many metres each quantity's unit has: by its name, else as given, else that of its axis, else metres."""
    if unit is not None and unit not in UNITS:
        raise ValueError(f"unit {unit!r}: expected m, cm or mm")
    stated = [quantity for quantity in AXES if units[quantity]]
    if unit and any(units[quantity] != unit for quantity in stated):
        raise SeriesError(path, f"column {stated[0]} is in {units[stated[0]]} by its name, not in {unit}: leave --unit out, or name the columns")
    own = {quantity: units[quantity] or unit or "m" for quantity in AXES}
    spread = {sigma: units[sigma] or own[axis] for sigma, axis in zip(SIGMAS, AXES, strict=True) if sigma in column}
    return {quantity: UNITS[name] for quantity, name in (own | spread).items()}


_PAIRS = ((("week", "tow"), "week_tow"), (("date", "clock"), "calendar"), (("date", "time"), "calendar"))
_SINGLE = ("time", "time_utc", "date", "mjd", "decimal_year", "unix", "seconds")


def _with_clock(path, line, table, row):
    """Return the Table with the columns that make the time and how they are read."""
    for pair, clock in _PAIRS:
        if all(quantity in table.column for quantity in pair) and (clock != "calendar" or guess_clock(row[table.column["date"]]) == "calendar"):
            return table._replace(clock=clock, clock_columns=pair)
    quantity = next((quantity for quantity in _SINGLE if quantity in table.column), None)
    if quantity is None:
        raise SeriesError(path, f"no column for the time: {WAYS_TO_NAME}", line)
    text = row[table.column[quantity]].replace(",", ".")
    clock = quantity if quantity in CLOCKS else guess_clock(text)
    if clock is None:
        raise SeriesError(path, f"expected a time like 2024-06-24T08:20:00, found {quoted(text)}", line)
    return table._replace(clock=clock, clock_columns=(quantity,), scale="UTC" if quantity == "time_utc" else "GPST")


def _words(table, names, is_named, unit):
    """Return notes on what was taken for what."""
    notes = [] if is_named else [f"no header: columns taken as {', '.join(names)}"]
    if table.clock != "calendar":
        notes.append(f"times taken as {CLOCKS[table.clock][1]}")
    if not unit and not any(re.search(r"(?i)(?<![a-z])(m|cm|mm|met[a-z]*)(?![a-z])", names[table.column[axis]]) for axis in AXES):
        notes.append("no unit stated: east, north and up taken in metres (--unit mm for millimetres)")
    if table.has_decimal_comma:
        notes.append("numbers taken with a decimal comma")
    if _is_of_monitor(names):
        notes.append("a table of gnsslab monitor: its unfiltered positions are taken")
    return notes


# rows --------------------------------------------------------------------------------------------------------------------------------


def _all_rows(path, table, progress):
    """Return the Rows of the whole file, and how many lines were cut short, 0 or 1."""
    pieces, cut = [NO_ROWS], 0
    for piece in read_pieces(path, progress):
        rows, is_cut = _rows_of(_data_lines(piece, table), table, path)
        pieces.append(rows)
        cut += is_cut
    return joined(pieces), cut


def _data_lines(piece, table):
    """Return the Piece without header and comments, commas as points where the table has decimal commas."""
    texts, lines = piece.texts, piece.numbers
    if lines[0] <= table.header_line or any(text.startswith(COMMENTS) for text in texts):
        kept = [k for k, text in enumerate(texts) if lines[k] > table.header_line and not text.startswith(COMMENTS)]
        texts, lines = [texts[k] for k in kept], [lines[k] for k in kept]
    if table.has_decimal_comma:
        texts = [text.replace(",", ".") for text in texts]
    return Piece(lines, [text.replace('"', "") for text in texts], piece.is_last)


def _rows_of(piece, table, path):
    """Return the Rows of a piece, and how many lines were cut short, 0 or 1."""
    rows, cut = split_rows(piece, table.separator, table.width + table.joins_date, path)
    if not rows:
        return NO_ROWS, cut
    _refuse_wider(rows, table, path, piece.numbers)
    rows = [_joined_date(row) for row in rows] if table.joins_date else rows
    lines, columns = piece.numbers[: len(rows)], list(zip(*rows, strict=False))
    read_time = CLOCKS[table.clock][0]
    time = to_gps_time(read_time([columns[table.column[quantity]] for quantity in table.clock_columns], lines, path), table.scale)

    def lengths(quantities):
        return np.stack([_scaled(columns, quantity, table, lines, path) for quantity in quantities], axis=-1)

    ratio = numbers(columns[table.column["ratio"]], lines, path, "ratio") if "ratio" in table.column else np.full(len(rows), np.nan)
    return Rows(time, lengths(AXES), lengths(SIGMAS), _status(columns, table, lines, path), ratio), cut


def _joined_date(row):
    return [f"{row[0]} {row[1]}", *row[2:]]


def _refuse_wider(rows, table, path, lines):
    """A row with more fields than the others is not read by guess: a decimal comma may have cut a number in two."""
    width = table.width + table.joins_date
    for k, row in enumerate(rows):
        if len(row) > width and any(field.strip() for field in row[width:]):
            raise SeriesError(path, f"expected {width} fields, as in the rows before, found {len(row)}", lines[k])


def _scaled(columns, quantity, table, lines, path):
    if quantity not in table.column:
        return np.full(len(lines), np.nan)
    return numbers(columns[table.column[quantity]], lines, path, quantity) * table.factor[quantity]


def _status(columns, table, lines, path):
    if "status" not in table.column:
        return np.full(len(lines), NOT_STATED, dtype=np.int8)
    known = STATUS_WORDS | QUALITY_WORDS
    texts = [text.strip().lower().removesuffix(".0") for text in columns[table.column["status"]]]
    for text, line in zip(texts, lines, strict=True):
        if text not in known:
            raise SeriesError(path, f"expected status fixed, float or none, or a quality from 0 to 7, found {quoted(text)}", line)
    return np.array([known[text] for text in texts], dtype=np.int8)
