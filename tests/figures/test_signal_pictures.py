"""Pictures of one satellite's signal."""

import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest

from gnsslab.figures.kept import KeptPicture, new_figure
from gnsslab.figures.signal import build_rates, build_signal, describe_signal, plot_signal


def _track(T=60, placed=-1, jump=0.0, one_carrier=False, left=0.0):
    seconds = np.arange(float(T))
    wave = np.sin(seconds)
    after = np.arange(T) >= placed if placed >= 0 else np.zeros(T, dtype=bool)
    found = np.zeros(T, dtype=bool)
    found[placed if placed >= 0 else 0] = placed >= 0
    nothing = np.full(T, np.nan)
    return SimpleNamespace(
        time=np.datetime64("2024-06-24T02:00:00", "ns") + np.arange(T) * np.timedelta64(1, "s"), seconds=seconds, satellite="G05", elevation=0.7,
        wavelength=0.19, code_minus_carrier=0.4 * wave - jump * after, carrier=nothing if one_carrier else 0.002 * wave + jump * after,
        ionosphere_twice=nothing if one_carrier else 0.001 * seconds, sigma_code=0.4, sigma_carrier=np.nan if one_carrier else 0.002,
        step=-jump if placed >= 0 else np.nan, placed=placed, found=found, range_rate=-300.0 + wave, has_doppler=True,
        code_rate=0.5 * wave, carrier_rate=0.03 * wave, left=left * seconds,
    )  # fmt: skip


@pytest.mark.parametrize("track", [_track(), _track(placed=20, jump=0.95), _track(one_carrier=True), _track(T=2), _track(left=60.0)])
def test_every_track_gives_a_picture(track, tmp_path):
    plot_signal(track).savefig(tmp_path / "a.png")
    assert (tmp_path / "a.png").stat().st_size > 5000


def test_code_and_carrier_stand_on_one_scale_above_and_the_carrier_enlarged_below():
    figure = new_figure(500, 420)
    build_signal(figure).show(_track())
    upper, lower = figure.axes
    heights = {line.get_label(): np.ptp(line.get_ydata()) for line in upper.lines if line.get_label() in ("code - carrier", "carrier alone")}
    assert heights["code - carrier"] / heights["carrier alone"] == pytest.approx(200, rel=0.01)
    assert upper.get_ylim()[1] == 0.5  # [m]
    assert lower.get_ylim()[1] == 10  # [mm]


def test_everything_of_a_slip_stays_in_sight():
    figure = new_figure(500, 420)
    build_signal(figure).show(_track(placed=20, jump=1.9))
    for axes in figure.axes:
        low, high = axes.get_ylim()
        for line in axes.lines:
            if line.get_transform() == axes.transData and len(line.get_ydata()):
                assert low < np.min(line.get_ydata())
                assert np.max(line.get_ydata()) < high


def test_noise_moves_the_points_and_not_the_frame(rng):
    scene = build_signal(new_figure(500, 420))
    frames = set()
    for _ in range(10):
        track = _track()
        track.code_minus_carrier = track.code_minus_carrier + 0.01 * rng.standard_normal(60)
        frames.add(scene.show(track))
    assert len(frames) == 1


def test_a_move_leaves_nothing_behind():
    for build in (build_signal, build_rates):
        kept = KeptPicture(build, 250, 210)
        kept.png(_track(placed=20, jump=0.95))
        assert kept.png(_track()) == KeptPicture(build, 250, 210).png(_track())


def test_words_for_the_picture():
    words = describe_signal(_track(placed=20, jump=0.95))
    assert "G05 at 40 degrees over 60 epochs" in words
    assert "scatters by 0.40 metres, the carrier alone by 2.0 millimetres" in words
    assert "A slip at 20 s moves code minus carrier by -0.95 metres; the engine finds it." in words
    assert "one carrier only" in describe_signal(_track(one_carrier=True))


def test_nothing_is_changed_and_read_only_arrays_serve():
    track = _track(placed=20, jump=0.95)
    for value in vars(track).values():
        if isinstance(value, np.ndarray):
            value.setflags(write=False)
    plot_signal(track)


def test_labs_load_without_matplotlib():
    code = "import sys; import gnsslab.labs.signal, gnsslab.labs.sky; assert 'matplotlib' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True)
