"""Integer ambiguities: decorrelation, integer least squares, and how far to trust them.

For a caller: `integer_least_squares`, `decorrelate`, `success_rate`, `adop`. For another kernel: `fix_groups`,
`decorrelate_kernel`, whose status must be GOOD, and `search_kernel`.
"""

from gnsslab.core.integers.decorrelation import GOOD, Decorrelation, LtDL, decorrelate, decorrelate_kernel, ltdl
from gnsslab.core.integers.rounding import integer_bootstrapping, integer_rounding
from gnsslab.core.integers.search import IntegerSolution, fix_groups, integer_least_squares, search_kernel
from gnsslab.core.integers.simulation import SimulatedFixes, SimulatedRate, simulate_fixes, simulate_success
from gnsslab.core.integers.success import SuccessBounds, adop, adop_success_rate, success_bounds, success_rate

__all__ = [
    "GOOD",
    "Decorrelation",
    "IntegerSolution",
    "LtDL",
    "SimulatedFixes",
    "SimulatedRate",
    "SuccessBounds",
    "adop",
    "adop_success_rate",
    "decorrelate",
    "decorrelate_kernel",
    "fix_groups",
    "integer_bootstrapping",
    "integer_least_squares",
    "integer_rounding",
    "ltdl",
    "search_kernel",
    "simulate_fixes",
    "simulate_success",
    "success_bounds",
    "success_rate",
]
