"""Epochs of a pair, each solved alone, with all satellites or with some of them."""

from dataclasses import replace

import numpy as np

from gnsslab.core.mixed_model import FloatSolution
from gnsslab.gnss.correlation import double_difference_covariance


def keep_satellites(epochs, kept):
    """Return PairEpochs of the satellites `kept` (k,), indices into epochs.satellites; the first of them is the new reference.

    Differences to one satellite hold those to any other: y_i1 = y_i0 - y_10.
    """
    f, m = len(epochs.wavelengths), len(epochs.satellites)
    take = np.eye(m)[:, 1:]  # row i: satellite i minus the first, of which the first itself is none
    T = np.kron(np.eye(f), take[kept[1:]] - take[kept[0]])
    return replace(
        epochs,
        y=epochs.y @ np.kron(np.eye(2), T).T,
        u=epochs.u[:, kept],
        integers=(T @ epochs.integers).astype(np.int64),
        satellites=tuple(epochs.satellites[k] for k in kept),
    )


def float_solutions(epochs, sigma_code, sigma_phase):
    """Return the FloatSolution of T PairEpochs, each with its own geometry; sigmas (m,) [m] of one receiver's reading.

    In one epoch there are as many carriers as integers, so the codes alone give the baseline:

    b_hat = (B' W B)^-1 B' W y_code,    a_hat = (y_phase - B b_hat) / lambda,
    Q_a = (Q_phase + B Q_b B') / lambda^2,    Q_ba = -Q_b B' / lambda
    """
    f, n = len(epochs.wavelengths), len(epochs.integers)
    Q_code, Q_phase = (np.kron(np.eye(f), double_difference_covariance(sigma, 0)) for sigma in (sigma_code, sigma_phase))
    B, wave = np.tile(epochs.u[:, :1] - epochs.u[:, 1:], (1, f, 1)), np.repeat(epochs.wavelengths, n // f)  # (T, n, 3), (n,)
    WB = np.linalg.solve(Q_code, B)
    Q_b = np.linalg.inv(np.swapaxes(B, -1, -2) @ WB)
    b_hat = np.matvec(Q_b @ np.swapaxes(WB, -1, -2), epochs.y[:, :n])
    BQ = B @ Q_b
    return FloatSolution(
        a_hat=(epochs.y[:, n:] - np.matvec(B, b_hat)) / wave,
        b_hat=b_hat,
        Q_a=(Q_phase + BQ @ np.swapaxes(B, -1, -2)) / np.outer(wave, wave),
        Q_b=Q_b,
        Q_ba=-np.swapaxes(BQ, -1, -2) / wave,
    )


def middle(solution):
    """Return the FloatSolution of the middle one of T epochs."""
    return FloatSolution(*(part[len(part) // 2] for part in solution[:5]), solution.length_used)


def order_of_loss(epochs, direction):
    """Return the order in which satellites are lost, indices (m,): those farthest in a direction (3,), east, north, up, go first."""
    return np.argsort(-epochs.u[len(epochs.u) // 2] @ np.asarray(direction, dtype=float), kind="stable")
