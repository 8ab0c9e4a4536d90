"""MC-LAMBDA: integer least squares when several baselines belong to one rigid body.

    F(a) = |a_hat - a|^2_Qa + min over rotations R of |b(a) - (R f_1, ..., R f_k)|^2_Q(b|a),    b(a) = b_hat - Q_ba Q_a^-1 (a_hat - a)

f_i are the known baselines in the body frame. All lengths and all angles between the baselines take part in the search, with the full
covariance: baselines that share an antenna are correlated.

1. The baselines become the rho axes they span (`nearest_rotation`). Antennas in line or more than three baselines leave combinations of
   b_hat that are zero for any rotation: measurements, by which the float solution is improved first.
2. The integers are decorrelated baseline by baseline, and searched one baseline after the other: once the first baseline is known,
   its length has been asked for, and at the second the angle between them.
3. Below a node with z_k ... z_n chosen every vector costs at least sum over i >= k of (c_i - z_i)^2 / d_i and the distance of u, given these
   integers, from any orthonormal frame. At the bottom that distance is found itself; in the cases that its lower bound does not prove, it is
   the lowest of the minima found from 25 starts (`nearest_frame`).
4. The bound expands until n_best vectors cost less. Each round finished proves what it has found.

The second best vector often costs ten to thirty times as much as the best, and the search for it takes nearly all of the time: ask for
n_best=1 where the ratio is not wanted. With three baselines the node limit mostly comes first; then the ratio is a lower bound.
"""

from typing import NamedTuple

import numpy as np

from gnsslab.core.integers.decorrelation import Decorrelation, decorrelate, ltdl
from gnsslab.core.integers.frame_search import search_frames
from gnsslab.core.integers.search import checked_count
from gnsslab.core.jit import kernel_input
from gnsslab.core.nearest_frame import rotations_of_the_cube
from gnsslab.core.nearest_rotation import body_axes, checked_body, frame_near, rotation_of_frame

NODE_LIMIT = 100_000  # about a fifth of a second of compiled search: the best needs 50 to 1000, the second of two baselines some 10 000
_GROWTH = 1.5  # of the bound: one too large by this costs 1.5^(n/2) times the nodes, one too small another round
_ASYMMETRY = 1e-8  # |Q_ij - Q_ji| / sqrt(Q_ii Q_jj): rounding stays below, a wrong formula does not
_NO_FRACTION = 2.0**51  # float64 of this size and more come in steps of a half or an integer


class AttitudeSolution(NamedTuple):
    """The best integer vectors for the baselines of a rigid body, best first."""

    candidates: np.ndarray  # (..., n_best, n) int64 [cycles]
    norms: np.ndarray  # (..., n_best), costs F; infinite where the node limit came before so many were found
    nodes: np.ndarray  # (...) branches tried, of node_limit at most
    node_limit: int
    rotations: np.ndarray  # (..., n_best, 3, 3), b_i = R f_i; NaN where the norm is infinite
    baselines: np.ndarray  # (..., n_best, k, 3) [m], the R f_i
    searched: np.ndarray  # (...) every vector that is not among the candidates costs at least this

    @property
    def complete(self):
        """True (...) where all candidates are proved best; False where the node limit came first."""
        return self.norms[..., -1] <= self.searched

    @property
    def is_best_proved(self):
        """True (...) where the first candidate is proved best; the others may not be."""
        return self.norms[..., 0] <= self.searched

    @property
    def best(self):
        """The best integer vector (..., n) int64 [cycles]."""
        return self.candidates[..., 0, :]

    @property
    def ratio(self):
        """Second best over best cost (...); where the second was not found in time, the ratio is at least this."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.minimum(self.norms[..., 1:].min(axis=-1, initial=np.inf), self.searched) / self.norms[..., 0]

    def __repr__(self):
        missed, unsure = int(np.sum(~self.complete)), int(np.sum(~self.is_best_proved))
        how = f"{missed} ended by the node limit, {unsure} of them before the best was proved" if missed else "all searched completely"
        return f"AttitudeSolution: {self.nodes.size} vectors of {self.candidates.shape[-1]} ambiguities, {how}"


def attitude_integer_least_squares(a_hat, Q_a, b_hat, Q_b, Q_ba, body, n_best=2, *, node_limit=NODE_LIMIT):
    """Find the n_best integer vectors a, with their rotations, for baselines b_i = R f_i of a rigid body (MC-LAMBDA).

    minimise |a_hat - a|^2_Qa + |b(a) - (R f_1, ..., R f_k)|^2_Q(b|a) over integer a and rotations R

    a_hat (..., n) [cycles], best baseline by baseline (any other order costs time only), Q_a (n, n); b_hat (..., k, 3) [m],
    Q_b (3k, 3k) and Q_ba (3k, n), baseline by baseline; body: the f_i (k, 3) [m]. The float solution must know nothing of
    lengths and angles, else they count twice. One baseline is C-LAMBDA (`constrained_integer_least_squares` is quicker).
    Returns an AttitudeSolution. Raises ValueError where shapes do not fit, the joint covariance is not positive definite,
    antennas are in one place or anything is not finite.
    Source: Teunissen (2007), Artificial Satellites 42:97-111; Giorgi, Teunissen, Verhagen and Buist (2010), Adv. Space Res. 46:118-129.

    Antennas a metre east and a metre north of a third; carriers of 0.2 m from the east for the one, from the north for the other.
    To the float 5.5 cycles 5 and 6 are equally near, but only 6 make the first baseline, 1.1 m by the code, a metre long:

    >>> body, Q_ba = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], np.zeros((6, 2))
    >>> Q_ba[0, 0] = Q_ba[4, 1] = -0.2
    >>> found = attitude_integer_least_squares(
    ...     [5.5, 5.0], 1.0025 * np.eye(2), [[1.1, 0.0, 0.0], [0.0, 1.0, 0.0]], 0.04 * np.eye(6), Q_ba, body)
    >>> found.best.tolist(), found.norms[:1].round(4).tolist(), found.baselines[0].round(3).tolist()
    ([6, 5], [0.25], [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    """
    n_best, node_limit = checked_count(n_best, "n_best"), checked_count(node_limit, "node_limit")
    problem = _checked(a_hat, Q_a, b_hat, Q_b, Q_ba, checked_body(body))
    axes = body_axes(problem.body)
    x, Q, rest = _in_axes(problem, axes.X)
    tree = _grown(Q, problem.n, len(problem.body))
    found = [_search(tree, x_v, n_best, node_limit) for x_v in x]
    return _record(found, rest, problem, axes, n_best, node_limit)


class _Problem(NamedTuple):
    """Float solutions (m, n + 3k) that share one covariance, and the shape of their stack."""

    x: np.ndarray  # (m, n + 3k), ambiguities and baselines
    Q: np.ndarray  # (n + 3k, n + 3k)
    n: int
    body: np.ndarray  # (k, 3) [m]
    stack: tuple[int, ...]


class _Tree(NamedTuple):
    """What all float solutions of one covariance share in the search; levels are searched from the last to the first."""

    Z: np.ndarray  # (n, n) int64, z = Z' a
    inverse: np.ndarray  # (n, n) int64, of Z
    L: np.ndarray  # (n, n), Q_z = L' diag(d) L
    G: np.ndarray  # (n, 3 rho), what z_k - c_k moves the axes u
    weights: np.ndarray  # (n, 3 rho, 3 rho) of u given z_k ... z_n
    kernel_inputs: list  # d (n,), G, weights and q_max (n,), the largest eigenvalues of their inverses


class _Found(NamedTuple):
    """What the search for one float solution came to."""

    a: np.ndarray  # (count, n) int64 [cycles]
    norms: np.ndarray  # (count,)
    frames: np.ndarray  # (count, 3, 3), axes as rows
    nodes: int
    searched: float


def _checked(a_hat, Q_a, b_hat, Q_b, Q_ba, body):
    """Return the _Problem, or say what does not fit."""
    a_hat, b_hat, Q_a, Q_b, Q_ba = (np.asarray(array, dtype=np.float64) for array in (a_hat, b_hat, Q_a, Q_b, Q_ba))
    n, k = (Q_a.shape[-1] if Q_a.ndim else 0), len(body)
    for name, array, shape in (("Q_a", Q_a, (n, n)), ("Q_b", Q_b, (3 * k, 3 * k)), ("Q_ba", Q_ba, (3 * k, n))):
        if array.shape != shape or n == 0:
            raise ValueError(f"{name} must have shape {shape} for {n} ambiguities and {k} baselines of the body; it has shape {array.shape}.")
    for name, array, shape in (("a_hat", a_hat, (n,)), ("b_hat", b_hat, (k, 3))):
        if array.shape[-len(shape) :] != shape:
            raise ValueError(f"{name} must have shape {shape} in its last axes, as Q_a and the body have it; it has shape {array.shape}.")
    if a_hat.shape[:-1] != b_hat.shape[:-2]:
        raise ValueError(f"a_hat {a_hat.shape} and b_hat {b_hat.shape} must be stacked alike, one float solution each.")
    x = np.concatenate([a_hat, b_hat.reshape(*a_hat.shape[:-1], 3 * k)], axis=-1)
    Q = np.block([[Q_a, Q_ba.T], [Q_ba, Q_b]])
    _check_values(x, Q, n)
    return _Problem(x.reshape(-1, n + 3 * k), 0.5 * (Q + Q.T), n, body, a_hat.shape[:-1])


def _check_values(x, Q, n):
    if not (np.all(np.isfinite(x)) and np.all(np.isfinite(Q))):
        raise ValueError("a_hat, b_hat and their covariances must be finite; they contain NaN or infinity: leave out what was not estimated.")
    if np.any(np.abs(x[..., :n]) >= _NO_FRACTION):
        raise ValueError("a_hat is 2^51 cycles or more, where float64 has no fractions left: subtract an approximate integer first.")
    if np.any(np.abs(Q - Q.T) > _ASYMMETRY * np.sqrt(np.abs(np.outer(np.diag(Q), np.diag(Q))))):
        raise ValueError("Q_a or Q_b is not symmetric; a covariance matrix is, so look at how it was made.")
    try:
        np.linalg.cholesky(0.5 * (Q + Q.T))
    except np.linalg.LinAlgError:
        raise ValueError(
            "Q_a, Q_b and Q_ba are not positive definite together: all three must come from one float solution that knows nothing of the body"
        ) from None


def _in_axes(problem, X):
    """Return float solutions (m, n + 3 rho) and covariance of ambiguities and axes u, and what each costs for certain (m,).

    b = (X x I) u. What is left over of b, N b with N X = 0, is zero in truth: x <- x - Q_xw Q_w^-1 w, w = N b, at the cost w' Q_w^-1 w.
    """
    x, Q, n = problem.x, problem.Q, problem.n
    rho, wide = X.shape[1], np.linalg.qr(X, mode="complete")
    left = np.linalg.solve(wide.R[:rho], wide.Q[:, :rho].T)  # (rho, k), left X = I
    to_axes = _block(np.eye(n), np.kron(left, np.eye(3)))
    zero = np.hstack([np.zeros((3 * (len(X) - rho), n)), np.kron(wide.Q[:, rho:].T, np.eye(3))])
    Q_wx, w = zero @ Q, x @ zero.T
    gain = np.linalg.solve(Q_wx @ zero.T, Q_wx)  # (rows of w, n + 3k)
    cost = np.vecdot(w, np.linalg.solve(Q_wx @ zero.T, w.T).T)
    Q_u = to_axes @ (Q - Q_wx.T @ gain) @ to_axes.T
    return (x - w @ gain) @ to_axes.T, 0.5 * (Q_u + Q_u.T), cost


def _block(upper, lower):
    return np.block([[upper, np.zeros((len(upper), lower.shape[1]))], [np.zeros((len(lower), upper.shape[1])), lower]])


def _grown(Q, n, k):
    """Return the _Tree of the joint covariance Q of n ambiguities, those of k baselines one after the other, and axes."""
    Z = _decorrelated_in_parts(Q[:n, :n], np.array_split(np.arange(n), k))
    L, d = ltdl(Z.T @ Q[:n, :n] @ Z)
    G = np.linalg.solve(L.T * d, Z.T @ Q[:n, n:])  # L' diag(d) G = Q_zu
    known = d[:, None, None] * G[:, :, None] * G[:, None, :]  # (n, p, p), what one more integer takes off the covariance
    spread = Q[n:, n:] - np.cumsum(known[::-1], axis=0)[::-1]
    weights, q_max = np.linalg.inv(spread), np.linalg.eigvalsh(spread)[:, -1]
    return _Tree(Z, Decorrelation(Z, L, d).inverse, L, G, weights, [kernel_input(array) for array in (d, G, weights, q_max)])


def _decorrelated_in_parts(Q, parts):
    """Return Z (n, n) that decorrelates each part of the ambiguities given the parts before; the first part comes last, so it is searched first."""
    Z, rest, end = np.zeros(Q.shape, dtype=np.int64), Q, len(Q)
    for part in (part for part in parts if len(part)):
        inside = rest[np.ix_(part, part)]
        Z[part, end - len(part) : end] = decorrelate(0.5 * (inside + inside.T)).Z
        rest = rest - rest[:, part] @ np.linalg.solve(inside, rest[part])
        end -= len(part)
    return Z


def _search(tree, x, n_best, node_limit):
    """Return what was _Found for one float solution x (n + 3 rho,)."""
    n = len(tree.Z)
    shift, u_hat = np.rint(x[:n]), x[n:]
    z_hat = tree.Z.T @ (x[:n] - shift)
    z, norms, nodes, searched = _expanded(tree, z_hat, u_hat, n_best, node_limit)
    u = u_hat + np.linalg.solve(tree.L.T, (z - z_hat).T).T @ tree.G  # (count, 3 rho), given the integers
    frames = np.reshape([frame_near(u_i, tree.weights[0])[0] for u_i in u], (-1, 3, 3))
    return _Found(z @ tree.inverse + shift.astype(np.int64), norms, frames, nodes, searched)


def _expanded(tree, z_hat, u_hat, n_best, node_limit):
    """Return z (count, n) and costs (count,) of the vectors below a bound that expands until there are n_best, the nodes, and what is searched."""
    problem = [kernel_input(np.column_stack([tree.L.T, z_hat])), *tree.kernel_inputs, kernel_input(u_hat), rotations_of_the_cube()]
    bound, nodes, searched, count = float(len(z_hat) + _conditions(u_hat)), 0, 0.0, 0  # first the mean cost of the true integers
    while nodes < node_limit and count < n_best:
        latest = search_frames(*problem, bound, n_best, node_limit - nodes)
        nodes += latest[-1]
        is_finished = nodes < node_limit
        if is_finished or count == 0:
            z, norms, count = np.asarray(latest[0], dtype=np.int64), np.asarray(latest[1]), latest[2]
        if is_finished:
            searched = bound if count < n_best else norms[-1]
        bound *= _GROWTH
    return z[:count], norms[:count], nodes, searched


def _conditions(u):
    """Return how many conditions make the axes u (3 rho,) an orthonormal frame: 1, 3 or 6."""
    rho = len(u) // 3
    return rho * (rho + 1) // 2


def _record(found, rest, problem, axes, n_best, node_limit):
    """Return the AttitudeSolution of what was _Found for each float solution; what was not found has an infinite norm."""
    m, n = len(found), problem.n
    candidates, norms = np.empty((m, n_best, n), dtype=np.int64), np.full((m, n_best), np.inf)
    R = np.full((m, n_best, 3, 3), np.nan)
    for v, one in enumerate(found):
        count = len(one.norms)
        candidates[v] = np.rint(problem.x[v, :n])
        candidates[v, :count], norms[v, :count] = one.a, one.norms + rest[v]
        R[v, :count] = rotation_of_frame(one.frames, axes.T)

    def shape(array):
        return array.reshape((*problem.stack, *array.shape[1:]))

    return AttitudeSolution(
        candidates=shape(candidates),
        norms=shape(norms),
        nodes=shape(np.array([one.nodes for one in found])),
        node_limit=node_limit,
        rotations=shape(R),
        baselines=shape(problem.body @ R.mT),
        searched=shape(rest + [one.searched for one in found]),
    )
