"""Simulated success timed: run `python tests/benchmarks/monte_carlo.py [rounds]`.

Samples a second of `simulate_success` on one thread, beside the asked 0.8 million at n = 10, and how many times as fast
as that `integer_least_squares` judges the same number of drawn vectors. Medians over interleaved rounds. Seconds are those
of the thread's own work (CPU), so that other programs on the machine do not count; the clock's stand beside. The
covariances are those of one epoch of double differences (code 0.3 m, phase 3 mm at the zenith), once with all noise
tripled, where most samples are fixed wrongly. Before each is timed the success rates of both ways must agree.
"""

import sys
import time

import numpy as np
from integers import double_difference_covariance

from gnsslab.core.integers import integer_least_squares, ltdl, simulate_success
from gnsslab.core.jit import COMPILED

MODELS = [(6, 1, 1, 10**6), (6, 2, 1, 10**6), (6, 2, 3, 10**6), (11, 2, 1, 200_000), (11, 4, 1, 50_000)]  # satellites, frequencies, noise, samples


def draw_and_fix(Q, rng, samples):
    """Return the share of drawn float vectors that integer least squares fixes to zero: the plain way to count."""
    L, d = ltdl(Q)
    a_hat = (np.sqrt(d) * rng.standard_normal((samples, len(d)))) @ L
    return np.mean(np.all(integer_least_squares(a_hat, Q, n_best=1).best == 0, axis=-1))


def seconds(function, *arguments):
    """Return CPU and clock seconds of a call."""
    cpu, clock = time.thread_time(), time.perf_counter()
    function(*arguments)
    return time.thread_time() - cpu, time.perf_counter() - clock


def check(Q, samples):
    """Stop where the two ways to count do not agree within five sigma; returns the rate."""
    simulated, drawn = simulate_success(Q, np.random.default_rng(1), samples), draw_and_fix(Q, np.random.default_rng(2), samples)
    assert abs(simulated.rate - drawn) < 5 * np.sqrt(2) * simulated.sigma, (simulated, drawn)
    return simulated.rate


def compare(Q, samples, rounds):
    """Print samples a second, and the ratio to least squares over a tenth as many drawn vectors."""
    rate, tenth = check(Q, samples // 10), samples // 10
    ours, plain = [], []
    for seed in range(rounds):
        ours.append(seconds(simulate_success, Q, np.random.default_rng(seed), samples))
        plain.append(seconds(draw_and_fix, Q, np.random.default_rng(seed), tenth))
    (cpu, clock), (cpu_plain, _) = np.median(ours, axis=0) / samples, np.median(plain, axis=0) / tenth
    asked = ", asked 0.8" if len(Q) == 10 else ""
    print(f"n = {len(Q):2d}, success rate {100 * rate:6.2f} %: {1e-6 / cpu:5.2f} million samples a second{asked}", end="")
    print(f" (by the clock {1e-6 / clock:.2f}), {cpu_plain / cpu:.1f} times as fast as least squares on drawn vectors")


def main(rounds=9):
    print("compiled" if COMPILED else "uncompiled")
    for satellites, frequencies, noise, samples in MODELS:
        Q = noise**2 * double_difference_covariance(satellites, frequencies, 1, np.random.default_rng(3))
        compare(Q, samples if COMPILED else samples // 100, rounds)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
