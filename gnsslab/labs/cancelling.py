"""Lab of lesson 02: what cancels and what grows when the measurements of two receivers and two satellites are differenced."""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from gnsslab.data import DataUnavailable
from gnsslab.gnss.frames import azimuth_elevation, enu_rotation
from gnsslab.gnss.orbits import group_delay
from gnsslab.gnss.signals import SPEED_OF_LIGHT, wavelength
from gnsslab.gnss.times import seconds_between
from gnsslab.labs.campaigns import FileReader, blocked_by_data, no_answer, require_files, simulated_instead
from gnsslab.labs.controls import Choice, FileOrPath, Slider
from gnsslab.labs.lab import Drawing, Goal, Lab, Preset, Readout, standing
from gnsslab.labs.levels import grain, levels_of, traced_by_code, traced_by_tags
from gnsslab.labs.static_pairs import static_pair
from gnsslab.simulate import LOW_COST, SURVEY, Clock, Static, find_preset, prepare_geometry
from gnsslab.simulate.geometry import antenna_position
from gnsslab.simulate.measurements import measure

KM, MM, MS = 1e3, 1e-3, 1e-3
KEPT = 4  # geometries kept by one lab: enough to go back and forth
REAL_DATA = "geonet-0759-3040"
SITUATION = replace(
    find_preset("static-rtk-5km"), systems="G", bands=1, start="2024-06-24T05:20:00", duration=300.0, mask_deg=12.0
)  # early afternoon, when the ionosphere is thickest
DIRECTION = np.array([0.6, 0.8])  # of the baseline, east and north
STEADY = Clock(offset=2e-6, drift=3e-9)  # the master's
DRIFT = -8e-9  # [s/s], of the rover's clock
TRACED = {"code": traced_by_code, "tags": traced_by_tags}
NOISES = {"survey": SURVEY, "cheap": LOW_COST}
MOSTLY = 0.9  # share of the epochs at which a satellite must have been measured
LOWEST = np.radians(10.0)

CONTROLS = (
    Choice("data", "Data", {"simulated": "simulated", "real pair": "real", "my files": "mine"}, "simulated",
           help="Simulated, two stations in Japan 3.3 km apart, or your own RINEX files."),
    Choice("observable", "Measurement", {"carrier": "carrier", "code": "code"}, "carrier", help="The carrier's phase, or the code."),
    Choice("clocks", "Clocks", {"as they are": True, "all perfect": False}, True, help="Those of both receivers and of the satellites."),
    Choice("atmosphere", "Atmosphere", {"none": "", "ionosphere": "I", "troposphere": "T", "both": "IT"}, "IT", help="What delays the signals."),
    Slider("length", "Baseline length", 0, 10, 0.5, 1, "km", help="From master to rover. Zero: side by side."),
    Slider("rover_clock", "Rover's clock error", 0, 1, 0.01, 0.01, "ms", help="How far it is fast. A millisecond is 300 km of light."),
    Choice("transmission", "Time of transmission", {"from each code": "code", "from the time tags": "tags"}, "code", more=True,
           help="How you know when the signal left: a receiver's own code tells, whatever its clock says. A time tag is as wrong as the clock."),
    Choice("satellite", "Satellite", {"high": "high", "middle": "middle", "lowest": "low"}, "low", more=True,
           help="Which one is compared with the reference. High: the highest but one."),
    Choice("reference", "Reference satellite", {"highest": "high", "middle": "middle", "lowest": "low"}, "high", more=True,
           help="Which one the others are compared with."),
    Choice("noise", "Antennas", {"survey": "survey", "cheap": "cheap"}, "survey", help="Cheap ones are twice as noisy.", more=True),
    Slider("seed", "Seed", 1, 100, 1, 33, help="Another seed is another draw of the noise.", more=True),
    FileOrPath("master_file", "Master observations"),
    FileOrPath("rover_file", "Rover observations"),
    FileOrPath("navigation_file", "Broadcast navigation"),
)  # fmt: skip
FILES = ("master_file", "rover_file", "navigation_file")
SIMULATION_ONLY = ("clocks", "atmosphere", "length", "rover_clock", "noise", "seed")

PRESETS = (
    Preset("start", "Start", {},
           "From top to bottom eight powers of ten: 100 km of satellite clocks, kilometres of receiver clocks, millimetres."),
    Preset("millisecond", "A millisecond off", {"rover_clock": 1},
           "The rover's clock is off by a millisecond: its own measurements move by 300 km, and the double difference does not care."),
    Preset("tags", "A millisecond, believed", {"rover_clock": 1, "transmission": "tags"},
           "Now you believe the time tags: you compute where the satellites were a millisecond later, and decimetres stay."),
    Preset("zero", "Side by side", {"length": 0},
           "With no distance between the antennas the atmosphere is gone too: what is left is the noise of four measurements."),
    Preset("ten", "Ten kilometres", {"length": 10},
           "Each receiver looks through air of its own: centimetres stay, and they are no noise, because they do not average out."),
    Preset("grain", "Noise alone", {"clocks": False, "atmosphere": "", "length": 0},
           "Hardly anything is left to cancel, and the noise grows: 1.4 times with the first difference, twice with the second."),
    Preset("code", "Code", {"observable": "code"},
           "The same clocks cancel in the codes, but the noise that grows is decimetres and metres, not millimetres."),
    Preset("real", "Two real stations", {"data": "real"},
           "Two stations in Japan, 3335 m apart, for an hour: the double difference stays within two centimetres of a whole number of cycles."),
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class Residuals:
    """Measured minus geometric of two receivers, m satellites and one signal over T epochs."""

    time: np.ndarray  # (T,) datetime64[ns]
    satellites: tuple[str, ...]  # (m,)
    elevation: np.ndarray  # (m,) [rad], in the middle, at the master
    value: np.ndarray  # (2, T, m) [m], master and rover
    wavelength: float  # [m]; 0 for a code
    length: float  # [m], of the baseline
    cycles: np.ndarray  # (2, m) int, whole cycles taken off the carriers
    atmosphere: np.ndarray | None = None  # (2, T, m) [m], what ionosphere and troposphere really added, where it is known

    def of(self, kept):
        """Return the same for the satellites marked in kept (m,) alone."""
        return replace(
            self,
            satellites=tuple(np.array(self.satellites)[kept].tolist()),
            elevation=self.elevation[kept],
            value=self.value[..., kept],
            cycles=self.cycles[:, kept],
            atmosphere=None if self.atmosphere is None else self.atmosphere[..., kept],
        )


@dataclass(frozen=True, eq=False)
class CancellingResult:
    """One pair of satellites at the three levels, and what to say."""

    settings: dict  # of the controls, all of them
    seconds: np.ndarray | None = None  # (T,) since the first epoch
    names: tuple[str, str] = ("", "")  # satellite, reference
    elevation_deg: tuple[float, float] = (0.0, 0.0)
    levels: object = None  # Levels [m]; the double difference of carriers without its whole cycles
    grains: tuple = ()  # per level: standard deviation [m] about a smooth curve, and the series less the curve
    cycles: int = 0  # whole cycles in the double difference, taken off
    atmosphere: float | None = None  # [m], what the atmosphere left in the double difference, mean; None where nobody knows
    wavelength: float = 0.0  # [m]; 0 for a code
    length: float = 0.0  # [m]
    problem: str = ""
    note: str = ""


class CancellingEngine:
    """The data of one lab instance, kept between moves, and the way from settings to a result."""

    def __init__(self):
        self._geometry = lru_cache(KEPT)(_geometry)
        self._pair = lru_cache(KEPT)(static_pair)
        self._files = FileReader()

    def compute(self, **settings):
        """Return the CancellingResult of checked settings; what a reader or the engine refuses becomes a sentence."""
        try:
            residuals, note = self._residuals(settings)
            return _compare(settings, residuals, note)
        except ValueError as refusal:
            return CancellingResult(settings, problem=no_answer(refusal))

    def _residuals(self, settings):
        """Return the Residuals chosen, and a note where they had to be others."""
        if settings["data"] == "mine":
            return self._mine(settings), ""
        if settings["data"] == "real":
            try:
                return _measured(self._pair(*self._files.data_set(REAL_DATA)), settings), ""
            except DataUnavailable as reason:
                return self._simulated(settings), simulated_instead(reason)
        return self._simulated(settings), ""

    def _mine(self, settings):
        master, rover, navigation = (settings[name] for name in FILES)
        require_files(master=master, rover=rover, navigation=navigation)
        observations = (self._files.observations(path) for path in (master, rover))
        return _measured(self._pair(*observations, self._files.ephemerides(navigation)), settings)

    def _simulated(self, settings):
        clocks = (STEADY, Clock(settings["rover_clock"] * MS, DRIFT)) if settings["clocks"] else (Clock(), Clock())
        return _simulate(self._geometry(settings["length"] * KM, clocks), settings)


def _geometry(length, clocks):
    east, north = DIRECTION * length
    return prepare_geometry(replace(SITUATION, trajectory=Static(place_enu=(east, north, 0.0)), clocks=clocks))


def _simulate(geometry, settings):
    """Return the Residuals of a simulated campaign; the simulation knows the whole cycles and takes them off."""
    geometry = _with_atmosphere(geometry, settings["atmosphere"])
    measured = measure(geometry, NOISES[settings["noise"]], np.random.default_rng(settings["seed"]))["G"]
    code, carrier = measured.value[:2, ..., 0]  # (R, T, m)
    lam = wavelength("G", "1")
    cycles = measured.integers[..., 0] + measured.fractions[:, None, None, 0]
    is_carrier = settings["observable"] == "carrier"
    raw = lam * (carrier - cycles) if is_carrier else code
    ends = [antenna_position(geometry.preset, receiver, np.zeros(1))[0] for receiver in range(2)]
    value, states = _less_ranges(geometry.tracks.ephemerides, measured.satellites, (geometry.preset.time,) * 2, ends, code, raw, settings)
    if not settings["clocks"]:
        value = value + _satellite_clocks(geometry.tracks.ephemerides, measured.satellites, states, is_carrier)
    sign = -1 if is_carrier else 1  # the ionosphere hurries the carrier on as much as it holds the code back
    return Residuals(
        time=geometry.preset.time,
        satellites=measured.satellites,
        elevation=geometry.elevation[0, len(carrier[0]) // 2],
        value=value,
        wavelength=lam * is_carrier,
        length=settings["length"] * KM,
        cycles=np.zeros((2, len(measured.satellites)), dtype=np.int64),
        atmosphere=geometry.troposphere + sign * geometry.ionosphere,
    )


def _with_atmosphere(geometry, kinds):
    """Return the geometry with only the delays of the kinds named, "I" and "T"."""
    none = np.zeros_like(geometry.ionosphere)
    return replace(geometry, ionosphere=geometry.ionosphere if "I" in kinds else none, troposphere=geometry.troposphere if "T" in kinds else none)


def _less_ranges(ephemerides, satellites, times, ends, codes, raw, settings):
    """Return raw (2, T, m) less the ranges to both ends, and the satellites' states at the master."""
    trace = TRACED[settings["transmission"]]
    traced = [trace(ephemerides, satellites, time, end, code) for time, end, code in zip(times, ends, codes, strict=True)]
    return raw - np.stack([rho for rho, _ in traced]), traced[0][1]


def _satellite_clocks(ephemerides, satellites, states, is_carrier):
    """Return c dt^s (T, m) [m]; for codes less the delay in the satellite, which is a clock of that signal's own."""
    delay = 0.0 if is_carrier else group_delay(ephemerides, states.index, ["G"] * len(satellites), ["1"] * len(satellites))
    return SPEED_OF_LIGHT * (states.clock - delay)


def _measured(found, settings):
    """Return the Residuals of a StaticPair: what two real receivers measured, each carrier's counter set by its code."""
    pair, lam = found.pair, float(found.pair.wavelength[0])
    code, carrier = np.stack([pair.master.code, pair.rover.code]), lam * np.stack([pair.master.phase, pair.rover.phase])
    is_carrier = settings["observable"] == "carrier"
    cycles = _cycles_by_code(code, carrier, lam) if is_carrier else np.zeros((2, code.shape[2]), dtype=np.int64)
    raw = carrier - lam * cycles[:, None] if is_carrier else code
    names = [pair.satellites[k] for k in pair.satellite]
    ends, times = (found.master_ecef, found.rover_ecef), (pair.time_master, pair.time)
    value, states = _less_ranges(found.ephemerides, names, times, ends, code, raw, settings)
    return Residuals(
        time=pair.time,
        satellites=tuple(names),
        elevation=_elevations(states.position, found.master_ecef),
        value=value,
        wavelength=lam * is_carrier,
        length=found.length,
        cycles=cycles,
    )


def _cycles_by_code(code, carrier, lam):
    """Return the whole cycles (2, m) by which carriers (2, T, m) [m] differ from their codes: a receiver may start counting anywhere."""
    apart = np.where(np.isfinite(code + carrier), carrier - code, np.nan)
    is_known = np.isfinite(apart).any(axis=1, keepdims=True)
    return np.rint(np.nanmedian(np.where(is_known, apart, 0.0), axis=1) / lam).astype(np.int64)


def _elevations(position, place):
    """Return the elevations (m,) [rad] of satellites (T, m, 3) in the middle of their epochs, below the horizon where there are none."""
    elevation = azimuth_elevation((position - place) @ enu_rotation(place).T)[1]
    return np.nanmedian(np.where(np.isfinite(elevation).any(axis=0), elevation, -np.pi / 2), axis=0)


def _compare(settings, residuals, note):
    """Return the result for the pair of satellites chosen."""
    residuals = residuals.of(_kept(residuals))
    satellite, reference = _chosen(residuals.elevation, settings["satellite"], settings["reference"])
    levels = levels_of(residuals.value, satellite, reference)
    rest = _whole_cycles(levels.double, residuals)
    taken_off = levels_of(residuals.cycles[:, None], satellite, reference).double
    levels = levels._replace(double=levels.double - rest * residuals.wavelength)
    air = residuals.atmosphere
    return CancellingResult(
        settings,
        seconds=seconds_between(residuals.time, residuals.time[0]),
        names=tuple(residuals.satellites[k] for k in (satellite, reference)),
        elevation_deg=tuple(float(np.degrees(residuals.elevation[k])) for k in (satellite, reference)),
        levels=levels,
        grains=tuple(grain(level) for level in levels),
        cycles=rest + int(taken_off[0, 0]),
        atmosphere=None if air is None else float(levels_of(air, satellite, reference).double.mean()),
        wavelength=residuals.wavelength,
        length=residuals.length,
        note=note,
    )


def _kept(residuals):
    """Return which satellites (m,) both receivers measured nearly all the time, well above the horizon."""
    kept = (np.isfinite(residuals.value).all(axis=0).mean(axis=0) >= MOSTLY) & (residuals.elevation > LOWEST)
    if kept.sum() < 2:
        raise ValueError("fewer than two satellites were measured by both receivers nearly all the time: give a shorter span of open sky")
    return kept


def _chosen(elevation, satellite, reference):
    """Return the indices of satellite and reference among the elevations (m,)."""
    order = np.argsort(-elevation)
    place = {"high": 0, "middle": len(order) // 2, "low": len(order) - 1}
    k = 1 if satellite == "high" else place[satellite]
    if k == place[reference]:
        raise ValueError("satellite and reference are the same one, and a satellite less itself is zero: choose another")
    return int(order[k]), int(order[place[reference]])


def _whole_cycles(double, residuals):
    """Return the whole cycles nearest to a measured double difference; of a simulated one they are off already, and codes have none."""
    if residuals.atmosphere is not None or not residuals.wavelength:
        return 0
    return int(np.rint(np.nanmedian(double) / residuals.wavelength))


def cancelling_lab():
    """Return a fresh lab with caches of its own."""
    return Lab(
        name="cancelling", title="What cancels, what grows", controls=CONTROLS, presets=PRESETS, goals=GOALS,
        compute=CancellingEngine().compute, figure=figure, drawings=drawings, describe=describe, readouts=readouts, table=table,
        steering=("data", "clocks"), blocked=blocked,
    )  # fmt: skip


def blocked(settings):
    """Return for each control without effect on the chosen data, or with the chosen clocks, the reason why."""
    is_perfect = settings["data"] == "simulated" and not settings["clocks"]
    by_clocks = dict.fromkeys(("rover_clock", "transmission"), "no effect: all clocks are perfect") if is_perfect else {}
    return blocked_by_data(settings["data"], SIMULATION_ONLY, FILES) | by_clocks


def figure(result):
    """Return the whole picture as one matplotlib Figure."""
    from gnsslab.figures.cancelling import plot_cancelling

    return plot_cancelling(result)


def drawings():
    """Return the two pictures of the lab."""
    from gnsslab.figures.cancelling import build_grains, build_sizes

    return Drawing("sizes", build_sizes, 470, 410), Drawing("grains", build_grains, 380, 410)


def describe(result):
    """Return the pictures in words."""
    from gnsslab.figures.cancelling import describe_cancelling

    return result.problem or describe_cancelling(result)


def readouts(result):
    """Return the sizes of the three levels with their noise, and what is left of the atmosphere or of the cycles."""
    from gnsslab.figures.cancelling import LEVELS, length_words, typical_size

    if result.problem:
        return []
    numbers = []
    for name, level, (sigma, _) in zip(LEVELS, result.levels, result.grains, strict=True):
        value, unit = length_words(typical_size(level)).split()
        numbers.append(Readout(name.capitalize(), value, unit, f"noise {length_words(sigma)}"))
    return [*numbers, _what_is_left(result)]


def _what_is_left(result):
    if result.atmosphere is not None:
        return Readout("Atmosphere left", f"{round(result.atmosphere / MM, 1) + 0.0:.1f}", "mm", f"in the double difference, {_pair_words(result)}")
    if not result.wavelength:
        return Readout("Whole cycles", "none", "", f"a code has none; {_pair_words(result)}")
    return Readout("Whole cycles", str(result.cycles), "", f"taken off the double difference, {_pair_words(result)}")


def _pair_words(result):
    (satellite, reference), (low, high) = result.names, result.elevation_deg
    return f"{satellite} at {low:.0f} deg less {reference} at {high:.0f} deg"


def table(result):
    """Return what is in the picture as columns."""
    (s, r), (raw, single, double) = result.names, result.levels
    names = (f"master_{s}_m", f"master_{r}_m", f"rover_{s}_m", f"rover_{r}_m", f"single_{s}_m", f"single_{r}_m", "double_m")
    return {"seconds": result.seconds} | dict(zip(names, (*raw, *single, *double), strict=True))


def _judge_calm(result):
    if result.problem or result.settings["data"] != "simulated":
        return False, "The rules ask for simulated data."
    used = result.settings
    by_rule = used["observable"] == "carrier" and used["clocks"] and used["atmosphere"] == "IT" and used["rover_clock"] >= 0.5 and used["length"] >= 5
    size = float(np.sqrt(np.nanmean(result.levels.double**2)))
    return by_rule and size < 5 * MM, standing(f"{size / MM:.1f} mm", by_rule)


GOALS = (
    Goal("calm", "Simulated carriers, clocks as they are with the rover's 0.5 ms off or more, the whole atmosphere, and 5 km or more between "
         "the receivers: bring the double difference to a typical size below 5 mm.", _judge_calm),
)  # fmt: skip
