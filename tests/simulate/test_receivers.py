import numpy as np
import pytest

from gnsslab.gnss.signals import BANDS, frequency, tracking_letters
from gnsslab.simulate.receivers import NO_NOISE, SIGNALS, Clock, Noise, cn0_at, gauss_markov, sends, signals_of, white_factor

SIGMA = 4  # a statistic further than 4 of its own standard deviations off fails: 1 run in 16 000


@pytest.mark.parametrize(("tau", "interval"), [(20.0, 1.0), (60.0, 1.0), (5.0, 0.2)])
def test_multipath_has_unit_variance_and_its_correlation_time(rng, tau, interval):
    T, n = 400, 3000
    x = gauss_markov(rng.standard_normal((T, 1, n)), interval, tau)[:, 0]
    a = np.exp(-interval / tau)
    independent = T * n * (1 - a**2) / (1 + a**2)  # effective number for second moments of a first-order series
    assert abs(np.mean(x**2) - 1) < SIGMA * np.sqrt(2 / independent)
    for lag in (1, 10, 40):
        product = np.mean(x[lag:] * x[:-lag])
        assert abs(product - a**lag) < SIGMA * np.sqrt(2 / independent)
    assert abs(np.mean(x[0] ** 2) - 1) < SIGMA * np.sqrt(2 / n)  # stationary from the first epoch on


def test_multipath_equals_its_recursion_written_by_hand(rng):
    w = rng.standard_normal((5, 1, 1))
    w.flags.writeable = False
    x, expected = w[0, 0, 0], [w[0, 0, 0]]
    for k in range(1, 5):
        x = np.exp(-0.1) * x + np.sqrt(1 - np.exp(-0.2)) * w[k, 0, 0]
        expected.append(x)
    assert np.allclose(gauss_markov(w, 1.0, 10.0)[:, 0, 0], expected, rtol=1e-14)


@pytest.mark.parametrize(("field", "value"), [("code", -0.1), ("carrier", np.nan), ("carrier_multipath_time", 0.0), ("doppler", np.inf)])
def test_noise_that_cannot_be_is_refused_in_words(field, value):
    with pytest.raises(ValueError, match=f"noise '{field}' must be"):
        Noise(**{field: value})


def test_clocks_are_offset_and_drift_and_jump():
    t = np.array([0.0, 10.0, 100.0])
    assert np.allclose(Clock(1e-3, 1e-6).error(t), [1e-3, 1.01e-3, 1.1e-3], atol=1e-15)
    jumping = Clock(0.0, 3e-5, jump=1e-3).error(np.arange(0, 200.0))
    assert np.abs(jumping).max() <= 0.5e-3 + 1e-12
    steps = np.diff(jumping)
    assert (np.isclose(steps, 3e-5, atol=1e-12) | np.isclose(steps, 3e-5 - 1e-3, atol=1e-12)).all()
    assert (steps < 0).sum() == 6  # 6 ms of drift


def test_signals_are_of_the_bands_the_engine_knows():
    for system, bands in SIGNALS.items():
        for band, signals in zip(BANDS[system], bands, strict=True):
            for signal in signals:
                assert signal[0] in band
                assert signal[1] in tracking_letters(system, signal[0])
                assert frequency(system, signal[0]) > 1e9
    assert [len(signals_of(system, 2)) for system in "GECJ"] == [2, 2, 2, 2]


def test_each_beidou_satellite_sends_one_third_signal():
    names = [f"C{number:02d}" for number in range(1, 64)]
    assert all(sends(name, "7I") != sends(name, "5P") for name in names)
    assert all(sends(name, "2I") and sends(name, "6I") for name in names)


def test_signal_strength_and_noise_follow_elevation():
    elevation = np.radians(np.arange(1, 90))
    assert (np.diff(cn0_at(elevation)) > 0).all()
    assert (np.diff(white_factor(elevation)) < 0).all()
    assert np.isfinite(white_factor(np.array([-0.2, 0.0]))).all()
    assert NO_NOISE.code == NO_NOISE.cn0 == 0
