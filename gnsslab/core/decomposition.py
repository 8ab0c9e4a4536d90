"""EEMD-wavelet: a series taken apart into oscillations, from fast to slow, and the fast ones shrunk like wavelet coefficients.

Slow: each trial of each axis sifts the series with cubic splines, in Python. The package EMD-signal does that; it is loaded when first used.
"""

import warnings

import numpy as np

from gnsslab.core.columns import columns, complete_measurements, uncolumns, whole_number
from gnsslab.core.denoise import soft, universal_limit

SIFTINGS = 8  # of each oscillation; Wu and Huang (2009) keep to about ten
FEWEST_EPOCHS = 5  # three extrema within


def eemd_wavelet(z, rng, trials=25, noise=0.2, shrunk=3, scale=1.0, progress=None):
    """Return z (..., T, d) without what is small in its fastest oscillations.

        sum over j < shrunk of soft(c_j, limit_j) + sum of the slower c_j,  limit_j = scale median |c_j| / 0.6745 sqrt(2 ln T)

    c_j: mean over `trials` of the j-th intrinsic mode function (IMF) of z + white noise of `noise` times the standard deviation of z,
    each axis for itself. (EMD-signal's own ensemble multiplies the range of z instead: 13 to 20 times as much noise where z has gross
    errors of some sigma.) Noise comes from `rng`, a `numpy.random.Generator`; `progress(done, all)` is told after each trial.
    A constant axis stays as it is. Raises ValueError for NaN, and for fewer than 5 epochs.

    Sources: Wu and Huang (2009), Advances in Adaptive Data Analysis 1:1-41; thresholds of IMFs: Kopsinis and McLaughlin (2009),
    IEEE Trans. Signal Processing 57:1351-1362.

    >>> z = np.full((64, 1), 7.0)
    >>> eemd_wavelet(z, np.random.default_rng(1)).ravel()[:3].tolist()
    [7.0, 7.0, 7.0]
    """
    z = complete_measurements(z)
    trials, shrunk = whole_number(trials, "trials", 1), whole_number(shrunk, "shrunk", 1)
    if z.shape[-2] < FEWEST_EPOCHS:
        raise ValueError(f"EEMD needs at least {FEWEST_EPOCHS} epochs, there are {z.shape[-2]}")
    if not (noise >= 0 and scale >= 0):
        raise ValueError(f"noise and scale must not be negative; got {noise} and {scale}")
    parts = columns(z).T
    report = _counted(progress, trials * len(parts))
    return uncolumns(np.transpose([_without_noise(part, rng, trials, noise, shrunk, scale, report) for part in parts]), z)


def _without_noise(y, rng, trials, noise, shrunk, scale, report):
    """Return y (T,) without what is small in its fastest oscillations, sifted in units of its sigma: EMD-signal stops at fixed sizes."""
    unit, mean = np.std(y), np.mean(y)
    if unit <= 1e-12 * abs(mean):  # rounding
        return y.copy()
    modes, whole = _fastest_modes((y - mean) / unit, rng, trials, noise, shrunk, report)
    small = modes - soft(modes, scale * universal_limit(modes, len(y), axis=-1))
    return mean + unit * (whole - small.sum(axis=0))


def _fastest_modes(y, rng, trials, noise, count, report):
    """Return the first `count` ensemble IMFs (count, T) of y (T,), zeros where there are fewer, and the sum (T,) of all."""
    emd, modes, whole = _sifter(), np.zeros((count, len(y))), np.zeros(len(y))
    for _ in range(trials):
        noisy = y + noise * rng.standard_normal(len(y))
        emd.emd(noisy, max_imf=count)
        modes[: len(emd.imfs)] += emd.imfs
        whole += noisy
        report()
    return modes / trials, whole / trials


def _sifter():
    """Return EMD-signal's decomposition with a fixed number of siftings; the package's own text warns when Python compiles it."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        from PyEMD import EMD
    return EMD(FIXE=SIFTINGS)


def _counted(progress, total):
    """Return a function to call after each trial, which tells progress(done, total)."""
    done = iter(range(1, total + 1))
    return (lambda: None) if progress is None else (lambda: progress(next(done), total))
