"""Lab of the cells: corners, presets, promises; and what is drawn worked out a second way."""

import numpy as np
import pytest

from gnsslab.core.integers import integer_least_squares, success_bounds
from gnsslab.gnss.signals import wavelength
from gnsslab.labs import cells
from gnsslab.labs.cells import DRAWS, ESTIMATORS
from gnsslab.labs.skies import open_sky

LAB = "cells"
FLOATS = ("float_1", "float_2", "float_3")


@pytest.fixture(scope="module")
def at_presets(lab):
    """Results of all presets, by name."""
    return {preset.name: lab.run(**preset.settings) for preset in lab.presets}


def _right(result):
    """Return by estimator whether its answer is right."""
    return {answer.name: answer.is_right for answer in result.answers}


def _inside(point, corners):
    """Return whether a point lies inside a convex polygon, by the side of each edge on which it lies."""
    edges, to_point = np.roll(corners, -1, axis=0) - corners, point - corners
    sides = edges[:, 0] * to_point[:, 1] - edges[:, 1] * to_point[:, 0]
    return (sides >= -1e-9).all() or (sides <= 1e-9).all()


@pytest.mark.parametrize("estimator", ESTIMATORS)
@pytest.mark.parametrize("settings", [{}, {"ambiguities": 3, "epochs": 10}, {"covariance": "satellites", "epochs": 1}])
@pytest.mark.parametrize("decorrelated", [False, True])
def test_the_float_point_lies_in_the_cell_of_the_answer(lab, rng, estimator, settings, decorrelated):
    for floats in rng.uniform(-1, 1, (20, 3)):
        result = lab.run(**dict(zip(FLOATS, floats.tolist(), strict=True)), estimator=estimator, decorrelated=decorrelated, **settings)
        answer = next(answer for answer in result.answers if answer.name == estimator)
        assert _inside(result.plane.centre, answer.integers[:2] + result.plane.corners)


@pytest.mark.parametrize("estimator", ESTIMATORS)
@pytest.mark.parametrize("ambiguities", [2, 3])
def test_a_draw_is_right_exactly_where_it_lies_in_the_true_cell(lab, estimator, ambiguities):
    plane = lab.run(estimator=estimator, ambiguities=ambiguities, float_1=0.1, float_2=0.1, float_3=0.1, draws=True).plane
    assert plane.third == (None if ambiguities == 2 else 0)
    assert len(plane.dots) > 100
    assert [_inside(dot, plane.corners) for dot in plane.dots] == plane.dots_right.tolist()


@pytest.mark.parametrize("covariance", ["textbook", "satellites", "frequencies", "independent"])
@pytest.mark.parametrize("ambiguities", [2, 3])
@pytest.mark.parametrize("decorrelated", [False, True])
def test_answers_are_right_as_often_as_promised(lab, covariance, ambiguities, decorrelated):
    """4.5 sigma of a count of a thousand; bootstrapping's promise is the published product besides."""
    result = lab.run(covariance=covariance, ambiguities=ambiguities, decorrelated=decorrelated, epochs=10 if covariance == "textbook" else 2)
    for answer in result.answers:
        sigma = np.sqrt(answer.promised * (1 - answer.promised) / DRAWS)
        assert abs(answer.counted - answer.promised) < 4.5 * sigma + 1.5 / DRAWS, answer.name
    assert result.answers[1].promised == pytest.approx(float(success_bounds(result.space.Q).bootstrapped), abs=1e-3)


def test_of_three_the_plane_is_that_of_the_first_two_given_the_third(lab):
    """Conditional mean and covariance by the textbook's formula, with the covariance itself."""
    result = lab.run(ambiguities=3, epochs=10, float_1=0.48, float_2=0.18, float_3=-0.58)
    Q, plane = cells.LGR_12 / 10, result.plane
    gain = Q[:2, 2] / Q[2, 2]
    np.testing.assert_allclose(plane.centre, [0.48, 0.18] - gain * (-0.58 - plane.third))
    np.testing.assert_allclose(plane.Q, Q[:2, :2] - np.outer(gain, Q[2, :2]))
    own = (-0.58 - plane.third) ** 2 / Q[2, 2]
    assert plane.touching == pytest.approx(result.norms[0] - own)  # the best squared norm, less the third one's share


def test_rounding_pays_no_heed_to_the_third(lab):
    plane = lab.run(ambiguities=3, epochs=10, estimator="rounding", float_3=0.9).plane
    assert plane.third == 1
    assert plane.centre.tolist() == [1.5, 1.1]
    np.testing.assert_allclose(plane.Q, cells.LGR_12[:2, :2] / 10)
    assert plane.touching is None


def test_decorrelated_it_is_the_same_experiment(lab, at_presets):
    for name in at_presets:
        settings = lab.preset(name).settings
        plain, other = (lab.run(**settings | {"decorrelated": flag}) for flag in (False, True))
        best, best_z = (result.answers[2] for result in (plain, other))
        assert other.space.back @ best_z.integers == pytest.approx(best.integers)
        assert best.counted == best_z.counted
        np.testing.assert_allclose(plain.norms, other.norms, rtol=1e-9)
        assert len(plain.tree.nodes) == other.nodes_otherwise
        assert len(other.tree.nodes) <= len(plain.tree.nodes)


def test_on_a_track_the_covariance_is_that_of_the_closed_form(lab):
    """Carriers give the ambiguities once the codes have given the way: Q_a = (Q_phase + B Q_b B') / lambda^2."""
    result = lab.run(covariance="satellites", ambiguities=3, epochs=4, code_noise=0.2, carrier_noise=6)
    B = -np.diff(open_sky("G").spread(4).u[:, 1][[0, 1, 0, 2, 0, 3]])[::2]  # north, less that of the first
    pattern = 2 * (np.eye(3) + 1)
    Q_code, Q_phase = 0.2**2 * pattern / 4, 0.006**2 * pattern / 4
    Q_b = 1 / (B @ np.linalg.solve(Q_code, B))
    np.testing.assert_allclose(result.space.Q, (Q_phase + Q_b * np.outer(B, B)) / wavelength("G", "1") ** 2, rtol=1e-9)


def test_of_two_frequencies_the_wide_lane_is_known_best(at_presets):
    """Its variance by hand: the way from two codes, 4 sigma^2 / 2, and the two carriers; in wide-lane cycles of 0.862 m."""
    space = at_presets["wide-lane"].space
    assert np.abs(space.Z[:, 1]).tolist() == [1, 1]
    assert space.Z[:, 1].sum() == 0
    lam = np.array([wavelength("G", band) for band in "12"])
    variance = 2 * 0.1**2 * (1 / lam[0] - 1 / lam[1]) ** 2 + 4 * 0.005**2 * np.sum(1 / lam**2)
    assert space.Q[1, 1] == pytest.approx(variance)
    assert np.sqrt(space.Q[1, 1]) < 0.2


def test_without_correlation_the_volume_is_the_same(lab):
    for ambiguities in (2, 3):
        needle, ball = (lab.run(ambiguities=ambiguities, covariance=name).space.Q for name in ("textbook", "independent"))
        assert np.linalg.det(needle) == pytest.approx(np.linalg.det(ball))
        assert np.count_nonzero(ball) == ambiguities


def test_presets_show_what_they_promise(lab, at_presets):
    right = {name: _right(result) for name, result in at_presets.items()}
    start = {tuple(answer.integers) for answer in at_presets["three-answers"].answers}
    assert len(start) == 3
    assert right["three-answers"] == {"rounding": False, "bootstrapping": False, "least squares": True}
    assert all(right["all-agree"].values())
    assert right["bootstrapping-helps"] == {"rounding": False, "bootstrapping": True, "least squares": True}
    assert right["far-needle"] == {"rounding": False, "bootstrapping": False, "least squares": True}
    assert np.hypot(*at_presets["far-needle"].x_hat) > 2.9
    assert all(right["decorrelated-cells"].values())
    assert 1 < at_presets["on-the-edge"].ratio < 1.02
    assert at_presets["thousand-draws"].settings["draws"]
    assert at_presets["tree-step-by-step"].nodes_shown == 3
    assert len(at_presets["three-in-the-tree"].tree.nodes) > 5 * len(at_presets["three-decorrelated"].tree.nodes)
    assert all(right["three-decorrelated"].values())
    assert not any(result.note for result in at_presets.values())  # noise may well bring all of them about


def test_more_cells_are_blue_for_a_better_estimator(lab):
    counted = [lab.run(estimator=name, draws=True).plane.dots_right.mean() for name in ESTIMATORS]
    assert counted[0] < counted[1] - 0.05 < counted[2] - 0.1


def test_norms_are_those_of_the_engine(lab, rng):
    for floats in rng.uniform(-4, 4, (20, 3)):
        result = lab.run(ambiguities=3, **dict(zip(FLOATS, floats.tolist(), strict=True)))
        best = integer_least_squares(floats, cells.LGR_12 / 30)
        np.testing.assert_allclose([result.norms, result.tree.norms], [best.norms] * 2, rtol=1e-9)
        assert result.tree.candidates.tolist() == best.candidates.tolist()


def test_a_float_point_that_noise_hardly_brings_about_is_said(lab):
    assert lab.run().note == ""
    assert "fewer than one in a thousand" in lab.run(float_1=1.5, float_2=-1).note


def test_float_point_on_an_integer_has_no_finite_ratio(lab):
    result = lab.run(float_1=1, float_2=2)
    assert result.norms[0] == 0
    assert next(readout for readout in lab.readouts(result) if readout.label == "Ratio").value == "\N{INFINITY}"


@pytest.mark.parametrize(
    ("goal", "settings", "reached"),
    [
        ("luck", {}, False),
        ("luck", {"float_1": 0.3, "float_2": 0.48}, True),
        ("luck", {"float_1": 0.3, "float_2": 0.48, "decorrelated": True}, False),  # against the rules
        ("luck", {"float_1": 0.3, "float_2": 0.48, "covariance": "independent"}, False),
        ("bush", {"ambiguities": 3}, False),
        ("bush", {"ambiguities": 3, "covariance": "satellites", "epochs": 1, "code_noise": 0.3, "carrier_noise": 3, "float_1": 0.66, "float_2": 3.18,
                  "float_3": 1.16}, True),
        ("bush", {"ambiguities": 3, "covariance": "satellites", "epochs": 1, "code_noise": 0.3, "carrier_noise": 3, "float_1": 0.66, "float_2": 3.18,
                  "float_3": 1.16, "decorrelated": True}, False),
    ],
)  # fmt: skip
def test_goals_are_judged(lab, goal, settings, reached):
    is_reached, words = lab.goal(goal).judge(lab.run(**settings))
    assert is_reached == reached
    assert words.startswith("Now: ")


def test_controls_without_effect_say_why(lab):
    assert set(lab.blocked(lab.settings())) == {"float_3", "code_noise", "carrier_noise"}
    assert lab.blocked(lab.settings(ambiguities=3, covariance="satellites")) == {}
