"""The short-baseline model: the published example, and noise drawn receiver by receiver."""

import json
from pathlib import Path

import numpy as np
import pytest

from gnsslab.core.mixed_model import solve_float
from gnsslab.gnss.short_baseline import short_baseline_model

REFERENCE = Path(__file__).parents[1] / "reference" / "constrained.json"


@pytest.fixture(scope="module")
def published():
    return json.loads(REFERENCE.read_text())["model"]


def test_published_covariances(published):
    """TU Delft's LAMBDA 4.0, example 3: one epoch of GPS L1, six satellites."""
    elevation, azimuth = np.array(published["El_rad"]), np.array(published["Az_rad"])
    u = np.stack([np.cos(elevation) * np.sin(azimuth), np.cos(elevation) * np.cos(azimuth), np.sin(elevation)], axis=-1)
    growth = 1 / (0.2 + np.sin(elevation))
    A, B, Q_y = short_baseline_model(-u, [published["c"] / published["f"]], 0.2 * growth, 0.002 * growth)  # B = D u there
    found = solve_float(np.zeros(len(A)), A, B, Q_y)
    for ours, theirs in ((found.Q_a, "Qaa"), (found.Q_b, "Qbb"), (found.Q_ba, "Qba")):
        assert np.allclose(ours, published[theirs], atol=1e-9)


def test_covariance_is_that_of_drawn_readings(rng):
    u = rng.standard_normal((4, 3))
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    sigma_code, sigma_phase, N = np.array([0.3, 0.4, 0.5, 0.6]), np.array([3.0, 4.0, 5.0, 6.0]), 40_000
    _, _, Q_y = short_baseline_model(u, [0.19, 0.24], sigma_code, sigma_phase, reference=1)
    others = [0, 2, 3]

    def draw(sigma):
        readings = sigma * rng.standard_normal((N, 2, 4))
        single = readings[:, 1] - readings[:, 0]
        return single[:, others] - single[:, [1]]

    counted = np.cov(np.hstack([draw(sigma_code), draw(sigma_code), draw(sigma_phase), draw(sigma_phase)]), rowvar=False)
    scale = np.sqrt(np.outer(np.diag(Q_y), np.diag(Q_y)))
    assert np.all(abs(counted - Q_y) < 5 * scale / np.sqrt(N))


def test_rows_are_codes_then_carriers_frequency_by_frequency():
    u = np.eye(3)
    A, B, Q_y = short_baseline_model(u, [0.2, 0.25], [0.3] * 3, [0.003] * 3)
    assert A.shape == (8, 4)
    assert np.array_equal(A[:4], np.zeros((4, 4)))
    assert np.array_equal(A[4:], np.diag([0.2, 0.2, 0.25, 0.25]))
    assert np.array_equal(B, np.tile([[1.0, -1.0, 0.0], [1.0, 0.0, -1.0]], (4, 1)))
    assert np.array_equal(Q_y[:2, 2:], np.zeros((2, 6)))


def test_more_epochs_of_one_geometry_divide_the_covariance():
    one, ten = (short_baseline_model(np.eye(3), [0.2], [0.3] * 3, [0.003] * 3, epochs=epochs) for epochs in (1, 10))
    assert np.allclose(one.Q_y, 10 * ten.Q_y)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((np.eye(3)[:1], [0.2], [0.3], [0.003]), "two or more satellites"),
        ((np.eye(3), [], [0.3] * 3, [0.003] * 3), "wavelengths"),
        ((np.eye(3), [0.2], [0.3] * 2, [0.003] * 3), "sigma_code must have one positive number of metres for each of the 3"),
        ((np.eye(3), [0.2], [0.3] * 3, [0.003, 0.003, -0.003]), "sigma_phase must have one positive number"),
        ((np.eye(3), [[0.2], [0.25]], [0.3] * 3, [0.003] * 3), "wavelengths"),
        ((np.eye(3), [np.nan], [0.3] * 3, [0.003] * 3), "wavelengths"),
        ((2e7 * np.eye(3), [0.2], [0.3] * 3, [0.003] * 3), "unit vectors from receiver to satellite"),
        ((np.eye(3), [0.2], [0.3] * 3, [0.003] * 3, 0), "epochs must be 1 or more; it is 0"),
        ((np.eye(3), [0.2], [0.3] * 3, [0.003] * 3, np.nan), "epochs must be 1 or more; it is nan"),
    ],
)
def test_bad_models_are_explained(arguments, message):
    with pytest.raises(ValueError, match=message):
        short_baseline_model(*arguments)
