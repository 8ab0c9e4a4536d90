"""Lab between all integers and none: corners, presets, promises; and the estimators against each other."""

import math

import numpy as np
import pytest

from gnsslab.labs import soft_fixing
from gnsslab.labs.soft_fixing import EPOCHS, RISKS, SIGMAS, single_ambiguity, soft_fixing_lab

LAB = "soft-fixing"
MM = 1e-3


@pytest.fixture(scope="module")
def at_presets(lab):
    """Results of all presets, by name."""
    return {preset.name: lab.run(**preset.settings) for preset in lab.presets}


def test_presets_show_what_they_promise(at_presets):
    rms = {name: result.rms for name, result in at_presets.items()}
    start = at_presets["soft"]
    assert np.mean(start.is_right) > 0.95
    assert rms["soft"]["soft"] < 0.95 * rms["soft"]["fixed"] < 0.5 * rms["soft"]["tested"]
    trees = at_presets["trees"]
    assert np.mean(trees.is_tested) < 0.15  # "rejects nine epochs of ten", nearly
    assert (trees.fixed, len(trees.risks)) == (13, 14)
    assert rms["trees"]["partial"] < 10 * MM < 0.4 < rms["trees"]["tested"]
    assert at_presets["single"].fixed == 0
    combined = soft_fixing_lab().run(**(at_presets["single"].settings | {"subset": "combinations"}))
    assert (combined.fixed, len(combined.risks)) == (11, 14)
    assert combined.rms["partial"] < 10 * MM < rms["single"]["partial"]
    assert (at_presets["five"].fixed, len(at_presets["five"].risks)) == (6, 8)
    assert rms["five"]["partial"] == pytest.approx(rms["five"]["float"] / 3, rel=0.1)
    assert rms["left-alone"]["fixed"] > rms["left-alone"]["float"] > rms["left-alone"]["soft"]
    strong = rms["plenty"]
    assert max(strong[way] for way in strong if way != "float") < 1.02 * min(strong.values())


def test_risk_accepted_is_kept(at_presets):
    """Wrong partial fixes are no more than the risk: bootstrapping promises it, least squares does better; 4 sigma of a count."""
    for name, result in at_presets.items():
        risk = result.settings["risk"]
        assert np.mean(~result.is_partial_right) < risk + 4 * math.sqrt(risk / EPOCHS), name


@pytest.mark.parametrize("subset", ["combinations", "single"])
def test_as_many_are_fixed_as_the_risk_allows(lab, subset):
    """The largest number whose risk is accepted; of single ambiguities fewer may be riskier than more."""
    fixed = []
    for risk in RISKS.values():
        result = lab.run(satellites=8, frequencies=2, trees=2, risk=risk, subset=subset)
        assert result.fixed == max((k for k, chance in enumerate(result.risks, 1) if chance <= risk), default=0)
        fixed.append(result.fixed)
    assert fixed == sorted(fixed, reverse=True)
    assert len(set(fixed)) > 2


def test_risk_of_combinations_grows_with_their_number(at_presets):
    assert all((np.diff(result.risks) >= 0).all() for name, result in at_presets.items() if name != "single")


@pytest.mark.parametrize(
    "settings", [{}, {"satellites": 8, "code_noise": 0.3}, {"satellites": 6, "code_noise": 0.1, "trees": 1}, {"satellites": 5, "frequencies": 2}]
)
def test_best_equivariant_has_the_least_mean_square(lab, settings):
    """Theory asks for it in the mean; over 2000 epochs the difference of mean squares may be off by 3 of its sigmas."""
    errors = lab.run(**settings).errors
    for way in ("float", "fixed", "tested", "partial"):
        worse = errors[way] ** 2 - errors["soft"] ** 2
        assert np.mean(worse) > -3 * np.std(worse) / math.sqrt(EPOCHS), way


def test_float_errors_are_those_of_the_covariance(lab):
    """The sum of three variances, 4 sigma of a mean of squares; the heaviest tail has all variance in one direction."""
    settings = lab.settings(trees=1)
    flt = soft_fixing._float_solutions(settings)
    total = np.trace(flt.Q_b)
    assert np.mean(lab.run(**settings).errors["float"] ** 2) == pytest.approx(total, rel=4 * math.sqrt(2 / EPOCHS))


def test_single_ambiguity_by_a_second_route():
    """The mean of integers weighted by their likelihood, written as a loop; rounding by a count of draws."""
    single = single_ambiguity(0.3)
    for x, soft in zip(single.float_values[::30], single.soft[::30], strict=True):
        weights = {z: math.exp(-((x - z) ** 2) / (2 * 0.3**2)) for z in range(-12, 13)}
        assert soft == pytest.approx(sum(z * w for z, w in weights.items()) / sum(weights.values()), abs=1e-5)
    drawn = 0.3 * np.random.default_rng(5).standard_normal(400_000)
    squares = np.rint(drawn) ** 2
    k = int(np.argmin(np.abs(SIGMAS - 0.3)))
    assert single.rms_rounded[k] ** 2 == pytest.approx(squares.mean(), abs=4 * squares.std() / math.sqrt(len(drawn)))


def test_single_ambiguity_between_steps_and_ramp():
    steps, ramp = single_ambiguity(0.05), single_ambiguity(0.8)
    far = np.abs(steps.float_values - np.rint(steps.float_values)) < 0.4
    np.testing.assert_allclose(steps.soft[far], np.rint(steps.float_values[far]), atol=1e-6)
    np.testing.assert_allclose(ramp.soft, ramp.float_values, atol=0.01)
    assert (steps.rms_soft <= steps.rms_rounded + 1e-9).all()
    assert (steps.rms_soft <= SIGMAS + 1e-9).all()


def test_table_has_an_epoch_a_row(lab):
    columns = lab.table(lab.run())
    assert {len(column) for column in columns.values()} == {EPOCHS}
    assert "error_soft_m" in columns


@pytest.mark.parametrize(
    ("goal", "settings", "reached"),
    [
        ("worse-than-nothing", {}, False),
        ("worse-than-nothing", {"satellites": 8, "code_noise": 0.3}, True),
        ("worse-than-nothing", {"satellites": 7, "code_noise": 0.3}, False),  # only 5 % better
        ("in-the-wood", {}, False),
        ("in-the-wood", {"satellites": 8, "frequencies": 2, "code_noise": 0.2, "trees": 3, "risk": 0.001}, False),
        ("in-the-wood", {"satellites": 8, "frequencies": 2, "code_noise": 0.2, "trees": 3, "risk": 0.001, "epochs": 5}, True),
        ("in-the-wood", {"satellites": 9, "frequencies": 2, "code_noise": 0.05, "trees": 3, "risk": 0.001}, False),  # against the rules
    ],
)
def test_goal_is_judged(lab, goal, settings, reached):
    assert lab.goal(goal).judge(lab.run(**settings))[0] == reached
