"""EEMD-wavelet: against the package's own ensemble, repeatable, of any unit, and every trial reported."""

import numpy as np
import pytest

from gnsslab.core.decomposition import eemd_wavelet


def of_seed(z, seed=1, **settings):
    return eemd_wavelet(z, np.random.default_rng(seed), **settings)


@pytest.fixture
def z(rng):
    """A slow wave of a metre in white noise of a fifth of that."""
    return np.sin(np.arange(400) / 40)[:, None] + 0.2 * rng.standard_normal((400, 1))


def test_noise_goes_and_the_wave_stays(z):
    wave = np.sin(np.arange(400) / 40)[:, None]
    assert np.std(of_seed(z) - wave) < 0.5 * np.std(z - wave)


def by_the_package(z):
    """Return what eemd_wavelet promises of z (T, 1), with the ensemble of EMD-signal, whose noise is counted in ranges of the series."""
    from PyEMD import EEMD  # loaded before by the library, which keeps its warnings down

    y, ensemble = z[:, 0] / z.std(), EEMD(trials=25, noise_width=0.2 / np.ptp(z / z.std()), parallel=False, FIXE=8)
    ensemble.noise_seed(5)
    modes = ensemble.eemd(y - y.mean(), max_imf=3)
    limit = np.median(abs(modes[:3]), axis=1, keepdims=True) / 0.6745 * np.sqrt(2 * np.log(len(y)))
    modes[:3] = np.sign(modes[:3]) * np.maximum(abs(modes[:3]) - limit, 0.0)
    return z.std() * (y.mean() + modes.sum(axis=0))[:, None]


def test_another_ensemble_differs_as_two_of_ours_do(z):
    ours, again, theirs = of_seed(z), of_seed(z, seed=2), by_the_package(z)
    assert np.std(ours - theirs) < 1.3 * np.std(ours - again)
    assert np.std(ours - again) < 0.3 * np.std(ours - z)


def test_the_same_seed_gives_the_same_series_in_any_unit_and_from_any_origin(z):
    first = of_seed(z, trials=4)
    assert (of_seed(z, trials=4) == first).all()
    assert (of_seed(z, seed=2, trials=4) != first).any()
    for unit, shift in ((1e-3, 0.0), (1e4, 5.0)):
        np.testing.assert_allclose(of_seed(unit * (z + shift), trials=4), unit * (first + shift), rtol=0, atol=1e-7 * unit)


def test_a_limit_of_nothing_takes_nothing(z):
    """With no noise added and no limit the oscillations add up to the series again."""
    np.testing.assert_allclose(of_seed(z, trials=1, noise=0.0, scale=0.0), z, rtol=0, atol=1e-12)


def test_every_trial_is_reported(rng):
    told = []
    of_seed(rng.standard_normal((60, 2)), trials=3, progress=lambda done, total: told.append((done, total)))
    assert told == [(k, 6) for k in range(1, 7)]


def test_axes_of_a_stack_and_axes_without_noise(z):
    z = np.stack([np.hstack([z, np.full_like(z, 1.2)])] * 2)
    z.flags.writeable = False
    done = of_seed(z, trials=2)
    assert done.shape == z.shape
    assert (done[..., 1] == 1.2).all()


@pytest.mark.parametrize("T", [5, 6, 9, 20])
def test_a_short_series_is_no_crash(T, rng):
    assert np.isfinite(of_seed(rng.standard_normal((T, 1)), trials=3)).all()
    assert np.isfinite(of_seed(np.arange(T, dtype=float)[:, None], trials=3)).all()


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: of_seed(np.zeros((4, 1))), "EEMD needs at least 5 epochs, there are 4"),
        (lambda: of_seed(np.full((9, 1), np.nan)), "9 of z have NaN"),
        (lambda: of_seed(np.zeros((9, 1)), trials=0), "trials must be a whole number"),
        (lambda: of_seed(np.zeros((9, 1)), noise=-1.0), "noise and scale must not be negative"),
        (lambda: of_seed(np.zeros(9)), r"write z\[:, None\]"),
    ],
)
def test_a_bad_call_is_told_what_was_expected(call, words):
    with pytest.raises(ValueError, match=words):
        call()
