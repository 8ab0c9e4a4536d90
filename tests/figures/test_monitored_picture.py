"""The picture of a monitored series: long series keep their extremes, and every kind of series can be drawn."""

import io
from types import SimpleNamespace

import numpy as np
import pytest

from gnsslab.figures.monitored import DRAWN_ONE_BY_ONE, STRETCHES, alarm_spans, labelled_steps, lowest_and_highest, plot_monitored, stretch_of
from gnsslab.systems.monitoring import Flag


def monitored(T, rng, **changes):
    """Return what `monitor` gives for T epochs of noise, some of it changed."""
    fields = {
        "time": np.datetime64("2024-01-01", "ns") + np.arange(T) * np.timedelta64(1, "s"),
        "enu": rng.normal(0, 0.01, (T, 3)),
        "level": np.zeros((T, 3)),
        "sigma": np.full((T, 3), 0.002),
        "flag": np.full(T, Flag.OK, dtype=np.int8),
        "alarm": np.zeros(T, dtype=bool),
        "steps": (),
    }
    return SimpleNamespace(**(fields | changes))


def texts_of(figure):
    return [text.get_text() for part in (figure, *figure.axes) for text in part.texts]


def test_extremes_of_stretches_against_a_loop(rng):
    T = DRAWN_ONE_BY_ONE + 4321
    values = rng.normal(size=T)
    values[rng.random(T) < 0.3] = np.nan
    values[stretch_of(T) == 7] = np.nan
    low, high, begin = lowest_and_highest(values)
    assert len(low) == len(high) == len(begin) == STRETCHES
    for k in range(0, STRETCHES, 97):
        part = values[begin[k] : begin[k + 1] if k + 1 < STRETCHES else T]
        part = part[np.isfinite(part)]
        assert (low[k], high[k]) == (part.min(), part.max())
    assert np.isnan(low[7])


def test_short_series_are_drawn_epoch_by_epoch(rng):
    values = rng.normal(size=50)
    low, high, begin = lowest_and_highest(values)
    assert np.array_equal(low, values)
    assert np.array_equal(high, values)
    assert np.array_equal(begin, np.arange(50))


@pytest.mark.parametrize("alarm", [[], [0], [1], [1, 1, 0, 1, 0, 0, 1], [0, 1, 1, 1]])
def test_spans_of_alarm_cover_it_and_nothing_else(alarm):
    covered = np.zeros(len(alarm), dtype=int)
    for begin, end in zip(*alarm_spans(np.array(alarm, dtype=bool)), strict=True):
        covered[begin : end + 1] += 1
    assert covered.tolist() == alarm


def test_a_long_series_says_that_it_is_thinned(rng):
    figure = plot_monitored(monitored(DRAWN_ONE_BY_ONE + 1, rng))
    assert any("20001 epochs, drawn from the lowest to the highest" in text for text in texts_of(figure))
    assert not any("drawn from" in text for text in texts_of(plot_monitored(monitored(100, rng))))


def test_steps_carry_their_sizes_and_the_axis_its_unit(rng):
    step = SimpleNamespace(time=None, first=40, found=44, size=np.array([0.036, -0.021, 0.0]), sigma=np.full(3, 0.002))
    figure = plot_monitored(monitored(100, rng, steps=(step,)))
    assert [panel.get_ylabel() for panel in figure.axes] == ["east [mm]", "north [mm]", "up [mm]"]
    assert [text.strip() for text in texts_of(figure)] == ["+36.0 mm", "-21.0 mm", "+0.0 mm"]


def test_of_steps_that_crowd_the_largest_is_labelled(rng):
    steps = tuple(SimpleNamespace(first=40 + k, size=np.array([size, 0.0, 0.0])) for k, size in enumerate([0.01, -0.05, 0.02, 0.03]))
    far = SimpleNamespace(first=90, size=np.array([0.001, 0.0, 0.0]))
    assert labelled_steps((*steps, far), np.arange(100.0)) == [steps[1], far]
    figure = plot_monitored(monitored(100, rng, steps=(*steps, far)))
    assert [text.strip() for text in texts_of(figure)][:2] == ["-50.0 mm", "+1.0 mm"]
    assert len(figure.axes[0].lines) >= 5


def test_outliers_do_not_set_the_scale(rng):
    enu, flag = rng.normal(0, 0.01, (100, 3)), np.full(100, Flag.OK, dtype=np.int8)
    enu[50], flag[50] = 1000.0, Flag.OUTLIER
    figure = plot_monitored(monitored(100, rng, enu=enu, flag=flag))
    assert figure.axes[0].get_ylim()[1] < 100  # [mm]


@pytest.mark.parametrize("case", ["one epoch", "nothing but gaps", "nothing but outliers", "alarm all the time", "empty level"])
def test_every_series_can_be_drawn(case, rng):
    T = 1 if case == "one epoch" else 30
    nan = np.full((T, 3), np.nan)
    changes = {
        "one epoch": {},
        "nothing but gaps": {"enu": nan, "flag": np.full(T, Flag.GAP)},
        "nothing but outliers": {"flag": np.full(T, Flag.OUTLIER)},
        "alarm all the time": {"alarm": np.ones(T, dtype=bool)},
        "empty level": {"enu": nan, "level": nan, "sigma": nan, "flag": np.full(T, Flag.GAP)},
    }[case]
    file = io.BytesIO()
    plot_monitored(monitored(T, rng, **changes)).savefig(file)
    assert file.getbuffer().nbytes > 10_000
