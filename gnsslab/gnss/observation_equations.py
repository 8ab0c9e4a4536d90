"""Observation equations: what code and carrier measure, term by term, all in metres.

P   = rho + c dt_r - c dt^s + T + I            code
Phi = rho + c dt_r - c dt^s + T - I + lambda N  carrier
D   = -(d Phi / dt) / lambda                    Doppler, positive while the satellite comes nearer
"""

from typing import NamedTuple

import numpy as np


class RangeTerms(NamedTuple):
    """What makes up a measured range; arrays of one shape, one frequency."""

    rho: np.ndarray  # [m], distance from the satellite at transmission to the antenna at reception
    clock_receiver: np.ndarray  # c dt_r [m], positive where the receiver's clock is fast
    clock_satellite: np.ndarray  # c dt^s [m]
    troposphere: np.ndarray  # T [m]
    ionosphere: np.ndarray  # I [m], delay of the code on this frequency

    def part(self, *index):
        """Return the terms at an index of their arrays."""
        return RangeTerms(*(term[index] for term in self))


def code_range(terms):
    """Return what the code should read [m]: P = rho + c dt_r - c dt^s + T + I.

    >>> code_range(RangeTerms(20e6, 300.0, 60.0, 4.0, 3.0))
    20000247.0
    """
    return terms.rho + terms.clock_receiver - terms.clock_satellite + terms.troposphere + terms.ionosphere


def carrier_range(terms):
    """Return what the carrier should read [m] but for its whole cycles: Phi - lambda N = rho + c dt_r - c dt^s + T - I.

    >>> carrier_range(RangeTerms(20e6, 300.0, 60.0, 4.0, 3.0))
    20000241.0
    """
    return terms.rho + terms.clock_receiver - terms.clock_satellite + terms.troposphere - terms.ionosphere
