"""Series of measurements (..., T, d), T epochs of d axes, as columns of one matrix (T, n) and back."""

import math
from numbers import Real

import numpy as np


def measurements(z):
    """Return z as an array (..., T, d) of numbers and NaN; raises ValueError for another shape or an infinite value."""
    z = np.asarray(z, dtype=np.float64)
    if z.ndim < 2:
        raise ValueError(f"z must have a row for each epoch and a column for each axis, (T, d); got shape {z.shape}: for one axis write z[:, None]")
    if np.isinf(z).any():
        raise ValueError("z must be finite, or NaN where nothing was measured; there is an infinite value")
    return z


def complete_measurements(z):
    """Return z as an array (..., T, d) of numbers; raises ValueError for a NaN too."""
    z = measurements(z)
    missing = np.count_nonzero(np.isnan(z).any(axis=-1))
    if missing:
        raise ValueError(f"this needs a number in every epoch, and {missing} of z have NaN: fill them first, with random_walk_smoother for instance")
    return z


def columns(z):
    """Return z (..., T, d) as (T, n): a column for each axis of each series.

    >>> columns(np.arange(8).reshape(2, 2, 2)).tolist()
    [[0, 1, 4, 5], [2, 3, 6, 7]]
    """
    return np.moveaxis(z, -2, 0).reshape(z.shape[-2], math.prod(z.shape[:-2]) * z.shape[-1])


def uncolumns(matrix, z):
    """Return columns (T, n) in the shape of z (..., T, d)."""
    shape = (z.shape[-2], *z.shape[:-2], z.shape[-1])
    return np.moveaxis(np.asarray(matrix).reshape(shape), 0, -2)


def whole_number(n, name, least):
    """Return n as an int; raises ValueError where it is none or below the least."""
    if not (isinstance(n, Real) and n % 1 == 0 and n >= least):
        raise ValueError(f"{name} must be a whole number, at least {least}; got {n}")
    return int(n)
