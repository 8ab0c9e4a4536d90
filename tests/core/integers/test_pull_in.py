"""Pull-in regions: what lies in them is what the estimators say, they fill space once, and their mass is the success rate."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from obvious import covariance
from scipy.spatial import ConvexHull, HalfspaceIntersection

from gnsslab.core.integers import decorrelate, integer_bootstrapping, integer_least_squares, integer_rounding, ltdl, success_rate
from gnsslab.core.integers.pull_in import bootstrapping_region, chance_inside, corners_of, least_squares_region, rounding_region

NEEDLE = np.array([[53.4, 38.4], [38.4, 28.0]])  # test example of K. Borre (2002), programs to Strang and Borre: Linear Algebra, Geodesy, and GPS
cases = st.tuples(st.integers(1, 5), st.integers(0, 2**32 - 1), st.floats(0.0, 3.0))  # n, seed, decades of spread
planes = st.tuples(st.just(2), st.integers(0, 2**32 - 1), st.floats(0.0, 4.0))


def regions_of(Q):
    """Return pairs of a region and the function that gives an estimator's integers."""
    return (
        (rounding_region(len(Q)), integer_rounding),
        (bootstrapping_region(ltdl(Q).L), lambda x: integer_bootstrapping(x, Q)),
        (least_squares_region(Q), lambda x: integer_least_squares(x, Q, n_best=1).best),
    )


def problem(n, seed, decades):
    rng = np.random.default_rng(seed)
    return covariance(n, rng, decades), rng


@settings(max_examples=40, deadline=None)
@given(cases)
def test_a_point_lies_in_the_region_of_its_integers_and_in_no_other(case):
    Q, rng = problem(*case)
    x = rng.uniform(-4, 4, (50, len(Q)))
    others = rng.integers(-3, 4, (50, len(Q)))
    others = others[np.any(others != 0, axis=1)]
    for region, estimate in regions_of(Q):
        offset = x - estimate(x)
        assert region._replace(bounds=region.bounds * (1 + 1e-7) + 1e-9).contains(offset).all()
        inside = region._replace(bounds=region.bounds * (1 - 1e-7)).contains(offset)
        assert not region.contains(offset[inside][:, np.newaxis] + others).any()


@settings(max_examples=60, deadline=None)
@given(planes)
def test_each_cell_of_the_plane_has_area_one_and_is_symmetric(case):
    Q, _ = problem(*case)
    for region, _ in regions_of(Q):
        corners = corners_of(region)
        x, y = corners.T
        assert abs(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))) / 2 == pytest.approx(1.0, rel=1e-6)
        apart = np.linalg.norm(corners[:, np.newaxis] + corners, axis=-1)  # from each corner to the mirror image of each
        assert apart.min(axis=0).max() < 1e-6 * np.abs(corners).max()


@pytest.mark.parametrize("n", [3, 4])
def test_each_cell_of_space_has_volume_one(n, rng):
    """The volume by Qhull, which knows only the half spaces."""
    for _ in range(5):
        Q = covariance(n, rng, decades=1.5)
        for region, _ in regions_of(Q):
            half_spaces = np.vstack([np.column_stack([sign * region.normals, -region.bounds]) for sign in (1, -1)])
            corners = HalfspaceIntersection(half_spaces, np.zeros(n)).intersections
            assert ConvexHull(corners).volume == pytest.approx(1.0, rel=1e-6)


def test_hexagon_of_the_textbook_in_decorrelated_space():
    """By hand, in the metric of [[4.8, 1.2], [1.2, 4.6]]: the corners are as far from (0, 0) as from two neighbours."""
    Z = decorrelate(NEEDLE).Z
    Q = Z.T @ NEEDLE @ Z
    corners = corners_of(least_squares_region(Q))
    assert len(corners) == 6
    steps = np.array([[i, j] for i in (-1, 0, 1) for j in (-1, 0, 1) if (i, j) != (0, 0)])
    for corner in corners:
        away = corner - steps
        norms = np.einsum("ki,ki->k", away, np.linalg.solve(Q, away.T).T)
        own = corner @ np.linalg.solve(Q, corner)
        assert np.sum(np.abs(norms - own) < 1e-9) == 2
        assert norms.min() > own - 1e-9


def test_without_correlation_all_three_are_squares():
    square = {(-0.5, -0.5), (-0.5, 0.5), (0.5, -0.5), (0.5, 0.5)}
    for region, _ in regions_of(np.diag([2.0, 0.3])):
        assert {tuple(corner) for corner in corners_of(region).round(9)} == square


@settings(max_examples=30, deadline=None)
@given(st.tuples(st.sampled_from([2, 3]), st.integers(0, 2**32 - 1), st.floats(0.0, 1.5)))
def test_chance_of_bootstrapping_is_the_published_product(case):
    Q, _ = problem(*case)
    decorrelation = decorrelate(Q)
    Q_z = decorrelation.Z.T @ Q @ decorrelation.Z
    assert chance_inside(bootstrapping_region(decorrelation.L), Q_z) == pytest.approx(float(success_rate(Q)), abs=2e-4)


@settings(max_examples=30, deadline=None)
@given(st.tuples(st.sampled_from([2, 3]), st.integers(0, 2**32 - 1), st.floats(0.0, 1.5)))
def test_rounding_is_right_less_often_than_bootstrapping_than_least_squares(case):
    Q, _ = problem(*case)
    rounding, bootstrapping, least_squares = (chance_inside(region, Q) for region, _ in regions_of(Q))
    assert rounding <= bootstrapping + 2e-4 <= least_squares + 4e-4


def test_chances_are_counted(rng):
    N = 100_000
    for Q in (NEEDLE / 30, np.array([[6.290, 5.978, 0.544], [5.978, 6.292, 2.340], [0.544, 2.340, 6.288]]) / 10):
        x = rng.multivariate_normal(np.zeros(len(Q)), Q, N)
        for region, estimate in regions_of(Q):
            promised, counted = chance_inside(region, Q), np.mean(~estimate(x).any(axis=1))
            assert abs(counted - promised) < 4 * np.sqrt(promised * (1 - promised) / N) + 5e-4  # and what the sum over directions leaves


def test_needs_are_said():
    with pytest.raises(ValueError, match="10 ambiguities at most; there are 11"):
        least_squares_region(np.eye(11))
    with pytest.raises(ValueError, match="a polygon has two coordinates; this region has 3"):
        corners_of(rounding_region(3))
    with pytest.raises(ValueError, match="two or three ambiguities; there are 4"):
        chance_inside(rounding_region(4), np.eye(4))
