"""Simulated success: draw float ambiguities, fix them, and count how often the true integers come out.

The true integers are zero, without loss of generality. After decorrelation z_hat = L' diag(sigma) x, sigma_k^2 = d_k, x
standard normal, and the squared distance of zero is |x|^2. So a fix is right if no integer vector is nearer than |x|. The
tree of `integer_least_squares` is searched with this bound, and left at the first vector found inside. On the way down
the float values come from x directly,

    c_k = sigma_k x_k + sum over i > k of (z_i - c_i + sigma_i x_i) L_ik,

whose terms are zero as long as all z_i are.
"""

import math
from concurrent.futures import as_completed
from typing import NamedTuple

import numpy as np

from gnsslab.core.integers.decorrelation import checked_covariance, decorrelate, ltdl
from gnsslab.core.integers.search import checked_count, choose_integer, integer_least_squares
from gnsslab.core.jit import kernel, kernel_input, matrix

_CHUNKS = 100  # as many child generators: a bar that moves by one per cent
_SMALLEST, _LARGEST = 5_000, 100_000  # samples of a chunk: worth sending away (2 ms of work); not too long to wait for
_BLOCK = 1_000  # samples drawn at a time: small enough to stay in the cache
_NODES = 1_000_000  # a sample that needs more is undecided
_TWO_SIDED_95 = 1.959963984540054  # quantile of the normal distribution


class SimulatedRate(NamedTuple):
    """A success rate counted in samples; `undecided` samples, ended by the node limit, are not among the successes."""

    successes: int
    samples: int
    undecided: int = 0

    @property
    def rate(self):
        """Share of the samples that were fixed to the true integers."""
        return self.successes / self.samples

    @property
    def sigma(self):
        """Standard deviation of the rate: half of Wilson's interval for one sigma, so never zero.

        It is sqrt(rate (1 - rate) / samples) where both outcomes are frequent, 1 / 2 (samples + 1) where one never came.
        """
        low, high = wilson_interval(self.successes, self.samples, 1.0)
        return (high - low) / 2.0

    @property
    def interval(self):
        """Wilson's interval (low, high) that covers the true success rate with 95 %, all undecided taken as wrong and as right."""
        low, _ = wilson_interval(self.successes, self.samples, _TWO_SIDED_95)
        _, high = wilson_interval(self.successes + self.undecided, self.samples, _TWO_SIDED_95)
        return low, high

    def __repr__(self):
        undecided = f", {self.undecided} undecided" if self.undecided else ""
        return f"SimulatedRate: {100 * self.rate:.3f} % +- {100 * self.sigma:.3f} % ({self.successes} of {self.samples}{undecided})"


def wilson_interval(successes, samples, quantile):
    """Return the shares p (low, high) whose count would lie within so many of its own sigmas of the counted one.

    |successes - N p| = quantile sqrt(N p (1 - p))

    Source: Wilson (1927), J. American Statistical Association 22:209-212.

    >>> [round(p, 4) for p in wilson_interval(0, 100, 2.0)]
    [0.0, 0.0385]
    """
    return _wilson_lower(successes, samples, quantile), 1.0 - _wilson_lower(samples - successes, samples, quantile)


def _wilson_lower(successes, samples, quantile):
    share, extra = successes / samples, quantile**2 / samples
    half = math.sqrt(share * (1.0 - share) * extra + extra**2 / 4.0)
    return max((share + extra / 2.0 - half) / (1.0 + extra), 0.0)


def simulate_success(Q, rng, samples=100_000, *, bias=None, executor=None, progress=None, node_limit=_NODES):
    """Count how often integer least squares finds the true integers, for float ambiguities drawn with covariance Q.

    Q: (n, n) [cycles^2]; rng: numpy.random.Generator, of which children are taken, so that the count depends neither on
    the executor nor on its workers; bias: (n,) added to the float ambiguities [cycles]. executor: anything with the
    interface of concurrent.futures.Executor does the work, in place of this thread. `progress(done, total)` is called
    now and then with the number of samples; what it raises ends the simulation. Returns a SimulatedRate. Raises
    ValueError where Q is not a covariance matrix, bias does not fit it, or samples is no whole number, 1 or more.
    Source: Verhagen, Li and Teunissen (2013), Computers & Geosciences 54:361-376.

    >>> rate = simulate_success([[0.25]], np.random.default_rng(1), 10_000)       # half a cycle is one sigma: 0.6827
    >>> rate.interval[0] < 0.6827 < rate.interval[1]
    True
    """
    Q, bias, samples, rng = _checked(Q, bias, samples, rng)
    Z, L, d = decorrelate(Q)
    mean = np.linalg.solve(L.T, Z.T @ bias) / np.sqrt(d)  # of x
    node_limit = checked_count(node_limit, "node_limit")
    sizes = _chunks(samples)
    jobs = [(mean, L, d, node_limit, child, size) for child, size in zip(rng.spawn(len(sizes)), sizes, strict=True)]
    successes = undecided = done = 0
    for size, right, open_ in _results(jobs, executor):
        successes, undecided, done = successes + right, undecided + open_, done + size
        if progress is not None:
            progress(done, samples)
    return SimulatedRate(successes, samples, undecided)


def _checked(Q, bias, samples, rng):
    Q, n = checked_covariance(Q), np.shape(Q)[-1]
    bias = np.zeros(n) if bias is None else np.asarray(bias, dtype=np.float64)
    if Q.ndim != 2:
        raise ValueError(f"Q must be one covariance matrix (n, n), simulated on its own; it has shape {Q.shape}.")
    if bias.shape != (n,) or not np.isfinite(bias).all():
        raise ValueError(f"bias must be one finite number of cycles for each of the {n} ambiguities; it is {bias}.")
    return Q, bias, checked_count(samples, "samples"), checked_generator(rng)


def checked_generator(rng):
    """Return rng, or say that it is no source of random numbers."""
    if not isinstance(rng, np.random.Generator):
        raise ValueError(f"rng must be a Generator, such as numpy.random.default_rng(seed) gives; it is {rng!r}.")
    return rng


def _chunks(samples):
    """Return the sizes of the chunks, which follow from the number of samples alone."""
    size = min(max(samples // _CHUNKS, _SMALLEST), _LARGEST)
    return [size] * (samples // size) + [samples % size] * (samples % size > 0)


def _results(jobs, executor):
    """Yield what `_count` returns for each job, in the order in which they come."""
    if executor is None:
        yield from (_count(*job) for job in jobs)
        return
    futures = [executor.submit(_count, *job) for job in jobs]
    try:
        yield from (future.result() for future in as_completed(futures))
    finally:
        for future in futures:
            future.cancel()


def _count(mean, L, d, node_limit, rng, size):
    """Draw `size` samples; returns their number, that of those fixed to zero, and that of the undecided."""
    U, sigma = kernel_input(L.T), kernel_input(np.sqrt(d))
    right = undecided = 0
    for start in range(0, size, _BLOCK):
        x = mean + rng.standard_normal((min(_BLOCK, size - start), len(d)))
        more_right, more_undecided = count_nearest_to_zero(kernel_input(x), U, sigma, node_limit)
        right, undecided = right + more_right, undecided + more_undecided
    return size, right, undecided


class SimulatedFixes(NamedTuple):
    """Drawn float ambiguities and their fixes; the true integers are zero.

    a_hat (N, n) [cycles]; best (N, n) int64, the integers found; is_right (N,) bool, all of them zero; norms (N, 2)
    squared distances of the best and the second best; complete (N,) bool, False where a node limit ended the search.
    """

    a_hat: np.ndarray
    best: np.ndarray
    is_right: np.ndarray
    norms: np.ndarray
    complete: np.ndarray

    @property
    def ratio(self):
        """Second best over best squared norm (N,)."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return self.norms[:, 1] / self.norms[:, 0]

    def __repr__(self):
        N, n = self.a_hat.shape
        return f"SimulatedFixes: {N} vectors of {n} ambiguities, {np.count_nonzero(self.is_right)} fixed to the true integers"


def simulate_fixes(Q, rng, samples, *, bias=None):
    """Draw float ambiguities with covariance Q about the true integers zero, and fix them by integer least squares.

    a_hat = bias + L' D^(1/2) x,   x standard normal,   Q = L' D L

    Q: (n, n) [cycles^2]; rng: numpy.random.Generator; bias: (n,) [cycles]. Returns SimulatedFixes. Raises ValueError as
    `simulate_success`, which is the one to take where the rate alone is wanted.

    >>> fixes = simulate_fixes([[0.01]], np.random.default_rng(1), 3)
    >>> fixes.is_right.tolist()
    [True, True, True]
    """
    Q, bias, samples, rng = _checked(Q, bias, samples, rng)
    L, d = ltdl(Q)
    a_hat = bias + (np.sqrt(d) * rng.standard_normal((samples, len(d)))) @ L  # (N, n)
    solution = integer_least_squares(a_hat, Q)
    return SimulatedFixes(a_hat, solution.best, np.all(solution.best == 0, axis=-1), solution.norms, solution.complete)


@kernel
def count_nearest_to_zero(x, U, sigma, node_limit):
    """Count the rows of x (N, n), z_hat = U diag(sigma) x, for which no integer vector is nearer than zero.

    Returns their number, and that of the rows which node_limit nodes did not decide.
    """
    levels, right, undecided = matrix(5, len(sigma)), 0, 0
    for v in range(len(x)):
        nearer, nodes = find_nearer(x[v], U, sigma, levels, node_limit)
        if not nearer:
            if nodes < node_limit:
                right += 1
            else:
                undecided += 1
    return right, undecided


@kernel
def find_nearer(x, U, sigma, levels, node_limit):
    """Search for an integer vector nearer than zero; returns whether one was found, and the nodes visited.

    As `search_in_place`, with |x|^2 for the bound; levels (5, n) is scratch: at each level the integer z, its float value
    c, what its choice moves the levels below by (g = z - c + sigma x), the step to the next integer, the sum above.
    """
    z, c, g, step, above = levels[0], levels[1], levels[2], levels[3], levels[4]
    n, bound = len(sigma), 0.0
    for k in range(n):
        bound += x[k] * x[k]
    k, nodes, norm, down = n, 0, 0.0, True
    while nodes < node_limit:
        nodes += 1
        if down:
            k -= 1
            above[k] = norm
            c[k] = sigma[k] * x[k]
            for i in range(k + 1, n):
                c[k] += U[k][i] * g[i]
        choose_integer(z, c, step, k, down)
        e = z[k] - c[k]
        g[k] = e + sigma[k] * x[k]
        norm = above[k] + (e / sigma[k]) ** 2
        down = norm < bound
        if down and k == 0:
            for i in range(n):
                if z[i] != 0.0:
                    return True, nodes
            down = False  # this is zero itself: rounding has made |x|^2 a little less
        elif not down:
            k += 1
            if k == n:
                return False, nodes
    return False, nodes
