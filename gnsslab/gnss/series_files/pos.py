"""RTKLIB's solution files (.pos): every time, coordinate and separator format that it writes, with or without its header."""

import re
from typing import NamedTuple

import numpy as np

from gnsslab.gnss.frames import ecef_from_geodetic, enu_rotation
from gnsslab.gnss.relative import Status
from gnsslab.gnss.rinex.errors import quoted
from gnsslab.gnss.series_files.clocks import calendar, to_gps_time, week_and_seconds
from gnsslab.gnss.series_files.gathering import NO_ROWS, Rows, counted, gathered, joined
from gnsslab.gnss.series_files.lines import SeriesError, read_head, read_pieces
from gnsslab.gnss.series_files.numbers import numbers, split_rows

ENDINGS = (".pos", ".llh", ".xyz", ".enu")  # the last three from receivers that run RTKLIB, often without a header
QUALITIES = {1: "fixed", 2: "float", 3: "SBAS", 4: "DGPS", 5: "single", 6: "PPP", 7: "dead reckoning"}
STATUS_OF_QUALITY = np.array([Status.NONE, Status.FIXED, *(Status.FLOAT,) * 6], dtype=np.int8)
SPREADS = 6  # three standard deviations and three signed roots of covariances
FROM_CENTRE = 6.3e6, 1e8  # [m], of an antenna on the Earth or in a low orbit
DECIMALS_OF_DEGREES = 6  # RTKLIB writes 9 of degrees and 4 of metres


class Form(NamedTuple):
    """How one file writes its rows."""

    separator: str | None  # None: blanks or tabs
    has_dates: bool  # else week and time of week
    scale: str  # GPST, UTC or JST
    frame: str  # llh, dms, xyz or enu
    reference_ecef: tuple | None  # (x, y, z) [m] of the base, where the header gives it

    @property
    def time_fields(self):
        """Return how many fields the time takes: a date and its clock are parted by a blank whatever the separator is."""
        return 1 if self.has_dates and self.separator else 2

    @property
    def quality_field(self):
        """Return where the quality stands: after the time and three numbers, seven where degrees have minutes and seconds."""
        return self.time_fields + (7 if self.frame == "dms" else 3)


def is_pos(path, head):
    """Return whether a file is RTKLIB's: by its header of columns, or by its name."""
    return any(_COLUMNS.match(text) for text in head.texts) or str(path).lower().removesuffix(".gz").endswith(ENDINGS)


def read_pos(path, progress=None):
    """Return the Series of an RTKLIB solution and notes. East, north and up are about the reference position of the header.

    Where the header gives none, they are about the median of the fixed positions (of all where none is fixed). Quality 1 is FIXED, 2 FLOAT;
    3 to 7 (SBAS, DGPS, single, PPP, dead reckoning) are FLOAT too, their standard deviations tell them apart. Raises SeriesError.
    """
    form, notes = find_form(path, read_head(path))
    rows, qualities, cut = _all_rows(path, form, progress)
    if not qualities.sum():
        raise SeriesError(path, "a header but no rows; the solution has no epochs")
    rows, said = _about_reference(rows, form)
    series, mended = gathered(rows)
    return series, [*notes, *said, *_quality_words(qualities), *["the last line is cut short: left out"] * cut, *mended]


# header ------------------------------------------------------------------------------------------------------------------------------

_COLUMNS = re.compile(r"%\s+(GPST|UTC|JST)\b.*(latitude|x-ecef|e-baseline)", re.IGNORECASE)
_FRAMES = {"latitude": "llh", "x-ecef": "xyz", "e-baseline": "enu"}


def find_form(path, head):
    """Return the Form of a file and notes on what was guessed; raise SeriesError where it has no rows or is no such file."""
    first = next((text for text in head.texts if not text.startswith("%")), None)
    if first is None:
        raise SeriesError(path, "a header but no rows; the solution has no epochs")
    form = _form_of_row(first, path, head.numbers[head.texts.index(first)])
    header = [text for text in head.texts if text.startswith("%")]
    columns = next((found for text in header if (found := _COLUMNS.match(text))), None)
    if not columns:
        return form, [f"no header: taken as GPS time and {_FRAME_WORDS[form.frame]}"]
    return _form_of_header(form, columns, header), _height_words(header)


_FRAME_WORDS = {
    "llh": "latitude, longitude [deg] and height",
    "dms": "latitude, longitude [deg min sec] and height",
    "xyz": "x, y, z (ECEF)",
    "enu": "east, north, up of the baseline",
}


def _form_of_header(form, columns, header):
    frame = _FRAMES[columns[2].lower()]
    frame = "dms" if frame == "llh" and "'" in columns.string else frame
    form = form._replace(scale=columns[1].upper(), frame=frame)
    return form._replace(reference_ecef=_reference(header, form))


def _form_of_row(text, path, line):
    """Return the Form of a row as far as it shows: the separator, whether it has dates, and the frame by the size of the numbers."""
    others = re.sub(r"[\d\s.+\-/:eE]|nan|inf", "", text)
    form = Form(others[:1] or None, bool(re.match(r"\s*\d{4}/", text)), "GPST", "llh", None)
    fields = [field.strip() for field in text.split(form.separator)][form.time_fields :]
    try:
        place = [float(field) for field in fields[:3]]
    except ValueError:
        place = []
    if len(place) < 3:
        raise SeriesError(path, f"expected a row of RTKLIB's solution, found {quoted(text, 60)}", line)
    return form._replace(frame=_guess_frame(fields, place))


def _guess_frame(fields, place):
    if FROM_CENTRE[0] < np.linalg.norm(place) < FROM_CENTRE[1]:
        return "xyz"
    if all(field.lstrip("+-").isdigit() for field in fields[:2]) and "." in fields[2]:
        return "dms"
    return "llh" if len(fields[0].partition(".")[2]) >= DECIMALS_OF_DEGREES else "enu"


def _reference(header, form):
    """Return the ECEF position of the base that a header states, None where it states none."""
    stated = next((text.partition(":")[2] for text in header if re.match(r"%\s*ref pos\s*:", text)), "")
    try:
        values = np.array([float(part) for part in stated.replace(form.separator or " ", " ").split()])
    except ValueError:
        return None
    if len(values) not in (3, 7):
        return None
    if form.frame == "xyz":
        return tuple(values)
    return tuple(ecef_from_geodetic(_radians(values)))


def _height_words(header):
    if any("/geodetic" in text for text in header):
        return ["heights are above the geoid, the reference is not: up is off by the height of the geoid, the same at every epoch"]
    return []


# rows --------------------------------------------------------------------------------------------------------------------------------


def _all_rows(path, form, progress):
    """Return the Rows of the whole file as `_rows_of` does, how many have each quality, and how many lines were cut short, 0 or 1."""
    pieces, qualities, cut = [NO_ROWS], np.zeros(len(STATUS_OF_QUALITY), int), 0
    for piece in read_pieces(path, progress):
        rows, quality, is_cut = _rows_of(_data_lines(piece, form, path), form, path)
        pieces.append(rows)
        qualities += np.bincount(quality, minlength=len(qualities))
        cut += is_cut
    return joined(pieces), qualities, cut


def _data_lines(piece, form, path):
    """Return the Piece without its header; raise SeriesError where a header further down changes the format or the reference."""
    if not any(text.startswith("%") for text in piece.texts):
        return piece
    kept = [k for k, text in enumerate(piece.texts) if not text.startswith("%")]
    for k in set(range(len(piece.texts))) - set(kept):
        _refuse_change(piece.texts[k], form, path, piece.numbers[k])
    return piece._replace(numbers=[piece.numbers[k] for k in kept], texts=[piece.texts[k] for k in kept])


def _refuse_change(text, form, path, line):
    columns = _COLUMNS.match(text)
    if columns and _form_of_header(form, columns, [])._replace(reference_ecef=form.reference_ecef) != form:
        raise SeriesError(path, "a second header with another format; give the solutions one by one", line)
    stated = _reference([text], form)
    if stated is not None and stated != form.reference_ecef:
        raise SeriesError(path, "a second header with another reference position; give the solutions one by one", line)


def _rows_of(piece, form, path):
    """Return the Rows of a piece with ECEF positions in place of east, north, up (but in frame enu), the quality (N,), and lines cut off."""
    rows, cut = split_rows(piece, form.separator, form.quality_field + 1, path)
    if not rows:
        return NO_ROWS, np.zeros(0, int), cut
    lines, columns = piece.numbers[: len(rows)], list(zip(*rows, strict=False))  # as many columns as the shortest row has
    read_time = calendar if form.has_dates else week_and_seconds
    time = to_gps_time(read_time(columns[: form.time_fields], lines, path), form.scale)
    values = [numbers(column, lines, path, form.time_fields + k + 1) for k, column in enumerate(columns[form.time_fields :][: _wanted(form)])]
    place, quality, rest = _parts(values, form)
    position = place if form.frame in ("xyz", "enu") else ecef_from_geodetic(_radians(place))
    _refuse_quality(quality, columns[form.quality_field], lines, path)
    sigma = _sigma(rest, position, form)
    return Rows(time, position, sigma, STATUS_OF_QUALITY[quality], _ratio(rest, len(rows))), quality, cut


def _wanted(form):
    return form.quality_field - form.time_fields + 2 + SPREADS + 2


def _parts(values, form):
    """Return the position's numbers (N, 3 or 7), the quality (N,) int, and the columns after the number of satellites."""
    places = form.quality_field - form.time_fields
    quality = np.where(np.isfinite(values[places]), values[places], -1.0).astype(int)
    return np.stack(values[:places], axis=-1), quality, values[places + 2 :]


def _radians(geodetic):
    """Return latitude, longitude [rad] and height [m] (..., 3) of degrees (..., 3), or of degrees, minutes, seconds twice (..., 7)."""
    geodetic = np.asarray(geodetic, dtype=float)
    if geodetic.shape[-1] == 3:
        return np.concatenate([np.radians(geodetic[..., :2]), geodetic[..., 2:]], axis=-1)
    degrees, minutes, seconds = geodetic[..., 0:6:3], geodetic[..., 1:6:3], geodetic[..., 2:6:3]
    size = np.abs(degrees) + minutes / 60 + seconds / 3600
    return np.concatenate([np.radians(np.copysign(size, degrees)), geodetic[..., 6:]], axis=-1)  # -0 degrees are south or west too


def _refuse_quality(quality, texts, lines, path):
    wrong = np.flatnonzero((quality < 0) | (quality >= len(STATUS_OF_QUALITY)))
    if len(wrong):
        raise SeriesError(path, f"expected a quality Q from 0 to 7, found {quoted(texts[wrong[0]].strip())}", lines[wrong[0]])


def _sigma(rest, position, form):
    """Return standard deviations (N, 3) east, north, up: reordered, or rotated with the cross terms from x, y, z."""
    if len(rest) < SPREADS:
        return np.full(position.shape, np.nan)
    first, second, up = rest[:3]
    if form.frame == "enu":
        return np.stack([first, second, up], axis=-1)
    if form.frame != "xyz":
        return np.stack([second, first, up], axis=-1)
    return rotated_sigma(np.stack(rest[:SPREADS], axis=-1), enu_rotation(position))


def rotated_sigma(spread, R_ne):
    """Return sqrt(diag(R_ne Q R_ne')) (N, 3) of RTKLIB's sdx, sdy, sdz, sdxy, sdyz, sdzx (N, 6); 0 where Q gives no root.

    The last three are signed roots of covariances. RTKLIB writes 0 for a standard deviation whose square it found negative: then 0 too.

    >>> rotated_sigma(np.array([[0.01, 0.02, 0.03, 0.0, 0.0, 0.0]]), np.eye(3)[None]).round(4).tolist()
    [[0.01, 0.02, 0.03]]
    """
    xx, yy, zz, xy, yz, zx = np.moveaxis(np.sign(spread) * spread**2, -1, 0)
    Q = np.stack([np.stack([xx, xy, zx], -1), np.stack([xy, yy, yz], -1), np.stack([zx, yz, zz], -1)], -2)
    squares = np.einsum("tij,tjk,tik->ti", R_ne, Q, R_ne)
    is_lawful = (squares > 0) & (spread[:, :3] > 0).all(axis=-1, keepdims=True)
    return np.sqrt(np.where(is_lawful, squares, 0.0))


def _ratio(rest, N):
    """Return the ratio (N,); RTKLIB writes 0 where no integers were searched."""
    if len(rest) < SPREADS + 2:
        return np.full(N, np.nan)
    return np.where(rest[SPREADS + 1] > 0, rest[SPREADS + 1], np.nan)


# reference ---------------------------------------------------------------------------------------------------------------------------


def _about_reference(rows, form):
    """Return the Rows with east, north, up about the reference, and a note that says which that is."""
    if form.frame == "enu":
        return rows, ["east, north, up from the base, as the file gives them"]
    reference, words = np.array(form.reference_ecef), "the reference position of the header"
    if form.reference_ecef is None:
        reference, words = _median_position(rows)
    enu = (rows.enu - reference) @ enu_rotation(reference).T
    return rows._replace(enu=enu), ["east, north, up about {}: {:.4f}, {:.4f}, {:.4f} m (ECEF)".format(words, *reference)]


def _median_position(rows):
    solved = (rows.status > Status.NONE) & np.isfinite(rows.enu).all(axis=1)
    fixed = rows.status == Status.FIXED
    chosen, words = (solved & fixed, "fixed positions") if (solved & fixed).any() else (solved, "positions")
    if not chosen.any():
        return np.zeros(3), "the Earth's centre, as no row has a position"
    return np.median(rows.enu[chosen], axis=0), f"the median of all {words}"


def _quality_words(qualities):
    others = [f"{counted(int(n), 'epoch')} {QUALITIES[q]}" for q, n in enumerate(qualities) if q > 2 and n]
    return [f"quality other than fixed and float taken as float: {', '.join(others)}"] if others else []
