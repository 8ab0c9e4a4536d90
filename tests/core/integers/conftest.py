"""Numbers made elsewhere, and the obvious implementations, for the tests of the integers."""

import json
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))


@pytest.fixture(scope="session")
def reference():
    """The content of tests/reference/integers.json."""
    return json.loads((Path(__file__).parents[2] / "reference" / "integers.json").read_text())
