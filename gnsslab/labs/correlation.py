"""Lab of lesson 02: the covariance of double differences, and what a solver gets that ignores half of it."""

from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from gnsslab.data import DataUnavailable
from gnsslab.gnss.correlation import double_difference_covariance, without_correlation
from gnsslab.gnss.frames import enu_rotation
from gnsslab.gnss.modelling import build_model
from gnsslab.gnss.signals import wavelength
from gnsslab.gnss.weighting import NoiseModel
from gnsslab.labs.campaigns import FileReader, blocked_by_data, no_answer, require_files, simulated_instead
from gnsslab.labs.controls import Choice, FileOrPath, Slider, Switch
from gnsslab.labs.lab import Drawing, Goal, Lab, Preset, Readout, standing
from gnsslab.labs.single_epochs import SingleDifferences, fixed_baselines, sampled_covariance, solve_each_epoch
from gnsslab.labs.skies import open_sky
from gnsslab.labs.static_pairs import static_pair
from gnsslab.simulate.receivers import white_factor
from gnsslab.systems.printed_differences import doubled_covariance_as_printed, unsquared_covariance_as_printed

MM = 1e-3
EPOCHS = 1000  # drawn of a simulation: a share of them is good to 1.6 %, a variance to 4.5 %
FEWEST_EPOCHS = 20  # of real data with all the satellites asked for
FEWEST_SATELLITES = 5  # one more than a position needs, so that there is something to compare
KEPT = 4
REAL_DATA = "geonet-0759-3040"
MOMENT = "2024-06-24T05:20:00"
REAL_MASK = np.radians(15.0)


def ignoring_correlation(sigma, reference):
    """Return the covariance of one who gets the variances right and ignores that all differences share the reference."""
    return without_correlation(double_difference_covariance(sigma, reference))


BELIEFS = {
    "respected": double_difference_covariance,
    "ignored": ignoring_correlation,
    "unsquared": unsquared_covariance_as_printed,
    "doubled": doubled_covariance_as_printed,
}

CONTROLS = (
    Choice("data", "Data", {"simulated": "simulated", "real pair": "real", "my files": "mine"}, "simulated",
           help="Simulated, two stations in Japan 3.3 km apart, or your own RINEX files."),
    Choice("belief", "The solver believes",
           {"correlation respected": "respected", "correlation ignored": "ignored", "as printed: not squared": "unsquared",
            "as printed: 2 V": "doubled"}, "respected",
           help="The covariance that it works with. The measurements stay the same."),
    Slider("satellites", "Satellites", FEWEST_SATELLITES, 9, 1, 8, help="Of GPS, from the highest to the lowest; one carrier."),
    Choice("reference", "Reference satellite", {"highest": "high", "middle": "middle", "lowest": "low"}, "high",
           help="Which one is taken off all others."),
    Switch("growing", "Noise grows towards the horizon", False, help="Off: all satellites equally good. On: the low ones are worse, and weigh less."),
    Slider("code_noise", "Code noise", 0.1, 1, 0.05, 0.3, "m", help="Of one reading of one receiver, at the zenith."),
    Slider("carrier_noise", "Carrier noise", 1, 10, 0.5, 3, "mm", help="Of one reading of one receiver, at the zenith.", more=True),
    Slider("seed", "Seed", 1, 100, 1, 2, help="Another seed is another draw of the noise.", more=True),
    FileOrPath("master_file", "Master observations"),
    FileOrPath("rover_file", "Rover observations"),
    FileOrPath("navigation_file", "Broadcast navigation"),
)  # fmt: skip
FILES = ("master_file", "rover_file", "navigation_file")
SIMULATION_ONLY = ("code_noise", "carrier_noise", "seed")

PRESETS = (
    Preset("pattern", "Start", {},
           "Left, from the noise itself: about 4 on the diagonal and 2 beside it. Right, by the formula: the same, and most epochs are solved."),
    Preset("ignored", "Ignored", {"belief": "ignored"},
           "The same measurements, the zeros on the right: the ratios fall, and up scatters more than the solver admits."),
    Preset("low-respected", "Low reference", {"growing": True, "reference": "low", "satellites": 9, "code_noise": 0.2},
           "The worst satellite is the reference and its noise is in every difference, but the solver knows: no other reference would do better."),
    Preset("low-ignored", "Low reference, ignored",
           {"growing": True, "reference": "low", "satellites": 9, "code_noise": 0.2, "belief": "ignored"},
           "The same measurements once more: a solver that thinks the differences independent loses most of its epochs."),
    Preset("doubled", "2 V", {"belief": "doubled"},
           "A paper of 1998 has 8-4-4: every sigma is 1.4 times too large, but the ratios do not move, as a common factor cancels in them."),
    Preset("unsquared", "Not squared", {"belief": "unsquared"},
           "A paper of 2019 has sigmas where variances belong: carriers look 13 times worse than they are, and hardly an epoch is believed."),
    Preset("few", "Six satellites", {"satellites": 6},
           "Five differences for three coordinates: most integers are lost, whatever the solver believes."),
    Preset("real-pattern", "Real stations", {"data": "real", "satellites": 6, "reference": "low"},
           "Nobody simulated this: the residuals of an hour in Japan show the pattern by themselves, on the left."),
    Preset("real-ignored", "Real, ignored", {"data": "real", "satellites": 6, "reference": "low", "belief": "ignored"},
           "The same hour with the correlation ignored: fewer epochs get the right integers, and the baseline now depends on the reference."),
)  # fmt: skip


class Case(NamedTuple):
    """Measurements to solve."""

    data: SingleDifferences
    satellites: tuple[str, ...]  # (m,) highest first
    sigma_is_known: bool  # a simulation's are, a real receiver's are assumed
    note: str = ""


@dataclass(frozen=True, eq=False)
class CorrelationResult:
    """What the noise does, what the solver believes, and what came of it."""

    settings: dict  # of the controls, all of them
    sampled: np.ndarray | None = None  # (n, n) covariance of the carriers' double differences, in units of one reading's variance
    believed: np.ndarray | None = None  # (n, n) the same as the solver has it
    solved: object = None  # Solved
    best: object = None  # Solved, by a solver that respects the correlation
    moved: float = 0.0  # [m], rms by which the baseline moves from the highest to the lowest reference
    satellites: tuple[str, ...] = ()  # (m,) highest first
    reference: int = 0  # index into satellites
    problem: str = ""
    note: str = ""


class CorrelationEngine:
    """The data of one lab instance, kept between moves, and the way from settings to a result."""

    def __init__(self):
        self._model = lru_cache(KEPT)(_real_model)
        self._files = FileReader()

    def compute(self, **settings):
        """Return the CorrelationResult of checked settings; what a reader or the engine refuses becomes a sentence."""
        try:
            return _solve(settings, self._case(settings))
        except ValueError as refusal:
            return CorrelationResult(settings, problem=no_answer(refusal))

    def _case(self, settings):
        """Return the Case chosen, with a note where it had to be another."""
        if settings["data"] == "mine":
            return self._mine(settings)
        if settings["data"] == "real":
            try:
                return _from_model(self._model(*self._files.data_set(REAL_DATA)), settings)
            except DataUnavailable as reason:
                return _simulate(settings)._replace(note=simulated_instead(reason))
        return _simulate(settings)

    def _mine(self, settings):
        master, rover, navigation = (settings[name] for name in FILES)
        require_files(master=master, rover=rover, navigation=navigation)
        observations = (self._files.observations(path) for path in (master, rover))
        return _from_model(self._model(*observations, self._files.ephemerides(navigation)), settings)


def _simulate(settings):
    """Return a Case drawn at random about a known baseline."""
    sky = open_sky("G", start=MOMENT).spread(settings["satellites"])
    growth = white_factor(sky.elevation) if settings["growing"] else np.ones(len(sky.names))
    sigma_code, sigma_phase = settings["code_noise"] * growth, settings["carrier_noise"] * MM * growth
    rng = np.random.default_rng(settings["seed"])
    (code, phase), lam = rng.standard_normal((2, 2, EPOCHS, len(sky.names))), wavelength("G", "1")  # each (receiver, T, m)
    integers = rng.integers(-1000, 1000, len(sky.names))
    data = SingleDifferences(
        code=(code[1] - code[0]) * sigma_code,
        phase=(phase[1] - phase[0]) * sigma_phase + lam * integers,
        design=-sky.u[np.newaxis],
        sigma_code=sigma_code,
        sigma_phase=sigma_phase,
        integers=integers,
        wavelength=lam,
    )
    return Case(data, sky.names, sigma_is_known=True)


def _real_model(base, rover, ephemerides):
    """Return the Model of two receivers at rest, about the baseline that the engine found."""
    found = static_pair(base, rover, ephemerides)
    T = len(found.pair.time)
    ends = (np.broadcast_to(end, (T, 3)) for end in (found.master_ecef, found.rover_ecef))
    return build_model(found.pair, *ends, ephemerides, REAL_MASK, NoiseModel(), np.zeros(T, dtype=bool)), enu_rotation(found.master_ecef)


def _from_model(model_and_axes, settings):
    """Return the Case of the satellites tracked longest, at the epochs that have them all, with a note where they are fewer than asked for."""
    model, R_ne = model_and_axes
    longest = np.argsort(-model.usable.sum(axis=0), kind="stable")
    count = _most_together(model.usable[:, longest], settings["satellites"])
    chosen = longest[:count]
    chosen = chosen[np.argsort(np.nanmedian(model.sigma_phase[:, chosen], axis=0))]  # the carrier's sigma grows downwards: the highest first
    rows = model.usable[:, chosen].all(axis=1)
    phase, lam = model.phase[rows][:, chosen], float(model.pair.wavelength[0])
    data = SingleDifferences(
        code=model.code[rows][:, chosen],
        phase=phase,
        design=model.design[rows][:, chosen] @ R_ne.T,
        sigma_code=_one_reading(model.sigma_code[rows][:, chosen], settings["growing"]),
        sigma_phase=_one_reading(model.sigma_phase[rows][:, chosen], settings["growing"]),
        integers=np.rint(np.median((phase - phase[:, :1]) / lam, axis=0)).astype(np.int64),
        wavelength=lam,
    )
    few = f"No more than {count} satellites were tracked together for {FEWEST_EPOCHS} epochs, so {count} are used."
    names = tuple(model.pair.satellites[model.pair.satellite[k]] for k in chosen)
    return Case(data, names, sigma_is_known=False, note="" if count == settings["satellites"] else few)


def _most_together(usable, wanted):
    """Return how many of the first columns of usable (T, c), `wanted` at most, are True together for long enough."""
    for count in range(min(wanted, usable.shape[1]), FEWEST_SATELLITES - 1, -1):
        if usable[:, :count].all(axis=1).sum() >= FEWEST_EPOCHS:
            return count
    raise ValueError(f"fewer than {FEWEST_SATELLITES} satellites were tracked together for {FEWEST_EPOCHS} epochs: give a longer span of open sky")


def _one_reading(sigma, growing):
    """Return sigmas (m,) of one receiver's readings from those of single differences (T, m); one for all where they shall not grow."""
    typical = np.median(sigma, axis=0) / np.sqrt(2)
    return typical if growing else np.full_like(typical, np.sqrt(np.mean(typical**2)))


def _solve(settings, case):
    """Return the result of a case."""
    data, m = case.data, len(case.satellites)
    reference = {"high": 0, "middle": m // 2, "low": m - 1}[settings["reference"]]
    belief, unit = BELIEFS[settings["belief"]], data.sigma_phase.min() ** 2
    sampled = sampled_covariance(data, reference)
    solved = solve_each_epoch(data, reference, belief)
    return CorrelationResult(
        settings,
        sampled=sampled / (unit if case.sigma_is_known else _fitting_unit(data, sampled, reference)),
        believed=belief(data.sigma_phase, reference) / unit,
        solved=solved,
        best=solved if belief is double_difference_covariance else solve_each_epoch(data, reference, double_difference_covariance),
        moved=_moved(data, belief),
        satellites=case.satellites,
        reference=reference,
        note=case.note,
    )


def _moved(data, belief):
    """Return by how much [m], rms, the baselines change from the highest to the lowest satellite as reference."""
    high, low = (fixed_baselines(data, reference, belief)[0] for reference in (0, len(data.integers) - 1))
    return float(np.sqrt(np.mean(np.sum((high - low) ** 2, axis=1))))


def _fitting_unit(data, sampled, reference):
    """Return the variance [m^2] of one reading at which a measured covariance is, on its diagonal, as large as the formula has it."""
    formula = double_difference_covariance(data.sigma_phase / data.sigma_phase.min(), reference)
    return np.trace(sampled) / np.trace(formula)


def correlation_lab():
    """Return a fresh lab with caches of its own."""
    return Lab(
        name="correlation", title="What differences have in common", controls=CONTROLS, presets=PRESETS, goals=GOALS,
        compute=CorrelationEngine().compute, figure=figure, drawings=drawings, describe=describe, readouts=readouts, table=table,
        steering=("data",), blocked=blocked,
    )  # fmt: skip


def blocked(settings):
    """Return for each control without effect on the chosen data the reason why."""
    return blocked_by_data(settings["data"], SIMULATION_ONLY, FILES)


def figure(result):
    """Return the whole picture as one matplotlib Figure."""
    from gnsslab.figures.correlation import plot_correlation

    return plot_correlation(result)


def drawings():
    """Return the two pictures of the lab."""
    from gnsslab.figures.correlation import build_cloud, build_pattern

    return Drawing("pattern", build_pattern, 460, 480), Drawing("cloud", build_cloud, 350, 360)


def describe(result):
    """Return the pictures in words."""
    from gnsslab.figures.correlation import describe_correlation

    return result.problem or describe_correlation(result)


def readouts(result):
    """Return the share of right integers, the ratio, the scatter in height against what is claimed, and what the reference moves."""
    if result.problem:
        return []
    solved = result.solved
    east, north, up = solved.baseline.std(axis=0) / MM
    claimed = np.sqrt(np.diag(solved.Q_baseline)) / MM
    fixed, wrong = 100 * np.mean(solved.is_fixed), int(np.sum(solved.is_fixed & ~solved.is_right))
    level = f"level {np.hypot(east, north):.1f}, claimed {np.hypot(*claimed[:2]):.1f}"
    return [
        Readout("Right integers", f"{100 * np.mean(solved.is_right):.1f}", "%", f"promised: {100 * solved.promised:.1f} % at least"),
        Readout("Ratio", f"{np.median(solved.ratio):.2f}", "", f"median; {fixed:.1f} % reach {solved.threshold:.2f}, {_wrong_words(wrong)}"),
        Readout("Scatter up", f"{up:.1f}", "mm", f"claimed {claimed[2]:.1f} mm; {level}"),
        Readout("Reference", f"{result.moved / MM:.1f}", "mm", "moves the baseline, from the highest to the lowest"),
    ]


def _wrong_words(wrong):
    return f"{wrong} of them wrong" if wrong else "none wrong"


def table(result):
    """Return what each epoch gave as columns."""
    solved = result.solved
    east, north, up = solved.baseline.T
    return {
        "epoch": np.arange(len(solved.ratio)),
        "ratio": solved.ratio,
        "is_right": solved.is_right,
        "is_fixed": solved.is_fixed,
        "east_m": east,
        "north_m": north,
        "up_m": up,
    }


def _judge_frugal(result):
    if result.problem or result.settings["data"] != "simulated":
        return False, "The rules ask for simulated data."
    used = result.settings
    by_rule = used["growing"] and used["reference"] == "low" and used["satellites"] <= 8
    right = 100 * float(np.mean(result.solved.is_right))
    return by_rule and right >= 95, standing(f"{right:.1f} % right", by_rule)


GOALS = (
    Goal("frugal", "Simulated data, eight satellites at most, noise that grows towards the horizon, and the lowest satellite as reference: get "
         "the right integers at 95 % of the epochs. Then see what ignoring the correlation makes of it.", _judge_frugal),
)  # fmt: skip
