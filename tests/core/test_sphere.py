"""The nearest point of a sphere: against the roots of a polynomial, against points of the sphere, and the hard case."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gnsslab.core.jit import kernel_input
from gnsslab.core.sphere import nearest_on_sphere, principal_axes

cases = st.tuples(st.integers(1, 4), st.integers(0, 2**32 - 1), st.floats(0.0, 4.0), st.floats(-2.0, 1.0))  # p, seed, decades of Q and of l


def problem(p, seed, decades, size):
    rng = np.random.default_rng(seed)
    axes = np.linalg.qr(rng.standard_normal((p, p)))[0]
    Q = axes @ np.diag(10.0 ** rng.uniform(-decades, 0.0, p)) @ axes.T
    return rng.standard_normal(p), (Q + Q.T) / 2, 10.0**size, rng


def cost_of(b, c, Q):
    return np.vecdot(b - c, np.linalg.solve(Q, (b - c).T).T)


def least_by_polynomial(c, Q, length):
    """Return the least cost over all stationary points: the real roots of the secular equation, multiplied out.

    sum c_i^2 prod over j != i of (1 + nu q_j)^2 = l^2 prod over j of (1 + nu q_j)^2
    """
    q, V = np.linalg.eigh(Q)
    factors = [np.polynomial.Polynomial([1.0, r]) ** 2 for r in q / q[-1]]
    whole = length**2 * np.prod(factors)
    for i, c_i in enumerate(V.T @ c):
        whole = whole - c_i**2 * np.prod([factors[j] for j in range(len(q)) if j != i] + [np.polynomial.Polynomial([1.0])])
    roots = whole.roots()
    nu = roots.real[abs(roots.imag) < 1e-4 * (1 + abs(roots))]
    b = (V @ ((V.T @ c)[:, None] / (1 + nu * (q / q[-1])[:, None]))).T
    b = b[np.isclose(np.linalg.norm(b, axis=1), length, rtol=1e-2)]
    b *= length / np.linalg.norm(b, axis=1, keepdims=True)
    return cost_of(b, c, Q).min()


@settings(max_examples=150, deadline=None)
@given(cases)
def test_it_lies_on_the_sphere_and_costs_what_is_said(case):
    c, Q, length, _ = problem(*case)
    found = nearest_on_sphere(c, Q, length)
    assert np.isclose(np.linalg.norm(found.b), length, rtol=1e-12)
    assert np.isclose(found.cost, cost_of(found.b, c, Q), rtol=1e-8, atol=1e-12)


@settings(max_examples=60, deadline=None)
@given(cases)
def test_no_other_point_is_nearer(case):
    c, Q, length, rng = problem(*case)
    found = nearest_on_sphere(c, Q, length)
    anywhere = rng.standard_normal((2000, len(c)))
    nearby = found.b + length * 0.01 * rng.standard_normal((2000, len(c)))
    points = np.vstack([anywhere, nearby])
    points *= length / np.linalg.norm(points, axis=1, keepdims=True)
    assert np.all(cost_of(points, c, Q) >= found.cost * (1 - 1e-9))


@pytest.mark.parametrize("p", [2, 3, 4])
@pytest.mark.parametrize("decades", [0.5, 2.0])
def test_equals_the_best_root_of_the_polynomial(p, decades, rng):
    for _ in range(30):
        c, Q, length, _ = problem(p, rng.integers(2**32), decades, rng.uniform(-0.5, 0.5))
        assert np.isclose(nearest_on_sphere(c, Q, length).cost, least_by_polynomial(c, Q, length), rtol=1e-4)


def test_hard_case_by_hand():
    """c lies on the short axis, 0.3 m out: b = (sqrt(1 - 0.4^2), 0.3 / (1 - 1/4)), cost 0.84 / 4 + 0.1^2."""
    found = nearest_on_sphere([0.0, 0.3], np.diag([4.0, 1.0]), 1.0)
    assert np.allclose(abs(found.b), [np.sqrt(0.84), 0.4], rtol=1e-14)
    assert np.isclose(found.cost, 0.84 / 4 + 0.01, rtol=1e-14)


@pytest.mark.parametrize("along", [1e-3, 1e-8, 1e-15, 1e-200, 0.0])
def test_nothing_happens_suddenly_near_the_hard_case(along):
    found, hard = (nearest_on_sphere([x, 0.3], np.diag([4.0, 1.0]), 1.0) for x in (along, 0.0))
    assert np.allclose(found.b, hard.b, atol=2 * along + 1e-14)
    assert np.isclose(found.cost, hard.cost, atol=along + 1e-14)


def test_centre_of_a_ball_is_equally_far_from_everywhere():
    found = nearest_on_sphere(np.zeros(3), 0.25 * np.eye(3), 2.0)
    assert np.isclose(np.linalg.norm(found.b), 2.0)
    assert np.isclose(found.cost, 16.0)


def test_equal_axes_mean_scaling():
    assert np.allclose(nearest_on_sphere([1.0, 2.0, 2.0], np.eye(3), 1.5).b, [0.5, 1.0, 1.0])


def test_unequal_axes_do_not():
    """A needle along east: going east costs little, so the answer is far from c scaled to the length."""
    c, Q = np.array([0.2, 0.8]), np.diag([1.0, 1e-4])
    assert np.allclose(nearest_on_sphere(c, Q, 1.0).b, [0.6, 0.8], atol=1e-3)  # 0.6^2 + 0.8^2 = 1


def test_stack_equals_one_by_one(rng):
    c, Q = rng.standard_normal((2, 3, 3)), problem(3, 5, 2.0, 0.0)[1]
    c.flags.writeable = False
    together = nearest_on_sphere(c, Q, 1.1)
    assert together.b.shape == (2, 3, 3)
    for index in np.ndindex(2, 3):
        assert np.array_equal(together.b[index], nearest_on_sphere(c[index], Q, 1.1).b)


@settings(max_examples=100, deadline=None)
@given(st.integers(1, 6), st.integers(0, 2**32 - 1), st.floats(0.0, 10.0))
def test_principal_axes_rebuild_the_matrix(p, seed, decades):
    _, Q, _, _ = problem(p, seed, decades, 0.0)
    q, V = kernel_input(np.zeros(p)), kernel_input(np.zeros((p, p)))
    principal_axes(kernel_input(Q.copy()), q, V)
    q, V = np.asarray(q), np.asarray(V)
    assert np.allclose(V @ V.T, np.eye(p), atol=1e-13)
    assert np.allclose(V.T @ np.diag(q) @ V, Q, atol=1e-14 * p)
    assert np.allclose(np.sort(q), np.linalg.eigvalsh(Q), atol=1e-14 * p)


@pytest.mark.parametrize(
    ("c", "Q", "length", "message"),
    [
        ([1.0, 0.0], np.eye(3), 1.0, "c must be"),
        ([1.0, 0.0], np.diag([1.0, 0.0]), 1.0, "not positive definite"),
        ([1.0, 0.0, 0.0], np.outer([1.0, 0.3, 0.7], [1.0, 0.3, 0.7]) + np.diag([0.0, 1.0, 0.0]), 1.0, "not positive definite"),
        ([1.0, np.nan], np.eye(2), 1.0, "NaN"),
        ([1.0, 0.0], [[1.0, 0.5], [0.4, 1.0]], 1.0, "Q is not symmetric"),
        ([1.0, 0.0], np.eye(2), 0.0, "positive number of metres; it is 0"),
    ],
)
def test_bad_calls_are_explained(c, Q, length, message):
    with pytest.raises(ValueError, match=message):
        nearest_on_sphere(c, Q, length)
