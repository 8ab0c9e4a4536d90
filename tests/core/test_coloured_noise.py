"""Noise learnt from a series: what was put in comes out, whatever gross errors and steps do."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import lfilter

from gnsslab.core.coloured_noise import FEWEST_DIFFERENCES, learn_noise, tail_factor, variogram


def series(rng, T, white, coloured, tau):
    """Return white noise and a Gauss-Markov series together, both in sigmas."""
    a = np.exp(-1 / tau)
    n = coloured * rng.standard_normal(T)
    n[1:] *= np.sqrt(1 - a * a)
    return white * rng.standard_normal(T) + lfilter([1], [1, -a], n)


def test_parts_are_found_in_the_mean_of_many_series(rng):
    found = [learn_noise(series(rng, 4000, 1.1, 1.9, 8.0)) for _ in range(20)]
    total = [np.sqrt(noise.white + noise.coloured) for noise in found]
    assert np.mean(total) == pytest.approx(np.hypot(1.1, 1.9), rel=0.06)  # 20 series of 250 independent parts each
    assert np.sqrt(np.mean([noise.long_run for noise in found])) == pytest.approx(np.sqrt(1.1**2 + 16 * 1.9**2), rel=0.25)


@pytest.mark.parametrize("count", [60, 120, 2000])
def test_a_gross_error_hardly_counts(rng, count):
    z = rng.standard_normal(count)
    clean = learn_noise(z)
    z[count // 3] += 1000.0
    spoiled = learn_noise(z)
    assert spoiled.white + spoiled.coloured < 2 * (clean.white + clean.coloured)


def test_a_step_hardly_counts_in_a_long_series(rng):
    z = rng.standard_normal(8000)
    z[4000:] += 15.0
    assert 1.0 <= tail_factor(z) < 1.3
    noise = learn_noise(z)
    assert noise.white + noise.coloured == pytest.approx(1.0, rel=0.5)


def test_variogram_is_that_of_the_model(rng):
    lags, V = np.mean([variogram(series(rng, 4000, 1.0, 2.0, 10.0)) for _ in range(20)], axis=0)
    assert pytest.approx(1 + 4 * (1 - np.exp(-lags / 10)), rel=0.08) == V


@settings(max_examples=20, deadline=None)
@given(scale=st.sampled_from([1e-4, 1.0, 1e3]), offset=st.floats(-1e3, 1e3))
def test_units_and_origin_do_not_matter(scale, offset):
    z = np.random.default_rng(3).standard_normal(300)
    plain, moved = learn_noise(z), learn_noise(scale * (z + offset))
    assert moved.white / scale**2 == pytest.approx(plain.white, rel=1e-6)
    assert moved.correlation == plain.correlation


def test_gaps_are_left_out_and_too_few_values_are_refused(rng):
    z = rng.standard_normal(2000)
    z[rng.random(2000) < 0.2] = np.nan
    noise = learn_noise(z)
    assert noise.white + noise.coloured == pytest.approx(1.0, rel=0.15)
    with pytest.raises(ValueError, match="16 values or more; there are 15"):
        learn_noise(np.arange(2.0 * FEWEST_DIFFERENCES - 1))
