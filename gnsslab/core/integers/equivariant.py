"""Best integer equivariant estimation: not one integer vector, but the mean of all, each with its probability as weight.

Fixing is right or wrong. The mean is never quite either: with precise data one vector has all the weight and the mean is
the fix; with poor data the weights are even and the mean is the float solution; in between its mean squared error is
less than that of both.

Two bounds make the infinite sum a short one, with a neglected share of the weight that is stated:

* Integer vectors farther than |a_hat - z|^2 = R^2 are left out. Their share of the weight is at most
  exp(q / 2) (R^2 / n)^(n/2) exp((n - R^2) / 2), for R^2 >= n and q the squared distance of the nearest: Chernoff's bound
  of the chi-square tail, which holds for sums over integers too, as all weights taken about an integer vector sum up to
  more than about any other point, and to less than exp(q / 2) times the sum about a_hat (Banaszczyk 1993, Math. Ann. 296:625-635).
* A variable whose conditional variance d_k is large, given those fixed before it, has so many integers with weight that their
  sum is an integral, up to 2 exp(-2 pi^2 d_k) of it (Poisson's summation). There the mean is c_k, the conditional float value.
"""

import math
from typing import NamedTuple

import numpy as np
from scipy.special import gammaln

from gnsslab.core.integers.decorrelation import checked_problem, decorrelate
from gnsslab.core.integers.rounding import integer_rounding
from gnsslab.core.integers.search import integer_least_squares
from gnsslab.core.jit import kernel, kernel_input, matrix

MOST_INTEGERS = 1_000_000  # about 20 ms of compiled summation for each float vector


class EquivariantSolution(NamedTuple):
    """Means of integer vectors, weighted with their probabilities."""

    a: np.ndarray  # (..., n) real [cycles]
    integers: np.ndarray  # (...) how many integer vectors were summed; 1 where all variables are summed as integrals
    greatest_weight: np.ndarray  # (...) of one integer vector, the nearest: near 1 the mean is as good as a fix; NaN where it is not known
    neglected: np.ndarray  # (...) bound on the share of the weight that was left out
    asked: float  # the neglected share asked for

    @property
    def complete(self):
        """True (...) where no more is neglected than asked; False where that took more integer vectors than allowed."""
        return self.neglected <= self.asked

    def __repr__(self):
        cut = int(np.sum(~np.asarray(self.complete)))
        limit = f"{cut} cut short by the limit on integer vectors" if cut else "all complete"
        average = np.sum(self.integers) / max(self.integers.size, 1)
        return f"EquivariantSolution: {self.integers.size} means of {average:.0f} integer vectors on average, {limit}"


def best_integer_equivariant(a_hat, Q, *, neglected=1e-6, most_integers=MOST_INTEGERS):
    """Return the mean of all integer vectors, weighted with their probability given the float ambiguities a_hat.

    a = sum z w_z / sum w_z,    w_z = exp(-(a_hat - z)' Q^-1 (a_hat - z) / 2),    over all integer z

    a_hat: (..., n) [cycles]; Q: (n, n) [cycles^2]. neglected: the largest share of the weight to leave out; where that
    takes more than about most_integers vectors, the nearest ones are summed and `complete` is False; where not even the nearest
    is found within the node limit of `integer_least_squares`, a is the nearest one seen. The mean squared error of a,
    and of b = `given_integers(solution, a)`, is the least that any estimator reaches which follows a shift by integers:
    least squares and float are such estimators. Returns an EquivariantSolution. Raises ValueError where shapes do not
    fit, Q is no covariance matrix, or a_hat is not finite.
    Source: Teunissen (2003), J. Geodesy 77:402-410.

    >>> best_integer_equivariant([0.4], [[0.25]]).a.round(3).tolist()      # -1, 0, 1, 2 have weights 0.02, 0.73, 0.49, 0.01
    [0.387]
    """
    a_hat, Q = checked_problem(a_hat, Q)
    _check(neglected, most_integers)
    whole = integer_rounding(a_hat)
    fraction = (a_hat - whole).reshape(-1, len(Q))  # (N, n)
    near, decorrelation = integer_least_squares(fraction, Q, n_best=1), decorrelate(Q)
    flat = int(np.argmin([*_is_flat(decorrelation.d, neglected), False]))  # so many variables, the first, are summed as integrals
    N, proved = len(fraction), near.complete | (flat == len(Q))
    mean, count, weight, lost = near.best.astype(np.float64), np.ones(N, dtype=np.int64), np.full(N, np.nan), np.ones(N)
    means = _means(fraction[proved], near.norms[proved, 0], decorrelation, flat, neglected, most_integers)
    mean[proved], count[proved], weight[proved], lost[proved] = means
    stack = a_hat.shape[:-1]
    return EquivariantSolution(
        a=whole + mean.reshape(a_hat.shape),
        integers=count.reshape(stack)[()],
        greatest_weight=weight.reshape(stack)[()],
        neglected=lost.reshape(stack)[()],
        asked=neglected,
    )


def _means(fraction, q, decorrelation, flat, neglected, most_integers):
    """Return the means (N, n) about the float vectors `fraction` (N, n), counts, greatest weights and neglected shares (N,).

    q: (N,) squared distance of the nearest vector; the first `flat` variables are summed as integrals.
    """
    Z, L, d = decorrelation
    R2, lost = _bounds(q, d[flat:], neglected / 2, most_integers)
    e, total, count = sum_integers(*map(kernel_input, ((fraction @ Z)[:, flat:], L[flat:, flat:], d[flat:], q, R2)))
    e = np.reshape(e, (len(q), len(d) - flat))
    mean = fraction + e @ L[flat:] @ decorrelation.inverse  # z - z_hat = L' e
    weight = 1.0 / np.asarray(total) / np.prod(np.sqrt(2 * math.pi * d[:flat]))
    return mean, np.asarray(count), weight, np.minimum(lost + np.sum(_share_of_waves(d[:flat])), 1.0)


def _share_of_waves(d):
    """Return by how much, at most, the sum over a variable's integers differs from the integral."""
    return 2.0 * np.exp(-2.0 * math.pi**2 * d)


def _is_flat(d, neglected):
    return _share_of_waves(d) <= neglected / (2 * len(d))


def _bounds(q, d, neglected, most_integers):
    """Return the bounds R^2 (N,) on the squared distance, and what the vectors beyond them weigh at most.

    x - ln x - 1 = (q - 2 ln p) / n,  x = R^2 / n,  p the neglected share; but no more than ellipsoids that hold
    about most_integers vectors: of all variables and, as the tree has to be walked, of the last one, two, three ...; their
    volumes are pi^(j/2) / Gamma(j/2 + 1) R^j prod over the last j of sigma_i.
    """
    n = len(d)
    if n == 0:
        return q, np.zeros_like(q)
    s = (q - 2.0 * math.log(neglected)) / n
    x = 1.0 + s + np.sqrt(2.0 * s)  # to the right of the solution, from where Newton's steps do not overshoot
    for _ in range(8):
        x -= (x - np.log(x) - 1.0 - s) / (1.0 - 1.0 / x)
    j = np.arange(1, n + 1)
    log_volume = 0.5 * j * math.log(math.pi) - gammaln(0.5 * j + 1.0) + 0.5 * np.cumsum(np.log(d[::-1]))
    affordable = np.exp(np.min(2.0 / j * (math.log(most_integers) - log_volume)))
    R2 = np.maximum(np.minimum(n * x, affordable), q * (1.0 + 1e-9) + 1e-9)  # the nearest is always in
    x = np.maximum(R2 / n, 1.0)
    return R2, np.minimum(np.exp(0.5 * q - 0.5 * n * (x - np.log(x) - 1.0)), 1.0)


def _check(neglected, most_integers):
    if not 1e-15 <= neglected < 1:
        raise ValueError(f"neglected is a share of the weight, from 1e-15, which is rounding, to 1; it is {neglected:g}")
    if not most_integers >= 1:
        raise ValueError(f"most_integers must be 1 or more; it is {most_integers:g}")


@kernel
def sum_integers(z_hat, L, d, q, bounds):
    """Sum over the integer vectors within the bounds (N,) of z_hat (N, n), in the metric of L' diag(d) L.

    Returns the weighted means of e_k = z_k - c_k (N, n), c_k the value of z_k given those after it, the sums of the
    weights exp((q - norm) / 2), and the counts (N,).
    """
    N, n = len(z_hat), len(d)
    means, result, levels = matrix(N, n), matrix(2, N), matrix(6, n + 1)
    for v in range(N):
        result[1][v] = walk(z_hat[v], L, d, q[v], bounds[v], means[v], levels[0], levels[1], levels[2], levels[3], levels[4], levels[5])
        result[0][v] = levels[5][n]
        for k in range(n):
            means[v][k] /= result[0][v]
    return means, result[0], result[1]


@kernel
def walk(z_hat, L, d, q, bound, sums, z, last, c, e, above, weight):
    """Walk the tree of all integers within the bound, the last variable first; returns how many vectors there are.

    Adds to sums (n,) the weighted e; weight_n becomes the sum of all weights, weight_k that of the vectors that share
    the present z_k ... z_n-1. The other vectors (n + 1,) are scratch: at each level the integer, the last one within the
    bound, the float value, the difference, the squared distance of the levels above.
    """
    n = len(d)
    k, norm, count, down = n, 0.0, 0, True
    while True:
        if down and k > 0:
            k -= 1
            above[k], weight[k + 1], c[k] = norm, 0.0, z_hat[k]
            for i in range(k + 1, n):
                c[k] += e[i] * L[i][k]
            reach = math.sqrt(max(bound - norm, 0.0) * d[k])
            z[k], last[k] = math.ceil(c[k] - reach), math.floor(c[k] + reach)
        else:
            if down:
                weight[0] = math.exp(0.5 * (q - norm))
                count += 1
            if k == n:
                return count
            sums[k] += e[k] * weight[k]
            weight[k + 1] += weight[k]
            z[k] += 1.0
        down = z[k] <= last[k]
        if down:
            e[k] = z[k] - c[k]
            norm = above[k] + e[k] * e[k] / d[k]
        else:
            k += 1
