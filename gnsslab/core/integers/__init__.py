"""Integer ambiguities: decorrelation, integer least squares, and how far to trust them.

For a caller: `integer_least_squares`, `decorrelate`, `success_rate`, `adop`. For another kernel:
`integer_least_squares_kernel`, or its parts `decorrelate_kernel` and `search_kernel`.
"""

from gnsslab.core.integers.decorrelation import Decorrelation, decorrelate, decorrelate_kernel
from gnsslab.core.integers.search import IntegerSolution, integer_least_squares, integer_least_squares_kernel, search_kernel
from gnsslab.core.integers.success import adop, success_rate

__all__ = [
    "Decorrelation",
    "IntegerSolution",
    "adop",
    "decorrelate",
    "decorrelate_kernel",
    "integer_least_squares",
    "integer_least_squares_kernel",
    "search_kernel",
    "success_rate",
]
