"""From truth to measurements: `simulate(preset, rng)`, or `prepare_geometry(preset)` once and `observe(geometry, noise, rng)` again and again."""

from gnsslab.simulate.events import Gap, GrossError, HalfCycle, Outage, Slip, Street
from gnsslab.simulate.geometry import Geometry, instants, prepare_geometry
from gnsslab.simulate.measurements import draw, idealise
from gnsslab.simulate.presets import PRESETS, Preset, find_preset, with_length
from gnsslab.simulate.receivers import LOW_COST, NO_NOISE, SURVEY, Clock, Noise
from gnsslab.simulate.series import SimulatedSeries, simulate_series, write_series
from gnsslab.simulate.series_presets import SERIES_PRESETS, SeriesNoise, SeriesPreset, Shift, find_series_preset, with_shifts
from gnsslab.simulate.simulation import Simulation, Truth, observe, observe_drawn, simulate, true_motion, write_simulation
from gnsslab.simulate.trajectories import Car, Hop, Ship, Static, Turntable

__all__ = [
    "LOW_COST", "NO_NOISE", "PRESETS", "SERIES_PRESETS", "SURVEY", "Car", "Clock", "Gap", "Geometry", "GrossError", "HalfCycle", "Hop", "Noise",
    "Outage", "Preset", "SeriesNoise", "SeriesPreset", "Shift", "Ship", "SimulatedSeries", "Simulation", "Slip", "Static", "Street", "Truth",
    "Turntable", "draw", "find_preset", "find_series_preset", "idealise", "instants", "observe", "observe_drawn", "prepare_geometry", "simulate",
    "simulate_series", "true_motion", "with_length", "with_shifts", "write_series", "write_simulation",
]  # fmt: skip
