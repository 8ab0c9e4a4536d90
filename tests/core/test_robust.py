"""Equivalent weights: by hand, as numpy writes them, their known efficiencies, and what a bad threshold is told."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.stats import norm

import gnsslab
from gnsslab.core.robust import Weight, danish, danish_weight, huber, huber_weight, igg3, igg3_weight, tukey, tukey_weight

THRESHOLDS = st.floats(1e-3, 1e3)
MAKERS = (huber, tukey, danish, lambda c: igg3(c, 1.7 * c))
WEIGHTS = st.builds(lambda make, c: make(c), st.sampled_from(MAKERS), THRESHOLDS)


def in_numpy(v, c):
    """Return the four weights as they are printed; IGG III with k1 = 2 c."""
    size = np.abs(v)
    with np.errstate(all="ignore"):
        return {
            huber: np.where(size <= c, 1.0, c / size),
            tukey: np.where(size < c, (1 - (v / c) ** 2) ** 2, 0.0),
            danish: np.where(size <= c, 1.0, np.exp(1 - (v / c) ** 2)),
            igg3: np.select([size <= c, size < 2 * c], [1.0, c / size * ((2 * c - size) / c) ** 2], 0.0),
        }


@pytest.mark.parametrize(
    ("k0", "k1", "v", "eta"),
    [(1, 2, 1.5, 1 / 6), (2, 5, 2.5, 5 / 9), (2, 5, 3, 8 / 27), (2, 5, 3.5, 1 / 7), (2, 5, 4, 1 / 18), (1.5, 3, 2.25, 1 / 6), (1.5, 3, 3, 0)],
)
def test_igg3_by_hand(k0, k1, v, eta):
    assert igg3_weight([v, -v], k0, k1) == pytest.approx([eta, eta], rel=1e-14)


@given(v=st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=9), c=THRESHOLDS)
def test_each_weight_is_the_formula_as_printed(v, c):
    printed = in_numpy(np.array(v), c)
    for made in (huber, tukey, danish):
        np.testing.assert_allclose(made(c)(v), printed[made], rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(igg3(c, 2 * c)(v), printed[igg3], rtol=1e-9, atol=1e-12)


@given(weight=WEIGHTS, v=st.floats(0, 1e6), more=st.floats(0, 1e6))
def test_a_weight_is_1_at_0_even_and_never_rises(weight, v, more):
    eta = weight([0.0, v, -v, v + more])
    assert eta[0] == 1.0
    assert eta[1] == eta[2]
    assert 0.0 <= eta[3] <= eta[1] <= 1.0


@given(weight=WEIGHTS)
def test_no_weight_jumps(weight):
    for knot in weight.thresholds:
        if math.isfinite(knot):
            below, above = weight([knot * (1 - 1e-9), knot * (1 + 1e-9)])
            assert abs(below - above) < 1e-7


def test_any_shape_and_what_is_nan_stays_so():
    v = np.array([[0.0, np.nan, np.inf], [1.0, -3.0, -np.inf]])
    v.flags.writeable = False
    eta = huber_weight(v, 1.5)
    assert eta.shape == (2, 3)
    assert np.isnan(eta[0, 1])
    assert eta[0, 2] == eta[1, 2] == 0.0
    assert np.ndim(tukey_weight(1.0, 4.685)) == 0
    assert danish_weight([], 2.0).shape == (0,)
    assert igg3_weight(np.inf, 1.0, 2.0) == 0.0
    assert (Weight()(v[:, :1]) == 1.0).all()


def efficiency(weight, edges):
    """Return the efficiency of the M-estimate of a mean from normal values, (E psi')^2 / E psi^2, with E psi' = E v psi (Stein)."""

    def expect(function):
        return sum(quad(lambda v: function(v) * norm.pdf(v), low, high)[0] for low, high in pairwise(edges))

    return expect(lambda v: v * v * weight(v)) ** 2 / expect(lambda v: (v * weight(v)) ** 2)


def test_the_usual_thresholds_cost_five_percent_of_good_data():
    """1.345 and 4.685 are known as the thresholds of 95 % efficiency (Holland and Welsch 1977)."""
    assert efficiency(huber(1.345), (-9, -1.345, 1.345, 9)) == pytest.approx(0.95, abs=5e-4)
    assert efficiency(tukey(4.685), (-4.685, 4.685)) == pytest.approx(0.95, abs=5e-4)


def test_one_and_two_sigma_lower_a_third_of_good_data(rng):
    """The paper's 1 and 2: 31.7 % of normal values count less and 4.6 % for nothing."""
    eta, N = igg3_weight(rng.standard_normal(100_000), 1, 2), 100_000
    for share, promised in ((np.mean(eta < 1), 0.3173), (np.mean(eta == 0), 0.0455)):
        assert abs(share - promised) < 4 * math.sqrt(promised * (1 - promised) / N)


@pytest.mark.parametrize(("k0", "k1"), [(2, 1), (1, 1), (0, 2), (-1, 2), (1, math.inf), (math.nan, 2), ([1, 2], 3)])
def test_igg3_says_which_thresholds_it_expects(k0, k1):
    with pytest.raises(ValueError, match="IGG III expects 0 < k0 < k1"):
        igg3(k0, k1)


@pytest.mark.parametrize("make", [huber, tukey, danish])
@pytest.mark.parametrize("c", [0.0, -1.0, math.inf, math.nan])
def test_a_threshold_must_be_above_zero(make, c):
    with pytest.raises(ValueError, match="expects a threshold above zero and finite"):
        make(c)


def test_the_weights_stand_at_the_door():
    assert gnsslab.igg3_weight is igg3_weight
    assert gnsslab.huber_weight is huber_weight
