"""What lesson 03 says in numbers is what its labs show, and its code runs."""

import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from gnsslab.core.integers import integer_least_squares, success_rate
from gnsslab.labs.cells import cells_lab
from gnsslab.labs.centimetres import CONTROLS, centimetres_lab
from gnsslab.labs.spectrum import spectrum_lab
from gnsslab.teaching.catalogue import find_lesson

TEXT = find_lesson("03").path.read_text("utf-8")


def table_after(words):
    """Return the cells of the first table after some words, without its head."""
    lines = [line.strip() for line in TEXT.split(words)[1].split("\n\n")[1].splitlines()]
    assert all(line.startswith("|") for line in lines)
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines[2:]]


def shown(lab, **settings):
    """Return the readouts of a lab by their labels."""
    return {readout.label: readout for readout in lab.readouts(lab.run(**settings))}


def numbers(text):
    """Return the numbers in a text as written."""
    return re.findall(r"\d+(?:\.\d+)?", text)


def test_code_shown_to_students_runs():
    (block,) = (part.split("```")[0] for part in TEXT.split("```python")[1:])
    code = "\n".join(line[4:] for line in block.splitlines())
    assert len([line for line in code.splitlines() if line.strip()]) == 10
    outcome = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert outcome.returncode == 0, outcome.stderr
    a_hat, a_fix, b_hat, b_fix = (np.array(numbers(part.replace("-", " ")), float) for part in re.findall(r"\[([^]]*)\]", outcome.stdout))
    assert a_fix.tolist() == list(range(10))
    signed = np.array(re.findall(r"-?\d+\.\d*", outcome.stdout.split("]")[0]), float)
    assert f"up to {np.abs(signed - a_fix).max():.1f} cycles" in TEXT
    assert np.sum(np.rint(signed) != a_fix) == 4  # "four of ten would be wrong"
    assert 0.1 < np.abs(b_hat).max() < 1 > 0.01 > np.abs(b_fix).max()
    assert len(a_hat) == 10


def test_table_of_beliefs_is_the_labs():
    lab, names = centimetres_lab(), next(c for c in CONTROLS if c.name == "belief").options
    rows = table_after("At its start:")
    assert [row[0] for row in rows] == list(names)[:3]
    for name, *cells in rows:
        found = shown(lab, belief=names[name])
        promised, claimed = numbers(found["Right integers"].note)[0], numbers(found["Float position"].note)[0]
        expected = [found["Right integers"].value, promised, found["ADOP"].value, found["Float position"].value, claimed]
        assert [numbers(cell)[0] for cell in cells] == expected, name
    assert "three too many" in TEXT
    assert "10 integers and 3 coordinates" in lab.run(belief=names["as printed: carrier alone"]).problem


def test_table_of_real_satellites_is_the_labs(dataset):
    dataset("geonet-0759-3040")
    lab = centimetres_lab()
    rows = table_after("Epochs with the right integers:")
    assert [row[0] for row in rows] == ["4", "5", "6", "7"]
    for satellites, *cells in rows:
        found = [shown(lab, data="real", satellites=int(satellites), frequencies=f)["Right integers"].value for f in (1, 2)]
        assert [numbers(cell)[0] for cell in cells] == found, satellites


def test_table_of_real_epochs_is_the_labs(dataset):
    dataset("geonet-0759-3040")
    lab = centimetres_lab()
    rows = table_after("the mean of several epochs:")
    assert len(rows) == 4
    for epochs, *cells in rows:
        found = shown(lab, data="real", satellites=6, frequencies=1, epochs=int(epochs))
        position, right = found["Float position"], found["Right integers"]
        expected = [position.value, numbers(position.note)[0], right.value, numbers(right.note)[0]]
        assert [numbers(cell)[0] for cell in cells] == expected, epochs


def test_words_about_real_stations_are_the_labs(dataset):
    dataset("geonet-0759-3040")
    lab = centimetres_lab()
    position = shown(lab, data="real", satellites=6, frequencies=1, code_noise=0.15, carrier_noise=2)["Float position"]
    assert position.value == numbers(position.note)[0]  # "now the claimed cloud fits the real one"
    fixed = [float(shown(lab, data="real", satellites=6, frequencies=f)["Fixed position"].value) for f in (1, 2)]
    assert 4 <= min(fixed) <= max(fixed) <= 5  # "4 to 5 mm"


def test_words_about_the_first_lab_are_its():
    lab = centimetres_lab()
    start = lab.run()
    found = shown(lab)
    assert round(100 * float(found["Float position"].value)) == 75  # [cm]
    assert round(float(found["Fixed position"].value)) == 7  # [mm]
    assert start.n == 10
    assert lab.run(satellites=7).is_right.all()  # "no crosses"
    four = lab.run(satellites=4)
    assert np.std(four.float_enu[:, :2]) / np.std(start.float_enu[:, :2]) == pytest.approx(6.0, abs=0.5)  # "six times as large"
    assert round(1 / np.mean(four.is_right)) == 9  # "one epoch in nine"
    noisy = lab.run(code_noise=0.6)
    np.testing.assert_allclose(noisy.Q_fixed, start.Q_fixed, rtol=1e-3)  # "the window does not move"
    np.testing.assert_allclose(noisy.Q_float, 4 * start.Q_float, rtol=1e-3)


def test_words_about_the_cells_are_the_labs():
    lab = cells_lab()
    counted = [answer.counted for answer in lab.run(**lab.preset("thousand-draws").settings).answers]
    assert [f"{100 * share:.0f} %" for share in counted] == ["28 %", "39 %", "64 %"]
    for share in counted:
        assert f"{100 * share:.0f} %" in TEXT
    nodes = [len(lab.run(**lab.preset(name).settings).tree.nodes) for name in ("three-in-the-tree", "three-decorrelated")]
    assert f"{nodes[0]} nodes, then {nodes[1]}" in TEXT
    Z = lab.run(**lab.preset("decorrelated-cells").settings).space.Z
    assert np.abs(np.linalg.det(Z)) == pytest.approx(1)
    np.testing.assert_array_equal(Z.T, [[-2, 3], [1, -1]])  # "z_1 = -2 a_1 + 3 a_2, z_2 = a_1 - a_2"
    np.testing.assert_array_equal(np.linalg.inv(Z.T).round(), [[1, 3], [1, 2]])  # "a_1 = z_1 + 3 z_2, a_2 = z_1 + 2 z_2"


def test_table_of_published_numbers_is_the_librarys():
    """Theirs from the record of published numbers, ours computed anew."""
    reference = json.loads((Path(__file__).parents[1] / "reference" / "integers.json").read_text("utf-8"))
    case = reference["ils_cases"][0]
    found = integer_least_squares(case["a_float"], case["Q"])
    norms = ", ".join(f"{norm:.4f}" for norm in found.norms)
    rates = [100 * float(success_rate(example["Q"])) for example in reference["success_rate"]]
    ours = [", ".join(map(str, found.candidates[0])), ", ".join(map(str, found.candidates[1])), norms, f"{rates[0]:.2f} %", f"{rates[1]:.1f} %"]
    published = case["published"]
    theirs = [", ".join(map(str, published[name])) for name in ("fixed_best", "fixed_second")]
    theirs += [", ".join(f"{norm:.4f}" for norm in published["sqnorm"]), *(f"{example['percent']} %" for example in reference["success_rate"])]
    rows = table_after("what the functions of this lesson give:")
    assert [row[2] for row in rows] == theirs
    assert [row[3] for row in rows] == ours
    assert [f"{value:.3f}" for value in case["a_float"]] == numbers(rows[0][1])


def test_words_about_the_spectrum_are_the_labs():
    lab = spectrum_lab()
    start, code, carrier, many = (lab.run(**settings).before.sigma for settings in ({}, {"code": 0.6}, {"carrier": 6}, {"together": 4}))
    np.testing.assert_allclose(code[:3] / start[:3], 2, rtol=0.01)  # "the three move, the others do not"
    np.testing.assert_allclose(code[3:] / start[3:], 1, rtol=0.01)
    np.testing.assert_allclose(carrier[:3] / start[:3], 1, rtol=0.01)  # "now it is the others"
    np.testing.assert_allclose(carrier[3:] / start[3:], 2, rtol=0.01)
    np.testing.assert_allclose(many / start, 0.5, rtol=1e-6)  # "everything goes down alike"
    thirty = lab.run(**lab.preset("thirty").settings)
    assert thirty.before.stopped > len(thirty.before.nodes) / 2  # "most searches do not end"
    assert thirty.before.sigma[10] > 2 * thirty.before.sigma[9]  # the second frequency's first: "some times larger again"
