"""Lab of lesson 01: the whole sky at one time. Where the satellites stand, how well they fix a place, and how much each of them errs."""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from gnsslab.core.least_squares import least_squares
from gnsslab.data import DataUnavailable, find_dataset
from gnsslab.gnss.frames import ecef_from_geodetic, enu_rotation
from gnsslab.gnss.points import solve_points
from gnsslab.gnss.signals import USED_SYSTEMS, wavelength
from gnsslab.gnss.times import add_seconds
from gnsslab.gnss.weighting import TYPICAL_CN0, NoiseModel, sigma_code
from gnsslab.labs.campaigns import FileReader, blocked_by_data, no_answer, require_files, simulated_instead
from gnsslab.labs.controls import Choice, FileOrPath, Slider
from gnsslab.labs.lab import Drawing, Goal, Lab, Preset, Readout, standing
from gnsslab.simulate import Noise, Static, find_preset, prepare_geometry
from gnsslab.simulate.measurements import measure
from gnsslab.simulate.recording import record
from gnsslab.systems.printed_ranges import sigma_code_as_printed

KEPT = 16  # skies kept by one lab
LONGITUDE = 135.0  # [deg], nine hours east of Greenwich to the minute
MIDNIGHT = np.datetime64("2024-06-23T15:00:00", "ns")  # GPS time of local midnight there
EPOCHS, EVERY = 11, 30.0  # five minutes, an epoch every 30 s, the sky drawn as it is in the middle
MOST_EPOCHS = 60  # of a real recording, spread over it
REAL_DATA = {"real": "matrtklib-static", "station": "cssrlib-078"}
PRESET = replace(
    find_preset("static-baseline"), duration=EPOCHS * EVERY, interval=EVERY, bands=1, mask_deg=0.0,
    trajectory=Static(), antennas=((0.0, 0.0, 0.0),), base=(0.0, 1.0, 0.0),
)  # fmt: skip


def engine_sigma(elevation):
    """Return the sigma of a code [m] at elevations [rad] as the engine takes it: 0.4 m at the zenith, growing towards the horizon."""
    return sigma_code(NoiseModel(), elevation, TYPICAL_CN0, wavelength("G", "1"))


def flat_sigma(elevation):
    """Return the sigma of a code [m] that paper D1 (1998) sets for its Rockwell receivers: 3 m for every satellite."""
    return np.full(np.shape(elevation), 3.0)


SIGMAS = {"law": engine_sigma, "flat": flat_sigma, "printed": sigma_code_as_printed}

CONTROLS = (
    Choice(
        "data", "Data", {"simulated": "simulated", "real roof": "real", "GEONET": "station", "my files": "mine"}, "simulated",
        help="A simulated receiver, a real one on a roof, one near a GEONET station (travels with the course), or your own.",
    ),
    Slider("hour", "Time of day", 0, 24, 0.5, 10, "h", help="Local time; within an hour it is another sky."),
    Slider("latitude_deg", "Latitude", -90, 90, 5, 35, "deg", help="Where you stand, on the meridian of Japan."),
    Choice("systems", "Systems", {"GPS": "G", "Galileo": "E", "GPS + Galileo": "GE", "all": "GECJ"}, "G", help="Whose satellites are used."),
    Slider("mask_deg", "Elevation mask", 0, 60, 5, 10, "deg", help="Satellites lower than this are not used."),
    Slider("multipath", "Multipath", 0, 3, 0.1, 0.2, "m", help="In a code at the zenith; it grows as 1/sin of the elevation."),
    Slider("code_noise", "Code noise", 0.1, 1.5, 0.1, 0.3, "m", help="Of one reading at the zenith.", more=True),
    Choice("ionosphere", "True ionosphere", {"as broadcast": 1, "twice as much": 2}, 1,
           help="The engine corrects by the broadcast model.", more=True),
    Choice("sigma", "Sigma promised", {"law by elevation": "law", "3 m for all": "flat", "3 cm, as printed": "printed"}, "law",
           help="What is promised of one code: the blue band in the first picture.", more=True),
    Slider("seed", "Seed", 1, 100, 1, 1, help="Another seed is another draw of the noise.", more=True),
    FileOrPath("observation_file", "Observations"),
    FileOrPath("navigation_file", "Broadcast navigation"),
)  # fmt: skip
FILES = ("observation_file", "navigation_file")
SIMULATION_ONLY = ("hour", "latitude_deg", "multipath", "code_noise", "ionosphere", "seed")

PRESETS = (
    Preset("sky", "Start", {},
           "A fan: overhead the codes err by less than half a metre, near the horizon by up to two metres."),
    Preset("high-mask", "High mask", {"mask_deg": 35},
           "The bad satellites are gone, and so is the geometry: the residuals shrink, yet up is worse than before."),
    Preset("city", "City street", {"mask_deg": 50, "systems": "GE"},
           "Five satellites of two systems stand above the roofs, close together: small residuals, and a height that is off by 12 m."),
    Preset("all-systems", "The whole sky", {"systems": "GECJ"},
           "Nearly forty satellites of four systems: DOP nearly halves, and the error with it, though each code is as noisy as before."),
    Preset("bad-site", "Bad site", {"multipath": 1.5},
           "The fan opens: near the horizon the codes are off by ten metres, far outside what the engine promises."),
    Preset("noon", "Noon and stormy", {"hour": 13, "ionosphere": 2, "mask_deg": 5},
           "Half of the ionosphere is left in the codes: low ones are too long, high ones too short, and the height is off by 6 m."),
    Preset("pole", "At the pole", {"latitude_deg": 90},
           "GPS never rises above 47 degrees here: the sky overhead is empty, and up is weak although ten satellites are in sight."),
    Preset("three-centimetres", "As printed", {"sigma": "printed"},
           "With 3 cm for 3 m the band is a hair line and nearly all residuals lie outside: the promise is a hundred times too good."),
    Preset("real-sky", "Real sky", {"data": "real", "systems": "GECJ"},
           "A real sky over Japan: all codes of one satellite err together, by orbit, clock and ionosphere. That is no noise."),
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class View:
    """The sky over one receiver: T epochs, m satellites; NaN where one was not seen."""

    time: np.ndarray  # (T,) datetime64[ns]
    names: tuple[str, ...]  # (m,)
    azimuth: np.ndarray  # (T, m) [rad]
    elevation: np.ndarray  # (T, m) [rad]
    used: np.ndarray  # (T, m) bool
    residual: np.ndarray  # (T, m) [m], code minus what it should read at the known place, clock taken out
    shown: int  # epoch at which the sky is drawn
    dop: np.ndarray  # (4,) geometric, position, horizontal, vertical at the epoch shown
    mask: float  # [rad]
    law_elevation: np.ndarray  # (k,) [rad]
    law_sigma: np.ndarray  # (k,) [m], what is promised of one code
    within: float  # share of the residuals within one sigma
    error_enu: np.ndarray  # (T, 3) [m], found minus true place; about the mean where the truth is not known
    promised: np.ndarray  # (2,) [m], level and up, from the promised sigma and the geometry
    is_truth_known: bool

    @property
    def error(self):
        """Root mean square error (2,) [m], level and up; NaN where no epoch is solved."""
        square = self.error_enu[np.isfinite(self.error_enu).all(axis=1)] ** 2
        if not len(square):
            return np.full(2, np.nan)
        return np.sqrt([square[:, :2].sum(axis=1).mean(), square[:, 2].mean()])


@dataclass(frozen=True, eq=False)
class SkyResult:
    """A View of the sky and what to say."""

    settings: dict  # of the controls, all of them
    view: View | None = None  # None where there is a problem
    problem: str = ""
    note: str = ""


@dataclass(frozen=True, eq=False)
class _Site:
    """What one receiver at rest recorded, and where it stood if that is known."""

    observations: object  # Observations
    ephemerides: object  # Ephemerides
    place: np.ndarray | None  # (3,) ECEF [m]


class SkyEngine:
    """The skies of one lab instance, kept between moves, and the way from settings to a result."""

    def __init__(self):
        self._files = FileReader()
        self._geometry = lru_cache(KEPT)(_geometry)
        self._simulated = lru_cache(KEPT)(self._simulate)

    def compute(self, **settings):
        """Return the SkyResult of checked settings; what a reader or the engine refuses becomes a sentence."""
        try:
            site, note = self._site(settings)
            return SkyResult(settings, _view(site, settings), note=note)
        except ValueError as refusal:
            return SkyResult(settings, problem=no_answer(refusal))

    def _site(self, settings):
        """Return the site chosen, and a note where it had to be another."""
        if settings["data"] == "mine":
            return self._mine(*(settings[name] for name in FILES)), ""
        if settings["data"] in REAL_DATA:
            try:
                return self._real(REAL_DATA[settings["data"]]), ""
            except DataUnavailable as reason:
                return self._simulation(settings), simulated_instead(reason)
        return self._simulation(settings), ""

    def _simulation(self, settings):
        return self._simulated(settings["systems"], *(settings[name] for name in SIMULATION_ONLY))

    def _simulate(self, systems, hour, latitude_deg, multipath, code_noise, ionosphere, seed):
        geometry = self._geometry(systems, hour, latitude_deg, ionosphere)
        noise = Noise(code=code_noise, code_multipath=multipath)
        observations = record(geometry.preset, measure(geometry, noise, np.random.default_rng(seed)), 0)
        latitude, longitude, height = geometry.preset.site
        place = ecef_from_geodetic([np.radians(latitude), np.radians(longitude), height])
        return _Site(observations, geometry.tracks.ephemerides, place + enu_rotation(place).T @ PRESET.base)

    def _real(self, name):
        base, _, ephemerides = self._files.data_set(name)
        return _Site(base, ephemerides, find_dataset(name).base_position)

    def _mine(self, observations, navigation):
        require_files(observation=observations, navigation=navigation)
        return _Site(self._files.observations(observations), self._files.ephemerides(navigation), None)


def _geometry(systems, hour, latitude_deg, ionosphere):
    start = str(add_seconds(MIDNIGHT, 3600.0 * hour - EVERY * (EPOCHS // 2)))
    delays = tuple(ionosphere * a for a in PRESET.ionosphere[:4]) + PRESET.ionosphere[4:]
    return prepare_geometry(replace(PRESET, systems=systems, start=start, site=(latitude_deg, LONGITUDE, 100.0), ionosphere=delays))


def _view(site, settings):
    """Return the View of a site: single points at its epochs, judged against the promised sigma."""
    points = _points(site, settings)
    sigma, law = SIGMAS[settings["sigma"]], np.radians(np.linspace(3, 90, 60))
    place = points.mean_position() if site.place is None else site.place
    error_enu = (points.position_ecef - place) @ enu_rotation(place).T
    residual = _residuals_at(error_enu, points)
    shown = int(np.argmin(np.where(points.is_solved, np.abs(np.arange(len(points.time)) - len(points.time) // 2), np.inf)))
    return View(
        time=points.time, names=points.names, azimuth=points.azimuth, elevation=points.elevation, used=points.used, residual=residual, shown=shown,
        dop=points.dop[shown], mask=np.radians(settings["mask_deg"]), law_elevation=law, law_sigma=sigma(law),
        within=_within(residual, sigma(np.maximum(points.elevation, law[0]))), error_enu=error_enu,
        promised=_promised(points, shown, sigma), is_truth_known=site.place is not None,
    )  # fmt: skip


def _points(site, settings):
    """Return the single Points of a site, of at most about MOST_EPOCHS epochs; ValueError in words where there is none."""
    systems = _systems_there(site.observations, settings["systems"])
    every = max(1, len(site.observations.time) // MOST_EPOCHS)
    points = solve_points(site.observations, site.ephemerides, systems=systems, mask_deg=settings["mask_deg"], epochs=slice(None, None, every))
    if not points.is_solved.any():
        raise ValueError(f"no place could be found: {points.main_reason()}")
    return points


def _systems_there(observations, wanted):
    there = "".join(letter for letter in wanted if letter in observations.tables)
    if not there:
        has = ", ".join(letter for letter in USED_SYSTEMS if letter in observations.tables) or "none that can be used"
        raise ValueError(f"these observations hold no satellite of the chosen systems; they have {has}")
    return there


def _residuals_at(error_enu, points):
    """Return the residuals (T, m) [m] at the known place: those at the place found, moved by u . error; each system's mean, its clock, taken out."""
    residual = points.residual - np.einsum("tmi,ti->tm", _directions(points.azimuth, points.elevation), error_enu)
    letters = np.array([name[0] for name in points.names])
    for system in points.systems:
        own = letters == system
        used = points.used[:, own]
        mean = np.sum(np.where(used, residual[:, own], 0.0), axis=1) / np.maximum(used.sum(axis=1), 1)
        residual[:, own] -= mean[:, None]
    return residual


def _directions(azimuth, elevation):
    """Return unit vectors (..., 3) east, north, up."""
    level = np.cos(elevation)
    return np.stack([np.sin(azimuth) * level, np.cos(azimuth) * level, np.sin(elevation)], axis=-1)


def _within(residual, sigma):
    """Return the share of the residuals that lie within one sigma."""
    known = np.isfinite(residual)
    return float(np.mean(np.abs(residual[known]) <= sigma[known]))


def _promised(points, epoch, sigma):
    """Return the promised error (2,) [m], level and up, at an epoch: Q = (A' W A)^-1, A = [-u, one clock a system], W = 1 / sigma^2."""
    used = points.used[epoch]
    elevation = points.elevation[epoch, used]
    u = _directions(points.azimuth[epoch, used], elevation)
    letters = np.array([name[0] for name in points.names])[used]
    clocks = [letters == system for system in points.systems if (letters == system).any()]
    A = np.column_stack([-u, *clocks]).astype(float)
    Q = least_squares(A, np.zeros(len(A)), sigma(elevation), np.ones(len(A), dtype=bool)).Q
    return np.sqrt([Q[0, 0] + Q[1, 1], Q[2, 2]])


def _judge_high(result):
    used, view = result.settings, result.view
    if view is None:
        return False, "Now: no answer."
    hdop, by_rule = view.dop[2], used["data"] == "simulated" and used["mask_deg"] >= 25
    return by_rule and hdop < 1.0, standing(f"HDOP {hdop:.2f} with a mask of {used['mask_deg']:g} deg", by_rule)


def _judge_gps(result):
    used, view = result.settings, result.view
    if view is None:
        return False, "Now: no answer."
    by_rule = used["data"] == "simulated" and used["systems"] == "G" and used["mask_deg"] >= 15
    return by_rule and view.dop[3] < 1.3, standing(f"VDOP {view.dop[3]:.2f}", by_rule)


GOALS = (
    Goal("high", "Simulated data: bring HDOP below 1.0 with an elevation mask of 25 deg or more.", _judge_high),
    Goal("gps", "Simulated data, GPS alone, a mask of 15 deg or more: find a time and a place with VDOP below 1.3.", _judge_gps),
)


def sky_lab():
    """Return a fresh lab with caches of its own."""
    return Lab(
        name="sky", title="The whole sky", controls=CONTROLS, presets=PRESETS, goals=GOALS,
        compute=SkyEngine().compute, figure=figure, drawings=drawings, describe=describe, readouts=readouts, table=table,
        steering=("data",), blocked=blocked,
    )  # fmt: skip


def blocked(settings):
    """Return for each control without effect on the chosen data the reason why."""
    return blocked_by_data(settings["data"], SIMULATION_ONLY, FILES)


def figure(result):
    """Return the whole picture as one matplotlib Figure."""
    from gnsslab.figures.sky import plot_sky

    return plot_sky(result.view)


def drawings():
    """Return the two pictures of the lab."""
    from gnsslab.figures.sky import build_residuals, build_sky

    return (
        Drawing("residuals", lambda part: _of_result(build_residuals(part)), 500, 420),
        Drawing("sky", lambda part: _of_result(build_sky(part)), 380, 400),
    )


def _of_result(scene):
    from gnsslab.figures.kept import Scene

    return Scene(scene.moving, lambda result: scene.show(result.view))


def describe(result):
    """Return the picture in words."""
    from gnsslab.figures.sky import describe_sky

    return describe_sky(result.view)


def readouts(result):
    """Return HDOP, VDOP, how many satellites, the error of the place and the share of residuals within one sigma."""
    if result.problem:
        return []
    view = result.view
    (level, up), (level_promised, up_promised) = view.error, view.promised
    above = int((view.elevation[view.shown] > 0).sum())
    kind = "" if view.is_truth_known else " about the mean"
    return [
        Readout("HDOP", f"{view.dop[2]:.2f}", "", "level: metres of place for each metre of code"),
        Readout("VDOP", f"{view.dop[3]:.2f}", "", "up"),
        Readout("Satellites", f"{int(view.used[view.shown].sum())}", "", f"used, of {above} above the horizon"),
        Readout("Error", f"{level:.2f}", "m", f"level{kind}, promised {level_promised:.2f}; up {up:.2f}, promised {up_promised:.2f}"),
        Readout("Within one sigma", f"{100 * view.within:.0f}", "%", "of the residuals; 68 would be right"),
    ]


def table(result):
    """Return what is in the picture as columns, one row a satellite and epoch."""
    view = result.view
    epoch, column = np.nonzero(np.isfinite(view.elevation))
    return {
        "time_gps": view.time[epoch],
        "satellite": np.array(view.names)[column],
        "azimuth_deg": np.degrees(view.azimuth[epoch, column]),
        "elevation_deg": np.degrees(view.elevation[epoch, column]),
        "used": view.used[epoch, column],
        "residual_m": view.residual[epoch, column],
    }
