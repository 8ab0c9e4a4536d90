"""From truth to measurements."""

from gnsslab.simulate.presets import PRESETS, Preset, find_preset, with_length
from gnsslab.simulate.simulation import Simulation, Truth, observe, prepare_geometry, simulate, write_simulation

__all__ = ["PRESETS", "Preset", "Simulation", "Truth", "find_preset", "observe", "prepare_geometry", "simulate", "with_length", "write_simulation"]
