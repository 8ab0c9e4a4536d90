"""The numbers of paper B's experiments, one dict for a seed: its own criterion, gross errors left, detail kept, the step of the means."""

import numpy as np

from gnsslab.core.robust import igg3_weight
from gnsslab.reproduce.paper_b_formulas import CM
from gnsslab.simulate import find_series_preset
from gnsslab.systems.criteria import lengths, rmse_about_mean, rmse_about_truth, rmse_about_two_means
from gnsslab.systems.deformation import B_FIXED, B_STEP

GROSS = 0.10  # [m], and a solution that is farther off counts as one with a gross error
NORMALS = 100_000  # drawn for the shares of good data
STEP_EPOCH = find_series_preset(B_STEP.preset).shifts[0].first


def fixed_numbers(experiment):
    """Return the numbers by key of the baseline at rest, in cm and percent."""
    outputs, truth = experiment.outputs, experiment.drawn.truth_enu
    scatter = {name: rmse_about_mean(lengths(y)) / CM for name, y in outputs.items()}
    found = {f"fixed {name}": value for name, value in scatter.items()}
    found |= {f"gain {name}": 100 * (1 - value / scatter["raw"]) for name, value in scatter.items()}
    left = {name: gross_left(outputs["raw"], outputs[name], truth) for name in ("adjustment", "wavelet", "EEMD", "robust Kalman", "joint")}
    found |= {f"left {name}": value for name, value in left.items()}
    detail = {name: _roughness(outputs[name]) for name in ("joint", "moving average", "wavelet", "EEMD")}
    found |= {f"detail {name}": 100 * (value / detail["moving average"] - 1) for name, value in detail.items()}
    found |= {f"{key} {name}": value for name, y in outputs.items() for key, value in _about_truth(y, truth).items()}
    return found | {
        "joint over adjustment": 100 * (1 - scatter["joint"] / scatter["adjustment"]),
        "joint over Kalman": 100 * (1 - scatter["joint"] / scatter["robust Kalman"]),
        "worse by 120": scatter["average 120"] - scatter["joint"],
        "better by IGG3": 100 * (1 - scatter["joint"] / scatter["plain joint"]),
    }


def _about_truth(positions, truth):
    """Return how long a baseline (T, 3) at rest comes out on the average, and how far off length and position are, in cm."""
    error = lengths(positions) - lengths(truth)
    return {"bias": np.mean(error) / CM, "length": np.sqrt(np.mean(error**2)) / CM, "position": rmse_about_truth(positions, truth) / CM}


def gross_left(raw, output, truth):
    """Return how much [%] of the errors beyond GROSS of raw solutions (T, 3) is left in an output (T, 3) at their epochs; NaN without any."""
    error, left = lengths(raw - truth), lengths(output - truth)
    is_gross = error > GROSS
    return 100 * np.mean(left[is_gross] / error[is_gross]) if is_gross.any() else np.nan


def _roughness(positions):
    """Return how far the length moves from one epoch to the next, the root of its mean square [m]."""
    return np.sqrt(np.mean(np.diff(lengths(positions)) ** 2))


def step_numbers(experiment):
    """Return the numbers by key of the platform that moves, in cm."""
    truth = lengths(experiment.drawn.truth_enu)
    found = {}
    for name in ("raw", "adjustment", "joint"):
        values = lengths(experiment.outputs[name])
        found[f"step {name}"] = rmse_about_two_means(values, STEP_EPOCH) / CM
        found[f"step {name} about mean"] = rmse_about_mean(values) / CM
        found[f"step {name} about truth"] = rmse_about_truth(values, truth) / CM
        found[f"deviation {name}"] = (_step_of_means(values) - _step_of_means(truth)) / CM
    return found


def _step_of_means(values):
    return values[STEP_EPOCH:].mean() - values[:STEP_EPOCH].mean()


def good_data_numbers(seed):
    """Return the shares [%] of good Gaussian data that IGG3 of the paper's k0 and k1 weighs down, rejects, and (20) has no number for."""
    weight = igg3_weight(np.random.default_rng((seed, 2)).standard_normal(NORMALS), B_FIXED.k0, B_FIXED.k1)
    return {"good down-weighted": 100 * np.mean(weight < 1), "good rejected": 100 * np.mean(weight == 0)}
