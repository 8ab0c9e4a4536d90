"""Weighting: how much a code or a carrier measurement may be trusted, from its elevation and its strength."""

from dataclasses import dataclass

import numpy as np

TYPICAL_CN0 = 45.0  # [dB-Hz], taken where a file gives no signal strength
_WEAKEST = 10.0  # [dB-Hz]; no carrier is tracked below: such numbers are classes 1 to 9 or a receiver's own units, and count as missing
_STRONGEST = 100.0  # [dB-Hz]; more is a slip of some file, and would overflow as a power of ten
_TRACKING_BANDWIDTH = 15.0  # [Hz], usual carrier loop


@dataclass(frozen=True)
class NoiseModel:
    """Standard deviations of one undifferenced measurement of one receiver.

    The carrier's variance is the sum of a part that is the same everywhere, a part that grows towards the horizon
    (multipath, antenna gain) and the thermal noise of the tracking loop; the code is `code_ratio` times worse.
    """

    phase: float = 0.003  # [m], the same at every elevation
    phase_horizon: float = 0.003  # [m], divided by sin(elevation)
    code_ratio: float = 100.0  # sigma of the code over sigma of the carrier
    correlated_share: float = 0.75  # of the carrier's variance, multipath that lasts
    correlation_time: float = 60.0  # [s], for which it lasts
    novelty_time: float = 10.0  # [s], the same as the filter believes it: longer is safer, but integers take longer to be found


def sigma_phase(noise, elevation, cn0, wavelength):
    """Return the standard deviation of the carrier [m], broadcast over elevation [rad], C/N0 [dB-Hz] and wavelength [m].

    sigma^2 = a^2 + b^2 / sin^2 el + (lambda / 2 pi)^2 B / 10^(C/N0 / 10); B = 15 Hz (Kaplan and Hegarty 2006, equation 5.9, without
    squaring loss). A missing C/N0, or one below 10 dB-Hz, counts as 45 dB-Hz, at which the last term is 0.7 mm on L1.

    >>> round(float(sigma_phase(NoiseModel(), np.pi / 2, 45.0, 0.1903)) * 1e3, 2)
    4.29
    """
    cn0 = np.where(np.isfinite(cn0) & (cn0 >= _WEAKEST), np.minimum(cn0, _STRONGEST), TYPICAL_CN0)
    thermal = (wavelength / (2 * np.pi)) ** 2 * _TRACKING_BANDWIDTH / 10 ** (cn0 / 10)
    return np.sqrt(noise.phase**2 + (noise.phase_horizon / np.sin(elevation)) ** 2 + thermal)


def sigma_code(noise, elevation, cn0, wavelength):
    """Return the standard deviation of the code [m]: the carrier's times `code_ratio`.

    >>> round(float(sigma_code(NoiseModel(), np.pi / 2, 45.0, 0.1903)), 3)
    0.429
    """
    return noise.code_ratio * sigma_phase(noise, elevation, cn0, wavelength)


def inflation_of_mean(n, interval, share, correlation_time):
    """Return how much larger the variance of the mean of n measurements is than independent ones would have it.

    f = 1 + 2 s sum over k < n of (1 - k / n) phi^k, phi = exp(-interval / tau): s is the share of the variance that is
    a first-order Gauss-Markov process of correlation time tau [s]. One measurement is not inflated; many by 1 + 2 s tau / interval.

    >>> inflation_of_mean(np.array([1, 10_000]), 1.0, 2 / 3, 60.0).round(1).tolist()
    [1.0, 79.9]
    """
    n, phi = np.asarray(n, dtype=float), np.exp(-interval / correlation_time)
    correlated = phi / (1 - phi) - phi * (1 - phi**n) / (n * (1 - phi) ** 2)
    return 1 + 2 * share * correlated


def information_step(n, interval, share, correlation_time):
    """Return what the n-th of correlated measurements adds to the information of their mean, 1 for the first one.

    I_n = n / f_n with f of `inflation_of_mean`; the step is I_n - I_n-1, in the end 1 / f. Divided by it, the variances of
    single measurements may be treated as independent, and add up to the information that the correlated ones have.

    >>> information_step(np.array([1, 2, 10_000]), 1.0, 2 / 3, 60.0).round(4).tolist()
    [1.0, 0.208, 0.0124]
    """
    n = np.asarray(n, dtype=float)
    before = np.where(n > 1, (n - 1) / inflation_of_mean(np.maximum(n - 1, 1), interval, share, correlation_time), 0.0)
    return n / inflation_of_mean(n, interval, share, correlation_time) - before
