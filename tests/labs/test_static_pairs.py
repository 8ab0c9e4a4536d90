"""Two receivers at rest: found where they stand, refused where they move or cannot be fixed."""

from dataclasses import replace

import numpy as np
import pytest

from gnsslab.labs.static_pairs import static_pair
from gnsslab.simulate import LOW_COST, find_preset, simulate


def test_simulated_stations_are_found_where_they_stand(rng):
    preset = replace(find_preset("static-rtk-5km"), duration=60.0, systems="GE")
    simulation = simulate(preset, rng)
    found = static_pair(*simulation.observations, simulation.ephemerides)
    assert found.length == pytest.approx(np.linalg.norm([3000, 4000, 35]), abs=0.03)
    assert {name[0] for name in found.pair.satellites} == {"G"}


def test_geonet_stations_are_3335_m_apart(campaign):
    geonet = campaign("geonet-0759-3040")
    found = static_pair(geonet.base, geonet.rover, geonet.ephemerides)
    assert found.length == pytest.approx(3335.3887, abs=0.01)  # registry, by RTKLIB


def test_a_rover_that_moves_is_refused(rng):
    simulation = simulate(replace(find_preset("car-rtk"), duration=60.0, events=()), rng)
    with pytest.raises(ValueError, match=r"the rover moves .* two receivers that stand still"):
        static_pair(*simulation.observations, simulation.ephemerides)


def test_too_few_fixed_epochs_are_refused(rng):
    simulation = simulate(replace(find_preset("static-rtk-5km"), duration=5.0, systems="G", noise=LOW_COST), rng)
    with pytest.raises(ValueError, match=r"only \d epochs could be fixed"):
        static_pair(*simulation.observations, simulation.ephemerides)
