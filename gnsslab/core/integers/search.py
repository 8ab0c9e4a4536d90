"""Integer least squares: the integer vectors nearest to the float ambiguities, in the metric of their covariance.

The squared distance |a_hat - a|^2 in the metric of Q is, after decorrelation, a sum of squares that grows term by term:

    sum over k = n ... 1 of (c_k - z_k)^2 / d_k,    c_k = z_hat_k + sum over i > k of (z_i - c_i) L_ik.

c_k is the float value of z_k once z_k+1 ... z_n have been chosen. So the integers are chosen one after the other, the
last first: a tree, each level one variable. The search goes down along the nearest integers, and has a first candidate
at the bottom (this one is bootstrapping). From then on a branch whose sum reaches that of the n_best-th candidate can
only get worse, and is left; at each level the integers are tried in the order of their distance to c_k (nearest, next
on the other side, and so on: Schnorr and Euchner 1994), so the first one that is too far ends its level. When the first
level ends, nothing outside has been left untried but what the bound excludes: the candidates are proved best.
Source: Chang, Yang and Zhou (2005), J. Geodesy 79:552-565; partial sums as Ghasemmehdi and Agrell (2011).
"""

import math
from typing import NamedTuple

import numpy as np

from gnsslab.core.integers.decorrelation import GOOD, checked_covariance, checked_stack, factor, raise_status, reduce
from gnsslab.core.jit import COMPILED, integer_matrix, kernel, kernel_input, matrix, nearest

MOST_BEST = 10_000  # candidates are kept in order by insertion: as many take seconds
NODE_LIMIT = 10_000_000  # about a tenth of a second of compiled search; a solvable problem takes n to some thousand

NOT_A_FLOAT, HAS_NO_FRACTION = -1, -2
_LONGEST = 64.0  # the search needs the subdiagonal of L only; the rest is kept this small against rounding: 64 * 2^-52
NO_FRACTION = 2.0**51  # float64 of this size and more come in steps of a half or an integer


class IntegerSolution(NamedTuple):
    """The nearest integer vectors, best first.

    candidates (..., n_best, n) int64 [cycles]; norms (..., n_best) squared distances in the metric of Q, infinite where
    a search cut short has seen fewer than n_best; nodes (...) branches tried, of node_limit at most.
    """

    candidates: np.ndarray
    norms: np.ndarray
    nodes: np.ndarray
    node_limit: int

    @property
    def complete(self):
        """True (...) where the candidates are proved best; False where the node limit came first: best of those seen."""
        return self.nodes < self.node_limit

    @property
    def best(self):
        """The nearest integer vector (..., n) int64 [cycles]."""
        return self.candidates[..., 0, :]

    @property
    def ratio(self):
        """Second best over best squared norm (...); RTKLIB's way round, the inverse of the LAMBDA toolbox's."""
        if self.norms.shape[-1] < 2:
            raise ValueError("a ratio takes the two best vectors, and there is one: search with n_best=2 or more")
        with np.errstate(divide="ignore", invalid="ignore"):
            return self.norms[..., 1] / self.norms[..., 0]

    def __repr__(self):
        missed = int(np.sum(self.nodes >= self.node_limit))
        how = f"{missed} ended by the node limit, not proved best" if missed else "all searched completely"
        return f"{type(self).__name__}: {self.norms[..., 0].size} vectors of {self.candidates.shape[-1]} ambiguities, {how}"


def integer_least_squares(a_hat, Q, n_best=2, *, node_limit=NODE_LIMIT):
    """Find the n_best integer vectors a nearest to the float ambiguities a_hat.

    minimise (a_hat - a)' Q^-1 (a_hat - a) over integer a

    a_hat: (..., n) float ambiguities [cycles]; Q: (n, n) or (..., n, n) their covariance [cycles^2]. One Q with many
    a_hat is decorrelated once. Returns an IntegerSolution. Raises ValueError where shapes do not fit, where Q is no
    covariance matrix, or where a_hat is not finite.
    Source: Teunissen (1995), J. Geodesy 70:65-82 (LAMBDA).

    >>> Q = [[6.290, 5.978, 0.544], [5.978, 6.292, 2.340], [0.544, 2.340, 6.288]]     # de Jonge and Tiberius (1996)
    >>> solution = integer_least_squares([5.450, 3.100, 2.970], Q)
    >>> solution.candidates.tolist(), solution.norms.round(4).tolist()
    ([[5, 3, 4], [6, 4, 4]], [0.2183, 0.3073])
    """
    a_hat, Q = np.asarray(a_hat, dtype=np.float64), checked_covariance(Q)
    n_best, node_limit = checked_count(n_best, "n_best", MOST_BEST), checked_count(node_limit, "node_limit")
    stack, groups = _grouped(a_hat, Q)
    candidates, norms, nodes, status, problem = fix_groups(*groups, n_best, node_limit)
    if status != GOOD:
        raise_problem(status, problem, stack if Q.ndim > 2 else ())
    return _as_record(candidates, norms, nodes, (stack, n_best, Q.shape[-1]), node_limit)


def checked_count(count, name, most=2**62):
    """Return a count as int, or say that it is none, or too large."""
    if type(count) is int and 1 <= count <= most:
        return count
    if not 1 <= count < math.inf or count != int(count):
        raise ValueError(f"{name} must be a whole number, 1 or more; it is {count}.")
    if count > most:
        raise ValueError(f"{name} must be no more than {most}; it is {count}.")
    return int(count)


def _grouped(a_hat, Q):
    """Return the stack's shape, and (a (groups, m, n), Q (groups, n, n)): m vectors share each Q."""
    stack, n = checked_stack(a_hat, Q), Q.shape[-1]
    if Q.ndim == 2:
        return stack, (kernel_input(a_hat.reshape(1, -1, n)), kernel_input(Q.reshape(1, n, n)))
    a_hat, Q = np.broadcast_to(a_hat, (*stack, n)), np.broadcast_to(Q, (*stack, n, n))
    return stack, (kernel_input(a_hat.reshape(-1, 1, n)), kernel_input(Q.reshape(-1, n, n)))


def _as_record(candidates, norms, nodes, shape, node_limit):
    if not COMPILED:
        candidates, norms, nodes = np.asarray(candidates, dtype=np.int64), np.asarray(norms), np.asarray(nodes, dtype=np.int64)
    stack, n_best, n = shape
    if not stack:
        return IntegerSolution(candidates, norms[0], nodes[0, 0], node_limit)
    return IntegerSolution(candidates.reshape(*stack, n_best, n), norms.reshape(*stack, n_best), nodes.reshape(stack), node_limit)


def raise_problem(status, group, stack):
    """Turn a search's status into ValueError; `group` counts through the stack of matrices, () where there is only one."""
    if status > GOOD:
        raise_status(status, np.unravel_index(group, stack) if stack else ())
    what = {
        NOT_A_FLOAT: "contains NaN or infinity: leave out the ambiguities that were not estimated",
        HAS_NO_FRACTION: "is 2^51 cycles or more, where float64 has no fractions left: subtract an approximate integer first",
    }
    raise ValueError(f"a_hat {what[status]}.")


@kernel
def fix_groups(a, Q, n_best, node_limit):
    """Fix a (groups, m, n), the m vectors of a group sharing one of Q (groups, n, n), decorrelated once.

    Returns candidates (groups m n_best, n), norms (groups m, n_best), nodes (groups m, 1), status and, where that is
    not GOOD, the group it happened in.
    """
    groups = len(Q)
    n, m = (len(Q[0]), len(a[0])) if groups > 0 else (0, 0)
    rows = groups * m
    candidates, norms, nodes = integer_matrix(rows * n_best, n), matrix(rows, n_best), integer_matrix(rows, 1)
    M, W, S, levels = matrix(n, n + m), matrix(n, n), matrix(n, n + 1), matrix(7, n)
    d, z, c, e, step, above, stale = levels[0], levels[1], levels[2], levels[3], levels[4], levels[5], levels[6]
    for group in range(groups):
        status = split(a[group], M)
        if status == GOOD:
            status = factor(Q[group], M, W, d)
        if status == GOOD:
            status = reduce(M, W, d, _LONGEST)
        if status != GOOD:
            return candidates, norms, nodes, status, group
        for v in range(m):
            row = group * m + v
            for k in range(n):
                S[k][n] = M[k][n + v]
            nodes[row][0] = search_in_place(M, S, d, z, c, e, step, above, stale, candidates, row * n_best, norms, row, node_limit)
            for b in range(row * n_best, row * n_best + n_best):
                restore(candidates, b, a[group], v, W, z, c)
    return candidates, norms, nodes, GOOD, groups


@kernel
def split(a, M):
    """Write the fractions of a (m, n), at most half a cycle, to the last columns of M (n, n + m); returns a status.

    The integer parts are added at the end, exactly: 1e8 cycles times the entries of Z would cost digits.
    """
    for v in range(len(a)):
        a_v, n = a[v], len(M)
        for k in range(n):
            if not abs(a_v[k]) < NO_FRACTION:
                return HAS_NO_FRACTION if abs(a_v[k]) < math.inf else NOT_A_FLOAT
            M[k][n + v] = a_v[k] - nearest(a_v[k])
    return GOOD


@kernel
def restore(candidates, b, a, v, W, z, sums):
    """Replace candidate b, a vector z, by W' z plus the integer part of a_v; the arguments z and sums are scratch."""
    candidate, a_v, n = candidates[b], a[v], len(W)
    for k in range(n):
        z[k] = candidate[k]
        sums[k] = nearest(a_v[k])
    for i in range(n):
        z_i, W_i = z[i], W[i]
        for k in range(n):
            sums[k] += z_i * W_i[k]
    for k in range(n):
        candidate[k] = int(sums[k])


@kernel
def search_kernel(z_hat, L, d, n_best, node_limit):
    """Search the n_best integer vectors nearest to z_hat (n,) in the metric of L' diag(d) L, from another kernel.

    Returns candidates (n_best, n) integers, best first, norms (n_best,), nodes (complete where below node_limit).
    """
    n = len(d)
    candidates, norms = integer_matrix(n_best, n), matrix(1, n_best)
    U, S, levels = matrix(n, n), matrix(n, n + 1), matrix(6, n)
    z, c, e, step, above, stale = levels[0], levels[1], levels[2], levels[3], levels[4], levels[5]
    for i in range(n):
        S[i][n] = z_hat[i]
        for j in range(i):
            U[j][i] = L[i][j]
    nodes = search_in_place(U, S, d, z, c, e, step, above, stale, candidates, 0, norms, 0, node_limit)
    return candidates, norms[0], nodes


@kernel
def search_in_place(U, S, d, z, c, e, step, above, stale, candidates, first, all_norms, row, node_limit):
    """Search the tree; writes candidates from row `first` on, and their norms to a row; returns the nodes visited.

    Given U = L' (n, n), d, and z_hat in the last column of S (n, n + 1), whose column i holds z_hat_k plus the sum from
    i on: a level looked at again adds only the terms that changed, those up to stale_k. The other vectors (n,) are
    scratch: at each level the integer z, its float value c, e = z - c, the step to the next integer, the sum above.
    """
    norms, n, last = all_norms[row], len(S), len(all_norms[row]) - 1
    for k in range(n):
        stale[k] = n - 1
    for b in range(last + 1):
        norms[b] = math.inf
    k, nodes, norm, down = n, 0, 0.0, True
    while nodes < node_limit:
        nodes += 1
        if down:
            k -= 1
            above[k] = norm
            oldest = int(stale[k])
            for i in range(oldest, k, -1):
                S[k][i] = S[k][i + 1] + e[i] * U[k][i]
            if k > 0 and stale[k - 1] < oldest:
                stale[k - 1] = oldest
            stale[k] = k + 1
            c[k] = S[k][k + 1]
        choose_integer(z, c, step, k, down)
        e[k] = z[k] - c[k]
        norm = above[k] + e[k] * e[k] / d[k]
        down = norm < norms[last]
        if down and k == 0:
            insert(candidates, first, norms, z, norm)
            down = False
        elif not down:
            k += 1
            if k == n:
                break
    return nodes


@kernel
def choose_integer(z, c, step, k, is_first):
    """Choose z_k: first the integer nearest to c_k, then the others in the order of their distance, one side after the other."""
    if is_first:
        z[k] = nearest(c[k])
        step[k] = 1.0 if c[k] > z[k] else -1.0
    else:
        z[k] += step[k]
        step[k] = -step[k] - math.copysign(1.0, step[k])


@kernel
def insert(candidates, first, norms, z, norm):
    """Put z among the candidates, which stand in the order of their norms; the last one drops out."""
    b = len(norms) - 1
    while b > 0 and norms[b - 1] > norm:
        norms[b] = norms[b - 1]
        for k in range(len(z)):
            candidates[first + b][k] = candidates[first + b - 1][k]
        b -= 1
    norms[b] = norm
    for k in range(len(z)):
        candidates[first + b][k] = z[k]
