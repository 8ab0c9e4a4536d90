"""The labs of the course, each made once, so that what one test has computed the next one finds."""

import pytest
from coming_labs import COMING

from gnsslab.teaching.catalogue import LESSONS


@pytest.fixture(scope="session")
def labs():
    """All labs by name."""
    return {name: lab for lesson in (*LESSONS, COMING) for name, lab in lesson.open_labs().items()}


@pytest.fixture(scope="module")
def lab(labs, request):
    """The lab that a module of tests names in LAB."""
    return labs[request.module.LAB]
