"""The model of a short baseline: double-differenced codes and carriers, in which the atmosphere has cancelled."""

import numpy as np

from gnsslab.core.mixed_model import MixedModel
from gnsslab.gnss.correlation import double_difference_covariance
from gnsslab.gnss.differences import difference_operator

_UNIT = 0.1  # the mean of unit vectors over an hour is 1 % shorter than 1; positions and angles are farther off


def short_baseline_model(u, wavelengths, sigma_code, sigma_phase, epochs=1, reference=0):
    """Return the MixedModel of m satellites on f frequencies: all codes first, then all carriers, frequency by frequency.

    y_code = B_1 b + e,    y_phase = lambda a + B_1 b + e,    B_1 = -D u,    Q = D diag(2 sigma^2) D'

    u: (m, 3) unit vectors from receiver to satellite; wavelengths: (f,) [m]; sigma_code, sigma_phase: (m,) [m] of one
    receiver's reading. There are n = f (m - 1) double-difference ambiguities a [cycles] and the baseline b (3,) [m] in the
    axes of u. `epochs` of one geometry, averaged, have Q_y / epochs.
    Raises ValueError for fewer than two satellites, vectors of another length, no frequency, sigmas or epochs that are
    not positive, or shapes that do not fit.
    Source: Teunissen and Montenbruck (2017), Springer Handbook of Global Navigation Satellite Systems, chapter 23.

    >>> up, north, east = [0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]
    >>> A, B, Q_y = short_baseline_model([up, north, east], [0.19], [0.3] * 3, [0.003] * 3)
    >>> A.tolist(), B[2:].tolist()
    ([[0.0, 0.0], [0.0, 0.0], [0.19, 0.0], [0.0, 0.19]], [[0.0, -1.0, 1.0], [-1.0, 0.0, 1.0]])
    >>> Q_y[:2, :2].round(2).tolist()
    [[0.36, 0.18], [0.18, 0.36]]
    """
    u, wavelengths = np.asarray(u, dtype=np.float64), np.atleast_1d(np.asarray(wavelengths, dtype=np.float64))
    sigma_code, sigma_phase = np.asarray(sigma_code, dtype=np.float64), np.asarray(sigma_phase, dtype=np.float64)
    _check(u, wavelengths, sigma_code, sigma_phase, epochs)
    m, f = len(u), len(wavelengths)
    B_1, carriers = -difference_operator(m, reference) @ u, np.kron(np.diag(wavelengths), np.eye(m - 1))
    codes, phases = (np.kron(np.eye(f), double_difference_covariance(sigma, reference)) for sigma in (sigma_code, sigma_phase))
    return MixedModel(
        A=np.vstack([np.zeros_like(carriers), carriers]),
        B=np.tile(B_1, (2 * f, 1)),
        Q_y=_block_diagonal(codes, phases) / epochs,
    )


def _check(u, wavelengths, sigma_code, sigma_phase, epochs):
    if u.ndim != 2 or u.shape[1] != 3 or len(u) < 2:
        raise ValueError(f"u must hold the unit vectors (m, 3) of two or more satellites; it has shape {u.shape}")
    if not np.all(np.abs(np.linalg.norm(u, axis=1) - 1) < _UNIT):
        raise ValueError("u must hold unit vectors from receiver to satellite; divide each by its length")
    if wavelengths.ndim != 1 or wavelengths.size == 0 or not _are_positive(wavelengths):
        raise ValueError(f"wavelengths must hold a positive number of metres for each frequency (f,); they are {wavelengths}")
    for name, sigma in (("sigma_code", sigma_code), ("sigma_phase", sigma_phase)):
        if sigma.shape != (len(u),) or not _are_positive(sigma):
            raise ValueError(f"{name} must have one positive number of metres for each of the {len(u)} satellites; it is {sigma}")
    if not 1 <= epochs < np.inf:
        raise ValueError(f"epochs must be 1 or more; it is {epochs}")


def _are_positive(values):
    return np.all((values > 0) & np.isfinite(values))


def _block_diagonal(upper, lower):
    zero = np.zeros((len(upper), len(lower)))
    return np.block([[upper, zero], [zero.T, lower]])
