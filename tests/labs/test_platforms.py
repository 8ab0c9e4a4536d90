"""The lab of moving platforms: what a time offset does and what its correction leaves, against formulas worked out here."""

from functools import cache

import numpy as np
import pytest

from gnsslab.labs.platforms import platforms_lab

LAB = platforms_lab()


@cache
def run(**settings):
    return LAB.run(**settings)


def preset(name):
    return run(**LAB.preset(name).settings)


def readout(result, label):
    return float(next(one.value for one in LAB.readouts(result) if one.label == label))


def test_an_offset_across_the_way_turns_the_heading_by_the_angle_of_the_way_driven():
    result = preset("offset")
    way = result.journey.speed * 0.05  # [m] that the master drives until the rover measures
    turned = np.degrees(np.abs(result.heading_error))
    expected = np.degrees(np.arctan2(way, result.settings["length"]))
    assert result.is_fixed.all()
    np.testing.assert_allclose(turned, expected, atol=2.5)  # slopes and curves take the way out of the level by that much
    assert readout(result, "Uncorrected offset") == pytest.approx(np.degrees(np.arctan(result.journey.speed.max() * 0.05)), abs=0.01)


def test_the_correction_takes_it_away():
    settings = LAB.preset("offset").settings
    corrected = run(**settings | {"correction": True})
    without_offset = run(**settings | {"time_offset": 0, "correction": True})
    assert readout(corrected, "Heading error") < 1.2 * readout(without_offset, "Heading error")
    assert not corrected.is_wrong.any()


def test_an_offset_along_the_way_makes_the_baseline_longer_and_keeps_the_heading():
    result = preset("offset-along")
    longer = result.attitude.length - result.settings["length"]
    np.testing.assert_allclose(longer, result.journey.speed * 0.05, atol=0.05)
    assert readout(result, "Heading error") < 1.0
    assert result.is_wrong.all()


def test_a_vector_without_the_known_length_is_not_fixed():
    assert preset("offset-length").problem or not preset("offset-length").is_fixed.any()


def test_a_second_of_doppler_velocity_makes_centimetres():
    result = preset("second")
    off = np.linalg.norm(result.attitude.baseline_enu - result.journey.baseline_enu, axis=1)[result.is_fixed]
    assert 0.02 < np.median(off) < 0.3, "five centimetres a second of each Doppler, some of them low"
    sigma = np.degrees(np.median(result.attitude.sigma_heading))
    assert sigma / 2 < readout(result, "Heading error") < 2 * sigma, "and the engine says so"


def test_sigma_goes_as_one_over_the_length():
    ratio = readout(preset("short"), "Heading error") / readout(preset("car"), "Heading error")
    assert ratio == pytest.approx(1 / 0.3, rel=0.2)


def test_the_rate_is_that_of_the_turntable():
    result = preset("turntable")
    turning = result.seconds > 55
    assert np.degrees(np.nanmedian(result.rate.rate[turning])) == pytest.approx(6.0, abs=0.02)
    assert np.degrees(np.nanmedian(result.true_rate[turning])) == pytest.approx(6.0, abs=0.02)
    assert readout(result, "Heading rate") < 0.3


def test_the_city_hides_satellites_and_gives_them_back():
    result = preset("city")
    assert len(result.seconds) < 250, "nothing is recorded under the bridge"
    assert not result.is_wrong.any()
    in_streets = ((result.seconds >= 60) & (result.seconds <= 110)) | ((result.seconds >= 190) & (result.seconds <= 240))
    assert result.is_fixed[~in_streets].mean() > 0.95
    assert result.attitude.satellites[in_streets].max() < result.attitude.satellites[~in_streets].max()
    alone = preset("city-alone")
    assert alone.is_fixed.mean() < 0.15
    assert alone.is_wrong.sum() > alone.is_fixed.sum() / 2


def test_what_other_presets_say():
    assert readout(preset("ship"), "Heading error") < 0.65 * readout(preset("car"), "Heading error")
    assert preset("everything").is_fixed.all()
    assert preset("car").is_fixed.all()


def test_goals_can_be_reached_and_are_not_given():
    for name, settings in (("short-arm", {"length": 0.5, "systems": "GECJ"}), ("half-a-second", {"time_offset": 500, "length": 2})):
        judge = LAB.goal(name).judge
        assert judge(run())[0] is False
        result = run(**settings)
        assert judge(result)[0] is True
