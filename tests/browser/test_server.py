"""The server by itself: addresses, theme, and a clean end on Ctrl-C."""

import os
import signal
import subprocess
import sys
from pathlib import Path
from urllib.error import HTTPError
from urllib.request import urlopen

import pytest

from gnsslab.teaching.catalogue import LESSONS


def _get(address):
    with urlopen(address, timeout=30) as answer:
        return answer.read().decode("utf-8")


def test_home_and_lessons_answer_and_follow_the_system_theme(course):
    home = _get(course)
    for lesson in LESSONS:
        assert f'href="{lesson.address}"' in home
        for address in (lesson.address, lesson.address.rstrip("/")):
            page = _get(course.rstrip("/") + address)
            assert lesson.title in page
            assert '"theme": "system"' in page


def test_unknown_address_is_not_found(course):
    with pytest.raises(HTTPError, match="404"):
        _get(course + "nothing").close()


def test_ctrl_c_ends_cleanly_with_a_lesson_open(chromium):
    with subprocess.Popen(
        [sys.executable, "-u", "-m", "gnsslab", "course", "--no-browser", "--port", "24780"],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        env=os.environ | {"PYTHONPATH": str(Path(__file__).resolve().parents[2])},
    ) as process:  # fmt: skip
        address = process.stdout.readline().split("the course is at ")[1].split()[0]
        context = chromium.new_context()
        page = context.new_page()
        page.goto(f"{address}lesson/00/")
        page.get_by_role("radio").first.wait_for(timeout=30_000)
        process.send_signal(signal.SIGINT)
        try:
            out, err = process.communicate(timeout=20)
        except subprocess.TimeoutExpired:
            process.kill()
            raise
        context.close()
    assert process.returncode == 0
    assert "stopped" in out
    assert "Traceback" not in out + err
