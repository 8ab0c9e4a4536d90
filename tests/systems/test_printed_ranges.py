"""Printed ranges: what is wrong with them shows."""

import numpy as np
import pytest
from simulated_ranges import DRIFT, EPOCHS, simulated_ranges

from gnsslab.gnss.observation_equations import carrier_range
from gnsslab.gnss.signals import SPEED_OF_LIGHT, wavelength
from gnsslab.gnss.weighting import TYPICAL_CN0, NoiseModel, sigma_code
from gnsslab.systems.printed_ranges import carrier_range_as_printed, sigma_code_as_printed

MM = 1e-3


def test_the_clock_runs_away_twice():
    terms, _, carrier = simulated_ranges()
    left = carrier - carrier_range_as_printed(terms)
    drift = 2 * SPEED_OF_LIGHT * DRIFT * (EPOCHS - 1)  # [m] between the first and the last epoch
    np.testing.assert_allclose(left[-1] - left[0], drift, atol=5.0)  # the rest: twice the change of the troposphere, 1.3 m at most


def test_printed_and_corrected_differ_by_twice_the_terms_with_a_wrong_sign():
    terms, _, _ = simulated_ranges()
    wrong = 2 * (terms.clock_receiver - terms.clock_satellite + terms.troposphere)
    np.testing.assert_allclose(carrier_range(terms) - carrier_range_as_printed(terms), wrong, atol=1 * MM)


def test_a_code_of_3_cm_is_thirteen_times_better_than_the_engine_takes_it():
    best = sigma_code(NoiseModel(), np.pi / 2, TYPICAL_CN0, wavelength("G", "1"))
    assert best / float(sigma_code_as_printed(np.pi / 2)) == pytest.approx(0.4 / 0.03, rel=0.1)


def test_the_printed_sigma_of_a_code_is_the_same_at_all_elevations():
    assert sigma_code_as_printed(np.zeros((2, 3))).tolist() == [[0.03] * 3] * 2
