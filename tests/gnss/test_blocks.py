"""Blocks: how epochs are cut into blocks, which satellite is the reference and how they are ordered must not matter."""

from dataclasses import fields, replace

import numpy as np
import pytest
from small_observations import short_preset

from gnsslab.gnss import blocks, motion
from gnsslab.gnss.differences import difference_pairs, pair_receivers
from gnsslab.gnss.modelling import build_model
from gnsslab.gnss.screening import LONGEST_GAP, cycle_slips
from gnsslab.gnss.weighting import NoiseModel
from gnsslab.simulate import Gap, Slip, observe, prepare_geometry

NANOMETRE, MILLIMETRE = 1e-9, 1e-3
ROUNDING = 100 * NANOMETRE  # single-difference ambiguities are open by 100 m in common: 2e5 cycles^2, of which doubles keep 3e-11
T, K = 60, 30
ALL = np.arange(T)


@pytest.fixture(scope="module")
def prepared():
    """Model and Path of a minute of GPS and Galileo on two bands, with a slip and a gap, started 3 m off."""
    geometry = prepare_geometry(short_preset(systems="GE", events=(Slip(K, (1,), signals=("2W",)), Gap(40, 42, (1,), signals=("5Q",)))))
    simulation = observe(geometry, geometry.preset.noise, np.random.default_rng(5))
    pair = pair_receivers(*simulation.observations)
    master, rover = simulation.truth.position_ecef, simulation.truth.position_ecef + np.array([3.0, -2.0, 1.0])
    path = motion.moving(pair.time, rover - master)
    model = build_model(pair, master, rover, simulation.ephemerides, np.radians(15.0), NoiseModel(), np.zeros(T, dtype=bool))
    return model, path


@pytest.fixture(scope="module")
def solution(prepared):
    """Its solution in the usual blocks."""
    return blocks.run_blocks(*prepared)


def assert_same(one, other):
    """Compare two solutions: all but the last digits."""
    for a, b in ((one.outcome.baseline_float, other.outcome.baseline_float), (one.outcome.baseline_fixed, other.outcome.baseline_fixed)):
        np.testing.assert_allclose(a, b, rtol=0, atol=ROUNDING)
    for name in ("Q_float", "Q_fixed", "misfit", "freedom"):
        a, b = getattr(one.outcome, name), getattr(other.outcome, name)
        np.testing.assert_allclose(a, b, rtol=1e-5, atol=1e-5 * np.abs(a).max(axis=tuple(range(1, a.ndim)), keepdims=True).min())
    np.testing.assert_allclose(one.outcome.ratio, other.outcome.ratio, rtol=1e-4)
    assert (one.satellites == other.satellites).all()
    assert (one.outcome.integers == other.outcome.integers).all()


def test_the_case_at_hand_is_a_good_one(prepared, solution):
    assert len(list(blocks._spans(prepared[0].usable))) == 3, "the gap cuts three blocks"
    assert prepared[0].slip[K].any()
    assert (solution.outcome.ratio[1:] > 3).all()
    assert (np.diff(solution.outcome.integers) != 0).sum() == 2


@pytest.mark.parametrize("cuts", [(1,), (K,), (K + 1, 41), tuple(range(1, T))], ids=["first", "at the slip", "two", "everywhere"])
def test_cutting_a_block_changes_nothing(prepared, solution, monkeypatch, cuts):
    natural = [first for first, _ in blocks._spans(prepared[0].usable)]
    bounds = sorted({*natural, *cuts})
    monkeypatch.setattr(blocks, "_spans", lambda usable: zip(bounds, [*bounds[1:], T], strict=True))
    assert_same(blocks.run_blocks(*prepared), solution)


@pytest.mark.parametrize("goodness", [lambda elevation: -elevation, lambda elevation: np.sin(1e3 * elevation)], ids=["lowest", "any"])
def test_the_choice_of_reference_changes_nothing(prepared, solution, monkeypatch, goodness):
    monkeypatch.setattr(blocks, "difference_pairs", lambda group, elevation: difference_pairs(group, goodness(elevation)))
    assert_same(blocks.run_blocks(*prepared), solution)


def test_a_reference_that_changes_at_every_epoch_changes_nothing(prepared, solution, monkeypatch, rng):
    monkeypatch.setattr(blocks, "_spans", lambda usable: zip(range(T), range(1, T + 1), strict=True))
    monkeypatch.setattr(blocks, "difference_pairs", lambda group, elevation: difference_pairs(group, rng.random(len(group))))
    assert_same(blocks.run_blocks(*prepared), solution)


def with_channels(model, order):
    """Return the model with its channels in another order, or only some of them."""
    c = len(model.pair.band)

    def reordered(record):
        arrays = {field.name: getattr(record, field.name) for field in fields(record)}
        dense = {k: v[:, order] for k, v in arrays.items() if isinstance(v, np.ndarray) and v.ndim > 1 and v.shape[1] == c}
        return replace(record, **dense, **{k: v[order] for k, v in arrays.items() if isinstance(v, np.ndarray) and v.shape == (c,)})

    return replace(reordered(model), pair=reordered(model.pair))


def test_the_order_of_channels_changes_nothing(prepared, solution, rng):
    model, path = prepared
    assert_same(blocks.run_blocks(with_channels(model, rng.permutation(len(model.pair.band))), path), solution)


def hidden(model, epochs):
    """Return the model with nothing usable at some epochs."""
    usable = model.usable.copy()
    usable[epochs] = False
    return replace(model, usable=usable, slip=cycle_slips(model.pair, usable, model.sigma_phase))


@pytest.mark.parametrize(("missing", "continues"), [(LONGEST_GAP - 1, True), (LONGEST_GAP + 1, False)])
def test_ambiguities_outlive_a_short_darkness_and_not_a_long_one(prepared, missing, continues):
    """Known ambiguities hold the float baseline where it was, to centimetres; new ones leave it to the codes, as slips of all carriers do."""
    model, path = prepared
    after = 10 + missing
    dark = hidden(model, slice(10, after))
    slipped = replace(dark, slip=dark.slip | (after == ALL)[:, None])
    b, b_slipped = (blocks.run_blocks(one, path).outcome.baseline_float for one in (dark, slipped))
    assert (np.abs(b[after] - b_slipped[after]).max() > MILLIMETRE) == continues
    if continues:
        assert np.linalg.norm(b[after] - b[9]) < 20 * MILLIMETRE


def test_epochs_without_measurements_have_neither_satellites_nor_integers(prepared):
    model, path = prepared
    dark = blocks.run_blocks(hidden(model, slice(20, 23)), path)
    assert (dark.satellites[20:23] == 0).all()
    assert (dark.outcome.integers[20:23] == 0).all()
    assert (dark.outcome.ratio[20:23] == 0).all()
    assert (dark.satellites[23:] > 4).all()


def test_satellites_count_only_where_they_are_differenced(prepared):
    model, path = prepared
    lonely = model.usable & ((model.pair.group != model.pair.group[0])[None] | (ALL[:, None] % 2 == 0) | (np.arange(len(model.pair.band)) == 0))
    counts = blocks.run_blocks(replace(model, usable=lonely), path).satellites
    names = [{model.pair.satellite[i] for i in np.flatnonzero(row & (model.pair.group != model.pair.group[0]))} for row in model.usable]
    first = model.pair.satellite[0]
    expected = [len(seen) for seen in names]
    assert [int(n) for n in counts[1:K:2]] == expected[1:K:2], f"satellite {first} on one band alone has nothing to be differenced with"


def test_progress_ends_at_the_last_epoch(prepared):
    told = []
    blocks.run_blocks(*prepared, progress=lambda done, total: told.append((done, total)))
    assert told[-1] == (T, T)
    assert told == sorted(told)


def test_the_filter_leaves_what_it_is_given_alone(prepared):
    model, path = prepared
    for record in (model, model.pair, model.pair.master, model.pair.rover):
        for field in fields(record):
            if isinstance(value := getattr(record, field.name), np.ndarray):
                value.flags.writeable = False
    blocks.run_blocks(replace(model, near=model.near.copy()), path)  # a view of read-only memory would be compiled for anew: 10 s
