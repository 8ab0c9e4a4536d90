"""Partial fixing: where not all ambiguities can be fixed with confidence, fix those that can.

Two ways to choose. After decorrelation: the last k of z = Z' a, the best known ones, whose success rate is known before
any data are there. In the original space: leave ambiguities out, the worst first (a satellite that rose just now), until
the rest is good enough. Either way k integer combinations C' a = z are fixed, and all else follows from their
correlation with it:

    a = a_hat - Q C (C' Q C)^-1 (C' a_hat - z)

which is still a vector of real numbers, but a better one. Nothing fixed (k = 0) gives the float solution, everything
(k = n) the integers.
Source: Teunissen, Joosten and Tiberius (1999), ION NTM-99:201-207; Parkins (2011), GPS Solutions 15:391-402.
"""

from typing import NamedTuple

import numpy as np
from scipy.special import erf

from gnsslab.core.integers.decorrelation import checked_problem, decorrelate, ltdl
from gnsslab.core.integers.rounding import integer_rounding
from gnsslab.core.integers.search import integer_least_squares
from gnsslab.core.integers.success import success_rate as success_rate_of
from gnsslab.core.mixed_model import given_known


class PartialSolution(NamedTuple):
    """Ambiguities of which some integer combinations C' a = z are fixed."""

    a: np.ndarray  # (..., n) real ambiguities given the fixed combinations [cycles]
    Q_a: np.ndarray  # (n, n) their covariance if the fix is right, of rank n - k [cycles^2]
    C: np.ndarray  # (n, k) int64, one column a combination
    z: np.ndarray  # (..., k) int64, their values [cycles]
    norms: np.ndarray  # (..., 2) squared distances of the best and second best z, for an acceptance test; (..., 0) where k = 0
    success_rate: float  # of bootstrapping for the k combinations

    @property
    def fixed(self):
        """The number k of fixed combinations."""
        return self.C.shape[-1]

    def __repr__(self):
        return f"PartialSolution: {self.fixed} of {len(self.C)} fixed, success rate {self.success_rate:.4f}"


def fix_most_certain(a_hat, Q, success_rate=0.999):
    """Fix as many ambiguities after decorrelation as reach the success rate together.

    max k:  prod over the last k of (2 Phi(1 / (2 sigma_i)) - 1) >= P,    then integer least squares on these k

    a_hat: (..., n) [cycles]; Q: (n, n) [cycles^2]; success_rate: P in [0, 1]. Returns a PartialSolution; its z are the last k
    of the decorrelated ambiguities, its C the last k columns of Z. Raises ValueError where Q is no covariance matrix.

    Of two ambiguities known to 0.05 and 0.6 cycles one is fixed:

    >>> found = fix_most_certain([3.1, 5.3], np.diag([0.0025, 0.36]))
    >>> found.z.tolist(), found.a.tolist()
    ([3], [3.0, 5.3])
    """
    a_hat, Q = checked_problem(a_hat, Q)
    _check_success_rate(success_rate)
    Z, _, d = decorrelate(Q)
    together = np.cumprod([1.0, *erf(1.0 / np.sqrt(8.0 * d[::-1]))])  # of the last 0, 1, 2, ... n
    k = int(np.sum(together >= success_rate)) - 1
    return fix_combinations(a_hat, Q, Z[:, len(d) - k :])._replace(success_rate=float(together[k]))


def fix_subset(a_hat, Q, success_rate=0.999, leave_out=None):
    """Fix those of the ambiguities themselves that reach the success rate, leaving out one after the other.

    a_hat: (..., n) [cycles]; Q: (n, n) [cycles^2]. leave_out: what to leave out first, second, ...: indices, or groups of
    indices (all ambiguities of a satellite); without it the ambiguity of the largest variance, and so on. Returns a
    PartialSolution, whose C are columns of the identity; it fixes nothing where even the last ones do not reach it.

    >>> fix_subset([3.1, 5.3], np.diag([0.0025, 0.36])).C.tolist()
    [[1], [0]]
    """
    a_hat, Q = checked_problem(a_hat, Q)
    _check_success_rate(success_rate)
    for kept in subsets(Q, leave_out):
        if success_rate_of(Q[np.ix_(kept, kept)]) >= success_rate:
            return fix_combinations(a_hat, Q, _columns(kept, len(Q)))
    return fix_combinations(a_hat, Q, _columns([], len(Q)))


def fix_accepted_subset(a_hat, Q, accept, leave_out=None):
    """Fix those of the ambiguities themselves whose fix is accepted, leaving out one after the other.

    accept: a function of a PartialSolution with its candidates' norms (2,), for example
    `lambda found: ratio_test(found.norms, 3.0)`. a_hat: (n,), one vector, as the answer depends on it; otherwise as
    `fix_subset`. Note that a test repeated on ever smaller subsets is passed by chance more often than once.

    >>> found = fix_accepted_subset([3.1, 5.45], np.diag([0.0025, 0.09]), lambda found: found.norms[1] > 3.0 * found.norms[0])
    >>> found.z.tolist(), found.fixed
    ([3], 1)
    """
    a_hat, Q = checked_problem(a_hat, Q)
    if a_hat.ndim != 1:
        raise ValueError(f"a_hat must be one float vector (n,), as each may be accepted with other ambiguities; it has shape {a_hat.shape}.")
    for kept in subsets(Q, leave_out):
        found = fix_combinations(a_hat, Q, _columns(kept, len(Q)))
        if accept(found):
            return found
    return fix_combinations(a_hat, Q, _columns([], len(Q)))


def subsets(Q, leave_out=None):
    """Yield the indices kept: all n, then without the first to leave out, and so on while any are left.

    Raises ValueError where leave_out is no list of indices, or groups of them.

    >>> [kept.tolist() for kept in subsets(np.diag([1.0, 3.0, 2.0]))]
    [[0, 1, 2], [0, 2], [0]]
    """
    kept = np.arange(len(Q))
    if np.isscalar(leave_out):
        raise ValueError(f"leave_out must be a list of indices, or of groups of them; it is {leave_out!r}: [{leave_out!r}] leaves out one")
    for group in np.argsort(-np.diag(Q), kind="stable") if leave_out is None else leave_out:
        if len(kept):
            yield kept
        kept = np.setdiff1d(kept, _checked_group(group, len(Q)))
    if len(kept):
        yield kept


def fix_combinations(a_hat, Q, C):
    """Fix the k integer combinations C' a by integer least squares, and the ambiguities by their correlation with them.

    a = a_hat - Q C (C' Q C)^-1 (C' a_hat - z),    Q_a|z = Q - Q C (C' Q C)^-1 C' Q

    a_hat: (..., n) [cycles]; Q: (n, n) [cycles^2]; C: (n, k) integers, columns of a unimodular matrix. Returns a PartialSolution.
    Raises ValueError where shapes do not fit, Q is no covariance matrix, or a_hat is not finite.

    >>> fix_combinations([3.1, 5.3], [[0.5, 0.4], [0.4, 0.5]], [[1], [-1]]).z.tolist()       # the difference -2.2
    [-2]
    """
    a_hat, Q = checked_problem(a_hat, Q)
    C, whole = _checked_combinations(C, len(Q)), integer_rounding(a_hat)  # large integers would cost digits in C' a_hat
    ltdl(Q)  # raises: the part C' Q C may be a covariance where Q is none
    if C.shape[1] == 0:
        stack = a_hat.shape[:-1]
        return PartialSolution(a_hat.copy(), Q.copy(), C, np.empty((*stack, 0), dtype=np.int64), np.empty((*stack, 0)), 1.0)
    Q_z = _symmetric(C.T @ Q @ C)
    z_hat = (a_hat - whole) @ C
    solution = integer_least_squares(z_hat, Q_z)
    gain = np.linalg.solve(Q_z, C.T @ Q).T  # (n, k)
    return PartialSolution(
        a=a_hat - np.matvec(gain, z_hat - solution.best),
        Q_a=_symmetric(Q - gain @ (C.T @ Q)),
        C=C,
        z=solution.best + whole @ C,
        norms=solution.norms,
        success_rate=float(success_rate_of(Q_z)),
    )


def given_combinations(solution, C, z):
    """Return b (..., p) and its covariance (p, p), given integer combinations C' a = z of a FloatSolution.

    b = b_hat - Q_ba C (C' Q_a C)^-1 (C' a_hat - z),    Q_b|z = Q_b - Q_ba C (C' Q_a C)^-1 C' Q_ab

    C: (n, k); z: (..., k), of a PartialSolution. With C the identity this is `given_integers`. Raises ValueError where
    they do not fit, or the combinations depend on each other.

    >>> from gnsslab.core.mixed_model import FloatSolution
    >>> found = FloatSolution(np.array([7.2]), np.array([3.0]), np.array([[0.2525]]), np.array([[0.01]]), np.array([[-0.05]]))
    >>> b, Q_b = given_combinations(found, [[1]], [7])
    >>> b.round(4).tolist(), Q_b.round(6).tolist()
    ([3.0396], [[9.9e-05]])
    """
    a_hat, z = np.asarray(solution.a_hat), np.asarray(z)
    C = _checked_combinations(C, a_hat.shape[-1])
    if z.shape[-1:] != C.shape[1:]:
        raise ValueError(f"z must have one value for each of the {C.shape[1]} combinations in its last axis; it has shape {z.shape}")
    return given_known(solution.b_hat, solution.Q_b, solution.Q_ba @ C, C.T @ solution.Q_a @ C, a_hat @ C - z)


def _checked_combinations(C, n):
    C = np.asarray(C)
    if C.ndim != 2 or len(C) != n or not np.issubdtype(C.dtype, np.integer):
        raise ValueError(f"C must be integers (n, k), a row for each of the {n} ambiguities; it has shape {C.shape}, type {C.dtype}.")
    return C


def _check_success_rate(success_rate):
    if not 0 <= success_rate <= 1:
        raise ValueError(f"success_rate is a probability between 0 and 1; it is {success_rate:g}")


def _checked_group(group, n):
    group = np.atleast_1d(group)
    if not np.issubdtype(group.dtype, np.integer) or np.any((group < 0) | (group >= n)):
        raise ValueError(f"leave_out must hold indices of ambiguities, 0 to {n - 1}, or groups of them; it holds {group.tolist()}")
    return group


def _columns(kept, n):
    return np.eye(n, dtype=np.int64)[:, kept]


def _symmetric(Q):
    return (Q + Q.T) / 2
