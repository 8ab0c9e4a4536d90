"""RTKLIB, where it can be had: the second implementation of many tests here; and the path to modules that tests share."""

import importlib
import os
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))


@pytest.fixture(scope="session")
def rtk():
    """RTKLIB through pyrtklib; skips without it, fails under GNSSLAB_REQUIRE_ALL=1 where there is a wheel (Python below 3.14)."""
    try:
        return importlib.import_module("pyrtklib")
    except ImportError:
        reason = "pyrtklib is not installed, so RTKLIB's answers are not there to compare with"
    if os.environ.get("GNSSLAB_REQUIRE_ALL") == "1" and sys.version_info < (3, 14):
        pytest.fail(f"GNSSLAB_REQUIRE_ALL=1, but: {reason}")
    pytest.skip(reason)
