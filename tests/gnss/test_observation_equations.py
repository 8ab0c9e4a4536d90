"""Observation equations, against measurements that the simulator makes in its own way."""

import numpy as np
from simulated_ranges import simulated_ranges

from gnsslab.gnss.observation_equations import RangeTerms, carrier_range, code_range
from gnsslab.gnss.signals import wavelength

MM = 1e-3


def _wander(values):
    """Largest change since the first epoch."""
    return np.abs(values - values[0]).max()


def test_the_code_leaves_a_constant():
    """What is left is the satellite's group delay, which is none of the terms."""
    terms, code, _ = simulated_ranges()
    assert code.shape[1] >= 8
    assert _wander(code - code_range(terms)) < 1 * MM
    assert np.abs(code - code_range(terms)).max() < 5.0  # [m], a GPS group delay is up to 10 ns


def test_the_carrier_leaves_whole_cycles():
    """Constant, and satellites differ by whole cycles: the receiver's own fraction is common to all."""
    terms, _, carrier = simulated_ranges()
    left = carrier - carrier_range(terms)
    assert _wander(left) < 1 * MM
    cycles = left[0] / wavelength("G", "1")
    np.testing.assert_allclose((cycles - cycles[0]) - np.round(cycles - cycles[0]), 0.0, atol=0.01)


def test_code_minus_carrier_is_twice_the_ionosphere():
    terms = RangeTerms(2.2e7, -31.0, 15.0, 3.5, np.array([0.0, 4.2]))
    np.testing.assert_allclose(code_range(terms) - carrier_range(terms), [0.0, 8.4], atol=1e-7)


def test_a_part_is_a_part_of_every_term():
    terms = RangeTerms(*np.arange(30.0).reshape(5, 3, 2))
    np.testing.assert_array_equal(np.stack(terms.part(slice(None), 1)), np.arange(30.0).reshape(5, 3, 2)[:, :, 1])
