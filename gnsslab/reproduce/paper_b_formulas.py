"""What follows from paper B's equations and settings without any noise: ranks, gains, answers to a clean step, its own arithmetic."""

import numpy as np

from gnsslab.core.denoise import moving_average
from gnsslab.core.random_walk import random_walk_filter
from gnsslab.core.robust import igg3
from gnsslab.systems.criteria import lag, rmse_about_mean
from gnsslab.systems.deformation import B_FIXED, B_STEP, filtered
from gnsslab.systems.printed_deformation import gain_as_printed, normal_matrix_as_printed
from gnsslab.systems.window_adjustment import (
    adjust_by_condition,
    adjust_with_adjusted_window,
    adjust_with_raw_window,
    weighted_mean,
    weights_by_error_of_mean,
    weights_by_mean_error,
)

CM = 0.01  # [m]
EPOCHS, FIRST = 3000, 400  # of a clean series, and where it steps
STEP = 0.036  # [m] on one axis
SHARES = (0.5, 0.9, 0.99)
INTERVALS = {"15 s": 15.0, "1 s": 1.0}  # of the paper's two series
STATED = {"raw": 2.37, "joint": 1.00, "adjustment": 1.40, "robust Kalman": 1.52, "moving average": 1.52, "wavelet": 1.78, "EEMD": 1.74}  # [cm]
STATED_GAIN = {"joint": 57.6, "adjustment": 40.9, "robust Kalman": 35.8, "moving average": 35.8, "wavelet": 24.8, "EEMD": 26.5}  # [%]
BASELINE, MOVED = 1.2, np.array([-0.02, -0.03])  # [m], the paper's platform: west, south


def formula_numbers():
    """Return the numbers by key, lengths in cm, lags in epochs."""
    return _equations() | _arithmetic() | _geometry() | _lags() | _lock_out()


def _equations():
    printed, gain = _gains()
    two = ([1.200], [[1.5**2]], [1.240], [[3.0**2]])
    return {
        "rank 11": float(np.linalg.matrix_rank(normal_matrix_as_printed(np.eye(3), np.diag([1.0, 2.0, 3.0])))),
        "formula 17": printed - gain[0],
        "missing 17": gain[1],
        "formula 22": float(rmse_about_mean(np.full(100, BASELINE + 1.0))) / CM,
        "weighted mean": 1e6 * abs(adjust_by_condition(*two).position[0] - weighted_mean(*two).position[0]),
    }


def _gains():
    """Return the number that (17) prints for two states measured as one, and the gain (2,) that is right."""
    P, H, R = np.diag([4.0, 1.0]), np.array([[1.0, 0.5]]), np.eye(1)
    return gain_as_printed(P, H, R)[0, 0], (P @ H.T / (H @ P @ H.T + R))[:, 0]


def _arithmetic():
    """Return the paper's percentages minus those of its own centimetres, and what else its numbers say of each other."""
    rounding = {f"arithmetic {name}": gain - _gain(STATED[name], STATED["raw"]) for name, gain in STATED_GAIN.items()}
    return rounding | {
        "stated over adjustment": _gain(STATED["joint"], STATED["adjustment"]),
        "stated over Kalman": _gain(STATED["joint"], STATED["robust Kalman"]),
        "stated table 3": _gain(1.02, 2.30),
        "epochs of 13 h": 13 * 3600 / INTERVALS["15 s"],
        "epochs of 18 h": 18 * 3600 / INTERVALS["1 s"],
    }


def _gain(value, raw):
    """Return by how many percent a value is below another."""
    return 100 * (1 - value / raw)


def _geometry():
    """Return by how much [cm] the baseline's length changes with the platform's move, along the baseline and across it."""
    along = BASELINE * MOVED / np.linalg.norm(MOVED)
    across = along[::-1] * (1, -1)
    return {name: (np.linalg.norm(b + MOVED) - BASELINE) / CM for name, b in (("length along", along), ("length across", across))}


def _lags():
    """Return how many epochs after a clean step each method shows its shares, by the key "joint 90"; and the time that is."""
    z = _clean(STEP)
    found = {"raw": z, "Kalman": filtered(z, B_STEP), "moving average": moving_average(z, B_FIXED.average)} | _adjusted(z)
    found |= {"joint": filtered(found["adjusted window"], B_STEP)}
    lags = {f"{name} {100 * share:.0f}": lag(y[:, 0] / STEP, FIRST, share) for name, y in found.items() for share in SHARES}
    return lags | {f"joint 90 at {name}": lags["joint 90"] * interval / 60 for name, interval in INTERVALS.items()}


def _adjusted(z):
    sigma = np.ones(len(z))
    equal, small = weights_by_mean_error(sigma), weights_by_error_of_mean(sigma)
    return {
        "raw window": adjust_with_raw_window(z, equal),
        "adjusted window": adjust_with_adjusted_window(z, equal),
        "error of mean": adjust_with_adjusted_window(z, small),
    }


def _lock_out():
    """Return beyond which step [cm] the robust Kalman filter rejects all it sees, and for how many epochs."""
    system, found = B_FIXED, {}
    for size in (10, 15):
        z = _clean(size * CM)
        walk = random_walk_filter(z, system.q, system.r, igg3(system.k0, system.k1))
        joint = filtered(_adjusted(z)["adjusted window"], system)
        found |= {
            f"rejected {size}": float(np.sum(walk.weight[FIRST:] == 0)),
            f"Kalman 50 of {size}": lag(walk.level[:, 0] / (size * CM), FIRST, 0.5),
            f"joint 50 of {size}": lag(joint[:, 0] / (size * CM), FIRST, 0.5),
        }
    predicted = walk.innovation_sigma[FIRST - 1, 0] ** 2 - system.r  # P^- once it is steady
    return found | {
        "steady variance": predicted / CM**2,
        "steady gain": predicted / (predicted + system.r),
        "lock-out": system.k1 * np.sqrt(predicted + system.r) / CM,
    }


def _clean(size):
    """Return one axis (EPOCHS, 1) [m] that steps by `size` [m] and has no noise."""
    return np.where(np.arange(EPOCHS) < FIRST, 0.0, size)[:, None]
