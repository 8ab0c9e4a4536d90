"""Coordinate series from files: tables of `gnsslab rtk`, `heading` and `monitor`, RTKLIB's .pos, and plain tables of time, east, north, up."""

from gnsslab.gnss.series_files.lines import SeriesError, read_head
from gnsslab.gnss.series_files.plain import read_plain
from gnsslab.gnss.series_files.pos import is_pos, read_pos


def read_series(path, *, columns=None, unit=None, progress=None):
    """Return the Series that a file holds, and notes: a tuple of sentences that account for every row and every guess.

    Told apart by what stands in the file: RTKLIB's solution format (`read_pos`), else a table (`read_plain`, which says what `columns` and
    `unit` do). Plain or gzipped. `progress(done, total)` counts bytes. Raises OSError, or ValueError with the line's number.
    """
    head = read_head(path)
    if head.texts[0].startswith("$G"):
        raise SeriesError(path, "NMEA sentences; expected a table of positions, or RTKLIB's own format (out-solformat llh, xyz or enu)")
    if not is_pos(path, head):
        series, notes = read_plain(path, columns, unit, progress)
    elif columns or unit:
        raise SeriesError(path, "RTKLIB's format states its own columns and units: leave --columns and --unit out")
    else:
        series, notes = read_pos(path, progress)
    return series, tuple(notes)


__all__ = ["SeriesError", "read_series"]
