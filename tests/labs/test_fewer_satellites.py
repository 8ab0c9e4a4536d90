"""Lab of satellites taken away: corners, presets, where it breaks on real data, promises, thresholds, pictures."""

from dataclasses import replace

import numpy as np
import pytest

from gnsslab.core.integers import adop, success_rate
from gnsslab.figures.fewer_satellites import OUTCOMES, build_epochs, build_stages
from gnsslab.figures.kept import KeptPicture, new_figure
from gnsslab.labs import fewer_satellites
from gnsslab.labs.epoch_solutions import float_solutions, keep_satellites, middle
from gnsslab.labs.fewer_satellites import DATA_SETS, FILES, broken_at, fewer_satellites_lab
from gnsslab.simulate import find_preset, simulate, write_simulation
from gnsslab.simulate.receivers import white_factor

LAB = "fewer-satellites"
SIMULATED = {"data": "simulated"}


@pytest.fixture
def real(lab, dataset):
    """A function from settings to the lab's result with real data; skips where they cannot be had."""

    def run(**settings):
        dataset(DATA_SETS[settings.get("data", "roof")])
        return lab.run(**settings)

    return run


def _right(result):
    """Shares of right integers by number of satellites."""
    return {len(stage.satellites): shares.right for stage, shares in zip(result.stages, result.shares, strict=True)}


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_simulated_epochs_are_right_as_often_as_promised(lab, seed):
    """Bootstrapping's success rate is a lower bound for integer least squares: 4 sigma of a count below it at most, 6 % above."""
    result = lab.run(**SIMULATED, seed=seed)
    for (_, counted), promised in zip(_right(result).items(), result.promised, strict=True):
        sigma = np.sqrt(promised * (1 - promised) / 150) + 0.5 / 150
        assert promised - 4 * sigma <= counted < promised + 0.06 + 4 * sigma


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_simulated_epochs_keep_the_promise_of_the_known_length(lab, seed):
    """Two counts, 150 epochs and 700 simulated ones: 4 sigma of their difference."""
    result = lab.run(**SIMULATED, seed=seed, known_length=True)
    assert min(result.promised) < 0.6
    for counted, promised in zip(_right(result).values(), result.promised, strict=True):
        assert abs(counted - promised) < 4 * np.sqrt(promised * (1 - promised) * (1 / 150 + 1 / 700)) + 0.01


@pytest.mark.parametrize("known_length", [False, True])
@pytest.mark.parametrize("allowed", [1, 5])
def test_failure_rates_are_kept_in_simulated_data(lab, allowed, known_length):
    """Failures of all stages and of five seeds together, by the thresholds of as many simulations: 4 sigma of the counts."""
    failed = epochs = 0
    for seed in range(1, 6):
        result = lab.run(**SIMULATED, seed=seed, acceptance="rate", failure_rate=allowed, known_length=known_length)
        failed += sum(round(150 * shares.failed) for shares in result.shares)
        epochs += 150 * len(result.shares)
    expected = allowed / 100 * epochs
    assert 0 < failed < expected + 4 * np.sqrt(expected) * np.sqrt(1 + 5 * 150 / 700)  # a simulation's threshold serves 150 epochs


def test_goal_is_judged(lab, real):
    goal = lab.goal("roof-five")
    assert not goal.judge(lab.run(**SIMULATED))[0]
    reached = {"satellites": 5, "known_length": True, "acceptance": "rate", "failure_rate": 10}
    for settings, expected in (
        ({}, False), ({"satellites": 5}, False), ({"satellites": 5, "known_length": True}, False), (reached, True),
        (reached | {"frequencies": 2}, False), (reached | {"satellites": 6}, False),
    ):  # fmt: skip
        done, words = goal.judge(real(**settings))
        assert (done, words.startswith("Now: ")) == (expected, True), settings


def test_controls_without_effect_say_why(lab):
    assert set(lab.blocked(lab.settings())) == {"seed", "failure_rate", *FILES}
    assert set(lab.blocked(lab.settings(acceptance="rate"))) == set(FILES)
    assert "seed" not in lab.blocked(lab.settings(known_length=True))
    assert set(lab.blocked(lab.settings(data="mine"))) == {"seed", "failure_rate"}


def test_roof_stands_where_the_data_set_says(real):
    """Length and direction given with the set, which nothing here has seen; the carriers with our integers leave millimetres."""
    real()
    case = _roof_case()
    east, north, _ = case.baseline
    assert np.linalg.norm(case.baseline) == pytest.approx(0.9902, abs=0.006)
    assert np.degrees(np.arctan2(east, north)) % 360 == pytest.approx(193.028, abs=0.3)
    epochs = case.epochs
    n = len(epochs.integers)
    left = epochs.y[:, n:] / np.repeat(epochs.wavelengths, n) - epochs.integers
    assert np.abs(left).max() < 0.1  # cycles: no other integers are near


def _roof_case():
    engine = fewer_satellites.FewerEngine()
    case, note = engine._case(fewer_satellites_lab().settings())
    assert note == ""
    return case


def test_where_it_breaks_on_the_roof(real):
    """One frequency of a roof in Nagoya: nine satellites find every epoch, five a quarter; the length keeps five alive."""
    plain, known = real(), real(known_length=True)
    right, right_known = _right(plain), _right(known)
    assert list(right) == [9, 8, 7, 6, 5, 4]
    assert right[9] == 1
    assert min(right[8], right[7]) > 0.95
    assert 0.8 < right[6] < 0.95
    assert right[5] < 0.35
    assert right[4] < 0.1
    assert broken_at(plain) == 5
    assert min(right_known[k] for k in (9, 8, 7, 6, 5)) > 0.97
    assert 0.6 < right_known[4] < 0.95
    assert broken_at(known) is None


def test_where_it_breaks_between_the_stations(real):
    plain, known, two = real(data="stations"), real(data="stations", known_length=True), real(data="stations", frequencies=2)
    right, right_known = _right(plain), _right(known)
    assert list(right) == [7, 6, 5, 4]
    assert broken_at(plain) == 5
    assert right[6] > 0.6 > 0.35 > right[5]
    assert all(right_known[k] > right[k] + 0.2 for k in right)
    assert broken_at(known) is None
    assert min(_right(two).values()) == 1


def test_highest_is_the_worst_loss_and_lowest_the_least(real):
    """What the choices say, by ADOP of all one can lose."""
    real()
    epochs = _roof_case().epochs
    sigma = white_factor(epochs.elevation)
    kept = list(range(len(epochs.satellites)))
    while len(kept) > 4:
        rests = [[k for k in kept if k != out] for out in kept]
        spoiled = [adop(middle(float_solutions(keep_satellites(epochs, np.array(r)), 0.3 * sigma[r], 0.003 * sigma[r])).Q_a) for r in rests]
        assert (np.argmax(spoiled), np.argmin(spoiled)) == (0, len(kept) - 1)
        kept.pop()


def test_presets_of_real_data_show_what_they_promise(lab, real):
    shown = {p.name: real(**p.settings) for p in lab.presets}
    chosen = {name: result.shares[result.chosen] for name, result in shown.items()}
    assert chosen["roof-four"].failed > 0.2
    assert chosen["roof-four"].failed > 10 * chosen["roof-four"].fixed
    assert chosen["roof-length"].right > 0.97
    assert chosen["roof-two"].right == 1
    assert broken_at(shown["roof-highest"]) == 6
    assert chosen["roof-rate"].fixed + chosen["roof-rate"].failed < 0.03
    promised = {name: result.promised[result.chosen] for name, result in shown.items()}
    assert promised["roof-sharp"] == pytest.approx(0.73, abs=0.02)
    assert promised["roof"] == pytest.approx(0.12, abs=0.02)
    np.testing.assert_array_equal(shown["roof-sharp"].outcomes, shown["roof"].outcomes)  # only the ratio of the two sigmas matters
    assert 0.6 < chosen["stations"].right < 0.75
    assert chosen["stations-two"].right == 1


def test_promise_is_the_success_rate_of_what_is_believed(lab):
    result = lab.run(**SIMULATED)
    for stage, promised in zip(result.stages, result.promised, strict=True):
        assert promised == pytest.approx(float(success_rate(stage.solution.Q_a)))


def test_errors_are_those_of_the_positions_given_out(lab):
    result = lab.run(**SIMULATED, satellites=8)
    believed = result.stage.norms[:, 1] >= 3 * result.stage.norms[:, 0]
    np.testing.assert_array_equal(result.off, np.where(believed, result.stage.off_fixed, result.stage.off_float))
    assert np.median(result.stage.off_fixed[result.stage.is_right]) < 0.02 < 0.3 < np.median(result.stage.off_float)


def test_fewer_satellites_than_asked_for_are_said(lab, real):
    result = real(satellites=10)
    assert "No more than 9 satellites were tracked together, so 9 are shown." in result.note
    assert len(result.stage.satellites) == 9


def test_own_files(lab, tmp_path):
    assert "your master, rover and navigation files are missing" in lab.run(data="mine").problem
    preset = replace(find_preset("static-rtk-5km"), duration=60.0, systems="G")
    write_simulation(tmp_path, simulate(preset, np.random.default_rng(5)))
    names = dict(zip(FILES, ("master.obs", "rover.obs", "broadcast.nav"), strict=True))
    result = lab.run(data="mine", frequencies=2, **{k: str(tmp_path / v) for k, v in names.items()})
    assert result.problem == ""
    assert len(result.off) == 60
    assert _right(result)[max(_right(result))] > 0.9


@pytest.mark.parametrize("build", [build_stages, build_epochs])
def test_moves_leave_nothing_behind(lab, build):
    kept = KeptPicture(build, 440, 420, sharpness=0.5)
    for settings in ({"satellites": 9}, {"mask": 30}, {"acceptance": "all", "satellites": 4}, {}):
        moved = kept.png(result := lab.run(**SIMULATED, **settings))
    assert moved == KeptPicture(build, 440, 420, sharpness=0.5).png(result)


def test_bars_say_the_shares(lab):
    """Heights of the parts of each bar, read from the picture, by the name of what they stand for."""
    result = lab.run(**SIMULATED, satellites=5)
    figure = new_figure(440, 420)
    build_stages(figure).show(result)
    for part, name in zip(figure.axes[0].collections, OUTCOMES, strict=True):
        heights = {round(float(path.vertices[:, 0].mean() + 0.1)): np.ptp(path.vertices[:, 1]) for path in part.get_paths()}
        for x, shares in enumerate(result.shares):
            assert heights.get(x, 0.0) == pytest.approx(100 * getattr(shares, name)), (name, x)


def test_marks_say_the_outcomes(lab):
    result = lab.run(**SIMULATED, satellites=5, acceptance="all")
    figure = new_figure(380, 420)
    build_epochs(figure).show(result)
    counts = {line.get_label(): len(line.get_xdata()) for line in figure.axes[0].lines}
    right = int(result.stage.is_right.sum())
    assert counts == {"fixed, right": right, "fixed, wrong": 150 - right, "rejected, right": 0, "rejected, wrong": 0}
