"""Pull-in regions: the float vectors that an estimator takes to the same integers.

Each is cut out by pairs of parallel planes, contains its own integers in the middle, has volume 1, and looks the same
about all integers: a cube for rounding, a parallelepiped for bootstrapping; for least squares all that is nearer to its
integers than to any others in the metric of Q, in the plane a hexagon.
"""

import itertools
from typing import NamedTuple

import numpy as np
from scipy.special import erf

from gnsslab.core.integers.search import integer_least_squares

MOST_AMBIGUITIES = 10  # 2^10 pairs of planes
DIRECTIONS = 20_000  # in which the mass inside is summed: good to 1e-4 for needles of 1 to 50


class PullInRegion(NamedTuple):
    """{x: |normals x| <= bounds}, the float vectors taken to zero; those taken to z are the same, moved by z."""

    normals: np.ndarray  # (k, n)
    bounds: np.ndarray  # (k,)

    def contains(self, x):
        """Return whether x (..., n) lies inside or on the edge."""
        return np.all(np.abs(x @ self.normals.T) <= self.bounds, axis=-1)


def rounding_region(n):
    """Return the PullInRegion of rounding: |x_k| <= 1/2.

    >>> rounding_region(2).contains([[0.4, -0.4], [0.6, 0.0]]).tolist()
    [True, False]
    """
    return PullInRegion(np.eye(n), np.full(n, 0.5))


def bootstrapping_region(L):
    """Return the PullInRegion of bootstrapping, last ambiguity first, with Q = L' diag(d) L: |(L'^-1 x)_k| <= 1/2.

    Source: Teunissen (1998), J. Geodesy 72:606-612.

    >>> bootstrapping_region([[1.0, 0.0], [2.0, 1.0]]).contains([[0.9, 0.4], [0.1, 0.4]]).tolist()
    [True, False]
    """
    L = np.asarray(L, dtype=np.float64)
    return PullInRegion(np.linalg.inv(L.T), np.full(len(L), 0.5))


def least_squares_region(Q):
    """Return the PullInRegion of integer least squares in the metric of Q (n, n): |v' Q^-1 x| <= v' Q^-1 v / 2.

    v runs through the shortest vector of each kind of integers, even and odd ones mixed in the same way: 2^n - 1 of them
    (Voronoi 1908). It is found as twice the way from half such a vector to the nearest integers.
    Raises ValueError for more than 10 ambiguities. Source: Agrell, Eriksson, Vardy and Zeger (2002), IEEE Trans. Inf. Theory 48:2201-2214.

    >>> least_squares_region([[1.0, 0.6], [0.6, 1.0]]).contains([[0.5, 0.5], [0.4, -0.4]]).tolist()
    [True, False]
    """
    Q = np.asarray(Q, dtype=np.float64)
    n = len(Q)
    if n > MOST_AMBIGUITIES:
        raise ValueError(f"least_squares_region is for {MOST_AMBIGUITIES} ambiguities at most; there are {n}, with up to 2^{n} planes")
    halves = np.array(list(itertools.product((0.0, 0.5), repeat=n))[1:])  # (2^n - 1, n)
    v = 2 * (halves - integer_least_squares(halves, Q, n_best=1).best)
    normals = np.linalg.solve(Q, v.T).T
    return PullInRegion(normals, 0.5 * np.vecdot(normals, v))


def corners_of(region):
    """Return the corners (v, 2) of a region of two ambiguities, one after the other around it.

    >>> corners_of(rounding_region(2)).tolist()
    [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]]
    """
    if region.normals.shape[1] != 2:
        raise ValueError(f"a polygon has two coordinates; this region has {region.normals.shape[1]}")
    signs = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    corners = np.linalg.solve(region.normals[:2], (signs * region.bounds[:2]).T).T
    for normal, bound in zip(region.normals[2:], region.bounds[2:], strict=True):
        corners = _clipped(_clipped(corners, normal, bound), -normal, bound)
    return corners


def _clipped(corners, normal, bound):
    """Return the part of a convex polygon with normal' x <= bound (Sutherland and Hodgman 1974)."""
    beyond = corners @ normal - bound
    kept = []
    for here, there, a, b in zip(corners, np.roll(corners, -1, axis=0), beyond, np.roll(beyond, -1), strict=True):
        if a <= 0:
            kept.append(here)
        if min(a, b) < 0 < max(a, b):
            kept.append(here + (there - here) * (a / (a - b)))
    return np.array(kept)


def chance_inside(region, Q):
    """Return the probability that a float vector about zero with covariance Q lies in a region: the success rate of its estimator.

    P = mean over directions u of F(r(u)),    r(u) = min over k of bounds_k / |normals_k' C u|,    C C' = Q

    F is the distribution of the length of n standard normal numbers, r(u) how far it is to the edge. For two or three
    ambiguities; raises ValueError for others.

    >>> round(float(chance_inside(rounding_region(2), [[0.25, 0.0], [0.0, 0.25]])), 4)       # 0.6827^2
    0.4661
    """
    n = region.normals.shape[1]
    if n not in (2, 3):
        raise ValueError(f"chance_inside is for two or three ambiguities; there are {n}: simulate the others")
    u = _circle() if n == 2 else _sphere()
    with np.errstate(divide="ignore"):
        r = np.min(region.bounds / np.abs(u @ (region.normals @ np.linalg.cholesky(Q)).T), axis=1)
    return np.mean(1 - np.exp(-0.5 * r**2) if n == 2 else erf(r / np.sqrt(2)) - np.sqrt(2 / np.pi) * r * np.exp(-0.5 * r**2))


def _circle():
    """Return directions (k, 2), evenly spread; those opposite are left out, as the regions are symmetric."""
    angle = np.pi * (np.arange(DIRECTIONS) + 0.5) / DIRECTIONS
    return np.column_stack([np.cos(angle), np.sin(angle)])


def _sphere():
    """Return directions (k, 3), evenly spread along a spiral from pole to pole."""
    height = 1 - (2 * np.arange(DIRECTIONS) + 1) / DIRECTIONS
    turn = np.pi * (3 - np.sqrt(5)) * np.arange(DIRECTIONS)
    radius = np.sqrt(1 - height**2)
    return np.column_stack([radius * np.cos(turn), radius * np.sin(turn), height])
