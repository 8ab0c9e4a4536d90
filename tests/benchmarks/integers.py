"""Integer least squares timed beside RTKLIB's C `lambda()`: run `python tests/benchmarks/integers.py [rounds]`.

Needs Debian's librtklib1 (libRTKLib.so.1); cssrlib's `mlambda`, and the same C through pyrtklib, are timed where they are
installed. Every ratio is of medians of CPU time over interleaved rounds in one thread, and counts only after all
candidates were found equal and all norms close. For "many" and "one Q" C's time is without ctypes' call overhead; for
"single", one Python call a problem, with it. The problems are double-difference covariances of simulated skies (code
0.3 m, phase 3 mm at the zenith, one epoch to ten) and random ones, half and half. GNSSLAB_NO_NUMBA=1 times the kernels
uncompiled.
"""

import ctypes
import os
import statistics
import sys
import time

import numpy as np

from gnsslab.core.integers import integer_least_squares
from gnsslab.core.jit import COMPILED

WAVELENGTHS = np.array([0.1903, 0.2442, 0.2548, 0.2483])  # L1, L2, L5, E5b [m]
ASKED = {"many": {5: 0.9, 10: 0.75, 20: 0.6, 40: 0.5}, "single": {5: 2.2, 10: 1.0, 20: 0.65}, "one Q": {10: 0.2, 20: 0.06}}


def double_difference_covariance(satellites, frequencies, epochs, rng):
    """Return Q (n, n) [cycles^2], n = frequencies (satellites - 1), of a short baseline with a position an epoch."""
    azimuth, elevation = rng.uniform(0, 2 * np.pi, satellites), np.arcsin(rng.uniform(0.26, 0.98, satellites))
    u = np.stack([np.sin(azimuth) * np.cos(elevation), np.cos(azimuth) * np.cos(elevation), np.sin(elevation)], axis=-1)
    D = np.hstack([-np.ones((satellites - 1, 1)), np.eye(satellites - 1)])
    weight = np.linalg.inv(2 * D @ np.diag(0.5 + 0.5 / np.sin(elevation) ** 2) @ D.T)  # of 1 m zenith sigma
    B = -D @ u
    code, phase = weight / 0.3**2, weight / 0.003**2
    N_b = frequencies * B.T @ (code + phase) @ B
    wavelengths = WAVELENGTHS[:frequencies]
    N_a = np.kron(np.diag(wavelengths**2), phase)
    N_ab = np.kron(wavelengths[:, None], phase @ B)
    Q = np.linalg.inv(epochs * (N_a - N_ab @ np.linalg.solve(N_b, N_ab.T)))
    return (Q + Q.T) / 2


def random_covariance(n, rng):
    """Return A diag(d) A' with A standard normal and d spread over four decades."""
    A = rng.standard_normal((n, n))
    Q = A @ np.diag(10.0 ** rng.uniform(-4, -1, n)) @ A.T / n
    return (Q + Q.T) / 2


def problems(n, count, rng):
    """Return float vectors (count, n) drawn about integers, and their covariances (count, n, n)."""
    frequencies = {5: 1, 10: 2, 20: 2, 40: 4}[n]
    Q = [double_difference_covariance(n // frequencies + 1, frequencies, rng.integers(1, 11), rng) for _ in range(count // 2)]
    Q = np.array(Q + [random_covariance(n, rng) for _ in range(count - len(Q))])
    noise = np.linalg.cholesky(Q) @ rng.standard_normal((count, n, 1))
    return rng.integers(-1000, 1000, (count, n)) + noise[..., 0], Q


def rtklib():
    """Return a function (a, Q) -> candidates (2, n), norms (2,) around RTKLIB's C, its call prepared as far as it can be."""
    library = ctypes.CDLL("libRTKLib.so.1", mode=os.RTLD_LAZY)
    c_lambda = getattr(library, "lambda")
    c_lambda.argtypes = [ctypes.c_int, ctypes.c_int, *[ctypes.c_void_p] * 4]
    return c_lambda


def solve_rtklib(c_lambda, a, Q):
    """Solve all problems by C; returns seconds spent in calls, candidates and norms."""
    count, n = a.shape
    F, s = np.zeros((count, 2, n)), np.zeros((count, 2))
    calls = [(n, 2, a[k].ctypes.data, Q[k].ctypes.data, F[k].ctypes.data, s[k].ctypes.data) for k in range(count)]
    start = time.thread_time()
    results = [c_lambda(*call) for call in calls]
    return time.thread_time() - start, F, s, np.array(results) == 0


def seconds(function, *arguments):
    start = time.thread_time()
    function(*arguments)
    return time.thread_time() - start


def call_overhead(c_lambda, a, Q):
    """Seconds of the same number of ctypes calls that return at once (n = 0): not C's time, so taken off."""
    call = (0, 2, a.ctypes.data, Q.ctypes.data, a.ctypes.data, a.ctypes.data)
    start = time.thread_time()
    [c_lambda(*call) for _ in range(len(a))]
    return time.thread_time() - start


def one_by_one(a, Q):
    for a_k, Q_k in zip(a, Q, strict=True):
        integer_least_squares(a_k, Q_k)


def call_cssrlib(a, Q):
    """Return the best candidates (count, n) of cssrlib's mlambda, Python over numpy arrays."""
    from cssrlib.mlambda import mlambda

    return np.array([mlambda(a_k.copy(), Q_k.copy())[0][:, 0] for a_k, Q_k in zip(a, Q, strict=True)])


def call_pyrtklib(a, Q):
    """Return the best candidates (count, n) of the same C through pyrtklib, its arrays filled from numpy's as its users do."""
    import pyrtklib

    c_lambda, n = getattr(pyrtklib, "lambda"), a.shape[1]
    best = np.empty(a.shape)
    for k in range(len(a)):
        values, matrix, F, s = (pyrtklib.Arr1Ddouble(size) for size in (n, n * n, 2 * n, 2))
        for i, value in enumerate(a[k].tolist()):
            values[i] = value
        for i, value in enumerate(Q[k].ravel().tolist()):
            matrix[i] = value
        c_lambda(n, 2, values, matrix, F, s)
        best[k] = [F[i] for i in range(n)]
    return best


def compare_called(name, call, n, count, rounds, rng):
    """Time one Python call a problem beside another package's, on the same problems."""
    a, Q = problems(n, count, rng)
    try:
        best = call(a, Q)
    except ImportError:
        return print(f"{name} is not installed: not compared")
    right = np.all(np.rint(best) == integer_least_squares(a, Q).best, axis=-1)
    assert right.mean() > 0.9, f"{name} gives other answers: {right.mean():.0%} are the same"  # C gives up after 10000 nodes
    ours, theirs = [], []
    for _ in range(rounds):
        theirs.append(seconds(call, a, Q))
        ours.append(seconds(one_by_one, a, Q))
    print(f"{name:9s} n = {n:2d}: {statistics.median(theirs) / statistics.median(ours):6.1f} times ours, {right.mean():.1%} the same")


def report(kind, n, ours, theirs, count):
    ratio, asked = statistics.median(ours) / statistics.median(theirs), ASKED[kind].get(n)
    c_us, our_us = (1e6 * statistics.median(times) / count for times in (theirs, ours))
    print(f"{kind:8s} n = {n:2d}: {ratio:6.2f} x C, asked {asked}   (C {c_us:.2f} us, ours {our_us:.2f} us a problem)")


def compare(n, count, rounds, rng, c_lambda):
    """Time many problems in one call, and one call a problem."""
    a, Q = problems(n, count, rng)
    _, F, s, solved = solve_rtklib(c_lambda, a, Q)
    a, Q = a[solved], Q[solved]  # RTKLIB gives up after 10000 nodes
    solution = integer_least_squares(a, Q)
    assert np.array_equal(solution.candidates, np.rint(F[solved]))  # solved for by LU: integers but for rounding
    assert np.allclose(solution.norms, s[solved], rtol=1e-6)
    many, single, theirs, theirs_called = [], [], [], []
    for _ in range(rounds):
        theirs_called.append(solve_rtklib(c_lambda, a, Q)[0])
        theirs.append(theirs_called[-1] - call_overhead(c_lambda, a, Q))
        many.append(seconds(integer_least_squares, a, Q))
        single.append(seconds(one_by_one, a, Q))
    report("many", n, many, theirs, len(a))
    if n in ASKED["single"]:
        report("single", n, single, theirs_called, len(a))


def compare_one_covariance(n, count, rounds, rng, c_lambda):
    """Time many float vectors that share one Q, a geometry's."""
    frequencies = 2
    Q = double_difference_covariance(n // frequencies + 1, frequencies, 3, rng)
    a = rng.multivariate_normal(np.zeros(n), Q, count)
    stack = np.broadcast_to(Q, (count, n, n)).copy()
    _, F, _, solved = solve_rtklib(c_lambda, a, stack)
    assert solved.all()
    assert np.array_equal(integer_least_squares(a, Q).candidates, np.rint(F))
    ours, theirs = [], []
    for _ in range(rounds):
        theirs.append(solve_rtklib(c_lambda, a, stack)[0] - call_overhead(c_lambda, a, stack))
        ours.append(seconds(integer_least_squares, a, Q))
    report("one Q", n, ours, theirs, count)


def main(rounds=15):
    rng, c_lambda = np.random.default_rng(2024), rtklib()
    scale = 1 if COMPILED else 20
    print("compiled" if COMPILED else "uncompiled")
    for n, count in ((5, 2000), (10, 1000), (20, 400), (40, 100)):
        compare(n, count // scale, rounds, rng, c_lambda)
    for n, count in ((10, 1000), (20, 400)):
        compare_one_covariance(n, count // scale, rounds, rng, c_lambda)
    for n, count in ((5, 100), (10, 40)):
        compare_called("cssrlib", call_cssrlib, n, count, min(rounds, 5), rng)
        compare_called("pyrtklib", call_pyrtklib, n, count, min(rounds, 5), rng)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
