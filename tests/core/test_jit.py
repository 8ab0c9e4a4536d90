"""Kernels: the same answers compiled and as ordinary Python, and no crash where nothing can be written."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from gnsslab.core import jit

PROGRAM = """
import json, sys
import numpy as np
from gnsslab.core import integers, jit
rng = np.random.default_rng(7)
out = {"compiled": jit.COMPILED, "numba": "numba" in sys.modules, "answers": []}
for n in (1, 2, 5, 9):
    A = rng.standard_normal((n, n))
    Q, a = A @ A.T + 0.01 * np.eye(n), rng.uniform(-1e6, 1e6, (3, n))
    s, D = integers.integer_least_squares(a, Q, n_best=3), integers.decorrelate(Q)
    Z, L, d, status = integers.decorrelate_kernel(jit.kernel_input(Q))
    z, norms, nodes = integers.search_kernel(jit.kernel_input((a[0] - np.rint(a[0])) @ np.asarray(Z)), L, d, 3, 1000)
    assert status == integers.GOOD and np.allclose(norms, s.norms[0], rtol=1e-9), "the parts, called as another kernel does"
    F = rng.standard_normal((3, n))
    known = integers.constrained_integer_least_squares(a, Q, rng.standard_normal((3, 3)), F @ Q @ F.T + 0.1 * np.eye(3), F @ Q, 1.0)
    out["answers"].append([known.candidates.tolist(), known.norms.tolist(), known.nodes.tolist(), known.baselines.tolist()])
    F, body = rng.standard_normal((6, n)), [[1.0, 0.0, 0.0], [0.3, 0.8, 0.0]]
    turned = integers.attitude_integer_least_squares(a[:1], Q, rng.standard_normal((1, 2, 3)), F @ Q @ F.T + 0.1 * np.eye(6), F @ Q, body)
    out["answers"].append([turned.candidates.tolist(), turned.norms.tolist(), turned.nodes.tolist(), turned.rotations.tolist()])
    mean = integers.best_integer_equivariant(a, 0.3 * Q / integers.adop(Q), neglected=1e-3, most_integers=3000)
    out["answers"].append([mean.a.tolist(), mean.integers.tolist(), mean.greatest_weight.tolist()])
    out["answers"].append([s.candidates.tolist(), s.norms.tolist(), s.nodes.tolist(), D.Z.tolist(), D.L.tolist(), D.d.tolist()])
print(json.dumps(out))
"""


def run(**environment):
    environment = {"PATH": os.environ["PATH"], "PYTHONPATH": os.pathsep.join(sys.path), **environment}
    done = subprocess.run([sys.executable, "-W", "error", "-c", PROGRAM], env=environment, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.fixture(scope="module")
def plain():
    """The answers of the uncompiled kernels."""
    return run(GNSSLAB_NO_NUMBA="1")


def test_switched_off_means_not_even_imported(plain):
    assert not plain["compiled"]
    assert not plain["numba"]


def test_same_answers_with_and_without_compilation(plain):
    pytest.importorskip("numba")
    compiled = run(**{name: os.environ[name] for name in ("NUMBA_CACHE_DIR", "HOME") if name in os.environ})  # where they are compiled already
    assert compiled["compiled"]
    assert len(plain["answers"]) == 16
    assert compiled["answers"] == plain["answers"]  # to the last bit: same operations in the same order


@pytest.mark.skipif(not jit.COMPILED, reason="the cache is numba's")
def test_no_folder_for_the_cache_is_no_crash(monkeypatch):
    def no_locator(*arguments, **options):
        if options.get("cache"):
            raise RuntimeError("cannot cache function: no locator available")
        return lambda function: function

    monkeypatch.setattr(jit.numba, "njit", no_locator)
    assert jit.kernel(abs) is abs


def test_kernel_input_never_changes_the_callers_array():
    values = np.arange(6.0).reshape(2, 3)
    values.flags.writeable = False
    assert np.asarray(jit.kernel_input(values)).tolist() == values.tolist()
    assert np.asarray(jit.kernel_input([[1, 2]])).dtype == np.float64
    assert np.shape(jit.matrix(2, 3)) == (2, 3)


def test_a_changed_kernel_gets_a_new_folder(tmp_path):
    """Numba looks at each kernel's own file only: a copy of the package with one kernel changed must not find what was compiled before."""
    package = Path(jit.__file__).parents[1]
    for name in ("core", "gnss"):
        shutil.copytree(package / name, tmp_path / "gnsslab" / name, ignore=shutil.ignore_patterns("__pycache__", "rinex"))
    (tmp_path / "gnsslab" / "__init__.py").write_text("")
    before = folder_of(tmp_path)
    assert list(before.rglob("*.nbi")), "nothing was kept for the next process"
    kalman = tmp_path / "gnsslab" / "core" / "kalman.py"
    kalman.write_text(kalman.read_text() + "\n# another thought\n")
    assert before.name.startswith("kernels-")
    assert folder_of(tmp_path) != before


def folder_of(place):
    program = "from gnsslab.core import jit; print(jit._cache_folder())"
    environment = {"PATH": os.environ["PATH"], "PYTHONPATH": os.pathsep.join([str(place), *sys.path]), "NUMBA_CACHE_DIR": str(place / "cache")}
    done = subprocess.run([sys.executable, "-c", program], env=environment, capture_output=True, text=True, timeout=60, cwd=place)
    assert done.returncode == 0, done.stderr
    return Path(done.stdout.strip())
