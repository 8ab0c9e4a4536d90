"""C-LAMBDA: integer least squares when the length of the baseline is known.

    F(a) = |a_hat - a|^2_Qa + min over |b| = l of |b(a) - b|^2_Q(b|a),    b(a) = b_hat - Q_ba Q_a^-1 (a_hat - a)

The second term is what an integer vector costs whose baseline misses the length. It takes part in the search, so it helps
to find the integers; a length used in the float solution before can do so only as far as it can be linearised.

The tree is the one of integer least squares (`search`), with the baseline as its last level. Once z_k ... z_n are chosen, b
is known with mean b_k and covariance Q_k, and every vector below costs at least

    sum over i >= k of (c_i - z_i)^2 / d_i + min over |b| = l of |b_k - b|^2_Qk,    by the secular equation (`sphere`).

A branch that reaches the bound is cut; (|b_k| - l)^2 / q_max <= the second term saves most of the equations. Two ways lead
to a bound (Teunissen, Giorgi and Buist 2011): expand a small one until it holds enough candidates, or shrink from the
cost that (|b(a)| - l)^2 / q_min promises for the nearest vectors. Either way it shrinks with each candidate found.
"""

import math
from typing import NamedTuple

import numpy as np

from gnsslab.core.covariance import check_symmetric
from gnsslab.core.integers.decorrelation import GOOD, checked_covariance
from gnsslab.core.integers.search import MOST_BEST, NODE_LIMIT, IntegerSolution, checked_count, integer_least_squares, raise_problem
from gnsslab.core.integers.sphere_search import NOT_JOINTLY_POSITIVE, fix_groups_on_sphere
from gnsslab.core.jit import kernel_input
from gnsslab.core.mixed_model import FloatSolution, given_integers

_SAFELY = 1 + 1e-9  # a bound is exclusive, and known but for rounding
_SMALLEST = 1e-9  # bound: one of zero, for integers and a length hit exactly, would hold nothing and never grow


class ConstrainedSolution(NamedTuple):
    """The best integer vectors for a baseline of known length, best first."""

    candidates: np.ndarray  # (..., n_best, n) int64 [cycles]
    norms: np.ndarray  # (..., n_best), costs F; infinite where a search cut short has seen fewer than n_best
    nodes: np.ndarray  # (...) branches tried, of node_limit at most
    node_limit: int
    baselines: np.ndarray  # (..., n_best, 3) [m], of the length given; NaN where the norm is infinite

    best = IntegerSolution.best
    ratio = IntegerSolution.ratio
    complete = IntegerSolution.complete
    __repr__ = IntegerSolution.__repr__


def constrained_integer_least_squares(a_hat, Q_a, b_hat, Q_b, Q_ba, length, n_best=2, *, node_limit=NODE_LIMIT):
    """Find the n_best integer vectors a, with their baselines b, for a baseline of known length (C-LAMBDA).

    minimise |a_hat - a|^2_Qa + |b(a) - b|^2_Q(b|a) over integer a and |b| = length,   b(a) = b_hat - Q_ba Q_a^-1 (a_hat - a)

    a_hat (..., n) [cycles] and Q_a (n, n); b_hat (..., 3) [m] and Q_b (3, 3); Q_ba (3, n): the float solution WITHOUT the
    length, else it counts twice (`fix_with_length` refuses that). Q may be stacked as a_hat is; two coordinates, or any
    number, do as well as three. Exact: the sphere by its secular equation, the integers by search, expanding the bound.
    Returns a ConstrainedSolution. Raises ValueError where shapes do not fit, the joint covariance is not positive
    definite, the length is not positive or anything is not finite.
    Source: Teunissen (2010), J. Geodesy 84:433-447; Teunissen, Giorgi and Buist (2011), GPS Solutions 15:15-28.

    Two antennas in line with a satellite, 0.3 m apart; the code says 0.4 m (sigma 0.2 m), the carrier 0.7 m (1 cm) and whole
    waves of 0.2 m. 1.5 cycles are left over: 1 and 2 fit alike, but only 2 gives 0.3 m; 5 gives -0.3 m, 3.5 sigma off the code.

    >>> found = constrained_integer_least_squares([1.5], [[1.0025]], [0.4], [[0.04]], [[-0.2]], 0.3)
    >>> found.candidates.tolist(), found.norms.round(2).tolist(), found.baselines.round(3).tolist()
    ([[2], [5]], [0.25, 12.25], [[0.3], [-0.3]])
    """
    problem = _checked(a_hat, Q_a, b_hat, Q_b, Q_ba, length)
    expected = problem.Q_a.shape[-1] + 1.0  # mean cost of the true integers: n fractions and one length
    return _search(problem, np.full(problem.a.shape[:2], 2.0 * expected), n_best, node_limit)


def constrained_by_shrinking(a_hat, Q_a, b_hat, Q_b, Q_ba, length, n_best=2, *, node_limit=NODE_LIMIT):
    """Do as `constrained_integer_least_squares`, but start with a bound that holds n_best candidates for certain (search and shrink).

    F(a) <= |a_hat - a|^2_Qa + (|b(a)| - l)^2 / q_min,    q_min the smallest eigenvalue of Q(b|a)

    The nearest n_best vectors of plain integer least squares give the bound. Same answers; quick where plain least
    squares is nearly right, slow where it is not.
    Source: Teunissen, Giorgi and Buist (2011), GPS Solutions 15:15-28.
    """
    problem = _checked(a_hat, Q_a, b_hat, Q_b, Q_ba, length)
    return _search(problem, _certain_bounds(problem, n_best, node_limit), n_best, node_limit)


def fix_with_length(solution, length, n_best=2):
    """Return the ConstrainedSolution of a FloatSolution whose baseline has a known length [m].

    Raises ValueError where the float solution has used the length already: it would count twice.
    """
    if solution.length_used:
        raise ValueError(
            "this float solution has used the known length already, and the search would count it a second time: "
            "fix the float solution without it, or fix this one by integer_least_squares"
        )
    a_hat, b_hat, Q_a, Q_b, Q_ba, _ = solution
    return constrained_integer_least_squares(a_hat, Q_a, b_hat, Q_b, Q_ba, length, n_best)


class _Problem(NamedTuple):
    """Groups g of m float solutions that share one covariance each."""

    a: np.ndarray  # (g, m, n) [cycles]
    Q_a: np.ndarray  # (g, n, n)
    b: np.ndarray  # (g, m, p) [m]
    Q_b: np.ndarray  # (g, p, p)
    Q_ba: np.ndarray  # (g, p, n)
    length: float  # [m]
    stack: tuple[int, ...]


def _checked(a_hat, Q_a, b_hat, Q_b, Q_ba, length):
    """Return the _Problem, or say what does not fit."""
    a_hat, b_hat, Q_b, Q_ba = (np.asarray(array, dtype=np.float64) for array in (a_hat, b_hat, Q_b, Q_ba))
    Q_a = checked_covariance(Q_a)
    n, p = Q_a.shape[-1], b_hat.shape[-1] if b_hat.ndim else 0
    for name, array, shape in (("a_hat", a_hat, (n,)), ("b_hat", b_hat, (p,)), ("Q_b", Q_b, (p, p)), ("Q_ba", Q_ba, (p, n))):
        _check_array(name, array, shape)
    check_symmetric(Q_b, "Q_b")
    if not (np.ndim(length) == 0 and 0 < length < math.inf):
        raise ValueError(f"the length must be one positive number of metres; it is {length}")
    return _grouped(a_hat, Q_a, b_hat, Q_b, Q_ba, float(length))


def _check_array(name, array, shape):
    if 0 in shape or array.shape[-len(shape) :] != shape:
        raise ValueError(f"{name} must have shape {shape} in its last axes, as the others have it; it has shape {array.shape}")
    if not np.all(np.isfinite(array)):
        raise ValueError(f"{name} contains NaN or infinity: leave out what was not estimated")


def _grouped(a_hat, Q_a, b_hat, Q_b, Q_ba, length):
    """Return the _Problem: one group where one covariance serves all, else a group each."""
    stacks = [array.shape[:-1] for array in (a_hat, b_hat)] + [array.shape[:-2] for array in (Q_a, Q_b, Q_ba)]
    try:
        stack, stack_Q = np.broadcast_shapes(*stacks), np.broadcast_shapes(*stacks[2:])
    except ValueError:
        raise ValueError(f"the stacks of a_hat, b_hat, Q_a, Q_b and Q_ba do not fit: they are {stacks}") from None
    leading = (-1, 1) if stack_Q else (1, -1)
    vectors = (np.broadcast_to(array, (*stack, array.shape[-1])).reshape(*leading, array.shape[-1]) for array in (a_hat, b_hat))
    shared = stack if stack_Q else (1,)
    matrices = (np.broadcast_to(array, (*shared, *array.shape[-2:])).reshape(-1, *array.shape[-2:]) for array in (Q_a, Q_b, Q_ba))
    (a, b), (Q_a, Q_b, Q_ba) = vectors, matrices
    return _Problem(a, Q_a, b, Q_b, Q_ba, length, stack)


def _search(problem, bounds, n_best, node_limit):
    """Return the ConstrainedSolution found from first bounds (g, m)."""
    n_best, node_limit = checked_count(n_best, "n_best", MOST_BEST), checked_count(node_limit, "node_limit")
    arrays = [kernel_input(array) for array in problem[:5]]
    candidates, norms, nodes, baselines, status, group = fix_groups_on_sphere(*arrays, problem.length, kernel_input(bounds), n_best, node_limit)
    if status != GOOD:
        _raise(status, group, problem.stack if len(problem.Q_a) > 1 else ())
    n, p = problem.Q_ba.shape[-1], problem.b.shape[-1]
    return ConstrainedSolution(
        candidates=np.asarray(candidates, dtype=np.int64).reshape(*problem.stack, n_best, n),
        norms=np.asarray(norms).reshape(*problem.stack, n_best),
        nodes=np.asarray(nodes, dtype=np.int64).reshape(problem.stack),
        node_limit=node_limit,
        baselines=np.asarray(baselines).reshape(*problem.stack, n_best, p),
    )


def _raise(status, group, stack):
    if status == NOT_JOINTLY_POSITIVE:
        raise ValueError(
            "Q_a, Q_b and Q_ba are not positive definite together: all three must come from one float solution that knows nothing of the length"
        )
    raise_problem(status, group, stack)


def _certain_bounds(problem, n_best, node_limit):
    """Return bounds (g, m) below which n_best vectors cost for certain: the cost promised for those of plain least squares."""
    near = integer_least_squares(problem.a, problem.Q_a[:, None], n_best, node_limit=node_limit)
    shared = FloatSolution(problem.a[..., None, :], problem.b[..., None, :], *(Q[:, None, None] for Q in (problem.Q_a, problem.Q_b, problem.Q_ba)))
    baselines, Q_b_fix = given_integers(shared, near.candidates)
    off = np.linalg.norm(baselines, axis=-1) - problem.length  # (g, m, n_best)
    promised = near.norms + off**2 / np.linalg.eigvalsh(Q_b_fix)[..., 0]
    return np.maximum(promised.max(axis=-1) * _SAFELY, _SMALLEST)
