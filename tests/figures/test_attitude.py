"""Pictures of an attitude."""

import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest

from gnsslab.figures.attitude import FIXED, FLOAT, NONE, STATUS_STYLE, build_angles, describe_attitude, plot_attitude
from gnsslab.figures.kept import new_figure


def _attitude(status, heading_deg=35.0, length=1.2, scatter=0.0, rng=None):
    status = np.asarray(status, dtype=np.int8)
    noise = scatter * rng.standard_normal((len(status), 3)) if rng else 0.0
    psi = np.radians(heading_deg)
    enu = length * np.array([np.sin(psi), np.cos(psi), 0.05]) + np.zeros((len(status), 3)) + noise
    enu[status == NONE] = np.nan
    e, n, u = enu.T
    sigma = np.where(status == NONE, np.nan, 0.003)
    return SimpleNamespace(
        time=np.datetime64("2024-06-24T08:20:00", "ns") + np.arange(len(status)) * np.timedelta64(1, "s"),
        status=status, heading=np.arctan2(e, n) % (2 * np.pi), pitch=np.arctan2(u, np.hypot(e, n)),
        length=np.linalg.norm(enu, axis=1), baseline_enu=enu, sigma_heading=sigma, sigma_pitch=2 * sigma,
    )  # fmt: skip


@pytest.mark.parametrize(
    "attitude",
    [
        _attitude([FIXED] * 5),
        _attitude([NONE] * 5),
        _attitude([FLOAT]),
        _attitude([]),
        _attitude([NONE, FLOAT, FIXED, FIXED], heading_deg=359.9),
        _attitude([FIXED] * 3, length=12_345.0),
    ],
    ids=["fixed", "none", "one epoch", "empty", "through north", "long"],
)
def test_every_attitude_gives_a_picture(attitude, tmp_path):
    plot_attitude(attitude).savefig(tmp_path / "a.png")
    assert (tmp_path / "a.png").stat().st_size > 5000


def test_status_is_told_by_colour_and_by_marker():
    for key in ("color", "marker"):
        assert len({style[key] for style in STATUS_STYLE.values()}) == 3


def test_heading_through_north_is_drawn_in_one_piece(rng):
    figure = new_figure(500, 400)
    build_angles(figure).show((_attitude([FIXED] * 50, heading_deg=0.0, scatter=0.005, rng=rng), None))
    low, high = figure.axes[0].get_ylim()
    drawn = np.concatenate([line.get_ydata() for line in figure.axes[0].lines if line.get_label() == "fixed"])
    assert high - low < 5  # deg: a wrap would need 360
    assert len(drawn) == 50
    assert (low < drawn).all()
    assert (drawn < high).all()


def test_axes_hold_still_under_small_changes(rng):
    """A slider's move changes the points, not the frame around them: that is what makes it comparable, and quick."""
    scene = build_angles(new_figure(500, 400))
    frames = {scene.show((_attitude([FIXED] * 50, scatter=0.002, rng=rng), None)) for _ in range(20)}
    assert len(frames) <= 2


def test_words_for_the_picture():
    words = describe_attitude(_attitude([FIXED, FIXED, FLOAT, NONE]), SimpleNamespace(heading=np.radians(35.0), pitch=0.0))
    assert "4 epochs (2 fixed, 1 float, 1 none)" in words
    assert "points to 35.0 degrees" in words
    assert words.endswith("Truth: 35.0 degrees.")
    assert describe_attitude(_attitude([NONE])).endswith("No epoch has a solution.")
    assert describe_attitude(_attitude([])) == "No epochs to show."


def test_nothing_is_changed_and_read_only_arrays_serve():
    attitude = _attitude([FIXED, FLOAT, NONE])
    for value in vars(attitude).values():
        value.setflags(write=False)
    plot_attitude(attitude, SimpleNamespace(heading=0.6, pitch=0.0))


def test_pyplot_stays_out_and_labs_load_without_matplotlib():
    code = """
import sys
import gnsslab.labs.north
assert "matplotlib" not in sys.modules
import gnsslab.figures.attitude
assert "matplotlib.pyplot" not in sys.modules
"""
    subprocess.run([sys.executable, "-c", code], check=True)
