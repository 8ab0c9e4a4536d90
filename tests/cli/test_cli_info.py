"""`gnsslab info`: the facts a student wants first."""

import gzip


def test_info_of_observations(run, files):
    answer = run("info", files.rover)
    assert answer.status == 0, answer.err
    text = " ".join(answer.out.split())
    assert "RINEX 3.04 observations" in text
    assert "span 2021-03-19T12:00:00.000 to 2021-03-19T12:00:59.000" in text
    assert "epochs 60, one every 1 s" in text
    assert "gaps none" in text
    assert "Galileo 8Q CLS 9 540 100.0 % 0 0" in text
    assert "QZSS J01 J02 J03 J07" in text


def test_info_tells_gaps_slips_and_half_cycles(run, files, tmp_path):
    epochs = gzip.decompress(files.rover.read_bytes()).decode("latin-1").split("\n>")
    epochs[30] = flagged(epochs[30], "3")  # slip and half cycle
    path = tmp_path / "gap.obs"
    path.write_text("\n>".join(epochs[:10] + epochs[13:]))
    text = " ".join(run("info", path).out.split())
    assert "gaps 1; the longest 4 s from 2021-03-19T12:00:08.000" in text
    assert "GPS 1C CLS 11 567 99.6 % 1 1" in text or "GPS 1C CLS 11 570 99.7 % 1 1" in text


def flagged(epoch, flag):
    """Set the loss-of-lock flag of the first phase of the first GPS satellite."""
    lines = epoch.split("\n")
    first = next(k for k, line in enumerate(lines) if line.startswith("G"))
    column = 3 + 16 + 14  # name, code with its flags, digits of the phase
    lines[first] = lines[first][:column] + flag + lines[first][column + 1 :]
    return "\n".join(lines)


def test_info_of_navigation(run, files):
    answer = run("info", files.nav)
    assert answer.status == 0, answer.err
    assert "navigation" in answer.out
    assert "span" in answer.out
    assert "GPS" in answer.out
    assert "data sets of" in answer.out


def test_info_of_other_files(run, tmp_path):
    path = tmp_path / "notes.txt"
    path.write_text("dear diary\n")
    answer = run("info", path)
    assert (answer.status, len(answer.err.splitlines())) == (1, 1)
    assert "RINEX VERSION / TYPE" in answer.err
