"""Lab of trust in a fix: corners, presets, promises against counts, tests against plain loops, and what multipath does to all of them."""

import itertools

import numpy as np
import pytest

from gnsslab.core.integers.acceptance import projector_test
from gnsslab.core.integers.decorrelation import decorrelate
from gnsslab.core.integers.search import integer_least_squares
from gnsslab.gnss.differences import difference_operator
from gnsslab.gnss.short_baseline import short_baseline_model
from gnsslab.gnss.signals import wavelength
from gnsslab.labs.skies import open_sky
from gnsslab.labs.trust import BIASED, FIVE, PRESETS, claims, projections
from gnsslab.simulate.receivers import white_factor

LAB = "trust"
FEW = {"samples": 1000}


@pytest.fixture(scope="module")
def at_presets(lab):
    """Results of all presets, by name."""
    return {p.name: lab.run(**p.settings) for p in lab.presets}


def test_best_and_worst_model_compute(lab):
    best = {"satellites": 9, "frequencies": 3, "code_noise": 0.1, "carrier_noise": 1, "epochs": 20}
    worst = {"satellites": 9, "frequencies": 3, "code_noise": 1, "carrier_noise": 10, "code_bias": 5, "carrier_bias": 40}
    hopeless = {"satellites": 5, "frequencies": 1, "code_noise": 1, "carrier_noise": 10, "code_bias": 5, "carrier_bias": 40}
    for settings in (best, worst, hopeless):
        result = lab.run(**FEW, **settings)
        assert np.isfinite([float(readout.value) for readout in lab.readouts(result)]).all()
        assert np.isfinite(result.statistic).all()
        assert np.allclose([sum(judged.shares) for judged in result.judged], 1)
        assert "nan" not in lab.describe(result)
    assert lab.run(**FEW, **best).counted.rate == 1
    assert lab.run(**FEW, **hopeless).counted.rate < 0.05


# --- the model and the count


@pytest.mark.parametrize(("satellites", "frequencies"), [(5, 1), (7, 2), (9, 3)])
def test_multipath_moves_the_float_ambiguities_as_least_squares_says(lab, satellites, frequencies):
    """The same system whitened row by row and solved by lstsq: 1 m in the codes, 1 mm in the carriers of the satellite in the middle."""
    result = lab.run(**FEW, satellites=satellites, frequencies=frequencies)
    sky = open_sky().first(satellites)
    growth = white_factor(sky.elevation)
    A, B, Q_y = short_baseline_model(sky.u, [wavelength("G", band) for band in "125"[:frequencies]], 0.2 * growth, 0.003 * growth)
    one = difference_operator(satellites, 0)[:, satellites // 2]
    assert sorted(one.tolist()) == [0.0] * (satellites - 2) + [1.0]
    zero = np.zeros(frequencies * (satellites - 1))
    y = np.array([[*np.tile(one, frequencies), *zero], [*zero, *np.tile(one, frequencies) / 1000]])
    W = np.linalg.inv(np.linalg.cholesky(Q_y))
    x = np.linalg.lstsq(W @ np.hstack([A, B]), W @ y.T)[0].T
    np.testing.assert_allclose(result.model.gains, x[:, : len(zero)], rtol=1e-6, atol=1e-9)


def test_count_is_that_of_a_search_through_a_box(lab):
    """Four ambiguities: all integer vectors within 3 of the rounded decorrelated ones, the nearest taken; 4 sigma of both counts."""
    settings = {"satellites": 5, "code_noise": 0.1, "epochs": 3}
    result = lab.run(**settings)
    Q, N, rng = result.model.Q, 2000, np.random.default_rng(99)
    a_hat = rng.multivariate_normal(np.zeros(4), Q, size=N)
    Z, Q_inverse = decorrelate(Q).Z, np.linalg.inv(Q)
    box = np.array(list(itertools.product(range(-3, 4), repeat=4)))
    right = 0
    for a in a_hat:
        candidates = np.linalg.solve(Z.T.astype(float), (np.rint(Z.T @ a) + box).T).T
        distances = np.einsum("ki,ij,kj->k", a - candidates, Q_inverse, a - candidates)
        right += np.abs(candidates[np.argmin(distances)]).max() < 0.5
    p = right / N
    assert 0.2 < p < 0.95
    assert abs(result.counted.rate - p) < 4 * np.sqrt(p * (1 - p) * (1 / N + 1 / result.counted.samples))


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("settings", [{}, {"satellites": 7}, FIVE, {"satellites": 8, "code_noise": 0.5, "carrier_noise": 6, "frequencies": 2}])
def test_count_lies_where_the_claims_put_it(lab, settings, seed):
    """Bootstrapping and all lower bounds below the count, upper bounds above it: 4 sigma."""
    result = lab.run(seed=seed, **settings)
    margin = 4 * result.counted.sigma
    bootstrapping, _, *bounds = result.model.claims
    for claim in (bootstrapping, *bounds):
        assert claim.low - margin < result.counted.rate
    for claim in bounds:
        assert result.counted.rate < claim.high + margin
    assert result.counted == result.unbiased


def test_more_noise_fewer_right_fixes(lab):
    rates = [lab.run(code_noise=noise).counted.rate for noise in (0.1, 0.2, 0.4, 0.8)]
    promised = [lab.run(code_noise=noise).model.promised for noise in (0.1, 0.2, 0.4, 0.8)]
    assert rates == sorted(rates, reverse=True)
    assert promised == sorted(promised, reverse=True)


def test_claims_of_uncorrelated_ambiguities_are_the_textbook_ones():
    """Sigmas of half a cycle: 0.6827 each, by bootstrapping, variances and eigenvalues alike."""
    known = {claim.name: claim for claim in claims(0.25 * np.eye(3))}
    expected = 0.6826894921370859**3
    for name in ("bootstrapping", "ADOP", "eigenvalues"):
        assert known[name].low == pytest.approx(expected)
        assert known[name].high == pytest.approx(expected)


# --- multipath


def test_multipath_moves_the_count_and_no_promise(lab):
    results = [lab.run(**BIASED | {"code_bias": bias}) for bias in (0, 1, 2, 2.5, 3, 4)]
    counts = [result.counted.rate for result in results]
    assert counts == sorted(counts, reverse=True)
    assert len({result.model.claims for result in results}) == 1
    assert len({result.model.adop for result in results}) == 1
    assert len({result.tolerated.ratio for result in results}) == 1
    assert len({result.unbiased for result in results}) == 1


@pytest.mark.parametrize("seed", [1, 2, 3, 4])
def test_biased_case_of_paper_e(lab, seed):
    """ADOP and bootstrapping promise 0.99 and more, and about 40 % are wrong: paper E's bursts are 1.5 to 4.5 m on single satellites."""
    result = lab.run(**BIASED, seed=seed)
    assert 1.5 <= BIASED["code_bias"] <= 4.5
    assert result.model.promised > 0.99
    assert result.model.claims[1].low > 0.99
    assert result.unbiased.rate > 0.99
    assert 0.35 < 1 - result.counted.rate < 0.5


def test_carrier_multipath_counts_too(lab):
    assert lab.run(**FEW, carrier_bias=40).counted.rate < lab.run(**FEW, carrier_bias=20).counted.rate < lab.run(**FEW).counted.rate - 0.05


def test_averaging_helps_against_noise_and_not_against_multipath(lab):
    assert lab.run(**FEW, epochs=10).counted.rate > lab.run(**FEW).counted.rate
    too_much = next(preset.settings for preset in PRESETS if preset.name == "all-wrong")
    assert lab.run(**FEW | too_much | {"epochs": 20}).counted.rate == lab.run(**FEW | too_much).counted.rate == 0


# --- tests of acceptance


@pytest.mark.parametrize("test", ["ratio", "tolerated", "difference", "projector"])
@pytest.mark.parametrize("biased", [False, True])
def test_shares_are_those_of_a_plain_loop(lab, test, biased):
    """Epoch by epoch, the four outcomes counted one by one."""
    settings = FEW | {"satellites": 7, "test": test, "threshold": 2.5} | ({"code_bias": 2} if biased else {})
    result = lab.run(**settings)
    counts = [0, 0, 0, 0]
    for is_right, value in zip(result.is_right, result.statistic, strict=True):
        is_fixed = value <= 2.5 if test == "projector" else value >= (result.tolerated.ratio if test == "tolerated" else 2.5)
        counts[(0 if is_right else 1) if is_fixed else (3 if is_right else 2)] += 1
    np.testing.assert_allclose(result.chosen.shares, np.array(counts) / 1000, atol=1e-12)
    assert sum(counts) == 1000


@pytest.mark.parametrize(("test", "sign"), [("ratio", -1), ("difference", -1), ("projector", 1)])
def test_shares_go_one_way_with_the_threshold(lab, test, sign):
    shares = [lab.run(test=test, threshold=c).chosen.shares for c in (1, 1.5, 2, 3, 5, 10, 20)]
    for name in ("fixed_right", "fixed_wrong"):
        assert (sign * np.diff([getattr(one, name) for one in shares]) >= 0).all()
    assert shares[0].fixed != shares[-1].fixed


def test_a_ratio_of_one_fixes_everything(lab):
    shares = lab.run(threshold=1).chosen.shares
    assert shares.fixed == 1
    assert shares == next(judged.shares for judged in lab.run().judged if judged.name == "none")


def test_projections_are_what_the_projector_test_compares(rng):
    Q = np.array([[0.09, 0.05, 0.01], [0.05, 0.08, 0.02], [0.01, 0.02, 0.06]])
    a_hat = rng.multivariate_normal(np.zeros(3), Q, size=300)
    found = integer_least_squares(a_hat, Q)
    along = projections(a_hat, Q, found.candidates)
    assert (along >= 0).all()  # else the second best, mirrored at the best, were nearer than itself
    for c in (0.5, 1.0, 1.5):
        np.testing.assert_array_equal(along <= c, projector_test(a_hat, Q, found.candidates, c))
    s_1, s_2 = found.norms.T
    step = found.candidates[:, 1] - found.candidates[:, 0]
    apart = np.sqrt(np.einsum("ki,ij,kj->k", step, np.linalg.inv(Q), step))
    np.testing.assert_allclose(along, (s_1 - s_2 + apart**2) / (2 * apart), rtol=1e-9, atol=1e-9)  # the cosine law


@pytest.mark.parametrize("settings", [{}, FIVE, {"satellites": 8}, {"satellites": 7, "code_noise": 0.1}])
@pytest.mark.parametrize("tolerance", [0.5, 1, 3])
def test_tolerated_failures_are_about_those_counted(lab, settings, tolerance):
    """The threshold comes from one draw, the count from another: twice the variance of a count, 4 sigma. Fewer where all may pass."""
    result = lab.run(**settings, test="tolerated", tolerance=tolerance)
    p, N = tolerance / 100, result.counted.samples
    margin = 4 * np.sqrt(2 * p / N)
    assert result.chosen.shares.fixed_wrong < p + margin
    if result.tolerated.ratio > 1:
        assert result.chosen.shares.fixed_wrong > p - margin


def test_more_tolerance_a_lower_threshold(lab):
    thresholds = [lab.run(satellites=8, tolerance=tolerance).tolerated.ratio for tolerance in (0.1, 0.5, 1, 2, 5)]
    assert thresholds == sorted(thresholds, reverse=True)
    assert thresholds[0] > 3 > thresholds[-1]


def test_upside_down_keeps_just_what_should_go(lab):
    right, wrong = lab.run(), lab.run(written="upside-down")
    np.testing.assert_array_equal(right.is_accepted, ~wrong.is_accepted)  # no ratio is exactly 3
    assert wrong.statistic[wrong.is_accepted].max() <= 3
    assert wrong.chosen.shares.fixed_wrong > 10 * right.chosen.shares.fixed_wrong


def test_one_limit_given_to_the_other_program_lets_all_pass(lab):
    for threshold in (1, 3, 20):
        assert lab.run(written="mixed", threshold=threshold).is_accepted.all()


@pytest.mark.parametrize("written", ["right", "upside-down", "mixed"])
@pytest.mark.parametrize("test", ["ratio", "tolerated", "difference", "projector"])
def test_shaded_range_is_what_is_accepted(lab, test, written):
    result = lab.run(**FEW, test=test, written=written, threshold=2)
    low, high = result.accepted_range
    np.testing.assert_array_equal(result.is_accepted, (result.statistic >= low) & (result.statistic <= high))


# --- what presets, goals and controls promise


def test_presets_show_what_they_promise(at_presets):
    fixed = {name: result.chosen.shares.fixed for name, result in at_presets.items()}
    wrong = {name: result.chosen.shares.fixed_wrong for name, result in at_presets.items()}
    right = {name: result.counted.rate for name, result in at_presets.items()}
    constant = {name: next(j.shares for j in result.judged if j.name == "constant") for name, result in at_presets.items()}
    start = at_presets["start"]
    assert start.model.promised + 4 * start.counted.sigma < right["start"]
    assert wrong["start"] < 0.002
    assert start.chosen.shares.rejected_right > 0.5 * right["start"]
    assert all(claim.high > 0.999 for claim in at_presets["strong"].model.claims)
    assert at_presets["strong"].model.promised > 0.9995
    assert all(judged.shares.fixed > 0.99 and judged.shares.fixed_wrong == 0 for judged in at_presets["strong"].judged)
    assert 0.2 < right["weak"] < 0.3
    assert fixed["weak"] < 0.05
    assert 0.4 < wrong["weak"] / fixed["weak"] < 0.6
    assert len(at_presets["twenty"].model.Q) == 21
    assert right["twenty"] > 0.96
    assert fixed["twenty"] < 0.06
    assert min(judged.shares.fixed for judged in at_presets["twenty"].judged[3:]) > 0.4
    assert abs(wrong["tolerated"] - 0.005) < 0.003
    assert fixed["tolerated"] - constant["tolerated"].fixed > 0.3
    assert 0.4 < 1 - right["biased"] < 0.48
    assert fixed["biased-tolerated"] == 1
    assert wrong["biased-tolerated"] == pytest.approx(1 - right["biased"])
    assert right["all-wrong"] == 0
    assert 0.08 < fixed["all-wrong"] == wrong["all-wrong"] < 0.12
    assert at_presets["all-wrong"].statistic.max() > 10
    assert fixed["difference"] > constant["difference"].fixed + 0.03
    assert np.exp(at_presets["difference"].chosen.threshold / 2) == pytest.approx(400, rel=0.02)
    assert fixed["projector"] > 0.5
    assert wrong["upside-down"] > 0.05
    assert fixed["mixed"] == 1


@pytest.mark.parametrize(
    ("goal", "settings", "reached"),
    [
        ("careful", {}, False),  # against the rules
        ("careful", FIVE, False),
        ("careful", FIVE | {"threshold": 2}, True),
        ("careful", FIVE | {"threshold": 1.2}, False),
        ("careful", FIVE | {"threshold": 2, "frequencies": 3}, False),
        ("careful", FIVE | {"threshold": 2, "epochs": 5}, False),
        ("biased", BIASED, False),
        ("biased", BIASED | {"test": "tolerated"}, False),
        ("biased", BIASED | {"code_noise": 0.6, "threshold": 1.8}, True),
        ("biased", BIASED | {"code_noise": 0.6, "threshold": 1.8, "code_bias": 0}, False),
    ],
)
def test_goals_are_judged(lab, goal, settings, reached):
    judged, words = lab.goal(goal).judge(lab.run(**settings))
    assert judged == reached
    assert words.startswith("Now: ")


def test_controls_without_effect_say_why(lab):
    assert lab.blocked(lab.settings()) == {}
    assert set(lab.blocked(lab.settings(test="tolerated"))) == {"threshold"}
    for test in ("difference", "projector"):
        assert set(lab.blocked(lab.settings(test=test))) == {"written"}
    assert all(reason.startswith("no effect: ") for test in ("tolerated", "difference") for reason in lab.blocked(lab.settings(test=test)).values())


def test_moving_back_brings_the_same_numbers(lab):
    before = lab.readouts(lab.run(**FEW))
    lab.run(**FEW, threshold=5)
    lab.run(**FEW, code_bias=3, seed=4)
    assert lab.readouts(lab.run(**FEW)) == before


def test_table_has_a_row_for_each_epoch(lab):
    result = lab.run(**FEW, test="projector", threshold=2)
    table = lab.table(result)
    assert {len(column) for column in table.values()} == {1000}
    assert np.mean(table["is_fixed"] & ~table["is_right"]) == pytest.approx(result.chosen.shares.fixed_wrong)
