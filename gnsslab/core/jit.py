"""Kernels: plain loops, compiled by Numba where it is installed, ordinary Python where it is not.

A kernel is one source for both worlds. It indexes matrices as `A[i][j]`, allocates through `vector` and `matrix`, and
uses `math`, no numpy: compiled these are arrays, uncompiled (in a browser, say) nested lists, because scalar loops over
numpy arrays are six times slower than over lists. Callers pass `kernel_input(array)` and read `np.asarray(result)`.

GNSSLAB_NO_NUMBA=1 in the environment switches the compiler off.
"""

import hashlib
import math
import os
from functools import cache, partial
from pathlib import Path

try:
    if os.environ.get("GNSSLAB_NO_NUMBA", "0") not in ("", "0"):
        raise ImportError("switched off by GNSSLAB_NO_NUMBA")
    import numba
except ImportError:
    numba = None

import numpy as np

COMPILED = numba is not None


def kernel(function, signature=None):
    """Compile a function of scalars and arrays on its first call, and keep the result on disk for the next process.

    Division follows IEEE (no exception), sums keep their order: the answers are those of the uncompiled source.
    The compiled code is kept in a folder of the user's cache (of NUMBA_CACHE_DIR where that is set) named after the text of
    all kernels; where no folder can be written it is compiled in each process anew. With a signature it is compiled at once,
    and only once: Numba makes a version of its own for each number that stands in a call, and two processes that do so
    at the same time may write them over each other.
    """
    if not COMPILED:
        return function
    options = {"error_model": "numpy", "no_cfunc_wrapper": True}  # the wrapper for C would double the smallest compilations
    options["nogil"] = True  # other threads of the process run meanwhile: a class, or a simulation on all cores
    usual, numba.config.CACHE_DIR = numba.config.CACHE_DIR, _cache_folder()
    try:
        return numba.njit(signature, cache=True, **options)(function)
    except RuntimeError:  # "no locator available": no folder for the cache
        return numba.njit(signature, **options)(function)
    finally:
        numba.config.CACHE_DIR = usual


@cache
def _cache_folder():
    """Return the folder for compiled kernels: a new one for each change in any of them, as Numba looks at one file at a time."""
    from numba.misc.appdirs import AppDirs

    base = os.environ.get("NUMBA_CACHE_DIR") or AppDirs("gnsslab", appauthor=False).user_cache_dir
    package = Path(__file__).parents[1]
    texts = [path.read_bytes() for folder in ("core", "gnss", "systems") for path in sorted(package.glob(f"{folder}/**/*.py"))]
    key = hashlib.sha256(b"".join(text for text in texts if b"@kernel" in text)).hexdigest()[:16]
    return str(Path(base) / f"kernels-{key}")


if COMPILED:

    @kernel
    def nearest(x):
        """Return the integer nearest to x, as a float; a tie goes up."""
        return np.floor(x + 0.5)  # one instruction, where math.floor goes by way of int64

    @partial(kernel, signature="float64[::1](int64)")
    def vector(n):
        """Allocate n zeros."""
        return np.zeros(n)

    @partial(kernel, signature="float64[:, ::1](int64, int64)")
    def matrix(rows, columns):
        """Allocate rows x columns zeros, indexed as A[i][j]."""
        return np.zeros((rows, columns))

    @partial(kernel, signature="float64[:, :, ::1](int64, int64, int64)")
    def cube(layers, rows, columns):
        """Allocate layers x rows x columns zeros, indexed as A[i][j][k]."""
        return np.zeros((layers, rows, columns))

    @partial(kernel, signature="int64[:, ::1](int64, int64)")
    def integer_matrix(rows, columns):
        """Allocate rows x columns integer zeros, indexed as A[i][j]."""
        return np.zeros((rows, columns), dtype=np.int64)

    _FLOAT64 = np.dtype(np.float64)

    def kernel_input(array):
        """Prepare an array for a kernel: float64, C-contiguous, writeable (else kernels are compiled once more); no copy where it is that already."""
        if type(array) is np.ndarray and array.dtype is _FLOAT64 and array.flags.carray:
            return array  # `require` finds the same, in ten times the time: a tenth of a small search
        return np.require(array, np.float64, "CW")

    def kernel_indices(array):
        """Prepare an array of indices for a kernel: int64, C-contiguous, writeable."""
        return np.require(array, np.int64, "CW")

else:

    def nearest(x):
        """Return the integer nearest to x, as a float; a tie goes up."""
        return float(math.floor(x + 0.5))

    def vector(n):
        """Allocate n zeros."""
        return [0.0] * n

    def matrix(rows, columns):
        """Allocate rows x columns zeros, indexed as A[i][j]."""
        return [[0.0] * columns for _ in range(rows)]

    def cube(layers, rows, columns):
        """Allocate layers x rows x columns zeros, indexed as A[i][j][k]."""
        return [matrix(rows, columns) for _ in range(layers)]

    def integer_matrix(rows, columns):
        """Allocate rows x columns integer zeros, indexed as A[i][j]."""
        return [[0] * columns for _ in range(rows)]

    def kernel_input(array):
        """Prepare an array for a kernel: nested lists of Python floats."""
        return np.asarray(array, dtype=np.float64).tolist()

    def kernel_indices(array):
        """Prepare an array of indices for a kernel: nested lists of Python integers."""
        return np.asarray(array, dtype=np.int64).tolist()
