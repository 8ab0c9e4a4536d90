"""Save this: every lab's picture, numbers and link can be taken along and read again."""

import csv
import io
from urllib.parse import parse_qsl, urlparse
from xml.etree import ElementTree

import numpy as np
import pytest

from gnsslab.labs.links import settings_of
from gnsslab.teaching.catalogue import LESSONS
from gnsslab.teaching.desk import Desk
from gnsslab.teaching.saving import link_of, saved, table_text

LABS = [(lesson, name) for lesson in LESSONS for name in lesson.open_labs()]


@pytest.fixture(scope="module", params=LABS, ids=lambda each: each[1])
def at_desk(request):
    """A lesson and a desk with one of its labs, run at its defaults."""
    lesson, name = request.param
    desk = Desk(lesson.open_labs()[name])
    desk.run({})
    return lesson, desk


def test_there_are_labs():
    assert LABS


def test_pictures_are_what_their_names_say(at_desk):
    _, desk = at_desk
    assert saved(desk, "png").startswith(b"\x89PNG")
    assert ElementTree.fromstring(saved(desk, "svg")).tag.endswith("svg")


def test_numbers_read_back(at_desk):
    _, desk = at_desk
    columns = desk.lab.table(desk.result)
    rows = list(csv.DictReader(io.StringIO(saved(desk, "csv").decode("utf-8"))))
    assert len(rows) == len(next(iter(columns.values()))) > 0
    assert list(rows[0]) == list(columns)
    assert all(value not in ("nan", "None") for row in rows for value in row.values())


def test_link_brings_the_controls_back(at_desk):
    lesson, desk = at_desk
    address = urlparse(link_of(lesson, desk))
    assert address.path == lesson.address
    settings, problems = settings_of(desk.lab, dict(parse_qsl(address.query)))
    assert problems == []
    assert settings == {name: value for name, value in desk.settings.items() if name in settings}
    assert "seed" in settings or "seed" not in desk.settings


def test_columns_of_unequal_length_are_refused():
    with pytest.raises(ValueError, match="zip"):
        table_text({"a": np.zeros(2), "b": np.zeros(3)})
