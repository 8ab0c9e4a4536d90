"""Bad input through the command line: each gets one plain sentence and status 1, no traceback, and no output file."""

import gzip
import re
from pathlib import Path

import pytest


def unpacked(path):
    return gzip.decompress(path.read_bytes())


@pytest.fixture(scope="session")
def bad(tmp_path_factory, files):
    """A folder of files that students bring."""
    folder = tmp_path_factory.mktemp("bad")
    rover = unpacked(files.rover)
    (folder / "empty.obs").write_bytes(b"")
    (folder / "binary.obs").write_bytes(bytes(range(256)) * 40)
    (folder / "letters.obs").write_bytes(rover.replace(b"G01  ", b"G01ab", 1) if b"G01  " in rover else with_letters(rover))
    (folder / "two.obs.gz").write_bytes(b"\x1f\x8b")
    (folder / "tomorrow.obs").write_bytes(rover.replace(b"> 2021 03 19", b"> 2021 03 20"))
    (folder / "tomorrow.nav").write_bytes(unpacked(files.nav).replace(b" 2021 03 19", b" 2021 05 19").replace(b" 2021 03 18", b" 2021 05 18"))
    (folder / "glonass.obs").write_bytes(only_system(rover, b"J"))
    (folder / "galileo.obs").write_bytes(only_system(unpacked(files.base), b"E"))
    (folder / "header.obs").write_bytes(rover[: rover.index(b"END OF HEADER") + 14])
    (folder / "copy.obs").write_bytes(rover)
    return folder


def with_letters(text):
    """Put letters into the first number of the first satellite line."""
    at = re.search(rb"\n[GEJ]\d\d", text).end()
    return text[: at + 3] + b"x2y" + text[at + 6 :]


def only_system(text, letter):
    """Leave the lines of one system in an observation file (RINEX 3), counts mended."""
    head, body = text.split(b"END OF HEADER", 1)
    epochs = body.split(b"\n>")
    kept = [epochs[0]]
    for epoch in epochs[1:]:
        first, *lines = epoch.split(b"\n")
        lines = [line for line in lines if line[:1] == letter]
        kept.append(first[:31] + b"%3d" % len(lines) + first[34:] + b"".join(b"\n" + line for line in lines))
    return head + b"END OF HEADER" + b"\n>".join(kept) + b"\n"


# what stands on the command line in place of master, rover or navigation, and words that must be in the answer
FILES = {
    "empty file": ("rover", "empty.obs", "empty"),
    "binary file": ("rover", "binary.obs", "binary.obs"),
    "navigation given as observation": ("rover", "NAV", "navigation"),
    "observation given as navigation": ("nav", "ROVER", "observation"),
    "no common epochs": ("rover", "tomorrow.obs", "epoch"),
    "no common satellites": (("master", "rover"), ("galileo.obs", "glonass.obs"), "satellite|signal"),
    "wrong day's navigation": ("nav", "tomorrow.nav", "those given are for 2021-05-|day of the observations"),
    "letters in a number field": ("rover", "letters.obs", r"line \d+"),
    "two-byte .gz": ("rover", "two.obs.gz", "gz|compressed"),
    "a folder": ("rover", ".", "folder"),
    "a folder as navigation": ("nav", ".", "folder"),
    "missing file": ("rover", "nowhere.obs", "nowhere.obs.*no such file"),
    "missing navigation": ("nav", "nowhere.nav", "nowhere.nav.*no such file"),
    "header only": ("rover", "header.obs", "epoch"),
    "the same file twice": ("rover", "MASTER", "same"),
    "a copy of the same file": (("master", "rover"), ("ROVER", "copy.obs"), "same"),
}
OPTIONS = {
    "unknown system": (("--systems", "GX"), "'X'"),
    "GLONASS": (("--systems", "R"), "GLONASS is read, not used"),
    "SBAS": (("--systems", "GS"), "SBAS is read, not used"),
    "no system": (("--systems", ""), "empty"),
    "mask above the zenith": (("--mask-deg", "91"), "0 to 90"),
    "mask below the horizon": (("--mask-deg", "-1"), "0 to 90"),
    "mask that is no number": (("--mask-deg", "nan"), "0 to 90"),
    "no frequency": (("--frequencies", "0"), "1 to 3"),
    "four frequencies": (("--frequencies", "4"), "1 to 3"),
    "frequencies and signals": (("--frequencies", "1", "--signals", "C1C"), "exclude each other"),
    "a signal that is none": (("--signals", "C1C,B3I"), "'B3I'"),
    "from in words": (("--from", "yesterday"), "2024-06-24T08:20:00"),
    "month 13": (("--to", "2021-13-01"), "2024-06-24T08:20:00"),
    "from after to": (("--from", "2021-03-19T12:00:30", "--to", "2021-03-19T12:00:10"), "after"),
    "span without epochs": (("--from", "2022-01-01"), "spans 2021-03-19T12:00:00.000"),
    "every zero": (("--every", "0"), "above zero"),
    "every negative": (("--every", "-5"), "above zero"),
    "picture of unknown kind": (("--plot", "x.doc"), ".png"),
    "picture that cannot be written": (("--plot", "nowhere/x.png"), "does not exist"),
}
HEADING_OPTIONS = {
    "length zero": (("--length", "0"), "above zero"),
    "length negative": (("--length", "-1.2"), "above zero"),
    "length infinite": (("--length", "inf"), "above zero"),
    "length sigma zero": (("--length-sigma", "0"), "above zero"),
    "mount heading nan": (("--mount-heading", "nan"), "finite"),
}
RTK_OPTIONS = {
    "two coordinates": (("--base-position", "1,2"), "three"),
    "coordinates in words": (("--base-position", "here"), "three"),
    "a place in space": (("--base-position", "1,2,3"), "not on the ground"),
    "nan": (("--base-position", "nan,nan,nan"), "not on the ground"),
}


def assert_one_sentence(answer, words, *outputs):
    assert answer.status == 1, answer
    assert answer.out == ""
    assert len(answer.complaint) == 1, answer.err
    assert answer.complaint[0].startswith("gnsslab: ")
    assert "a mistake in gnsslab" not in answer.err
    assert re.search(words, answer.complaint[0], re.IGNORECASE), answer.complaint[0]
    assert not any(Path(output).exists() for output in outputs)


@pytest.mark.parametrize("command", ["heading", "rtk"])
@pytest.mark.parametrize("case", FILES)
def test_bad_file(run, files, bad, tmp_path, command, case):
    places, names, words = FILES[case]
    known = {"MASTER": files.base, "ROVER": files.rover, "NAV": files.nav}
    given = {"master": files.base, "rover": files.rover, "nav": files.nav}
    for place, name in zip([places], [names], strict=True) if isinstance(places, str) else zip(places, names, strict=True):
        given[place] = known.get(name, bad / name)
    out = tmp_path / "out.csv"
    assert_one_sentence(run(command, *given.values(), "-o", out), words, out, f"{out}.json")


@pytest.mark.parametrize("command", ["heading", "rtk"])
def test_file_cut_in_the_middle_of_an_epoch(run, files, tmp_path, command):
    cut = tmp_path / "cut.obs"
    cut.write_bytes(unpacked(files.rover)[:-2000])
    answer = run(command, files.base, cut, files.nav, "-o", tmp_path / "out.csv")
    assert answer.status == 0, answer.err
    assert answer.complaint == []
    assert "cut.obs" in answer.err  # a note says that the last epoch is left out
    assert len((tmp_path / "out.csv").read_text().splitlines()) == 1 + 59


@pytest.mark.parametrize("command", ["heading", "rtk"])
@pytest.mark.parametrize("case", OPTIONS)
def test_bad_option(run, files, tmp_path, command, case):
    arguments, words = OPTIONS[case]
    out = tmp_path / "out.csv"
    assert_one_sentence(run(command, *files, "-o", out, *arguments), words, out)


@pytest.mark.parametrize("case", HEADING_OPTIONS)
def test_bad_option_of_heading(run, files, tmp_path, case):
    arguments, words = HEADING_OPTIONS[case]
    assert_one_sentence(run("heading", *files, "-o", tmp_path / "out.csv", *arguments), words, tmp_path / "out.csv")


@pytest.mark.parametrize("case", RTK_OPTIONS)
def test_bad_option_of_rtk(run, files, tmp_path, case):
    arguments, words = RTK_OPTIONS[case]
    assert_one_sentence(run("rtk", *files, "-o", tmp_path / "out.csv", *arguments), words, tmp_path / "out.csv")


@pytest.mark.parametrize("command", ["heading", "rtk"])
def test_output_that_cannot_be_written_is_found_out_before_the_work(run, files, tmp_path, monkeypatch, command):
    def never(*_):
        raise AssertionError("read before the output was checked")

    monkeypatch.setattr("gnsslab.cli.baseline.read_inputs", never)
    (tmp_path / "a-file").write_text("")
    assert_one_sentence(run(command, *files, "-o", tmp_path), "folder")
    assert_one_sentence(run(command, *files, "-o", tmp_path / "nowhere" / "out.csv"), "does not exist")
    assert_one_sentence(run(command, *files, "-o", tmp_path / "x.png", "--plot", tmp_path / "x.png"), "after --plot", tmp_path / "x.png")
    assert_one_sentence(run(command, *files, "-o", tmp_path / "a-file" / "out.csv"), "does not exist")
    assert_one_sentence(run(command, *files, "-o", "/proc/out.csv" if Path("/proc/self").exists() else tmp_path), "written|folder")


def test_an_input_is_never_overwritten(run, files, tmp_path):
    rover = tmp_path / "rover.obs"
    rover.write_bytes(unpacked(files.rover))
    before = rover.read_bytes()
    answer = run("rtk", files.base, rover, files.nav, "-o", rover)
    assert answer.status == 1
    assert "one of the inputs" in answer.err
    assert rover.read_bytes() == before


@pytest.mark.parametrize("name", ["empty.obs", "binary.obs", "letters.obs", "two.obs.gz", ".", "nowhere.obs"])
def test_info_of_bad_files(run, bad, name):
    assert_one_sentence(run("info", bad / name), re.escape(name) if name != "." else "folder")


def test_folder_that_cannot_be_made(run, tmp_path):
    from gnsslab.simulate import PRESETS

    (tmp_path / "a-file").write_text("")
    assert_one_sentence(run("simulate", next(iter(PRESETS)), "-o", tmp_path / "a-file" / "x"), "cannot be made")
    assert_one_sentence(run("simulate", next(iter(PRESETS)), "-o", tmp_path / "y", "--seed", "-1"), "seed")


@pytest.mark.parametrize("command", [("simulate", "static-baseline"), ("heading", "a.obs", "b.obs", "c.nav"), ("rtk", "a.obs", "b.obs", "c.nav")])
def test_an_output_without_a_name(run, tmp_path, monkeypatch, command):
    monkeypatch.chdir(tmp_path)
    answer = run(*command, "-o", "")
    assert answer.status == 1
    assert len(answer.complaint) == 1
    assert "has no name" in answer.complaint[0]
    assert not list(tmp_path.iterdir())


def test_heading_under_the_name_of_another_format(run, files, tmp_path):
    answer = run("heading", *files, "-o", tmp_path / "out.pos")
    assert answer.status == 1
    assert "heading writes CSV" in answer.complaint[0]
    assert not (tmp_path / "out.pos").exists()


def test_a_base_that_stands_a_hundred_metres_off_is_noted(run, files, tmp_path):
    """The registry's position with x wrong by 100 m; the right one passes without a word."""
    right = "-3959400.631,3385704.533,3667523.111"
    assert "codes place it" not in run("rtk", *files, "-o", tmp_path / "right.csv", "--base-position", right).err
    answer = run("rtk", *files, "-o", tmp_path / "wrong.csv", "--base-position", right.replace("59400", "59300"))
    assert answer.status == 0
    (note,) = [line for line in answer.err.splitlines() if "codes place it" in line]
    assert 90 <= float(re.search(r"is (\d+) m from", note)[1]) <= 110
