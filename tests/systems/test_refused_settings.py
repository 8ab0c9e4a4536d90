"""What heading and paper A's filter refuse at the door: settings that would otherwise give a wrong answer, or none, without a word."""

from dataclasses import replace

import numpy as np
import pytest

from gnsslab.gnss.preparation import Settings, prepare_moving
from gnsslab.gnss.selection import keep_epochs
from gnsslab.simulate import find_preset, simulate
from gnsslab.systems.constrained_filter import FilterSettings, run_filter, steady_path
from gnsslab.systems.dual_antenna import A_STATIC, dual_antenna_attitude


@pytest.fixture(scope="module")
def simulation():
    return simulate(replace(find_preset(A_STATIC.preset), duration=5.0, events=()), np.random.default_rng(0))


@pytest.fixture(scope="module")
def prepared(simulation):
    return prepare_moving(*simulation.observations, simulation.ephemerides, A_STATIC.settings)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"length": 1.167, "length_sigma": np.inf}, "the sigma of the length must be more than 0 m, not inf"),
        ({"mount_heading": np.nan}, "the mount heading must be an angle in radians, not nan"),
    ],
)
def test_heading_refuses(simulation, given, words):
    with pytest.raises(ValueError, match=words):
        dual_antenna_attitude(*simulation.observations, simulation.ephemerides, **given)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"mask_deg": 95.0}, "from 0 to below 90 degrees; it is 95.0"),
        ({"mask_deg": np.nan}, "from 0 to below 90 degrees; it is nan"),
        ({"frequencies": 1.5}, "1, 2 or 3; it is 1.5"),
        ({"signals": "C1C"}, "they are the text 'C1C'"),
        ({"acceleration": np.nan}, "it is nan"),
        ({"acceptance": -1.0}, "0 or more; it is -1.0"),
        ({"longest_age": -1.0}, "0 s or more of a master's epoch; it is -1.0"),
    ],
)
def test_settings_that_mean_nothing(given, words):
    with pytest.raises(ValueError, match=words):
        Settings(**given)


def test_receivers_without_epochs_are_said_to_have_none(simulation):
    empty = [keep_epochs(one, np.zeros(len(one.time), dtype=bool)) for one in simulation.observations]
    with pytest.raises(ValueError, match="there are no epochs"):
        dual_antenna_attitude(*empty, simulation.ephemerides)


@pytest.mark.parametrize("use", [17, None, 2.5])
def test_a_use_of_the_length_that_there_is_not(prepared, use):
    with pytest.raises(ValueError, match="the use of the length must be one of LengthUse"):
        run_filter(prepared, steady_path(prepared, A_STATIC.velocity_noise), FilterSettings(length_use=use))


@pytest.mark.parametrize("noise", [(np.nan, 0.02, 0.01), (-0.02, 0.02, 0.01), (np.inf,) * 3, 0.02, (0.02, 0.01)])
def test_a_velocity_noise_is_three_numbers(prepared, noise):
    with pytest.raises(ValueError, match="the velocity noise must be three numbers"):
        steady_path(prepared, noise)
