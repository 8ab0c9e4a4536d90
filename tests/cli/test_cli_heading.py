"""`gnsslab heading` on files as users bring them: gaps, two rates, bad clocks, a wrong length, files exchanged, one bad antenna."""

import csv
import json
import re
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest

from gnsslab.simulate import LOW_COST, Clock, find_preset, observe, prepare_geometry, true_motion, with_length, write_simulation

ROOF = 0.9910  # [m], of matrtklib-static
WRONG = 0.05  # [m]
MS = 1e-3  # [s]


class Session(NamedTuple):
    """The files of a baseline, and the true heading and pitch (T,) [deg] at the rover's epochs where they are known."""

    master: object
    rover: object
    nav: object
    heading: np.ndarray | None = None
    length: float | None = None

    @property
    def paths(self):
        return self.master, self.rover, self.nav


@pytest.fixture
def heading(run, tmp_path):
    """Run the command on files; return its Answer, the rows of its table and the record beside it."""

    def run_heading(paths, *options):
        out = tmp_path / "heading.csv"
        answer = run("heading", *paths, "-o", out, *options)
        assert answer.status == 0, answer.err
        assert answer.complaint == []
        with open(out, encoding="utf-8") as lines:
            rows = list(csv.DictReader(lines))
        return answer, rows, json.loads((tmp_path / "heading.csv.json").read_text())

    return run_heading


@pytest.fixture
def simulated(tmp_path):
    """Simulate a preset with changes, write it as files, return the Session."""

    def simulate(name, *, length=None, seed=5, **changes):
        preset = replace(find_preset(name), **changes)
        preset = preset if length is None else with_length(preset, length)
        simulation = observe(prepare_geometry(preset), preset.noise, np.random.default_rng(seed))
        write_simulation(tmp_path / "files", simulation)
        seconds = np.arange(preset.epochs) * preset.interval
        truth = true_motion(preset, seconds - preset.clocks[1].error(seconds))
        east, north, _ = truth.baselines_enu[0].T
        known = float(np.linalg.norm(truth.baselines_enu[0, 0]))
        files = (tmp_path / "files" / name for name in ("master.obs", "rover.obs", "broadcast.nav"))
        return Session(*files, np.degrees(np.arctan2(east, north)) % 360, known)

    return simulate


@pytest.fixture(scope="module")
def roof(dataset):
    folder = dataset("matrtklib-static")
    return Session(folder / "base.obs", folder / "rover.obs", folder / "base.nav")


def cut(source, target, keep):
    """Write the epochs k of a RINEX 3 file for which keep(k)."""
    head, body = source.read_text().split("END OF HEADER", 1)
    first, *epochs = body.split("\n>")
    kept = [epoch for k, epoch in enumerate(epochs) if keep(k)]
    target.write_text("\n>".join([head + "END OF HEADER" + first, *(epoch.rstrip("\n") for epoch in kept)]) + "\n")
    return target


def numbers(rows, name):
    return np.array([float(row[name]) if row[name] else np.nan for row in rows])


def statuses(rows):
    return np.array([row["status"] for row in rows])


def turned(one, other):
    """Return one - other [deg] in [-180, 180)."""
    return (one - other + 180) % 360 - 180


def notes_about(answer, words):
    return [line for line in answer.err.splitlines() if re.search(words, line)]


# Gaps and rates.


def test_a_master_with_gaps_leaves_rows_without_a_heading(heading, roof, tmp_path):
    gaps = set(range(50, 70)) | {0, 100, 300}
    master = cut(roof.master, tmp_path / "gaps.obs", lambda k: k not in gaps)
    answer, rows, record = heading((master, roof.rover, roof.nav), "--length", ROOF)
    assert len(rows) == 301
    assert set(np.flatnonzero(statuses(rows) == "none")) == gaps
    assert set(statuses(rows)) == {"none", "fixed"}
    assert [rows[60][name] for name in ("heading_deg", "length_m", "satellites")] == ["", "", ""]
    assert notes_about(answer, "master has an epoch") == ["note: the master has an epoch for 278 of the rover's 301: the others have no heading"]
    assert any("278 of the rover's 301" in note for note in record["notes"])


def test_a_rover_with_gaps_has_its_own_epochs_and_no_note(heading, roof, tmp_path):
    rover = cut(roof.rover, tmp_path / "gaps.obs", lambda k: not 20 <= k < 200)
    answer, rows, _ = heading((roof.master, rover, roof.nav), "--length", ROOF)
    assert len(rows) == 121
    assert set(statuses(rows)) == {"fixed"}
    assert not notes_about(answer, "master has an epoch")


def test_a_master_every_thirty_seconds(heading, roof, tmp_path):
    master = cut(roof.master, tmp_path / "slow.obs", lambda k: k % 30 == 0)
    answer, rows, _ = heading((master, roof.rover, roof.nav), "--length", ROOF)
    assert len(rows) == 301
    assert np.flatnonzero(statuses(rows) == "fixed").tolist() == list(range(0, 301, 30))
    assert len(notes_about(answer, "the master has an epoch for 11 of the rover's 301")) == 1
    assert not notes_about(answer, "epochs are fixed")  # a thirtieth of the rover's epochs, but all of those in common
    assert np.nanmax(np.abs(turned(numbers(rows, "heading_deg"), 193.03))) < 0.5


def test_a_grid_on_which_the_master_has_nothing_starts_at_the_first_common_epoch(heading, run, roof, tmp_path):
    master = cut(roof.master, tmp_path / "slow.obs", lambda k: k % 30 == 0)
    rover = cut(roof.rover, tmp_path / "late.obs", lambda k: k >= 17)
    _, rows, _ = heading((master, rover, roof.nav), "--every", 30)
    assert rows[0]["time"] == "2024-06-24T08:20:30.000"
    assert set(statuses(rows)) == {"fixed"}
    assert len(rows) == 10
    never = cut(roof.rover, tmp_path / "never.obs", lambda k: k % 30 == 17)
    answer = run("heading", master, never, roof.nav, "-o", tmp_path / "never.csv", "--every", 30)
    assert answer.status == 1
    assert answer.complaint[0].startswith("gnsslab: no common epochs")


@pytest.mark.parametrize("later", [4, 20])
def test_a_rover_that_samples_milliseconds_later(heading, simulated, tmp_path, later):
    """Tags and measurements both; the antennas stand still, so the truth is the same."""
    session = simulated("static-baseline", duration=120.0)
    master = cut(session.master, tmp_path / "slow.obs", lambda k: k % 30 == 0)
    late = simulated("static-baseline", duration=120.0, start=f"2024-06-24T08:20:00.{later:03d}")
    answer, rows, _ = heading((master, late.rover, session.nav), "--length", session.length)
    assert rows[0]["time"] == f"2024-06-24T08:20:00.{later:03d}"
    assert len(rows) == 120
    assert np.flatnonzero(statuses(rows) != "none").tolist() == [0, 30, 60, 90]
    assert len(notes_about(answer, "the master has an epoch for 4 of the rover's 120")) == 1
    assert_right(rows, session)


def test_a_rover_five_times_as_fast_as_its_master(heading, simulated, tmp_path):
    session = simulated("car-heading", duration=40.0, interval=0.2)
    slow = cut(session.master, tmp_path / "slow.obs", lambda k: k % 5 == 0)
    answer, rows, _ = heading((slow, session.rover, session.nav), "--length", session.length)
    assert len(rows) == 200
    has_master = np.arange(200) % 5 == 0
    assert (statuses(rows)[~has_master] == "none").all()
    assert (statuses(rows)[has_master] == "fixed").all()
    assert len(notes_about(answer, "the master has an epoch for 40 of the rover's 200")) == 1
    assert_right(rows, session)


def test_a_rover_slower_than_its_master_is_served_throughout(heading, simulated, tmp_path):
    session = simulated("car-heading", duration=40.0, interval=0.2)
    slow = cut(session.rover, tmp_path / "slow.obs", lambda k: k % 5 == 0)
    answer, rows, _ = heading((session.master, slow, session.nav), "--length", session.length)
    assert len(rows) == 40
    assert (statuses(rows) == "fixed").all()
    assert not notes_about(answer, "master has an epoch")


def assert_right(rows, session, least=0.9):
    """Fixed at least at such a share of the solved epochs, and each fixed heading within four of its sigma and 5 cm of the truth."""
    fixed = statuses(rows) == "fixed"
    solved = statuses(rows) != "none"
    assert solved.any()
    assert fixed.sum() >= least * solved.sum()
    off = turned(numbers(rows, "heading_deg"), session.heading)[fixed]
    assert (np.abs(off) < np.degrees(WRONG / session.length)).all()
    assert (np.abs(off) > 4 * numbers(rows, "sigma_heading_deg")[fixed]).sum() <= 0.02 * len(rows)


# Clocks.

CLOCKS = {
    "steps of a millisecond": (Clock(offset=2e-6), Clock(drift=4e-5, jump=1e-3)),
    "half a second": (Clock(offset=2e-6), Clock(offset=0.5)),
    "minus half a second": (Clock(offset=2e-6), Clock(offset=-0.5)),
    "both step": (Clock(offset=3e-4, drift=-3e-5, jump=1e-3), Clock(offset=-4e-4, drift=5e-5, jump=1e-3)),
}


@pytest.mark.parametrize("clocks", CLOCKS)
@pytest.mark.parametrize("known", [False, True], ids=["", "known length"])
def test_bad_clocks_on_a_moving_car(heading, simulated, clocks, known):
    """At 15 m/s half a second is 7 m, a millisecond 1.5 cm: a degree of heading on a metre."""
    session = simulated("car-heading", duration=90.0, clocks=CLOCKS[clocks])
    _, rows, _ = heading(session.paths, *(("--length", session.length) if known else ()))
    assert_right(rows, session, 0.8)


# The length.


def test_the_record_says_that_the_length_was_used(heading, roof):
    _, _, record = heading(roof.paths, "--length", ROOF, "--every", 30)
    assert record["method"] == "length 0.991 m, sigma 0.005 m: in the search for the integers, and as a measurement of the baseline they give"
    _, _, record = heading(roof.paths, "--every", 30)
    assert record["method"] == "length not used"


@pytest.mark.parametrize(("length", "words"), [("1.041", "not 1.041 m: measure the length again"), ("991", "not 991 m: give the length in metres")])
@pytest.mark.parametrize("options", [(), ("--systems", "G", "--frequencies", 1), ("--systems", "G", "--frequencies", 1, "--single-epoch")])
def test_a_wrong_length_is_one_sentence(run, roof, tmp_path, length, words, options):
    answer = run("heading", *roof.paths, "-o", tmp_path / "out.csv", "--every", 3, "--length", length, *options)
    assert answer.status == 1
    (sentence,) = answer.complaint
    assert re.search(r"^gnsslab: the antennas are 0\.9[89]\d m apart by most fixed epochs, ", sentence)
    assert words in sentence
    assert not (tmp_path / "out.csv").exists()


def test_a_length_that_fits_badly_is_a_note_and_in_the_record(heading, roof):
    answer, _, record = heading(roof.paths, "--length", ROOF + 0.02, "--systems", "G", "--frequencies", 1)
    assert len(notes_about(answer, "fixed epochs measure 0.98")) == 1
    assert any("fixed epochs measure 0.98" in note for note in record["notes"])


@pytest.mark.parametrize("sigma", ["1e-6", "1"])
@pytest.mark.parametrize("options", [(), ("--systems", "G", "--frequencies", 1, "--single-epoch")], ids=["all", "GPS L1, single epochs"])
def test_a_sigma_of_the_length_too_small_or_large(heading, roof, sigma, options):
    _, rows, _ = heading(roof.paths, "--length", ROOF, "--length-sigma", sigma, "--every", 3, *options)
    fixed = statuses(rows) == "fixed"
    assert fixed.mean() > 0.9
    assert np.abs(turned(numbers(rows, "heading_deg"), 193.03))[fixed].max() < 1.0
    assert np.abs(numbers(rows, "length_m") - ROOF)[fixed].max() < (1e-4 if sigma == "1e-6" else 0.02)


@pytest.mark.parametrize("option", ["--length", "--length-sigma"])
@pytest.mark.parametrize("value", ["nan", "0", "-1", "inf"])
def test_no_such_length(run, roof, tmp_path, option, value):
    answer = run("heading", *roof.paths, "-o", tmp_path / "out.csv", "--length", 1, option, value)
    assert (answer.status, len(answer.complaint)) == (1, 1)
    assert f"{option} " in answer.complaint[0]
    assert "above zero" in answer.complaint[0]


@pytest.mark.parametrize("length", [0.3, 5.0])
@pytest.mark.parametrize("name", ["static-baseline", "car-heading"])
@pytest.mark.parametrize("options", [(), ("--systems", "G")], ids=["all", "GPS"])
def test_short_and_long_baselines_at_rest_and_moving(heading, simulated, name, length, options):
    session = simulated(name, length=length, duration=90.0)
    answer, rows, _ = heading(session.paths, "--length", session.length, *options)
    assert_right(rows, session, 0.9)
    assert not notes_about(answer, "length")


@pytest.mark.parametrize("length", [0.3, 5.0])
@pytest.mark.parametrize("options", [(), ("--single-epoch",)], ids=["filter", "single epochs"])
def test_seven_satellites_of_one_frequency_are_right_or_float(heading, simulated, length, options):
    """A minute and a half of GPS L1 on a car: how many are fixed is luck; that few are is said."""
    session = simulated("car-heading", length=length, duration=90.0)
    answer, rows, _ = heading(session.paths, "--length", session.length, "--systems", "G", "--frequencies", 1, *options)
    assert_right(rows, session, 0.0)
    is_few = (statuses(rows) == "fixed").sum() < 45
    assert len(notes_about(answer, r"of 90 epochs are fixed with the length")) == is_few


# The files exchanged.


@pytest.mark.parametrize("options", [(), ("--systems", "G", "--frequencies", 1), ("--systems", "G", "--frequencies", 1, "--single-epoch")])
def test_exchanged_files_turn_the_heading_and_keep_the_status(heading, roof, options):
    _, there, _ = heading(roof.paths, "--length", ROOF, "--every", 2, *options)
    _, back, _ = heading((roof.rover, roof.master, roof.nav), "--length", ROOF, "--every", 2, *options)
    assert_turned(there, back)


@pytest.mark.parametrize("clocks", ["steps of a millisecond", "both step"])
def test_exchanged_files_of_a_turning_ship(heading, simulated, clocks):
    """Headings are those at the rover's instants: a millisecond of 6 degrees in 9 s is 0.004 degrees."""
    session = simulated("ship-heading", duration=90.0, clocks=CLOCKS[clocks])
    _, there, _ = heading(session.paths, "--length", session.length)
    _, back, _ = heading((session.rover, session.master, session.nav), "--length", session.length)
    assert_turned(there, back)


def assert_turned(there, back):
    assert statuses(there).tolist() == statuses(back).tolist()
    fixed = statuses(there) == "fixed"
    assert fixed.mean() > 0.8
    apart = turned(numbers(back, "heading_deg"), numbers(there, "heading_deg") + 180)[fixed]
    assert np.abs(apart).max() < 0.02
    assert np.abs(numbers(back, "pitch_deg") + numbers(there, "pitch_deg"))[fixed].max() < 0.02


# One antenna much worse than the other.


@pytest.mark.parametrize(("times", "least"), [(4, 0.5), (10, 0.0)])
def test_one_antenna_much_worse_than_the_other(heading, simulated, tmp_path, times, least):
    """The rover's errors are so many times as large: right or float, at most 1 % of the epochs wrong; at four times most are still fixed."""
    session = simulated("static-baseline", duration=150.0, noise=LOW_COST)
    quiet = session.master.rename(tmp_path / "quiet.obs")
    names = ("code", "carrier", "code_multipath", "carrier_multipath")
    bad = replace(LOW_COST, **{name: times * getattr(LOW_COST, name) for name in names})
    noisy = simulated("static-baseline", duration=150.0, noise=bad)  # the same draws, so that only the rover's noise is another
    for options, share in (((), least), (("--single-epoch",), least), (("--systems", "G", "--frequencies", 1), 0.0)):
        _, rows, _ = heading((quiet, noisy.rover, noisy.nav), "--length", session.length, *options)
        fixed = statuses(rows) == "fixed"
        off = np.abs(turned(numbers(rows, "heading_deg"), session.heading))
        assert fixed.mean() >= share, options
        assert (fixed & (off > np.degrees(WRONG / session.length))).mean() <= 0.01, options
        assert (statuses(rows) != "none").all(), options
