"""Each epoch solved alone, with a covariance that the caller believes in: float baseline, integers, fixed baseline."""

from dataclasses import dataclass

import numpy as np

from gnsslab.core.integers import integer_least_squares, success_rate
from gnsslab.gnss.differences import difference_operator
from gnsslab.gnss.judging import ratio_threshold


@dataclass(frozen=True, eq=False)
class SingleDifferences:
    """Rover minus master at T epochs on one carrier of m satellites, measured minus modelled about the known baseline."""

    code: np.ndarray  # (T, m) [m]
    phase: np.ndarray  # (T, m) [m], whole cycles left in it
    design: np.ndarray  # (T, m, 3) or (1, m, 3), change with the baseline east, north, up
    sigma_code: np.ndarray  # (m,) [m], of one receiver's measurement
    sigma_phase: np.ndarray  # (m,) [m]
    integers: np.ndarray  # (m,) int [cycles], the true ones, up to a number common to all
    wavelength: float  # [m]


@dataclass(frozen=True, eq=False)
class Solved:
    """What a solver made of T epochs, n = m - 1 double differences each."""

    ratio: np.ndarray  # (T,) second best over best squared norm
    is_right: np.ndarray  # (T,) bool, the best integers are the true ones
    threshold: float  # a ratio at or above it counts as fixed
    promised: float  # success rate that the believed covariance promises
    baseline: np.ndarray  # (T, 3) [m], east, north, up less the known baseline, with the true integers
    Q_baseline: np.ndarray  # (3, 3) [m^2], covariance that the solver claims for it, middle epoch

    @property
    def is_fixed(self):
        """Which epochs pass the ratio test, (T,) bool."""
        return self.ratio >= self.threshold


def solve_each_epoch(data, reference, believed):
    """Return what a solver makes of SingleDifferences; `believed(sigma, reference)` is the covariance (n, n) it works with.

    y_code = B b + e,  y_phase = B b + lambda a + e:
    b_hat = (B' W B)^-1 B' W y_code,  a_hat = (y_phase - B b_hat) / lambda,  Q_a = (Q_phase + B Q_b B') / lambda^2.

    In one epoch there are as many carriers as integers, so the codes alone give the float baseline. With the integers known
    the carriers give the fixed one.
    """
    D = difference_operator(len(data.integers), reference)
    Q_code, Q_phase = (believed(sigma, reference) for sigma in (data.sigma_code, data.sigma_phase))
    B, code, phase, truth = D @ data.design, data.code @ D.T, data.phase @ D.T, D @ data.integers
    gain, Q_b = _weighted(B, Q_code)
    a_hat = (phase - np.matvec(B, np.matvec(gain, code))) / data.wavelength
    Q_a = (Q_phase + B @ Q_b @ np.swapaxes(B, -1, -2)) / data.wavelength**2
    found = integer_least_squares(a_hat, Q_a if len(Q_a) > 1 else Q_a[0])
    baseline, Q_baseline = fixed_baselines(data, reference, believed)
    return Solved(
        ratio=found.ratio,
        is_right=(found.best == truth).all(axis=-1),
        threshold=float(ratio_threshold(len(truth))),
        promised=float(np.median(success_rate(Q_a))),
        baseline=baseline,
        Q_baseline=Q_baseline,
    )


def fixed_baselines(data, reference, believed):
    """Return the baselines (T, 3) [m] that the carriers give with the true integers, and the covariance (3, 3) claimed at the middle epoch."""
    D = difference_operator(len(data.integers), reference)
    gain, Q = _weighted(D @ data.design, believed(data.sigma_phase, reference))
    return np.matvec(gain, (data.phase - data.wavelength * data.integers) @ D.T), Q[len(Q) // 2]


def sampled_covariance(data, reference):
    """Return the covariance (n, n) [m^2] that the carriers' double differences show by themselves, over T epochs about their means."""
    D = difference_operator(len(data.integers), reference)
    return np.cov((data.phase - data.wavelength * data.integers) @ D.T, rowvar=False)


def _weighted(B, Q):
    """Return the least-squares gain (..., 3, n) of y = B b + e, e ~ N(0, Q), and the covariance (..., 3, 3) that it claims."""
    WB = np.linalg.solve(Q, B)  # (..., n, 3)
    Q_b = np.linalg.inv(np.swapaxes(B, -1, -2) @ WB)
    return Q_b @ np.swapaxes(WB, -1, -2), Q_b
