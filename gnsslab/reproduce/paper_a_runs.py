"""Paper A's two experiments, simulated and solved in every way that the paper compares, and as it prints its equations."""

from dataclasses import dataclass, replace

import numpy as np

from gnsslab.labs.filter_modes import FilterModes, Scene
from gnsslab.simulate import find_preset
from gnsslab.systems.dual_antenna import A_STATIC, A_TURNTABLE

AT_REST, TURNING = (Scene(name, A_STATIC.filter.length, 0.0, 6.0, 1, 0.0) for name in ("static", "turntable"))
AS_PRINTED = {
    "printed 16": {"length_sigma": A_STATIC.filter.length},
    "printed 25": {"printed_prediction": True},
    "printed 31": {"printed_residual": True},
}
TURNING_AS_PRINTED = {"printed 25": AS_PRINTED["printed 25"]}


@dataclass(frozen=True, eq=False)
class Experiment:
    """One draw of one experiment over T epochs: solutions by name, direct, length, position, and + length with one equation as printed."""

    seconds: np.ndarray  # (T,) [s] since the start
    truth: np.ndarray  # (T, 3) [m] east, north, up
    solutions: dict  # of labs.filter_modes.Solution


def experiments(seeds):
    """Yield both experiments of each seed, at rest and on the turntable."""
    modes = FilterModes()
    for seed in seeds:
        yield _experiment(modes, AT_REST, A_STATIC, seed, AS_PRINTED), _experiment(modes, TURNING, A_TURNTABLE, seed, TURNING_AS_PRINTED)


def _experiment(modes, scene, system, seed, as_printed):
    noise = find_preset(system.preset).noise
    campaign = modes.campaign(scene, noise.carrier_multipath, noise.doppler, seed)
    velocity_noise = system.velocity_noise[0]
    solutions = modes.solve(campaign, velocity_noise, system.filter, "none")
    for name, changes in as_printed.items():
        solutions[name] = modes.solve(campaign, velocity_noise, replace(system.filter, **changes), "none")["length"]
    return Experiment(campaign.seconds, campaign.truth, solutions)
