"""Lab of lesson 04: single epochs of real data, satellites taken away one by one until the integers are lost."""

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from gnsslab.core.integers import fix_with_length, integer_least_squares, ratio_test, simulate_fixes, success_rate, threshold_of_fixes
from gnsslab.core.mixed_model import FloatSolution, given_integers
from gnsslab.data import DataUnavailable
from gnsslab.gnss.judging import ratio_threshold
from gnsslab.gnss.short_baseline import short_baseline_model
from gnsslab.gnss.signals import wavelength
from gnsslab.labs.campaigns import FileReader, blocked_by_data, no_answer, require_files, simulated_instead
from gnsslab.labs.controls import Choice, FileOrPath, Slider, Switch
from gnsslab.labs.epoch_solutions import float_solutions, keep_satellites, middle, order_of_loss
from gnsslab.labs.lab import Drawing, Goal, Lab, Preset, Readout, standing
from gnsslab.labs.pair_epochs import PairEpochs, choose_epochs, model_pair
from gnsslab.labs.skies import open_sky
from gnsslab.simulate.receivers import white_factor

MM = 1e-3
KEPT = 8
FEWEST, MOST = 4, 10
EPOCHS = 150  # at most: five minutes every two seconds, an hour every half minute
DATA_SETS = {"roof": "matrtklib-static", "stations": "geonet-0759-3040"}
SIMULATED_CODE, SIMULATED_CARRIER = 0.3, 3 * MM  # [m], of one reading at the zenith
SIMULATED_BASELINE = np.array([0.6, 0.8, 0.0])  # [m]
BANDS = "12"  # of GPS
SAMPLES = 2000  # simulated for a threshold: a failure rate of 1 % is good to 0.2 %
SAMPLES_ON_SPHERE = 700  # the same with the length, where each costs five times as much
BROKEN = 0.5  # share of right integers below which it counts as broken

DIRECTIONS = {"lowest": (0, 0, -1), "highest": (0, 0, 1), "east": (1, 0, 0), "south": (0, -1, 0)}  # the farthest that way goes first
FILES = ("master_file", "rover_file", "navigation_file")

CONTROLS = (
    Choice("data", "Data", {"two antennas, 1 m": "roof", "two stations, 3.3 km": "stations", "simulated": "simulated", "my files": "mine"}, "roof",
           help="A roof in Nagoya for five minutes, two stations in Japan for an hour, simulated, or your own RINEX files."),
    Slider("satellites", "Satellites left", FEWEST, MOST, 1, 6, help="Of GPS. The second picture shows the epochs with so many."),
    Choice("frequencies", "Frequencies", {"one": 1, "two": 2}, 1, help="L1, or L1 and L2."),
    Choice("order", "The next to go", {"lowest (hurts least)": "lowest", "highest (hurts most)": "highest", "eastern": "east", "southern": "south"},
           "lowest", help="Eastern, southern: as if a wall grew on that side."),
    Choice("acceptance", "Believe",
           {"every fix": "all", "ratio of 3 or more": "three", "the engine's ratio": "engine", "failure rate": "rate"}, "three",
           help="Failure rate: the ratio at which a simulation of these satellites fails as rarely as you allow, under more."),
    Switch("known_length", "The length is known", False, help="The distance of the two antennas takes part in the search."),
    Slider("code_noise", "Code noise believed", 0.05, 1, 0.05, 0.3, "m", help="Of one reading of one receiver, at the zenith.", more=True),
    Slider("carrier_noise", "Carrier noise believed", 1, 10, 0.5, 3, "mm", help="Of one reading of one receiver, at the zenith.", more=True),
    Slider("failure_rate", "Failure rate allowed", 0.5, 10, 0.5, 1, "%", help="Of all epochs: believed and wrong.", more=True),
    Slider("mask", "Elevation mask", 5, 30, 5, 10, "deg", help="No satellite below is used.", more=True),
    Slider("seed", "Seed", 1, 100, 1, 1, help="Another seed is another draw of the noise.", more=True),
    FileOrPath("master_file", "Master observations"),
    FileOrPath("rover_file", "Rover observations"),
    FileOrPath("navigation_file", "Broadcast navigation"),
)  # fmt: skip

PRESETS = (
    Preset("roof", "Until it breaks", {},
           "Nine satellites give the right integers at every epoch, six at nine of ten, five at one of four: it breaks all at once."),
    Preset("roof-four", "Four, believed", {"satellites": 4},
           "With four satellites a ratio of 3 comes by chance: three epochs of ten are fixed, and nearly all of them wrong."),
    Preset("roof-length", "The length known", {"satellites": 5, "known_length": True},
           "The same epochs; the search knows that the antennas are 0.99 m apart, and five satellites are enough."),
    Preset("roof-two", "Two frequencies", {"frequencies": 2, "satellites": 4},
           "The second carrier helps as much as five more satellites: four give the right integers at every epoch, though not yet a good position."),
    Preset("roof-highest", "The highest first", {"order": "highest"},
           "The same number of satellites, but the good ones are gone: it breaks at six. The number alone promises nothing."),
    Preset("roof-rate", "Failure rate 1 %", {"acceptance": "rate", "satellites": 5},
           "A threshold of its own for each number of satellites: with few of them next to nothing is fixed, and hardly anything fixed wrong."),
    Preset("roof-sharp", "Half the noise", {"code_noise": 0.15, "carrier_noise": 1.5},
           "Both sigmas halved: the promise for six satellites rises from 12 to 73 %, and no epoch changes. It is about the noise you believe in."),
    Preset("stations", "Two stations", {"data": "stations"},
           "An hour over 3.3 km: more noise than on the roof, so six satellites of one carrier are right at two of three epochs."),
    Preset("stations-two", "Two stations, L1 + L2", {"data": "stations", "frequencies": 2, "satellites": 4},
           "Both carriers: every epoch has its integers, down to four satellites."),
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class Case:
    """Epochs to lose satellites of."""

    epochs: PairEpochs
    baseline: np.ndarray  # (3,) [m], the known one, east, north, up


@dataclass(frozen=True, eq=False)
class Stage:
    """T epochs with some satellites left."""

    satellites: tuple[str, ...]
    gone: str  # the satellite that went last, "" where none did
    norms: np.ndarray  # (T, 2), what the best and the second best integers cost
    is_right: np.ndarray  # (T,) bool
    off_float: np.ndarray  # (T,) [m], float position from the known one
    off_fixed: np.ndarray  # (T,) [m]
    solution: FloatSolution  # of the middle epoch, with its whole baseline

    @property
    def n(self):
        """Number of ambiguities."""
        return self.solution.a_hat.shape[-1]

    def outcomes(self, threshold):
        """Return the Outcomes of a ratio test."""
        believed = ratio_test(self.norms, threshold)
        return Outcomes(believed & self.is_right, ~believed & self.is_right, ~believed & ~self.is_right, believed & ~self.is_right)

    def shares(self, threshold):
        """Return the Shares of a ratio test."""
        return Shares(*(float(np.mean(chosen)) for chosen in self.outcomes(threshold)))


class Outcomes(NamedTuple):
    """Which of T epochs came to what, each (T,) bool."""

    fixed: np.ndarray  # believed and right
    right_rejected: np.ndarray
    wrong_rejected: np.ndarray
    failed: np.ndarray  # believed and wrong


class Shares(NamedTuple):
    """The same in shares of all epochs."""

    fixed: float
    right_rejected: float
    wrong_rejected: float
    failed: float

    @property
    def right(self):
        """Epochs with the right integers, believed or not."""
        return self.fixed + self.right_rejected


@dataclass(frozen=True, eq=False)
class FewerResult:
    """Every number of satellites, from all to four."""

    settings: dict  # of the controls, all of them
    stages: tuple[Stage, ...] = ()
    thresholds: tuple[float, ...] = ()  # of the ratio, one a stage
    promised: tuple[float, ...] = ()  # share of right integers by the noise that is believed, one a stage
    chosen: int = 0  # index of the stage looked at
    problem: str = ""
    note: str = ""

    @property
    def stage(self):
        """The Stage looked at."""
        return self.stages[self.chosen]

    @property
    def shares(self):
        """The Shares of all stages."""
        return [stage.shares(threshold) for stage, threshold in zip(self.stages, self.thresholds, strict=True)]

    @property
    def outcomes(self):
        """The Outcomes of the stage looked at."""
        return self.stage.outcomes(self.thresholds[self.chosen])

    @property
    def off(self):
        """Errors (T,) [m] of the positions given out with the stage looked at: fixed where believed, else float."""
        return np.where(self.outcomes.fixed | self.outcomes.failed, self.stage.off_fixed, self.stage.off_float)


class FewerEngine:
    """The data of one lab instance, kept between moves, and the way from settings to a result."""

    def __init__(self):
        self._files = FileReader()
        self._model = lru_cache(KEPT)(model_pair)
        self._measured = lru_cache(KEPT)(_measured)
        self._simulated = lru_cache(KEPT)(_simulated)
        self._stages = lru_cache(KEPT)(_stages)
        self._promise = lru_cache(KEPT * MOST)(_simulated_fixes)

    def compute(self, **settings):
        """Return the FewerResult of checked settings; what a reader or the engine refuses becomes a sentence."""
        try:
            case, note = self._case(settings)
            return self._solve(settings, case, note)
        except ValueError as refusal:
            return FewerResult(settings, problem=no_answer(refusal))

    def _case(self, settings):
        """Return the Case chosen, and a note where it had to be another."""
        if settings["data"] == "mine":
            return self._from_files(self._mine(settings), settings), ""
        if settings["data"] in DATA_SETS:
            try:
                return self._from_files(self._files.data_set(DATA_SETS[settings["data"]]), settings), ""
            except DataUnavailable as reason:
                return self._simulation(settings), simulated_instead(reason)
        return self._simulation(settings), ""

    def _from_files(self, files, settings):
        return self._measured(self._model(*files, settings["frequencies"]), settings["mask"])

    def _simulation(self, settings):
        return self._simulated(settings["frequencies"], settings["mask"], settings["seed"])

    def _mine(self, settings):
        master, rover, navigation = (settings[name] for name in FILES)
        require_files(master=master, rover=rover, navigation=navigation)
        return self._files.observations(master), self._files.observations(rover), self._files.ephemerides(navigation)

    def _solve(self, settings, case, note):
        """Return the result of a case."""
        stages = self._stages(case, *(settings[name] for name in ("order", "code_noise", "carrier_noise", "known_length")))
        chosen = max(0, len(stages[0].satellites) - settings["satellites"])
        return FewerResult(
            settings,
            stages,
            thresholds=tuple(self._threshold(stage, settings) for stage in stages),
            promised=tuple(self._promised(stage, settings) for stage in stages),
            chosen=chosen,
            note=" ".join(filter(None, (note, _few_words(settings, case)))),
        )

    def _threshold(self, stage, settings):
        """Return the ratio from which a stage's fixes are believed."""
        if settings["acceptance"] == "rate":
            fixes = self._promise(stage, settings["known_length"], settings["seed"])
            return threshold_of_fixes(fixes.ratio, fixes.is_right, settings["failure_rate"] / 100).ratio
        return {"all": 1.0, "three": 3.0, "engine": float(ratio_threshold(stage.n))}[settings["acceptance"]]

    def _promised(self, stage, settings):
        """Return the share of right integers that the noise believed promises: by formula, and by simulation where the length is in the search."""
        if settings["known_length"]:
            return float(np.mean(self._promise(stage, True, settings["seed"]).is_right))
        return float(success_rate(stage.solution.Q_a))


def _few_words(settings, case):
    """Return the note on satellites or frequencies that there are not."""
    epochs, words = case.epochs, []
    if len(epochs.satellites) < settings["satellites"]:
        words.append(f"No more than {len(epochs.satellites)} satellites were tracked together, so {len(epochs.satellites)} are shown.")
    if len(epochs.wavelengths) < settings["frequencies"]:
        words.append("Both receivers have one frequency only.")
    return " ".join(words)


def _measured(pair_model, mask):
    """Return the Case of two receivers at rest: all the satellites that were tracked together, at EPOCHS epochs at most."""
    epochs = choose_epochs(pair_model, MOST, np.radians(mask), 1)
    every = slice(None, None, -(-len(epochs.y) // EPOCHS))
    moving = len(epochs.u) > 1
    baseline = pair_model.R_ne @ np.median(pair_model.model.near, axis=0)
    return Case(replace(epochs, y=epochs.y[every], u=epochs.u[every] if moving else epochs.u), baseline)


def _simulated(frequencies, mask, seed):
    """Return a Case drawn at random, of the GPS satellites above a mask [deg]; the true integers are zero."""
    sky = open_sky("G", mask)
    sky = sky.first(min(MOST, len(sky.names)))
    growth, wavelengths = white_factor(sky.elevation), np.array([wavelength("G", band) for band in BANDS[:frequencies]])
    model = short_baseline_model(sky.u, wavelengths, SIMULATED_CODE * growth, SIMULATED_CARRIER * growth)
    noise = np.random.default_rng(seed).standard_normal((EPOCHS, len(model.Q_y))) @ np.linalg.cholesky(model.Q_y).T
    return Case(PairEpochs(noise, sky.u[np.newaxis], wavelengths, np.zeros(model.A.shape[1], np.int64), sky.names), SIMULATED_BASELINE)


def _stages(case, order, code_noise, carrier_noise, known_length):
    """Return the Stages of a Case, from all its satellites to FEWEST, solved with the noise that is believed."""
    epochs, growth = case.epochs, white_factor(case.epochs.elevation)
    sigmas = code_noise * growth, carrier_noise * MM * growth
    going = order_of_loss(epochs, DIRECTIONS[order])
    stages = []
    for count in range(len(going) - FEWEST + 1):
        kept = np.sort(going[count:])
        solution = float_solutions(keep_satellites(epochs, kept), *(sigma[kept] for sigma in sigmas))
        truth = keep_satellites(epochs, kept).integers
        gone = epochs.satellites[going[count - 1]] if count else ""
        stages.append(_stage(tuple(epochs.satellites[k] for k in kept), gone, solution, truth, case.baseline, known_length))
    return tuple(stages)


def _stage(satellites, gone, solution, truth, baseline, known_length):
    """Return the Stage of FloatSolutions about the known baseline."""
    whole = solution._replace(b_hat=solution.b_hat + baseline)
    found = fix_with_length(whole, float(np.linalg.norm(baseline))) if known_length else integer_least_squares(whole.a_hat, whole.Q_a)
    fixed = found.baselines[:, 0] if known_length else given_integers(whole, found.best)[0]
    return Stage(
        satellites=satellites,
        gone=gone,
        norms=found.norms,
        is_right=(found.best == truth).all(axis=-1),
        off_float=np.linalg.norm(solution.b_hat, axis=-1),
        off_fixed=np.linalg.norm(fixed - baseline, axis=-1),
        solution=middle(whole._replace(b_hat=np.broadcast_to(baseline, whole.b_hat.shape))),
    )


class _Drawn(NamedTuple):
    """Fixes of a simulation."""

    ratio: np.ndarray  # (N,)
    is_right: np.ndarray  # (N,) bool


def _simulated_fixes(stage, known_length, seed):
    """Return what becomes of float solutions drawn with the covariance that a stage's middle epoch claims."""
    rng = np.random.default_rng(seed)
    if not known_length:
        fixes = simulate_fixes(stage.solution.Q_a, rng, SAMPLES)
        return _Drawn(fixes.ratio, fixes.is_right)
    _, b, Q_a, Q_b, Q_ba, _ = stage.solution
    errors = rng.standard_normal((SAMPLES_ON_SPHERE, stage.n + 3)) @ np.linalg.cholesky(np.block([[Q_a, Q_ba.T], [Q_ba, Q_b]])).T
    drawn = stage.solution._replace(a_hat=errors[:, : stage.n], b_hat=b + errors[:, stage.n :])
    found = fix_with_length(drawn, float(np.linalg.norm(b)))
    return _Drawn(found.ratio, ~found.best.any(axis=-1))


def fewer_satellites_lab():
    """Return a fresh lab with caches of its own."""
    return Lab(
        name="fewer-satellites", title="Until it breaks", controls=CONTROLS, presets=PRESETS, goals=GOALS,
        compute=FewerEngine().compute, figure=figure, drawings=drawings, describe=describe, readouts=readouts, table=table,
        steering=("data", "acceptance", "known_length"), blocked=blocked,
    )  # fmt: skip


def blocked(settings):
    """Return for each control without effect on what was chosen the reason why."""
    by_rate = settings["acceptance"] == "rate"
    drawn = settings["data"] == "simulated" or by_rate or settings["known_length"]
    reasons = blocked_by_data(settings["data"], () if drawn else ("seed",), FILES)
    return reasons if by_rate else reasons | {"failure_rate": 'choose "failure rate" as what is believed'}


def figure(result):
    """Return the whole picture as one matplotlib Figure."""
    from gnsslab.figures.fewer_satellites import plot_fewer

    return plot_fewer(result)


def drawings():
    """Return the two pictures of the lab."""
    from gnsslab.figures.fewer_satellites import build_epochs, build_stages

    return Drawing("stages", build_stages, 440, 420), Drawing("epochs", build_epochs, 380, 420)


def describe(result):
    """Return the pictures in words."""
    from gnsslab.figures.fewer_satellites import describe_fewer

    return result.problem or describe_fewer(result)


def readouts(result):
    """Return the shares of the stage looked at, and where it breaks."""
    if result.problem:
        return []
    shares, promised = result.shares[result.chosen], 100 * result.promised[result.chosen]
    rejected = shares.right_rejected + shares.wrong_rejected
    return [
        Readout("Right integers", f"{100 * shares.right:.1f}", "%", f"of {len(result.off)} epochs; promised: {promised:.1f} %"),
        Readout("Fixed, right", f"{100 * shares.fixed:.1f}", "%", f"by a ratio of {result.thresholds[result.chosen]:.2f} or more"),
        Readout("Fixed, wrong", f"{100 * shares.failed:.1f}", "%", f"{100 * rejected:.1f} % rejected"),
        _breaks(result),
    ]


def broken_at(result):
    """Return the largest number of satellites with which fewer than half the epochs are right, None where there is none."""
    counts = [len(stage.satellites) for stage, shares in zip(result.stages, result.shares, strict=True) if shares.right < BROKEN]
    return max(counts, default=None)


def _breaks(result):
    count, most = broken_at(result), len(result.stages[0].satellites)
    if count:
        return Readout("Breaks at", str(count), "", f"satellites: fewer than half are right; {100 * result.shares[0].right:.0f} % with {most}")
    return Readout("Breaks at", "none", "", f"half the epochs and more are right, from {most} satellites to {FEWEST}")


def table(result):
    """Return what each epoch gave, with the satellites looked at, as columns."""
    stage = result.stage
    return {
        "epoch": 1 + np.arange(len(stage.is_right)),
        "ratio": stage.norms[:, 1] / stage.norms[:, 0],
        "is_right": stage.is_right,
        "is_believed": result.outcomes.fixed | result.outcomes.failed,
        "off_float_m": stage.off_float,
        "off_fixed_m": stage.off_fixed,
    }


def _judge_five(result):
    if result.problem or result.settings["data"] != "roof":
        return False, "The rules ask for the two antennas on the roof."
    shares = result.shares[result.chosen]
    by_rule = result.settings["frequencies"] == 1 and len(result.stage.satellites) == 5
    reached = shares.fixed >= 0.95 and shares.failed == 0
    return by_rule and reached, standing(f"{100 * shares.fixed:.1f} % fixed and right, {100 * shares.failed:.1f} % fixed wrong", by_rule)


GOALS = (
    Goal("roof-five", "Two antennas, one frequency, five satellites left: fix 95 % of the epochs or more, all of them right.", _judge_five),
)  # fmt: skip
