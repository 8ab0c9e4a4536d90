"""What the text of lesson 01 tells is true: its tables, its numbers and its nine lines."""

import re
import runpy
from types import SimpleNamespace

import numpy as np
import pytest

from gnsslab.gnss.dense import single_frequency_codes
from gnsslab.gnss.signals import wavelength
from gnsslab.labs.signal import signal_lab
from gnsslab.labs.sky import sky_lab
from gnsslab.teaching.catalogue import find_lesson

LESSON = find_lesson("01")
TEXT = LESSON.path.read_text("utf-8")


def rows_of_table(head):
    """Return the cells of a Markdown table whose first line begins so."""
    lines = TEXT[TEXT.index(head) :].splitlines()[2:]
    table = lines[: next(k for k, line in enumerate(lines) if "|" not in line)]
    return [[cell.strip() for cell in line.strip().strip("|").split("|")] for line in table]


def run(lab, suffix, **changed):
    """Run the lesson without a browser, controls of one lab changed; return that lab's result."""
    app = runpy.run_path(str(LESSON.path))["app"]
    predicted = {"prediction": SimpleNamespace(value=LESSON.exercises.PREDICTION.options[0])}
    names = app.run(defs=predicted)[1]
    old = names[f"controls{suffix}"]
    moved = SimpleNamespace(value=old.value | changed, items=old.items)
    result = app.run(defs=predicted | {f"controls{suffix}": moved})[1][f"result{suffix}"]
    assert result.settings.items() >= changed.items()
    return result


@pytest.mark.parametrize(
    ("lab", "suffix", "preset"),
    [(lab, suffix, preset) for lab, suffix in ((signal_lab(), ""), (sky_lab(), "_sky")) for preset in lab.presets if "data" not in preset.settings],
    ids=lambda value: getattr(value, "name", value),
)
def test_both_labs_run_at_every_preset(lab, suffix, preset):
    assert run(lab.name, suffix, **preset.settings).problem == ""


def test_the_three_numbers_of_the_scene_are_real(campaign):
    measured = single_frequency_codes(campaign("matrtklib-static").rover, "G")
    column = measured.satellites.index("G20")
    told = [[float(cell.replace("&nbsp;", "").replace("\N{MINUS SIGN}", "-")) for cell in row[1:]] for row in rows_of_table("| time |")]
    assert len(told) == 2
    for epoch, (code, carrier, doppler) in enumerate(told):
        assert code == pytest.approx(measured.code[epoch, column], abs=6e-4)
        assert carrier == pytest.approx(measured.phase[epoch, column], abs=6e-4)
        assert doppler == pytest.approx(measured.doppler[epoch, column], abs=6e-4)
    (code, carrier, doppler), (code_after, carrier_after, doppler_after) = told
    assert f"the code grew by {code_after - code:.2f} m" in TEXT
    assert f"grew by {carrier_after - carrier:.3f} cycles" in TEXT
    assert f"long: {(carrier_after - carrier) * wavelength('G', '1'):.2f} m" in TEXT
    assert f"mean Doppler says {-(doppler + doppler_after) / 2:.3f}" in TEXT or f"{-(doppler + doppler_after) / 2:.3f}\n    cycles" in TEXT


def test_the_table_of_masks_is_what_the_lab_shows():
    rows, lab = rows_of_table("| mask |"), sky_lab()
    assert len(rows) == 4
    for mask, satellites, vdop, error in rows:
        view = lab.run(mask_deg=int(mask.rstrip("°"))).view
        assert int(satellites) == view.used[view.shown].sum()
        assert float(vdop) == pytest.approx(view.dop[3], abs=0.006)
        assert float(error.removesuffix(" m")) == pytest.approx(view.error[1], abs=0.06)


def test_numbers_told_beside_the_first_lab():
    track = signal_lab().run().track
    assert "scatter by 0.4 m" in TEXT
    assert track.sigma_code == pytest.approx(0.4, abs=0.05)
    assert "scatters by 2 mm" in TEXT
    assert track.sigma_carrier == pytest.approx(0.002, abs=0.0005)
    assert "200 times finer" in TEXT
    assert track.sigma_code / track.sigma_carrier == pytest.approx(200, rel=0.1)


def test_one_cycle_on_both_carriers_moves_their_difference_by_little():
    assert "54 mm" in TEXT
    assert wavelength("G", "2") - wavelength("G", "1") == pytest.approx(0.054, abs=5e-4)


def test_the_nine_lines_run(tmp_path, monkeypatch, capsys):
    """Copied as they stand, in a folder of simulated files."""
    from gnsslab.simulate import find_preset, simulate, write_simulation

    write_simulation(tmp_path, simulate(find_preset("static-baseline"), np.random.default_rng(1)))
    monkeypatch.chdir(tmp_path)
    block = TEXT.split("```python")[1].split("```")[0]
    lines = [line.strip() for line in block.splitlines() if line.strip()]
    assert len(lines) == 9
    exec(compile("\n".join(lines), "lesson 01", "exec"), {})
    said = capsys.readouterr().out
    scatter = {name: float(metres) for name, metres in re.findall(r"'(G\d\d)': ([\d.]+)", said)}
    assert len(scatter) >= 8
    assert 0.2 < min(scatter.values()) < 1.0  # [m], code of 0.3 m and multipath of 0.2 m
    assert "300 epochs, 300 solved" in said


def test_links_lead_to_symbols_of_the_notation():
    from gnsslab.teaching.pages.notation import notation_body

    linked, page = set(re.findall(r"\]\(/notation#(\w+)\)", TEXT)), notation_body()
    assert {"P", "Phi", "phi", "D", "lambda", "N", "dt_r", "dt_s", "I", "T", "rho"} <= linked
    assert [name for name in linked if f'id="{name}"' not in page] == []


def test_no_em_dash():
    assert "\u2014" not in TEXT
