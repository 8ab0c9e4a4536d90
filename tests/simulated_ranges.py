"""Ranges that the simulator makes in its own way, with the terms of the observation equation that went into them."""

from dataclasses import replace
from functools import lru_cache

import numpy as np

from gnsslab.gnss.observation_equations import RangeTerms
from gnsslab.gnss.signals import SPEED_OF_LIGHT, wavelength
from gnsslab.simulate import NO_NOISE, Clock, find_preset, prepare_geometry
from gnsslab.simulate.measurements import measure

DRIFT = 1e-7  # [s/s] of the receiver's clock: 30 m/s
EPOCHS = 60  # seconds


@lru_cache(1)
def simulated_ranges():
    """Return terms (T, m) and noise-free code and carrier [m] of the GPS satellites of one receiver, whose clock drifts."""
    preset = replace(find_preset("static-baseline"), systems="G", bands=1, duration=float(EPOCHS), clocks=(Clock(1e-4, DRIFT), Clock()))
    geometry = prepare_geometry(preset)
    measured = measure(geometry, NO_NOISE, np.random.default_rng(1))["G"]
    clock_receiver = SPEED_OF_LIGHT * preset.clocks[0].error(np.arange(float(EPOCHS)))[:, None]
    clock_satellite = SPEED_OF_LIGHT * geometry.tracks.clock
    rho = geometry.pseudorange[0] - clock_receiver + clock_satellite
    terms = RangeTerms(rho, clock_receiver, clock_satellite, geometry.troposphere[0], geometry.ionosphere[0])
    code, carrier = measured.value[0, 0, :, :, 0], measured.value[1, 0, :, :, 0] * wavelength("G", "1")
    seen = np.isfinite(code).all(axis=0)
    return RangeTerms(*(np.broadcast_to(term, rho.shape)[:, seen] for term in terms)), code[:, seen], carrier[:, seen]
