"""The data page: every set, whose it is, how it comes; and the law of simulated errors as the simulation has it."""

from dataclasses import fields

import numpy as np
import pytest
from html_outline import Outline

from gnsslab.data import read_registry
from gnsslab.data.locations import project_folder
from gnsslab.simulate import LOW_COST, PRESETS, SURVEY
from gnsslab.simulate.receivers import multipath_factor, white_factor
from gnsslab.teaching.pages.data_sources import NOISE
from gnsslab.teaching.pages.pages import data_page

PAGE = data_page()
OUTLINE = Outline(PAGE)


@pytest.mark.parametrize("dataset", read_registry().values(), ids=lambda dataset: dataset.name)
def test_set_is_told_with_all_its_facts(dataset):
    assert dataset.name in OUTLINE.ids
    for fact in (dataset.title, dataset.place, dataset.span, dataset.receivers, dataset.truth, dataset.use, dataset.licence, dataset.credit):
        assert fact
        assert " ".join(fact.split()) in OUTLINE.text


@pytest.mark.parametrize("dataset", read_registry().values(), ids=lambda dataset: dataset.name)
def test_way_of_a_set_is_that_of_its_files(dataset):
    section = Outline(f'<section id="{dataset.name}">' + PAGE.split(f'id="{dataset.name}">')[1].split("</section>")[0] + "</section>")
    travels = (project_folder("datasets") / dataset.name).is_dir()
    assert ("travels with the course" in section.text) == travels
    assert ("downloaded when first used" in section.text) != travels
    assert ("from a local mirror only" in section.text) == any(file.made_from for file in dataset.files)
    commits = {file.url.split("/raw/")[1].split("/")[0] for file in dataset.files if file.url}
    assert {link.rsplit("/", 1)[1] for link in section.links} == commits


def test_every_size_of_the_noise_is_told():
    assert set(NOISE) == {field.name for field in fields(SURVEY)}
    for name, (words, unit, scale) in NOISE.items():
        row = f"{words} {getattr(SURVEY, name) * scale:g} {getattr(LOW_COST, name) * scale:g} {unit}"
        assert row in OUTLINE.text


def test_numbers_in_the_law_are_those_of_the_simulation():
    thirty = np.radians(30.0)
    assert f"which is {white_factor(thirty):.1f} at 30 degrees" in OUTLINE.text
    assert f"which is {multipath_factor(thirty):.0f} at 30 degrees" in OUTLINE.text
    assert f"all but {100 * np.exp(-1):.0f} %" in OUTLINE.text


def test_every_preset_is_told():
    for preset in PRESETS.values():
        assert preset.title in OUTLINE.text
        assert preset.sentence in OUTLINE.text
