"""Simulated coordinate series: a preset and random numbers in, solutions and the truth out; and the files of them."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.signal import lfilter

from gnsslab.gnss.relative import Status
from gnsslab.gnss.series import Series
from gnsslab.gnss.times import iso_text

SERIES_COLUMNS = "time,east_m,north_m,up_m,sigma_east_m,sigma_north_m,sigma_up_m"
TRUTH_COLUMNS = "time,east_m,north_m,up_m"


@dataclass(frozen=True, eq=False)
class SimulatedSeries:
    """A series over T epochs, and what only a simulation knows."""

    series: Series
    truth_enu: np.ndarray  # (T, 3) [m]
    is_gross: np.ndarray  # (T,) bool, a gross error was added

    def __repr__(self):
        return f"SimulatedSeries: {len(self.truth_enu)} epochs, {int(self.is_gross.sum())} gross errors"


def simulate_series(preset, rng):
    """Simulate a series preset with random numbers from `rng`, a numpy Generator; the same preset and seed give the same series.

    >>> from gnsslab.simulate import find_series_preset
    >>> simulate_series(find_series_preset("b-fixed"), np.random.default_rng(1)).series.enu.shape
    (2256, 3)
    """
    noise, T = preset.noise, preset.epochs
    truth_enu = preset.truth_enu
    e = noise.white * rng.standard_normal((T, 3)) + gauss_markov(T, noise.coloured, noise.coloured_time / preset.interval, rng)
    is_gross = rng.random(T) < noise.gross_share
    e += np.where(is_gross[:, None], noise.gross * rng.standard_normal((T, 3)), 0.0)
    stated = np.hypot(noise.white, noise.coloured) * np.exp(noise.sigma_spread * rng.standard_normal(T))
    sigma = np.tile(stated[:, None], 3)
    series = Series(preset.time, truth_enu + e, sigma, np.full(T, Status.FIXED, dtype=np.int8), np.full(T, np.nan))
    return SimulatedSeries(series, truth_enu, is_gross)


def gauss_markov(T, sigma, correlation_epochs, rng):
    """Return a stationary first-order Gauss-Markov series (T, 3) on three axes: x_k = a x_(k-1) + sigma sqrt(1 - a^2) n_k, a = exp(-1 / tau).

    `correlation_epochs` is tau, in epochs; sigma that of x itself.

    >>> x = gauss_markov(100_000, 2.0, 5.0, np.random.default_rng(1))
    >>> x.std().round(1), (x[1:] * x[:-1]).mean().round(1)  # 4 exp(-1 / 5) = 3.3
    (np.float64(2.0), np.float64(3.3))
    """
    a = np.exp(-1.0 / correlation_epochs)
    n = sigma * rng.standard_normal((T, 3))
    n[1:] *= np.sqrt(1 - a * a)
    return lfilter([1.0], [1.0, -a], n, axis=0)


def write_series(folder, simulated):
    """Write series.csv and truth.csv into a folder, made if need be; return the paths."""
    folder = Path(folder)
    series, paths = simulated.series, (folder / "series.csv", folder / "truth.csv")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        _write_table(paths[0], SERIES_COLUMNS, series.time, np.hstack([series.enu, series.sigma]))
        _write_table(paths[1], TRUTH_COLUMNS, series.time, simulated.truth_enu)
    except OSError as error:
        raise ValueError(f"the series cannot be written to {folder}: {error.strerror or error}; choose a folder that can be written") from None
    return paths


def _write_table(path, header, time, values):
    rows = zip(time, np.round(values, 5) + 0.0, strict=True)  # without negative zeros
    lines = (",".join([iso_text(t), *(f"{x:.5f}" for x in row)]) for t, row in rows)
    path.write_text("\n".join([header, *lines]) + "\n", encoding="ascii")
