"""Pictures of a sky."""

from types import SimpleNamespace

import numpy as np
import pytest

from gnsslab.figures.kept import KeptPicture, new_figure
from gnsslab.figures.sky import SYSTEM_STYLE, build_residuals, build_sky, describe_sky, plot_sky


def _view(
    names=("G05", "E11", "C30", "J02"), elevation_deg=(80.0, 45.0, 5.0, 20.0), azimuth_deg=(0.0, 90.0, 180.0, 270.0), used=(1, 1, 0, 1), error=0.5
):
    T, m = 3, len(names)
    elevation = np.tile(np.radians(elevation_deg), (T, 1))
    used = np.tile(np.array(used, dtype=bool), (T, 1))
    law = np.radians(np.linspace(3, 90, 60))
    return SimpleNamespace(
        time=np.datetime64("2024-06-24T02:00:00", "ns") + np.arange(T) * np.timedelta64(30, "s"), names=names, shown=1,
        azimuth=np.tile(np.radians(azimuth_deg), (T, 1)), elevation=elevation, used=used, dop=np.array([2.0, 1.7, 0.9, 1.5]), mask=np.radians(10),
        residual=np.where(used, error * np.linspace(-1, 1, T * m).reshape(T, m), np.nan), law_elevation=law, law_sigma=0.4 / np.sin(law), within=0.7,
    )  # fmt: skip


@pytest.mark.parametrize(
    "view",
    [
        _view(),
        _view(error=300.0),
        _view(("G05",), (10.0,), (0.0,), (0,)),
        _view(tuple(f"G{k:02d}" for k in range(1, 33)), np.linspace(-20, 89, 32), np.linspace(0, 359, 32), [1] * 32),
    ],
    ids=["four", "gross", "none used", "many"],
)
def test_every_view_gives_a_picture(view, tmp_path):
    plot_sky(view).savefig(tmp_path / "a.png")
    assert (tmp_path / "a.png").stat().st_size > 5000


def test_north_is_up_east_is_right_and_the_zenith_in_the_middle():
    figure = new_figure(400, 420)
    build_sky(figure).show(_view())
    place = {}
    for line in figure.axes[0].lines:
        if line.get_marker() not in ("None", "", None) and len(line.get_xdata()):
            place[line.get_marker(), line.get_fillstyle()] = (line.get_xdata()[0], line.get_ydata()[0])
    np.testing.assert_allclose(place["o", "full"], (0.0, 10 / 90), atol=1e-9)  # 80 degrees up in the north
    np.testing.assert_allclose(place["s", "full"], (0.5, 0.0), atol=1e-9)
    np.testing.assert_allclose(place["^", "none"], (0.0, -85 / 90), atol=1e-9)  # below the mask: hollow
    np.testing.assert_allclose(place["D", "full"], (-70 / 90, 0.0), atol=1e-9)


def test_what_is_below_the_horizon_is_not_drawn():
    figure = new_figure(400, 420)
    build_sky(figure).show(_view(elevation_deg=(80.0, 45.0, -5.0, 20.0)))
    hollow = [line for line in figure.axes[0].lines if line.get_marker() == "^" and line.get_fillstyle() == "none"]
    assert not np.isfinite(hollow[0].get_xdata()).any()


def test_systems_are_told_by_colour_and_by_marker():
    for key in ("color", "marker", "label"):
        assert len({style[key] for style in SYSTEM_STYLE.values()}) == len(SYSTEM_STYLE)


def test_all_residuals_are_in_sight():
    for error in (0.5, 7.0, 300.0):
        figure = new_figure(480, 420)
        view = _view(error=error)
        build_residuals(figure).show(view)
        low, high = figure.axes[0].get_ylim()
        assert low < np.nanmin(view.residual)
        assert np.nanmax(view.residual) < high


def test_a_move_leaves_nothing_behind():
    many = _view(tuple(f"G{k:02d}" for k in range(1, 33)), np.linspace(5, 89, 32), np.linspace(0, 359, 32), [1] * 32)
    for build in (build_sky, build_residuals):
        kept = KeptPicture(build, 240, 210)
        kept.png(many)
        kept.png(_view())
        kept.png(many)
        assert kept.png(_view()) == KeptPicture(build, 240, 210).png(_view())


def test_words_for_the_picture():
    words = describe_sky(_view())
    assert "4 satellites above the horizon, 3 of them used above the mask of 10 degrees" in words
    assert "HDOP 0.90, VDOP 1.50" in words
    assert "70 percent lie within one sigma" in words


def test_nothing_is_changed_and_read_only_arrays_serve():
    view = _view()
    for value in vars(view).values():
        if isinstance(value, np.ndarray):
            value.setflags(write=False)
    plot_sky(view)
