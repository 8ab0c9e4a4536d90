"""Lab of a filter's health: NIS and its bounds, sigma against error, presets, starts from cold, slips, pictures."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chi2

from gnsslab.figures.filter_health import BINS, build_over_time, build_shares
from gnsslab.figures.kept import KeptPicture, new_figure
from gnsslab.gnss.preparation import prepare_moving
from gnsslab.gnss.weighting import NoiseModel
from gnsslab.labs import filter_health
from gnsslab.labs.filter_health import NEVER, STARTS, USES, WINDOW, filter_health_lab, nis_bounds
from gnsslab.simulate import find_preset, simulate
from gnsslab.systems.constrained_filter import run_filter, steady_path
from gnsslab.systems.dual_antenna import A_STATIC

WHITE = {"multipath": 0, "carrier_sigma": 2.9, "code_sigma": 0.8, "velocity_noise": 1}


@pytest.fixture(scope="module")
def lab():
    """The lab, made once for all tests here."""
    return filter_health_lab()


@pytest.fixture
def shown(lab):
    """A function from a preset's name to its Health."""
    return lambda name: lab.run(**lab.preset(name).settings).health


# --- what is computed


def test_bounds_are_those_of_chi_square():
    """The second is an example of Bar-Shalom, Li and Kirubarajan (2001, section 5.4.2): 50 runs with 2 degrees of freedom, 1.5 to 2.6."""
    np.testing.assert_allclose(nis_bounds(13, 1), chi2.ppf([0.025, 0.975], 13))
    np.testing.assert_allclose(nis_bounds(2, 50).round(1), [1.5, 2.6])
    np.testing.assert_allclose(nis_bounds(np.array([5, 13]), 20)[:, 0], chi2.ppf([0.025, 0.975], 100) / 20)


def test_nis_of_chi_square_lies_in_its_bounds_as_often_as_they_say(lab):
    """4 sigma of a count."""
    health, N = lab.run().health, 20_000
    drawn = np.random.default_rng(1).chisquare(13, (N, WINDOW))
    for values, count in ((drawn[:, 0], 1), (drawn.mean(axis=1), WINDOW)):
        low, high = nis_bounds(13, count)
        assert abs(np.mean((low < values) & (values < high)) - 0.95) < 4 * np.sqrt(0.95 * 0.05 / N)
    assert np.all(health.gate == pytest.approx(chi2.isf(0.001, health.freedom)))
    assert np.sum(health.promised(np.array([0.0, *BINS, np.inf]))) == pytest.approx(1)


def test_running_mean_is_that_of_the_epochs_before(lab):
    health = lab.run().health
    seconds, mean = health.running(health.nis_phase)
    assert (seconds[0], seconds[-1]) == (WINDOW - 1, 649)
    for k in (0, 100, len(mean) - 1):
        assert mean[k] == pytest.approx(np.mean(health.nis_phase[k : k + WINDOW]))


def test_angle_errors_are_the_angles_between():
    """By products of vectors, whichever way the baseline points."""
    rng = np.random.default_rng(3)
    truth = rng.standard_normal((200, 3))
    baseline = truth + 0.3 * rng.standard_normal((200, 3))
    heading, pitch = filter_health._angle_errors(baseline, truth).T
    (e, n, u), (e0, n0, u0) = baseline.T, truth.T
    np.testing.assert_allclose(heading, np.arctan2(e * n0 - n * e0, n * n0 + e * e0), atol=1e-12)
    np.testing.assert_allclose(pitch, np.arcsin(u / np.linalg.norm(baseline, axis=1)) - np.arcsin(u0 / np.linalg.norm(truth, axis=1)), atol=1e-12)


def test_default_is_the_papers_filter(lab):
    """A run made step by step, without the lab."""
    simulation = simulate(find_preset(A_STATIC.preset), np.random.default_rng(1))
    prepared = prepare_moving(*simulation.observations, simulation.ephemerides, A_STATIC.settings)
    run, health = run_filter(prepared, steady_path(prepared, A_STATIC.velocity_noise), A_STATIC.filter), lab.run().health
    np.testing.assert_allclose(health.nis_phase, run.nis_phase, rtol=1e-6)
    np.testing.assert_array_equal(health.is_held, run.is_held)
    settled = slice(filter_health.SETTLED, None)
    off = run.baseline[settled] - simulation.truth.baselines_enu[0][settled]
    along = np.array([np.cos(np.radians(35)), -np.sin(np.radians(35))])  # across the baseline, to the right
    assert np.degrees(np.sqrt(np.mean((off[:, :2] @ along) ** 2)) / 1.167) == pytest.approx(health.rms[0], rel=0.02)


def test_one_factor_on_all_sigmas_is_as_good_as_another_noise_model(lab):
    """The noise model adds 0.7 mm of thermal noise, whatever the rest: 3 % of the variance of 4 mm."""
    simulation = simulate(find_preset(A_STATIC.preset), np.random.default_rng(1))
    noise = NoiseModel(0.004 / 2**0.5, 0.004 / 2**0.5, 1.2 / 0.004, correlated_share=0.0)
    prepared = prepare_moving(*simulation.observations, simulation.ephemerides, replace(A_STATIC.settings, noise=noise))
    run = run_filter(prepared, steady_path(prepared, A_STATIC.velocity_noise), A_STATIC.filter)
    health = lab.run(carrier_sigma=4, code_sigma=1.2).health
    settled = health.is_settled
    assert health.mean(health.nis_phase) == pytest.approx(run.nis_phase[settled].mean(), rel=0.04)
    assert health.mean(health.nis_code) == pytest.approx(run.nis_code[settled].mean(), rel=0.04)


# --- what is to be seen


@pytest.mark.parametrize("seed", range(1, 7))
def test_white_noise_told_as_it_is_gives_what_is_promised(lab, seed):
    """NIS of 13 to 8 %: the filter lets a baseline at rest move a little. Codes have 0.4 m of multipath in 0.8 m, and 2 sigma of errors that last."""
    health = lab.run(**WHITE, seed=seed).health
    assert health.mean(health.nis_phase) == pytest.approx(13, rel=0.08)
    assert health.mean(health.nis_code) == pytest.approx(13, rel=0.2)
    assert 0.90 < health.inside[0] <= 1
    assert health.rejected(health.nis_phase) <= 5
    assert health.share(health.is_fixed) == 1


@pytest.mark.parametrize("seed", range(1, 7))
def test_nis_goes_with_the_square_of_the_sigma(lab, seed):
    """Where the innovation is nearly all measurement; codes are all of it."""
    nis = {sigma: (h := lab.run(code_sigma=sigma, seed=seed).health).mean(h.nis_code) for sigma in (0.6, 1.2, 2.4)}
    assert nis[0.6] / nis[1.2] == pytest.approx(4, rel=0.05)
    assert nis[1.2] / nis[2.4] == pytest.approx(4, rel=0.05)


def test_presets_show_what_they_promise(shown):
    found = {name: shown(f"health-{name}") for name in ("paper", "white", "small", "lasting", "lag", "gate", "no-hold", "held-wrong")}
    nis = {name: health.mean(health.nis_phase) for name, health in found.items()}
    inside = {name: health.inside[0] for name, health in found.items()}
    fixed = {name: health.share(health.is_fixed) for name, health in found.items()}
    assert nis["paper"] < 13 / 2
    assert inside["white"] == pytest.approx(0.97, abs=0.01)
    assert np.subtract(nis["white"], found["white"].mean_bounds).prod() < 0
    assert nis["small"] == pytest.approx(7 * 13, rel=0.1)
    assert 100 < np.argmax(found["small"].is_fixed) < 130
    assert inside["small"] == pytest.approx(1 / 3, abs=0.05)
    assert nis["lasting"] < 13 / 2
    assert inside["lasting"] < 0.87
    assert found["lag"].rms[0] == pytest.approx(2.5, abs=0.5)
    assert np.median(found["lag"].sigma[100:, 0]) == pytest.approx(0.3, abs=0.05)
    assert found["gate"].rejected(found["gate"].nis_code) / 550 == pytest.approx(5 / 6, abs=0.03)
    assert not found["gate"].is_wrong[100:].any()
    assert fixed["no-hold"] == pytest.approx(0.25, abs=0.03)
    assert found["held-wrong"].is_wrong.all()
    assert found["held-wrong"].is_held.all()
    assert nis["held-wrong"] > 1000


def test_codes_of_the_gate_are_good(lab):
    """The same data, believed as they are, pass."""
    health = lab.run(code_sigma=0.8).health
    assert health.rejected(health.nis_code) <= 5


def test_hold_is_what_keeps_the_fixes(lab):
    """Over ten seeds, with nothing else changed."""
    shares = {hold: np.mean([(h := lab.run(hold_after=hold, seed=seed).health).share(h.is_fixed) for seed in range(1, 11)]) for hold in (0, 5)}
    assert shares[5] > 0.95
    assert shares[0] < shares[5] - 0.15


def test_slip_is_seen_in_the_innovation(lab):
    """Nothing differs before; at the slip it is one wavelength of L1, less what the filter's own baseline takes."""
    plain, slipped = lab.run().health, lab.run(slip_at=200).health
    np.testing.assert_allclose(slipped.nis_phase[:200], plain.nis_phase[:200], rtol=1e-9)
    assert abs(slipped.watched - plain.watched)[200] == pytest.approx(0.1903, abs=0.001)
    assert (slipped.nis_phase[200:300] > slipped.gate[200:300]).all()
    assert (slipped.nis_phase[302:] < slipped.gate[302:]).all()
    assert slipped.inside[0] < plain.inside[0] - 0.1


def test_lag_goes_with_a_velocity_that_may_change(lab):
    biased, free = (lab.run(motion="turning", velocity_noise=q).health for q in (1, 30))
    assert free.mean(free.nis_phase) < 13 < 50 < biased.mean(biased.nis_phase)
    assert np.mean(biased.error[100:, 0]) < -1.5 < -0.3 < np.mean(free.error[100:, 0])


# --- starts from cold


def test_starts_are_first_fixes_of_runs(lab):
    result = lab.run(many_starts=True)
    assert result.starts.first.shape == (len(USES), STARTS)
    assert result.starts.first.max() < 120
    assert not result.starts.is_wrong[result.starts.first == NEVER].any()
    assert lab.run().starts is None


def test_length_in_the_search_fixes_first_and_as_a_row_changes_nothing(lab):
    starts = lab.run(many_starts=True).starts
    nowhere, row, search = np.where(starts.first == NEVER, 1000, starts.first)
    assert np.mean(search == 0) > 0.5
    assert np.median(search) < 2 < 15 < np.median(row)
    assert (search <= row).all()
    assert np.median(np.abs(row - nowhere)) == 0


def test_a_start_is_the_first_two_minutes_of_a_trial(lab):
    """One of them by hand, with random numbers of the same seed."""
    starts = lab.run(many_starts=True, seed=2).starts
    preset = replace(find_preset(A_STATIC.preset), duration=120.0, events=())
    for k in (0, 7):
        simulation = simulate(preset, np.random.default_rng((2, k)))
        prepared = prepare_moving(*simulation.observations, simulation.ephemerides, A_STATIC.settings)
        first = run_filter(prepared, steady_path(prepared, A_STATIC.velocity_noise), A_STATIC.filter).first_fix
        assert starts.first[1, k] == (NEVER if first is None else first)


# --- goals, controls, pictures


def test_goals_are_judged(lab):
    band, both = lab.goals
    for settings, reached in (({}, False), ({"carrier_sigma": 6}, True), ({"carrier_sigma": 6, "multipath": 4}, False), (WHITE, False)):
        assert band.judge(lab.run(**settings))[0] is reached, settings
    for settings, reached in (({}, False), (WHITE, False), ({"multipath_time": 1, "carrier_sigma": 5.6}, True), ({"carrier_sigma": 6}, False)):
        assert both.judge(lab.run(**settings))[0] is reached, settings
    assert "outside the rules" in band.judge(lab.run(**WHITE))[1]


def test_every_corner_computes(lab):
    for control in lab.controls:
        for value in control.corners:
            result = lab.run(**{control.name: value})
            assert result.problem == ""
            assert len(lab.readouts(result)) == 6
            assert {len(column) for column in lab.table(result).values()} == {len(result.health.seconds)}
            words = f"{lab.readouts(result)} {lab.describe(result)}"
            assert "nan" not in words
            assert "inf" not in words


def test_sigma_of_the_hold_needs_a_hold(lab):
    assert set(lab.blocked(lab.settings())) == set()
    assert set(lab.blocked(lab.settings(hold_after=0))) == {"hold_sigma"}
    one, two = (lab.readouts(lab.run(hold_after=0, hold_sigma=sigma)) for sigma in (0.5, 30))
    assert one == two


@pytest.mark.parametrize("build", [build_over_time, build_shares])
def test_kept_pictures_hold_nothing_back(lab, build):
    kept = KeptPicture(build, 440, 480, sharpness=0.5)
    for settings in ({"motion": "turning"}, {"many_starts": True}, {"hold_after": 1, "ratio": 1, "seed": 3}, {"hold_after": 0, "seed": 5}, {}):
        moved = kept.png(result := lab.run(**settings))
    assert moved == KeptPicture(build, 440, 480, sharpness=0.5).png(result)


def test_picture_of_shares_says_the_numbers(lab):
    result = lab.run(many_starts=True)
    figure = new_figure(360, 480)
    build_shares(figure).show(result)
    spread, first = figure.axes
    outline = spread.collections[0].get_paths()[0].vertices
    assert np.sum(outline[1:-1:2, 1][: len(BINS) - 1]) == pytest.approx(100, abs=0.01)
    for line, epochs in zip(first.lines, result.starts.first, strict=False):
        assert np.max(line.get_ydata(), initial=0) == pytest.approx(100 * np.mean(epochs >= 0))
        assert f"{np.sum(epochs >= 0)} within 120 s" in lab.describe(result)


def test_strip_and_triangles_say_the_epochs(lab):
    result = lab.run(hold_after=20, seed=3, velocity_noise=1)
    health, figure = result.health, new_figure(500, 560)
    build_over_time(figure).show(result)
    *_, heading, strip = figure.axes
    for part, chosen in zip(strip.collections, (np.ones(650), health.is_fixed, health.is_held, health.is_wrong), strict=True):
        assert sum(np.ptp(path.vertices[:, 0]) for path in part.get_paths()) == pytest.approx(np.sum(chosen))
    inside, outside = (len(line.get_xdata()) for line in heading.lines)
    assert (inside + outside, outside) == (650, np.sum(np.abs(health.error[:, 0]) >= 2 * health.sigma[:, 0]))
