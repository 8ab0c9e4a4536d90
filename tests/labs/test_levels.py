"""Residuals at three levels: what cancels, what grows, and what a clock error does to the satellites' places."""

import numpy as np
import pytest
from scipy.stats import chi2

from gnsslab.gnss.signals import SPEED_OF_LIGHT
from gnsslab.labs.levels import grain, levels_of, traced_by_code, traced_by_tags
from gnsslab.simulate.sky import broadcast_ephemerides

T, M = 4000, 5
UNLIKELY = 1e-5


@pytest.fixture
def noise(rng):
    """White noise of unit variance (receiver, epoch, satellite)."""
    return rng.standard_normal((2, T, M))


def test_clocks_cancel_where_they_should(noise, rng):
    of_satellites, of_receivers = 1e5 * rng.standard_normal((T, M)), 3e5 * rng.standard_normal((2, T, 1))
    clean = levels_of(noise, 3, 1)
    without_satellites, without_all = levels_of(noise + of_satellites, 3, 1), levels_of(noise + of_satellites + of_receivers, 3, 1)
    rounding = 1e-9  # of 1e5 m
    np.testing.assert_allclose(without_satellites.single, clean.single, atol=rounding)
    np.testing.assert_allclose(without_all.double, clean.double, atol=rounding)
    assert np.abs(without_all.single).mean() > 1e4


@pytest.mark.parametrize(("level", "series", "growth"), [("undifferenced", 4, 1), ("single", 2, 2), ("double", 1, 4)])
def test_variance_grows_by_two_and_by_four(noise, level, series, growth):
    """The sum of T squares over its variance is chi-square of T degrees of freedom."""
    values = getattr(levels_of(noise, 0, 4), level)
    assert values.shape == (series, T)
    low, high = chi2.ppf([UNLIKELY, 1 - UNLIKELY], T)
    assert ((low < np.sum(values**2, axis=1) / growth) & (np.sum(values**2, axis=1) / growth < high)).all()


def test_double_difference_changes_sign_with_the_roles(noise):
    np.testing.assert_allclose(levels_of(noise, 2, 4).double, -levels_of(noise, 4, 2).double, atol=1e-12)


def test_missing_measurements_stay_missing(noise):
    noise[0, 7, 2] = np.nan
    levels = levels_of(noise, 2, 0)
    assert np.flatnonzero(np.isnan(levels.double[0])).tolist() == [7]
    assert np.isfinite(levels_of(noise, 1, 0).double).all()


def test_grain_is_what_a_drifting_clock_hides(noise):
    t = np.linspace(0, 300, T)
    drifting = 0.001 * noise[0, :, :1].T + 60_000 + 8.0 * t + 0.01 * t**2
    sigma, rest = grain(drifting)
    assert sigma == pytest.approx(0.001, rel=4 / np.sqrt(2 * T))
    assert np.abs(rest).max() < 0.01


def test_grain_takes_gaps_and_too_few_epochs():
    with_gap = np.array([[1.0, 2.0, np.nan, 4.0, 5.0, 6.0]])
    assert grain(with_gap)[0] == pytest.approx(0.0, abs=1e-12)
    assert np.isnan(grain(np.array([[1.0, 2.0, 3.0]]))[1]).all()


def test_a_millisecond_moves_the_satellites_by_their_range_rate():
    """Tags a millisecond fast: ranges by the tags differ from those by the codes by range rate times a millisecond."""
    time = np.datetime64("2024-06-24T05:20:00", "ns") + np.arange(61) * np.timedelta64(1, "s")
    ephemerides = broadcast_ephemerides(time[0], time[-1], "G")
    satellites, place = ("G24", "G25", "G28"), np.array([-3_817_000.0, 3_563_000.0, 3_650_000.0])
    guess = np.full((61, 3), 0.075 * SPEED_OF_LIGHT)
    for _ in range(4):  # what a perfect receiver would measure: the range less the satellite's clock
        rho, states = traced_by_code(ephemerides, satellites, time, place, guess)
        guess = rho - SPEED_OF_LIGHT * states.clock
    late = guess + 1e-3 * SPEED_OF_LIGHT  # the same tags, but measured a millisecond earlier
    by_code, _ = traced_by_code(ephemerides, satellites, time, place, late)
    by_tags, _ = traced_by_tags(ephemerides, satellites, time, place, late)
    rate = np.gradient(rho, 1.0, axis=0)
    assert np.abs(rate).max() > 300  # m/s
    np.testing.assert_allclose((by_tags - by_code)[1:-1], 1e-3 * rate[1:-1], atol=1e-5)  # the rate changes by 0.1 m/s each second
