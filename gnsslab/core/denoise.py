"""Filters that look at a series through a window or a wavelet: averages, medians, polynomials, thresholds.

All take z (..., T, d), T epochs of d axes at equal steps of time, and return an array of that shape. NaN, where nothing was
measured, is left out of averages and medians; polynomials and wavelets need every epoch and say so.
"""

from typing import NamedTuple

import numpy as np
import pywt
from scipy.signal import savgol_filter

from gnsslab.core.columns import columns, complete_measurements, measurements, uncolumns, whole_number

MAD_OF_NORMAL = 0.6745  # median |x| of a standard normal x
SORTED_AT_ONCE = 2**20  # values in the windows of a block of epochs, 8 MB


def moving_average(z, n):
    """Return the mean of the n epochs around each one, n // 2 before it; at the ends of those that there are. NaN where there are none.

    >>> moving_average([[0.0], [3.0], [6.0], [0.0]], 3).ravel().tolist()
    [1.5, 3.0, 3.0, 3.0]
    """
    n = whole_number(n, "the window n", 1)
    return _window_mean(measurements(z), before=n // 2, after=n - 1 - n // 2)


def trailing_average(z, n):
    """Return the mean of each epoch and the n - 1 before it, of those that there are: what can be known at once. NaN where there are none.

    >>> trailing_average([[0.0], [3.0], [6.0], [0.0]], 3).ravel().tolist()
    [0.0, 1.5, 3.0, 3.0]
    """
    return _window_mean(measurements(z), before=whole_number(n, "the window n", 1) - 1, after=0)


class Hampel(NamedTuple):
    """A series without its outliers."""

    filtered: np.ndarray  # (..., T, d) z, and the median of the window where z is an outlier
    is_outlier: np.ndarray  # (..., T, d) bool


def hampel_filter(z, half_width, threshold=3.0):
    """Return the `Hampel` of z: a value more than threshold sigma from the median of its window is replaced by that median.

        |z_k - med| > threshold 1.4826 MAD,  over the epochs k - half_width to k + half_width, fewer at the ends

    Where more than half of a window are equal the MAD is 0 and all others in it count as outliers.
    Sources: Hampel (1974), J. American Statistical Association 69:383-393; as a filter: Pearson (2002), IEEE Trans. Control Systems
    Technology 10:55-63.

    >>> cleaned = hampel_filter([[0.0], [1.0], [2.0], [90.0], [4.0], [5.0], [6.0]], half_width=3)
    >>> cleaned.filtered.ravel().tolist(), cleaned.is_outlier.ravel().nonzero()[0].tolist()
    ([0.0, 1.0, 2.0, 4.0, 4.0, 5.0, 6.0], [3])
    """
    z, half = measurements(z), whole_number(half_width, "half_width", 1)
    if not threshold > 0:
        raise ValueError(f"the threshold counts sigmas and must be above zero, such as 3; got {threshold}")
    middle, spread = (uncolumns(array, z) for array in _medians(columns(z), half))
    is_outlier = np.abs(z - middle) > threshold * spread
    return Hampel(np.where(is_outlier, middle, z), is_outlier)


def savitzky_golay(z, n, degree):
    """Return at each epoch the value of the polynomial fitted to the n epochs around it; the first and last n // 2 lie on the end polynomials.

    n is odd and above the degree. Raises ValueError for another n, fewer than n epochs, or NaN.
    Source: Savitzky and Golay (1964), Analytical Chemistry 36:1627-1639.

    >>> savitzky_golay([[0.0], [1.0], [4.0], [9.0], [16.0]], n=5, degree=2).round(9).ravel().tolist()
    [0.0, 1.0, 4.0, 9.0, 16.0]
    """
    z, degree = complete_measurements(z), whole_number(degree, "the degree", 0)
    n = whole_number(n, "the window n", degree + 1)
    if n % 2 == 0 or n > z.shape[-2]:
        raise ValueError(f"the window n must be odd and at most the number of epochs, {z.shape[-2]}; got {n}")
    return savgol_filter(z, n, degree, axis=-2)


def soft(c, limit):
    """Shrink coefficients c by the limit, to 0 if below it."""
    return np.sign(c) * np.maximum(np.abs(c) - limit, 0.0)


def hard(c, limit):
    """Keep coefficients c above the limit, 0 for the others."""
    return np.where(np.abs(c) > limit, c, 0.0)


def wavelet_threshold(z, level=3, wavelet="db8", shrink=soft):
    """Return z with the wavelet coefficients of its finest levels put through `shrink(c, limit)`, `soft` or `hard`.

        limit = sigma sqrt(2 ln T),  sigma = median |c of the finest level| / 0.6745        for each axis

    sigma is that of white noise. The wavelet is one that PyWavelets knows by name.
    Raises ValueError for NaN and for a series too short for the level. Source: Donoho and Johnstone (1994), Biometrika 81:425-455.

    >>> z = np.zeros((256, 1)); z[128:] = 1.0
    >>> bool(np.ptp(wavelet_threshold(z) - z) < 1e-9)  # without noise nothing is taken away
    True
    """
    z = complete_measurements(z)
    smooth, *details = pywt.wavedec(z, wavelet, level=_possible_level(level, wavelet, z.shape[-2]), axis=-2)
    limit = universal_limit(details[-1], z.shape[-2], axis=-2)
    return pywt.waverec([smooth, *(shrink(c, limit) for c in details)], wavelet, axis=-2)[..., : z.shape[-2], :]


def universal_limit(c, T, axis):
    """Return sigma sqrt(2 ln T), sigma = median |c| / 0.6745 along an axis that stays: T normal values of sigma hardly ever pass it."""
    return np.median(np.abs(c), axis=axis, keepdims=True) / MAD_OF_NORMAL * np.sqrt(2 * np.log(T))


def _window_mean(z, before, after):
    """Return the mean over epochs k - before to k + after of the numbers there, by differences of a running sum."""
    T, present = z.shape[-2], ~np.isnan(z)
    first, last = np.maximum(np.arange(T) - before, 0), np.minimum(np.arange(T) + after + 1, T)
    origin = _mean(np.sum(z, axis=-2, keepdims=True, where=present), np.count_nonzero(present, axis=-2, keepdims=True))  # keeps the sum small
    return origin + _mean(_running(np.where(present, z - origin, 0.0), first, last), _running(present, first, last))


def _mean(total, count):
    """Return total / count, NaN where the count is 0."""
    return np.divide(total, count, out=np.full(np.shape(total), np.nan), where=count > 0)


def _running(values, first, last):
    """Return the sums over epochs first <= k < last of values (..., T, d)."""
    total = np.zeros((*values.shape[:-2], values.shape[-2] + 1, values.shape[-1]), dtype=np.result_type(values, np.int64))
    np.cumsum(values, axis=-2, out=total[..., 1:, :])
    return total[..., last, :] - total[..., first, :]


def _medians(z, half):
    """Return the median and 1.4826 MAD (T, n) of the window around each epoch of z (T, n), a block of epochs at a time."""
    middle, spread, width = np.empty_like(z), np.empty_like(z), 2 * half + 1
    padded = np.pad(z, ((half, half), (0, 0)), constant_values=np.nan)
    step = max(1, SORTED_AT_ONCE // (width * max(z.shape[1], 1)))
    for start in range(0, len(z), step):
        part = slice(start, start + step)
        windows = np.lib.stride_tricks.sliding_window_view(padded[start : start + step + 2 * half], width, axis=0)  # (step, n, width)
        middle[part] = _median(windows)
        spread[part] = _median(np.abs(windows - middle[part, :, None])) / MAD_OF_NORMAL
    return middle, spread


def _median(windows):
    """Return the median over the last axis of what is not NaN."""
    ordered = np.sort(windows, axis=-1)  # NaN last
    count = np.count_nonzero(~np.isnan(ordered), axis=-1)[..., None]
    low, high = np.take_along_axis(ordered, np.maximum(count - 1, 0) // 2, axis=-1), np.take_along_axis(ordered, count // 2, axis=-1)
    return (0.5 * (low + high))[..., 0]


def _possible_level(level, wavelet, T):
    """Return the level, for which the coarsest coefficients must not all touch both ends of the series."""
    level, length = whole_number(level, "the level", 1), pywt.Wavelet(wavelet).dec_len
    needed = (length - 1) * 2**level
    if needed > T:
        raise ValueError(f"level {level} of the wavelet {wavelet} needs at least {needed} epochs, there are {T}: take a lower level")
    return level
