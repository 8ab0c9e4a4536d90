"""Integer ambiguities: decorrelation, integer least squares, and how far to trust them.

For a caller: `integer_least_squares`, `decorrelate`, `success_rate`, `adop`. For another kernel: `fix_groups`,
`decorrelate_kernel`, whose status must be GOOD, and `search_kernel`.
"""

from gnsslab.core.integers.decorrelation import GOOD, Decorrelation, decorrelate, decorrelate_kernel
from gnsslab.core.integers.search import IntegerSolution, fix_groups, integer_least_squares, search_kernel
from gnsslab.core.integers.success import adop, success_rate

__all__ = [
    "GOOD",
    "Decorrelation",
    "IntegerSolution",
    "adop",
    "decorrelate",
    "decorrelate_kernel",
    "fix_groups",
    "integer_least_squares",
    "search_kernel",
    "success_rate",
]
