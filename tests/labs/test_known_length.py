"""Lab of the known length: published shares, claims against counts, second routes, corners, presets, goals, pictures."""

import itertools
import json
from pathlib import Path

import numpy as np
import pytest

from gnsslab.core.integers import fix_with_length, integer_least_squares
from gnsslab.figures.kept import KeptPicture, new_figure
from gnsslab.figures.known_length import build_map, build_shares, fits_length
from gnsslab.labs import known_length
from gnsslab.labs.known_length import METHODS, Fixes

LAB = "known-length"
FEW = {"epochs": 100}


@pytest.fixture(scope="module")
def at_presets(lab):
    """Results of all presets, by name."""
    return {p.name: lab.run(**p.settings) for p in lab.presets}


@pytest.fixture(scope="module")
def published():
    """The model and the success rates for one epoch of L1, made elsewhere."""
    return json.loads((Path(__file__).parents[1] / "reference" / "constrained.json").read_text())


def _rates(result):
    return {name: fixes.right.rate for name, fixes in result.counted.fixes.items()}


def test_model_is_the_published_one(lab, published):
    """Float covariances of the toolbox's example: order and sign of its differences are ours; metres point the other way."""
    free, model = lab.run().counted.free, published["model"]
    for ours, theirs in ((free.Q_a, model["Qaa"]), (free.Q_b, model["Qbb"]), (np.abs(free.Q_ba), np.abs(model["Qba"]))):
        np.testing.assert_allclose(ours, theirs, rtol=1e-8)


@pytest.mark.parametrize("length", [0.5, 1, 2])
def test_published_success_rates(lab, published, length):
    """Shares of 3000 trials made elsewhere against 6000 of ours: 4 sigma of the difference of two counts."""
    runs = [lab.run(length=length, epochs=2000, seed=seed) for seed in (1, 2, 3)]
    rates = published["success_rate"]
    for ours, theirs in (("without", "unconstrained_ILS"), ("search", "constrained")):
        counted, made_elsewhere = np.mean([_rates(run)[ours] for run in runs]), rates[theirs][f"l={length:.1f}"]
        sigma = np.sqrt(made_elsewhere * (1 - made_elsewhere) * (1 / 6000 + 1 / rates["trials"]))
        assert abs(counted - made_elsewhere) < 4 * sigma, (ours, counted, made_elsewhere)


@pytest.mark.parametrize("method", ["without", "search"])
@pytest.mark.parametrize("settings", [{}, {"satellites": 4}, {"satellites": 5}, {"carrier_noise": 10}, {"code_noise": 0.5}, {"length": 0.3}], ids=str)
def test_honest_methods_claim_what_they_keep(lab, method, settings):
    """The likelihoods' shares are calibrated: 4 sigma of the count, and 2 % for vectors on the sphere that were left out of the sum."""
    fixes = lab.run(epochs=2000, **settings).counted.fixes[method]
    assert abs(fixes.claimed - fixes.right.rate) < 4 * fixes.right.sigma + 0.02 * (method == "search")


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_row_and_twice_claim_far_too_much(lab, seed):
    counted = lab.run(seed=seed).counted
    for method in ("row", "twice"):
        fixes = counted.fixes[method]
        assert fixes.claimed > fixes.right.rate + 0.5
    assert counted.fixes["row"].right.rate < counted.fixes["without"].right.rate  # worse than no length at all
    assert counted.fixes["twice"].claimed > 0.95


def test_library_refuses_the_second_use(lab):
    with pytest.raises(ValueError, match="used the known length already"):
        fix_with_length(lab.run().counted.tied, 1.0)


def test_row_by_one_big_system(lab):
    """The row as one more line of whitened least squares, all unknowns at once, epoch by epoch."""
    settings = lab.settings(row_sigma=5)
    result, (A, B, Q_y) = lab.run(row_sigma=5), known_length._model(settings)
    counted, n = result.counted, A.shape[1]
    noise = known_length._noise(settings["seed"], settings["epochs"], settings["satellites"])
    y = counted.truth @ B.T + noise.measurements @ np.linalg.cholesky(Q_y).T
    W = np.linalg.inv(np.linalg.cholesky(Q_y))
    for t in (0, 7, 99):
        b_0 = counted.free.b_hat[t]
        h = b_0 / np.linalg.norm(b_0)
        lines = np.vstack([W @ np.hstack([A, B]), np.concatenate([np.zeros(n), h])[None] / 0.05])
        x = np.linalg.lstsq(lines, np.append(W @ y[t], (1.0 - np.linalg.norm(b_0) + h @ b_0) / 0.05))[0]
        np.testing.assert_allclose(x, np.concatenate([counted.tied.a_hat[t], counted.tied.b_hat[t]]), atol=1e-8)


def test_search_and_scaling_by_brute_force(lab):
    """The 400 nearest integer vectors, each with the cost of the sphere's nearest point by a fine grid of multipliers, and of scaling."""
    result = lab.run(length_error=1, epochs=100)
    free, fixes = result.counted.free, result.counted.fixes
    gain = free.Q_ba @ np.linalg.inv(free.Q_a)
    weight = np.linalg.inv(free.Q_b - gain @ free.Q_ba.T)
    for t in range(15):
        near = integer_least_squares(free.a_hat[t], free.Q_a, 400)
        b = free.b_hat[t] - (free.a_hat[t] - near.candidates) @ gain.T
        scaled = b * (1.01 / np.linalg.norm(b, axis=1))[:, None] - b
        exact = near.norms + _squared_distances_from_sphere(b, weight, 1.01)
        for costs, method in ((near.norms + np.einsum("ki,ij,kj->k", scaled, weight, scaled), "scaled"), (exact, "search")):
            assert costs.min() < near.norms[-1]  # no vector beyond the 400 can cost less
            np.testing.assert_array_equal(fixes[method].integers[t], near.candidates[np.argmin(costs)])
            assert fixes[method].norms[t, 0] == pytest.approx(costs.min(), rel=1e-5)


def _squared_distances_from_sphere(c, W, length):
    """Return min (b - c)' W (b - c) over |b| = length, c (k, 3): (W + m I) b = W c, m by bisection, as the length of b falls with m."""
    low, high = np.full(len(c), -np.linalg.eigvalsh(W)[0] * (1 - 1e-12)), np.linalg.norm(c @ W, axis=1) / length
    for _ in range(100):
        m = (low + high) / 2
        b = np.linalg.solve(W + m[:, None, None] * np.eye(3), (c @ W)[..., None])[..., 0]
        long = np.linalg.norm(b, axis=1) > length
        low, high = np.where(long, m, low), np.where(long, high, m)
    return np.einsum("ki,ij,kj->k", b - c, W, b - c)


def test_scaling_never_costs_less_and_loses_where_the_length_is_wrong(at_presets, lab):
    for result in (*at_presets.values(), lab.run()):
        exact, scaled = (result.counted.fixes[name] for name in ("search", "scaled"))
        assert (scaled.norms[:, 0] >= exact.norms[:, 0] - 1e-9).all()
    exact, scaled = (at_presets["scaled-length"].counted.fixes[name].is_right for name in ("search", "scaled"))
    only_exact, only_scaled = np.sum(exact & ~scaled), np.sum(scaled & ~exact)
    assert only_exact - only_scaled > 4 * np.sqrt(only_exact + only_scaled)  # a sign test on the epochs where they differ


def test_claim_is_the_best_ones_share_of_the_likelihood():
    fixes = Fixes(np.zeros((2, 1)), np.zeros((2, 3)), np.array([[1.0, 3.0, 9.0], [2.0, 2.0, np.inf]]))
    likelihood = np.exp(-0.5 * fixes.norms)
    np.testing.assert_allclose(fixes.claim, likelihood[:, 0] / likelihood.sum(axis=1))
    assert fixes.is_believed.tolist() == [True, False]


def test_presets_show_what_they_promise(at_presets):
    rates = {name: _rates(result) for name, result in at_presets.items()}
    claims = {name: {m: f.claimed for m, f in result.counted.fixes.items()} for name, result in at_presets.items()}
    assert rates["one-epoch"]["without"] == pytest.approx(0.31, abs=0.06)  # 2.5 sigma of 400
    assert rates["one-epoch"]["search"] == pytest.approx(0.96, abs=0.03)
    assert rates["length-row"]["row"] < rates["length-row"]["without"]
    assert claims["length-row"]["row"] == pytest.approx(0.83, abs=0.03)
    assert claims["length-twice"]["twice"] == pytest.approx(0.99, abs=0.02)
    assert rates["length-twice"]["twice"] == pytest.approx(0.25, abs=0.06)
    assert rates["short-baseline"]["search"] > rates["one-epoch"]["search"]
    assert rates["long-baseline"]["row"] > 2 * rates["one-epoch"]["row"]
    assert 1.7 < claims["long-baseline"]["row"] / rates["long-baseline"]["row"] < 2.6
    assert rates["length-off"]["search"] < 0.03
    assert claims["length-off"]["search"] > 0.8
    assert rates["hard-direction"]["search"] < 0.93
    assert rates["nine-satellites"]["without"] > 0.98
    assert rates["nine-satellites"]["row"] < 0.6


def test_other_heading_of_the_hard_direction(lab):
    settings = lab.preset("hard-direction").settings
    assert _rates(lab.run(**settings | {"heading": 150}))["search"] > 0.98


def test_epoch_on_the_map_is_one_of_those_counted(lab):
    for method, epoch in itertools.product(METHODS, (1, 18)):
        result = lab.run(method=method, epoch=epoch)
        shown, fixes = result.shown, result.fixes
        assert shown.is_right == fixes.is_right[epoch - 1]
        np.testing.assert_allclose(shown.answer, fixes.baseline[epoch - 1])
        assert (np.diff(shown.distances[:-1]) >= -1e-9).all()
        assert shown.distances[-1] >= shown.distances[0] - 1e-9
        if method in ("without", "row"):
            np.testing.assert_allclose(shown.baselines[-1], shown.baselines[0])
    np.testing.assert_allclose(np.linalg.norm(lab.run().shown.answer), 1.0)


def test_default_epoch_tells_the_story(lab):
    """Without the length it is wrong by decimetres, with it right to a centimetre, and one of the vectors alone fits."""
    result = lab.run()
    shown = result.shown
    assert shown.is_right
    assert np.linalg.norm(shown.answer_without - shown.truth) > 0.3
    assert np.linalg.norm(shown.answer - shown.truth) < 0.02
    assert fits_length(shown, result.entered)[:-1].sum() == 1


def test_directions_are_as_set(lab):
    truth = lab.run(direction="set", heading=90, pitch=30, length=2).counted.truth
    np.testing.assert_allclose(truth, np.tile([np.sqrt(3), 0, 1], (len(truth), 1)), atol=1e-12)
    any_direction = lab.run(length=2, epochs=2000).counted.truth
    np.testing.assert_allclose(np.linalg.norm(any_direction, axis=1), 2)
    assert np.abs(any_direction.mean(axis=0)).max() < 4 * 2 / np.sqrt(3 * 2000)


def test_more_epochs_begin_with_the_same_ones(lab):
    few, many = (lab.run(epochs=count).fixes.is_right for count in (200, 400))
    np.testing.assert_array_equal(few, many[:200])


@pytest.mark.parametrize(
    ("goal", "settings", "reached"),
    [
        ("five", {}, False),
        ("five", {"satellites": 5}, False),
        ("five", {"satellites": 5, "carrier_noise": 1}, True),
        ("five", {"satellites": 5, "carrier_noise": 1, "length": 0.5}, False),
        ("five", {"satellites": 5, "carrier_noise": 1, "code_noise": 0.1}, False),
        ("honest", {}, False),
        ("honest", {"row_sigma": 35}, True),
        ("honest", {"row_sigma": 35, "seed": 5}, True),
        ("honest", {"row_sigma": 35, "code_noise": 0.1}, False),
        ("honest", {"row_sigma": 35, "length": 5}, False),
    ],
)
def test_goals_are_judged(lab, goal, settings, reached):
    result = lab.run(**settings)
    assert lab.goal(goal).judge(result)[0] == reached
    assert lab.goal(goal).judge(result)[1].startswith("Now: ")


def test_controls_without_effect_say_why(lab):
    assert set(lab.blocked(lab.settings())) == {"heading", "pitch"}
    assert lab.blocked(lab.settings(direction="set")) == {}


@pytest.mark.parametrize("build", [build_map, build_shares])
def test_moves_leave_nothing_behind(at_presets, build):
    kept = KeptPicture(build, 440, 480, sharpness=0.5)
    for result in at_presets.values():
        moved = kept.png(result)
    assert moved == KeptPicture(build, 440, 480, sharpness=0.5).png(result)


def test_what_was_chosen_is_never_off_the_map(lab):
    figure = new_figure(440, 480)
    scene = build_map(figure)
    for epoch, length in itertools.product((1, 9, 18, 40), (0.3, 1, 5)):
        result = lab.run(epoch=epoch, length=length, **FEW)
        half = scene.show(result)
        assert np.abs(np.array([result.shown.truth, result.shown.b_hat, result.shown.baselines[-1]])[:, :2]).max() < half
        assert result.entered < half


def test_bars_say_the_counts(lab):
    result = lab.run()
    figure = new_figure(380, 480)
    build_shares(figure).show(result)
    bars = figure.axes[1].patches
    np.testing.assert_allclose([bar.get_width() for bar in bars], [100 * rate for rate in _rates(result).values()])
