"""Paper A reproduced: its calibrated numbers come out over twenty draws, its claims are judged by numbers, ours are found on a second route."""

import numpy as np
import pytest

from gnsslab.core.rotations import heading_pitch_of
from gnsslab.gnss.preparation import prepare_moving
from gnsslab.reproduce import paper_a
from gnsslab.reproduce.paper_a_formulas import formula_numbers
from gnsslab.reproduce.papers import reproduced
from gnsslab.reproduce.rule import DOES_NOT_HOLD, GOOD, HOLDS, NOT_REPRODUCED, verdict
from gnsslab.simulate import find_preset, simulate
from gnsslab.systems.constrained_filter import run_filter, steady_path
from gnsslab.systems.dual_antenna import A_STATIC

SEEDS = 20


@pytest.fixture(scope="module")
def reproduction():
    return reproduced("A", range(SEEDS))


@pytest.fixture(scope="module")
def line(reproduction):
    """Find the one line of an item, a quantity and a source."""

    def find(item, quantity, source=""):
        found = [one for one in reproduction.lines if one["item"] == item and one["quantity"] == quantity and source in one["source"]]
        assert len(found) == 1, (item, quantity, [one["item"] for one in reproduction.lines])
        return found[0]

    return find


@pytest.mark.parametrize("quantity", ["heading error, rms", "pitch error, rms"])
@pytest.mark.parametrize("item", ["At rest, + length", "At rest, (16) as printed"])
def test_calibrated_scatter_comes_out_within_a_quarter(line, item, quantity):
    one = line(item, quantity)
    assert one["seeds"] == SEEDS
    assert one["ours_median"] == pytest.approx(one["paper_value"], rel=0.25)


def test_calibrated_spikes_come_out_within_a_factor_of_two(reproduction):
    spikes = [one for one in reproduction.lines if one["source"] == "calibration" and "largest heading error, epochs" in one["quantity"]]
    assert len(spikes) == 8
    for one in spikes:
        assert 0.5 <= one["ours_median"] / one["paper_value"] <= 2, one


def test_the_claims_on_causes_do_not_hold(line):
    does_not = [
        ("The length removes the error at 300", "left of it where the row is without effect, (16) as printed"),
        ("The length removes the error at 500", "left of it where the row is without effect, (16) as printed"),
        ("Fig. 7d, epoch 218", "pitch error over its usual rms, + length"),
        ("The clocks' offset is the cause at 218", "offset that turns the heading by 0.5 deg at 0.061 m/s"),
    ]
    for item, quantity in does_not:
        assert line(item, quantity)["verdict"] == DOES_NOT_HOLD
        assert line(item, quantity)["cause"]
    for item in ("Fig. 5a, epoch 300", "Fig. 5a, epoch 500"):
        assert line(item, "largest direct heading error over its usual rms")["verdict"] == HOLDS


def test_the_jump_at_218_is_the_masters_way_across_the_baseline(line):
    expected = np.degrees(np.arctan(np.radians(6) * 1.167 / 2 * 1.0 / 1.167))  # v dt / l of a master half a length from the axis
    one = line("Turntable, + length", "heading error at 218")
    assert abs(one["ours_mean"]) == pytest.approx(expected, abs=4 * one["ours_sd"] / np.sqrt(SEEDS))


def test_every_line_follows_from_its_numbers(reproduction):
    items = paper_a.ITEMS
    assert len(reproduction.lines) == len(items) > 60
    for one, item in zip(reproduction.lines, items, strict=True):
        assert list(one)[:5] == ["paper", "item", "quantity", "unit", "paper_value"]
        q1, q3 = one["ours_quartiles"]
        again = verdict(item.paper_value, np.array([q1, q1, one["ours_median"], q3, q3]), item.is_claim)  # five numbers with these quartiles
        assert one["verdict"] == again
        assert one["cause"] or one["verdict"] in GOOD, f"no cause is given: {one}"
    assert {NOT_REPRODUCED, *GOOD, DOES_NOT_HOLD} <= {one["verdict"] for one in reproduction.lines}


def test_items_are_told_apart():
    named = [(item.item, item.quantity, item.source) for item in paper_a.ITEMS]
    assert len(set(named)) == len(named)


def test_numbers_on_a_second_route():
    """Straight from the simulator and the filter, without the lab's campaigns: the same numbers for the same seed."""
    sim = simulate(find_preset(A_STATIC.preset), np.random.default_rng(4))
    prepared = prepare_moving(*sim.observations, sim.ephemerides, A_STATIC.settings)
    run = run_filter(prepared, steady_path(prepared, A_STATIC.velocity_noise), A_STATIC.filter)
    heading, pitch = np.degrees(heading_pitch_of(run.baseline[100:650]))
    numbers = paper_a.reproduce(range(4, 5)).numbers
    assert numbers["rest length heading"] == pytest.approx([np.sqrt(np.mean((heading - 35) ** 2))], abs=1e-3)  # truth at tags: microseconds apart
    assert numbers["rest length pitch"] == pytest.approx([np.sqrt(np.mean(pitch**2))], abs=1e-3)
    assert numbers["rest length longest"] == pytest.approx([1e3 * (np.linalg.norm(run.baseline[100:650], axis=1).max() - 1.167)], abs=1e-3)
    assert numbers["rest length first fix"] == [run.first_fix]


def test_formulas_as_computed_by_hand():
    """The papers' own exercise numbers, and the norm of (4)'s first row."""
    found = formula_numbers()
    assert found["formula 5"] == pytest.approx(-180.0)
    assert found["formula 6"] == pytest.approx(21.344 - 20, abs=5e-4)
    sigmas = [(1 / 10**2 + 1 / tape**2) ** -0.5 for tape in (1167.0, 5.0)]  # [mm], of two measurements: 10 mm, and the tape
    assert found["formula 16"] == pytest.approx(sigmas[0] - sigmas[1])
    assert found["formula 25"] == pytest.approx(2.0)
    assert found["formula 28"] == pytest.approx(0.02 - 0.0004)
    assert found["formula 33"] == pytest.approx(3.24 - 0.428, abs=0.006)
    assert found["formula 34"] == pytest.approx(0.737 - 0.728, abs=0.001)
    assert found["offset needed"] == pytest.approx(167, abs=1)


def test_figures_are_pictures_with_words(reproduction):
    assert [picture.title.split(":")[0] for picture in reproduction.pictures] == [f"Figure {n}" for n in range(4, 9)]
    for picture in reproduction.pictures:
        assert picture.png.startswith(b"\x89PNG")
        assert len(picture.words) > 40
        assert "nan" not in picture.words


def test_progress_counts_the_seeds():
    seen = []
    reproduced("A", range(2), lambda done, total: seen.append((done, total)))
    assert seen == [(1, 2), (2, 2)]
