"""A coordinate series: where a point was at each epoch, east, north and up of a reference, and how far each epoch may be trusted."""

from dataclasses import dataclass

import numpy as np

from gnsslab.gnss.relative import Status
from gnsslab.gnss.times import iso_text, usual_step


@dataclass(frozen=True, eq=False)
class Series:
    """East, north and up of one point at increasing times; NaN rows and status NONE where there is no solution.

    `time` (T,) datetime64[ns], GPS time, strictly increasing; `enu` (T, 3) [m]; `sigma` (T, 3) [m], NaN where not stated;
    `status` (T,) int8 of Status; `ratio` (T,) second best over best squared norm of the integer search, NaN where not stated.
    A series that contradicts itself raises ValueError.

    >>> day = np.array(["2024-01-01", "2024-01-02"], "M8[ns]")
    >>> Series(day, np.zeros((2, 3)), np.full((2, 3), 0.003), np.full(2, Status.FIXED, np.int8), np.full(2, np.nan))
    Series: 2 epochs from 2024-01-01T00:00:00.000, every 86400 s; 2 fixed, 0 float, 0 without solution
    """

    time: np.ndarray
    enu: np.ndarray
    sigma: np.ndarray
    status: np.ndarray
    ratio: np.ndarray

    def __post_init__(self):
        _refuse_shapes(self)
        _refuse_order(self.time)
        _refuse_contradictions(self)

    def __len__(self):
        return len(self.time)

    def __repr__(self):
        fixed, floats = (int((self.status == status).sum()) for status in (Status.FIXED, Status.FLOAT))
        counts = f"{fixed} fixed, {floats} float, {len(self) - fixed - floats} without solution"
        if not len(self):
            return "Series: no epochs"
        every = f", every {usual_step(self.time):g} s" if len(self) > 1 else ""
        return f"Series: {len(self)} epoch{'s' * (len(self) > 1)} from {iso_text(self.time[0])}{every}; {counts}"

    @property
    def is_solved(self):
        """Return where there is a solution (T,) bool."""
        return self.status > Status.NONE

    def at(self, indices):
        """Return the Series of some of the epochs, given by a slice, increasing indices or a mask (T,) bool."""
        return Series(self.time[indices], self.enu[indices], self.sigma[indices], self.status[indices], self.ratio[indices])


def series_of(relative):
    """Return the Series of a Relative: its baselines, their standard deviations sigma = sqrt(diag Q_enu), status and ratio."""
    sigma = np.sqrt(np.diagonal(relative.Q_enu, axis1=-2, axis2=-1))
    return Series(relative.time, relative.baseline_enu, sigma, relative.status, relative.ratio)


def series_of_numbers(time, enu, sigma=None):
    """Return the Series of positions `enu` (T, 3) [m] at `time` (T,), every row with three numbers FIXED, the others without solution.

    >>> series_of_numbers(np.array(["2024-01-01"], "M8[ns]"), [[0.0, 0.0, np.nan]]).enu
    array([[nan, nan, nan]])
    """
    enu = np.asarray(enu, dtype=float)
    is_solved = np.isfinite(enu).all(axis=-1)
    sigma = np.full(enu.shape, np.nan) if sigma is None else np.asarray(sigma, dtype=float)
    status = np.where(is_solved, Status.FIXED, Status.NONE).astype(np.int8)
    return Series(np.asarray(time, dtype="datetime64[ns]"), np.where(is_solved[..., None], enu, np.nan), sigma, status, np.full(len(enu), np.nan))


def _refuse_shapes(series):
    T = len(series.time)
    asked = {"time": (T,), "enu": (T, 3), "sigma": (T, 3), "status": (T,), "ratio": (T,)}
    for name, shape in asked.items():
        found = np.shape(getattr(series, name))
        if found != shape:
            raise ValueError(f"a series of {T} epochs needs {name} of shape {shape}, not {found}")
    if np.asarray(series.time).dtype != "datetime64[ns]":
        raise ValueError(f"times of a series must be datetime64[ns] in GPS time, not {np.asarray(series.time).dtype}")


def _refuse_order(time):
    if np.isnat(time).any():
        raise ValueError(f"epoch {int(np.isnat(time).argmax())} of the series has no time: leave such rows out")
    late = np.flatnonzero(time[1:] <= time[:-1])
    if len(late):
        earlier, later = time[late[0]], time[late[0] + 1]
        raise ValueError(f"times of a series must increase, but {iso_text(later)} follows {iso_text(earlier)}: sort them, keep one row a time")


def _refuse_contradictions(series):
    if not np.isin(series.status, list(Status)).all():
        raise ValueError("status of a series must be Status.NONE, FLOAT or FIXED at every epoch")
    has_position = np.isfinite(series.enu).all(axis=1)
    wrong = np.flatnonzero(has_position != series.is_solved)
    if len(wrong):
        status = Status(int(series.status[wrong[0]])).name
        raise ValueError(f"epoch {wrong[0]} of the series has status {status} and position {series.enu[wrong[0]]}: NONE and NaN go together")
    if (series.sigma < 0).any() or np.isinf(series.sigma).any():
        raise ValueError("standard deviations of a series must be finite and not negative, or NaN where not stated")
