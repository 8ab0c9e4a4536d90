"""Simulated success: the same samples judged another way, closed forms, published numbers, and who does the work does not matter."""

import json
import os
import subprocess
import sys
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from obvious import all_within, covariance
from scipy.optimize import brentq
from scipy.stats import binom

from gnsslab.core.integers import decorrelate, integer_least_squares, simulate_fixes, simulate_success, success_bounds, success_rate
from gnsslab.core.integers.simulation import SimulatedRate, count_nearest_to_zero, wilson_interval
from gnsslab.core.jit import kernel_input

SIGMAS = 4.5  # of a binomial count: seven in a million by chance
PUBLISHED = json.loads((Path(__file__).parents[2] / "reference" / "success.json").read_text())
LIMIT = 1_000_000


def agrees(simulated, probability):
    """Whether a count of a known probability is not further off than chance brings it."""
    low, high = wilson_interval(simulated.successes, simulated.samples, SIGMAS)
    return low <= probability <= high


def drawn(n, seed, power, N, bias=0.0):
    """Samples x (N, n) and what they stand for: Q, L', sigma of the decorrelated ambiguities, and the float vectors."""
    rng = np.random.default_rng(seed)
    Q = 10.0**power * covariance(n, rng, decades=2.0)
    Z, L, d = decorrelate(Q)
    x = rng.standard_normal((N, n)) + bias
    a_hat = np.linalg.solve(Z.T, L.T @ (np.sqrt(d)[:, None] * x.T)).T
    return Q, (kernel_input(x), kernel_input(L.T), kernel_input(np.sqrt(d))), a_hat


@settings(max_examples=60, deadline=None)
@given(st.integers(1, 9), st.integers(0, 2**32 - 1), st.floats(-2.5, 0.5), st.floats(-1.0, 1.0))
def test_each_sample_is_judged_as_by_integer_least_squares(n, seed, power, bias):
    Q, (x, U, sigma), a_hat = drawn(n, seed, power, 40, bias)
    is_right = np.all(integer_least_squares(a_hat, Q, n_best=1).best == 0, axis=-1)
    judged = [count_nearest_to_zero([x_k] if isinstance(x, list) else x_k[None], U, sigma, LIMIT) for x_k in x]
    assert judged == [(int(right), 0) for right in is_right]


def test_each_sample_is_judged_as_by_the_obvious_recursion():
    """All integer vectors not farther than zero, found without decorrelation: zero alone, or others too."""
    both = set()
    for seed in range(6):
        Q, (x, U, sigma), a_hat = drawn(3, seed, -0.5, 20)
        for k in range(20):
            within = all_within(a_hat[k], Q, a_hat[k] @ np.linalg.solve(Q, a_hat[k]) * (1 + 1e-9))
            right, undecided = count_nearest_to_zero(kernel_input(np.asarray(x)[[k]]), U, sigma, LIMIT)
            assert (right, undecided) == (len(within) == 1, 0)
            both.add(right)
    assert both == {0, 1}


@pytest.mark.parametrize("sigma", [0.1, 0.25, 0.5, 2.0])
def test_one_ambiguity_and_many_without_correlation_have_closed_forms(sigma, rng):
    for n in (1, 4):
        exact = success_rate(sigma**2 * np.eye(n))
        assert agrees(simulate_success(sigma**2 * np.eye(n), rng, 20_000), exact)


def test_published_success_lies_between_the_published_bounds(rng):
    """97.10 % by two million samples elsewhere; bootstrapping 97.08, the walls 97.13: simulated here within both and its error."""
    simulated, bounds = simulate_success(PUBLISHED["bounds"]["Q"], rng, 400_000), PUBLISHED["bounds"]["decorrelated"]
    low, high = wilson_interval(simulated.successes, simulated.samples, SIGMAS)
    assert low < bounds["pull_in_upper"] / 100
    assert high > bounds["bootstrapped"] / 100
    assert agrees(simulated, PUBLISHED["bounds"]["simulated"]["least_squares"] / 100)


def test_published_single_epoch_model(reference, rng):
    """Bootstrapping 30.7 % there; least squares 31.0 % by 20000 samples elsewhere, good to 0.3 %."""
    Q = reference["success_rate"][1]["Q"]
    simulated = simulate_success(Q, rng, 20_000)
    assert abs(simulated.rate - 0.310) < SIGMAS * np.hypot(simulated.sigma, 0.0033)
    assert success_bounds(decorrelate(Q).Q_z).bootstrapped <= simulated.interval[1]


def test_a_bias_is_that_of_the_float_ambiguities(rng):
    """One ambiguity with bias b: right where -1/2 - b < e < 1/2 - b. Many with a bias of one cycle: never right, and the same for all variables."""
    from scipy.stats import norm

    exact = norm.cdf(0.5, loc=0.3, scale=0.25) - norm.cdf(-0.5, loc=0.3, scale=0.25)
    assert agrees(simulate_success([[0.0625]], rng, 20_000, bias=[0.3]), exact)
    Q = 0.01 * covariance(5, rng)
    assert simulate_success(Q, rng, 1000).rate > 0.9
    assert simulate_success(Q, rng, 1000, bias=[0, 0, 1, 0, 0]).rate < 0.1
    bias = 0.2 * rng.standard_normal(5)
    fixes = simulate_fixes(Q, rng, 20_000, bias=bias)
    assert agrees(simulate_success(Q, rng, 20_000, bias=bias), np.mean(fixes.is_right)) or np.mean(fixes.is_right) in (0, 1)


class AtOnce(Executor):
    """An executor that does the work where it is handed over; counts what it was given."""

    def __init__(self):
        self.futures = []

    def submit(self, function, /, *arguments):
        self.futures.append(Future())
        self.futures[-1].set_result(function(*arguments))
        return self.futures[-1]


class Never(AtOnce):
    """An executor that does the first job only."""

    def submit(self, function, /, *arguments):
        if not self.futures:
            return super().submit(function, *arguments)
        self.futures.append(Future())
        return self.futures[-1]


def counted(Q, executor=None):
    return simulate_success(Q, np.random.default_rng(5), 23_456, executor=executor)


def test_count_does_not_depend_on_who_does_the_work(rng):
    Q = 0.5 * covariance(4, rng, decades=1.0)
    alone, at_once = counted(Q), AtOnce()
    assert 0.05 < alone.rate < 0.95
    assert alone.samples == 23_456
    assert counted(Q, at_once) == alone
    assert len(at_once.futures) > 3, "one job alone cannot be shared"
    for workers in (1, 3):
        with ThreadPoolExecutor(workers) as pool:
            assert counted(Q, pool) == alone
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        assert counted(Q, pool) == alone


def test_one_generator_gives_other_samples_each_time(rng):
    Q = [[1.0]]
    counts = {simulate_success(Q, rng, 5000).successes for _ in range(5)}
    assert len(counts) > 1


@pytest.mark.parametrize("samples", [1, 4999, 5000, 5001, 12_345, 500_000, 512_345])
@pytest.mark.parametrize("executor", [None, AtOnce()])
def test_progress_counts_all_samples_once(samples, executor, rng):
    calls = []
    simulated = simulate_success([[0.01]], rng, samples, executor=executor, progress=lambda done, total: calls.append((done, total)))
    done = [call[0] for call in calls]
    assert {call[1] for call in calls} == {samples} == {simulated.samples}
    assert done[-1] == samples
    assert np.all(np.diff([0, *done]) > 0)
    assert len(calls) <= 101


def test_what_progress_raises_ends_the_simulation(rng):
    class Enough(Exception):
        pass

    def stop(done, total):
        raise Enough

    executor = Never()
    with pytest.raises(Enough):
        simulate_success([[0.01]], rng, 50_000, executor=executor, progress=stop)
    assert len(executor.futures) == 10
    assert all(future.cancelled() for future in executor.futures[1:])


def test_a_mistake_of_a_worker_is_told(rng):
    class Broken(AtOnce):
        def submit(self, function, /, *arguments):
            future = Future()
            future.set_exception(OSError("the worker is gone"))
            return future

    with pytest.raises(OSError, match="the worker is gone"):
        simulate_success([[0.01]], rng, 10, executor=Broken())


def test_samples_that_were_not_decided_are_said(rng):
    Q = 0.2 * covariance(8, rng, decades=1.0)
    whole, cut = (simulate_success(Q, np.random.default_rng(3), 2000, node_limit=limit) for limit in (LIMIT, 40))
    assert whole.undecided == 0
    assert 0 < cut.undecided < 2000
    assert cut.successes <= whole.successes <= cut.successes + cut.undecided
    assert cut.interval[0] < whole.rate < cut.interval[1]
    assert f"{cut.undecided} undecided" in repr(cut)
    assert "undecided" not in repr(whole)
    nothing = simulate_success(Q, rng, 100, node_limit=1)
    assert (nothing.successes, nothing.undecided) == (0, 100)
    assert nothing.interval == (0.0, 1.0)


def test_sixty_ambiguities_a_trillion_wide(rng):
    basis = np.linalg.qr(rng.standard_normal((60, 60)))[0]
    Q = basis @ np.diag(np.geomspace(3e-9, 3e3, 60)) @ basis.T  # condition 1e12
    Q = (Q + Q.T) / 2
    promised, simulated = success_rate(Q), simulate_success(Q, rng, 500)
    assert 0.9 < promised < 0.9999
    assert simulated.undecided == 0
    assert simulated.interval[1] >= promised


@given(st.integers(1, 10_000), st.floats(0.0, 1.0), st.floats(0.1, 5.0))
def test_interval_by_its_definition(samples, share, quantile):
    """The shares whose count would deviate by so many of their own sigmas, by root finding."""
    successes = round(share * samples)
    low, high = wilson_interval(successes, samples, quantile)

    def excess(p):
        return (successes - samples * p) ** 2 - quantile**2 * samples * p * (1 - p)

    assert 0 <= low <= successes / samples <= high <= 1
    inner = np.clip(successes / samples, 1e-9, 1 - 1e-9)  # off 0 and 1, where both sides are zero
    expected_low = brentq(excess, 0, inner, xtol=1e-14) if successes > 0 else 0
    expected_high = brentq(excess, inner, 1, xtol=1e-14) if successes < samples else 1
    assert np.allclose([low, high], [expected_low, expected_high], rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("probability", [0.001, 0.03, 0.5, 0.97, 0.9999])
def test_interval_covers_as_often_as_it_says(probability):
    """Over all counts that 10000 samples can give, with their exact chances; Wilson's is 95 % on average, not for each p."""
    N = 10_000
    counts = np.flatnonzero(binom.pmf(np.arange(N + 1), N, probability) > 1e-12)
    inside = [SimulatedRate(int(k), N).interval[0] <= probability <= SimulatedRate(int(k), N).interval[1] for k in counts]
    assert 0.91 < np.sum(binom.pmf(counts[inside], N, probability)) < 0.985


def test_sigma_is_binomial_and_never_zero():
    assert np.isclose(SimulatedRate(30_000, 100_000).sigma, np.sqrt(0.3 * 0.7 / 100_000), rtol=1e-4)
    assert np.isclose(SimulatedRate(0, 999).sigma, 1 / 2000)
    assert np.isclose(SimulatedRate(999, 999).sigma, 1 / 2000)
    assert SimulatedRate(0, 999).rate == 0.0
    assert repr(SimulatedRate(3, 4)) == "SimulatedRate: 75.000 % +- 20.000 % (3 of 4)"  # sqrt(3/64 + 1/64) / (1 + 1/4)


def test_fixes_are_drawn_with_the_covariance_and_judged_by_least_squares(rng):
    N, n = 40_000, 4
    Q, bias = 0.2 * covariance(n, rng, decades=1.0), rng.standard_normal(n)
    fixes = simulate_fixes(Q, rng, N, bias=bias)
    whitened = np.linalg.solve(np.linalg.cholesky(Q), (fixes.a_hat - bias).T)  # (n, N) standard normal
    assert np.all(np.abs(np.mean(whitened, axis=1)) < SIGMAS / np.sqrt(N))
    assert np.all(np.abs(whitened @ whitened.T / N - np.eye(n)) < SIGMAS * np.sqrt(2 / N))  # of a mean of squares
    solution = integer_least_squares(fixes.a_hat, Q)
    assert np.array_equal(fixes.best, solution.best)
    assert np.array_equal(fixes.norms, solution.norms)
    assert np.array_equal(fixes.ratio, solution.ratio)
    assert np.array_equal(fixes.is_right, np.all(fixes.best == 0, axis=-1))
    assert fixes.complete.all()


def test_fixes_are_right_as_often_as_counted(rng):
    Q = 0.5 * covariance(5, rng, decades=1.0)
    fixes, simulated = simulate_fixes(Q, rng, 20_000), simulate_success(Q, rng, 20_000)
    assert 0.05 < simulated.rate < 0.99
    assert abs(np.mean(fixes.is_right) - simulated.rate) < SIGMAS * np.sqrt(2) * simulated.sigma
    assert f"20000 vectors of 5 ambiguities, {np.sum(fixes.is_right)} fixed" in repr(fixes)


def test_same_seed_same_fixes():
    Q = np.eye(3)
    Q.flags.writeable = False
    one, other = (simulate_fixes(Q, np.random.default_rng(4), 10) for _ in range(2))
    assert np.array_equal(one.a_hat, other.a_hat)


PROGRAM = """
import json
import numpy as np
from gnsslab.core import integers, jit
rng = np.random.default_rng(7)
answers = []
for n in (1, 3, 6):
    A = rng.standard_normal((n, n))
    Q = 0.01 * (A @ A.T + 0.1 * np.eye(n))
    answers.append(list(integers.simulate_success(Q, np.random.default_rng(1), 6000, bias=np.full(n, 0.1))))
print(json.dumps([jit.COMPILED, answers]))
"""


def test_same_counts_with_and_without_compilation():
    pytest.importorskip("numba")
    runs = []
    for switch in ("0", "1"):
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path), "GNSSLAB_NO_NUMBA": switch}
        done = subprocess.run([sys.executable, "-W", "error", "-c", PROGRAM], env=environment, capture_output=True, text=True, timeout=300)
        assert done.returncode == 0, done.stderr
        runs.append(json.loads(done.stdout))
    assert [run[0] for run in runs] == [True, False]
    assert runs[0][1] == runs[1][1]
    assert any(0 < successes < 6000 for successes, *_ in runs[0][1])


@pytest.mark.parametrize("simulate", [simulate_success, simulate_fixes])
@pytest.mark.parametrize(
    ("Q", "options", "message"),
    [
        ([[1.0, 1.0], [1.0, 1.0]], {}, "Q is not positive definite"),
        ([[1.0, 0.5], [0.4, 1.0]], {}, "Q is not symmetric"),
        ([[np.nan]], {}, "Q contains NaN"),
        (np.ones((2, 1, 1)), {}, r"Q must be one covariance matrix \(n, n\).*it has shape \(2, 1, 1\)"),
        ([1.0], {}, r"shape \(1,\)"),
        (np.eye(2), {"bias": [0.1]}, "one finite number of cycles for each of the 2 ambiguities"),
        (np.eye(2), {"bias": [0.1, np.nan]}, "one finite number of cycles"),
        (np.eye(2), {"samples": 0}, "samples must be a whole number, 1 or more; it is 0"),
        (np.eye(2), {"samples": 10.5}, "samples must be a whole number, 1 or more; it is 10.5"),
        (np.eye(2), {"rng": 7}, r"rng must be a Generator, such as numpy.random.default_rng\(seed\) gives; it is 7"),
    ],
)
def test_bad_calls_are_explained(simulate, Q, options, message):
    with pytest.raises(ValueError, match=message):
        simulate(Q, **{"rng": np.random.default_rng(1), "samples": 10, **options})


def test_bad_node_limit_is_explained(rng):
    with pytest.raises(ValueError, match="node_limit must be a whole number, 1 or more; it is 0"):
        simulate_success([[1.0]], rng, 10, node_limit=0)
