"""Lab of the spectrum: corners, presets, the fall after the third, and what decorrelation saves."""

import numpy as np
import pytest

from gnsslab.core.integers import adop, decorrelate, success_bounds, success_rate
from gnsslab.labs.skies import open_sky
from gnsslab.labs.spectrum import NODE_LIMIT, SEARCHES, _float_ambiguities

LAB = "spectrum"


@pytest.mark.parametrize("sats", [5, 8, 11])
@pytest.mark.parametrize("bands", [1, 2, 3])
def test_spectrum_falls_after_the_third_whatever_n(lab, sats, bands):
    """Three coordinates come from the codes alone: three ambiguities are as uncertain as the codes, the others as the carriers."""
    result = lab.run(sats=sats, bands=bands)
    assert result.n == bands * (sats - 1)
    first, rest = result.before.sigma[:3], result.before.sigma[3:]
    assert first.min() > 2 * rest.max()
    assert np.exp(np.mean(np.log(first))) > 10 * np.exp(np.mean(np.log(rest)))
    if sats > 5:  # with four differences on one frequency one is left
        assert np.ptp(np.log(result.after.sigma)) < 0.6 * np.ptp(np.log(result.before.sigma))


def test_adop_is_the_geometric_mean_of_both(lab):
    result = lab.run(sats=9, bands=2)
    for sigma in (result.before.sigma, result.after.sigma):
        assert np.exp(np.mean(np.log(sigma))) == pytest.approx(result.adop, rel=1e-6)


def test_chances_are_the_librarys(lab):
    settings = lab.settings(sats=10)
    sky = open_sky("G", settings["lowest"], "2024-06-24T08:20:00").spread(10)
    _, Q_a = _float_ambiguities(settings, sky)
    result = lab.run(**settings)
    assert result.before.chance == pytest.approx(float(success_bounds(Q_a).bootstrapped), rel=1e-9)
    assert result.after.chance == pytest.approx(float(success_rate(Q_a)), rel=1e-9)
    assert result.adop == pytest.approx(float(adop(Q_a)))
    np.testing.assert_allclose(result.after.sigma, np.sqrt(decorrelate(Q_a).d)[::-1])


def test_no_search_is_shorter_than_straight_down(lab):
    """Down to the first candidate (n), to the second (1 or more), and back up (n)."""
    for settings in ({}, {"bands": 2}, {"together": 60}, {"sats": 11, "bands": 3}):
        result = lab.run(**settings)
        assert min(result.before.nodes.min(), result.after.nodes.min()) >= 2 * result.n


def test_decorrelation_saves_nodes_by_hundreds(lab):
    for name, factor in (("seven", 200), ("fourteen", 1000), ("thirty", 5000)):
        result = lab.run(**lab.preset(name).settings)
        assert np.median(result.before.nodes) > factor * np.median(result.after.nodes), name


def test_presets_show_what_they_promise(lab):
    result = {p.name: lab.run(**p.settings) for p in lab.presets}
    assert result["seven"].before.sigma[2] / result["seven"].before.sigma[3] == pytest.approx(20, abs=3)  # "a factor of twenty"
    assert 10_000 < np.median(result["seven"].before.nodes) < 20_000  # "thousands"
    assert 25 < np.median(result["seven"].after.nodes) < 40  # "thirty"
    assert 0 < result["thirty"].before.stopped < SEARCHES  # "some do not end"
    assert result["thirty"].after.stopped == 0
    assert np.median(result["thirty"].after.nodes) < 1.1 * (2 * 30 + 1)
    assert result["without"].after is None
    np.testing.assert_allclose(result["sixty"].before.sigma, result["seven"].before.sigma / np.sqrt(60), rtol=1e-6)
    assert result["poor-code"].before.sigma[2] / result["poor-code"].before.sigma[3] > 100  # "a cliff"


def test_a_search_that_was_stopped_is_said(lab):
    result = lab.run(**lab.preset("thirty").settings)
    assert (result.before.nodes <= NODE_LIMIT).all()
    assert f"{result.before.stopped} of {SEARCHES} stopped at 500" in str(lab.readouts(result))


def test_few_satellites_above_the_mask_are_said(lab):
    assert "No more than 5 satellites stand above the mask" in lab.run(lowest=30).note


@pytest.mark.parametrize(
    ("settings", "reached"),
    [
        ({}, False),
        ({"sats": 9, "together": 60}, True),
        ({"sats": 9, "together": 60, "decorrelated": False}, False),
        ({"sats": 9, "together": 60, "code": 0.25}, False),
        ({"sats": 9, "together": 60, "bands": 2}, False),
    ],
)
def test_goal_is_judged(lab, settings, reached):
    assert lab.goal("straight").judge(lab.run(**settings))[0] == reached
