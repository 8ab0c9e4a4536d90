"""From truth to measurements: `simulate(preset, rng)`, or `prepare_geometry(preset)` once and `observe(geometry, noise, rng)` again and again."""

from gnsslab.simulate.events import Gap, GrossError, HalfCycle, Outage, Slip, Street
from gnsslab.simulate.geometry import Geometry, instants, prepare_geometry
from gnsslab.simulate.measurements import draw, idealise
from gnsslab.simulate.presets import PRESETS, Preset, find_preset, with_length
from gnsslab.simulate.receivers import LOW_COST, NO_NOISE, SURVEY, Clock, Noise
from gnsslab.simulate.simulation import Simulation, Truth, observe, observe_drawn, simulate, true_motion, write_simulation
from gnsslab.simulate.trajectories import Car, Hop, Ship, Static, Turntable

__all__ = [
    "LOW_COST", "NO_NOISE", "PRESETS", "SURVEY", "Car", "Clock", "Gap", "Geometry", "GrossError", "HalfCycle", "Hop", "Noise", "Outage", "Preset",
    "Ship", "Simulation", "Slip", "Static", "Street", "Truth", "Turntable", "draw", "find_preset", "idealise", "instants", "observe", "observe_drawn",
    "prepare_geometry", "simulate", "true_motion", "with_length", "write_simulation",
]  # fmt: skip
