"""Integer least squares the obvious way, twice: every point of a box, and a recursion without any cleverness."""

import itertools

import numpy as np


def best_in_box(a_hat, Q, n_best, half_width):
    """Return candidates and squared norms of the n_best points of the box round(a_hat) +- half_width."""
    sides = [range(int(x) - half_width, int(x) + half_width + 1) for x in np.rint(a_hat)]
    points = np.array(list(itertools.product(*sides)))  # (sides^n, n)
    residual = a_hat - points
    norms = np.einsum("pi,pi->p", residual, np.linalg.solve(Q, residual.T).T)
    order = np.argsort(norms)[:n_best]
    return points[order], norms[order]


def all_within(a_hat, Q, bound):
    """Return every integer point whose squared norm is at most `bound`, by conditioning the first variable on nothing.

    Plain recursion: fix a_1, condition the others on it, take its share off the bound.
    """
    if len(a_hat) == 0:
        return [()]
    reach = np.sqrt(bound * Q[0, 0])
    found = []
    for a_1 in range(int(np.ceil(a_hat[0] - reach)), int(np.floor(a_hat[0] + reach)) + 1):
        gain = Q[1:, 0] / Q[0, 0]
        rest = all_within(a_hat[1:] - gain * (a_hat[0] - a_1), Q[1:, 1:] - np.outer(gain, Q[0, 1:]), bound - (a_hat[0] - a_1) ** 2 / Q[0, 0])
        found += [(a_1, *others) for others in rest]
    return found


def best_by_recursion(a_hat, Q, n_best, bound):
    """Return candidates and norms of the n_best points, `bound` at least as large as the n_best-th norm."""
    points = np.array(all_within(a_hat, Q, bound * (1 + 1e-9)))
    residual = a_hat - points
    norms = np.einsum("pi,pi->p", residual, np.linalg.solve(Q, residual.T).T)
    order = np.argsort(norms)[:n_best]
    return points[order], norms[order]


def covariance(n, rng, decades=3.0):
    """Return a random covariance (n, n) [cycles^2], its eigenvalues spread over so many decades below 1."""
    basis = np.linalg.qr(rng.standard_normal((n, n)))[0]
    Q = basis @ np.diag(10.0 ** rng.uniform(-decades, 0.0, n)) @ basis.T
    return (Q + Q.T) / 2


def unimodular(n, rng):
    """Return an integer matrix with determinant 1: a random product of Gauss steps and a permutation."""
    Z = np.eye(n, dtype=np.int64)[rng.permutation(n)]
    for _ in range(2 * n):
        i, j = rng.integers(0, n, 2)
        if i != j:
            Z[:, i] += rng.integers(-2, 3) * Z[:, j]
    return Z
