"""M-estimates: against the minimum of their loss, against least squares, their standard errors counted, and wild values by the third."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

from gnsslab.core.robust import Weight, danish, huber, igg3, tukey
from gnsslab.core.robust_fit import robust_level, robust_trend

SEEDS = st.integers(0, 2**32 - 1)
ROBUST = (huber(1.345), tukey(4.685), danish(2.0), igg3(1.5, 5.0))


def contaminated(rng, T, share=0.1):
    """Return t, irregular and not in order, and y (T,): a line in noise of 0.01, with a share of wild values and some missing."""
    t = rng.permutation(np.cumsum(rng.exponential(1.0, T)))
    y = 3.0 + 0.02 * t + 0.01 * rng.standard_normal(T)
    y[: int(share * T)] += 5.0 * rng.random(int(share * T))
    y[-2:] = np.nan
    return t, y


def huber_loss(v, c):
    return np.sum(np.where(abs(v) <= c, v**2 / 2, c * abs(v) - c * c / 2))


@settings(deadline=None, max_examples=30)
@given(seed=SEEDS, T=st.integers(8, 60), unit=st.sampled_from([1e-3, 1.0, 1e6]))
def test_hubers_fits_have_the_least_loss(seed, T, unit):
    rng = np.random.default_rng(seed)
    t, y = contaminated(rng, T)
    present = np.isfinite(y)
    fit = robust_trend(unit * t, y, huber(1.345))
    for _ in range(20):
        near = huber_loss((y - fit.at(unit * t))[present] / fit.sigma, 1.345)
        tilt = 10.0 ** rng.uniform(-4, 0) * fit.sigma * rng.standard_normal(2)
        other = fit.at(unit * t) + tilt[0] + tilt[1] * (t - t[present].mean()) / t.std()
        assert near <= huber_loss((y - other)[present] / fit.sigma, 1.345) + 1e-9
    level = robust_level(y, huber(1.345))
    best = minimize(lambda x: huber_loss((y[present] - x) / level.sigma, 1.345), np.nanmedian(y), method="Nelder-Mead", options={"xatol": 1e-10})
    assert level.level == pytest.approx(best.x[0], abs=1e-5 * level.sigma)


@settings(deadline=None)
@given(seed=SEEDS, T=st.integers(4, 50))
def test_at_full_weight_it_is_least_squares_with_its_standard_error(seed, T):
    rng = np.random.default_rng(seed)
    t, y = rng.uniform(0, 100, T), rng.standard_normal(T)
    fit, level = robust_trend(t, y, Weight()), robust_level(y, Weight())
    (rate, at_zero), Q = np.polyfit(t, y, 1, cov=True) if T > 4 else (np.polyfit(t, y, 1), None)
    assert fit.rate == pytest.approx(rate, abs=1e-9)
    assert fit.at(0.0) == pytest.approx(at_zero, abs=1e-7)
    if Q is not None:
        assert fit.sigma_rate == pytest.approx(np.sqrt(Q[0, 0]), rel=1e-6)
    assert level.level == pytest.approx(y.mean())
    assert level.sigma_level == pytest.approx(y.std(ddof=1) / np.sqrt(T), rel=1e-9)


@settings(deadline=None, max_examples=30)
@given(seed=SEEDS, weight=st.sampled_from(ROBUST), unit=st.floats(1e-4, 1e4), shift=st.floats(-1e3, 1e3))
def test_units_origin_and_order_do_not_matter(seed, weight, unit, shift):
    rng = np.random.default_rng(seed)
    t, y = contaminated(rng, 40)
    order = rng.permutation(40)
    one, other = robust_trend(t, y, weight), robust_trend(10 * t[order] + shift, unit * y[order] + shift, weight)
    assert other.rate == pytest.approx(unit * one.rate / 10, rel=1e-4)
    assert other.sigma == pytest.approx(unit * one.sigma, rel=1e-4)
    np.testing.assert_allclose(other.weight, one.weight[order], atol=1e-3)


@pytest.mark.parametrize("weight", ROBUST)
def test_standard_errors_are_those_counted_in_clean_and_wild_noise(weight, rng):
    N, T = 120, 40
    t = rng.uniform(0, 10, T)
    for wild in (0.0, 0.1):
        y = rng.standard_normal((N, T)) * np.where(rng.random((N, T)) < wild, 10.0, 1.0)
        trends, levels = [robust_trend(t, row, weight) for row in y], [robust_level(row, weight) for row in y]
        for found, claimed in (
            ([fit.rate for fit in trends], [fit.sigma_rate for fit in trends]),
            ([fit.level for fit in levels], [fit.sigma_level for fit in levels]),
        ):
            assert np.median(claimed) == pytest.approx(np.std(found), rel=0.3)  # 4 sigma of a deviation from 120: 0.26


def test_the_usual_thresholds_cost_five_percent_and_save_the_rest(rng):
    """In normal noise Huber's level has 1 / 0.95 of the mean's variance; one value of ten wild, and the mean is worse by far."""
    clean = rng.standard_normal((500, 50))
    spoilt = clean + 30.0 * (np.arange(50) < 5)
    ratio = np.var([robust_level(row, huber(1.345)).level for row in clean]) / np.var(clean.mean(axis=1))
    assert 1.0 < ratio < 1.12
    for weight in ROBUST[1:]:
        assert abs(np.mean([robust_level(row, weight).level for row in spoilt[:100]])) < 0.05 < np.mean(spoilt)


@pytest.mark.parametrize("weight", ROBUST[1:])
def test_a_third_of_wild_levels_and_a_fifth_of_wild_trends_are_left_out(weight, rng):
    y = rng.standard_normal(300)
    y[rng.permutation(300)[:100]] += 1e3
    assert abs(robust_level(y, weight).level) < 0.5
    t = np.sort(rng.uniform(0, 1e7, 300))  # a season of seconds
    y = rng.standard_normal(300) + 1e-6 * t
    y[rng.permutation(300)[:60]] += 1e3
    fit = robust_trend(t, y, weight)
    assert fit.rate == pytest.approx(1e-6, abs=5 * fit.sigma_rate)
    assert np.count_nonzero(fit.weight == 0) >= 60 or weight == ROBUST[2]


def test_a_line_without_noise_and_a_still_series():
    t = np.array([0.0, 0.1, 0.5, 2.0, 9.0])
    line = robust_trend(t, 0.3 - 0.7 * t, tukey(4.685))
    assert (line.sigma, line.sigma_rate) == (0.0, 0.0)
    assert line.rate == pytest.approx(-0.7)
    assert (line.weight == 1).all()
    still = robust_level([1.2] * 5 + [9.0, np.nan], huber(1.345))
    assert still.level == pytest.approx(1.2)
    assert still.weight.tolist() == [1.0] * 5 + [0.0, 0.0]


def test_they_read_aloud():
    assert repr(robust_level([1.0, 2.0, 3.0, 90.0], igg3(2, 5))).startswith("RobustLevel: 2 +- ")
    assert repr(robust_trend([0.0, 1.0, 2.0], [0.0, 2.0, 4.0], huber(1.345))).startswith("RobustTrend: 2 +- 0 per unit of time")


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: robust_level([1.0, np.nan], huber(1.5)), "a level with its sigma needs at least two values, there are 1"),
        (lambda: robust_level([], huber(1.5)), "there are 0"),
        (lambda: robust_level(np.zeros((5, 3)), huber(1.5)), r"write z\[:, 0\]"),
        (lambda: robust_trend([0.0, 1.0], [0.0, 1.0], huber(1.5)), "needs at least three values, not all at one time; there are 2"),
        (lambda: robust_trend([4.0] * 5, [0.0] * 5, huber(1.5)), "not all at one time"),
        (lambda: robust_trend([0.0, 1.0], [0.0], huber(1.5)), "there are 2 times and 1 values"),
        (lambda: robust_level([0.0, 1.0, 10.0, 11.0], igg3(1e-3, 2e-3)), "their thresholds are too small"),
    ],
)
def test_a_bad_call_is_told_what_was_expected(call, words):
    with pytest.raises(ValueError, match=words):
        call()
