"""Integer ambiguities: decorrelation, integer least squares, and how far to trust them.

Which file answers what:

* decorrelation, rounding, search: find the integers (`decorrelate`, `ltdl`, `integer_rounding`, `integer_bootstrapping`, `integer_least_squares`);
* constrained, orthonormal: find them where a length, or a whole rigid body, is known;
* success, simulation, pull_in: how often they will be right (`success_rate`, `success_bounds`, `adop`, `simulate_success`);
* acceptance, aperture: whether to trust the fix at hand (`ratio_test`, `failure_rate_threshold`, `aperture_bootstrapping`);
* partial, equivariant: between all integers and none (`fix_most_certain`, `fix_subset`, `best_integer_equivariant`);
* tree: the search written down, for looking at.

For another kernel: `fix_groups`, `fix_groups_on_sphere`, `decorrelate_kernel`, whose status must be GOOD, and `search_kernel`.
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
from gnsslab.core.integers.sphere_search import fix_groups_on_sphere
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
    "fix_groups_on_sphere",
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
