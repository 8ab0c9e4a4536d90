"""The registry: complete, and true of what travels with the project."""

import gzip
import hashlib
import re

import numpy as np
import pytest

from gnsslab.data import find_dataset, read_registry
from gnsslab.data.locations import project_folder
from gnsslab.gnss.frames import enu_rotation, geodetic_from_ecef
from gnsslab.gnss.rinex import read_rinex_obs

millimetre = 1e-3
TRAVELS = "cssrlib-078"


@pytest.mark.parametrize("name", read_registry())
def test_each_file_has_checksum_size_and_origin(name):
    dataset = find_dataset(name)
    assert dataset.files
    assert dataset.title
    assert dataset.licence
    for file in dataset.files:
        assert re.fullmatch("[0-9a-f]{64}", file.sha256)
        assert file.size > 0
        assert bool(file.url) != bool(file.made_from)
        assert not file.url or re.search("/[0-9a-f]{40}/", file.url), "an address without a fixed commit may change"
    known = {file.name for file in dataset.files}
    assert {name for name in (dataset.base, dataset.rover, *dataset.nav) if name} <= known


def test_what_travels_is_what_the_registry_says():
    for file in find_dataset(TRAVELS).files:
        packed = project_folder("datasets") / TRAVELS / f"{file.name}.gz"
        content = gzip.decompress(packed.read_bytes())
        assert (len(content), hashlib.sha256(content).hexdigest()) == (file.size, file.sha256)


def test_the_known_positions_agree_with_the_known_length():
    dataset = find_dataset(TRAVELS)
    baseline = dataset.rover_position - dataset.base_position
    assert np.linalg.norm(baseline) == pytest.approx(5290.0282, abs=millimetre)  # as published with the set
    assert np.linalg.norm(find_dataset("matrtklib-static").baseline_enu) == pytest.approx(0.9902, abs=millimetre)


def test_geodetic_base_becomes_ecef(dataset):
    folder = dataset("matrtklib-static")
    latitude_deg, longitude_deg, _ = map(float, (folder / "base_position.txt").read_text().split())
    up = enu_rotation(find_dataset("matrtklib-static").base_position)[2]
    assert np.degrees(np.arcsin(up[2])) == pytest.approx(latitude_deg, abs=1e-9)
    assert np.degrees(np.arctan2(up[1], up[0])) == pytest.approx(longitude_deg, abs=1e-9)


def test_unknown_names_are_answered_with_the_known_ones():
    with pytest.raises(ValueError, match=r"no data set 'mars': expected one of cssrlib-078, geonet-0759-3040"):
        find_dataset("mars")
    with pytest.raises(ValueError, match=r"no file 'x': it has 30340780.21q"):
        find_dataset(TRAVELS).file("x")


def test_repr_can_be_read_aloud():
    assert repr(find_dataset("geonet-0759-3040")) == (
        "Dataset geonet-0759-3040: 3.34 km GPS L1/L2 baseline, 57 min at 30 s, 2005-04-02; 4 files, 0.3 MB"
    )


@pytest.mark.parametrize("name", read_registry())
def test_each_set_says_where_when_with_what_and_whose_it_is(name):
    known = find_dataset(name)
    assert known.place
    assert known.receivers
    assert known.credit
    assert re.match(r"\d{4}-\d\d-\d\d", known.span)


@pytest.mark.parametrize("name", [name for name, known in read_registry().items() if known.rover])
def test_place_and_span_are_those_of_the_files(dataset, name):
    known = find_dataset(name)
    observed = read_rinex_obs(dataset(name) / (known.base or known.rover))
    latitude, longitude, _ = geodetic_from_ecef(observed.header.position_ecef)
    for degrees, letters in ((np.degrees(latitude), "NS"), (np.degrees(longitude), "EW")):
        assert f"{abs(degrees):.1f} {letters[int(degrees < 0)]}" in known.place
    first, last = (np.datetime_as_string(label, "s") for label in (observed.time[0], observed.time[-1] + np.timedelta64(100, "ms")))
    assert known.span.startswith(f"{first[:10]}, {first[11:]} to ")
    assert last[11:] in known.span
