"""Ranges and their sigma as printed in papers A and D1, misprints and all: for comparison only, called by labs and tests.

The mended forms are `gnss.observation_equations.carrier_range` and the sigmas of `gnss.weighting`.
"""

import numpy as np


def carrier_range_as_printed(terms):
    """Return Phi + lambda N as equation (1) of Li et al. (2021) prints it for RangeTerms: rho - c dt_r + c dt^s - I - T.

    The paper calls the terms clock errors and delays. With that meaning both clocks and the troposphere have the wrong sign;
    double differences cancel most of it, which is why it did no harm there.

    >>> from gnsslab.gnss.observation_equations import RangeTerms
    >>> carrier_range_as_printed(RangeTerms(20e6, 300.0, 60.0, 4.0, 3.0))
    19999753.0
    """
    return terms.rho - terms.clock_receiver + terms.clock_satellite - terms.ionosphere - terms.troposphere


def sigma_code_as_printed(elevation):
    """Return the sigma (...) of a code [m] that paper D1 (1998) prints for its Motorola receivers at elevations (...): 3 cm, a slip of the unit.

    >>> sigma_code_as_printed([0.2, 1.5]).tolist()
    [0.03, 0.03]
    """
    return np.full(np.shape(elevation), 0.03)
