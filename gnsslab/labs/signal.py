"""Lab of lesson 01: one satellite over some minutes. Code, carrier and Doppler, a slip the student places, and what the equation leaves."""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from gnsslab.data import DataUnavailable
from gnsslab.gnss.observation_equations import carrier_range
from gnsslab.gnss.screening import cycle_slips
from gnsslab.gnss.times import seconds_between
from gnsslab.gnss.weighting import NoiseModel, sigma_phase
from gnsslab.labs.campaigns import FileReader, blocked_by_data, no_answer, require_files, simulated_instead
from gnsslab.labs.controls import Choice, FileOrPath, Slider
from gnsslab.labs.lab import Drawing, Goal, Lab, Preset, Readout, standing
from gnsslab.labs.recordings import read_recording, shown_epochs, simulated_recording, with_slip
from gnsslab.simulate import Clock, Noise, Static, find_preset, prepare_geometry
from gnsslab.systems.printed_ranges import carrier_range_as_printed

KEPT = 12  # simulations and geometries kept by one lab: three clocks and three ionospheres go through nine
MM = 1e-3  # [m]
FINER = 100  # multipath bends the carrier about that much less than the code: its wave is 19 cm, the code's chip 293 m
MULTIPATH_TIME = 30.0  # [s], for which a reflection lasts
FULL = 0.9  # share of the epochs at which a satellite must have been measured to be shown
REAL_DATA = {"real": "matrtklib-static", "station": "cssrlib-078"}
# Eleven in the morning in Japan: ten GPS satellites from 11 to 74 degrees, and the ionosphere growing.
PRESET = replace(
    find_preset("static-baseline"), start="2024-06-24T02:00:00", duration=300.0, systems="G",
    trajectory=Static(), antennas=((0.0, 0.0, 0.0),), base=(0.0, 1.0, 0.0),
)  # fmt: skip
CLOCKS = {
    "steered": Clock(offset=2e-6, drift=3e-9),
    "free": Clock(offset=2e-4, drift=1e-7),  # 30 m/s: a quartz crystal left alone
    "jumping": Clock(offset=3.5e-4, drift=1e-6, jump=1e-3),  # half a millisecond is reached after 150 s
}
EQUATIONS = {"corrected": carrier_range, "printed": carrier_range_as_printed}

CONTROLS = (
    Choice(
        "data", "Data", {"simulated": "simulated", "real roof": "real", "GEONET": "station", "my files": "mine"}, "simulated",
        help="A simulated receiver, a real one on a roof, one 5 km from a GEONET station (travels with the course), or your own.",
    ),
    Slider("elevation_deg", "Satellite near elevation", 10, 85, 5, 50, "deg", help="The satellite nearest to this elevation is shown."),
    Slider("code_noise", "Code noise", 0.1, 1.5, 0.1, 0.3, "m", help="Of one reading at the zenith."),
    Slider("multipath", "Multipath", 0, 2, 0.1, 0.1, "m", help="In the code at the zenith; the carrier gets a hundredth of it."),
    Slider("slip_cycles", "Cycle slip on L1", -10, 10, 1, 0, "cycles", help="From then on the carrier counts that many cycles too many."),
    Choice("clock", "Clock", {"steered": "steered", "free": "free", "jumping": "jumping"}, "steered",
           help="Of the receiver: steered, left alone (it gains 30 m a second), or fast (it gains 300 m a second) and set back by 1 ms."),
    Slider("slip_second", "Cycle slip on L2", -10, 10, 1, 0, "cycles", help="The same on the second carrier, at the same moment.", more=True),
    Slider("slip_at", "Slip after", 10, 90, 5, 50, "%", help="Of the recording.", more=True),
    Slider("carrier_noise", "Carrier noise", 0.5, 5, 0.5, 1.5, "mm", help="Of one reading at the zenith.", more=True),
    Choice("ionosphere", "Ionosphere", {"none": 0, "as usual": 1, "four times as much": 4}, 1,
           help="The true delay; the dots climb or fall by twice its change.", more=True),
    Choice("equation", "Equation of the carrier", {"corrected": "corrected", "as printed": "printed"}, "corrected",
           help="What is taken from the carrier in the last picture.", more=True),
    Slider("seed", "Seed", 1, 100, 1, 1, help="Another seed is another draw of the noise.", more=True),
    FileOrPath("observation_file", "Observations"),
    FileOrPath("navigation_file", "Broadcast navigation"),
)  # fmt: skip
FILES = ("observation_file", "navigation_file")
SIMULATION_ONLY = ("code_noise", "multipath", "carrier_noise", "clock", "ionosphere", "seed")

PRESETS = (
    Preset("start", "Start", {},
           "Above, dots and line stand on one scale: the code scatters by decimetres, the carrier is a line as thin as the pen."),
    Preset("cycle-slip", "Cycle slip", {"slip_cycles": 5},
           "Five cycles too many from 150 s on: code minus carrier stands 0.95 m lower, and the engine marks the second."),
    Preset("small-slip", "One cycle", {"slip_cycles": 1, "elevation_deg": 15},
           "One cycle is 19 cm: lost among the dots, but a cliff in the enlarged line of the carrier."),
    Preset("multipath", "Multipath", {"multipath": 1.5, "code_noise": 0.1},
           "Slow waves instead of grass: an echo lasts for half a minute, so averaging ten seconds removes nothing of it."),
    Preset("cheap", "Cheap antenna", {"code_noise": 1, "multipath": 0.6, "carrier_noise": 3},
           "Three times the noise everywhere, and still the carrier is more than a hundred times finer than the code."),
    Preset("horizon", "Near the horizon", {"elevation_deg": 10},
           "The same receiver, a satellite at 10 degrees: code and carrier scatter almost four times as much as at 47 degrees."),
    Preset("ionosphere", "Ionosphere", {"ionosphere": 4, "elevation_deg": 20, "code_noise": 0.1},
           "The dots climb along the dashed line: twice the ionosphere, as it delays the code and advances the carrier."),
    Preset("clock-jump", "Clock jump", {"clock": "jumping"},
           "At 150 s the clock is set back by 1 ms, 300 km of light: code minus carrier notices nothing, the range rate has one spike."),
    Preset("printed", "As printed", {"clock": "free", "equation": "printed"},
           "In five minutes the equation as printed runs 18 km away from the carrier; corrected, it leaves one number."),
    Preset("roof", "Real roof", {"data": "real"},
           "A survey antenna in Japan: the code scatters by a decimetre, in slow waves, the carrier by a millimetre."),
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class Track:
    """One satellite over T epochs, ready to be drawn; NaN where something was not measured."""

    time: np.ndarray  # (T,) datetime64[ns]
    seconds: np.ndarray  # (T,) [s] since the first epoch
    satellite: str  # "G05"
    elevation: float  # [rad], in the middle
    wavelength: float  # [m] of the first carrier
    code_minus_carrier: np.ndarray  # (T,) [m], less its level before any slip
    carrier: np.ndarray  # (T,) [m], first carrier minus second, less level and slow drift; NaN with one carrier
    ionosphere_twice: np.ndarray  # (T,) [m], change of twice the delay as the two carriers tell it
    sigma_code: float  # [m], scatter of the code
    sigma_carrier: float  # [m], scatter of one carrier, NaN with one carrier
    step: float  # [m], by which code minus carrier moved where the slip was placed, NaN without
    placed: int  # epoch of the slip, -1 without
    found: np.ndarray  # (T,) bool, the engine says that the count of cycles broke
    range_rate: np.ndarray  # (T,) [m/s] by Doppler, else by the carrier
    has_doppler: bool
    code_rate: np.ndarray  # (T,) [m/s], change of the code a second, less `range_rate`
    carrier_rate: np.ndarray  # (T,) [m/s]
    left: np.ndarray  # (T,) [m], carrier minus the right side of the equation, less its first value


@dataclass(frozen=True, eq=False)
class SignalResult:
    """One satellite's Track and what to say."""

    settings: dict  # of the controls, all of them
    track: Track | None = None  # None where there is a problem
    problem: str = ""
    note: str = ""


class SignalEngine:
    """The recordings of one lab instance, kept between moves, and the way from settings to a result."""

    def __init__(self):
        self._files = FileReader()
        self._geometry = lru_cache(KEPT)(_geometry)
        self._simulated = lru_cache(KEPT)(self._simulate)
        self._read = lru_cache(KEPT)(read_recording)

    def compute(self, **settings):
        """Return the SignalResult of checked settings; what a reader or the engine refuses becomes a sentence."""
        try:
            recording, note = self._recording(settings)
            return SignalResult(settings, _track(recording, settings), note=note)
        except ValueError as refusal:
            return SignalResult(settings, problem=no_answer(refusal))

    def _recording(self, settings):
        """Return the recording chosen, and a note where it had to be another."""
        if settings["data"] == "mine":
            return self._mine(*(settings[name] for name in FILES))
        if settings["data"] in REAL_DATA:
            try:
                _, rover, ephemerides = self._files.data_set(REAL_DATA[settings["data"]])
                return self._read(rover, ephemerides), ""
            except DataUnavailable as reason:
                return self._simulation(settings), simulated_instead(reason)
        return self._simulation(settings), ""

    def _simulation(self, settings):
        return self._simulated(*(settings[name] for name in SIMULATION_ONLY))

    def _simulate(self, code_noise, multipath, carrier_noise_mm, clock, ionosphere, seed):
        noise = Noise(
            code=code_noise, carrier=carrier_noise_mm * MM, code_multipath=multipath, carrier_multipath=multipath / FINER,
            code_multipath_time=MULTIPATH_TIME, carrier_multipath_time=MULTIPATH_TIME,
        )  # fmt: skip
        return simulated_recording(self._geometry(clock, ionosphere), noise, np.random.default_rng(seed))

    def _mine(self, observations, navigation):
        """Return the recording in the student's files, and a note where only its beginning is shown."""
        require_files(observation=observations, navigation=navigation)
        observed = self._files.observations(observations)
        shown, total = int(shown_epochs(observed.time).sum()), len(observed.time)
        note = f"The file holds {total} epochs; the first {shown} are shown." if shown < total else ""
        return self._read(observed, self._files.ephemerides(navigation)), note


def _geometry(clock, ionosphere):
    delays = tuple(ionosphere * a for a in PRESET.ionosphere[:4]) + PRESET.ionosphere[4:] if ionosphere else None
    return prepare_geometry(replace(PRESET, clocks=(CLOCKS[clock], CLOCKS["steered"]), ionosphere=delays))


def _track(recording, settings):
    """Return the Track of the satellite chosen, with the student's slip in it."""
    satellite = _nearest(recording, np.radians(settings["elevation_deg"]))
    first, second = _channels(recording.pair, satellite)
    cycles = (settings["slip_cycles"], settings["slip_second"] if second is not None else 0)
    epoch = round(settings["slip_at"] / 100 * (len(recording.time) - 1)) if any(cycles) else -1
    if any(cycles):
        recording = with_slip(recording, (first, second)[: 1 + (second is not None)], epoch, cycles[: 1 + (second is not None)])
    return _measured(recording, satellite, first, second, epoch, EQUATIONS[settings["equation"]])


def _nearest(recording, elevation):
    """Return the column of the satellite nearest to an elevation [rad], of those with code and all carriers nearly always."""
    pair = recording.pair
    whole = np.isfinite(pair.rover.code + pair.rover.phase).mean(axis=0) >= FULL
    carriers = np.bincount(pair.satellite[whole], minlength=len(pair.satellites))
    middle = np.array([np.nanmedian(column) if np.isfinite(column).any() else np.nan for column in recording.elevation.T])
    usable = (carriers == min(2, carriers.max(initial=0))) & (carriers > 0) & np.isfinite(middle)
    if not usable.any():
        raise ValueError("no satellite was measured throughout; give a file in which one satellite stays in sight")
    return int(np.argmin(np.where(usable, np.abs(middle - elevation), np.inf)))


def _channels(pair, satellite):
    """Return the channels of a satellite's first and second carrier; None for a second there is not."""
    channels = np.flatnonzero(pair.satellite == satellite)
    channels = channels[np.argsort(pair.band[channels], kind="stable")]
    return int(channels[0]), int(channels[1]) if len(channels) > 1 else None


def _measured(recording, satellite, first, second, epoch, equation):
    pair, tracks = recording.pair, recording.pair.rover
    seconds = seconds_between(pair.time, pair.time[0])
    carrier = tracks.phase * pair.wavelength
    found = _found_slips(recording)[:, [first] if second is None else [first, second]].any(axis=1)
    arc = np.cumsum(found)
    pure, drift = _carrier_alone(carrier, pair.wavelength, seconds, first, second, arc)
    minus, sigma_code, step = _code_minus_carrier(tracks.code[:, first] - carrier[:, first], drift, seconds, arc, epoch)
    rate, has_doppler = _range_rate(tracks.doppler[:, first], carrier[:, first], pair.wavelength[first], seconds)
    left = carrier[:, first] - equation(recording.terms.part(slice(None), satellite))
    return Track(
        time=pair.time, seconds=seconds, satellite=pair.satellites[satellite], elevation=float(np.nanmedian(recording.elevation[:, satellite])),
        wavelength=float(pair.wavelength[first]), code_minus_carrier=minus, carrier=pure.values, ionosphere_twice=drift,
        sigma_code=sigma_code, sigma_carrier=pure.sigma / np.sqrt(2), step=step, placed=epoch, found=found,
        range_rate=rate, has_doppler=has_doppler, code_rate=_rate(tracks.code[:, first], seconds) - rate,
        carrier_rate=_rate(carrier[:, first], seconds) - rate, left=left - _first(left),
    )  # fmt: skip


def _found_slips(recording):
    """Return (T, c) bool: where the engine, which is told nothing, sees a break in the count of cycles."""
    pair = recording.pair
    elevation = recording.elevation[:, pair.satellite]
    usable = np.isfinite(pair.rover.code + pair.rover.phase) & (elevation > 0)
    sigma = sigma_phase(NoiseModel(), np.where(usable, elevation, np.nan), pair.rover.cn0, pair.wavelength)
    return cycle_slips(pair, usable, sigma)


@dataclass(frozen=True, eq=False)
class _Levelled:
    """A series split into arcs, each with a level of its own, and one smooth drift for all."""

    values: np.ndarray  # (T,), less drift and the level of the first arc
    drift: np.ndarray  # (T,), zero in the first epoch
    sigma: float  # scatter about levels and drift


def _levelled(series, seconds, arc, degree):
    """Fit one level an arc and a common polynomial of that degree by least squares; return the `_Levelled` series."""
    known = np.isfinite(series)
    time = seconds / max(seconds[-1], 1.0)
    smooth = time[:, None] ** np.arange(1, degree + 1)
    A = np.hstack([smooth, (arc[:, None] == np.unique(arc[known])).astype(float)])
    x = np.linalg.lstsq(A[known], series[known], rcond=None)[0]
    residual = series - A @ x
    drift = smooth @ x[:degree]
    sigma = np.sqrt(np.sum(residual[known] ** 2) / max(known.sum() - A.shape[1], 1))
    return _Levelled(series - drift - x[degree], drift, float(sigma))


def _carrier_alone(carrier, wavelength, seconds, first, second, arc):
    """Return the `_Levelled` difference of the two carriers, in which all but noise and ionosphere cancels, and twice the ionosphere (T,).

    Phi_1 - Phi_2 = (g - 1) I + levels, g = (lambda_2 / lambda_1)^2
    """
    if second is None:
        nothing = np.full(len(seconds), np.nan)
        return _Levelled(nothing, nothing, float("nan")), nothing
    pure = _levelled(carrier[:, first] - carrier[:, second], seconds, arc, 2)
    g = (wavelength[second] / wavelength[first]) ** 2
    return pure, 2 * pure.drift / (g - 1)


def _code_minus_carrier(series, ionosphere_twice, seconds, arc, epoch):
    """Return the series less its first level (T,), the code's scatter, and the step at the student's slip (NaN without)."""
    has_drift = np.isfinite(ionosphere_twice).all()
    drift = ionosphere_twice if has_drift else np.zeros(len(seconds))
    level = _levelled(series - drift, seconds, arc, 0 if has_drift else 1)
    rest = level.values
    step = np.nanmean(rest[epoch:]) - np.nanmean(rest[:epoch]) if epoch > 0 else float("nan")
    return rest + drift, level.sigma, float(step)


def _range_rate(doppler, carrier, wavelength, seconds):
    """Return the mean range rate of each step (T,) [m/s], by Doppler where there is any, else by the carrier; and whether by Doppler."""
    if not np.isfinite(doppler).any():
        return _rate(carrier, seconds), False
    mean = np.concatenate([doppler[:1], (doppler[1:] + doppler[:-1]) / 2])
    return -wavelength * mean, True


def _rate(length, seconds):
    """Return the change a second (T,) [m/s] since the epoch before, NaN at the first."""
    return np.concatenate([[np.nan], np.diff(length) / np.diff(seconds)])


def _first(values):
    known = values[np.isfinite(values)]
    return known[0] if len(known) else np.nan


def _judge_hidden(result):
    used, track = result.settings, result.track
    if track is None:
        return False, "Now: no answer yet."
    size = max(abs(used["slip_cycles"]), abs(used["slip_second"]))
    is_found = track.found[track.placed]
    by_rule = used["data"] == "simulated"
    state = "no slip is placed" if track.placed < 0 else f"a slip of {size} cycle{'s' if size > 1 else ''} is {'found' if is_found else 'missed'}"
    return by_rule and size >= 1 and not is_found, standing(state, by_rule)


def _judge_finer(result):
    if result.track is None:
        return False, "Now: no answer yet."
    used, ratio = result.settings, _ratio(result.track)
    by_rule = used["data"] == "simulated" and used["code_noise"] <= 0.3 and result.track.elevation < np.radians(20)
    return by_rule and ratio >= 300, standing(f"{ratio:.0f} times finer", by_rule)


GOALS = (
    Goal("hidden", "Simulated data: place a slip of whole cycles, on one carrier or on both, so that the engine misses it.", _judge_hidden),
    Goal("finer", "Simulated data, code noise of 0.3 m or less, a satellite below 20 degrees: make the carrier 300 times finer than the code.",
         _judge_finer),
)  # fmt: skip


def signal_lab():
    """Return a fresh lab with caches of its own."""
    return Lab(
        name="signal", title="One satellite", controls=CONTROLS, presets=PRESETS, goals=GOALS,
        compute=SignalEngine().compute, figure=figure, drawings=drawings, describe=describe, readouts=readouts, table=table,
        steering=("data",), blocked=blocked,
    )  # fmt: skip


def blocked(settings):
    """Return for each control without effect on the chosen data the reason why."""
    return blocked_by_data(settings["data"], SIMULATION_ONLY, FILES)


def figure(result):
    """Return the whole picture as one matplotlib Figure."""
    from gnsslab.figures.signal import plot_signal

    return plot_signal(result.track)


def drawings():
    """Return the two pictures of the lab."""
    from gnsslab.figures.signal import build_rates, build_signal

    return (
        Drawing("signal", lambda part: _of_result(build_signal(part)), 500, 420),
        Drawing("rates", lambda part: _of_result(build_rates(part)), 380, 420),
    )


def _of_result(scene):
    from gnsslab.figures.kept import Scene

    return Scene(scene.moving, lambda result: scene.show(result.track))


def describe(result):
    """Return the picture in words."""
    from gnsslab.figures.signal import describe_signal

    return describe_signal(result.track)


def readouts(result):
    """Return the scatter of code and carrier, what became of the slip, the range rate, and what the equation leaves."""
    if result.problem:
        return []
    track = result.track
    return [
        Readout("Code", f"{track.sigma_code:.2f}", "m", f"scatter; {track.satellite} at {np.degrees(track.elevation):.0f} deg"),
        _carrier_readout(track),
        _slip_readout(track, result.settings),
        _rate_readout(track),
        _equation_readout(track),
    ]


def _carrier_readout(track):
    if not np.isfinite(track.sigma_carrier):
        return Readout("Carrier", "none", "", "one carrier only: nothing to hold it against")
    return Readout("Carrier", f"{track.sigma_carrier / MM:.1f}", "mm", f"scatter; {_ratio(track):.0f} times finer than the code")


def _slip_readout(track, settings):
    if track.placed < 0:
        count = int(track.found.sum())
        return Readout("Slip", "none", "", f"placed; the engine marks {count} by itself")
    word = "found" if track.found[track.placed] else "missed"
    size = settings["slip_cycles"] * track.wavelength
    return Readout("Slip", word, "", f"L1 moved by {size:.2f} m; code minus carrier by {track.step:.2f} m")


def _rate_readout(track):
    middle = track.range_rate[len(track.range_rate) // 2]
    source = f"Doppler {-middle / track.wavelength:.0f} Hz" if track.has_doppler else "by the carrier: the file holds no Doppler"
    return Readout("Range rate", f"{middle:.1f}", "m/s", source)


def _equation_readout(track):
    left = float(np.nanmax(np.abs(track.left)))
    value, unit = (f"{left / 1000:.1f}", "km") if left >= 1000 else (f"{left:.2f}", "m")
    return Readout("Equation leaves", value, unit, "at most, besides one constant")


def _ratio(track):
    return track.sigma_code / track.sigma_carrier


def table(result):
    """Return what is in the picture as columns."""
    track = result.track
    return {
        "time_gps": track.time,
        "code_minus_carrier_m": track.code_minus_carrier,
        "carrier_minus_carrier_mm": track.carrier / MM,
        "twice_ionosphere_m": track.ionosphere_twice,
        "slip_found": track.found,
        "range_rate_m_s": track.range_rate,
        "code_rate_minus_doppler_m_s": track.code_rate,
        "carrier_rate_minus_doppler_m_s": track.carrier_rate,
        "equation_leaves_m": track.left,
    }
