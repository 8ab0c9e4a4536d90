"""The end of a process while a thread still compiles: quiet, with the status asked for."""

import subprocess
import sys

import pytest

BUSY = """
import threading, time
from gnsslab.core.jit import kernel
from gnsslab.teaching.ending import end_process

@kernel
def spin(n):
    total = 0.0
    for i in range(n):
        total += (i % 7) * 0.5
    return total

threading.Thread(target=lambda: [spin(10**8) for _ in range(1000)], daemon=True).start()
time.sleep(0.5)
print("stopped")
end_process({status})
"""
IDLE = "from gnsslab.teaching.ending import end_process; print('stopped'); end_process({status})"


@pytest.mark.parametrize("program", [BUSY, IDLE])
@pytest.mark.parametrize("status", [0, 1])
def test_it_ends_with_its_status_and_its_last_words(program, status, tmp_path):
    file = tmp_path / "program.py"
    file.write_text(program.replace("{status}", str(status)))
    done = subprocess.run([sys.executable, file], capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stdout, done.stderr) == (status, "stopped\n", "")
