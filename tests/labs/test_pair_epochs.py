"""Epochs of two receivers at rest as measurements of the mixed model."""

import numpy as np
import pytest

from gnsslab.labs.pair_epochs import choose_epochs, model_pair


@pytest.fixture(scope="module")
def stations(campaign):
    """Two stations of GEONET on two frequencies."""
    data = campaign("geonet-0759-3040")
    return model_pair(data.base, data.rover, data.ephemerides, 2)


def test_what_is_left_of_the_measurements_is_their_noise(stations):
    """With the known baseline and integers nothing but noise remains: metres of code, centimetres of carrier."""
    epochs = choose_epochs(stations, 6, np.radians(15), 1)
    n = len(epochs.integers)
    assert n == 2 * (6 - 1)
    code, carrier = epochs.y[:, :n], epochs.y[:, n:] - np.repeat(epochs.wavelengths, 5) * epochs.integers
    assert 0.05 < code.std() < 2.0
    assert np.abs(carrier).max() < 0.06
    assert np.abs(epochs.integers).max() < 30  # as far off as the codes of one epoch
    np.testing.assert_allclose(epochs.wavelengths, [0.190294, 0.244210], atol=1e-6)


def test_satellites_stand_highest_first_above_the_mask(stations):
    for mask in (15, 30):
        epochs = choose_epochs(stations, 5, np.radians(mask), 1)
        assert (np.diff(epochs.elevation) <= 0).all()
        assert epochs.elevation.min() >= np.radians(mask)
        np.testing.assert_allclose(np.linalg.norm(epochs.u, axis=-1), 1, atol=1e-3)  # the troposphere's slope is in the design


def test_means_of_windows_by_loops(stations):
    single, means = (choose_epochs(stations, 6, np.radians(15), together) for together in (1, 7))
    assert len(means.y) == len(single.y) - 6
    for k in (0, 50, len(means.y) - 1):
        np.testing.assert_allclose(means.y[k], sum(single.y[k : k + 7]) / 7, rtol=1e-9)
        np.testing.assert_allclose(means.u[k], sum(single.u[k : k + 7]) / 7, rtol=1e-9)


def test_too_few_satellites_or_epochs_are_refused_in_words(stations):
    with pytest.raises(ValueError, match="fewer than four satellites were tracked together for 20 epochs"):
        choose_epochs(stations, 6, np.radians(60), 1)
    with pytest.raises(ValueError, match="fewer than 500: use fewer epochs together"):
        choose_epochs(stations, 6, np.radians(15), 500)
