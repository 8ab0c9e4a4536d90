"""Series: what it refuses, its words, cutting it, and the one that a relative solution gives."""

from datetime import timedelta

import numpy as np
import pytest

from gnsslab.gnss.relative import Relative, Status
from gnsslab.gnss.series import Series, series_of, series_of_numbers

MILLIMETRE = 1e-3


def series_like(T=4, **changes):
    """Return the fields of a lawful series of T epochs, some of them changed."""
    fields = {
        "time": np.datetime64("2024-06-24T08:20:00", "ns") + np.arange(T) * np.timedelta64(30, "s"),
        "enu": np.arange(3.0 * T).reshape(T, 3),
        "sigma": np.full((T, 3), 3 * MILLIMETRE),
        "status": np.full(T, Status.FIXED, dtype=np.int8),
        "ratio": np.full(T, 12.0),
    }
    return fields | changes


def test_words_of_a_series():
    status = np.array([2, 1, 0, 2], np.int8)
    enu = np.where((status > 0)[:, None], np.ones((4, 3)), np.nan)
    words = repr(Series(**series_like(status=status, enu=enu)))
    assert words == "Series: 4 epochs from 2024-06-24T08:20:00.000, every 30 s; 2 fixed, 1 float, 1 without solution"
    assert repr(Series(**series_like(1))).startswith("Series: 1 epoch from 2024-06-24T08:20:00.000; 1 fixed")
    assert repr(Series(**series_like(0))) == "Series: no epochs"


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"enu": np.zeros((4, 2))}, r"4 epochs needs enu of shape \(4, 3\), not \(4, 2\)"),
        ({"ratio": np.zeros(3)}, r"ratio of shape \(4,\)"),
        ({"time": series_like()["time"].astype("M8[s]")}, r"datetime64\[ns\] in GPS time, not datetime64\[s\]"),
        ({"time": series_like()["time"][[0, 1, 1, 2]]}, "08:20:30.000 follows 2024-06-24T08:20:30.000: sort them"),
        ({"time": series_like()["time"][[0, 2, 1, 3]]}, "must increase"),
        ({"time": np.append(series_like()["time"][:3], np.datetime64("NaT"))}, "epoch 3 of the series has no time"),
        ({"status": np.array([2, 2, 0, 2], np.int8)}, "epoch 2 of the series has status NONE and position"),
        ({"enu": np.full((4, 3), np.nan)}, "epoch 0 of the series has status FIXED and position"),
        ({"status": np.array([2, 2, 7, 2], np.int8)}, "Status.NONE, FLOAT or FIXED"),
        ({"sigma": np.full((4, 3), -1.0)}, "not negative"),
        ({"sigma": np.full((4, 3), np.inf)}, "finite"),
    ],
)
def test_a_series_that_contradicts_itself_is_refused(changes, words):
    with pytest.raises(ValueError, match=words):
        Series(**series_like(**changes))


def test_cutting_by_slice_indices_and_mask_is_the_same():
    series = Series(**series_like(10))
    for cut in (slice(2, 8, 2), [2, 4, 6], np.isin(np.arange(10), [2, 4, 6])):
        part = series.at(cut)
        assert len(part) == 3
        assert part.enu[:, 0].tolist() == [6.0, 12.0, 18.0]
        assert part.is_solved.all()


def test_arrays_are_neither_changed_nor_copied_into_other_values():
    fields = series_like()
    for array in fields.values():
        array.flags.writeable = False
    assert Series(**fields).enu is fields["enu"]
    made = series_of_numbers(fields["time"], fields["enu"])
    assert np.array_equal(made.enu, fields["enu"])
    assert np.isnan(made.sigma).all()
    assert np.isnan(made.ratio).all()


def test_rows_without_three_numbers_have_no_solution():
    enu = np.ones((4, 3))
    enu[1, 2], enu[3] = np.nan, np.nan
    series = series_of_numbers(series_like()["time"], enu)
    assert series.status.tolist() == [2, 0, 2, 0]
    assert np.isnan(series.enu[[1, 3]]).all()


def test_series_of_a_relative_solution(rng):
    T = 6
    root = rng.normal(0, MILLIMETRE, (T, 3, 3))
    Q = root @ root.swapaxes(1, 2)
    Q[4] = np.nan
    status = np.array([2, 2, 1, 2, 0, 2], np.int8)
    baseline = np.where((status > 0)[:, None], rng.normal(size=(T, 3)), np.nan)
    time = series_like(T)["time"]
    relative = Relative(time, status, baseline, baseline, Q, baseline, np.full(T, 9.0), np.full(T, 12))
    series = series_of(relative)
    assert np.array_equal(series.enu, baseline, equal_nan=True)
    for t in range(T):  # sigma by hand
        for axis in range(3):
            assert series.sigma[t, axis] == pytest.approx(Q[t, axis, axis] ** 0.5, nan_ok=True)
    assert (series.time[1] - series.time[0]).astype("m8[us]").item() == timedelta(seconds=30)
