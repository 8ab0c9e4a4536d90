"""Presets of coordinate series: where an antenna truly was, and the noise of its solutions. How to filter them is not said here."""

from dataclasses import dataclass, replace

import numpy as np


@dataclass(frozen=True)
class Shift:
    """The ground goes by `enu` [m], evenly from epoch `first` to epoch `last`: a step where these are one epoch, else a slide."""

    first: int
    last: int
    enu: tuple[float, float, float]

    def done(self, epochs):
        """Return the share of it done (T,) at epochs 0 to T - 1.

        >>> Shift(1, 2, (0.0, -0.03, 0.0)).done(4).tolist(), Shift(2, 2, (0.0, -0.03, 0.0)).done(4).tolist()
        ([0.0, 0.5, 1.0, 1.0], [0.0, 0.0, 1.0, 1.0])
        """
        return np.clip((np.arange(epochs) - self.first + 1) / (self.last - self.first + 1), 0.0, 1.0)


@dataclass(frozen=True)
class SeriesNoise:
    """Errors of each axis, in metres: white ones, a first-order Gauss-Markov series, and gross errors of all axes at some epochs.

    The sigma that a solution states varies from epoch to epoch by the factor exp(sigma_spread n), n standard normal, and knows nothing
    of gross errors.
    """

    white: float
    coloured: float
    coloured_time: float  # [s]
    gross_share: float  # of the epochs
    gross: float
    sigma_spread: float = 0.15

    def __post_init__(self):
        for name in ("white", "coloured", "gross", "sigma_spread"):
            if not (np.isfinite(getattr(self, name)) and getattr(self, name) >= 0):
                raise ValueError(f"noise {name!r} is a standard deviation, zero or above; it is {getattr(self, name)}")
        if not (np.isfinite(self.coloured_time) and self.coloured_time > 0):
            raise ValueError(f"noise 'coloured_time' is a time above zero [s]; it is {self.coloured_time}")
        if not 0 <= self.gross_share < 1:
            raise ValueError(f"noise 'gross_share' is a share of the epochs, from 0 to below 1; it is {self.gross_share}")


@dataclass(frozen=True)
class SeriesPreset:
    """A series of solutions of one baseline. Change one with `dataclasses.replace`."""

    name: str
    title: str
    sentence: str  # what to look at
    start: str  # GPS time, "2021-07-06T21:00:00"
    interval: float  # [s]
    epochs: int
    baseline_enu: tuple[float, float, float]  # [m] before anything moves
    noise: SeriesNoise
    shifts: tuple[Shift, ...] = ()

    def __post_init__(self):
        if self.interval <= 0 or self.epochs < 1:
            raise ValueError(f"preset {self.name!r}: expected an interval above zero and an epoch or more, not {self.interval} s and {self.epochs}")
        for shift in self.shifts:
            if not 0 <= shift.first <= shift.last < self.epochs:
                raise ValueError(f"preset {self.name!r}: a shift from {shift.first} to {shift.last} is not within epochs 0 to {self.epochs - 1}")

    @property
    def time(self):
        """GPS times (T,), datetime64[ns]."""
        nanoseconds = np.round(np.arange(self.epochs) * self.interval * 1e9).astype("timedelta64[ns]")
        return np.datetime64(self.start, "ns") + nanoseconds

    @property
    def truth_enu(self):
        """Where the antenna truly is (T, 3) [m]."""
        moved = sum((np.outer(shift.done(self.epochs), shift.enu) for shift in self.shifts), np.zeros((self.epochs, 3)))
        return moved + self.baseline_enu


def find_series_preset(name):
    """Return the preset of that name.

    >>> find_series_preset("b-step").epochs
    63857
    """
    if name not in SERIES_PRESETS:
        raise ValueError(f"there is no series preset {name!r}; the presets are {', '.join(SERIES_PRESETS)}")
    return SERIES_PRESETS[name]


def with_shifts(preset, *shifts):
    """Return the preset with these shifts in place of its own.

    >>> with_shifts(find_series_preset("b-fixed"), Shift(1000, 1000, (0.1, 0.0, 0.0))).truth_enu[[999, 1000], 0].round(3).tolist()
    [0.95, 1.05]
    """
    return replace(preset, shifts=shifts)


# Paper B gives epochs, interval, length of the baseline and the step. The noise is the papers' calibration: with it, seven
# methods leave the scatter that the paper's tables 1 to 3 print. Its date is local time; here it counts as GPS time.
_DIRECTION = np.array((0.95, -0.60, 0.42)) / np.linalg.norm((0.95, -0.60, 0.42))

_ALL = (
    SeriesPreset(
        "b-fixed",
        "Paper B: a fixed baseline beside a high building",
        "Nothing moves for nine hours; reflections make centimetres that last for minutes, and a few solutions are far off.",
        start="2021-07-06T21:00:00",
        interval=15.0,
        epochs=2256,
        baseline_enu=tuple(1.2 * _DIRECTION),
        noise=SeriesNoise(white=0.0112, coloured=0.0188, coloured_time=112.5, gross_share=0.0032, gross=0.13),
    ),
    SeriesPreset(
        "b-step",
        "Paper B: a platform moves 3.6 cm",
        "18 hours, one solution a second; at epoch 30 350 the antenna is moved 2 cm west and 3 cm south. When do you know?",
        start="2021-05-28T02:00:00",
        interval=1.0,
        epochs=63_857,
        baseline_enu=(-1.2 * 2 / 13**0.5, -1.2 * 3 / 13**0.5, 0.0),  # pointing where the step goes: only so does the length tell all of it
        noise=SeriesNoise(white=0.0198, coloured=0.0104, coloured_time=110.0, gross_share=0.002, gross=0.13),
        shifts=(Shift(30_350, 30_350, (-0.02, -0.03, 0.0)),),
    ),
)
SERIES_PRESETS = {preset.name: preset for preset in _ALL}
