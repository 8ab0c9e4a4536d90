"""Relative positioning: real data with known answers, a second implementation, and simulated data whose truth is known."""

import json
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from one_epoch import solve_one_epoch
from small_observations import short_preset

from gnsslab.gnss.differences import common_epochs
from gnsslab.gnss.frames import enu_rotation
from gnsslab.gnss.judging import ratio_threshold
from gnsslab.gnss.points import solve_points
from gnsslab.gnss.relative import Status, solve_moving, solve_relative, station_position
from gnsslab.gnss.selection import keep_epochs
from gnsslab.gnss.signals import SPEED_OF_LIGHT
from gnsslab.simulate import Clock, GrossError, Outage, Slip, Turntable, observe, prepare_geometry

MM, CM, MICROMETRE = 1e-3, 1e-2, 1e-6  # [m]
WRONG = 5 * CM
REFERENCE = Path(__file__).parents[1] / "reference" / "acceptance.json"


# Real data: the numbers asked for, with base and base position of the registry.


class Real:
    """A solution of real data, and how it compares with the registry."""

    def __init__(self, campaign, name, **options):
        real = campaign(name)
        self.solution = solve_relative(real.base, real.rover, real.ephemerides, base_position=real.facts.base_position, **options)
        self.is_fixed = self.solution.status == Status.FIXED
        common = len(common_epochs(real.base.time, real.rover.time)[0])
        self.fixed_percent = 100 * self.is_fixed.sum() / common
        self.error = self.solution.baseline_enu - truth_of(real.facts)
        self.median_error = np.median(self.error[self.is_fixed], axis=0)
        self.wrong = int((np.linalg.norm(self.error[self.is_fixed], axis=1) > WRONG).sum())


def truth_of(facts):
    """Return the baseline (3,) [m] of the registry, axes at the base."""
    if facts.baseline_enu is not None:
        return facts.baseline_enu
    return enu_rotation(facts.base_position) @ (facts.rover_position - facts.base_position)


def test_two_antennas_on_a_roof_all_systems(campaign):
    real = Real(campaign, "matrtklib-static")
    assert real.fixed_percent == 100
    assert real.wrong == 0
    assert np.linalg.norm(np.median(real.solution.baseline_enu, axis=0)) == pytest.approx(0.9902, abs=1 * MM)


@pytest.mark.parametrize(
    "options",
    [
        {"systems": "G", "frequencies": 1, "single_epoch": True},
        {"systems": "C", "frequencies": 1},
        {"systems": "C", "frequencies": 1, "single_epoch": True},
        {"static": True},
    ],
    ids=["GPS L1 single epoch", "BeiDou B1", "BeiDou B1 single epoch", "static"],
)
def test_two_antennas_on_a_roof_with_less(campaign, options):
    real = Real(campaign, "matrtklib-static", **options)
    assert real.fixed_percent >= 99
    assert real.wrong == 0
    assert np.abs(real.median_error).max() < 5 * MM


@pytest.mark.parametrize("options", [{"single_epoch": True}, {"frequencies": 1}], ids=["L1+L2 single epoch", "L1 filter"])
def test_three_kilometres_of_gps(campaign, options):
    real = Real(campaign, "geonet-0759-3040", systems="G", **options)
    assert real.fixed_percent >= 99
    assert (np.abs(real.median_error) < [3 * MM, 4 * MM, 10 * MM]).all()


def test_five_kilometres_of_all_systems(campaign):
    real = Real(campaign, "cssrlib-078")
    assert real.fixed_percent == 100
    assert np.hypot(*real.median_error[:2]) < 5 * MM
    assert abs(real.median_error[2]) < 10 * MM
    assert real.wrong == 0


def test_a_day_on_a_slope_with_beidou_alone(slope_day, campaign):
    is_fixed = slope_day.status == Status.FIXED
    error = slope_day.enu[is_fixed] - truth_of(campaign("beidou-slope").facts)
    assert 100 * is_fixed.mean() >= 92
    assert (np.linalg.norm(error, axis=1) > 15 * CM).sum() <= 7
    assert (np.abs(np.median(error, axis=0)) < [5 * MM, 5 * MM, 15 * MM]).all()  # RTKLIB's own scatter over that day


# A second implementation, without differences (tests/gnss/one_epoch.py).

ONE_EPOCH = [
    ("geonet-0759-3040", 40, {"G": ("1C", "2W")}),
    ("geonet-0759-3040", 80, {"G": ("1C", "2W")}),
    ("matrtklib-static", 150, {"G": ("1C", "2W"), "E": ("1C", "5Q")}),
]


@pytest.mark.parametrize(("name", "k", "signals"), ONE_EPOCH)
def test_one_epoch_agrees_with_undifferenced_least_squares(campaign, name, k, signals):
    real = campaign(name)
    base_position = real.facts.base_position if real.facts.base_position is not None else station_position(real.base, real.ephemerides)
    epochs = [index[k] for index in common_epochs(real.base.time, real.rover.time)]
    start = base_position + [30.0, -20.0, 10.0] + enu_rotation(base_position).T @ real.facts.baseline_enu  # metres off, as a single point is
    other = solve_one_epoch(real.base, real.rover, real.ephemerides, epochs, base_position, start, signals)
    ours, ours_float = (
        solve_relative(
            real.base, real.rover, real.ephemerides, base_position=base_position, systems="".join(signals), single_epoch=True, acceptance=acceptance
        )
        for acceptance in (16.0, np.inf)
    )
    t = epochs[1]
    assert ours.status[t] == Status.FIXED
    assert ours_float.status[t] == Status.FLOAT
    assert ours.satellites[t] == other.satellites
    np.testing.assert_allclose(ours.baseline_ecef[t], other.fixed_baseline, rtol=0, atol=0.1 * MM)
    # ours is drawn to its single point, metres off, by (1 m of code / 100 m of open prior)^2
    np.testing.assert_allclose(ours_float.baseline_ecef[t], other.float_baseline, rtol=0, atol=1 * MM)
    assert ours.ratio[t] == pytest.approx(other.ratio, rel=0.01)


# Simulated data.


@pytest.fixture(scope="module")
def roof():
    """A minute of two antennas 1.167 m apart, GPS and Galileo."""
    return simulated(systems="GE")


def simulated(seed=1, **changes):
    geometry = prepare_geometry(short_preset(**changes))
    return observe(geometry, geometry.preset.noise, np.random.default_rng(seed))


def solved(simulation, verb=solve_relative, **options):
    if verb is solve_relative:
        options.setdefault("base_position", simulation.truth.position_ecef[0])
    return verb(*simulation.observations[:2], simulation.ephemerides, **options)


def assert_true(solution, simulation, sigmas=5.0, least_fixed=0.95):
    """Fixed epochs lie within so many of their own sigmas of the truth, and there are enough of them."""
    is_fixed = solution.status == Status.FIXED
    assert is_fixed.mean() >= least_fixed
    error = solution.baseline_enu[is_fixed] - simulation.truth.baselines_enu[0][is_fixed]
    sigma = np.sqrt(np.diagonal(solution.Q_enu[is_fixed], axis1=1, axis2=2))
    assert (np.abs(error) < sigmas * sigma).all()
    assert (np.linalg.norm(error, axis=1) < WRONG).all()


@pytest.mark.parametrize("options", [{}, {"static": True}, {"single_epoch": True}, {"frequencies": 1}], ids=str)
def test_simulated_truth_is_recovered(roof, options):
    assert_true(solved(roof, **options), roof, least_fixed=0.8 if options == {"frequencies": 1} else 0.95)


@pytest.mark.parametrize("system", ["G", "E", "C"])
def test_one_system_is_enough(system):
    simulation = simulated(systems=system)
    assert_true(solved(simulation, systems=system), simulation)


def test_qzss_alone_may_be_too_few_but_helps_the_others(roof):
    simulation = simulated(systems="GJ")
    both, one = solved(simulation, systems="GJ"), solved(simulation, systems="G")
    assert (both.satellites > one.satellites).all()
    assert_true(both, simulation)


@pytest.mark.parametrize(
    "clocks",
    [
        (Clock(offset=4e-4), Clock(offset=-4.5e-4)),
        (Clock(offset=-3e-3), Clock(offset=2e-3)),
        (Clock(drift=4e-5, jump=1e-3), Clock(drift=-2e-5, jump=1e-3)),
    ],
    ids=["0.85 ms", "5 ms", "jumps of 1 ms"],
)
def test_receiver_clocks_apart_by_milliseconds_do_no_harm(clocks):
    simulation = simulated(systems="GE", clocks=clocks)
    assert_true(solved(simulation), simulation)
    assert_true(solved(simulation, solve_moving), simulation)


def test_tags_on_either_side_of_a_change_of_ephemerides_do_no_harm():
    simulation = simulated(systems="G", start="2024-06-24T08:59:30")
    changed = _with_other_clocks_from(simulation.ephemerides, np.datetime64("2024-06-24T10:00:00"))
    master, rover = simulation.observations
    options = {"base_position": simulation.truth.position_ecef[0]}
    same, apart = (solve_relative(master, receiver, changed, **options) for receiver in (rover, _tagged_earlier(rover, 1e-3)))
    assert (same.status == Status.FIXED).all()
    assert (apart.status == Status.FIXED).all()
    np.testing.assert_allclose(apart.baseline_ecef, same.baseline_ecef, rtol=0, atol=MICROMETRE)


def _with_other_clocks_from(ephemerides, toe):
    """Return the ephemerides with satellite clocks up to 1.2 m off in the data sets from `toe` on, as real ones are."""
    off = (ephemerides.toe >= toe) * 1e-9 * np.array([int(name[1:]) % 5 for name in ephemerides.satellite])
    return replace(ephemerides, af0=ephemerides.af0 + off)


def _tagged_earlier(observations, seconds):
    """Return the same measurements by a receiver whose clock is late: tags and codes are less by as much."""
    time = observations.time - np.timedelta64(round(seconds * 1e9), "ns")
    return replace(observations, time=time, tables={system: _codes_less(table, seconds) for system, table in observations.tables.items()})


def _codes_less(table, seconds):
    is_code = np.array([code[0] == "C" for code in table.codes])
    return replace(table, value=table.value - SPEED_OF_LIGHT * seconds * is_code)


def test_a_turning_rover_is_followed():
    simulation = simulated(systems="GE", trajectory=Turntable(still=10.0, rate_deg_s=6.0), antennas=((0.0, -0.6, 0.0), (0.0, 0.6, 0.0)))
    assert_true(solved(simulation, solve_moving), simulation)


def test_slips_and_gross_errors_leave_no_trace():
    simulation = simulated(
        systems="GE",
        events=(
            Slip(20, (1,), signals=("2W",)),
            Slip(40, (0,), is_flagged=False),
            *(GrossError(30, "C1C", 80.0, (1,), (name,)) for name in ("G11",)),
            *(GrossError(50, "L1C", 5.0, (1,), (name,)) for name in ("G11",)),
        ),
    )
    assert_true(solved(simulation), simulation, least_fixed=0.9)


@pytest.mark.parametrize("error", [50.0, 3e3, -299_792.458, 2e7, -2e7], ids=lambda error: f"{error:.0f} m")
@pytest.mark.parametrize("antenna", [0, 1])
def test_a_code_wrong_by_any_amount_spoils_no_other_epoch(error, antenna):
    simulation = simulated(systems="GE", events=(GrossError(30, "C1C", error, (antenna,), ("G11",)),))
    assert_true(solved(simulation), simulation, least_fixed=0.98)


def test_after_an_outage_the_fix_comes_back():
    simulation = simulated(systems="GE", events=(Outage(20, 24, (1,)),))
    solution = solved(simulation)
    assert len(solution.time) == 55
    assert (solution.status[-20:] == Status.FIXED).all()


def test_a_moving_master_gives_the_same_short_baseline_as_a_known_one(roof):
    """The master's own error of metres turns a baseline of 1 m by 1e-7."""
    moving, known = solved(roof, solve_moving), solved(roof)
    both = (moving.status == Status.FIXED) & (known.status == Status.FIXED)
    assert both.mean() > 0.95
    np.testing.assert_allclose(moving.baseline_enu[both], known.baseline_enu[both], rtol=0, atol=0.1 * MM)


def test_epochs_without_master_have_no_solution_and_a_row(roof):
    master, rover = roof.observations
    keep = np.ones(60, dtype=bool)
    keep[25:35] = False
    solution = solve_relative(keep_epochs(master, keep), rover, roof.ephemerides, base_position=roof.truth.position_ecef[0])
    assert (solution.time == rover.time).all()
    assert (solution.status[25:35] == Status.NONE).all()
    assert (solution.satellites[25:35] == 0).all()
    for values in (solution.baseline_enu, solution.baseline_ecef, solution.position_ecef, solution.Q_enu, solution.ratio):
        assert np.isnan(values[25:35]).all()
        assert np.isfinite(values[keep]).all()
    assert (solution.status[keep] > Status.NONE).all()
    assert repr(solution).startswith("Relative: 60 epochs, ")
    assert repr(solution).endswith(" 10 without solution")


def test_a_slower_master_serves_every_epoch_it_has(roof):
    master, rover = roof.observations
    solution = solve_relative(keep_epochs(master, np.arange(60) % 5 == 0), rover, roof.ephemerides, base_position=roof.truth.position_ecef[0])
    assert np.flatnonzero(solution.status).tolist() == list(range(0, 60, 5))


def test_too_few_satellites_give_no_solution(roof):
    """Three of one system: even the single point has four unknowns."""
    names = roof.satellites["G"][:3]
    few = simulated(satellites=names)
    with pytest.raises(ValueError, match="only 3 satellites"):
        solved(few, systems="G")


def test_a_higher_mask_uses_fewer_satellites(roof):
    low, high = solved(roof, mask_deg=10.0), solved(roof, mask_deg=35.0)
    assert (high.satellites < low.satellites).all()


def test_frequencies_named_by_signals_are_those_counted(roof):
    counted, named = solved(roof, frequencies=1), solved(roof, signals=("C1C",))
    np.testing.assert_array_equal(counted.baseline_enu, named.baseline_enu)


def test_nothing_given_is_changed(roof):
    for one in roof.observations:
        for table in one.tables.values():
            for array in (table.epoch, table.number, table.value, table.lli, table.ssi):
                array.flags.writeable = False
        one.time.flags.writeable = one.power_failure.flags.writeable = False
    base_position = roof.truth.position_ecef[0].copy()
    base_position.flags.writeable = False
    assert (solved(roof, base_position=base_position).status == Status.FIXED).any()


def test_progress_reaches_the_end(roof):
    told = []
    solved(roof, progress=lambda done, total: told.append((done, total)))
    assert told[-1] == (60, 60)


def test_axes_at_the_master_and_position_agree(roof):
    solution = solved(roof)
    base = roof.truth.position_ecef[0]
    np.testing.assert_allclose(solution.position_ecef - base, solution.baseline_ecef, atol=MICROMETRE)
    np.testing.assert_allclose(solution.baseline_ecef @ enu_rotation(base).T, solution.baseline_enu, atol=MICROMETRE)


# The base's place.


def test_the_base_stands_at_its_marker_plus_the_antenna_offset(roof):
    marker = roof.truth.position_ecef[0]
    header = replace(roof.observations[0].header, position_ecef=marker, antenna_delta_enu=np.array([0.1, -0.2, 1.5]))
    place = station_position(replace(roof.observations[0], header=header), roof.ephemerides)
    np.testing.assert_allclose(enu_rotation(marker) @ (place - marker), [0.1, -0.2, 1.5], atol=MICROMETRE)


def test_without_a_marker_the_base_stands_at_its_mean_single_point(roof):
    unmarked = replace(roof.observations[0], header=replace(roof.observations[0].header, position_ecef=None))
    place = station_position(unmarked, roof.ephemerides)
    assert np.linalg.norm(place - roof.truth.position_ecef[0]) < 10.0  # broadcast ionosphere left in, codes of 0.3 m: metres
    points = solve_points(unmarked, roof.ephemerides)
    np.testing.assert_allclose(place, points.position_ecef.mean(axis=0), atol=MM)
    solution = solve_relative(unmarked, roof.observations[1], roof.ephemerides)
    assert np.abs(solution.baseline_enu - roof.truth.baselines_enu[0])[solution.status == Status.FIXED].max() < 2 * CM


# Errors.


def test_no_common_epochs(roof):
    master, rover = roof.observations
    early, late = np.arange(60) < 20, np.arange(60) >= 20
    with pytest.raises(ValueError, match="no common epochs"):
        solve_relative(keep_epochs(master, early), keep_epochs(rover, late), roof.ephemerides)


def test_epochs_half_a_second_apart_are_told_so(roof):
    master, rover = roof.observations
    late = replace(rover, time=rover.time + np.timedelta64(500, "ms"))
    with pytest.raises(ValueError, match=r"within 25 ms.*20:00\.000 to .*, the rover .*20:00\.500 to .*sampled at the same instants"):
        solve_relative(master, late, roof.ephemerides)


def test_no_common_satellites(roof):
    with pytest.raises(ValueError, match="no common satellites"):
        solved(roof, systems="C")


@pytest.mark.parametrize(("systems", "words"), [("GR", "GLONASS .R. is read but has no orbits"), ("X", "unknown system 'X'"), ("", "no system")])
def test_a_system_that_cannot_be_used(roof, systems, words):
    with pytest.raises(ValueError, match=words):
        solved(roof, systems=systems)


def test_navigation_of_another_day(roof):
    other = prepare_geometry(short_preset(systems="GE", start="2024-06-20T08:20:00")).tracks.ephemerides
    with pytest.raises(ValueError, match=r"no position at any epoch: .* those given are for 2024-06-20"):
        solve_relative(*roof.observations, other, base_position=roof.truth.position_ecef[0])
    with pytest.raises(ValueError, match=r"no position at any epoch: .* those given are for 2024-06-20"):
        solve_moving(*roof.observations, other)


@pytest.mark.parametrize("position", [[1e6, 2e6], [np.nan] * 3, [[0.0, 0.0, 6.4e6]]], ids=["two", "nan", "nested"])
def test_a_base_position_that_is_none(roof, position):
    with pytest.raises(ValueError, match="base_position must be three finite ECEF coordinates"):
        solved(roof, base_position=position)


@pytest.mark.parametrize("static", [False, True])
def test_one_epoch_is_enough(roof, static):
    first = [keep_epochs(one, np.arange(60) == 0) for one in roof.observations]
    solution = solve_relative(*first, roof.ephemerides, base_position=roof.truth.position_ecef[0], static=static)
    assert solution.status.tolist() == [Status.FIXED]
    assert np.linalg.norm(solution.baseline_enu[0] - roof.truth.baselines_enu[0, 0]) < 2 * CM


def test_a_mask_above_all_satellites_leaves_every_epoch_without_solution(roof):
    solution = solved(roof, mask_deg=89.0)
    assert not solution.status.any()
    assert np.isnan(solution.baseline_enu).all()


def test_without_doppler_and_strength_it_goes_on(roof):
    bare = [without(one, "DS") for one in roof.observations]
    assert_true(solve_relative(*bare, roof.ephemerides, base_position=roof.truth.position_ecef[0]), roof)


def without(observations, kinds):
    """Return the observations without some kinds of measurements."""
    tables = {}
    for system, table in observations.tables.items():
        kept = [i for i, code in enumerate(table.codes) if code[0] not in kinds]
        arrays = {name: getattr(table, name)[:, kept] for name in ("value", "lli", "ssi")}
        tables[system] = replace(table, codes=tuple(table.codes[i] for i in kept), **arrays)
    return replace(observations, tables=tables)


# Acceptance.


def test_acceptance_is_that_of_a_fitted_fixed_failure_rate():
    """RTKLIB demo5's thresholds, fitted to a fixed failure rate, by number of double differences, for its nominal ratio of 3."""
    rows = [row for row in json.loads(REFERENCE.read_text())["ar_threshold_demo5"]["rows"] if row[0] == 3]
    assert len(rows) == 4
    for _, pairs, threshold in rows:
        assert ratio_threshold(pairs) == pytest.approx(threshold, rel=0.2), f"{pairs} pairs"


def test_acceptance_falls_with_the_number_of_integers_to_a_floor():
    thresholds = ratio_threshold(np.arange(1, 200))
    assert (np.diff(thresholds) <= 0).all()
    assert thresholds[0] == 17.0
    assert thresholds[-1] == 1.5
    assert ratio_threshold(0) == ratio_threshold(1)


def test_stricter_acceptance_fixes_less(roof):
    fixed = [(solved(roof, systems="E", frequencies=1, single_epoch=True, acceptance=c).status == Status.FIXED).sum() for c in (4.0, 16.0, 400.0)]
    assert fixed[0] >= fixed[1] >= fixed[2]
    assert fixed[0] > fixed[2]


# One source, compiled and plain.

PROGRAM = """
import json
import numpy as np
from gnsslab.core import jit
from gnsslab.gnss.relative import solve_relative
from gnsslab.simulate import find_preset, simulate
from dataclasses import replace
s = simulate(replace(find_preset("static-baseline"), duration=8.0, systems="G"), np.random.default_rng(2))
r = solve_relative(*s.observations, s.ephemerides, systems="G", frequencies=1)
print(json.dumps([jit.COMPILED, r.status.tolist(), r.baseline_enu.tolist(), r.Q_enu.tolist(), r.ratio.tolist()]))
"""


def answers(**environment):
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path), **environment}
    done = subprocess.run([sys.executable, "-W", "error", "-c", PROGRAM], env=environment, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_the_same_answers_without_compilation():
    pytest.importorskip("numba")
    compiled, plain = answers(GNSSLAB_NO_NUMBA="0"), answers(GNSSLAB_NO_NUMBA="1")
    assert (compiled[0], plain[0]) == (True, False)
    assert compiled[1] == plain[1]
    for a, b in zip(compiled[2:], plain[2:], strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-6, atol=MICROMETRE**2)


def test_a_base_that_stands_elsewhere_is_refused(campaign):
    roof = campaign("matrtklib-static")
    with pytest.raises(ValueError, match=r"the base position is 1\.7 km from where the base's own codes place it"):
        solve_relative(roof.base, roof.rover, roof.ephemerides, base_position=roof.facts.base_position + 1000.0)


def test_single_epochs_at_rest_are_not_averaged(campaign):
    roof = campaign("matrtklib-static")
    options = {"base_position": roof.facts.base_position, "systems": "G", "single_epoch": True}
    at_rest = solve_relative(roof.base, roof.rover, roof.ephemerides, static=True, **options)
    moving = solve_relative(roof.base, roof.rover, roof.ephemerides, **options)
    np.testing.assert_array_equal(at_rest.baseline_enu, moving.baseline_enu)


def test_a_header_that_the_codes_contradict_is_not_believed(campaign):
    """Some programs write a position tens of kilometres off, or that of another day: the codes then say where the base is."""
    roof = campaign("matrtklib-static")
    astray = replace(roof.base, header=replace(roof.base.header, position_ecef=roof.base.header.position_ecef + 5000.0))
    assert np.linalg.norm(station_position(astray, roof.ephemerides) - roof.facts.base_position) < 5.0
    assert (solve_relative(astray, roof.rover, roof.ephemerides).status == Status.FIXED).all()
