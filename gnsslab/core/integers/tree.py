"""The search for the nearest integers with every node written down: for looking at, not for speed.

The same search as in `search.py`, in the shortest words: the last integer first, at each level the nearest to the float value
first, and back up from whatever is as far away as the n_best-th candidate already.
"""

import math
from enum import IntEnum
from itertools import count
from typing import NamedTuple

import numpy as np

from gnsslab.core.integers.search import NO_FRACTION, checked_count

MOST_AMBIGUITIES = 12
NODE_LIMIT = 20_000  # enough to see that nobody wants to look at it


class Outcome(IntEnum):
    """What became of a node."""

    DOWN = 0  # the next level was tried below it
    CANDIDATE = 1  # at the lowest level, and nearer than the n_best-th so far
    CUT = 2  # as far as the n_best-th candidate or farther: left, with all that lies beyond


class Node(NamedTuple):
    """One integer, tried at one level."""

    level: int  # index of the ambiguity, n - 1 at the top
    parent: int  # place of the node above it in the list of nodes, -1 at the top
    integer: int  # [cycles]
    value: float  # conditional float value c that the integer is compared with [cycles]
    norm: float  # partial squared norm, of this level and those above
    bound: float  # norm of the n_best-th candidate when the node was tried, infinite at first
    outcome: Outcome


class SearchTree(NamedTuple):
    """All nodes in the order in which they were tried, and what was found."""

    nodes: tuple[Node, ...]
    candidates: np.ndarray  # (n_best, n) int64, best first
    norms: np.ndarray  # (n_best,) squared norms

    def __repr__(self):
        return f"SearchTree: {len(self.nodes)} nodes, best {self.candidates[0].tolist()} at {self.norms[0]:.3g}"


def search_tree(z_hat, L, d, n_best=2):
    """Search the n_best integer vectors nearest to z_hat in the metric of L' diag(d) L, and return every step of it.

    (z_hat - z)' Q^-1 (z_hat - z) = sum over k = n ... 1 of (z_k - c_k)^2 / d_k,    c_k = z_hat_k + sum over i > k of (z_i - c_i) L_ik

    z_hat: (n,) float values [cycles]; L: (n, n) unit lower triangular; d: (n,) conditional variances [cycles^2]. Raises
    ValueError for more than 12 ambiguities or 20 000 nodes: `integer_least_squares` is the function for those.
    Source: Teunissen (1995), J. Geodesy 70:65-82; the order at each level is that of Schnorr and Euchner (1994).

    >>> tree = search_tree([0.4, 0.2], [[1.0, 0.0], [0.5, 1.0]], [0.1, 0.4], n_best=1)
    >>> [(node.level, node.integer, round(node.value, 3), round(node.norm, 3), node.outcome.name) for node in tree.nodes[:2]]
    [(1, 0, 0.2, 0.1, 'DOWN'), (0, 0, 0.3, 1.0, 'CANDIDATE')]
    """
    z_hat, L, d = (np.asarray(array, dtype=np.float64) for array in (z_hat, L, d))
    _check(z_hat, L, d)
    search = _Search(z_hat.tolist(), L.tolist(), d.tolist(), checked_count(n_best, "n_best"))
    search.try_level(len(d) - 1, parent=-1, above=0.0)
    norms, candidates = zip(*search.found, strict=True)
    return SearchTree(tuple(search.nodes), np.array(candidates, dtype=np.int64), np.array(norms))


def _check(z_hat, L, d):
    n = d.size
    if not 1 <= n <= MOST_AMBIGUITIES:
        raise ValueError(f"search_tree is for 1 to {MOST_AMBIGUITIES} ambiguities, to look at; there are {n}: integer_least_squares takes any number")
    if d.shape != (n,) or z_hat.shape != (n,) or L.shape != (n, n):
        raise ValueError(f"z_hat, d and L must have shapes ({n},), ({n},) and ({n}, {n}); they have {z_hat.shape}, {d.shape} and {L.shape}")
    if not np.all(np.abs(z_hat) < NO_FRACTION) or not np.all((d > 0) & np.isfinite(d)):
        raise ValueError("z_hat must be finite, below 2^51 cycles, where float64 has fractions, and all conditional variances d positive")
    if not np.array_equal(np.triu(L), np.eye(n)) or not np.all(np.isfinite(L)):
        raise ValueError("L must be unit lower triangular, as of ltdl or decorrelate")


class _Search:
    """The state of one search: what has been found, what has been tried, and the integers chosen on the way down."""

    def __init__(self, z_hat, L, d, n_best):
        self.z_hat, self.L, self.d, self.n_best = z_hat, L, d, n_best
        self.nodes = []
        self.found = []  # pairs of norm and integers, best first
        self.z, self.e = [0] * len(d), [0.0] * len(d)  # the integer at each level, and how far it is from its float value

    @property
    def bound(self):
        """Norm that a candidate must stay below."""
        return self.found[-1][0] if len(self.found) == self.n_best else math.inf

    def try_level(self, k, parent, above):
        """Try the integers of level k, nearest first, below the norm of the levels above; the first one too far ends the level."""
        c = self.value(k)
        for integer in nearest_first(c):
            self.z[k], self.e[k] = integer, integer - c
            norm, bound = above + self.e[k] * self.e[k] / self.d[k], self.bound
            outcome = Outcome.CUT if norm >= bound else Outcome.CANDIDATE if k == 0 else Outcome.DOWN
            self._note(Node(k, parent, integer, c, norm, bound, outcome))
            if outcome == Outcome.CUT:
                return
            if outcome == Outcome.CANDIDATE:
                self.found = sorted([*self.found, (norm, tuple(self.z))], key=lambda one: one[0])[: self.n_best]
            else:
                self.try_level(k - 1, len(self.nodes) - 1, norm)

    def value(self, k):
        """Return the float value of level k, given the integers chosen above it."""
        c = self.z_hat[k]
        for i in range(len(self.d) - 1, k, -1):  # one after the other, as the compiled search adds them
            c += self.e[i] * self.L[i][k]
        return c

    def _note(self, node):
        if len(self.nodes) == NODE_LIMIT:
            raise ValueError(f"the tree has more than {NODE_LIMIT} nodes: too many to look at; decorrelate first, or use integer_least_squares")
        self.nodes.append(node)


def nearest_first(c):
    """Yield all integers in the order of their distance from c.

    >>> from itertools import islice
    >>> list(islice(nearest_first(2.3), 5))
    [2, 3, 1, 4, 0]
    """
    nearest = math.floor(c + 0.5)
    step = 1 if c > nearest else -1
    for k in count():
        yield nearest + (-step * (k // 2) if k % 2 == 0 else step * (k // 2 + 1))
