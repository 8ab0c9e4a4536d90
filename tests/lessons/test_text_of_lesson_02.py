"""What lesson 02 says in numbers is what its labs show, and its code runs."""

import re
import subprocess
import sys

import numpy as np
import pytest

from gnsslab.labs.cancelling import cancelling_lab
from gnsslab.labs.correlation import CONTROLS, correlation_lab
from gnsslab.simulate import find_preset, simulate, write_simulation
from gnsslab.teaching.catalogue import find_lesson

TEXT = find_lesson("02").path.read_text("utf-8")


def test_code_shown_to_students_runs(tmp_path):
    """In a folder made by the command that the text names, line by line as it stands."""
    assert "gnsslab simulate static-baseline" in TEXT
    write_simulation(tmp_path, simulate(find_preset("static-baseline"), np.random.default_rng(0)))
    (block,) = (part.split("```")[0] for part in TEXT.split("```python")[1:])
    code = "\n".join(line[4:] for line in block.splitlines())
    outcome = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert outcome.returncode == 0, outcome.stderr
    single, double = (np.array(re.findall(r"-?\d+\.\d*", part), float) for part in outcome.stdout.split("]")[:2])
    assert len(double) == len(single) - 1 > 3
    assert (np.abs(single) > 1000).all()  # kilometres of clock, the same for each satellite
    assert np.ptp(single) < 20
    assert (np.abs(double) < 8).all()
    assert "[4. 2. 2." in outcome.stdout


def test_table_of_beliefs_is_the_labs():
    lab, names = correlation_lab(), next(c for c in CONTROLS if c.name == "belief").options
    rows = re.findall(r"^ *\| ((?:correlation|as printed)[^|]*) \|(.*)\|$", TEXT, re.MULTILINE)
    assert [name for name, _ in rows] == list(names)
    for name, cells in rows:
        result = lab.run(belief=names[name])
        shown = {readout.label: readout for readout in lab.readouts(result)}
        promised, claimed = (re.search(r"[\d.]+", shown[label].note)[0] for label in ("Right integers", "Scatter up"))
        expected = [shown["Right integers"].value, promised, shown["Ratio"].value, claimed, shown["Scatter up"].value]
        assert re.findall(r"[\d.]+", cells) == expected, name


def test_words_about_real_stations_are_the_labs(dataset):
    dataset("geonet-0759-3040")
    result = cancelling_lab().run(data="real")
    single, double = result.levels.single[0], result.levels.double[0]
    assert result.length == pytest.approx(3335.39, abs=0.005)
    assert f"{result.cycles:,}".replace(",", " ") in TEXT
    assert np.diff(single).mean() / 30 == pytest.approx(750, abs=5)
    assert single[-1] == pytest.approx(2600e3, rel=0.03)
    assert np.abs(double).max() < 0.02
    assert len(double) == 120  # an hour at 30 s


def test_words_about_the_start_are_the_labs():
    lab = cancelling_lab()
    tags = lab.run(**lab.preset("tags").settings)
    assert np.abs(tags.levels.double).mean() == pytest.approx(0.25, abs=0.05)  # "a quarter of a metre"
    per_km = [abs(lab.run(length=10, satellite=satellite).atmosphere) / 10 for satellite in ("high", "middle", "low")]
    assert max(per_km) == per_km[-1] < 0.0035  # "up to 3 mm for each kilometre, most for low satellites"
