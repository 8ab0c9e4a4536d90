"""Paper A's filter: against a second one written differently, against statistics of noise drawn as assumed, and what must not matter."""

import json
import os
import subprocess
import sys
from dataclasses import fields, replace

import numpy as np
import pytest
from joint_filter import run_jointly

from gnsslab.core.jit import COMPILED
from gnsslab.gnss import blocks
from gnsslab.gnss.differences import difference_pairs
from gnsslab.gnss.preparation import prepare_moving
from gnsslab.simulate import LOW_COST, Gap, Outage, Slip, Turntable, find_preset, simulate
from gnsslab.systems.constrained_filter import FilterSettings, direct_path, run_filter, steady_path
from gnsslab.systems.dual_antenna import A_STATIC, A_TURNTABLE
from gnsslab.systems.length_row import LengthUse, RowState

MM, NANOMETRE = 1e-3, 1e-9
ROUNDING = 100 * NANOMETRE  # ambiguities are open by 100 m in common: 3e5 cycles^2, of which doubles keep 6e-11
T, SLIPPED, SETS, RISES = 30, 17, 9, 13
ALL = np.arange(T)
HOLD = 3
OPTIONS = A_STATIC.filter.__class__(hold_after=HOLD)


def prepared_case(*events, seed=3):
    """Return half a minute of the turntable, turning from the eighth second on, Prepared for the filter; and the true baselines."""
    preset = replace(find_preset("paper-a-turntable"), duration=float(T), trajectory=Turntable(still=8.0), noise=LOW_COST, events=events)
    simulation = simulate(preset, np.random.default_rng(seed))
    prepared = prepare_moving(*simulation.observations, simulation.ephemerides, A_TURNTABLE.settings)
    return prepared, simulation.truth.baselines_enu[0][prepared.model.pair.epoch]


@pytest.fixture(scope="module")
def prepared():
    """All slip at one epoch; one satellite is hidden for some epochs, another one's data have a short hole that its count survives."""
    names = prepared_case()[0].model.pair.satellites
    hidden = Outage(SETS, RISES - 1, antennas=(1,), satellites=names[:1])
    return prepared_case(Slip(SLIPPED, antennas=(1,)), hidden, Gap(22, 23, antennas=(1,), satellites=names[-1:]))[0]


def steady(prepared):
    return steady_path(prepared, A_TURNTABLE.velocity_noise)


PATHS = pytest.mark.parametrize("path_of", [steady, direct_path], ids=["steady", "direct"])
USES = pytest.mark.parametrize("use", list(LengthUse), ids=lambda use: use.name)


def assert_same(run, other, metre=ROUNDING):
    """Compare two runs, whatever they are called: all but the last digits."""
    for name in ("baseline_float", "baseline_fixed", "velocity"):
        np.testing.assert_allclose(getattr(run, name), getattr(other, name), rtol=0, atol=metre, err_msg=name)
    for name in ("Q_float", "Q_fixed"):
        np.testing.assert_allclose(getattr(run, name), getattr(other, name), rtol=1e-5, atol=(1 * MM) ** 2 * 1e-3, err_msg=name)
    np.testing.assert_allclose(run.ratio, other.ratio, rtol=1e-4)
    np.testing.assert_allclose(run.nis_code, other.nis_code, rtol=1e-5)
    assert (run.is_held == other.is_held).all()


def test_the_case_at_hand_is_a_good_one(prepared):
    usable, slip = prepared.model.usable, prepared.model.slip
    assert len(list(blocks._spans(usable))) >= 5, "a satellite sets and rises, another one is away for two epochs"
    assert (slip[SLIPPED] == usable[SLIPPED]).all()
    run = run_filter(prepared, steady(prepared), OPTIONS)
    assert run.is_held.any()
    assert not run.is_held.all()


# The second implementation.


@USES
@PATHS
def test_the_joint_filter_agrees(prepared, path_of, use):
    settings = replace(OPTIONS, length_use=use)
    run, joint = (filter_(prepared, path_of(prepared), settings) for filter_ in (run_filter, run_jointly))
    assert_same(run, joint)
    np.testing.assert_allclose(run.nis_code + run.nis_phase, joint.nis, rtol=1e-5, atol=1e-6)


@pytest.mark.parametrize(("length", "length_sigma"), [(1.167, 0.002), (1.10, 0.03)], ids=["tight", "wrong"])
def test_another_length_and_sigma_are_used_alike(prepared, length, length_sigma):
    settings = replace(OPTIONS, length_use=LengthUse.SEARCH, length=length, length_sigma=length_sigma)
    assert_same(*(filter_(prepared, steady(prepared), settings) for filter_ in (run_filter, run_jointly)))


def test_innovations_and_their_sigma_are_those_of_the_carriers_given_the_codes(prepared):
    """The joint filter has other references: z_i - z_r of channels i and r is the innovation of i against r."""
    run, joint = (filter_(prepared, steady(prepared), replace(OPTIONS, hold_after=0)) for filter_ in (run_filter, run_jointly))
    group, usable, compared = prepared.model.pair.group, prepared.model.usable, 0
    for t, (z, S, channels, references) in enumerate(joint.phase_innovation):
        single = np.zeros((usable.shape[1], len(z)))  # of each channel against the joint filter's reference
        single[channels, range(len(z))] = 1.0
        for g in np.unique(group[channels]):
            members = np.flatnonzero(usable[t] & (group == g))
            (reference,) = members[np.isnan(run.innovation[t, members])]
            assert references[[group[i] for i in channels].index(g)] == members[0]
            for i in members[members != reference]:
                T_i = single[i] - single[reference]
                assert run.innovation[t, i] == pytest.approx(T_i @ z, abs=1e-6)
                assert run.innovation_sigma[t, i] == pytest.approx(np.sqrt(T_i @ S @ T_i), rel=1e-5)
                compared += 1
        assert np.isnan(run.innovation[t, ~usable[t]]).all()
    assert compared > 10 * T


def test_the_float_solution_is_least_squares_of_all_epochs_at_once(prepared):
    """Batch: motion, ambiguities of every epoch and all measurements in one system, whose last epoch is what a filter knows then."""
    epochs = 7
    part = first_epochs(prepared, epochs)
    model, path = part.model, steady(part)
    run = run_filter(part, path, replace(OPTIONS, length_use=LengthUse.NOWHERE, hold_after=0))
    c, opened = model.usable.shape[1], 1 / 100.0  # [1/m], weight of an ambiguity just opened
    n = 6 + c
    A, y = [], []

    def add(rows, values, *at):
        wide = np.zeros((len(rows), n * epochs))
        for t, part_ in at:
            wide[:, n * t : n * t + n] += part_
        A.append(rows @ wide if rows.shape[1] == len(wide) else wide)
        y.append(values)

    for t in range(epochs):
        move = np.eye(6, n)
        W = np.linalg.inv(np.linalg.cholesky(path.Q[t] + 1e-12 * np.eye(6)))
        add(W, W @ path.offset[t], (t, move), *([(t - 1, -path.F[t] @ move)] if t else []))
        ambiguity = np.hstack([np.zeros((c, 6)), np.diag(model.pair.wavelength)])
        if t:
            W = np.eye(c) / np.sqrt(path.drift[t])
            add(W, np.zeros(c), (t, ambiguity), (t - 1, -ambiguity))
        else:
            add(opened * np.eye(c), opened * (model.phase[0] - model.code[0]), (0, ambiguity))
        D = np.vstack([np.eye(c)[others] - np.eye(c)[first] for first, others in groups_of(model)])
        for values, sigma, phase in ((model.code[t], model.sigma_code[t], 0.0), (model.phase[t], model.sigma_phase[t], 1.0)):
            W = np.linalg.inv(np.linalg.cholesky(D @ np.diag(sigma**2) @ D.T))
            H = np.hstack([model.design[t], np.zeros((c, 3)), phase * np.diag(model.pair.wavelength)])
            add(W, W @ D @ (values + model.design[t] @ model.near[t]), (t, D @ H))
    A, y = np.vstack(A), np.concatenate(y)
    scale = np.linalg.norm(A, axis=0)
    x = np.linalg.lstsq(A / scale, y, rcond=1e-15)[0] / scale
    b = rotation(part)[-1] @ x[n * (epochs - 1) : n * (epochs - 1) + 3]
    np.testing.assert_allclose(run.baseline_float[-1], b, rtol=0, atol=0.01 * MM)


def groups_of(model):
    """Yield the first channel of each group and the others."""
    for group in np.unique(model.pair.group):
        first, *others = np.flatnonzero(model.pair.group == group)
        yield first, others


def rotation(prepared):
    from gnsslab.gnss.frames import enu_rotation

    return enu_rotation(prepared.master_ecef)


def first_epochs(prepared, epochs):
    """Return the first epochs of the Prepared, all channels being usable there."""
    assert prepared.model.usable[:epochs].all()
    return cut(prepared, slice(0, epochs))


def cut(prepared, span):
    """Return some epochs of the Prepared."""
    T_all = len(prepared.model.near)

    def part(record):
        arrays = {field.name: getattr(record, field.name) for field in fields(record)}
        return replace(record, **{k: v[span] for k, v in arrays.items() if isinstance(v, np.ndarray) and v.shape[:1] == (T_all,)})

    model = replace(part(prepared.model), pair=part(prepared.model.pair))
    return prepared._replace(**{name: getattr(prepared, name)[span] for name in prepared._fields if name != "model"}, model=model)


# The printed formulas.


def test_prediction_as_printed_never_learns_the_velocity(prepared):
    """(25) without F' against the same equation in whole matrices that may lose their symmetry; at rest it does no harm, turning it does."""
    settings = replace(OPTIONS, printed_prediction=True)
    run, joint = (filter_(prepared, steady(prepared), settings) for filter_ in (run_filter, run_jointly))
    assert_same(run, joint)
    assert np.abs(run.velocity).max() < 1 * MM


def test_the_baseline_printed_stands_still_where_it_turns():
    """At 6 degrees a second the end of 1.167 m moves at 12 cm/s: the mended prediction learns that."""
    prepared, truth = prepared_case()
    velocity = np.gradient(truth, axis=0)[-10:]
    assert np.linalg.norm(velocity, axis=1) == pytest.approx(0.122, abs=0.003)
    off = {}
    for printed in (False, True):
        run = run_filter(prepared, steady(prepared), replace(OPTIONS, printed_prediction=printed))
        off[printed] = np.linalg.norm(run.velocity[-10:] - velocity, axis=1).mean()
    assert off[False] < 0.05
    assert off[True] > 0.10


@pytest.mark.parametrize("use", [LengthUse.NOWHERE, LengthUse.GUARDED_ROW], ids=lambda use: use.name)
def test_residuals_as_printed_leave_the_range_in(prepared, use):
    settings = replace(OPTIONS, printed_residual=True, length_use=use)
    run, joint = (filter_(prepared, steady(prepared), settings) for filter_ in (run_filter, run_jointly))
    assert_same(run, joint, metre=0.01 * MM)  # the baseline runs away by many metres, and rounding with it


# Health.


def drawn(prepared, path, rng):
    """Return the Prepared with measurements drawn exactly as the filter assumes them: its motion, its white noise, whole cycles."""
    model = prepared.model
    x, b = np.zeros(6), np.zeros_like(model.near)
    for t, (F, Q, offset) in enumerate(zip(path.F, path.Q, path.offset, strict=True)):
        x = F @ x + offset + rng.multivariate_normal(np.zeros(6), Q)
        b[t] = x[:3]
    cycles = np.cumsum(np.where(model.slip, rng.integers(-50, 50, model.slip.shape), 0), axis=0)
    drift = np.cumsum(rng.standard_normal(model.code.shape) * np.sqrt(path.drift)[:, None], axis=0)
    ranges = np.einsum("tci,ti->tc", model.design, b - model.near) + rng.uniform(-30, 30, (len(b), 1))  # a clock of its own each epoch
    code = ranges + rng.standard_normal(model.code.shape) * model.sigma_code
    phase = ranges + cycles * model.pair.wavelength + drift + rng.standard_normal(model.phase.shape) * model.sigma_phase
    return prepared._replace(model=replace(model, code=code, phase=phase)), b


def test_nis_is_chi_square_where_the_noise_is_as_assumed(prepared, rng):
    """Sums over epochs and 40 draws; a sum of N has the mean N and the variance 2 N. Epochs that open ambiguities left out: their prior is loose."""
    path, settings = steady(prepared), replace(OPTIONS, length_use=LengthUse.NOWHERE, hold_after=0)
    counted = ~prepared.model.slip.any(axis=1) & (np.arange(T) > 0) & (np.arange(T) != RISES)
    total, freedom, off = np.zeros(2), 0, []
    for _ in range(40):
        case, truth = drawn(prepared, path, rng)
        run = run_filter(case, path, settings)
        total += run.nis_code[counted].sum(), run.nis_phase[counted].sum()
        freedom += run.freedom[counted].sum()
        off.append(np.linalg.solve(run.Q_float[-1], miss := run.baseline_float[-1] - rotation(case)[-1] @ truth[-1]) @ miss)
    assert np.abs(total - freedom).max() < 4.5 * np.sqrt(2 * freedom)
    assert np.sum(off) == pytest.approx(3 * 40, abs=4.5 * np.sqrt(2 * 3 * 40)), "and the true error is as large as its sigma says"


def test_noise_taken_for_half_doubles_sigmas(prepared, rng):
    """The check can fail: with sigmas of half the true size NIS is four times as large."""
    path, settings = steady(prepared), replace(OPTIONS, length_use=LengthUse.NOWHERE, hold_after=0)
    case, _ = drawn(prepared, path, rng)
    halved = replace(case.model, sigma_code=case.model.sigma_code / 2, sigma_phase=case.model.sigma_phase / 2)
    run = run_filter(case._replace(model=halved), path, settings)
    assert run.nis_code.sum() > 2 * run.freedom.sum()


def test_what_was_measured_is_what_is_counted(prepared):
    run = run_filter(prepared, steady(prepared), OPTIONS)
    usable, group = prepared.model.usable, prepared.model.pair.group
    for t in range(T):
        assert run.freedom[t] == usable[t].sum() - len(np.unique(group[usable[t]]))
        assert np.isfinite(run.innovation[t]).sum() == run.freedom[t]


def test_states_of_the_row(prepared):
    """Dropped while codes alone tell of the baseline, used when carriers with known ambiguities do; a row at every epoch is never dropped."""
    path = steady(prepared)
    guarded = run_filter(prepared, path, OPTIONS)
    sure = np.array([np.trace(Q) for Q in run_filter(prepared, path, replace(OPTIONS, length_use=LengthUse.NOWHERE)).Q_float]) / 3 < 0.1167**2
    assert guarded.row_state[0] == RowState.DROPPED
    first_used = np.argmax(guarded.row_state == RowState.USED)
    assert 0 < first_used == np.argmax(sure)
    assert (np.isnan(guarded.row_innovation) == (guarded.row_state != RowState.USED)).all()
    assert (run_filter(prepared, path, replace(OPTIONS, length_use=LengthUse.ROW)).row_state == RowState.USED).all()
    for use in (LengthUse.NOWHERE, LengthUse.SEARCH):
        assert (run_filter(prepared, path, replace(OPTIONS, length_use=use)).row_state == RowState.NONE).all()


def test_held_from_the_wanted_count_of_fixes_on(prepared):
    path = steady(prepared)
    for hold_after in (1, 2, 4):
        run = run_filter(prepared, path, replace(OPTIONS, hold_after=hold_after))
        streak = 0
        for is_fixed, is_held in zip(run.is_fixed, run.is_held, strict=True):
            streak = streak + 1 if is_fixed else 0
            assert is_held == (streak >= hold_after)
        assert run.is_held.any()
    assert not run_filter(prepared, path, replace(OPTIONS, hold_after=0)).is_held.any()


def test_best_baseline_and_first_fix(prepared):
    ratio = float(np.median(run_filter(prepared, steady(prepared), replace(OPTIONS, hold_after=0)).ratio))
    run = run_filter(prepared, steady(prepared), replace(OPTIONS, ratio=ratio, hold_after=0))
    assert 0 < run.is_fixed.sum() < T
    assert (run.is_fixed == (run.ratio >= ratio)).all()
    np.testing.assert_array_equal(run.baseline[run.is_fixed], run.baseline_fixed[run.is_fixed])
    np.testing.assert_array_equal(run.baseline[~run.is_fixed], run.baseline_float[~run.is_fixed])
    np.testing.assert_array_equal(run.Q[~run.is_fixed], run.Q_float[~run.is_fixed])
    assert run.first_fix == np.flatnonzero(run.is_fixed)[0]
    assert run_filter(prepared, steady(prepared), replace(OPTIONS, ratio=1e9)).first_fix is None


# What must not matter.


@pytest.mark.parametrize("cuts", [(1,), (SLIPPED,), tuple(range(1, T))], ids=["first", "at the slip", "everywhere"])
@pytest.mark.parametrize("use", [LengthUse.GUARDED_ROW, LengthUse.SEARCH], ids=lambda use: use.name)
def test_cutting_a_block_changes_nothing(prepared, monkeypatch, cuts, use):
    """The count of fixes in a row goes on from block to block, and the reference that changes with them does not matter."""
    path, settings = steady(prepared), replace(OPTIONS, length_use=use)
    run = run_filter(prepared, path, settings)
    bounds = sorted({*(first for first, _ in blocks._spans(prepared.model.usable)), *cuts})
    monkeypatch.setattr(blocks, "_spans", lambda usable: zip(bounds, [*bounds[1:], T], strict=True))
    assert_same(run_filter(prepared, path, settings), run)


def test_the_choice_of_reference_changes_nothing(prepared, monkeypatch, rng):
    path = steady(prepared)
    run = run_filter(prepared, path, OPTIONS)
    monkeypatch.setattr(blocks, "difference_pairs", lambda group, goodness: difference_pairs(group, rng.random(len(group))))
    other = run_filter(prepared, path, OPTIONS)
    assert (np.isnan(run.innovation) != np.isnan(other.innovation)).any(), "no reference has changed"
    assert_same(other, run)


def test_runs_do_not_remember_each_other_and_leave_their_arguments_alone(prepared):
    path = steady(prepared)
    for record in (prepared.model, prepared.model.pair):
        for field in fields(record):
            if isinstance(getattr(record, field.name), np.ndarray):
                getattr(record, field.name).flags.writeable = False
    for array in path:
        array.flags.writeable = False
    once, again = (run_filter(prepared, path, OPTIONS) for _ in range(2))
    for one, other in zip(once, again, strict=True):
        np.testing.assert_array_equal(one, other)


def test_progress_is_told(prepared):
    heard = []
    run_filter(prepared, steady(prepared), OPTIONS, progress=lambda done, total: heard.append((done, total)))
    assert heard[-1] == (T, T)
    assert heard == sorted(heard)


PROGRAM = """
import json, sys
import numpy as np
sys.path.insert(0, {folder!r})
from test_constrained_filter import *
case = cut(prepared_case(Slip(7, antennas=(1,)))[0], slice(0, 10))
answers = []
for use in LengthUse:
    for options in ({{}}, {{"printed_prediction": True}}, {{"printed_residual": True}}):
        run = run_filter(case, steady(case), replace(OPTIONS, length_use=use, **options))
        answers.append([np.nan_to_num(array).tolist() for array in run])
print(json.dumps([COMPILED, answers]))
"""


@pytest.mark.skipif(not COMPILED, reason="there is no compiler to compare with")
def test_same_answers_with_and_without_compilation():
    answers = {}
    for switch in ("0", "1"):
        environment = {**os.environ, "GNSSLAB_NO_NUMBA": switch, "PYTHONPATH": os.pathsep.join(sys.path)}
        program = PROGRAM.format(folder=os.path.dirname(__file__))
        done = subprocess.run([sys.executable, "-c", program], env=environment, capture_output=True, text=True, timeout=300)
        assert done.returncode == 0, done.stderr
        compiled, answers[switch] = json.loads(done.stdout)
        assert compiled == (switch == "0")
    assert len(answers["0"]) == 3 * len(LengthUse)
    assert answers["1"] == answers["0"]  # to the last bit: same operations in the same order


# Bad calls.


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"length": 0.0}, "the length between the antennas must be more than 0 m, not 0"),
        ({"length": np.nan}, "the length between the antennas must be more than 0 m, not nan"),
        ({"length_sigma": -0.1}, "the sigma of the length must be more than 0 m, not -0.1"),
        ({"ratio": 0.5}, "the ratio must be 1 or more"),
        ({"hold_after": -1}, "hold_after counts fixes in a row, 0 for never; it is -1"),
        ({"hold_sigma": 0.0}, "the sigma of held integers must be more than 0 cycles, not 0"),
    ],
)
def test_settings_without_sense_are_refused(prepared, wrong, words):
    with pytest.raises(ValueError, match=words):
        run_filter(prepared, steady(prepared), replace(FilterSettings(), **wrong))
