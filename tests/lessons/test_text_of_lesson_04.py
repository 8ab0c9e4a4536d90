"""What lesson 04 says in numbers is what its labs show, and its code runs."""

import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from gnsslab.core.integers import (
    best_integer_equivariant,
    decorrelate,
    integer_least_squares,
    success_bounds,
    success_rate,
)
from gnsslab.core.integers.success import adop_success_rate
from gnsslab.core.mixed_model import FloatSolution, given_integers
from gnsslab.labs.fewer_satellites import fewer_satellites_lab
from gnsslab.labs.known_length import known_length_lab
from gnsslab.labs.soft_fixing import soft_fixing_lab
from gnsslab.labs.trust import trust_lab
from gnsslab.teaching.catalogue import find_lesson

TEXT = find_lesson("04").path.read_text("utf-8")
PLAIN = re.sub(r"\s+", " ", TEXT)
REFERENCE = Path(__file__).parents[1] / "reference"
CM, MM = 1e-2, 1e-3


@pytest.fixture(scope="module")
def trust():
    """The first lab."""
    return trust_lab()


@pytest.fixture(scope="module")
def soft():
    """The second lab."""
    return soft_fixing_lab()


@pytest.fixture(scope="module")
def length():
    """The third lab."""
    return known_length_lab()


@pytest.fixture(scope="module")
def fewer():
    """The last lab."""
    return fewer_satellites_lab()


def at(lab, preset, **changed):
    """Return a lab's result at a preset, some settings changed."""
    return lab.run(**(dict(lab.preset(preset).settings) | changed))


def says(*sentences):
    """Assert that the lesson says so, line breaks apart."""
    for sentence in sentences:
        assert sentence in PLAIN, sentence


def row(name):
    """Return the numbers in a row of a table, by the beginning of its first cell."""
    (cells,) = re.findall(rf"^ *\| {re.escape(name)}[^|]* \|(.*)\|$", TEXT, re.MULTILINE)
    return [float(number) for number in re.findall(r"\d+\.?\d*", cells)]


def test_code_shown_to_students_runs():
    """It finds what the text says: least squares wrong, the test says so, the length puts it right; and a second use is refused."""
    (block,) = (part.split("```")[0] for part in TEXT.split("```python")[1:])
    code = "\n".join(line[4:] for line in block.splitlines())
    more = "\ntry: gl.fix_with_length(gl.use_length(flt, 1.0, 0.005), 1.0)\nexcept ValueError as refusal: print('refused:', refusal)\n"
    outcome = subprocess.run([sys.executable, "-c", code + more], capture_output=True, text=True, check=False)
    assert outcome.returncode == 0, outcome.stderr
    lines = outcome.stdout.splitlines()
    truth = [34, -28, -45, -20, -22]
    found = [int(number) for number in re.findall(r"-?\d+", lines[1].split("]")[0])]
    assert found != truth
    assert re.search(r"\] 2\.[12]\d* RatioThreshold: 4\.\d+ .*False$", lines[1])
    with_length = next(line for line in lines if line.startswith("[") and line.endswith("]") and "." not in line)
    assert [int(number) for number in re.findall(r"-?\d+", with_length)] == truth
    assert "refused:" in lines[-1]
    says("the ratio is 2.2, and this model asks for more than 4", "34, \N{MINUS SIGN}28, \N{MINUS SIGN}45, \N{MINUS SIGN}20, \N{MINUS SIGN}22")


def test_scene_is_an_epoch_of_the_roof(fewer, dataset):
    dataset("matrtklib-static")
    stage = fewer.run(satellites=5).stage
    assert stage.norms[24, 1] / stage.norms[24, 0] == pytest.approx(10.1, abs=0.05)
    assert not stage.is_right[24]
    assert stage.off_fixed[24] == pytest.approx(0.36, abs=0.005)
    sigma = np.sqrt(np.diag(given_integers(stage.solution, np.rint(stage.solution.a_hat))[1]))
    np.testing.assert_allclose(sigma, [6 * MM, 13 * MM, 17 * MM], atol=0.6 * MM)
    nine = fewer.run(satellites=9).stage  # all right, so these are the true ones
    assert 4 * np.median(nine.norms[:, 0]) / nine.n == pytest.approx(0.6, abs=0.05)
    says("ratio 10.1", "6 mm, 13 mm and 17 mm", "At the 25th", "**36 cm**", "squared distances were **0.010 and 0.104**", "off by 0.36 m")


def test_words_about_the_first_lab(trust):
    start, tolerated, five = trust.run(), trust.run(test="tolerated"), trust.run(satellites=5)
    assert (100 * start.model.promised, 100 * start.counted.rate) == pytest.approx((88.7, 93.6), abs=0.05)
    assert start.chosen.shares.rejected_right > start.chosen.shares.fixed_right
    assert tolerated.chosen.threshold == pytest.approx(1.54, abs=0.005)
    assert tolerated.chosen.shares.fixed == pytest.approx(2 * start.chosen.shares.fixed, rel=0.01)
    assert (100 * five.chosen.shares.fixed, 100 * five.chosen.shares.fixed_wrong) == pytest.approx((15.5, 14.4), abs=0.05)
    weak, many, biased = (at(trust, name) for name in ("weak", "twenty", "biased"))
    assert weak.counted.rate == pytest.approx(0.25, abs=0.04)  # "three of four are wrong"
    assert weak.chosen.shares.fixed_wrong == pytest.approx(0.5 * weak.chosen.shares.fixed, rel=0.1)
    assert many.counted.rate == pytest.approx(0.97, abs=0.005)
    assert many.chosen.shares.fixed < 0.05
    assert (100 * biased.model.claims[1].low, 100 * (1 - biased.counted.rate)) == pytest.approx((99.97, 44), abs=0.5)
    assert biased.chosen.shares.fixed < 0.01  # "lets hardly any epoch pass"
    assert at(trust, "biased-tolerated").chosen.shares.fixed == 1
    all_wrong = at(trust, "all-wrong").chosen.shares
    assert all_wrong.fixed == all_wrong.fixed_wrong == pytest.approx(0.1, abs=0.01)  # "a tenth", "every one of them is wrong"
    assert [preset.label for preset in trust.presets[-4:]] == ["Difference", "Projector", "Upside down", "1/3 for 3"]  # "the last four buttons"
    says("88.7 %, and 93.6 %", "the ratio, 1.54", "15.5 % pass, and 14.4 % pass and are wrong", "ADOP promises 99.97 %, and 44 % are wrong")


def test_table_of_the_ratio_upside_down(trust):
    for name, written in (("second over best, at least 3", "right"), ("upside down", "upside-down"), ("1/3 given where 3 was meant", "mixed")):
        shares = trust.run(written=written).chosen.shares
        assert row(name)[-2:] == pytest.approx([100 * shares.fixed, 100 * shares.fixed_wrong], abs=0.05), name


def test_words_about_the_second_lab(soft):
    start, trees, single, alone = (at(soft, name) for name in ("soft", "trees", "single", "left-alone"))
    assert 100 * np.mean(start.is_right) == pytest.approx(97.7, abs=0.05)
    assert (start.rms["fixed"], start.rms["soft"]) == pytest.approx((0.16, 0.14), abs=0.005)
    assert 0.5 < np.median(start.errors["fixed"][~start.is_right]) < 1.5  # "off by a metre"
    below = [100 * np.mean(start.errors[way] < 2 * CM) for way in ("soft", "fixed")]
    assert below == pytest.approx([82, 96], abs=0.5)
    assert (len(trees.risks), trees.fixed) == (14, 13)
    assert 100 * np.mean(trees.is_tested) == pytest.approx(11.8, abs=0.06)
    assert (trees.rms["tested"], trees.rms["partial"]) == pytest.approx((0.55, 8 * MM), rel=0.1)
    assert single.fixed == 0
    assert at(soft, "single", subset="combinations").fixed == 11
    assert (single.rms["soft"], single.rms["fixed"]) == pytest.approx((12 * MM, 9 * MM), abs=0.5 * MM)
    third = at(soft, "single", subset="combinations", seed=3)
    assert (third.rms["soft"], third.rms["fixed"]) == pytest.approx((32 * MM, 33 * MM), abs=0.6 * MM)
    assert third.rms["soft"] < third.rms["fixed"]
    assert int((third.errors["fixed"] > 1).sum()) == 1  # "one fix is more than a metre off"
    assert np.mean(alone.is_right) < 0.5
    assert alone.rms["fixed"] > alone.rms["float"]
    gain = start.single.rms_rounded / start.single.sigmas
    assert start.single.sigmas[np.argmax(gain > 1)] == pytest.approx(0.29)
    says(
        "97.7 % of the fixes",
        "rms: 0.16 m",
        "has 0.14 m",
        "11.8 % of the epochs",
        "**13 of the 14**",
        "begins at 0.29 cycles",
        ": 11 can",
        "82 % instead of 96 %",
        "32 mm against 33 mm",
    )


def test_words_about_the_third_lab(length):
    result = length.run()
    fixes = result.counted.fixes
    right = {name: 100 * found.right.rate for name, found in fixes.items()}
    assert (right["without"], right["row"], right["twice"], right["search"]) == pytest.approx((31.5, 11, 22, 96), abs=0.5)
    assert (100 * fixes["row"].claimed, 100 * fixes["twice"].claimed) == pytest.approx((84, 98.5), abs=0.5)
    wrong_length = length.run(length_error=5).counted.fixes["search"]
    assert wrong_length.right.rate == 0  # "not one epoch"
    assert 100 * wrong_length.claimed == pytest.approx(87, abs=0.5)
    assert 100 * at(length, "short-baseline").fixes.right.rate == pytest.approx(98.5, abs=0.05)
    errors = np.linalg.norm(result.counted.free.b_hat - result.counted.truth, axis=-1)
    assert np.sqrt(np.mean(errors**2)) == pytest.approx(0.9, abs=0.1)  # "off by nearly a metre"
    assert at(length, "nine-satellites").counted.fixes["without"].right.rate > 0.99
    assert (np.hypot(1, 0.5) - 1, np.degrees(np.arctan(0.5))) == pytest.approx((0.12, 27), abs=0.5)
    says("31.5 % are right", "11 % are right", "claims 84 %", "claims 98.5 %, and 22 % are right", "22 % right, 98.5 % claimed")


def test_words_about_the_printed_row(length):
    row_of_20 = 100 * length.run(row_sigma=20).counted.fixes["row"].right.rate
    assert row_of_20 == pytest.approx(45, abs=1)
    assert round(1.167 / 0.005) == 233
    for sigma, left in ((1.167, 10.0), (0.005, 4.5)):  # of a prior of 10 mm, in mm
        assert 1e3 / np.sqrt(0.01**-2 + sigma**-2) == pytest.approx(left, abs=0.05)
    says("45 % against 11 %", "233 times", "stays at 10.0 mm, where it should become 4.5 mm")


def test_words_about_real_data(fewer, dataset):
    dataset("matrtklib-static")
    dataset("geonet-0759-3040")
    stages = {len(stage.satellites): stage for stage in fewer.run().stages}
    right = {count: np.mean(stage.is_right) for count, stage in stages.items()}
    assert (right[9], right[6], right[5]) == pytest.approx((1.0, 0.9, 0.25), abs=0.02)
    five, rate = fewer.run(satellites=5), fewer.run(satellites=5, acceptance="rate")
    assert (int((five.outcomes.fixed | five.outcomes.failed).sum()), int(five.outcomes.failed.sum())) == (13, 8)
    assert rate.thresholds[rate.chosen] == pytest.approx(11, abs=1)
    assert not (rate.outcomes.fixed | rate.outcomes.failed).any()
    assert np.mean(at(fewer, "roof-length").stage.is_right) == pytest.approx(0.99, abs=0.005)
    two = at(fewer, "roof-two")
    assert np.all(two.stage.is_right)
    assert np.median(two.off[:10]) > 1  # "off by metres at first"
    for count, stage in stages.items():  # "m - 4 of them are left to check the rest"
        assert 2 * (count - 1) - stage.n - 3 == count - 4
    breaks = next(readout for readout in fewer.readouts(at(fewer, "stations")) if readout.label == "Breaks at")
    assert breaks.value == "5"
    usual, sharp = fewer.run(), at(fewer, "roof-sharp")
    assert usual.promised[usual.chosen] < 0.2
    for stage, before, promised in zip(sharp.stages, usual.stages, sharp.promised, strict=True):
        assert promised == pytest.approx(np.mean(stage.is_right), abs=0.17)  # "close to the counts"
        np.testing.assert_array_equal(stage.is_right, before.is_right)  # "no integer changes and no ratio"
        np.testing.assert_allclose(stage.norms[:, 1] / stage.norms[:, 0], before.norms[:, 1] / before.norms[:, 0], rtol=1e-6)


def both_ends(published, name):
    """Return a published lower and upper bound, after decorrelation."""
    return [published["decorrelated"][f"{name}_{end}"] for end in ("lower", "upper")]


def test_table_of_success_rates():
    published = json.loads((REFERENCE / "success.json").read_text())["bounds"]
    Q = np.array(published["Q"])
    Z = decorrelate(Q).Z
    as_they_are, better = success_bounds(Q), success_bounds(Z.T @ Q @ Z)
    for name, printed, ours in (
        ("success rate of bootstrapping", [published["original"]["bootstrapped"]], [as_they_are.bootstrapped]),
        ("the same after decorrelation", [published["decorrelated"]["bootstrapped"]], [better.bootstrapped]),
        ("bounds by the pull-in region", both_ends(published, "pull_in"), [better.pull_in_lower, better.pull_in_upper]),
        ("bounds by the eigenvalues", both_ends(published, "eigenvalue"), [better.eigenvalue_lower, better.eigenvalue_upper]),
    ):
        assert row(name) == pytest.approx([*printed, *(100 * float(value) for value in ours)], abs=0.006), name
    rates = [float(adop_success_rate(cycles, 28)) for cycles in (0.14, 0.20)]
    assert row("ADOP 0.14 and 0.20") == pytest.approx([0.990, 0.705, *rates], abs=0.0006)


def test_table_of_squared_errors(rng):
    """Of the published example: 50 000 draws here, so as good as 0.005 and 0.002; three sigmas."""
    published = json.loads((REFERENCE / "equivariant.json").read_text())
    Q_a, Q_ba, Q_b = (np.array(published[name]) for name in ("Q_a", "Q_ba", "Q_b"))
    factor = np.linalg.cholesky(np.block([[Q_a, Q_ba.T], [Q_ba, Q_b]]))
    a_hat, b_hat = np.split(rng.standard_normal((50_000, 8)) @ factor.T, [5], axis=1)
    solution = FloatSolution(a_hat, b_hat, Q_a, Q_b, Q_ba)
    ways = (
        ("squared error of the baseline", "mse_least_squares_over_float", integer_least_squares(a_hat, Q_a, n_best=1).best, 0.017),
        ("the same, best equivariant over float", "mse_equivariant_over_float", best_integer_equivariant(a_hat, Q_a).a, 0.006),
    )
    for name, key, a, tolerance in ways:
        printed, ours = row(name)[:2]
        mse = np.mean(np.sum(given_integers(solution, a)[0] ** 2, axis=1)) / np.mean(np.sum(b_hat**2, axis=1))
        assert printed == published[key]
        assert mse == pytest.approx(ours, abs=tolerance)
    assert row("one epoch of L1, success rate") == pytest.approx([30.7, 100 * float(success_rate(Q_a))], abs=0.05)


def test_table_of_the_known_length(length):
    """Three seeds of 2000 epochs, as the table's mean has it."""
    counted = [length.run(epochs=2000, seed=seed).counted.fixes for seed in (1, 2, 3)]
    published = json.loads((REFERENCE / "constrained.json").read_text())
    assert "0.316" in json.dumps(published)
    assert "0.956" in json.dumps(published)
    for name, method, printed in (("one epoch of L1, length 1 m", "without", 31.6), ("the same: right with it in the search", "search", 95.6)):
        ours = 100 * np.mean([fixes[method].right.rate for fixes in counted])
        assert row(name)[:2] == pytest.approx([printed, ours], abs=0.06), name


def test_table_of_thresholds(trust):
    table = json.loads((REFERENCE / "ratio_thresholds.json").read_text())
    mu = {tuple(numbers[:3]): numbers[3] for numbers in table["rows"]}
    tolerated = trust.run(test="tolerated")
    assert len(tolerated.model.Q) == 8
    wrong = 1 - tolerated.counted.rate
    assert 0.05 < wrong < 0.10
    printed = [mu[0.01, rate, 8] for rate in (0.05, 0.1)]
    assert row("threshold") == pytest.approx([*printed, 1 / tolerated.chosen.threshold, 100 * wrong], abs=0.006 + 0.04)
    says("1/1.54 = 0.65")


def test_table_of_multipath(trust):
    biased = at(trust, "biased")
    assert row("multipath that the model ignores")[-2:] == pytest.approx(
        [100 * biased.model.claims[1].low, 100 * (1 - biased.counted.rate)], abs=0.05
    )
    assert 100 * float(adop_success_rate(0.0755, 28)) > 99.99  # "promises everything"
