"""`gnsslab course`: options that do not go together, in one sentence."""

import pytest


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--host", "0.0.0.0"), "--jupyter is for this machine only, not for 0.0.0.0"),
        (("--present",), "--jupyter and --present exclude each other"),
        (("--token", "roof"), "--jupyter and --token exclude each other"),
        (("--no-token",), "--jupyter and --no-token exclude each other"),
        (("--port", "0"), "--port 0: expected a port number"),
    ],
)
def test_jupyter_refuses_what_it_cannot_do(run, tmp_path, monkeypatch, options, words):
    monkeypatch.chdir(tmp_path)
    answer = run("course", "--jupyter", *options)
    assert answer.status == 1
    assert len(answer.complaint) == 1
    assert words in answer.complaint[0]
    assert list(tmp_path.iterdir()) == []
