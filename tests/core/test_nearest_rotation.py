"""The nearest rotation: SciPy's Kabsch where weights are scalars, a grid of rotations and SciPy's descent where they are not."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

from gnsslab.core.jit import kernel_input
from gnsslab.core.nearest_frame import descend, frame_bound, rotations_of_the_cube
from gnsslab.core.nearest_rotation import body_axes, nearest_rotation
from gnsslab.core.sphere import nearest_on_sphere

BODIES = {
    "one": [[0.0, 1.0, 0.0]],
    "in line": [[0.0, 1.0, 0.0], [0.0, -1.3, 0.0]],
    "right angle": [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0]],
    "narrow": [[0.0, 15.0, 0.0], [1.5, 14.0, 0.0]],
    "flat": [[0.0, 1.0, 0.0], [0.7, 0.7, 0.0], [-0.7, 0.6, 0.0]],
    "nearly flat": [[0.0, 1.0, 0.0], [0.7, 0.7, 0.0], [-0.7, 0.6, 0.02]],
    "tripod": [[0.0, 1.0, 0.0], [0.7, 0.7, 0.0], [0.0, 0.4, 0.6]],
    "left-handed": [[0.0, 1.0, 0.0], [0.7, 0.7, 0.0], [0.0, 0.4, -0.6]],
    "five": [[0.0, 1.0, 0.0], [0.7, 0.7, 0.0], [0.0, 0.4, 0.6], [1.0, 1.0, 1.0]],
}
bodies = pytest.mark.parametrize("body", BODIES.values(), ids=BODIES.keys())
cases = st.tuples(st.sampled_from(list(BODIES.values())), st.integers(0, 2**32 - 1), st.floats(0.0, 5.0), st.floats(-3.0, 0.3))


def problem(body, seed, decades, noise):
    """Return measured baselines (k, 3) and a full covariance; the noise has another covariance, so that some fit badly."""
    rng, body = np.random.default_rng(seed), np.array(body)
    size = np.linalg.norm(body, axis=1).max()
    axes = np.linalg.qr(rng.standard_normal((body.size, body.size)))[0]
    Q = axes @ np.diag(10.0 ** rng.uniform(-decades, 0.0, body.size)) @ axes.T
    R = Rotation.random(random_state=rng).as_matrix()
    return body @ R.T + 10.0**noise * size * rng.standard_normal(body.shape), 0.5 * (Q + Q.T), body, R, rng


def misfits(b, Q, body, R):
    """Return the squared distances (N,) for rotations R (N, 3, 3), written down as they are defined."""
    off = (b - np.einsum("nij,kj->nki", R, body)).reshape(len(R), -1)
    return np.vecdot(off, np.linalg.solve(Q, off.T).T)


GRID = np.array([R.as_matrix() for R in Rotation.random(4000, random_state=3)])  # random rotations, dense enough that some lie in every valley


def by_force(b, Q, body, best=6):
    """Return the least misfit over a grid of rotations, the best of them improved by SciPy's descent over rotation vectors."""
    values = misfits(b, Q, body, GRID)
    ends = []
    for start in GRID[np.argsort(values)[:best]]:
        ends.append(minimize(turned_by, np.zeros(3), args=(start, b, Q, body), method="BFGS", options={"gtol": 1e-9}).fun)
    return min(ends)


def turned_by(theta, start, b, Q, body):
    """Return the misfit of a rotation turned by a vector theta (3,) [rad]."""
    return misfits(b, Q, body, (Rotation.from_rotvec(theta).as_matrix() @ start)[None])[0]


@bodies
@pytest.mark.parametrize("noise", [-2.0, -0.5, 0.3])
def test_no_rotation_of_a_fine_grid_leads_lower(body, noise, rng):
    for _ in range(3):
        b, Q, body_, _, _ = problem(body, rng.integers(2**32), rng.uniform(0.0, 2.0), noise)
        found = nearest_rotation(b, Q, body_)
        assert np.isclose(found.misfit, by_force(b, Q, body_), rtol=1e-6, atol=1e-9)


@bodies
def test_nor_in_metrics_so_long_that_scipy_gets_stuck(body, rng):
    for noise in (-2.0, -0.5, 0.3):
        b, Q, body_, _, _ = problem(body, rng.integers(2**32), 6.0, noise)
        assert nearest_rotation(b, Q, body_).misfit <= by_force(b, Q, body_) * (1 + 1e-6) + 1e-9


@bodies
def test_six_hundred_starts_find_no_lower_minimum(body, rng):
    """Bodies that fit well and badly, in metrics up to a hundred thousand to one."""
    starts = GRID[:600]
    for _ in range(25):
        b, Q, body_, _, _ = problem(body, rng.integers(2**32), rng.uniform(0.0, 5.0), rng.uniform(-2.0, 0.3))
        X, T = body_axes(body_)
        G = np.kron(X, np.eye(3))
        M = G.T @ np.linalg.solve(Q, G)
        u_hat = np.linalg.solve(M, G.T @ np.linalg.solve(Q, b.ravel()))
        least = b.ravel() @ np.linalg.solve(Q, b.ravel()) - u_hat @ M @ u_hat
        minima = [descend(kernel_input(M), kernel_input(u_hat), kernel_input((R @ T.T).T)) for R in starts]
        assert np.isclose(nearest_rotation(b, Q, body_).misfit, min(minima) + least, rtol=1e-6, atol=1e-9)


@settings(max_examples=150, deadline=None)
@given(cases)
def test_what_is_returned_is_a_rotation_with_that_misfit_and_not_below_the_bound(case):
    b, Q, body, _, _ = problem(*case)
    found = nearest_rotation(b, Q, body)
    assert np.allclose(found.rotation @ found.rotation.T, np.eye(3), atol=1e-12)
    assert np.isclose(np.linalg.det(found.rotation), 1.0)
    assert np.allclose(found.baselines, body @ found.rotation.T, atol=1e-12 * np.abs(body).max())
    value = misfits(b, Q, body, found.rotation[None])[0]
    assert np.isclose(found.misfit, value, rtol=1e-6, atol=1e-9)
    assert found.bound <= value * (1 + 1e-6) + 1e-9


@settings(max_examples=100, deadline=None)
@given(cases, st.floats(0.01, 2.0))
def test_bound_is_below_every_rotation_however_early_it_stops(case, share):
    b, Q, body, _, _ = problem(*case)
    X, T = body_axes(body)
    G = np.kron(X, np.eye(3))
    M = G.T @ np.linalg.solve(Q, G)
    u_hat = np.linalg.solve(M, G.T @ np.linalg.solve(Q, b.ravel()))
    u = np.einsum("nij,kj->nki", GRID, T[: X.shape[1]]).reshape(len(GRID), -1)
    distances = np.vecdot(u - u_hat, (u - u_hat) @ M)
    found = frame_bound(kernel_input(M), kernel_input(u_hat), share * distances.min(), kernel_input(np.zeros(len(u_hat))))
    assert found <= distances.min() * (1 + 1e-9)


@pytest.mark.filterwarnings("ignore:Optimal rotation is not uniquely")  # of antennas in line
@settings(max_examples=100, deadline=None)
@given(cases)
def test_equals_kabsch_of_scipy_where_coordinates_are_alike(case):
    b, _, body, _, rng = problem(*case)
    sigma = rng.uniform(0.5, 2.0, len(body))
    found = nearest_rotation(b, np.diag(np.repeat(sigma**2, 3)), body)
    kabsch = Rotation.align_vectors(b, body, weights=sigma**-2 if len(body) > 1 else None)[0]
    expected = np.sum(((b - kabsch.apply(body)) / sigma[:, None]) ** 2)
    assert np.isclose(found.misfit, expected, rtol=1e-7, atol=1e-9)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0.0, 3.0), st.floats(-2.0, 0.3))
def test_one_baseline_is_the_nearest_point_of_a_sphere(seed, decades, noise):
    b, Q, body, _, _ = problem(BODIES["one"], seed, decades, noise)
    found, on_sphere = nearest_rotation(b, Q, body), nearest_on_sphere(b[0], Q, 1.0)
    assert np.isclose(found.misfit, on_sphere.cost, rtol=1e-7, atol=1e-9)


@bodies
def test_without_noise_the_truth_comes_back(body, rng):
    _, Q, body_, R, _ = problem(body, 11, 2.0, -3.0)
    found = nearest_rotation(body_ @ R.T, Q, body_)
    assert found.is_proved
    assert found.misfit < 1e-12
    assert np.allclose(found.baselines, body_ @ R.T, atol=1e-7)
    if body_axes(body_).X.shape[1] > 1:
        assert np.allclose(found.rotation, R, atol=1e-6)


@settings(max_examples=60, deadline=None)
@given(cases)
def test_other_axes_turn_the_answer(case):
    b, Q, body, _, rng = problem(*case)
    S, P = (Rotation.random(random_state=rng).as_matrix() for _ in range(2))  # of the world, of the body
    whole = np.kron(np.eye(len(body)), S)
    found, turned = nearest_rotation(b, Q, body), nearest_rotation(b @ S.T, whole @ Q @ whole.T, body @ P.T)
    assert np.isclose(found.misfit, turned.misfit, rtol=1e-6, atol=1e-9)


def test_a_body_that_nearly_fits_is_proved(rng):
    """Two centimetres of noise on a body of a metre."""
    for body in ("in line", "right angle", "tripod"):
        proofs = []
        for _ in range(50):
            b, Q, body_, _, _ = problem(BODIES[body], rng.integers(2**32), 1.0, -1.7)
            proofs.append(bool(nearest_rotation(b, Q, body_).is_proved))
        assert np.mean(proofs) > 0.9, body


def test_a_stack_of_measurements(rng):
    b, Q, body, _, _ = problem(BODIES["right angle"], 5, 1.0, -1.0)
    b = b + 0.1 * rng.standard_normal((2, 3, 2, 3))
    found = nearest_rotation(b, Q, body)
    assert found.rotation.shape == (2, 3, 3, 3)
    assert found.misfit.shape == found.is_proved.shape == (2, 3)
    assert np.isclose(found.misfit[1, 2], nearest_rotation(b[1, 2], Q, body).misfit)


def test_the_rotations_of_the_cube():
    R = np.reshape(rotations_of_the_cube(), (24, 3, 3))
    assert len({tuple(matrix.ravel()) for matrix in R}) == 24
    assert np.allclose(R @ R.mT, np.eye(3))
    assert np.allclose(np.linalg.det(R), 1.0)
    traces = np.einsum("nij,mij->nm", GRID, R).max(axis=1)
    assert np.degrees(np.arccos((traces.min() - 1) / 2)) < 63


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"body": [[0.0, 1.0], [1.0, 0.0]]}, r"body must have shape \(k, 3\)"),
        ({"body": [[0.0, 1.0, 0.0], [0.0, 0.0, 0.0]]}, "baseline 1 of the body has length zero"),
        ({"body": [[0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]}, "has length zero"),
        ({"body": [[0.0, np.nan, 0.0], [1.0, 0.0, 0.0]]}, "body contains NaN"),
        ({"b": np.zeros((3, 3))}, "one baseline"),
        ({"b": np.full((2, 3), np.inf)}, "must be finite"),
        ({"Q_b": np.eye(3)}, r"Q_b must have shape \(6, 6\)"),
        ({"Q_b": np.diag([1.0, 1.0, 1.0, 1.0, 1.0, -1.0])}, "not positive definite"),
    ],
)
def test_bad_input_is_told_in_a_sentence(change, words):
    good = {"b": np.eye(3)[:2], "Q_b": np.eye(6), "body": np.eye(3)[:2]}
    with pytest.raises(ValueError, match=words):
        nearest_rotation(**{**good, **change})


def test_arguments_are_left_alone():
    b, Q, body = np.eye(3)[:2], np.eye(6), np.eye(3)[:2]
    for array in (b, Q, body):
        array.flags.writeable = False
    nearest_rotation(b, Q, body)
