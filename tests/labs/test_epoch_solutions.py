"""Epochs of a pair solved one by one: against the whole system at once, and with other references."""

import numpy as np
import pytest

from gnsslab.core.mixed_model import solve_float
from gnsslab.gnss.short_baseline import short_baseline_model
from gnsslab.labs.epoch_solutions import float_solutions, keep_satellites, middle, order_of_loss
from gnsslab.labs.pair_epochs import PairEpochs

T, M, WAVELENGTHS = 5, 7, np.array([0.1903, 0.2442])


@pytest.fixture
def single(rng):
    """Integers (f, m) and single differences of codes and carriers (2, T, f, m), satellites that move, sigmas (m,) of one reading."""
    u = rng.standard_normal((M, 3)) + 0.05 * rng.standard_normal((T, M, 3))
    u[..., 2] = np.abs(u[..., 2]) + 0.3
    u /= np.linalg.norm(u, axis=-1, keepdims=True)
    sigma = np.linspace(1, 3, M)
    integers = rng.integers(-50, 50, (2, M))
    noise = np.sqrt(2) * sigma * rng.standard_normal((2, T, 2, M)) * np.array([0.3, 0.003])[:, None, None, None]
    clocks = rng.standard_normal((T, 1, 1))
    return u, sigma, integers, noise + clocks + np.array([0, 1])[:, None, None, None] * WAVELENGTHS[:, None] * integers


def _epochs(single, kept):
    """Return the PairEpochs of some satellites, differenced here, with a plain subtraction."""
    u, _, integers, values = single
    values, integers = values[..., kept], integers[:, kept]
    double = values[..., 1:] - values[..., :1]  # (2, T, f, m - 1)
    return PairEpochs(
        y=np.concatenate([double[0].reshape(T, -1), double[1].reshape(T, -1)], axis=1),
        u=u[:, kept],
        wavelengths=WAVELENGTHS,
        integers=(integers[:, 1:] - integers[:, :1]).ravel(),
        satellites=tuple(f"G{k + 1:02d}" for k in kept),
    )


@pytest.mark.parametrize("kept", [[0, 1, 2, 3, 4, 5, 6], [0, 2, 5, 6], [3, 4, 5, 6], [6, 1, 3, 0]], ids=str)
def test_satellites_that_go_leave_the_differences_of_the_others(single, kept):
    ours, theirs = keep_satellites(_epochs(single, np.arange(M)), np.array(kept)), _epochs(single, np.array(kept))
    for name in ("y", "u", "wavelengths", "integers"):
        np.testing.assert_allclose(getattr(ours, name), getattr(theirs, name), atol=1e-9)
    assert ours.satellites == theirs.satellites


def test_float_solutions_by_the_whole_system_at_once(single):
    u, sigma, *_ = single
    epochs = _epochs(single, np.arange(M))
    found = float_solutions(epochs, 0.3 * sigma, 0.003 * sigma)
    for t in range(T):
        one = solve_float(epochs.y[t], *short_baseline_model(u[t], WAVELENGTHS, 0.3 * sigma, 0.003 * sigma))
        for ours, theirs in zip(found[:5], one[:5], strict=True):
            np.testing.assert_allclose(ours[t], theirs, rtol=1e-6, atol=1e-9)
    half = middle(found)
    np.testing.assert_array_equal(half.a_hat, found.a_hat[2])
    np.testing.assert_array_equal(half.Q_a, found.Q_a[2])


def test_one_geometry_serves_all_epochs(single):
    u, sigma, *_ = single
    at_rest = (np.broadcast_to(u[:1], u.shape), *single[1:])
    many, shared = _epochs(at_rest, np.arange(M)), _epochs((u[:1], *single[1:]), np.arange(M))
    ours, theirs = (float_solutions(epochs, 0.3 * sigma, 0.003 * sigma) for epochs in (shared, many))
    assert ours.Q_a.shape[0] == 1
    for one, other in zip(ours[:5], theirs[:5], strict=True):
        np.testing.assert_allclose(np.broadcast_to(one, other.shape), other, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(middle(ours).Q_a, middle(theirs).Q_a)


def test_order_follows_the_direction(single):
    epochs = _epochs(single, np.arange(M))
    for direction, key in (((0, 0, -1), lambda e, n, u: u), ((0, 0, 1), lambda e, n, u: -u), ((1, 0, 0), lambda e, n, u: -e)):
        order = order_of_loss(epochs, direction)
        assert sorted(order) == list(range(M))
        assert (np.diff([key(*epochs.u[T // 2, k]) for k in order]) >= 0).all()
