"""M-estimation of a level, or of a level and a trend, from one series with outliers: least squares with equivalent weights, iterated.

Each fit starts from medians, which half (a level) or a quarter (a trend) of wild values cannot carry away; the scale is that of
the residuals there, and stays. So weights that fall to 0, with which a fit may have several solutions, find the one near the start.
"""

from dataclasses import dataclass

import numpy as np

from gnsslab.core.denoise import MAD_OF_NORMAL

MOST_ITERATIONS = 200
CONVERGED = 1e-9  # of the scale, a step that no one sees
ROUNDING = 1e-12  # of the values: four digits above that of float64
STEP = 0.05  # of v, over which the slope of v eta(v) is taken: less than any threshold, wide enough to average a jump


@dataclass(frozen=True, eq=False)
class RobustLevel:
    """A level with outliers held down."""

    level: float  # [unit of y]
    sigma: float  # of one value, MAD / 0.6745 about the median
    sigma_level: float  # standard error, for errors independent of each other
    weight: np.ndarray  # (T,) eta in [0, 1]; 0 where y is NaN

    def __repr__(self):
        return f"RobustLevel: {self.level:.6g} +- {self.sigma_level:.2g}, sigma of one value {self.sigma:.2g}, {_counted(self.weight)}"


@dataclass(frozen=True, eq=False)
class RobustTrend:
    """A straight line, level + rate (t - t_mean), with outliers held down."""

    level: float  # [unit of y] at t_mean
    rate: float  # [unit of y per unit of t]
    t_mean: float  # mean time of the values
    sigma: float  # of one value, MAD / 0.6745 about the first line
    sigma_level: float  # standard error, for errors independent of each other
    sigma_rate: float
    weight: np.ndarray  # (T,) eta in [0, 1]; 0 where y or t is NaN

    def at(self, t):
        """Return the line at times t."""
        return self.level + self.rate * (np.asarray(t) - self.t_mean)

    def __repr__(self):
        return f"RobustTrend: {self.rate:.6g} +- {self.sigma_rate:.2g} per unit of time, sigma of one value {self.sigma:.2g}, {_counted(self.weight)}"


def robust_level(y, weight):
    """Return the `RobustLevel` of y (T,): the x with sum eta(v) v = 0, v = (y - x) / sigma, next to the median.

    `weight` gives eta in [0, 1] of an array of v, such as `gnsslab.core.robust.huber(1.345)`. NaN are left out. The standard error is
    sigma sqrt(sum psi^2 / (n - 1)) / (mean of psi' sqrt(n)), psi = eta v; NaN where psi falls more than it rises.
    Raises ValueError for fewer than two values. Source: Huber (1964), Annals of Mathematical Statistics 35:73-101.

    >>> from gnsslab.core.robust import tukey
    >>> fit = robust_level([1.0, 2.0, 3.0, 4.0, 1000.0], tukey(4.685))
    >>> round(fit.level, 2), float(fit.weight[-1])
    (2.5, 0.0)
    """
    y = _series(y)
    present = np.isfinite(y)
    y_p = y[present]
    if len(y_p) < 2:
        raise ValueError(f"a level with its sigma needs at least two values, there are {len(y_p)}")
    x, sigma, eta, Q = _m_estimate(np.ones((len(y_p), 1)), y_p, np.array([np.median(y_p)]), weight)
    return RobustLevel(float(x[0]), sigma, float(np.sqrt(Q[0, 0])), _spread_out(eta, present))


def robust_trend(t, y, weight):
    """Return the `RobustTrend` of y (T,) at times t (T,), in any order and at any steps; see `robust_level`.

    The first line is that of Theil's incomplete method: the median slope of pairs half the series apart in order of time.
    Raises ValueError for fewer than three values or equal times. Source: Theil (1950), Proc. Kon. Ned. Akad. Wetensch. A53:386-392.

    >>> from gnsslab.core.robust import huber
    >>> fit = robust_trend([0.0, 1.0, 2.0, 4.0, 7.0, 8.0], [1.0, 3.0, 5.0, 900.0, 15.0, 17.0], huber(1.345))
    >>> round(fit.rate, 9), fit.weight.round(3).tolist()
    (2.0, [1.0, 1.0, 1.0, 0.0, 1.0, 1.0])
    """
    t, y = _series(t), _series(y)
    if len(t) != len(y):
        raise ValueError(f"a trend needs a time for each value: there are {len(t)} times and {len(y)} values")
    present = np.isfinite(y) & np.isfinite(t)
    t_p, y_p = t[present], y[present]
    if len(y_p) < 3 or np.ptp(t_p) == 0:
        raise ValueError(f"a trend with its sigma needs at least three values, not all at one time; there are {len(y_p)}")
    t_mean, unit = np.mean(t_p), np.std(t_p)  # in this unit both columns are of one size
    A = np.column_stack([np.ones(len(t_p)), (t_p - t_mean) / unit])
    x, sigma, eta, Q = _m_estimate(A, y_p, _theil_line(A[:, 1], y_p), weight)
    level, rate, sigma_level, sigma_rate = np.concatenate([x, np.sqrt(np.diag(Q))]) / [1.0, unit, 1.0, unit]
    return RobustTrend(*map(float, (level, rate, t_mean, sigma, sigma_level, sigma_rate)), _spread_out(eta, present))


def _series(y):
    y = np.asarray(y, dtype=np.float64)
    if y.ndim != 1:
        raise ValueError(f"this fits one series at a time, an array (T,); got shape {y.shape}: for an axis write z[:, 0]")
    return y


def _theil_line(t, y):
    """Return level at t = 0 and rate: the median slope of pairs half a series apart, and the median of what is left."""
    order, half = np.argsort(t, kind="stable"), len(t) // 2
    dt, dy = t[order][half:] - t[order][:-half], y[order][half:] - y[order][:-half]
    rate = np.median(dy[dt > 0] / dt[dt > 0])
    return np.array([np.median(y - rate * t), rate])


def _m_estimate(A, y, x, weight):
    """Return the solution x of A'(eta(v) v) = 0 next to the x given, the sigma that v is counted in, eta and the covariance of x."""
    sigma = float(np.median(np.abs(_residual(A, y, x)))) / MAD_OF_NORMAL
    for _ in range(MOST_ITERATIONS):
        before, x = x, _weighted_solution(A, y, np.asarray(weight(_standardised(_residual(A, y, x), sigma))))
        if (np.abs(A[[0, -1]] @ (x - before)) <= CONVERGED * sigma).all():
            break
    v = _standardised(_residual(A, y, x), sigma)
    return x, sigma, np.asarray(weight(v)), _covariance(A, v, weight, sigma)


def _residual(A, y, x):
    """Return y - A x, with 0 for what is only rounding."""
    residual = y - A @ x
    return np.where(np.abs(residual) <= ROUNDING * np.median(np.abs(y)), 0.0, residual)


def _standardised(residual, sigma):
    """Return residual / sigma; where sigma is 0, over half of the residuals being 0, the others are infinite."""
    if sigma > 0:
        return residual / sigma
    return np.where(residual == 0, 0.0, np.copysign(np.inf, residual))


def _weighted_solution(A, y, eta):
    """Return x with A' diag(eta) (y - A x) = 0."""
    N = A.T @ (A * eta[:, None])
    if np.linalg.matrix_rank(N, hermitian=True) < len(N):
        raise ValueError("the weights leave too few values for a fit: their thresholds are too small")
    return np.linalg.solve(N, A.T @ (eta * y))


def _covariance(A, v, weight, sigma):
    """Return sigma^2 (sum psi^2 / (n - p)) / (mean psi')^2 (A'A)^-1: Huber (1973), Annals of Statistics 1:799-821."""
    n, p = A.shape
    if sigma == 0:
        return np.zeros((p, p))
    psi = weight(v) * v
    slope = np.mean((v + STEP) * weight(v + STEP) - (v - STEP) * weight(v - STEP)) / (2 * STEP)
    factor = np.sum(psi**2) / (n - p) / slope**2 if slope > 0 else np.nan
    return sigma**2 * factor * np.linalg.inv(A.T @ A)


def _spread_out(eta, present):
    """Return eta for all epochs, 0 for those without a value."""
    weight = np.zeros(len(present))
    weight[present] = eta
    return weight


def _counted(weight):
    return f"{len(weight)} values, {np.count_nonzero(weight == 0)} left out"
