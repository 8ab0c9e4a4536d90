"""The robust filter of a walking level timed: run `python tests/benchmarks/robust_kalman.py [rounds]`.

63 857 epochs of three axes with gross errors, beside the same filter with numpy matrices in a loop over epochs, the usual way
to write it: asked is 300 times as fast. Both must give the same answers first. Medians of CPU time in one thread over
interleaved rounds. Then a million epochs: seconds, and the most memory taken beyond the series itself.
"""

import statistics
import sys
import time
import tracemalloc

import numpy as np

from gnsslab.core.denoise import hampel_filter, moving_average, wavelet_threshold
from gnsslab.core.jit import COMPILED
from gnsslab.core.random_walk import random_walk_filter, random_walk_smoother
from gnsslab.core.robust import igg3

EPOCHS, MILLION, ASKED = 63_857, 1_000_000, 300.0
Q, R, K0, K1 = 0.48e-4, 9.9e-4, 1.0, 2.0  # [m^2], and thresholds in sigma
MB = 1e6


def noisy_series(epochs, rng):
    """Return z (epochs, 3) [m]: a walk with white noise, and gross errors in one epoch of 300."""
    z = np.cumsum(np.sqrt(Q) * rng.standard_normal((epochs, 3)), axis=0) + np.sqrt(R) * rng.standard_normal((epochs, 3))
    return z + 0.13 * rng.standard_normal((epochs, 3)) * (rng.random((epochs, 1)) < 1 / 300)


def matrix_loop(z):
    """Return the level (T, 3) by a Kalman filter of textbook matrices, one epoch after the other."""
    F, H, Q_w, R_v, eye = np.eye(3), np.eye(3), Q * np.eye(3), R * np.eye(3), np.eye(3)
    x, P, level = z[0].copy(), R * np.eye(3), np.empty_like(z)
    for k in range(len(z)):
        if k > 0:
            x, P = F @ x, F @ P @ F.T + Q_w
        v = z[k] - H @ x
        size = np.abs(v) / np.sqrt(np.diag(H @ P @ H.T + R_v))
        eta = np.where(size <= K0, 1.0, np.where(size < K1, K0 / np.maximum(size, K0) * ((K1 - size) / (K1 - K0)) ** 2, 1e-30))
        R_bar = R_v / np.sqrt(np.outer(eta, eta))
        K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R_bar)
        x, P = x + K @ v, (eye - K @ H) @ P
        level[k] = x
    return level


def cpu_seconds(function, *arguments):
    """Return the CPU seconds of a call in this thread."""
    start = time.thread_time()
    function(*arguments)
    return time.thread_time() - start


def robust_filter(z):
    return random_walk_filter(z, Q, R, igg3(K0, K1))


def compare(rounds):
    """Print the times of both ways and their ratio; return whether it is as asked."""
    z = noisy_series(EPOCHS, np.random.default_rng(1))
    difference = np.abs(robust_filter(z).level - matrix_loop(z)).max()
    assert difference < 1e-10, f"the two filters differ by {difference} m"
    times = [(statistics.median(cpu_seconds(robust_filter, z) for _ in range(5)), cpu_seconds(matrix_loop, z)) for _ in range(rounds)]
    ours, matrices = np.median(times, axis=0)
    print(f"{EPOCHS} epochs x 3 axes: {1e3 * ours:.2f} ms, matrices {1e3 * matrices:.0f} ms: {matrices / ours:.0f} times, asked {ASKED:.0f}")
    print(f"largest difference {difference:.1e} m")
    return matrices / ours >= ASKED


def a_million():
    """Print seconds and memory of the verbs on a million epochs."""
    z = noisy_series(MILLION, np.random.default_rng(2))
    filtered = robust_filter(z)
    verbs = {
        "random_walk_filter": lambda: robust_filter(z),
        "random_walk_smoother": lambda: random_walk_smoother(filtered, Q),
        "moving_average of 15": lambda: moving_average(z, 15),
        "hampel_filter of 15": lambda: hampel_filter(z, 7),
        "wavelet_threshold": lambda: wavelet_threshold(z),
    }
    for name, verb in verbs.items():
        seconds = cpu_seconds(verb)
        tracemalloc.start()
        verb()
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        print(f"{name:22} {MILLION} x 3: {seconds:5.2f} s, {peak / MB:4.0f} MB; the series is {z.nbytes / MB:.0f} MB")


def main(rounds=5):
    print("compiled" if COMPILED else "uncompiled")
    kept = compare(rounds)
    a_million()
    return kept


if __name__ == "__main__":
    sys.exit(not main(*map(int, sys.argv[1:])))
