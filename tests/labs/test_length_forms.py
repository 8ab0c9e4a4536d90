"""Lab of the forms of a known length: what each does to real epochs, which fixes are wrong, the guard's state, presets, goals, pictures."""

from dataclasses import replace

import numpy as np
import pytest

from gnsslab.figures.kept import KeptPicture, new_figure
from gnsslab.figures.length_forms import NAMES, PARTS, STATES, build_forms, build_run
from gnsslab.gnss.frames import enu_rotation
from gnsslab.labs.length_forms import FILES, LengthFormsEngine, length_forms_lab
from gnsslab.labs.length_runs import FORMS, run_engine, run_form
from gnsslab.simulate import find_preset, simulate, write_simulation
from gnsslab.systems.constrained_filter import FilterSettings, run_filter, steady_path
from gnsslab.systems.dual_antenna import A_STATIC
from gnsslab.systems.length_row import LengthUse, RowState

SIMULATED = {"data": "simulated"}
ROW_FORMS = ("guarded", "row", "iterated", "second")


@pytest.fixture(scope="module")
def lab():
    """The lab, whose caches serve all tests here."""
    return length_forms_lab()


@pytest.fixture
def real(lab, dataset):
    """A function from settings to the lab's result on the roof; skips where the data cannot be had."""

    def run(**settings):
        dataset("matrtklib-static")
        result = lab.run(**settings)
        assert (result.problem, "simulated" in result.note) == ("", False)
        return result

    return run


@pytest.fixture(scope="module")
def roof_pair():
    """A function from a way to carry on to the PreparedPair of the roof, all GPS satellites."""
    engine = LengthFormsEngine()

    def pair(memory):
        settings = length_forms_lab().settings(memory=memory, satellites=9)
        known, _ = engine._known(settings)
        return known, engine._pair(known, replace(known.settings, systems="G", single_epoch=memory == "single"), settings, 1.0)

    return pair


def _shares(result):
    """Percent right and wrong by form."""
    return {form: (100 * run.right.rate, 100 * run.wrong.rate) for form, run in result.runs.items()}


# --- the finding, on the roof


def test_row_before_the_integers_does_harm(real):
    """GPS L1, filter: what is fixed with no length is lost with a row from the first epoch on; the search fixes from the first epoch on."""
    nine = _shares(real(satellites=9))
    assert nine["nowhere"] == (100, 0)
    assert nine["row"] == nine["iterated"] == (0, 0)
    eight = real()
    shares = _shares(eight)
    assert shares["nowhere"][0] > 60
    assert max(shares[form][0] for form in ROW_FORMS) < 5
    for form in ("search", "engine"):
        assert shares[form] == (100, 0)
        assert eight.runs[form].first_fix == 0


@pytest.mark.parametrize("satellites", [9, 8, 7, 6, 5])
def test_search_in_a_filter_fixes_every_epoch(real, satellites):
    """Asked: 99 % with six and five satellites, none wrong."""
    shares = _shares(real(satellites=satellites))
    for form in ("search", "engine"):
        assert shares[form][0] >= 99
        assert shares[form][1] == 0


@pytest.mark.parametrize(("satellites", "asked"), [(6, 89.0), (5, 75.0)])
def test_search_in_single_epochs(real, satellites, asked):
    """Six highest 89 %, five highest 75 %, none wrong, and twice what is fixed with no length; the guard lets no row in."""
    result = real(memory="single", satellites=satellites)
    shares = _shares(result)
    for form in ("search", "engine"):
        assert shares[form][0] >= asked - 0.05  # as given, in tenths
        assert shares[form][0] >= 2 * shares["nowhere"][0] - 0.4  # one epoch of 301
        assert shares[form][1] == 0
    assert result.runs["guarded"].dropped == 1
    assert shares["guarded"] == shares["nowhere"]


@pytest.mark.parametrize("sign", [-1, 1])
def test_wrong_length_in_single_epochs(real, sign):
    """Six highest: off by 5 mm still 80 %, none wrong; off by 10 cm at most 2 % accepted."""
    for form in ("search", "engine"):
        right, wrong = _shares(real(memory="single", satellites=6, length_error=0.5 * sign))[form]
        assert (right >= 80, wrong) == (True, 0)
        assert sum(_shares(real(memory="single", satellites=6, length_error=10 * sign))[form]) <= 2


def test_what_presets_promise(lab, real):
    shares = {preset.name: _shares(real(**preset.settings)) for preset in lab.presets if preset.name != "paper-receivers"}
    guarded = real()
    assert 100 * guarded.run.dropped == pytest.approx(29, abs=0.5)
    used = guarded.run.row_state == RowState.USED
    assert np.median(guarded.run.off[used]) == pytest.approx(0.4, abs=0.05)
    assert np.abs(guarded.run.length[used] - guarded.entered).max() < 0.03
    assert shares["guarded-row"]["guarded"] == (0, 0)
    assert (shares["row-always"]["nowhere"][0], shares["row-always"]["row"][0]) == (100, 0)
    assert shares["iterated-row"]["iterated"][0] == pytest.approx(97, abs=0.5)
    assert [_shares(real(satellites=count))["iterated"][0] for count in (5, 7, 8, 9)] == [0, 0, 0, 0]
    assert shares["second-order"]["second"][1] == pytest.approx(95, abs=0.5)
    assert shares["in-the-search"]["nowhere"][0] == pytest.approx(48, abs=0.5)
    assert shares["epochs-alone"]["search"][0] == pytest.approx(93, abs=0.5)
    assert shares["two-centimetres"]["search"] == (pytest.approx(22, abs=0.5), 0)
    tens = shares["ten-centimetres"]
    assert min(tens[form][1] for form in ROW_FORMS) == pytest.approx(66, abs=0.5)
    assert max(tens[form][1] for form in ROW_FORMS) == pytest.approx(97, abs=0.5)
    assert sum(tens["search"]) < 2
    below = _shares(real(length_error=-10))
    assert (below["search"][1], below["engine"][1]) == (100, 0)
    halved = real(noise=0.5, satellites=6)
    assert 100 * halved.run.dropped == pytest.approx(18, abs=0.5)
    assert shares["noise-halved"]["guarded"][0] == 0
    assert _shares(real(satellites=6))["guarded"][0] == pytest.approx(74, abs=0.5)
    multipath = shares["added-multipath"]
    assert [round(multipath[form][0]) for form in ("nowhere", "guarded", "search", "engine")] == [53, 0, 78, 100]


def test_the_papers_receivers(lab):
    """Simulated: nothing but the row at every epoch does harm."""
    shares = _shares(lab.run(**lab.preset("paper-receivers").settings))
    assert (shares["row"], shares["iterated"]) == ((0, 0), (0, 0))
    assert min(shares[form][0] for form in ("nowhere", "guarded", "second", "search", "engine")) > 98
    assert max(wrong for _, wrong in shares.values()) == 0


# --- what counts as wrong, and the guard


@pytest.mark.parametrize("memory", ["single", "filter"])
@pytest.mark.parametrize("form", ["nowhere", "second", "search", "engine"])
def test_wrong_are_those_that_ask_for_other_integers(dataset, roof_pair, memory, form):
    """Second route: the integers that a baseline leaves in the double-difference carriers, against those that the truth leaves."""
    dataset("matrtklib-static")
    known, whole = roof_pair(memory)
    kept = whole.order[1:6]  # five of them, so that some are wrong
    model = whole.prepared.model
    pair = replace(whole, prepared=whole.prepared._replace(model=replace(model, usable=model.usable & np.isin(model.pair.satellite, kept))))
    run = run_form(pair, known.baseline, form, memory, FilterSettings(length=known.length))
    R_ne, channels = enu_rotation(whole.prepared.master_ecef), np.flatnonzero(np.isin(model.pair.satellite, kept))

    def integers(baseline):
        b = np.einsum("tij,ti->tj", R_ne, np.broadcast_to(baseline, run.baseline.shape)) - model.near
        left = model.phase[:, channels] - np.einsum("tci,ti->tc", model.design[:, channels], b)
        return np.rint((left[:, 1:] - left[:, :1]) / model.pair.wavelength[channels[0]])

    other = (integers(run.baseline) != integers(known.baseline)).any(axis=1)
    np.testing.assert_array_equal(run.is_wrong, run.is_fixed & other)
    np.testing.assert_array_equal(run.is_right, run.is_fixed & ~other)


def test_guard_drops_the_row_of_uncertain_baselines(dataset, roof_pair):
    """Dropped where the float sigma is above a tenth of the length in the mean of the axes, and only there."""
    dataset("matrtklib-static")
    known, pair = roof_pair("filter")
    path = steady_path(pair.prepared, np.array(A_STATIC.velocity_noise))
    found = run_filter(pair.prepared, path, FilterSettings(length=known.length, length_use=LengthUse.GUARDED_ROW))
    run = run_form(pair, known.baseline, "guarded", "filter", FilterSettings(length=known.length))
    dropped = run.row_state == RowState.DROPPED
    assert 0 < dropped.sum() < len(dropped)
    np.testing.assert_array_equal(dropped, np.isnan(found.row_innovation))
    assert (np.trace(found.Q_float[dropped], axis1=1, axis2=2) > 3 * (0.1 * known.length) ** 2).all()
    assert (np.trace(found.Q_float[~dropped], axis1=1, axis2=2) < 3 * (0.1 * known.length) ** 2).all()
    assert run.dropped == pytest.approx(dropped.mean())


def test_single_epochs_know_nothing_of_each_other(dataset, roof_pair):
    """Every second epoch taken out, the others stay as they were."""
    dataset("matrtklib-static")
    known, pair = roof_pair("single")
    model = pair.prepared.model
    half = replace(
        model,
        pair=replace(model.pair, time=model.pair.time[::2]),
        **{name: getattr(model, name)[::2] for name in ("near", "design", "code", "phase", "sigma_code", "sigma_phase", "novelty", "usable", "slip")},
    )
    fewer = replace(pair, prepared=pair.prepared._replace(model=half, master_ecef=pair.prepared.master_ecef[::2]))
    for form in ("nowhere", "search"):
        whole, part = (run_form(each, known.baseline, form, "single", FilterSettings(length=known.length)) for each in (pair, fewer))
        np.testing.assert_allclose(part.ratio, whole.ratio[::2], rtol=1e-9)
        np.testing.assert_allclose(part.baseline, whole.baseline[::2], atol=1e-9)


def test_engine_with_and_without_a_length(dataset, roof_pair):
    dataset("matrtklib-static")
    known, pair = roof_pair("single")
    alone, search = run_engine(pair, known.baseline), run_engine(pair, known.baseline, known.length)
    assert search.right.rate >= alone.right.rate
    assert not (alone.row_state != RowState.NONE).any()


# --- data, notes, refusals


def test_fewer_satellites_than_asked_for_are_said(lab):
    result = lab.run(**SIMULATED, satellites=15)
    count = len(result.satellites)
    assert f"No more than {count} satellites are above 15 degrees, so {count} are used." in result.note


def test_one_control_that_does_not_matter_makes_no_new_run(lab):
    """The form shown, and what a form does not look at, leave its run as it is."""
    before = lab.run(**SIMULATED).runs
    assert all(lab.run(**SIMULATED, form="search").runs[form] is before[form] for form in FORMS)
    longer = lab.run(**SIMULATED, length_error=1).runs
    assert [form for form in FORMS if longer[form] is before[form]] == ["nowhere"]
    noisier = lab.run(**SIMULATED, noise=4.0).runs
    assert [form for form in FORMS if noisier[form] is before[form]] == ["engine"]


def test_seed_draws_what_is_drawn(lab, real):
    chosen = [set(real(order="chance", satellites=6, seed=seed).satellites) for seed in (1, 2, 1)]
    assert chosen[0] == chosen[2] != chosen[1]
    noisy = [real(multipath=0.5, seed=seed).run.off for seed in (1, 2, 1)]
    np.testing.assert_array_equal(noisy[0], noisy[2])
    assert (noisy[0] != noisy[1]).any()
    assert real(seed=2).run is real(seed=3).run


def test_highest_and_lowest_are_kept(real):
    nine, six, low = (real(satellites=count, order=order).satellites for count, order in ((9, "highest"), (6, "highest"), (3 + 1, "lowest")))
    assert six == nine[:6]
    assert set(low) == set(nine[-4:])


def test_own_files(lab, tmp_path):
    assert "your master, rover and navigation files are missing" in lab.run(data="mine").problem
    assert lab.readouts(lab.run(data="mine")) == []
    assert lab.describe(lab.run(data="mine")).startswith("No answer: ")
    preset = replace(find_preset("static-baseline"), duration=60.0, systems="G")
    write_simulation(tmp_path, simulate(preset, np.random.default_rng(5)))
    names = dict(zip(FILES, ("master.obs", "rover.obs", "broadcast.nav"), strict=True))
    result = lab.run(data="mine", **{k: str(tmp_path / v) for k, v in names.items()})
    assert result.problem == ""
    assert result.entered == pytest.approx(1.167, abs=0.005)
    assert len(result.run.off) == 60


def test_controls_without_effect_say_why(lab):
    assert set(lab.blocked(lab.settings())) == {"seed", *FILES}
    assert set(lab.blocked(lab.settings(order="chance"))) == set(FILES)
    assert set(lab.blocked(lab.settings(multipath=0.5))) == set(FILES)
    assert set(lab.blocked(lab.settings(memory="single"))) == {"seed", "hold_after", *FILES}
    assert set(lab.blocked(lab.settings(data="simulated"))) == set(FILES)


def test_goals_are_judged(lab, real):
    alone, harm = lab.goal("five-alone").judge, lab.goal("do-harm").judge
    five = {"memory": "single", "satellites": 5, "form": "search"}
    for settings, expected in ((five, False), (five | {"ratio": 1.5}, True), (five | {"ratio": 1.5, "satellites": 6}, False), ({}, False)):
        done, words = alone(real(**settings))
        assert (done, words.startswith("Now: ")) == (expected, True), settings
    learnt = {"noise": "learnt", "satellites": 6}
    for settings, expected in ((learnt, True), (learnt | {"length_error": 5}, False), (learnt | {"form": "search"}, False), ({}, False)):
        done, words = harm(real(**settings))
        assert (done, words.startswith("Now: ")) == (expected, True), settings
    assert not alone(lab.run(data="mine"))[0]
    assert not harm(lab.run(data="mine"))[0]


def test_no_preset_reaches_a_goal(lab, real):
    results = [real(**preset.settings) for preset in lab.presets if preset.settings.get("data", "roof") == "roof"]
    assert len(results) >= 8
    assert not any(goal.judge(result)[0] for goal in lab.goals for result in results)


# --- readouts and pictures


def test_readouts_say_the_guard_aloud(lab):
    for form in FORMS:
        result = lab.run(**SIMULATED, form=form)
        right, wrong, row, error, search = lab.readouts(result)
        assert (right.label, wrong.label, error.label, search.label) == ("Fixed, right", "Fixed, wrong", "Error", "In the search")
        assert (row.label, row.value) == (("Row dropped", f"{100 * result.run.dropped:.0f}") if form in ROW_FORMS else ("Row", "none"))


@pytest.mark.parametrize("build", [build_forms, build_run])
def test_moves_leave_nothing_behind(lab, build):
    kept = KeptPicture(build, 460, 420, sharpness=0.5)
    for settings in ({"form": "search"}, {"memory": "single", "satellites": 4}, {"length_error": 10, "form": "row"}, {}):
        moved = kept.png(result := lab.run(**SIMULATED, **settings))
    assert moved == KeptPicture(build, 460, 420, sharpness=0.5).png(result)


def test_bars_say_the_shares(lab):
    """Widths of the parts of each bar, read from the picture, and the numbers beside."""
    result = lab.run(**SIMULATED, memory="single", satellites=5)
    figure = new_figure(460, 420)
    build_forms(figure).show(result)
    axes, rows = figure.axes[0], {name: len(NAMES) - 1 - k for k, name in enumerate(NAMES)}
    expected = {name: (run.right.rate, run.wrong.rate, 1 - run.right.rate - run.wrong.rate) for name, run in result.runs.items()}
    for k, part in enumerate(axes.collections):
        widths = {round(float(np.mean(path.vertices[:4, 1]))): np.ptp(path.vertices[:, 0]) for path in part.get_paths()}
        assert part.get_label() == list(PARTS.values())[k][0]
        for name, row in rows.items():
            assert widths.get(row, 0.0) == pytest.approx(100 * expected[name][k], abs=1e-9), (name, k)
    low, high = result.runs["search"].right.interval
    x, y = axes.lines[0].get_data()
    np.testing.assert_allclose(x[y == rows["search"]][:2], [100 * low, 100 * high])


def test_states_say_what_became_of_each_epoch(lab):
    result = lab.run(**SIMULATED, form="guarded")
    figure = new_figure(400, 420)
    build_run(figure).show(result)
    run = result.run
    counts = [int(at.sum()) for at in (run.row_state == RowState.DROPPED, run.row_state == RowState.USED, ~run.is_fixed, run.is_wrong, run.is_right)]
    assert [len(line.get_xdata()) for line in figure.axes[0].lines] == counts
    assert [text.get_text() for text in figure.axes[0].get_yticklabels()] == list(STATES)
    assert f"row dropped at {100 * run.dropped:.1f} % of the epochs" in figure.axes[0].get_title(loc="left")


def test_names_are_those_of_the_forms(lab):
    assert list(NAMES) == list(FORMS) == list(lab.control("form").corners)
