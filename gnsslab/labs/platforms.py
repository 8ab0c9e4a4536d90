"""Lab of lesson 05: two antennas on a car, a ship or a turntable, and two receivers that do not measure at the same instant."""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from gnsslab.core.rotations import heading_pitch_of, within_half_turn
from gnsslab.gnss.frames import enu_rotation
from gnsslab.gnss.relative import Status
from gnsslab.labs.campaigns import no_answer
from gnsslab.labs.controls import Choice, Slider, Switch
from gnsslab.labs.filter_modes import rms
from gnsslab.labs.lab import Drawing, Goal, Lab, Preset, Readout, standing
from gnsslab.simulate import Clock, draw, find_preset, idealise, instants, observe_drawn, prepare_geometry, with_length
from gnsslab.simulate.simulation import true_motion
from gnsslab.systems.dual_antenna import Attitude, dual_antenna_attitude
from gnsslab.systems.heading_rate import HeadingRate, heading_rate

KEPT = 4
MM, MS = 1e-3, 1e-3
WRONG = 0.05  # [m], a fixed epoch further than this from the truth is wrong
SECONDS = 250.0  # of each journey
SOURCES = {"car": "car-heading", "ship": "ship-heading", "turntable": "paper-a-turntable", "city": "city-heading"}

CONTROLS = (
    Choice("platform", "Platform", {"car in the hills": "car", "ship in swell": "ship", "turntable": "turntable", "car in a city": "city"}, "car",
           help="What carries the two antennas."),
    Slider("length", "Baseline length", 0.3, 5, 0.1, 1, "m", help="From the master's antenna to the rover's."),
    Slider("time_offset", "The rover measures later by", 0, 1000, 5, 0, "ms", help="Both stamp the same second; their clocks are that far apart."),
    Choice("mount", "Antennas", {"along the way": "along", "across it": "across"}, "along", help="How the baseline lies on the body.", more=True),
    Switch("correction", "Correct the master's position (29)", True, help="Move it on by its Doppler velocity to the rover's instant."),
    Choice("systems", "Systems", {"GPS": "G", "GPS + BeiDou": "GC", "GPS + Galileo": "GE", "all": "GECJ"}, "GE", help="Whose satellites are used."),
    Switch("known_length", "Use the known length", True, help="In the search for the integers."),
    Choice("frequencies", "Frequencies", {"one": 1, "two": 2}, 1, help="Carriers used of each satellite.", more=True),
    Switch("single_epoch", "Each second alone", False, help="On: no memory. Off: a filter carries the integers on.", more=True),
    Slider("carrier_noise", "Carrier noise", 0.5, 5, 0.5, 2, "mm", help="Of one reading at the zenith; multipath adds one and a half times as much.",
           more=True),
    Slider("doppler_noise", "Doppler noise", 0.5, 20, 0.5, 5, "cm/s", help="Of one reading at the zenith: the velocity comes from it.", more=True),
    Slider("seed", "Seed", 1, 100, 1, 1, help="Another seed is another draw of the noise.", more=True),
)  # fmt: skip

JOURNEY = (
    "platform",
    "length",
    "mount",
    "time_offset",
    "systems",
    "frequencies",
    "carrier_noise",
    "doppler_noise",
    "seed",
)  # on what a recording depends

PRESETS = (
    Preset("car", "A car in the hills", {},
           "Heading to 0.26 deg and pitch to 0.48 on a winding road; each curve shows in the rate."),
    Preset("ship", "A ship in swell", {"platform": "ship", "length": 2},
           "A long turn, half a degree a second. On twice the length: heading to 0.13 deg, pitch to 0.36."),
    Preset("turntable", "A turntable", {"platform": "turntable", "systems": "GC"},
           "Six degrees a second, round and round: the rate is known to a fraction of a degree a second."),
    Preset("city", "Between houses", {"platform": "city"},
           "Two streets leave few satellites and a bridge none. With four in sight nothing is fixed; in the open it is back at once."),
    Preset("city-alone", "Between houses, GPS alone", {"platform": "city", "systems": "G", "known_length": False},
           "One system, one frequency, no length: hardly a second is fixed, and most of those are wrong."),
    Preset("offset", "50 ms apart, across", {"time_offset": 50, "mount": "across", "correction": False, "known_length": False},
           "At 15 m/s the car drives 0.75 m in between, across the baseline: the heading is off by up to 37 deg. Switch the correction on."),
    Preset("offset-along", "50 ms apart, along", {"time_offset": 50, "correction": False, "known_length": False},
           "The same, but the antennas lie along the way: now the baseline gets longer and the heading hardly notices. Yet all is wrong."),
    Preset("offset-length", "50 ms apart, length known", {"time_offset": 50, "correction": False},
           "The measured vector has not the known length, so nothing is fixed. Switch the correction on."),
    Preset("second", "A second apart, corrected", {"time_offset": 1000, "mount": "across"},
           "The Doppler velocity is good to centimetres a second, and a second of it makes centimetres: the heading is off by 3 deg rms, but fixed."),
    Preset("short", "30 cm", {"length": 0.3},
           "A short arm: the same millimetres turn it three times as far."),
    Preset("everything", "All systems", {"systems": "GECJ", "frequencies": 2, "single_epoch": True},
           "Two carriers of every satellite: each second is fixed alone, without memory."),
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class Journey:
    """What two receivers recorded on the way, and the truth at the rover's instants."""

    observations: tuple  # (master, rover)
    ephemerides: object
    time: np.ndarray  # (T,) tags
    baseline_enu: np.ndarray  # (T, 3) [m]
    track: np.ndarray  # (T, 2) [m] east and north of the master from where it started
    speed: np.ndarray  # (T,) [m/s] of the master


@dataclass(frozen=True, eq=False)
class PlatformsResult:
    """An attitude on the way, and the truth."""

    settings: dict  # of the controls, all of them
    journey: Journey | None = None
    attitude: Attitude | None = None
    rate: HeadingRate | None = None
    problem: str = ""
    note: str = ""

    @property
    def seconds(self):
        """Seconds (T,) since the start."""
        return (self.journey.time - self.journey.time[0]) / np.timedelta64(1, "s")

    @property
    def truth(self):
        """True heading and pitch (T,) [rad] of the baseline."""
        return heading_pitch_of(self.journey.baseline_enu)

    @property
    def heading_error(self):
        """Measured minus true heading (T,) [rad], within half a turn."""
        return within_half_turn(self.attitude.heading - self.truth[0])

    @property
    def pitch_error(self):
        """Measured minus true pitch (T,) [rad]."""
        return self.attitude.pitch - self.truth[1]

    @property
    def true_rate(self):
        """True mean heading rate (T,) [rad/s] since the epoch before; NaN at the first."""
        return np.append(np.nan, within_half_turn(np.diff(self.truth[0])) / np.diff(self.seconds))

    @property
    def is_fixed(self):
        """Which epochs are fixed, (T,) bool."""
        return self.attitude.status == Status.FIXED

    @property
    def is_wrong(self):
        """Which of them are wrong, (T,) bool."""
        return self.is_fixed & (np.linalg.norm(self.attitude.baseline_enu - self.journey.baseline_enu, axis=1) > WRONG)


class PlatformsEngine:
    """The journeys of one lab instance, kept between moves."""

    def __init__(self):
        self._ideal = lru_cache(KEPT)(_ideal)
        self._drawn = lru_cache(KEPT)(self._draw)
        self._journey = lru_cache(KEPT)(self._record)

    def compute(self, **settings):
        """Return the PlatformsResult of checked settings; what the engine refuses becomes a sentence."""
        journey = self._journey(*(settings[name] for name in JOURNEY))
        try:
            attitude = _attitude(journey, settings)
        except ValueError as refusal:
            return PlatformsResult(settings, journey, problem=no_answer(refusal))
        return PlatformsResult(settings, journey, attitude, heading_rate(attitude))

    def _record(self, platform, length, mount, time_offset, systems, frequencies, carrier_noise, doppler_noise, seed):
        """Return the Journey of a platform with these receivers."""
        geometry, ideals = self._ideal(platform, length, mount, time_offset, systems, frequencies)
        draws = self._drawn(platform, length, mount, time_offset, systems, frequencies, seed)
        carrier = carrier_noise * MM
        noise = replace(geometry.preset.noise, carrier=carrier, carrier_multipath=1.5 * carrier, doppler=doppler_noise / 100)
        simulation = observe_drawn(geometry, ideals, draws, noise)
        return _journey(geometry.preset, simulation)

    def _draw(self, platform, length, mount, time_offset, systems, frequencies, seed):
        """Return the errors of a seed."""
        return draw(self._ideal(platform, length, mount, time_offset, systems, frequencies)[0], np.random.default_rng(seed))


def _ideal(platform, length, mount, time_offset, systems, frequencies):
    """Return the Geometry of a platform, and its ideal measurements."""
    source = find_preset(SOURCES[platform])
    clocks = Clock(offset=2e-6), Clock(offset=2e-6 - time_offset * MS)  # a clock that is slow stamps late instants with the same tag
    preset = replace(
        source, duration=SECONDS, events=_before_the_end(source.events), systems=systems, bands=frequencies, satellites=(), clocks=clocks
    )
    geometry = prepare_geometry(with_length(_across(preset) if mount == "across" else preset, length))
    return geometry, idealise(geometry)


def _across(preset):
    """Return the preset with its antennas turned by a quarter: what lay forward lies to the right."""
    return replace(preset, antennas=tuple((forward, right, up) for right, forward, up in preset.antennas))


def _before_the_end(events):
    """Return the events that a journey is long enough for."""
    return tuple(event for event in events if getattr(event, "last", getattr(event, "epoch", 0)) < SECONDS)


def _journey(preset, simulation):
    """Return the Journey at the epochs that the rover has."""
    master, rover = simulation.observations[:2]
    index = np.searchsorted(preset.time, rover.time)
    truth = true_motion(preset, instants(preset, 1))
    place = (truth.position_ecef - truth.position_ecef[0]) @ enu_rotation(truth.position_ecef[0]).T
    speed = np.linalg.norm(np.gradient(place, preset.interval, axis=0), axis=1)
    return Journey((master, rover), simulation.ephemerides, rover.time, truth.baselines_enu[0, index], place[index, :2], speed[index])


def _attitude(journey, settings):
    """Run the engine on a journey's observations."""
    return dual_antenna_attitude(
        *journey.observations,
        journey.ephemerides,
        length=settings["length"] if settings["known_length"] else None,
        systems=settings["systems"],
        frequencies=settings["frequencies"],
        single_epoch=settings["single_epoch"],
        position_correction=settings["correction"],
    )


def offset_error(result):
    """Return the largest heading error [rad] that the time offset makes without a correction: atan(v dt / l)."""
    settings = result.settings
    return float(np.arctan2(result.journey.speed.max() * settings["time_offset"] * MS, settings["length"]))


def _share(claims):
    return 100 * float(np.mean(claims))


def _rms_deg(errors):
    """Return the root mean square [deg] of errors [rad], NaN where there are none."""
    return float(np.degrees(rms(errors)))


def _solved(result):
    """Return which epochs are as good as the best there are, (T,) bool."""
    status = result.attitude.status
    return (status == status.max()) & (status > Status.NONE)


def _judge_short(result):
    if result.problem:
        return False, result.problem
    used, error, fixed = result.settings, _rms_deg(result.heading_error[_solved(result)]), _share(result.is_fixed)
    by_rule = used["platform"] == "car" and used["length"] <= 0.5 and used["frequencies"] == 1 and used["carrier_noise"] >= 2
    return by_rule and error < 0.5 and fixed >= 99, standing(f"heading {error:.2f} deg rms, {fixed:.1f} % fixed", by_rule)


def _judge_apart(result):
    if result.problem:
        return False, result.problem
    used, error = result.settings, _rms_deg(result.heading_error[_solved(result)])
    by_rule = used["platform"] == "car" and used["time_offset"] >= 500 and used["doppler_noise"] >= 5 and used["length"] <= 2
    return by_rule and error < 1.0, standing(f"heading {error:.2f} deg rms", by_rule)


GOALS = (
    Goal("short-arm", "The car, 0.5 m or less between the antennas, one frequency, carrier noise of 2 mm or more: "
         "heading good to 0.5 deg rms, 99 % fixed.", _judge_short),
    Goal("half-a-second", "The car, the receivers half a second apart or more, Doppler noise of 5 cm/s or more, 2 m or less between the antennas: "
         "heading good to 1 deg rms.", _judge_apart),
)  # fmt: skip


def platforms_lab():
    """Return a fresh lab with caches of its own."""
    return Lab(
        name="platforms", title="On the move", controls=CONTROLS, presets=PRESETS, goals=GOALS, compute=PlatformsEngine().compute,
        figure=figure, drawings=drawings, describe=describe, readouts=readouts, table=table, steering=("time_offset",), blocked=blocked,
    )  # fmt: skip


def blocked(settings):
    """Return for each control without effect the reason why."""
    return {} if settings["time_offset"] else {"correction": "no effect: the receivers measure at the same instant"}


def figure(result):
    """Return both pictures as one matplotlib Figure."""
    from gnsslab.figures.platforms import plot_platforms

    return plot_platforms(result)


def drawings():
    """Return the two pictures of the lab."""
    from gnsslab.figures.platforms import build_angles, build_track

    return Drawing("journey", build_angles, 520, 520), Drawing("track", build_track, 340, 380, presented=True)


def describe(result):
    """Return the pictures in words."""
    from gnsslab.figures.platforms import describe_platforms

    return describe_platforms(result)


def readouts(result):
    """Return heading, pitch and rate errors, the share of fixed epochs, and what the offset would do."""
    if result.problem:
        return []
    best = _solved(result)
    wrong = int(result.is_wrong.sum())
    kind = "fixed" if result.is_fixed.any() else "float"
    rate_error = (result.rate.rate - result.true_rate)[1:][best[1:] & best[:-1]]
    return [
        Readout("Heading error", _number(_rms_deg(result.heading_error[best])), "deg", f"rms of the {kind} epochs"),
        Readout("Pitch error", _number(_rms_deg(result.pitch_error[best])), "deg", "rms"),
        Readout("Heading rate", _number(_rms_deg(rate_error)), "deg/s", "rms of its error"),
        Readout("Fixed", f"{_share(result.is_fixed):.1f}", "%", f"of {len(best)} seconds, {wrong or 'none'} wrong"),
        Readout("Uncorrected offset", _number(np.degrees(offset_error(result))), "deg", "atan(v dt / l) at the highest speed"),
    ]


def _number(value):
    return "none" if np.isnan(value) else f"{value:.2f}"


def table(result):
    """Return what is in the pictures as columns."""
    attitude, (heading, pitch) = result.attitude, result.truth
    return {
        "time_gps": attitude.time,
        "status": np.array(("none", "float", "fixed"))[attitude.status],
        "heading_deg": np.degrees(attitude.heading),
        "pitch_deg": np.degrees(attitude.pitch),
        "rate_deg_s": np.degrees(result.rate.rate),
        "true_heading_deg": np.degrees(heading),
        "true_pitch_deg": np.degrees(pitch),
        "true_rate_deg_s": np.degrees(result.true_rate),
        "sigma_heading_deg": np.degrees(attitude.sigma_heading),
        "satellites": attitude.satellites,
        "speed_m_s": result.journey.speed,
    }
