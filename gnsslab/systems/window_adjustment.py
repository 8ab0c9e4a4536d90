"""Paper B's "improved unconstrained adjustment" (Li et al. 2021, section 2): each epoch is adjusted together with the mean of those before it.

Two positions of one point, X_1 the mean of a window and X_2 the epoch's, should be equal. That is one condition for each axis,
A d + l = 0 with A = [-I I] and l = X_2 - X_1. Its least-squares solution is the weighted mean of the two, and that is all there is to it:

    x_hat = w x_k + (1 - w) x_bar,   w = s_bar^2 / (s_bar^2 + s_k^2)

The paper's window is 30 epochs long, and its error s_bar the mean of the errors of its epochs, so that w is near one half. It does not say
whether the window holds solutions as they came or as adjusted.
"""

from typing import NamedTuple

import numpy as np

from gnsslab.core.jit import kernel, kernel_input, matrix


class Adjusted(NamedTuple):
    """Two positions adjusted to be one point."""

    position: np.ndarray  # (p,) [m]
    Q: np.ndarray  # (p, p) [m^2]


def adjust_by_condition(X_1, Q_1, X_2, Q_2):
    """Return the `Adjusted` of two positions (p,) with covariances (p, p), by condition adjustment.

    d = -Q A' (A Q A')^-1 l,   Q = blockdiag(Q_1, Q_2),   A = [-I I],   l = X_2 - X_1      (Koch 1999, section 3.2.5)

    >>> found = adjust_by_condition([120.0], [[2.25]], [124.0], [[9.0]])
    >>> found.position.round(9).tolist(), np.sqrt(found.Q).round(2).tolist()
    ([120.8], [[1.34]])
    """
    X_1, Q_1, X_2, Q_2 = (np.asarray(each, dtype=float) for each in (X_1, Q_1, X_2, Q_2))
    p = len(X_1)
    A = np.hstack([-np.eye(p), np.eye(p)])
    Q = np.block([[Q_1, np.zeros((p, p))], [np.zeros((p, p)), Q_2]])
    gain = np.linalg.solve(A @ Q @ A.T, A @ Q).T  # Q A' (A Q A')^-1
    corrections = -gain @ (X_2 - X_1)
    Q_adjusted = Q - gain @ A @ Q
    return Adjusted(X_1 + corrections[:p], Q_adjusted[:p, :p])


def weighted_mean(X_1, Q_1, X_2, Q_2):
    """Return the `Adjusted` of two positions (p,) with covariances (p, p), as their weighted mean: the same numbers as `adjust_by_condition`.

    x_hat = (Q_1^-1 + Q_2^-1)^-1 (Q_1^-1 X_1 + Q_2^-1 X_2)

    >>> weighted_mean([120.0], [[2.25]], [124.0], [[9.0]]).position.round(9).tolist()
    [120.8]
    """
    X_1, Q_1, X_2, Q_2 = (np.asarray(each, dtype=float) for each in (X_1, Q_1, X_2, Q_2))
    W = np.linalg.solve((Q_1 + Q_2).T, Q_1.T).T  # of X_2: Q_1 (Q_1 + Q_2)^-1
    return Adjusted(X_1 + W @ (X_2 - X_1), Q_1 - W @ Q_1)


def weights_by_mean_error(sigma, window=30):
    """Return the weight w (T,) of each epoch beside its window, whose error is the mean of its epochs' stated errors sigma (T,) [m]: the paper's.

    >>> weights_by_mean_error([1.0, 1.0, 2.0]).tolist()
    [1.0, 0.5, 0.2]
    """
    return _weights(sigma, mean_before(np.asarray(sigma, float)[:, None], window)[:, 0])


def weights_by_error_of_mean(sigma, window=30):
    """Return the same with the error that a mean of independent epochs would have: the mean of their errors over the root of their number.

    >>> weights_by_error_of_mean(np.ones(40))[[1, 4, 39]].round(4).tolist()  # 1/2, 1/5, 1/31
    [0.5, 0.2, 0.0323]
    """
    sigma = np.asarray(sigma, float)
    epochs = np.clip(np.arange(len(sigma)), 1, window)
    return _weights(sigma, mean_before(sigma[:, None], window)[:, 0] / np.sqrt(epochs))


def _weights(sigma, sigma_window):
    sigma = np.asarray(sigma, dtype=float)
    if not (np.isfinite(sigma) & (sigma > 0)).all():
        raise ValueError("the stated errors must be positive numbers [m]; leave out the epochs without, or give a constant")
    weight = sigma_window**2 / (sigma_window**2 + sigma**2)
    weight[:1] = 1.0  # nothing stands before the first epoch
    return weight


def mean_before(z, window):
    """Return for each epoch of z (T, d) the mean of up to `window` epochs before it; for the first, itself.

    >>> mean_before(np.array([[1.0], [2.0], [6.0], [0.0]]), 2).tolist()
    [[1.0], [1.0], [1.5], [4.0]]
    """
    if window < 1:
        raise ValueError(f"the window must be one epoch long at least; it is {window}")
    z = np.asarray(z, dtype=float)
    total = np.vstack([np.zeros_like(z[:1]), np.cumsum(z - z[:1], axis=0)])  # of differences, so that sums stay small
    last = np.arange(len(z))
    first = np.maximum(last - window, 0)
    mean = z[:1] + (total[last] - total[first]) / np.maximum(last - first, 1)[:, None]
    return np.where(last[:, None] > 0, mean, z)


def adjust_with_raw_window(z, weight, window=30):
    """Return z (T, d) adjusted with weights (T,), the window holding solutions as they came: w z_k + (1 - w) mean(z_(k-30) .. z_(k-1)).

    >>> adjust_with_raw_window(np.array([[0.0], [0.0], [1.0], [1.0]]), np.full(4, 0.5), 2).ravel().tolist()
    [0.0, 0.0, 0.5, 0.75]
    """
    z, weight = _checked(z, weight)
    return weight[:, None] * z + (1 - weight[:, None]) * mean_before(z, window)


def adjust_with_adjusted_window(z, weight, window=30):
    """Return z (T, d) adjusted with weights (T,), the window holding solutions as adjusted: each feeds on those before it.

    >>> adjust_with_adjusted_window(np.array([[0.0], [0.0], [1.0], [1.0]]), np.full(4, 0.5), 2).ravel().tolist()
    [0.0, 0.0, 0.5, 0.625]
    """
    z, weight = _checked(z, weight)
    if window < 1:
        raise ValueError(f"the window must be one epoch long at least; it is {window}")
    return np.asarray(_adjust(kernel_input(z), kernel_input(weight), window)).reshape(z.shape)


@kernel
def _adjust(z, weight, window):
    T, d = len(z), len(z[0])
    out, total = matrix(T, d), matrix(1, d)[0]
    for k in range(T):
        inside = min(k, window)
        for j in range(d):
            w = weight[k] if inside > 0 else 1.0
            out[k][j] = w * z[k][j] + (1.0 - w) * (total[j] / max(inside, 1) + z[0][j])
            total[j] += out[k][j] - z[0][j]  # sums of differences stay small
            if inside == window:
                total[j] -= out[k - window][j] - z[0][j]
    return out


def _checked(z, weight):
    z, weight = np.asarray(z, dtype=float), np.asarray(weight, dtype=float)
    if z.ndim != 2 or not len(z) or weight.shape != z.shape[:1]:
        raise ValueError(f"expected a series (T, d) of one epoch at least with a weight for each; the shapes are {z.shape} and {weight.shape}")
    if not (np.isfinite(z).all() and np.isfinite(weight).all()):
        raise ValueError("the adjustment needs a number at each epoch: leave out the epochs without a solution first")
    return z, weight
