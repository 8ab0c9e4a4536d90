"""Motion: transition and process noise by what they must do together, whatever the step."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from small_observations import times

from gnsslab.gnss import motion

STEPS = st.floats(0.01, 9.9)  # [s]
NEAR = np.array([1.0, 2.0, 3.0])


def path_of(kind, seconds, **options):
    """Return the Path over epochs at so many seconds."""
    time = times(np.round(np.asarray(seconds) * 1000).astype(int))
    return kind(time, np.tile(NEAR, (len(time), 1)), **options)


@settings(deadline=None)
@given(dt=STEPS, q=st.floats(0.01, 30))
def test_process_noise_is_the_integral_of_white_acceleration(dt, q):
    """Q = integral over s of F(s) G q^2 G' F(s)', by Simpson's rule, which is exact for the cubic powers that stand in it."""
    dt = round(dt, 3)
    path = path_of(motion.moving, [0, dt], acceleration=q)
    G = np.vstack([np.zeros((3, 3)), np.eye(3)])

    def integrand(s):
        F = np.eye(6)
        F[:3, 3:] = s * np.eye(3)
        return q**2 * F @ G @ G.T @ F.T

    simpson = dt / 6 * (integrand(0.0) + 4 * integrand(dt / 2) + integrand(dt))
    np.testing.assert_allclose(path.Q[1], simpson, rtol=1e-9)


@settings(deadline=None)
@given(a=STEPS, b=STEPS)
def test_two_steps_are_one(a, b):
    a, b = round(a, 3), round(b, 3)
    path = path_of(motion.moving, [0, a, a + b], longest_gap=100.0)
    whole = path_of(motion.moving, [0, a + b], longest_gap=100.0)
    np.testing.assert_allclose(path.F[2] @ path.F[1], whole.F[1], rtol=1e-9)
    np.testing.assert_allclose(path.F[2] @ path.Q[1] @ path.F[2].T + path.Q[2], whole.Q[1], rtol=1e-9)
    assert path.drift[1:].sum() == pytest.approx(whole.drift[1])


def test_a_moving_rover_keeps_its_velocity_and_starts_anew_after_a_long_gap():
    path = path_of(motion.moving, [0, 1, 2, 14, 15])
    for start in (0, 3):
        assert not path.F[start].any()
        assert path.offset[start].tolist() == [1, 2, 3, 0, 0, 0]
        assert np.sqrt(path.Q[start].diagonal()[:3]).tolist() == [motion.SIGMA_OPEN] * 3
    for step in (1, 2, 4):
        assert (path.F[step] @ [5, 5, 5, 1, 2, 3]).tolist() == [6, 7, 8, 1, 2, 3]
        assert not path.offset[step].any()


def test_epochs_half_a_minute_apart_are_no_gap():
    path = path_of(motion.moving, [0, 30, 60, 90, 150])
    assert [bool(F.any()) for F in path.F] == [False, True, True, True, False]


def test_what_stands_still_is_opened_once_and_never_moved():
    path = path_of(motion.static, [0, 1, 100])
    assert path.offset.tolist() == [[1, 2, 3], [0, 0, 0], [0, 0, 0]]
    assert (path.F[1:] == np.eye(3)).all()
    assert not path.Q[1:].any()
    assert path.drift.tolist() == pytest.approx([0.0, motion.AMBIGUITY_DRIFT**2, 99 * motion.AMBIGUITY_DRIFT**2])


def test_single_epochs_know_nothing_of_each_other():
    path = path_of(motion.forgetful, [0, 1, 2])
    assert not path.F.any()
    assert (path.offset == NEAR).all()
    assert (motion.SIGMA_OPEN**2 * np.eye(3) == path.Q).all()


@pytest.mark.parametrize("kind", [motion.moving, motion.static, motion.forgetful])
def test_one_epoch_is_enough_and_nothing_given_is_changed(kind):
    near = NEAR[None].copy()
    near.flags.writeable = False
    path = kind(times([0]), near)
    assert path.offset[0, :3].tolist() == NEAR.tolist()
    path.offset[0, 0] = 99.0
    assert near[0, 0] == 1.0
