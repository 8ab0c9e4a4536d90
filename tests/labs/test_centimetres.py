"""Lab of float and fixed positions: corners, presets, promises kept, and what a shortcut or a misprint costs."""

from dataclasses import replace

import numpy as np
import pytest

from gnsslab.labs import centimetres
from gnsslab.labs.centimetres import DRAWN, simulate_epochs
from gnsslab.labs.epoch_solutions import float_solutions, middle
from gnsslab.labs.pair_epochs import choose_epochs, model_pair
from gnsslab.simulate import find_preset, simulate, write_simulation
from gnsslab.simulate.receivers import white_factor

LAB = "centimetres"
MM = 1e-3


@pytest.fixture(scope="module")
def at_presets(lab):
    """Results of all presets of simulated data, by name."""
    return {p.name: lab.run(**p.settings) for p in lab.presets if p.settings.get("data") != "real"}


def _right(result):
    return float(np.mean(result.is_right))


@pytest.mark.parametrize(("frequencies", "satellites", "epochs"), [(1, 8, 1), (2, 6, 1), (2, 5, 1), (3, 5, 1), (1, 8, 5)])
def test_integers_are_right_as_often_as_promised(lab, frequencies, satellites, epochs):
    """Bootstrapping's success rate is a lower bound for integer least squares: 4 sigma of a count below it at most, 6 % above."""
    result = lab.run(frequencies=frequencies, satellites=satellites, epochs=epochs)
    sigma = np.sqrt(result.promised * (1 - result.promised) / DRAWN)
    assert result.promised - 4 * sigma < _right(result) < result.promised + 0.06 + 4 * sigma


@pytest.mark.parametrize("epochs", [1, 20])
def test_clouds_are_as_wide_as_claimed(lab, epochs):
    """A variance of N draws is good to sqrt(2 / N) of itself."""
    result = lab.run(satellites=7, epochs=epochs)
    assert result.is_right.all()
    for enu, Q in ((result.float_enu, result.Q_float), (result.fixed_enu, result.Q_fixed)):
        np.testing.assert_allclose(np.mean(enu**2, axis=0), np.diag(Q), rtol=4 * np.sqrt(2 / DRAWN))


def test_integers_sharpen_by_code_over_carrier(lab):
    """Codes and carriers have one geometry, so Q_fixed = Q_float / (1 + (sigma_code / sigma_carrier)^2) exactly."""
    for code, carrier in ((0.3, 3), (1, 1), (0.1, 10)):
        result = lab.run(code_noise=code, carrier_noise=carrier)
        np.testing.assert_allclose(result.Q_fixed, result.Q_float / (1 + (code / (carrier * MM)) ** 2), rtol=1e-6)


def test_epochs_together_shrink_everything_by_the_root(lab):
    one, many = lab.run(), lab.run(epochs=25)
    assert many.adop == pytest.approx(one.adop / 5, rel=1e-9)
    np.testing.assert_allclose(many.Q_float, one.Q_float / 25, rtol=1e-9)
    np.testing.assert_allclose(many.float_enu, one.float_enu / 5, atol=1e-7)  # the same draws
    np.testing.assert_allclose(many.promised_over_span, one.promised_over_span, rtol=1e-9)  # the curve stays


def test_curve_passes_through_the_promise(lab):
    for epochs in (1, 12, 60):
        result = lab.run(epochs=epochs, frequencies=1)
        assert result.promised_over_span[list(result.span).index(epochs)] == pytest.approx(result.promised, rel=1e-9)


def test_diagonal_alone_is_rounding(lab):
    """Second route: the float ambiguities by hand from the codes' positions, rounded."""
    result = lab.run(belief="diagonal")
    epochs = simulate_epochs(result.settings)
    n = len(epochs.integers)
    toward = epochs.u[0][1:] - epochs.u[0][0]
    ranges = np.tile(-result.float_enu @ toward.T, (1, n // len(toward)))
    a_hat = (epochs.y[:, n:] - ranges) / np.repeat(epochs.wavelengths, len(toward))
    np.testing.assert_array_equal(result.is_right, (np.rint(a_hat) == epochs.integers).all(axis=1))
    assert _right(result) < 0.02 < 0.95 < _right(lab.run())


def test_wrong_fixes_lie_on_a_lattice_of_other_integers(lab):
    """The same wrong integers always put the position at the same place, but for the carrier's millimetres."""
    result = lab.run(frequencies=1, satellites=6, carrier_noise=1)
    wrong = result.fixed_enu[~result.is_right]
    apart = np.linalg.norm(wrong[:, None] - wrong, axis=-1)
    apart[np.arange(len(wrong)), np.arange(len(wrong))] = np.inf
    assert np.median(apart.min(axis=1)) < 10 * MM < 0.3 < np.median(np.linalg.norm(wrong, axis=1))


def test_presets_show_what_they_promise(at_presets):
    right = {name: _right(result) for name, result in at_presets.items()}
    assert 0.97 < right["start"] < 1  # "a few crosses"
    assert 0.25 < right["one-frequency"] < 0.40  # "two of three epochs are crosses"
    assert right["ten-epochs"] == 1  # "not a cross is left"
    assert 0.70 < right["five"] < 0.80  # "a quarter"
    assert right["three-frequencies"] > 0.95
    assert right["printed-code"] < 0.02 < 0.995 < at_presets["printed-code"].promised  # "99 of 100 fixes are wrong"
    assert right["cheap"] < 0.4
    spread = {name: np.sqrt(np.mean(result.float_enu[:, :2] ** 2)) for name, result in at_presets.items()}
    assert spread["five"] / spread["start"] == pytest.approx(1.5, abs=0.1)  # "grows by half"
    assert spread["one-frequency"] / spread["ten-epochs"] == pytest.approx(np.sqrt(10), rel=1e-6)  # "three times smaller"


def test_carrier_alone_is_refused_with_the_count(lab):
    result = lab.run(belief="carrier", satellites=6, frequencies=1)
    assert "5 carriers have 5 integers and 3 coordinates to find, 8 unknowns" in result.problem


@pytest.mark.parametrize(
    ("settings", "reached"),
    [
        ({}, False),  # two frequencies are against the rules
        ({"frequencies": 1, "satellites": 7}, False),
        ({"frequencies": 1, "satellites": 7, "epochs": 12, "mask": 20}, True),
        ({"frequencies": 1, "satellites": 7, "epochs": 13, "mask": 20}, False),
        ({"frequencies": 1, "satellites": 7, "epochs": 12, "mask": 20, "code_noise": 0.25}, False),
        ({"frequencies": 1, "satellites": 7, "epochs": 12, "mask": 20, "belief": "diagonal"}, False),
        ({"data": "mine"}, False),
    ],
)
def test_goal_is_judged(lab, settings, reached):
    assert lab.goal("thrifty").judge(lab.run(**settings))[0] == reached


def test_controls_without_effect_say_why(lab):
    assert set(lab.blocked(lab.settings())) == set(centimetres.FILES)
    assert {"seed"} <= set(lab.blocked(lab.settings(data="real")))


def test_fewer_satellites_than_asked_for_is_said(lab):
    result = lab.run(mask=30, satellites=6)
    assert "No more than 4 satellites stand above the mask" in result.note
    assert "lower the mask" in lab.run(mask=40).problem


def test_real_stations_find_their_integers(lab, dataset):
    dataset("geonet-0759-3040")
    one, two = (lab.run(**lab.preset(name).settings) for name in ("real-one", "real-two"))
    assert 0.4 < _right(one) < 0.9
    assert _right(two) == 1
    assert len(two.is_right) == 120
    assert np.linalg.norm(two.fixed_enu, axis=1).max() < 0.03  # about the baseline that the engine found with its own filter
    assert "Both receivers have L1+L2 only." in lab.run(data="real", frequencies=3).note
    assert "No more than 7 satellites" in lab.run(data="real", satellites=9).note


def test_real_epochs_together_shrink_less_than_the_root(lab, dataset):
    """Reflections last for minutes: sixty half-minutes are far fewer than sixty independent epochs."""
    dataset("geonet-0759-3040")
    one, many = (lab.run(data="real", frequencies=1, epochs=epochs).float_enu for epochs in (1, 60))
    assert len(many) == 61
    shrunk = np.sqrt(np.mean(one[:, :2] ** 2) / np.mean(many[:, :2] ** 2))
    assert 1.5 < shrunk < 0.6 * np.sqrt(60)


def test_real_float_positions_by_the_closed_form(lab, campaign):
    """Second route: in an epoch the codes alone give the position, b_hat = (B' W B)^-1 B' W y_code."""
    data = campaign("geonet-0759-3040")
    epochs = choose_epochs(model_pair(data.base, data.rover, data.ephemerides, 2), 6, np.radians(10), 5)
    growth = white_factor(epochs.elevation) / np.sqrt(5)
    found, result = float_solutions(epochs, 0.3 * growth, 3 * MM * growth), lab.run(data="real", satellites=6, epochs=5)
    np.testing.assert_allclose(result.float_enu, found.b_hat, atol=1e-6)
    np.testing.assert_allclose(result.Q_float, middle(found).Q_b, rtol=1e-6)


def test_own_files(lab, tmp_path):
    assert "your master, rover and navigation files are missing" in lab.run(data="mine").problem
    preset = replace(find_preset("static-rtk-5km"), duration=60.0, systems="G")
    write_simulation(tmp_path, simulate(preset, np.random.default_rng(5)))
    names = dict(zip(centimetres.FILES, ("master.obs", "rover.obs", "broadcast.nav"), strict=True))
    paths = {k: str(tmp_path / v) for k, v in names.items()}
    result = lab.run(data="mine", satellites=6, **paths)
    assert result.problem == ""
    assert len(result.is_right) == 60
    assert _right(result) > 0.9
    assert len(lab.run(data="mine", satellites=6, epochs=60, **paths).is_right) == 1
    assert "fewer than four satellites" in lab.run(data="mine", mask=40, **paths).problem
