"""Lab of lesson 00: which way is north? Two antennas, their observations, heading and pitch."""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from gnsslab.data import DataUnavailable
from gnsslab.labs.campaigns import FileReader, blocked_by_data, no_answer, require_files, simulated_instead
from gnsslab.labs.controls import Choice, FileOrPath, Slider, Switch
from gnsslab.labs.lab import Drawing, Goal, Lab, Preset, Readout, standing
from gnsslab.simulate import draw, find_preset, idealise, observe_drawn, prepare_geometry, with_length
from gnsslab.systems.dual_antenna import dual_antenna_attitude

FIXED = 2
KEPT = 4  # simulations kept by one lab: enough to go back and forth
MM = 1e-3  # [m]
WRONG = 0.05  # [m], a fixed epoch further than this from the truth is wrong
PRESET = replace(find_preset("static-baseline"), bands=3)
REAL_DATA = "matrtklib-static"
REAL_LENGTH = 0.9902  # [m], as given with the data set

CONTROLS = (
    Choice(
        "data", "Data", {"simulated": "simulated", "real roof": "real", "my files": "mine"}, "simulated",
        help="Simulated receivers, two real ones on a roof, or your own RINEX files.",
    ),
    Choice(
        "systems", "Systems", {"GPS": "G", "Galileo": "E", "BeiDou": "C", "GPS + Galileo": "GE", "all": "GECJ"}, "G",
        help="Whose satellites are used.",
    ),
    Choice("frequencies", "Frequencies", {"one": 1, "two": 2, "three": 3}, 2, help="Carriers used of each satellite."),
    Slider("mask_deg", "Elevation mask", 5, 60, 5, 15, "deg", help="Satellites lower than this are not used."),
    Slider("length", "Baseline length", 0.3, 5, 0.1, 1.2, "m", help="From the first antenna to the second."),
    Slider("carrier_noise", "Carrier noise", 0.5, 4, 0.5, 2, "mm", help="Of one reading at the zenith; multipath adds as much."),
    Switch("single_epoch", "Each second alone", True, help="On: no memory. Off: a filter carries the whole numbers on."),
    Slider("code_noise", "Code noise", 0.1, 1.5, 0.1, 0.8, "m", help="Of one reading at the zenith; multipath adds half.", more=True),
    Switch("known_length", "Use the known length", False, help="Tell the engine the length, to 5 mm.", more=True),
    Slider("seed", "Seed", 1, 100, 1, 1, help="Another seed is another draw of the noise.", more=True),
    FileOrPath("master_file", "Master observations"),
    FileOrPath("rover_file", "Rover observations"),
    FileOrPath("navigation_file", "Broadcast navigation"),
)  # fmt: skip
FILES = ("master_file", "rover_file", "navigation_file")
SIMULATION_ONLY = ("carrier_noise", "length", "code_noise", "seed")

PRESETS = (
    Preset("start", "Start", {},
           "Most seconds are fixed. Their blue dots lie on one line; the orange ones point anywhere."),
    Preset("survey", "Survey antennas", {"carrier_noise": 1, "code_noise": 0.3},
           "Half the carrier noise and cleaner codes: every second is fixed, and the scatter of heading halves."),
    Preset("cheap", "Cheap antennas", {"carrier_noise": 3, "code_noise": 1.2},
           "A little more noise, and most seconds lose their whole numbers."),
    Preset("memory", "Cheap, with memory", {"carrier_noise": 3, "code_noise": 1.2, "single_epoch": False},
           "The same noise, but a filter carries the whole numbers on: once found, they stay, and all is blue."),
    Preset("sky", "The whole sky", {"systems": "GECJ", "frequencies": 1},
           "One frequency only, but four systems: 30 satellites and more fix every second."),
    Preset("lonely", "One frequency", {"frequencies": 1},
           "Hardly a second is fixed. And look at the blue dots far off the line: fixed, sure of themselves, and wrong."),
    Preset("short", "Arm's length", {"length": 0.3},
           "The same millimetres on a shorter lever: heading scatters four times as much."),
    Preset("city", "City street", {"mask_deg": 45, "systems": "GE"},
           "High walls hide all below 45 degrees. Few satellites are left, and what they say is weak."),
    Preset("roof", "Real roof", {"data": "real"},
           "Five minutes from a roof in Japan. The needle turns to 193 degrees, and the dots wander slowly: multipath."),
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class Campaign:
    """What one measurement campaign left behind: two receivers' observations, orbits, and what is known besides."""

    master: object  # Observations
    rover: object  # Observations
    ephemerides: object  # Ephemerides
    length: float | None = None  # [m], where it is known
    truth: "NorthTruth | None" = None


@dataclass(frozen=True, eq=False)
class NorthTruth:
    """What really was, of two antennas that stand still."""

    heading: float  # [rad]
    pitch: float  # [rad]
    baseline_enu: np.ndarray  # (3,) [m]


@dataclass(frozen=True, eq=False)
class NorthResult:
    """An attitude, the truth where it is known, and what to say."""

    settings: dict  # of the controls, all of them
    attitude: object = None  # Attitude, None where there is a problem
    truth: NorthTruth | None = None
    problem: str = ""  # one sentence where there is no attitude
    note: str = ""  # one sentence beside the picture


class NorthEngine:
    """The data of one lab instance, kept between moves, and the way from settings to a result."""

    def __init__(self):
        self._whole_sky = lru_cache(1)(lambda: prepare_geometry(PRESET))
        self._ideal = lru_cache(KEPT)(self._without_noise)
        self._drawn = lru_cache(KEPT)(self._draw)
        self._files = FileReader()
        self._simulated = lru_cache(KEPT)(self._simulate)

    def compute(self, **settings):
        """Return the NorthResult of checked settings; what a reader or the engine refuses becomes a sentence."""
        try:
            campaign, note = self._campaign(settings)
            return NorthResult(settings, _attitude(campaign, settings), campaign.truth, note=note)
        except ValueError as refusal:
            return NorthResult(settings, problem=no_answer(refusal))

    def _campaign(self, settings):
        """Return the campaign chosen, and a note where it had to be another."""
        if settings["data"] == "mine":
            return self._mine(*(settings[name] for name in FILES)), ""
        if settings["data"] == "real":
            try:
                return self._real(), ""
            except DataUnavailable as reason:
                return self._simulation(settings), simulated_instead(reason)
        return self._simulation(settings), ""

    def _simulation(self, settings):
        return self._simulated(settings["systems"], *(settings[name] for name in SIMULATION_ONLY))

    def _simulate(self, systems, carrier_noise_mm, length, code_noise, seed):
        carrier = carrier_noise_mm * MM
        noise = replace(PRESET.noise, carrier=carrier, carrier_multipath=carrier, code=code_noise, code_multipath=code_noise / 2)
        simulation = observe_drawn(*self._ideal(length, systems), self._drawn(seed), noise)
        return Campaign(*simulation.observations, simulation.ephemerides, length, _truth_at_rest(simulation.truth))

    def _without_noise(self, length, systems):
        """Return the Geometry of the satellites of some systems, and their ideal measurements."""
        satellites = tuple(name for name in self._whole_sky().tracks.satellites if name[0] in systems)
        geometry = prepare_geometry(replace(with_length(PRESET, length), satellites=satellites))
        return geometry, idealise(geometry)

    def _draw(self, seed):
        """Return the errors of all systems: those of one do not depend on which others are used."""
        return draw(self._whole_sky(), np.random.default_rng(seed))

    def _real(self):
        return Campaign(*self._files.data_set(REAL_DATA), REAL_LENGTH)

    def _mine(self, master, rover, navigation):
        require_files(master=master, rover=rover, navigation=navigation)
        return Campaign(self._files.observations(master), self._files.observations(rover), self._files.ephemerides(navigation))


def _truth_at_rest(truth):
    """Return the truth of a simulation in which nothing moves: its first epoch."""
    return NorthTruth(float(truth.heading[0]), float(truth.pitch[0]), truth.baselines_enu[0, 0])


def _attitude(campaign, settings):
    """Run the engine on a campaign's observations."""
    return dual_antenna_attitude(
        campaign.master,
        campaign.rover,
        campaign.ephemerides,
        length=campaign.length if settings["known_length"] else None,
        systems=settings["systems"],
        frequencies=settings["frequencies"],
        mask_deg=settings["mask_deg"],
        single_epoch=settings["single_epoch"],
    )


def _judge_sharp(result):
    used, scatter, fixed = result.settings, _heading_scatter(result), _fixed_percent(result)
    by_rule = used["data"] == "simulated" and used["carrier_noise"] >= 2 and used["single_epoch"]
    return by_rule and scatter < 0.05 and fixed >= 95, standing(f"scatter {scatter:.2f} deg, {fixed:.1f} % fixed", by_rule)


def _judge_frugal(result):
    used, fixed = result.settings, _fixed_percent(result)
    by_rule = used["data"] == "simulated" and used["systems"] == "G" and used["frequencies"] == 2 and used["code_noise"] >= 1
    return by_rule and fixed >= 95, standing(f"{fixed:.1f} % fixed", by_rule)


GOALS = (
    Goal("sharp", "Simulated data, each second alone, carrier noise of 2 mm or more: bring the scatter of heading below "
         "0.05 deg, with 95 % of the seconds fixed.", _judge_sharp),
    Goal("frugal", "Simulated data, GPS alone, two frequencies, code noise of 1 m or more: fix 95 % of the seconds.",
         _judge_frugal),
)  # fmt: skip


def north_lab():
    """Return a fresh lab with caches of its own."""
    return Lab(
        name="north", title="Which way is north?", controls=CONTROLS, presets=PRESETS, goals=GOALS,
        compute=NorthEngine().compute, figure=figure, drawings=drawings, describe=describe, readouts=readouts, table=table,
        steering=("data",), blocked=blocked,
    )  # fmt: skip


def blocked(settings):
    """Return for each control without effect on the chosen data the reason why."""
    unknown = {"known_length": "the length of your baseline is not known here"} if settings["data"] == "mine" else {}
    return blocked_by_data(settings["data"], SIMULATION_ONLY, FILES) | unknown


def figure(result):
    """Return the whole picture as one matplotlib Figure."""
    from gnsslab.figures.attitude import plot_attitude

    return plot_attitude(result.attitude, result.truth)


def drawings():
    """Return the two pictures of the lab."""
    from gnsslab.figures.attitude import build_angles, build_compass

    return (
        Drawing("angles", lambda part: _of_result(build_angles(part)), 500, 420),
        Drawing("compass", lambda part: _of_result(build_compass(part)), 340, 340),
    )


def _of_result(scene):
    from gnsslab.figures.kept import Scene

    return Scene(scene.moving, lambda result: scene.show((result.attitude, result.truth)))


def describe(result):
    """Return the picture in words."""
    from gnsslab.figures.attitude import describe_attitude

    return describe_attitude(result.attitude, result.truth)


def readouts(result):
    """Return heading, pitch, share of fixed epochs and length, of the best epochs there are."""
    if result.problem:
        return []
    attitude, best = result.attitude, _best(result.attitude)
    fixed = Readout("Fixed", f"{_fixed_percent(result):.1f}", "%", f"of {len(attitude.status)} seconds{_wrong_words(result)}")
    if not best.any():
        return [Readout("Heading", "none"), Readout("Pitch", "none"), fixed, Readout("Length", "none")]
    e, n, u = np.median(attitude.baseline_enu[best], axis=0)
    length = attitude.length[best]
    return [
        _angle("Heading", np.arctan2(e, n) % (2 * np.pi), attitude.heading[best]),
        _angle("Pitch", np.arctan2(u, np.hypot(e, n)), attitude.pitch[best]),
        fixed,
        Readout("Length", f"{np.median(length):.3f}", "m", f"scatter {np.quantile(np.abs(length - np.median(length)), 0.683) / MM:.1f} mm"),
    ]


def table(result):
    """Return what is in the picture as columns."""
    attitude = result.attitude
    east, north, up = attitude.baseline_enu.T
    return {
        "time_gps": attitude.time,
        "status": np.array(("none", "float", "fixed"))[attitude.status],
        "heading_deg": np.degrees(attitude.heading),
        "pitch_deg": np.degrees(attitude.pitch),
        "east_m": east,
        "north_m": north,
        "up_m": up,
        "sigma_heading_deg": np.degrees(attitude.sigma_heading),
        "sigma_pitch_deg": np.degrees(attitude.sigma_pitch),
    }


def _angle(label, middle, angles):
    return Readout(label, f"{np.degrees(middle):.2f}", "deg", f"scatter {_scatter(angles):.2f} deg")


def _wrong_words(result):
    """Return how many fixed epochs are wrong, where the truth is known."""
    if result.truth is None:
        return ""
    fixed = result.attitude.baseline_enu[result.attitude.status == FIXED]
    wrong = int(np.sum(np.linalg.norm(fixed - result.truth.baseline_enu, axis=1) > WRONG))
    return f", {wrong} of them wrong" if wrong else ", none wrong"


def _best(attitude):
    """Return which epochs have the best status there is, (T,) bool."""
    return (attitude.status == np.max(attitude.status, initial=0)) & np.isfinite(attitude.heading)


def _heading_scatter(result):
    best = _best(result.attitude) if result.attitude is not None else np.zeros(0, bool)
    return _scatter(result.attitude.heading[best]) if best.any() else float("inf")


def _fixed_percent(result):
    return 100 * float(np.mean(result.attitude.status == FIXED)) if result.attitude is not None else 0.0


def _scatter(angle):
    """Return the distance [deg] from their middle within which 68 % of the angles [rad] lie: sigma, were they Gaussian."""
    middle = np.angle(np.median(np.exp(1j * angle).real) + 1j * np.median(np.exp(1j * angle).imag))
    return float(np.degrees(np.quantile(np.abs(np.angle(np.exp(1j * (angle - middle)))), 0.683)))
