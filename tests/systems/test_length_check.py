"""A known length that does not fit: refused where most fixed epochs agree on another one, else said in words; single epochs become float."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from gnsslab.gnss.relative import Relative, Status, solve_moving
from gnsslab.systems.dual_antenna import dual_antenna_attitude
from gnsslab.systems.length_check import checked_by_length

MM, CM = 1e-3, 1e-2  # [m]
ROOF = 0.9910  # [m], all systems on two bands, mean of five minutes
HIGHEST = ("G13", "G05", "G15", "G20", "G18", "G30")  # of GPS, in order


def relative(lengths, fixed=(), float_=(), sigma=3 * MM):
    """Return a Relative of baselines towards the north, of these lengths [m]."""
    lengths = np.asarray(lengths, dtype=float)
    T = len(lengths)
    status = np.full(T, Status.NONE, dtype=np.int8)
    status[list(fixed)], status[list(float_)] = Status.FIXED, Status.FLOAT
    baseline = np.where((status > Status.NONE)[:, None], lengths[:, None] * np.array([0.0, 1.0, 0.0]), np.nan)
    Q = np.broadcast_to(np.eye(3) * sigma**2, (T, 3, 3))
    time = np.datetime64("2024-01-01", "ns") + np.arange(T) * np.timedelta64(1, "s")
    return Relative(time, status, baseline, baseline, Q, baseline, np.ones(T), np.full(T, 8))


def never():
    raise AssertionError("most epochs are fixed, so there is nothing to solve again")


def test_a_length_that_fits_changes_nothing_and_says_nothing():
    found = relative(np.full(20, 1.004), fixed=range(20))
    checked, warnings = checked_by_length(found, 1.0, 5 * MM, never)
    assert warnings == ()
    np.testing.assert_array_equal(checked.status, found.status)


def test_one_epoch_five_sigma_off_becomes_float_and_is_counted():
    """sqrt(3^2 + 5^2) = 5.8 mm, five of which are 29.2 mm."""
    lengths = np.full(20, 1.0)
    lengths[[4, 9]] = 1.029, 1.030
    checked, (warning,) = checked_by_length(relative(lengths, fixed=range(20)), 1.0, 5 * MM, never)
    assert np.flatnonzero(checked.status != Status.FIXED).tolist() == [9]
    assert warning == "the fixed epochs measure 1.000 m, the length given is 1 m: 1 of 20 contradict it and count as float"


def test_all_epochs_three_sigma_off_are_worth_a_word():
    assert checked_by_length(relative(np.full(9, 1.017), fixed=range(9)), 1.0, 5 * MM, never)[1] == ()
    _, (warning,) = checked_by_length(relative(np.full(9, 1.018), fixed=range(9)), 1.0, 5 * MM, never)
    assert "measure 1.018 m, the length given is 1 m: more than three of their sigma apart" in warning


def test_most_fixed_epochs_on_another_length_are_believed_instead():
    lengths = np.where(np.arange(20) < 11, 1.2, 1.0)
    with pytest.raises(ValueError, match=r"^the antennas are 1\.200 m apart by most fixed epochs, not 1 m: measure the length again"):
        checked_by_length(relative(lengths, fixed=range(20)), 1.0, 5 * MM, never)


def test_wrong_fixes_that_do_not_agree_say_nothing_about_the_tape():
    lengths = 1.0 + 0.1 * np.arange(1, 13)
    checked, (warning,) = checked_by_length(relative(lengths, fixed=range(12)), 1.0, 5 * MM, never)
    assert (checked.status == Status.FLOAT).all()
    assert "12 of 12 contradict" in warning


def test_few_fixed_epochs_ask_those_without_the_length():
    few, most = relative(np.ones(20), float_=range(20)), relative(np.full(20, 1.3), fixed=range(15), float_=range(15, 20))
    with pytest.raises(ValueError, match=r"1\.300 m apart by most fixed epochs, not 1 m"):
        checked_by_length(few, 1.0, 5 * MM, lambda: most)


def test_few_that_agree_on_nothing_leave_a_doubt_in_words():
    few, also_few = relative(np.ones(20), fixed=[3], float_=range(4, 20)), relative(np.full(20, 1.3), fixed=[7], float_=range(8, 20))
    _, (warning,) = checked_by_length(few, 1.0, 5 * MM, lambda: also_few)
    assert warning.startswith("only 1 of 17 epochs are fixed with the length of 1 m (1 without it, 1.300 m apart)")
    scattered = relative(np.linspace(1, 5, 20), fixed=range(6), float_=range(6, 20))
    assert "(6 without it): " in checked_by_length(few, 1.0, 5 * MM, lambda: scattered)[1][0]
    none = relative(np.ones(20), float_=range(20))
    _, (warning,) = checked_by_length(none, 1.0, 5 * MM, lambda: none)
    assert warning.startswith("none of 20 epochs are fixed with the length of 1 m (none without it)")


def test_epochs_without_a_solution_do_not_count():
    """A rover at 5 Hz with a master at 1 Hz: four of five epochs have none, and all others are fixed."""
    _, warnings = checked_by_length(relative(np.ones(100), fixed=range(0, 100, 5)), 1.0, 5 * MM, never)
    assert warnings == ()


def test_nothing_solved_at_all_is_not_the_lengths_fault():
    assert checked_by_length(relative(np.ones(5)), 1.0, 5 * MM, never)[1] == ()


@pytest.mark.parametrize(("length", "words"), [(1167.0, "give the length in metres"), (0.001, "by most fixed epochs")])
def test_another_unit_is_guessed(length, words):
    with pytest.raises(ValueError, match=words):
        checked_by_length(relative(np.full(9, 1.167), fixed=range(9)), length, 5 * MM, never)


def test_codes_know_metres_from_millimetres():
    found = relative(np.full(9, 1.9), float_=range(9), sigma=2.0)
    with pytest.raises(ValueError, match=r"about 1\.9 m apart by their codes, not 1167 m: give the length in metres, or leave it out"):
        checked_by_length(found, 1167.0, 5 * MM, lambda: found)


def test_bad_codes_make_a_baseline_long_and_blame_nobody():
    found = relative(np.full(9, 14.0), float_=range(9), sigma=8.0)
    checked, (warning,) = checked_by_length(found, 1.167, 5 * MM, lambda: found)
    assert (checked.status == Status.FLOAT).all()
    assert "none of 9 epochs are fixed" in warning


# Real data.


def only(observations, names):
    """Return the observations of these satellites of GPS."""
    table = observations.tables["G"]
    rows = np.isin(table.number, [int(name[1:]) for name in names])
    arrays = {name: getattr(table, name)[rows] for name in ("epoch", "number", "value", "lli", "ssi")}
    return replace(observations, tables={"G": replace(table, **arrays)})


@pytest.fixture(scope="module")
def roof(campaign):
    """A function from a number of satellites to attitude(length, ...) on GPS L1 with so many, the highest ones."""
    real = campaign("matrtklib-static")

    def attitude_with(satellites):
        pair = [only(receiver, HIGHEST[:satellites]) for receiver in (real.base, real.rover)]
        return partial(dual_antenna_attitude, *pair, real.ephemerides, systems="G", frequencies=1)

    return attitude_with


@pytest.mark.parametrize("single_epoch", [False, True], ids=["filter", "single epochs"])
@pytest.mark.parametrize("satellites", [5, 6])
@pytest.mark.parametrize("off", [-5 * CM, 5 * CM])
def test_five_centimetres_are_noticed_on_a_few_satellites(roof, satellites, off, single_epoch):
    """Refused; but single epochs of five satellites, 14 of 301 of which are fixed without a length, can only say that none fits."""
    attitude = roof(satellites)
    if single_epoch and satellites == 5:
        found = attitude(length=ROOF + off, single_epoch=True)
        assert (found.status == Status.FIXED).mean() <= 0.02
        assert any("a length that is wrong by centimetres does that" in words for words in found.warnings)
    else:
        with pytest.raises(ValueError, match=r"the antennas are 0\.9[89]\d m apart by most fixed epochs, not"):
            attitude(length=ROOF + off, single_epoch=single_epoch)


@pytest.mark.parametrize(("satellites", "single_epoch", "least"), [(6, False, 0.99), (5, False, 0.99), (6, True, 0.80)])
def test_five_millimetres_do_no_harm(roof, satellites, single_epoch, least):
    found = roof(satellites)(length=ROOF + 5 * MM, single_epoch=single_epoch)
    assert (found.status == Status.FIXED).mean() >= least
    assert found.warnings == ()


def test_two_centimetres_are_said(roof):
    assert any("fixed epochs measure 0.98" in words for words in roof(6)(length=ROOF + 2 * CM).warnings)


def test_a_length_that_contradicts_all_systems_is_refused(campaign):
    roof = campaign("matrtklib-static")
    with pytest.raises(ValueError, match=r"the antennas are 0\.99\d m apart by most fixed epochs, not 1\.2 m"):
        dual_antenna_attitude(roof.base, roof.rover, roof.ephemerides, length=1.2)
    with pytest.raises(ValueError, match="more than 0 m, not inf"):
        dual_antenna_attitude(roof.base, roof.rover, roof.ephemerides, length=np.inf)


def test_a_single_epoch_that_the_length_contradicts_is_not_called_fixed(campaign):
    """Integers of one satellite moved by a wavelength would do this; here the tape is honest and one epoch is bent by hand."""
    roof = campaign("matrtklib-static")
    honest = solve_moving(roof.base, roof.rover, roof.ephemerides)
    assert (honest.status == Status.FIXED).all()
    bent = honest.baseline_enu.copy()
    bent[7] *= 1.1
    checked, warnings = checked_by_length(replace(honest, baseline_enu=bent), ROOF, 5 * MM, never)
    assert np.flatnonzero(checked.status != Status.FIXED).tolist() == [7]
    assert len(warnings) == 1
