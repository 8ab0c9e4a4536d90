"""Equations of paper B (Li et al. 2021) as printed, to be compared with what they should be."""

import numpy as np


def normal_matrix_as_printed(Q_1, Q_2):
    """Return A'PA (6, 6) of equation (11) for positions with covariances Q_1, Q_2 (3, 3): its rank is 3, so that (12) has no inverse.

    A = [-I I] says that two positions differ by nothing; both may still move together. P is taken as (Q_1 + Q_2)^-1: the printed one, 6 x 6,
    cannot be multiplied with A.

    >>> int(np.linalg.matrix_rank(normal_matrix_as_printed(np.eye(3), 4 * np.eye(3))))
    3
    """
    A = np.hstack([-np.eye(3), np.eye(3)])
    return A.T @ np.linalg.solve(np.asarray(Q_1, float) + np.asarray(Q_2, float), A)


def gain_as_printed(P, H, R):
    """Return equation (17), K = H P H' / (H P H' + R): a number, where a gain has one for each state. Right only where H = 1.

    >>> P, H = np.diag([4.0, 1.0]), np.array([[1.0, 0.5]])
    >>> gain_as_printed(P, H, np.eye(1)).round(3).tolist(), (P @ H.T / (H @ P @ H.T + 1)).round(3).tolist()
    ([[0.81]], [[0.762], [0.095]])
    """
    P, H, R = (np.asarray(each, dtype=float) for each in (P, H, R))
    return np.linalg.solve((H @ P @ H.T + R).T, (H @ P @ H.T).T).T


def equivalent_variance_as_printed(R, weight):
    """Return equation (20), lambda R with lambda = 1 / eta: infinite where the weight eta is 0, so code that multiplies with it gets no number.

    >>> float(equivalent_variance_as_printed(9.0, 0.25)), float(equivalent_variance_as_printed(9.0, 0.0))
    (36.0, inf)
    """
    with np.errstate(divide="ignore"):
        return np.asarray(R, dtype=float) / np.asarray(weight, dtype=float)
