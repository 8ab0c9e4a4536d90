"""Integer ambiguities: decorrelation, integer least squares, and how far to trust them.

For a caller: `integer_least_squares`, `integer_bootstrapping`, `integer_rounding`; `decorrelate`, `ltdl`; `success_rate`,
`success_bounds`, `simulate_success`, `adop`. For another kernel: `fix_groups`,
`decorrelate_kernel`, whose status must be GOOD, and `search_kernel`.
"""

from gnsslab.core.integers.acceptance import RatioThreshold, difference_test, failure_rate_threshold, projector_test, ratio_test, threshold_of_fixes
from gnsslab.core.integers.aperture import (
    ApertureSolution,
    ApertureThreshold,
    aperture_bootstrapping,
    aperture_success_rate,
    failure_rate_aperture,
)
from gnsslab.core.integers.constrained import (
    ConstrainedSolution,
    constrained_by_shrinking,
    constrained_integer_least_squares,
    fix_with_length,
)
from gnsslab.core.integers.decorrelation import GOOD, Decorrelation, LtDL, decorrelate, decorrelate_kernel, ltdl
from gnsslab.core.integers.equivariant import EquivariantSolution, best_integer_equivariant
from gnsslab.core.integers.orthonormal import AttitudeSolution, attitude_integer_least_squares
from gnsslab.core.integers.partial import (
    PartialSolution,
    fix_accepted_subset,
    fix_combinations,
    fix_most_certain,
    fix_subset,
    given_combinations,
)
from gnsslab.core.integers.rounding import integer_bootstrapping, integer_rounding
from gnsslab.core.integers.search import IntegerSolution, fix_groups, integer_least_squares, search_kernel
from gnsslab.core.integers.simulation import SimulatedFixes, SimulatedRate, simulate_fixes, simulate_success
from gnsslab.core.integers.success import SuccessBounds, adop, adop_success_rate, success_bounds, success_rate
from gnsslab.core.integers.tree import SearchTree, search_tree

__all__ = [
    "GOOD",
    "ApertureSolution",
    "ApertureThreshold",
    "AttitudeSolution",
    "ConstrainedSolution",
    "Decorrelation",
    "EquivariantSolution",
    "IntegerSolution",
    "LtDL",
    "PartialSolution",
    "RatioThreshold",
    "SearchTree",
    "SimulatedFixes",
    "SimulatedRate",
    "SuccessBounds",
    "adop",
    "adop_success_rate",
    "aperture_bootstrapping",
    "aperture_success_rate",
    "attitude_integer_least_squares",
    "best_integer_equivariant",
    "constrained_by_shrinking",
    "constrained_integer_least_squares",
    "decorrelate",
    "decorrelate_kernel",
    "difference_test",
    "failure_rate_aperture",
    "failure_rate_threshold",
    "fix_accepted_subset",
    "fix_combinations",
    "fix_groups",
    "fix_most_certain",
    "fix_subset",
    "fix_with_length",
    "given_combinations",
    "integer_bootstrapping",
    "integer_least_squares",
    "integer_rounding",
    "ltdl",
    "projector_test",
    "ratio_test",
    "search_kernel",
    "search_tree",
    "simulate_fixes",
    "simulate_success",
    "success_bounds",
    "success_rate",
    "threshold_of_fixes",
]
