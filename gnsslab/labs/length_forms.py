"""Lab of lesson 05: where a known length belongs. The same epochs, one filter, six forms of use, and the engine."""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from gnsslab.data import DataUnavailable, find_dataset
from gnsslab.gnss.frames import enu_rotation
from gnsslab.gnss.known_length import cautious
from gnsslab.gnss.preparation import Settings
from gnsslab.gnss.selection import keep_epochs
from gnsslab.labs.campaigns import FileReader, blocked_by_data, no_answer, require_files, simulated_instead
from gnsslab.labs.controls import Choice, FileOrPath, Slider
from gnsslab.labs.degraded_pairs import FEWEST, KnownPair, add_multipath, at_rover, keep_satellites, prepare_pair, seconds_of
from gnsslab.labs.lab import Drawing, Goal, Lab, Preset, Readout, standing
from gnsslab.labs.length_runs import FORMS, run_form, with_noise
from gnsslab.labs.static_pairs import static_pair
from gnsslab.simulate import find_preset, simulate
from gnsslab.systems.constrained_filter import FilterSettings
from gnsslab.systems.dual_antenna import A_STATIC
from gnsslab.systems.length_row import RowState

CM, MM = 1e-2, 1e-3
KEPT = 6
MOST = 15  # satellites
LONGEST = 650  # epochs of one's own files
ROOF = "matrtklib-static"
ONE_CARRIER = Settings(frequencies=1)
AS_USUAL = 1.0
NOTHING = "There is no answer to judge."
SIMULATED = {"simulated": "static-baseline", "paper": A_STATIC.preset}
FILES = ("master_file", "rover_file", "navigation_file")
ROWS = ("guarded", "row", "iterated", "second")  # the forms with a row

CONTROLS = (
    Choice("data", "Data",
           {"two antennas on a roof": "roof", "simulated": "simulated", "simulated as in the paper": "paper", "my files": "mine"}, "roof",
           help="A roof in Nagoya for five minutes, simulated, or your own RINEX files. One carrier is used."),
    Choice("form", "Shown over time",
           {"no length": "nowhere", "guarded row": "guarded", "row always": "row", "iterated row": "iterated", "second-order row": "second",
            "search": "search", "our engine": "engine"}, "guarded", help="All forms are counted; one is shown over time."),
    Choice("memory", "Carried on", {"nothing": "single", "ambiguities": "direct", "everything": "filter"}, "filter",
           help="From one epoch to the next. Epochs of a filter are no independent trials: their interval is too short."),
    Slider("satellites", "Satellites", FEWEST, MOST, 1, 8, help="How many are left."),
    Slider("length_error", "You enter too much by", -10, 10, 0.5, 0, "cm", help="Error of the length that you type in."),
    Choice("noise", "Assumed noise",
           {"four times": 4.0, "as usual": AS_USUAL, "half": 0.5, "a quarter": 0.25, "learnt from the codes": "learnt"}, AS_USUAL,
           help="What the filter is told of codes and carriers. As usual: the law of RTKLIB, 4 mm and 0.4 m in the zenith."),
    Slider("multipath", "Multipath added", 0, 1.5, 0.1, 0, "m", help="To the rover's codes, in the zenith; to its carriers a 200th.", more=True),
    Choice("order", "Satellites left are", {"the highest": "highest", "the lowest": "lowest", "by chance": "chance"}, "highest",
           help="By chance: the seed draws them.", more=True),
    Choice("systems", "Systems", {"GPS": "G", "GPS + BeiDou": "GC", "all": "GECJ"}, "G", help="Whose satellites there are.", more=True),
    Slider("ratio", "Ratio for a fix", 1.5, 10, 0.5, 3, help="Second best over best squared norm. The engine judges in its own way.", more=True),
    Slider("hold_after", "Hold after", 0, 20, 1, 5, "fixes", help="Fixes in a row, after which the integers are held; 0: never.", more=True),
    Slider("length_sigma", "Sigma of the length", 1, 50, 1, 5, "mm", help="How well the filter is told to believe it.", more=True),
    Slider("seed", "Seed", 1, 100, 1, 1, help="Another seed is another draw of noise, multipath and satellites.", more=True),
    FileOrPath("master_file", "Master observations"),
    FileOrPath("rover_file", "Rover observations"),
    FileOrPath("navigation_file", "Broadcast navigation"),
)  # fmt: skip

PRESETS = (
    Preset("guarded-row", "The guarded row", {},
           "Dropped at 29 % of the epochs. Then the row is let in: the length is right at once, the baseline 40 cm off, and not one epoch is fixed."),
    Preset("row-always", "Row at every epoch", {"form": "row", "satellites": 9},
           "Nine satellites: all epochs are fixed with no length, and none with a row from the first epoch on."),
    Preset("iterated-row", "Iterated", {"form": "iterated", "satellites": 6},
           "A lottery: 97 % right with six satellites, and none with five, seven, eight or nine."),
    Preset("second-order", "Second order", {"form": "second"},
           "Modest at first and sure of itself later: 95 % of the epochs are fixed, and wrong."),
    Preset("in-the-search", "In the search", {"form": "search", "satellites": 5},
           "Five satellites: fixed from the first epoch on, all of them right. With no length it is 48 %."),
    Preset("epochs-alone", "Each epoch alone", {"memory": "single", "satellites": 6},
           "The codes of one epoch never pass the guard: the row is dropped at all epochs, just where it would help. In the search: 93 %."),
    Preset("two-centimetres", "2 cm wrong", {"memory": "single", "satellites": 6, "length_error": 2, "form": "search"},
           "The search finds fewer baselines of that length: 22 % are fixed instead of 93 %, but none of them wrong."),
    Preset("ten-centimetres", "10 cm wrong", {"length_error": 10},
           "The rows fix 66 to 97 % of the epochs wrong, the search nearly none. At -10 cm the search is taken in too; our engine is not."),
    Preset("noise-halved", "Half the noise", {"noise": 0.5, "satellites": 6},
           "Told half the noise, the guard lets the row in sooner, after 18 % of the epochs, and none is right; as usual it was 74 %."),
    Preset("added-multipath", "Multipath", {"multipath": 0.7, "satellites": 9, "form": "search"},
           "0.7 m on the codes: 53 % with no length, none with the guarded row, 78 % with the search. Our engine knows that it lasts: all."),
    Preset("paper-receivers", "The paper's receivers", {"data": "paper", "systems": "GC", "satellites": 15, "seed": 5},
           "Fifteen satellites are sure of the baseline when the guard opens: no harm is done, and little good. A row from the start fixes none."),
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class LengthFormsResult:
    """All forms on the same epochs."""

    settings: dict  # of the controls, all of them
    seconds: np.ndarray | None = None  # (T,) [s]
    runs: dict | None = None  # FormRun of each of FORMS
    entered: float = 0.0  # [m], the length that was typed in
    baseline: np.ndarray | None = None  # (3,) [m], the true one
    satellites: tuple[str, ...] = ()
    problem: str = ""
    note: str = ""

    @property
    def run(self):
        """The FormRun shown over time."""
        return self.runs[self.settings["form"]]


class LengthFormsEngine:
    """The data of one lab instance, kept between moves, and the way from settings to a result."""

    def __init__(self):
        self._files = FileReader()
        self._simulated = lru_cache(KEPT)(_simulated)
        self._roof = lru_cache(1)(roof)
        self._own = lru_cache(1)(_own)
        self._prepared = lru_cache(KEPT)(_prepared)
        self._degraded = lru_cache(KEPT)(_degraded)
        self._run = lru_cache(KEPT * len(FORMS))(run_form)

    def compute(self, **settings):
        """Return the LengthFormsResult of checked settings; what a reader or the engine refuses becomes a sentence."""
        try:
            return self._solve(settings, *self._known(settings))
        except ValueError as refusal:
            return LengthFormsResult(settings, problem=no_answer(refusal))

    def _known(self, settings):
        """Return the KnownPair chosen, and a note where it had to be another."""
        if settings["data"] in SIMULATED:
            return self._simulated(settings["data"], settings["seed"]), ""
        if settings["data"] == "mine":
            return self._own(*self._mine(settings)), ""
        try:
            return self._roof(*self._files.data_set(ROOF)), ""
        except DataUnavailable as reason:
            return self._simulated("simulated", settings["seed"]), simulated_instead(reason)

    def _mine(self, settings):
        master, rover, navigation = (settings[name] for name in FILES)
        require_files(master=master, rover=rover, navigation=navigation)
        return self._files.observations(master), self._files.observations(rover), self._files.ephemerides(navigation)

    def _solve(self, settings, known, note):
        """Return the result of a KnownPair: what was run before, on the same epochs, is kept."""
        single = settings["memory"] == "single"
        pair = self._pair(known, _for_filter(known, settings["systems"], single), settings, settings["noise"])
        learning = self._pair(known, _for_engine(settings["systems"], single), settings, AS_USUAL)
        entered = known.length + settings["length_error"] * CM
        runs = {form: self._form(learning if form == "engine" else pair, known, form, entered, settings) for form in FORMS}
        few = _few_words(len(pair.satellites), settings)
        return LengthFormsResult(settings, seconds_of(pair), runs, entered, known.baseline, pair.satellites, note=" ".join(filter(None, (note, few))))

    def _pair(self, known, assumed, settings, noise):
        """Return the PreparedPair, degraded as the controls say."""
        ways = (settings[name] for name in ("satellites", "order", "multipath"))
        return self._degraded(self._prepared(known, assumed), *ways, noise, settings["seed"] if _is_drawn(settings) else None)

    def _form(self, pair, known, form, entered, settings):
        """Return the FormRun of one form: what it does not look at makes no new run."""
        length, sigma = (1.0, 0.005) if form == "nowhere" else (entered, settings["length_sigma"] * MM)
        believed = {} if form == "engine" else {"ratio": settings["ratio"], "hold_after": int(settings["hold_after"])}
        return self._run(pair, tuple(known.baseline), form, settings["memory"], FilterSettings(length, sigma, **believed))


def _simulated(data, seed):
    """Return the simulated KnownPair of a seed."""
    simulation = simulate(find_preset(SIMULATED[data]), np.random.default_rng(seed))
    baseline = simulation.truth.baselines_enu[0, 0]
    return KnownPair(*simulation.observations, simulation.ephemerides, baseline, A_STATIC.settings if data == "paper" else ONE_CARRIER)


def roof(master, rover, ephemerides):
    """Return the KnownPair of the roof; where the antennas stand was given with the data."""
    return KnownPair(master, rover, ephemerides, find_dataset(ROOF).baseline_enu, ONE_CARRIER)


def _own(master, rover, ephemerides):
    """Return the KnownPair of one's own files, the first epochs of long ones; the engine says with two frequencies where the antennas are."""
    master, rover = (keep_epochs(one, np.arange(len(one.time)) < LONGEST) for one in (master, rover))
    found = static_pair(master, rover, ephemerides)
    baseline = enu_rotation(found.master_ecef) @ (found.rover_ecef - found.master_ecef)
    return KnownPair(master, rover, ephemerides, baseline, ONE_CARRIER)


def _for_filter(known, systems, single):
    """Return the Settings of the six forms, which do not ask what is news."""
    return _for_engine(systems, single) if known.settings is ONE_CARRIER else replace(known.settings, systems=systems, single_epoch=single)


def _for_engine(systems, single):
    """Return the Settings of the engine with a known length."""
    return replace(ONE_CARRIER, systems=systems, single_epoch=single, noise=cautious(ONE_CARRIER.noise))


def _prepared(known, settings):
    return at_rover(prepare_pair(known, settings))


def _degraded(pair, satellites, order, multipath, noise, seed):
    """Return the PreparedPair with so many satellites left, multipath added, and the noise that the filter is to assume."""
    first, second = np.random.default_rng(seed).spawn(2)
    ranked = {"highest": pair.order, "lowest": pair.order[::-1], "chance": first.permutation(pair.order)}[order]
    if multipath > 0:
        pair = add_multipath(pair, multipath, second)
    return with_noise(keep_satellites(pair, ranked[:satellites]), None if noise == "learnt" else noise)


def _is_drawn(settings):
    """Say whether satellites or multipath are drawn at random."""
    return settings["order"] == "chance" or settings["multipath"] > 0


def _few_words(count, settings):
    """Return the note on satellites that there are not."""
    return f"No more than {count} satellites are above 15 degrees, so {count} are used." if count < settings["satellites"] else ""


def length_forms_lab():
    """Return a fresh lab with caches of its own."""
    return Lab(
        name="length-forms", title="Where the length belongs", controls=CONTROLS, presets=PRESETS, goals=GOALS,
        compute=LengthFormsEngine().compute, figure=figure, drawings=drawings, describe=describe, readouts=readouts, table=table,
        steering=("data", "memory", "order", "multipath"), blocked=blocked,
    )  # fmt: skip


def blocked(settings):
    """Return for each control without effect on what was chosen the reason why."""
    source = "simulated" if settings["data"] in SIMULATED else settings["data"]
    reasons = blocked_by_data(source, () if _is_drawn(settings) else ("seed",), FILES)
    if settings["memory"] == "single":
        reasons |= {"hold_after": "nothing is held where each epoch stands alone"}
    return reasons


def figure(result):
    """Return the whole picture as one matplotlib Figure."""
    from gnsslab.figures.length_forms import plot_forms

    return plot_forms(result)


def drawings():
    """Return the two pictures of the lab."""
    from gnsslab.figures.length_forms import build_forms, build_run

    return Drawing("forms", build_forms, 430, 420), Drawing("run", build_run, 420, 420)


def describe(result):
    """Return the pictures in words."""
    from gnsslab.figures.length_forms import describe_forms

    return result.problem or describe_forms(result)


def readouts(result):
    """Return what became of the form shown, of its row, and the same of the search."""
    if result.problem:
        return []
    run, without = result.run, result.runs["nowhere"]
    return [
        Readout("Fixed, right", f"{100 * run.right.rate:.1f}", "%", f"of {len(run.off)} epochs; with no length {100 * without.right.rate:.1f} %"),
        Readout("Fixed, wrong", f"{100 * run.wrong.rate:.1f}", "%", f"half a cycle off or more; with no length {100 * without.wrong.rate:.1f} %"),
        row_readout(result),
        Readout("Error", *_in_words(float(np.median(run.off))), "median of all epochs, float ones included"),
        Readout("In the search", f"{100 * result.runs['search'].right.rate:.1f}", "%", f"fixed and right, {_first_words(result)}"),
    ]


def row_readout(result):
    """Return what became of the row, said aloud."""
    run = result.run
    if result.settings["form"] not in ROWS:
        return Readout("Row", "none", "", "the length is in the search only" if result.settings["form"] != "nowhere" else "the length is not used")
    share = 100 * run.dropped
    used = run.row_state == RowState.USED
    without_fix = 100 * float(np.mean(used & ~run.is_right))
    return Readout("Row dropped", f"{share:.0f}", "%", f"of the epochs; used, and yet no right fix, at {without_fix:.0f} %")


def _first_words(result):
    run = result.runs["search"]
    return "never" if run.first_fix is None else f"first after {result.seconds[run.first_fix]:.0f} s"


def _in_words(metres):
    """Return a distance as a number and its unit."""
    return (f"{metres / MM:.1f}", "mm") if metres < 0.1 else (f"{metres:.2f}", "m")


def table(result):
    """Return what the form shown made of each epoch, as columns."""
    run = result.run
    return {
        "seconds": result.seconds,
        "is_fixed": run.is_fixed,
        "is_right": run.is_right,
        "row": np.array(("none", "used", "dropped"))[run.row_state],
        "ratio": run.ratio,
        "length_m": run.length,
        "off_m": run.off,
    }


def _judge_alone(result):
    if result.problem:
        return False, NOTHING
    run, asked = result.run, {"data": "roof", "systems": "G", "memory": "single", "multipath": 0}
    by_rule = _has(result, asked) and len(result.satellites) <= 5
    reached = run.right.rate >= 0.95 and run.wrong.successes == 0
    return by_rule and reached, standing(_shares_words(run), by_rule)


def _judge_harm(result):
    if result.problem:
        return False, NOTHING
    run, by_rule = result.run, _has(result, {"data": "roof", "form": "guarded", "length_error": 0, "multipath": 0})
    harmed = run.wrong.rate >= 0.8 and result.runs["nowhere"].wrong.successes == 0
    return by_rule and harmed, standing(f"{_shares_words(run)}; with no length {100 * result.runs['nowhere'].wrong.rate:.1f} % wrong", by_rule)


def _has(result, asked):
    """Say whether the controls stand as asked."""
    return all(result.settings[name] == value for name, value in asked.items())


def _shares_words(run):
    return f"{100 * run.right.rate:.1f} % fixed and right, {100 * run.wrong.rate:.1f} % fixed and wrong"


GOALS = (
    Goal("five-alone", "The roof, GPS, each epoch alone, five satellites: fix 95 % of the epochs, none of them wrong.", _judge_alone),
    Goal("do-harm", "The roof, the right length, no multipath: find where the guarded row makes 80 % of the epochs fixed and wrong, "
         "while with no length none is.", _judge_harm),
)  # fmt: skip
