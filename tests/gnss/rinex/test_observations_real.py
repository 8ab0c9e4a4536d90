"""The fast reader against a plain one, line by line and float by float, on every real file of the registry."""

from datetime import datetime, timedelta

import numpy as np
import pytest

from gnsslab.gnss.rinex import read_rinex_obs, write_rinex_obs
from gnsslab.gnss.rinex.text import read_bytes

FILES = [
    ("matrtklib-static", "base.obs"),
    ("matrtklib-static", "rover.obs"),
    ("geonet-0759-3040", "07590920.05o"),
    ("geonet-0759-3040", "30400920.05o"),
    ("cssrlib-078", "3034078M1.21O"),
    ("cssrlib-078", "SEPT078M1.21O"),
    ("gnssimu-walk", "walk.obs"),
    ("beidou-slope", "base_all.obs.gz"),
]
PARTS = ("epoch", "number", "value", "lli", "ssi")
GEONET_CODES = {"L1": "L1C", "C1": "C1C", "L2": "L2W", "P2": "C2W"}


def file_of(dataset, name, file):
    """Path of a file of a data set; some sets hold it packed, or under a name with .gz."""
    folder = dataset(name)
    found = [path for path in (folder / file, folder / f"{file}.gz", folder / file.removesuffix(".gz")) if path.exists()]
    if not found:
        pytest.skip(f"{name} has no {file}")
    return found[0]


def plainly_read(text):
    """Return (time, satellite, code) -> (value, lli, ssi), read one line after the other."""
    lines = iter(text.splitlines())
    codes, version = plain_header(lines)
    body = plain_epochs3(lines) if version >= 3 else plain_epochs2(lines, len(codes["G"]))
    return {
        (time, name, code): plain_field(fields[16 * at : 16 * at + 16].ljust(16))
        for time, name, fields in body
        for at, code in enumerate(codes[name[0]])
    }


def plain_header(lines):
    codes, version, letter = {}, 0.0, ""
    for line in lines:
        if line[60:].startswith("RINEX VERSION"):
            version = float(line[:9])
        elif line[60:].startswith("SYS / # / OBS TYPES"):
            letter = line[0] if line[0] != " " else letter
            codes.setdefault(letter, []).extend(line[6:60].split())
        elif line[60:].startswith("# / TYPES OF OBSERV"):
            codes["G"] = [GEONET_CODES[kind] for kind in line[6:60].split()]
        elif line[60:].startswith("END OF HEADER"):
            return codes, version
    raise AssertionError("no END OF HEADER")


def plain_time(year, month, day, hour, minute, second):
    whole, _, fraction = second.partition(".")
    time = datetime(int(year), int(month), int(day), int(hour), int(minute)) + timedelta(seconds=int(whole))
    return np.datetime64(time, "ns") + np.timedelta64(int(fraction.ljust(9, "0")), "ns")


def plain_epochs3(lines):
    for line in lines:
        words = line[1:].split()
        for row in [next(lines) for _ in range(int(words[7]))]:
            yield plain_time(*words[:6]), row[:3], row[3:]


def plain_epochs2(lines, types):
    for line in lines:
        flag, count = int(line[28]), int(line[29:32])
        if flag > 1:
            for _ in range(count):
                next(lines)
            continue
        names = line[32:68]
        for _ in range((count - 1) // 12):
            names += next(lines)[32:68]
        time = plain_time("20" + line[1:3].replace(" ", "0"), *line[3:26].split())
        for at in range(count):
            fields = "".join(next(lines).ljust(80) for _ in range((types + 4) // 5))
            yield time, names[3 * at : 3 * at + 3].replace(" ", "0"), fields


def plain_field(field):
    number = float(field[:14]) if field[:14].strip() else None
    return number, int(field[14].strip() or 0), int(field[15].strip() or 0)


def as_dictionary(observations):
    """The same shape from what the library read."""
    return {
        (observations.time[epoch], f"{letter}{number:02d}", code): (None if value != value else value, lli, ssi)
        for letter, table in observations.tables.items()
        for epoch, number, *rows in zip(*(getattr(table, part).tolist() for part in PARTS), strict=True)
        for code, value, lli, ssi in zip(table.codes, *rows, strict=True)
    }


@pytest.mark.parametrize(("name", "file"), FILES, ids=[f"{name}-{file}" for name, file in FILES])
def test_every_value_and_flag_is_what_a_plain_reader_reads(dataset, name, file):
    path = file_of(dataset, name, file)
    expected = plainly_read(read_bytes(path).decode())
    found = as_dictionary(read_rinex_obs(path))
    assert len(expected) > 1000
    assert found.keys() == expected.keys()
    different = [key for key, value in expected.items() if found[key] != value]
    zeros = [key for key in different if expected[key][0] == 0 and key[2][0] in "CL"]  # 0.0 means missing there
    assert different == zeros


@pytest.mark.parametrize(("name", "file"), FILES[:7], ids=[f"{name}-{file}" for name, file in FILES[:7]])
def test_written_and_read_again_nothing_changes(dataset, name, file, tmp_path):
    first = read_rinex_obs(file_of(dataset, name, file))
    write_rinex_obs(tmp_path / "again.obs", first)
    second = read_rinex_obs(tmp_path / "again.obs")
    assert np.array_equal(first.time, second.time)
    assert first.header.glonass_channels == second.header.glonass_channels
    for letter, table in first.tables.items():
        other = second.tables[letter]
        assert table.codes == other.codes
        assert np.array_equal(table.value, other.value, equal_nan=True)
        assert all(np.array_equal(getattr(table, part), getattr(other, part)) for part in ("epoch", "number", "lli", "ssi"))
    assert second.warnings == ()


def test_a_file_cut_anywhere_keeps_every_whole_epoch(dataset, tmp_path, rng):
    text = read_bytes(file_of(dataset, "cssrlib-078", "SEPT078M1.21O"))
    whole = read_rinex_obs(file_of(dataset, "cssrlib-078", "SEPT078M1.21O"))
    start = text.index(b"\n>")
    for cut in rng.integers(start + 2, len(text), 60):
        (tmp_path / "cut.obs").write_bytes(text[:cut])
        observations = read_rinex_obs(tmp_path / "cut.obs")
        begun = text[:cut].count(b"\n>")
        assert begun - 1 <= len(observations.time) <= begun
        assert len(observations.time) == begun or observations.warnings
        for letter, table in observations.tables.items():
            kept = len(table.epoch)
            assert np.array_equal(table.value, whole.tables[letter].value[:kept], equal_nan=True)
            assert np.array_equal(table.lli, whole.tables[letter].lli[:kept])
