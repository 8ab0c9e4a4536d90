"""Lab of the covariance of double differences: corners, presets, promises; and what ignoring correlation costs."""

from dataclasses import replace

import numpy as np
import pytest

from gnsslab.labs import correlation
from gnsslab.labs.correlation import EPOCHS
from gnsslab.simulate import find_preset, simulate, write_simulation

LAB = "correlation"
MM = 1e-3


@pytest.fixture(scope="module")
def at_presets(lab):
    """Results of all presets of simulated data, by name."""
    return {p.name: lab.run(**p.settings) for p in lab.presets if p.settings.get("data") != "real"}


def _right(result):
    return float(np.mean(result.solved.is_right))


def test_pattern_appears_by_itself(lab):
    """Entries of a sample covariance of N draws have variance (Q_ij^2 + Q_ii Q_jj) / (N - 1); 4.5 sigma on each of 49."""
    result = lab.run()
    n = 7
    pattern = 2 * (np.eye(n) + np.ones((n, n)))
    np.testing.assert_allclose(result.believed, pattern, rtol=1e-12)
    spread = np.sqrt((pattern**2 + 16) / (EPOCHS - 1))
    assert (np.abs(result.sampled - pattern) < 4.5 * spread).all()


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_integers_are_right_as_often_as_promised(lab, seed):
    """Bootstrapping's success rate is a lower bound for integer least squares: 4 sigma of a count below it at most, 3 % above."""
    solved = lab.run(seed=seed).solved
    sigma = np.sqrt(solved.promised * (1 - solved.promised) / EPOCHS)
    assert solved.promised - 4 * sigma < np.mean(solved.is_right) < solved.promised + 0.03 + 4 * sigma


@pytest.mark.parametrize("growing", [False, True])
def test_claims_hold_where_the_correlation_is_respected(lab, growing):
    solved = lab.run(growing=growing, reference="low").solved
    np.testing.assert_allclose(solved.baseline.var(axis=0), np.diag(solved.Q_baseline), rtol=4 * np.sqrt(2 / EPOCHS))


@pytest.mark.parametrize("growing", [False, True])
def test_reference_moves_the_baseline_only_where_correlation_is_ignored(lab, growing):
    for belief in ("respected", "doubled", "unsquared"):
        assert lab.run(belief=belief, growing=growing).moved < 1e-6 * MM
    assert lab.run(belief="ignored", growing=growing).moved > 2 * MM


def test_presets_show_what_they_promise(at_presets):
    right = {name: _right(result) for name, result in at_presets.items()}
    ratio = {name: np.median(result.solved.ratio) for name, result in at_presets.items()}
    assert right["pattern"] > 0.95
    assert ratio["ignored"] < 0.8 * ratio["pattern"]
    assert right["low-respected"] > 0.85 > 0.5 > right["low-ignored"]
    assert right["few"] < 0.5
    np.testing.assert_allclose(at_presets["doubled"].solved.ratio, at_presets["pattern"].solved.ratio, rtol=1e-6)
    assert np.mean(at_presets["unsquared"].solved.is_fixed) < 0.1 < 0.5 < np.mean(at_presets["pattern"].solved.is_fixed)


def test_ignoring_makes_the_solver_too_sure_of_up(at_presets):
    solved = at_presets["ignored"].solved
    assert solved.baseline[:, 2].std() > 1.3 * np.sqrt(solved.Q_baseline[2, 2])


def test_printed_covariances_claim_what_their_words_say(at_presets):
    """2 V: sqrt 2 too large; not squared: sqrt(1 / (2 sigma)) = 12.9 at 3 mm."""
    claimed = {name: np.sqrt(np.diag(at_presets[name].solved.Q_baseline)) for name in ("pattern", "doubled", "unsquared")}
    np.testing.assert_allclose(claimed["doubled"] / claimed["pattern"], np.sqrt(2), rtol=1e-9)
    np.testing.assert_allclose(claimed["unsquared"] / claimed["pattern"], np.sqrt(1 / 0.006), rtol=1e-9)


@pytest.mark.parametrize(
    ("settings", "reached"),
    [
        ({}, False),  # against the rules
        ({"growing": True, "reference": "low"}, False),
        ({"growing": True, "reference": "low", "code_noise": 0.15, "carrier_noise": 2}, True),
        ({"growing": True, "reference": "low", "code_noise": 0.15, "carrier_noise": 2, "belief": "ignored"}, False),
        ({"growing": True, "reference": "low", "code_noise": 0.15, "carrier_noise": 2, "satellites": 9}, False),
        ({"data": "mine"}, False),
    ],
)
def test_goal_is_judged(lab, settings, reached):
    assert lab.goal("frugal").judge(lab.run(**settings))[0] == reached


def test_controls_without_effect_say_why(lab):
    assert set(lab.blocked(lab.settings())) == set(correlation.FILES)
    assert set(correlation.SIMULATION_ONLY) <= set(lab.blocked(lab.settings(data="real")))


def test_real_stations_show_the_pattern(lab, dataset):
    dataset("geonet-0759-3040")
    result = lab.run(**lab.preset("real-pattern").settings)
    n = len(result.sampled)
    beside = (result.sampled.sum() - np.trace(result.sampled)) / (n * (n - 1))
    assert n == 5
    assert np.trace(result.sampled) / n == pytest.approx(4.0)  # by choice of the unit
    assert 1.5 < beside < 3.0  # 2 by the formula
    assert (result.sampled > 0).all()


def test_real_stations_lose_integers_where_correlation_is_ignored(lab, dataset):
    dataset("geonet-0759-3040")
    respected, ignored = (lab.run(**lab.preset(name).settings) for name in ("real-pattern", "real-ignored"))
    assert _right(respected) > _right(ignored) + 0.1
    assert respected.moved < 1e-6 < 1 * MM < ignored.moved
    assert np.linalg.norm(np.median(respected.solved.baseline, axis=0)) < 0.02  # about the engine's own baseline, which used two frequencies


def test_more_satellites_than_there_are_is_said(lab, dataset):
    dataset("geonet-0759-3040")
    result = lab.run(data="real", satellites=9)
    assert "No more than 7 satellites" in result.note
    assert len(result.satellites) == 7


def test_own_files(lab, tmp_path):
    assert "your master, rover and navigation files are missing" in lab.run(data="mine").problem
    preset = replace(find_preset("static-rtk-5km"), duration=60.0, systems="G")
    write_simulation(tmp_path, simulate(preset, np.random.default_rng(5)))
    names = dict(zip(correlation.FILES, ("master.obs", "rover.obs", "broadcast.nav"), strict=True))
    result = lab.run(data="mine", satellites=6, **{k: str(tmp_path / v) for k, v in names.items()})
    assert result.problem == ""
    assert len(result.solved.ratio) == 60
    short = replace(preset, duration=12.0)
    write_simulation(tmp_path, simulate(short, np.random.default_rng(5)))
    refused = lab.run(data="mine", **{k: str(tmp_path / v) for k, v in names.items()})
    assert "fewer than 5 satellites were tracked together for 20 epochs" in refused.problem
