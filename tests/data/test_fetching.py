"""Fetching: mirror, travelling set, cache and download in this order, a checksum each time, one line when it cannot be had."""

import functools
import hashlib
import http.server
import threading

import pytest

from gnsslab.data import DataFile, Dataset, DataUnavailable, dataset_path, fetch, verify
from gnsslab.data import fetching as module

CONTENT = {"a.obs": b"observations\n" * 5000, "b.nav": b"navigation\n" * 300}


@pytest.fixture(autouse=True)
def places(monkeypatch, tmp_path):
    """An empty cache and no mirror."""
    monkeypatch.setenv("GNSSLAB_CACHE", str(tmp_path / "cache"))
    monkeypatch.delenv("GNSSLAB_DATA_MIRROR", raising=False)
    return tmp_path


@pytest.fixture
def server(tmp_path):
    """A server of this machine with the files of a data set; gives its address and the list of what was asked for."""
    asked = []
    (tmp_path / "served").mkdir()
    for name, content in CONTENT.items():
        (tmp_path / "served" / name).write_bytes(content)

    class Quiet(http.server.SimpleHTTPRequestHandler):
        def log_message(self, *_):
            asked.append(self.path)

    handler = functools.partial(Quiet, directory=str(tmp_path / "served"))
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as running:
        threading.Thread(target=running.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{running.server_port}", asked
        running.shutdown()


@pytest.fixture
def small(monkeypatch, server):
    """A registered data set on that server."""
    files = tuple(DataFile(name, len(text), hashlib.sha256(text).hexdigest(), f"{server[0]}/{name}") for name, text in CONTENT.items())
    return register(monkeypatch, files)


def register(monkeypatch, files):
    dataset = Dataset("small", "a small set", "none", "", "", files)
    monkeypatch.setattr(module, "find_dataset", lambda name: dataset)
    return dataset


def test_downloads_once_and_tells_progress(small, server, places):
    seen = []
    folder = fetch("small", lambda done, total: seen.append((done, total)))
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == CONTENT
    assert folder == places / "cache" / "small"
    assert seen[-1] == (small.size, small.size)
    assert [done for done, _ in seen] == sorted(done for done, _ in seen)
    assert len(server[1]) == 2
    assert dataset_path("small", "a.obs") == folder / "a.obs"
    assert len(server[1]) == 2


def test_a_damaged_file_in_the_cache_is_fetched_again(small, server, places):
    (fetch("small") / "a.obs").write_bytes(b"damaged")
    assert verify("small")["a.obs"].startswith("wrong checksum")
    assert dataset_path("small", "a.obs").read_bytes() == CONTENT["a.obs"]
    assert set(verify("small").values()) == {"ok"}


def test_something_else_from_the_server_is_refused(small, places):
    (places / "served" / "a.obs").write_bytes(b"<html>not found</html>")
    with pytest.raises(DataUnavailable, match=r"sent something else than a\.obs"):
        fetch("small")


def test_the_mirror_comes_first(small, server, places, monkeypatch):
    mirror = mirrored(places, monkeypatch)
    assert fetch("small") == mirror
    assert dataset_path("small", "b.nav") == mirror / "b.nav"
    assert server[1] == []


def test_a_wrong_file_in_the_mirror_is_no_secret(small, places, monkeypatch):
    (mirrored(places, monkeypatch) / "a.obs").write_bytes(b"other")
    with pytest.raises(DataUnavailable, match=r"a\.obs is not the registry's file"):
        fetch("small")


def test_a_mirror_that_is_no_folder_is_said(small, places, monkeypatch):
    monkeypatch.setenv("GNSSLAB_DATA_MIRROR", str(places / "nowhere"))
    with pytest.raises(OSError, match="which is no folder"):
        fetch("small")


def mirrored(places, monkeypatch):
    folder = places / "mirror" / "small"
    folder.mkdir(parents=True)
    for name, content in CONTENT.items():
        (folder / name).write_bytes(content)
    monkeypatch.setenv("GNSSLAB_DATA_MIRROR", str(folder.parent))
    return folder


def test_without_network_one_line_says_what_to_do(monkeypatch):
    register(monkeypatch, (DataFile("a.obs", 3, "0" * 64, "http://127.0.0.1:9/a.obs"),))
    with pytest.raises(DataUnavailable) as caught:
        fetch("small")
    message = str(caught.value)
    assert "\n" not in message
    assert "gnsslab data get small" in message
    assert "GNSSLAB_DATA_MIRROR" in message


def test_without_address_one_line_says_what_to_do(monkeypatch):
    register(monkeypatch, (DataFile("a.obs", 3, "0" * 64, made_from="converted from a.rtcm3"),))
    with pytest.raises(DataUnavailable, match=r"no public address \(it was converted from a.rtcm3\): put it into a folder"):
        fetch("small")


def test_a_cache_that_cannot_be_written_is_said(small, places, monkeypatch):
    (places / "file").write_text("")
    monkeypatch.setenv("GNSSLAB_CACHE", str(places / "file"))
    with pytest.raises(DataUnavailable, match="GNSSLAB_CACHE"):
        fetch("small")


def test_the_travelling_set_needs_no_network(places):
    folder = fetch("cssrlib-078")
    assert folder == places / "cache" / "cssrlib-078"
    assert len(list(folder.iterdir())) == 4
    assert set(verify("cssrlib-078").values()) == {"ok"}
