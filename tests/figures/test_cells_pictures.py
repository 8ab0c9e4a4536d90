"""Pictures of the plane of two ambiguities and of the search tree."""

import numpy as np
import pytest

from gnsslab.core.integers import integer_bootstrapping, integer_least_squares, integer_rounding
from gnsslab.figures import cells, search_tree
from gnsslab.figures.cells import build_plane, describe_cells, plot_cells
from gnsslab.figures.integer_words import combination, decimal, indexed, vector, whole
from gnsslab.figures.kept import KeptPicture, new_figure
from gnsslab.figures.search_tree import build_tree
from gnsslab.labs.cells import ESTIMATORS, cells_lab

ESTIMATE = {
    "rounding": lambda x, Q: integer_rounding(x),
    "bootstrapping": integer_bootstrapping,
    "least squares": lambda x, Q: integer_least_squares(x, Q).best,
}
BUSH = {"ambiguities": 3, "covariance": "frequencies", "epochs": 1, "code_noise": 1.0, "carrier_noise": 1, "float_1": 4, "float_2": 4, "float_3": 4}


@pytest.fixture(scope="module")
def lab():
    """One lab for all tests."""
    return cells_lab()


@pytest.mark.parametrize(
    "settings", [{}, {"draws": True, "ambiguities": 3}, {"estimator": "rounding", "float_1": -4}, BUSH, {"epochs": 1, "float_1": 4, "float_2": -4}]
)
def test_every_result_gives_a_picture(lab, tmp_path, settings):
    plot_cells(lab.run(**settings)).savefig(tmp_path / "a.png")
    assert (tmp_path / "a.png").stat().st_size > 20_000


@pytest.mark.parametrize("estimator", ESTIMATORS)
@pytest.mark.parametrize(
    "settings", [{}, {"decorrelated": True}, {"covariance": "satellites", "code_noise": 1.0, "carrier_noise": 1}, {"ambiguities": 3}]
)
def test_every_point_of_the_window_lies_in_one_cell_and_it_is_the_engines(lab, rng, estimator, settings):
    result = lab.run(estimator=estimator, **settings)
    figure = new_figure(410, 480)
    scene = build_plane(figure)
    scene.show(result)
    axes = figure.axes[0]
    paths = scene.moving[0].get_paths()
    points = np.column_stack([rng.uniform(*axes.get_xlim(), 60), rng.uniform(*axes.get_ylim(), 60)])
    for point, expected in zip(points, ESTIMATE[estimator](points, result.plane.Q), strict=True):
        owners = [path.vertices[:-1].mean(axis=0) for path in paths if path.contains_point(point)]
        assert len(owners) == 1  # the middle of a symmetric cell is its integer
        np.testing.assert_allclose(owners[0], expected, atol=1e-9)


@pytest.mark.parametrize("estimator", ESTIMATORS)
@pytest.mark.parametrize("decorrelated", [False, True])
@pytest.mark.parametrize("covariance", ["textbook", "satellites", "frequencies", "independent"])
def test_neighbours_have_different_tints(lab, estimator, decorrelated, covariance):
    corners = lab.run(estimator=estimator, decorrelated=decorrelated, covariance=covariance).plane.corners
    beyond_each_edge = (corners + np.roll(corners, -1, axis=0)) / 2 * 1.01
    neighbours = np.rint(2 * beyond_each_edge / 1.01)
    tints = cells._tints(np.vstack([np.zeros(2), neighbours]), corners)
    long = np.linalg.norm(corners - np.roll(corners, -1, axis=0), axis=1) > 1e-6
    if estimator != "bootstrapping":  # there a long side borders on two cells, which its middle does not show
        assert (tints[1:][long] != tints[0]).all()


def test_axes_hold_still_while_the_float_point_moves_a_little(lab):
    scene = build_plane(new_figure(410, 480))
    assert len({scene.show(lab.run(float_1=1 + k / 50, float_2=1 + k / 70)) for k in range(10)}) == 1


@pytest.mark.parametrize(
    "settings", [{}, {"float_1": 4, "float_2": -4}, {"float_1": 4, "float_2": -4, "decorrelated": True}, {"ambiguities": 3, "float_3": -4}]
)
def test_the_float_point_is_in_the_picture(lab, settings):
    result = lab.run(**settings)
    figure = new_figure(410, 480)
    build_plane(figure).show(result)
    axes = figure.axes[0]
    for value, (low, high) in zip(result.plane.centre, (axes.get_xlim(), axes.get_ylim()), strict=True):
        assert low < value < high


def test_the_ellipse_grown_to_the_nearest_goes_through_it_and_leaves_the_others_outside(lab):
    result = lab.run()
    scene = build_plane(new_figure(410, 480))
    scene.show(result)
    ellipse = next(artist for artist in scene.moving if getattr(artist, "get_label", str)() == "grown")
    outline = ellipse.get_path().transformed(ellipse.get_patch_transform()).to_polygons(closed_only=False)[0]
    assert np.linalg.norm(outline - result.answers[2].integers, axis=1).min() < 0.05


@pytest.mark.parametrize("settings", [{}, {"ambiguities": 3, "epochs": 10}, BUSH])
def test_nodes_keep_their_places_while_the_tree_grows(lab, settings):
    total = min(search_tree.MOST_NODES, len(lab.run(**settings).tree.nodes))
    before = {}
    for shown in range(1, total + 1):
        scene = build_tree(new_figure(400, 480))
        scene.show(lab.run(nodes_shown=shown, **settings))
        places = {
            tuple(place) for line in scene.moving if line.get_label() in search_tree.NODE_WORDS.values() for place in line.get_xydata().round(6)
        }
        assert len(places) == shown
        assert set(before) <= places
        before = dict.fromkeys(places)


def test_nodes_of_a_level_do_not_cover_each_other(lab):
    for settings in ({}, {"ambiguities": 3, "epochs": 10}, {"covariance": "satellites", "epochs": 1, "ambiguities": 3}):
        result = lab.run(**settings)
        layout = search_tree._Layout(result.tree.nodes[: search_tree.MOST_NODES], len(result.x_hat))
        assert min(layout.spacing) >= 2 * layout.radius * 0.99
        assert layout.places[:, 0].min() > 0
        assert layout.places[:, 0].max() < search_tree.WIDTH


def test_parents_stand_above_the_middle_of_their_children(lab):
    nodes = lab.run(ambiguities=3, epochs=10).tree.nodes
    layout = search_tree._Layout(nodes, 3)
    for parent in {node.parent for node in nodes} - {-1}:
        x = [place[0] for node, place in zip(nodes, layout.places, strict=True) if node.parent == parent]
        assert layout.places[parent][0] == pytest.approx(np.mean(x))


def test_moves_leave_nothing_behind(lab):
    results = [lab.run(**settings) for settings in ({"draws": True}, BUSH, {"ambiguities": 3}, {"nodes_shown": 4})]
    for build, width in ((build_plane, 410), (build_tree, 400)):
        kept = KeptPicture(build, width, 480, sharpness=0.5)
        for result in results:
            moved = kept.png(result)
        assert moved == KeptPicture(build, width, 480, sharpness=0.5).png(results[-1])


def test_words_for_the_pictures(lab):
    words = describe_cells(lab.run(nodes_shown=4))
    assert "as they stand" in words
    assert "covered by the cells of least squares, each of area 1." in words
    assert "rounding says (2, 1), bootstrapping says (1, 1), least squares says (0, 0); true is (0, 0)" in words
    assert "its ellipse 17.9 times as long as wide" in words  # sqrt(81.146 / 0.254), the eigenvalues of the textbook's covariance
    assert "of 11 nodes. The first 4 are shown" in words
    assert "It is the plane of the first two, with 0 for the third" in describe_cells(lab.run(ambiguities=3, float_1=0, float_2=0, float_3=0.1))


def test_words_on_the_last_step(lab):
    first, last = (search_tree._words_on_step(result, result.tree.nodes[: result.nodes_shown]) for result in (lab.run(nodes_shown=1), lab.run()))
    assert first == (f"Step 1 of 11: {indexed('a', 1)} = 1 for 1.10", "squared norm 0.01, no bound yet: goes on below")
    assert last == ("All 11 steps: best (0, 0) at 1.30", "second best (3, 2) at 3.74; nothing else is nearer")


def test_numbers_as_written_by_hand():
    minus = "\N{MINUS SIGN}"
    assert vector(np.array([2, -1])) == f"(2, {minus}1)"
    assert decimal(-1.234) == f"{minus}1.23"
    assert whole(np.int64(-3)) == f"{minus}3"
    assert combination([-2, 3], "a") == f"{minus}2 {indexed('a', 0)} + 3 {indexed('a', 1)}"
    assert combination([0, 1, -1], "a") == f"{indexed('a', 1)} {minus} {indexed('a', 2)}"
