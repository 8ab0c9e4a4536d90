"""Acceptance tests: one ambiguity in closed form, counts on fresh samples, and the published thresholds."""

import json
import math
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from obvious import covariance
from scipy.special import erf, ndtr

from gnsslab.core.integers import (
    adop,
    decorrelate,
    difference_test,
    failure_rate_threshold,
    integer_least_squares,
    projector_test,
    ratio_test,
    simulate_fixes,
    simulate_success,
    threshold_of_fixes,
)
from gnsslab.core.mixed_model import solve_float
from gnsslab.gnss.short_baseline import short_baseline_model

PUBLISHED = json.loads((Path(__file__).parents[2] / "reference" / "ratio_thresholds.json").read_text())
SIGMAS = 4.5  # of a count: seven in a million by chance


def model(n, cycles=0.25, seed=1):
    rng = np.random.default_rng(seed)
    Q = covariance(n, rng, decades=2.0)
    return Q * (cycles / adop(Q)) ** 2


# --- the tests themselves


def test_ratio_is_second_over_best_and_ties_pass():
    assert ratio_test([1.0, 3.0], 3.0)
    assert not ratio_test([1.0, 2.999], 3.0)
    assert ratio_test([0.0, 1.0], 1e9)  # an integer float vector
    assert ratio_test([2.0, 2.0, 5.0], 1.0)


def test_difference_is_the_logarithm_of_how_much_likelier_the_best_is(rng):
    Q, a_hat = model(3), rng.uniform(-5, 5, 3)
    solution = integer_least_squares(a_hat, Q)
    likelihood = [math.exp(-0.5 * (a_hat - a) @ np.linalg.solve(Q, a_hat - a)) for a in solution.candidates]
    c = 2 * math.log(likelihood[0] / likelihood[1])
    assert difference_test(solution.norms, c - 1e-9)
    assert not difference_test(solution.norms, c + 1e-9)


def test_projection_is_what_the_two_distances_say(rng):
    """|a_hat - a_2|^2 = |a_hat - a_1|^2 - 2 p |a_2 - a_1| + |a_2 - a_1|^2, by the law of cosines in Q's metric."""
    Q, a_hat = model(4), rng.uniform(-5, 5, (50, 4))
    solution = integer_least_squares(a_hat, Q)
    between = solution.candidates[:, 1] - solution.best
    squared = np.einsum("ki,ki->k", between, np.linalg.solve(Q, between.T).T)
    p = (squared - (solution.norms[:, 1] - solution.norms[:, 0])) / (2 * np.sqrt(squared))
    assert np.all(p >= 0)
    for c in (0.3, 0.8, 1.5):
        accepted = projector_test(a_hat, Q, solution.candidates, c)
        assert np.array_equal(accepted, p <= c)
        assert 0 < accepted.sum() < 50
    assert projector_test(a_hat, Q, solution.candidates, np.max(np.sqrt(squared)) / 2).all()  # half of the way: everything


def test_a_search_cut_short_is_never_accepted():
    assert not ratio_test([1.0, np.inf], 3.0)
    assert not ratio_test([np.inf, np.inf], 1.0)
    assert not difference_test([1.0, np.inf], 3.0)


def test_stacks_in_stacks_out(rng):
    Q, a_hat = model(3), rng.uniform(-5, 5, (4, 5, 3))
    solution = integer_least_squares(a_hat, Q, n_best=3)
    accepted = [ratio_test(solution.norms, 2.0), difference_test(solution.norms, 2.0), projector_test(a_hat, Q, solution.candidates, 1.0)]
    assert [found.shape for found in accepted] == [(4, 5)] * 3
    alone = solution.norms[2, 3], solution.candidates[2, 3]
    assert [found[2, 3] for found in accepted] == [
        ratio_test(alone[0], 2.0),
        difference_test(alone[0], 2.0),
        projector_test(a_hat[2, 3], Q, alone[1], 1.0),
    ]


# --- one ambiguity: fixed where the fraction is at most delta


def rates_of_one(delta, sigma):
    """Return the probabilities of right and wrong fixes of one ambiguity, fixed where its fraction is at most delta."""
    chance = {k: ndtr((k + delta) / sigma) - ndtr((k - delta) / sigma) for k in range(-60, 61)}
    right = chance.pop(0)
    return right, sum(chance.values())


@pytest.mark.parametrize("sigma", [0.2, 0.35])
def test_all_three_are_one_test_for_one_ambiguity(sigma, rng):
    a_hat, delta = rng.uniform(-5, 5, (400, 1)), 0.31
    solution = integer_least_squares(a_hat, [[sigma**2]])
    inside = np.abs(a_hat - np.rint(a_hat))[:, 0] <= delta
    assert np.array_equal(ratio_test(solution.norms, ((1 - delta) / delta) ** 2), inside)
    assert np.array_equal(difference_test(solution.norms, (1 - 2 * delta) / sigma**2), inside)
    assert np.array_equal(projector_test(a_hat, [[sigma**2]], solution.candidates, delta / sigma), inside)


@pytest.mark.parametrize(("sigma", "failure_rate"), [(0.2, 0.003), (0.3, 0.001), (0.3, 0.05)])
def test_threshold_of_one_ambiguity_in_closed_form(sigma, failure_rate, rng):
    low, high = 0.0, 0.5
    for _ in range(60):
        delta = (low + high) / 2
        low, high = (low, delta) if rates_of_one(delta, sigma)[1] > failure_rate else (delta, high)
    right, wrong = rates_of_one(delta, sigma)
    found = failure_rate_threshold([[sigma**2]], failure_rate, rng, samples=200_000)
    allowed = failure_rate * found.samples
    wider = [((1 - d) / d) ** 2 for d in (_delta(failure_rate * (1 + s * SIGMAS / math.sqrt(allowed)), sigma) for s in (1, -1))]
    assert wider[0] <= found.ratio <= wider[1]
    assert found.interval[0] < found.ratio < found.interval[1]
    assert abs(found.success_rate - erf(1 / math.sqrt(8) / sigma)) < SIGMAS * math.sqrt(0.25 / found.samples)
    assert abs(found.fix_rate - right - wrong) < 0.1 * (right + wrong)


def _delta(failure_rate, sigma):
    deltas = np.linspace(0, 0.5, 5001)
    return np.interp(failure_rate, [rates_of_one(delta, sigma)[1] for delta in deltas], deltas)


# --- thresholds by simulation


@settings(max_examples=100, deadline=None)
@given(st.lists(st.tuples(st.floats(1.0, 50.0), st.booleans()), min_size=1, max_size=40), st.floats(0.02, 0.98))
def test_the_threshold_is_the_smallest_that_keeps_the_rate(fixes, failure_rate):
    ratio, is_right = np.array([x for x, _ in fixes]), np.array([right for _, right in fixes])
    if failure_rate * len(fixes) < 1:
        with pytest.raises(ValueError, match="less than one failure"):
            threshold_of_fixes(ratio, is_right, failure_rate)
        return
    found = threshold_of_fixes(ratio, is_right, failure_rate)
    assert np.sum(~is_right & (ratio >= found.ratio)) <= failure_rate * len(fixes) * (1 + 1e-12)
    below = np.nextafter(found.ratio, 0.0)
    assert found.ratio == 1.0 or np.sum(~is_right & (ratio >= below)) > failure_rate * len(fixes)
    assert found.failure_rate == np.mean(~is_right & (ratio >= found.ratio))
    assert found.fix_rate == np.mean(ratio >= found.ratio)
    assert 1.0 <= found.interval[0] <= found.ratio <= found.interval[1]
    assert np.isclose(found.mu * found.ratio, 1.0)


@pytest.mark.parametrize(("n", "failure_rate"), [(2, 0.01), (5, 0.001), (8, 0.01)])
def test_the_rate_is_kept_on_fresh_samples(n, failure_rate, rng):
    Q, samples = model(n, cycles=0.22), 100_000
    found = failure_rate_threshold(Q, failure_rate, rng, samples)
    fresh = simulate_fixes(Q, rng, samples)
    accepted = ratio_test(fresh.norms, found.ratio)
    failures = np.sum(accepted & ~fresh.is_right)
    assert found.success_rate < 1 - 2 * failure_rate  # else there is no need for a test
    assert abs(failures - failure_rate * samples) < SIGMAS * math.sqrt(2 * failure_rate * samples)  # both counts err
    assert abs(accepted.mean() - found.fix_rate) < 0.05
    assert failures > 0
    assert math.isclose(found.sigma, math.sqrt(failure_rate * (1 - failure_rate) / samples), rel_tol=0.1)


def test_the_interval_holds_the_next_simulation(rng):
    Q = model(4, cycles=0.25)
    best = failure_rate_threshold(Q, 0.01, rng, 400_000).ratio
    found = [failure_rate_threshold(Q, 0.01, rng, 20_000) for _ in range(60)]
    inside = sum(one.interval[0] <= best <= one.interval[1] for one in found)
    assert inside >= 50  # 57 expected; fewer than 50 happens once in ten thousand


def test_accept_outright_where_least_squares_is_good_enough(rng):
    found = failure_rate_threshold(model(5, cycles=0.1), 0.001, rng, 20_000)
    assert found.ratio == found.mu == found.fix_rate == 1.0
    assert math.isclose(found.failure_rate, 1 - found.success_rate)
    assert found.failure_rate <= 0.001
    assert found.interval[0] == 1.0


def test_read_aloud(rng):
    assert "fixed 100.0%, failed 0.00% +-" in repr(failure_rate_threshold([[0.0004]], 0.01, rng, 1000))


# --- published thresholds: a table over the failure rate of least squares and n, made for many models at once


def directions(m):
    """Unit vectors (m, 3) to satellites between 12 and 80 degrees of elevation, turning by the golden angle."""
    elevation, azimuth = np.radians(12 + 68 * (np.arange(m) * 0.618 % 1.0)), 2.39996 * np.arange(m)
    return np.stack([np.cos(elevation) * np.sin(azimuth), np.cos(elevation) * np.cos(azimuth), np.sin(elevation)], axis=1)


def covariance_of_model(n):
    """One epoch of a short baseline, L1 alone, or both L1 and L2 where that gives n = 20; two ambiguities: one range, L1 and L2."""
    if n == 2:
        A, B, Q_y = np.vstack([np.zeros((2, 2)), np.diag([0.1903, 0.2442])]), np.ones((4, 1)), np.diag([0.09, 0.09, 9e-6, 9e-6])
    else:
        waves = [0.1903, 0.2442] if n == 20 else [0.1903]
        m = n // len(waves) + 1
        A, B, Q_y = short_baseline_model(directions(m), waves, np.full(m, 0.3), np.full(m, 0.003))
    return solve_float(np.zeros(len(A)), A, B, Q_y).Q_a


@cache
def simulated(n, failure_rate_of_least_squares):
    """Fixes of the model of n, all sigmas scaled so that least squares fails at this rate."""
    Q = covariance_of_model(n)
    d = decorrelate(Q).d
    scales = np.geomspace(1e-3, 1e3, 20_001)
    bootstrapped = 1 - np.prod(erf(1 / np.sqrt(8 * scales[:, None] * d)), axis=1)
    low = scales[np.searchsorted(bootstrapped, failure_rate_of_least_squares) - 1]  # least squares fails more rarely
    high, samples = 2.0 * low, int(min(40_000, 1000 / failure_rate_of_least_squares))
    for _ in range(7):
        middle = math.sqrt(low * high)
        fails = 1 - simulate_success(middle * Q, np.random.default_rng(5), samples).rate
        low, high = (low, middle) if fails > failure_rate_of_least_squares else (middle, high)
    return simulate_fixes(math.sqrt(low * high) * Q, np.random.default_rng(6), 50_000)


def compared(failure_rate, rate_of_least_squares, n, mu):
    """Return our threshold, and the failures with the published one and their number allowed."""
    fixes = simulated(n, rate_of_least_squares)
    assert abs(np.mean(~fixes.is_right) / rate_of_least_squares - 1) < 0.25
    failures = np.sum(~fixes.is_right & (fixes.norms[:, 0] <= mu * fixes.norms[:, 1]))
    return threshold_of_fixes(fixes.ratio, fixes.is_right, failure_rate), failures, failure_rate * len(fixes.ratio)


def test_published_thresholds_keep_the_rate_for_five_ambiguities_and_more():
    """They are conservative over most models, not over all: with other noise or sky some fail a third more often than tolerated.

    Ours, for the model at hand, is the same or bolder, and fixes more.
    """
    rows = [row for row in PUBLISHED["rows"] if row[2] >= 5]
    assert len(rows) == 48
    shares = []
    for row in rows:
        found, failures, allowed = compared(*row)
        assert failures < allowed + SIGMAS * math.sqrt(allowed), row
        assert 1 / found.interval[0] >= row[3], row
        if row[3] > 0:
            assert found.mu < 1.75 * row[3], row
            shares.append(failures / allowed)
        else:
            assert found.fix_rate < 0.15, row  # the table gives up where little could be fixed
    assert 0.4 < np.mean(shares) < 0.9  # of the tolerated failures


def test_published_thresholds_of_two_ambiguities_are_too_bold_where_least_squares_is_poor():
    """At 10 % and more. Other models of two do no better, the densest grid (hexagonal) included."""
    rows = [row for row in PUBLISHED["rows"] if row[2] == 2 and row[3] > 0]
    assert len(rows) == 11
    for row in rows:
        found, failures, allowed = compared(*row)
        if row[1] <= 0.02:
            assert failures < 1.1 * allowed + SIGMAS * math.sqrt(allowed), row
            assert 1 / found.interval[0] > 0.9 * row[3], row
        if row[1] >= 0.1:
            assert failures > allowed + SIGMAS * math.sqrt(allowed), row
            assert 1 / found.interval[0] < row[3], row


def test_two_equal_candidates_are_not_accepted():
    """A search cut short before the first candidate leaves them equal: nothing is known of the second best."""
    assert not projector_test([0.1, 0.2], np.eye(2), [[0, 0], [0, 0]], 10.0)


BAD_CALLS = [
    (lambda: ratio_test([1.0, 2.0], 0.4), "second / best, so its threshold must be 1 or more, not 0.4"),
    (lambda: ratio_test([1.0], 3.0), r"second best in its last axis \(n_best=2 or more\); it has shape \(1,\)"),
    (lambda: ratio_test(1.0, 3.0), r"it has shape \(\)"),
    (lambda: difference_test([1.0, 2.0], -1.0), "must be 0 or more; it is -1"),
    (lambda: projector_test([0.1], [[1.0]], [[0], [1]], np.nan), "must be 0 or more; it is nan"),
    (lambda: projector_test([0.1], [[1.0]], [[0]], 1.0), r"candidates must be \(..., 2 or more, 1\).*they have shape \(1, 1\)"),
    (lambda: projector_test([0.1], [1.0], [[0], [1]], 1.0), "Q must be a covariance matrix"),
    (lambda: projector_test([0.1, 0.2], np.ones((2, 2)), [[0, 0], [1, 0]], 1.0), "Q is not positive definite"),
    (lambda: projector_test([0.1, 0.2], [[1.0, 0.5], [0.4, 1.0]], [[0, 0], [1, 0]], 1.0), "Q is not symmetric"),
    (lambda: threshold_of_fixes([1.5, 2.0, 3.0], [True, False], 0.5), r"shapes \(3,\) and \(2,\)"),
    (lambda: threshold_of_fixes([0.5, 2.0], [True, False], 0.5), "second / best, 1 or more"),
    (lambda: threshold_of_fixes([np.nan, 2.0], [True, False], 0.5), "second / best, 1 or more"),
    (lambda: failure_rate_threshold([[1.0]], 1.0, np.random.default_rng(1)), "more than 0 and less than 1; it is 1"),
    (lambda: failure_rate_threshold([[1.0]], 0.001, np.random.default_rng(1), 500), "500 samples hold less than one failure.*use 10000 or more"),
    (lambda: failure_rate_threshold([[-1.0]], 0.001, np.random.default_rng(1), 5000), "not positive definite"),
]


@pytest.mark.parametrize(("call", "message"), BAD_CALLS)
def test_bad_calls_are_explained(call, message):
    with pytest.raises(ValueError, match=message):
        call()


def test_searches_cut_short_are_never_accepted():
    """An infinite ratio says that no second best was found, not that there is none."""
    found = threshold_of_fixes([np.inf, np.inf, 1.2, 5.0, 6.0], [False, True, False, True, True], 0.2)
    assert found.ratio == 1.0
    assert found.fix_rate == 0.6
    assert found.failure_rate == 0.2
