"""Observation equations, against measurements that the simulator makes in its own way."""

from dataclasses import replace

import numpy as np
import pytest

from gnsslab.gnss.observation_equations import RangeTerms, carrier_range, carrier_range_as_printed, code_range
from gnsslab.gnss.signals import SPEED_OF_LIGHT, wavelength
from gnsslab.simulate import NO_NOISE, Clock, find_preset, prepare_geometry
from gnsslab.simulate.measurements import measure

MM = 1e-3


@pytest.fixture(scope="module")
def simulated():
    """Terms (T, m) and noise-free code and carrier [m] of the GPS satellites of one receiver, whose clock drifts by 30 m/s."""
    preset = replace(find_preset("static-baseline"), systems="G", bands=1, duration=60.0, clocks=(Clock(1e-4, 1e-7), Clock()))
    geometry = prepare_geometry(preset)
    measured = measure(geometry, NO_NOISE, np.random.default_rng(1))["G"]
    clock_receiver = SPEED_OF_LIGHT * preset.clocks[0].error(np.arange(60.0))[:, None]
    clock_satellite = SPEED_OF_LIGHT * geometry.tracks.clock
    rho = geometry.pseudorange[0] - clock_receiver + clock_satellite
    terms = RangeTerms(rho, clock_receiver, clock_satellite, geometry.troposphere[0], geometry.ionosphere[0])
    code, carrier = measured.value[0, 0, :, :, 0], measured.value[1, 0, :, :, 0] * wavelength("G", "1")
    seen = np.isfinite(code).all(axis=0)
    return RangeTerms(*(np.broadcast_to(term, rho.shape)[:, seen] for term in terms)), code[:, seen], carrier[:, seen]


def _wander(values):
    """Largest change since the first epoch."""
    return np.abs(values - values[0]).max()


def test_the_code_leaves_a_constant(simulated):
    """What is left is the satellite's group delay, which is none of the terms."""
    terms, code, _ = simulated
    assert code.shape[1] >= 8
    assert _wander(code - code_range(terms)) < 1 * MM
    assert np.abs(code - code_range(terms)).max() < 5.0  # [m], a GPS group delay is up to 10 ns


def test_the_carrier_leaves_whole_cycles(simulated):
    """Constant, and satellites differ by whole cycles: the receiver's own fraction is common to all."""
    terms, _, carrier = simulated
    left = carrier - carrier_range(terms)
    assert _wander(left) < 1 * MM
    cycles = left[0] / wavelength("G", "1")
    np.testing.assert_allclose((cycles - cycles[0]) - np.round(cycles - cycles[0]), 0.0, atol=0.01)


def test_as_printed_the_clock_runs_away_twice(simulated):
    terms, _, carrier = simulated
    left = carrier - carrier_range_as_printed(terms)
    drift = 2 * SPEED_OF_LIGHT * 1e-7 * 59  # [m] in the 59 s between the first and the last epoch
    np.testing.assert_allclose(left[-1] - left[0], drift, atol=5.0)  # the rest: twice the change of the troposphere, 1.3 m at most


def test_printed_and_corrected_differ_by_twice_the_terms_with_a_wrong_sign(simulated):
    terms, _, _ = simulated
    wrong = 2 * (terms.clock_receiver - terms.clock_satellite + terms.troposphere)
    np.testing.assert_allclose(carrier_range(terms) - carrier_range_as_printed(terms), wrong, atol=1 * MM)


def test_code_minus_carrier_is_twice_the_ionosphere():
    terms = RangeTerms(2.2e7, -31.0, 15.0, 3.5, np.array([0.0, 4.2]))
    np.testing.assert_allclose(code_range(terms) - carrier_range(terms), [0.0, 8.4], atol=1e-7)


def test_a_part_is_a_part_of_every_term():
    terms = RangeTerms(*np.arange(30.0).reshape(5, 3, 2))
    np.testing.assert_array_equal(np.stack(terms.part(slice(None), 1)), np.arange(30.0).reshape(5, 3, 2)[:, :, 1])
