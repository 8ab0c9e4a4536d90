"""Sigma means something: the squared error in its own covariance is chi-square, over 20 simulated runs each.

Multipath of the simulated receivers lasts 60 s, so errors 190 s apart are correlated by exp(-190/60) = 4 % and their squares
by 0.2 %: such epochs count as independent. Of a mean over all epochs, the last one is taken, one value a run.
"""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chi2

from gnsslab.gnss.relative import Status, solve_relative
from gnsslab.simulate import find_preset, observe, prepare_geometry

RUNS = 20
APART = 190.0  # [s]
SETTLED = 20.0  # [s] from the start, so that integers are found in all runs

ROOF = replace(find_preset("static-baseline"), interval=5.0, duration=420.0, systems="GE")
ROAD = replace(find_preset("car-rtk"), interval=2.0, duration=300.0, systems="GE", events=())
ROOF_ALL = replace(find_preset("static-baseline"), interval=3.0)


def normalised_squared_errors(preset, epochs, **options):
    """Return e' Q^-1 e (k,) at these epochs of all runs, where fixed, and the share of epochs fixed."""
    geometry = prepare_geometry(preset)
    values, shares = [], []
    for seed in range(RUNS):
        simulation = observe(geometry, preset.noise, np.random.default_rng(seed))
        base_position = simulation.truth.position_ecef[0]
        solution = solve_relative(*simulation.observations, simulation.ephemerides, base_position=base_position, **options)
        is_fixed = solution.status == Status.FIXED
        error = solution.baseline_enu - simulation.truth.baselines_enu[0]
        values += [error[t] @ np.linalg.solve(solution.Q_enu[t], error[t]) for t in epochs if is_fixed[t]]
        shares.append(is_fixed.mean())
    return np.array(values), np.mean(shares)


def assert_in_band(values):
    """The sum of k squared errors with three degrees of freedom each lies in the middle 99 % of chi-square."""
    low, high = chi2.ppf([0.005, 0.995], 3 * len(values))
    assert low < values.sum() < high, f"mean {values.mean() / 3:.2f} of {low / 3 / len(values):.2f} to {high / 3 / len(values):.2f}"


def apart(preset):
    return range(round(SETTLED / preset.interval), preset.epochs, round(APART / preset.interval))


@pytest.mark.parametrize(("preset", "options"), [(ROOF, {}), (ROOF, {"single_epoch": True}), (ROAD, {})], ids=["roof", "single epoch", "car"])
def test_sigma_of_fixed_epochs_means_something(preset, options):
    values, fixed_share = normalised_squared_errors(preset, apart(preset), **options)
    assert fixed_share > 0.95
    assert len(values) >= 0.9 * RUNS * len(apart(preset))
    assert_in_band(values)


def test_sigma_of_a_mean_over_time_means_something():
    """300 s of correlated multipath are worth two or three independent epochs, not a hundred: without that sigma would be 5 times too small."""
    values, fixed_share = normalised_squared_errors(ROOF_ALL, [ROOF_ALL.epochs - 1], static=True)
    assert fixed_share > 0.95
    assert len(values) == RUNS
    assert_in_band(values)
