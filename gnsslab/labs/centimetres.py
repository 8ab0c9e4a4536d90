"""Lab of lesson 03: float and fixed positions of a known baseline in one plane, half a metre and millimetres."""

from dataclasses import dataclass
from functools import lru_cache, partial

import numpy as np

from gnsslab.core.integers import adop, integer_least_squares, success_rate
from gnsslab.core.mixed_model import FloatSolution, given_integers, solve_float
from gnsslab.data import DataUnavailable
from gnsslab.gnss.correlation import without_correlation
from gnsslab.gnss.differences import difference_operator
from gnsslab.gnss.short_baseline import short_baseline_model
from gnsslab.gnss.signals import wavelength
from gnsslab.labs.campaigns import FileReader, blocked_by_data, no_answer, require_files, simulated_instead
from gnsslab.labs.controls import Choice, FileOrPath, Slider
from gnsslab.labs.lab import Drawing, Goal, Lab, Preset, Readout, standing
from gnsslab.labs.pair_epochs import PairEpochs, choose_epochs, model_pair
from gnsslab.labs.skies import open_sky
from gnsslab.simulate.receivers import white_factor
from gnsslab.systems.printed_ranges import sigma_code_as_printed

MM = 1e-3
DRAWN = 1000  # epochs of a simulation: a share of them is good to 1.6 %
FEWEST_SATELLITES = 4
BANDS = "125"  # of GPS
BAND_NAMES = {1: "L1", 2: "L1+L2", 3: "L1+L2+L5"}
REAL_DATA = "geonet-0759-3040"
KEPT = 4
FILES = ("master_file", "rover_file", "navigation_file")
SPAN = (1, 2, 3, 4, 5, 6, 8, 10, 12, 15, 20, 25, 30, 40, 60)  # epochs together at which the promise is worked out

CONTROLS = (
    Choice("data", "Data", {"simulated": "simulated", "real pair": "real", "my files": "mine"}, "simulated",
           help="Simulated, two stations in Japan 3.3 km apart, or your own RINEX files."),
    Slider("satellites", "Satellites", FEWEST_SATELLITES, 10, 1, 6, help="Of GPS, spread from the highest to the lowest above the mask."),
    Choice("frequencies", "Frequencies", {name: f for f, name in BAND_NAMES.items()}, 2, help="Each brings a code and a carrier of every satellite."),
    Slider("code_noise", "Code noise", 0.1, 1, 0.05, 0.3, "m",
           help="Of one reading of one receiver, at the zenith. In real data: what the solver believes."),
    Slider("epochs", "Epochs together", 1, 60, 1, 1, help="Their mean is solved. Simulated noise is new at each epoch; real reflections last."),
    Choice("belief", "The solver believes",
           {"all it knows": "all", "diagonal alone": "diagonal", "as printed: code 3 cm": "printed", "as printed: carrier alone": "carrier"}, "all",
           help="The measurements stay the same."),
    Slider("carrier_noise", "Carrier noise", 1, 10, 0.5, 3, "mm",
           help="Of one reading of one receiver, at the zenith. In real data: what the solver believes.", more=True),
    Slider("mask", "Elevation mask", 10, 40, 5, 10, "deg", help="Satellites below are left out. Low ones are noisy, but widen the view.", more=True),
    Slider("seed", "Seed", 1, 100, 1, 2, help="Another seed is another draw of the noise.", more=True),
    FileOrPath("master_file", "Master observations"),
    FileOrPath("rover_file", "Rover observations"),
    FileOrPath("navigation_file", "Broadcast navigation"),
)  # fmt: skip

PRESETS = (
    Preset("start", "Start", {},
           "A cloud of metres becomes a cloud of millimetres: the right epochs all lie in the dot in the middle, and the little window magnifies it. "
           "A few crosses got wrong integers."),
    Preset("one-frequency", "L1 alone", {"frequencies": 1, "satellites": 8},
           "The fixed cloud is as small as before, but two of three epochs are crosses: good to millimetres, or "
           "off by decimetres and more, with nothing between."),
    Preset("ten-epochs", "Ten epochs", {"frequencies": 1, "satellites": 8, "epochs": 10},
           "The mean of ten epochs on L1: both clouds are three times smaller, not more, and not a cross is left."),
    Preset("five", "Five satellites", {"satellites": 5},
           "One satellite fewer: the float cloud grows by half, and a quarter of the epochs have wrong integers."),
    Preset("three-frequencies", "Three frequencies", {"satellites": 5, "frequencies": 3},
           "Five satellites again, with a third carrier: more integers to find, and nearly every epoch finds them."),
    Preset("diagonal", "Diagonal alone", {"belief": "diagonal"},
           "The same epochs, each ambiguity rounded by itself: hardly one is right, because all of them are wrong together."),
    Preset("printed-code", "Code 3 cm", {"belief": "printed", "frequencies": 1, "satellites": 8},
           "A paper of 1998 has 3 cm where 3 m belongs: the solver promises 100 %, and 99 of 100 fixes are wrong."),
    Preset("cheap", "Cheap antenna", {"code_noise": 0.8, "carrier_noise": 5},
           "Read the axes: the float cloud is nearly three times as large as at the start, and seven of ten epochs are crosses."),
    Preset("real-one", "Real, L1", {"data": "real", "frequencies": 1, "satellites": 6},
           "An hour in Japan, each epoch by itself on one frequency: two of three find their integers, far more than promised."),
    Preset("real-two", "Real, L1 + L2", {"data": "real", "frequencies": 2, "satellites": 6},
           "The same hour on both frequencies: nobody simulated this, and every epoch finds its integers."),
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class CentimetresResult:
    """Positions about the known baseline, before and after the integers, of T epochs (or means of some)."""

    settings: dict  # of the controls, all of them
    float_enu: np.ndarray | None = None  # (T, 3) [m]
    fixed_enu: np.ndarray | None = None  # (T, 3) [m]
    is_right: np.ndarray | None = None  # (T,) bool: the integers found are the true ones
    Q_float: np.ndarray | None = None  # (3, 3) [m^2], as the solver claims, middle epoch
    Q_fixed: np.ndarray | None = None  # (3, 3) [m^2]
    promised: float = 0.0  # success rate that the solver's covariance promises
    adop: float = 0.0  # [cycles]
    n: int = 0  # ambiguities
    satellites: tuple[str, ...] = ()
    span: np.ndarray | None = None  # (s,) epochs together
    promised_over_span: np.ndarray | None = None  # (s,)
    problem: str = ""
    note: str = ""


class CentimetresEngine:
    """The data of one lab instance, kept between moves, and the way from settings to a result."""

    def __init__(self):
        self._files = FileReader()
        self._model = lru_cache(KEPT)(model_pair)

    def compute(self, **settings):
        """Return the CentimetresResult of checked settings; what a reader or the engine refuses becomes a sentence."""
        try:
            case, note = self._case(settings)
            return _solve(settings, case, note)
        except ValueError as refusal:
            return CentimetresResult(settings, problem=no_answer(refusal))

    def _case(self, settings):
        """Return the PairEpochs chosen, and a note where they had to be others."""
        if settings["data"] == "mine":
            return self._mine(settings)
        if settings["data"] == "real":
            try:
                return self._measured(self._files.data_set(REAL_DATA), settings)
            except DataUnavailable as reason:
                return simulate_epochs(settings), simulated_instead(reason)
        return simulate_epochs(settings), _few_above_mask(settings)

    def _mine(self, settings):
        master, rover, navigation = (settings[name] for name in FILES)
        require_files(master=master, rover=rover, navigation=navigation)
        return self._measured([*map(self._files.observations, (master, rover)), self._files.ephemerides(navigation)], settings)

    def _measured(self, files, settings):
        model = self._model(*files, settings["frequencies"])
        epochs = choose_epochs(model, settings["satellites"], np.radians(settings["mask"]), settings["epochs"])
        return epochs, _fewer_than_asked(settings, len(epochs.satellites), model.frequencies)


def simulate_epochs(settings):
    """Return PairEpochs drawn at random about a known baseline, with the noise of the settings."""
    sky = _sky(settings)
    wavelengths = np.array([wavelength("G", band) for band in BANDS[: settings["frequencies"]]])
    sigma_code, sigma_phase = (sigma / np.sqrt(settings["epochs"]) for sigma in _sigmas(settings, sky.elevation))
    f, m = len(wavelengths), len(sky.names)
    code, phase, integers = _draws(settings["seed"], f, m)
    D = difference_operator(m, 0)
    dd_code, dd_phase = code * sigma_code @ D.T, phase * sigma_phase @ D.T + wavelengths[:, None] * (integers @ D.T)
    return PairEpochs(
        y=np.concatenate([dd_code.reshape(DRAWN, -1), dd_phase.reshape(DRAWN, -1)], axis=1),
        u=sky.u[np.newaxis],
        wavelengths=wavelengths,
        integers=(integers @ D.T).astype(np.int64).ravel(),
        satellites=sky.names,
    )


@lru_cache(16)
def _draws(seed, f, m):
    """Return rover minus master of unit noise, code and carrier (T, f, m), and integers (f, m): the same draws at every noise level."""
    rng = np.random.default_rng(seed)
    reading = rng.standard_normal((2, 2, DRAWN, f, m))  # receiver, code or carrier
    return *(reading[1] - reading[0]), rng.integers(-1000, 1000, (f, m))


def _sky(settings):
    """Return the Sky of as many satellites as are asked for, spread over those above the mask."""
    sky = open_sky("G", settings["mask"])
    if len(sky.names) < FEWEST_SATELLITES:
        raise ValueError(f"only {len(sky.names)} satellites stand above {settings['mask']} degrees, and a position needs four: lower the mask")
    return sky.spread(min(settings["satellites"], len(sky.names)))


def _few_above_mask(settings):
    count = len(open_sky("G", settings["mask"]).names)
    return f"No more than {count} satellites stand above the mask, so {count} are used." if count < settings["satellites"] else ""


def _fewer_than_asked(settings, m, f):
    """Return the note on satellites or frequencies that real data do not have."""
    words = [f"No more than {m} satellites were tracked together, so {m} are used."] * (m < settings["satellites"])
    words += [f"Both receivers have {BAND_NAMES[f]} only."] * (f < settings["frequencies"])
    return " ".join(words)


def _sigmas(settings, elevation):
    """Return the sigmas (m,) [m] of one receiver's code and carrier: both grow towards the horizon."""
    growth = white_factor(elevation)
    return settings["code_noise"] * growth, settings["carrier_noise"] * MM * growth


def _solve(settings, epochs, note):
    """Return the result of PairEpochs."""
    _refuse_carrier_alone(settings, len(epochs.integers))
    solution = _float_solutions(settings, epochs)
    believed = _diagonals(solution.Q_a) if settings["belief"] == "diagonal" else solution.Q_a
    a_fix = integer_least_squares(solution.a_hat, believed).best
    fixed, Q_fixed = given_integers(solution, a_fix)
    span = np.array(SPAN)
    return CentimetresResult(
        settings,
        float_enu=solution.b_hat,
        fixed_enu=fixed,
        is_right=(a_fix == epochs.integers).all(axis=-1),
        Q_float=_middle(solution.Q_b),
        Q_fixed=_middle(Q_fixed),
        promised=float(success_rate(_middle(believed))),
        adop=float(adop(_middle(believed))),
        n=len(epochs.integers),
        satellites=epochs.satellites,
        span=span,
        promised_over_span=success_rate(_middle(believed) * (settings["epochs"] / span)[:, None, None]),
        note=note,
    )


def _refuse_carrier_alone(settings, n):
    if settings["belief"] == "carrier":
        raise ValueError(f"{n} carriers have {n} integers and 3 coordinates to find, {n + 3} unknowns: carriers alone give no float solution here")


def _float_solutions(settings, epochs):
    """Return the FloatSolution of all epochs, one covariance for all where the satellites do not move."""
    sigma_code, sigma_phase = _sigmas(settings, epochs.elevation)
    if settings["belief"] == "printed":
        sigma_code = sigma_code_as_printed(epochs.elevation)
    model = partial(short_baseline_model, wavelengths=epochs.wavelengths, sigma_code=sigma_code, sigma_phase=sigma_phase, epochs=settings["epochs"])
    if len(epochs.u) == 1:
        return solve_float(epochs.y, *model(epochs.u[0]))
    each = [solve_float(y, *model(u)) for y, u in zip(epochs.y, epochs.u, strict=True)]
    return FloatSolution(*(np.stack(parts) for parts in zip(*(solution[:5] for solution in each), strict=True)))


def _diagonals(Q):
    """Return covariances (..., n, n) as one has them who rounds each ambiguity by itself."""
    return without_correlation(Q) if Q.ndim == 2 else np.stack([without_correlation(one) for one in Q])


def _middle(Q):
    """Return the covariance (n, n) of the middle epoch, or the one for all."""
    return Q if Q.ndim == 2 else Q[len(Q) // 2]


def centimetres_lab():
    """Return a fresh lab with caches of its own."""
    return Lab(
        name="centimetres", title="From half a metre to millimetres", controls=CONTROLS, presets=PRESETS, goals=GOALS,
        compute=CentimetresEngine().compute, figure=figure, drawings=drawings, describe=describe, readouts=readouts, table=table,
        steering=("data",), blocked=blocked,
    )  # fmt: skip


def blocked(settings):
    """Return for each control without effect on the chosen data the reason why."""
    return blocked_by_data(settings["data"], ("seed",), FILES)


def figure(result):
    """Return the whole picture as one matplotlib Figure."""
    from gnsslab.figures.centimetres import plot_centimetres

    return plot_centimetres(result)


def drawings():
    """Return the two pictures of the lab."""
    from gnsslab.figures.centimetres import build_plane, build_span

    return Drawing("plane", build_plane, 460, 540), Drawing("span", build_span, 350, 360)


def describe(result):
    """Return the pictures in words."""
    from gnsslab.figures.centimetres import describe_centimetres

    return result.problem or describe_centimetres(result)


def readouts(result):
    """Return the scatter before and after the integers, the share of right ones beside the promise, and ADOP."""
    if result.problem:
        return []
    right, wrong = (result.fixed_enu[chosen] for chosen in (result.is_right, ~result.is_right))
    claimed = np.sqrt(np.trace(result.Q_float[:2, :2]))
    off = f"; the wrong ones lie {np.median(np.hypot(*wrong.T[:2])):.1f} m off" if len(wrong) else "; none is wrong"
    return [
        Readout("Float position", f"{_level(result.float_enu):.2f}", "m", f"rms on the map; the solver claims {claimed:.2f} m"),
        Readout("Fixed position", *((f"{_level(right) / MM:.1f}", "mm") if len(right) else ("none", "")), f"rms of the right ones{off}"),
        Readout("Right integers", f"{100 * np.mean(result.is_right):.1f}", "%", f"promised: {100 * result.promised:.1f} %"),
        Readout("ADOP", f"{result.adop:.3f}", "cycles", f"of {result.n} ambiguities"),
    ]


def _level(enu):
    """Return the rms distance (T, 3) -> [m] from the true point on the map."""
    return float(np.sqrt(np.mean(np.sum(enu[:, :2] ** 2, axis=1))))


def table(result):
    """Return what each epoch gave as columns."""
    columns = {"epoch": np.arange(len(result.is_right)), "is_right": result.is_right}
    for kind, enu in (("float", result.float_enu), ("fixed", result.fixed_enu)):
        columns |= {f"{kind}_{name}_m": values for name, values in zip(("east", "north", "up"), enu.T, strict=True)}
    return columns


def _judge_thrifty(result):
    if result.problem or result.settings["data"] != "simulated":
        return False, "The rules ask for simulated data."
    used = result.settings
    by_rule = used["frequencies"] == 1 and used["satellites"] <= 7 and used["code_noise"] >= 0.3 and used["carrier_noise"] >= 3
    by_rule = by_rule and used["epochs"] <= 12 and used["belief"] == "all"
    right = 100 * float(np.mean(result.is_right))
    return by_rule and right >= 99, standing(f"{right:.1f} % right", by_rule)


GOALS = (
    Goal("thrifty", "Simulated data, L1 alone, seven satellites and twelve epochs at most, noise as at the start or worse, all that the solver "
         "knows: get the right integers in 99 % of the cases.", _judge_thrifty),
)  # fmt: skip
