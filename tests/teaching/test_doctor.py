"""The doctor: says what is missing, and what to type."""

import sys
from importlib import metadata

import pytest

from gnsslab.teaching import doctor


def test_all_is_well_where_the_tests_run():
    findings = doctor.examine()
    assert [finding.words for finding in findings if finding.state == "broken"] == []
    assert len(findings) > 10


def test_missing_and_other_packages_are_told_apart():
    assert doctor.package("no-such-package", ()) == ("broken", "no-such-package is not installed: type `pip install no-such-package`")
    installed = metadata.version("numpy")
    assert doctor.package("numpy", (installed,)).state == "well"
    other = doctor.package("numpy", ("0.1",))
    assert other.state == "hint"
    assert "type `pip install numpy==0.1`" in other.words


def test_old_python_is_told(monkeypatch):
    monkeypatch.setattr(sys, "version_info", (3, 9, 1))
    assert doctor.python().state == "broken"


def test_every_needed_package_has_a_tested_version():
    assert [finding.words for finding in doctor.packages() if "tested" not in finding.words] == []


def test_cache_that_cannot_be_written(monkeypatch, tmp_path):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("GNSSLAB_CACHE", str(tmp_path / "file"))
    assert doctor.cache().state == "broken"
    assert "GNSSLAB_CACHE" in doctor.cache().words


def test_mirror_that_is_no_folder(monkeypatch, tmp_path):
    monkeypatch.setenv("GNSSLAB_DATA_MIRROR", str(tmp_path / "nowhere"))
    (finding,) = doctor.data_sets()
    assert finding.state == "broken"


def test_missing_browser_and_lessons(monkeypatch):
    import webbrowser

    def none():
        raise webbrowser.Error("no browser")

    def gone(name):
        raise FileNotFoundError("install gnsslab again")

    monkeypatch.setattr(webbrowser, "get", none)
    monkeypatch.setattr(doctor, "project_folder", gone)
    assert "--no-browser" in doctor.browser().words
    assert doctor.lessons().state == "broken"


@pytest.mark.parametrize("state", ["not here yet", "wrong checksum: delete x"])
def test_missing_data_is_a_hint(state):
    finding = doctor._data_set("small", [state])
    assert finding.state == "hint"
    assert "gnsslab data get small" in finding.words
