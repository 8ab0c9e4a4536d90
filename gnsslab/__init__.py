"""Precise GNSS by hand: carrier-phase positioning, integers, attitude and more, each algorithm in the open.

The public names below load their modules when first used, so that `import gnsslab` itself is quick.
"""

from importlib import import_module

__version__ = "0.1.0"

_HOME_OF = {
    "read_rinex_obs": "gnsslab.gnss.rinex",
    "read_rinex_nav": "gnsslab.gnss.rinex",
    "write_rinex_obs": "gnsslab.gnss.rinex",
    "write_rinex_nav": "gnsslab.gnss.rinex",
    "read_rtcm": "gnsslab.gnss.rtcm",
    "RtcmError": "gnsslab.gnss.rtcm",
    "RinexError": "gnsslab.gnss.rinex",
    "Observations": "gnsslab.gnss.observations",
    "Ephemerides": "gnsslab.gnss.ephemerides",
    "read_series": "gnsslab.gnss.series_files",
    "Series": "gnsslab.gnss.series",
    "series_of": "gnsslab.gnss.series",
    "solve_points": "gnsslab.gnss.points",
    "solve_relative": "gnsslab.gnss.relative",
    "dual_antenna_attitude": "gnsslab.systems.dual_antenna",
    "heading_rate": "gnsslab.systems.heading_rate",
    "integer_least_squares": "gnsslab.core.integers",
    "decorrelate": "gnsslab.core.integers",
    "success_rate": "gnsslab.core.integers",
    "adop": "gnsslab.core.integers",
    "integer_rounding": "gnsslab.core.integers",
    "integer_bootstrapping": "gnsslab.core.integers",
    "success_bounds": "gnsslab.core.integers",
    "simulate_success": "gnsslab.core.integers",
    "constrained_integer_least_squares": "gnsslab.core.integers",
    "fix_with_length": "gnsslab.core.integers",
    "attitude_integer_least_squares": "gnsslab.core.integers",
    "nearest_rotation": "gnsslab.core.nearest_rotation",
    "solve_float": "gnsslab.core.mixed_model",
    "given_integers": "gnsslab.core.mixed_model",
    "FloatSolution": "gnsslab.core.mixed_model",
    "use_length": "gnsslab.core.mixed_model",
    "short_baseline_model": "gnsslab.gnss.short_baseline",
    "ratio_test": "gnsslab.core.integers",
    "difference_test": "gnsslab.core.integers",
    "failure_rate_threshold": "gnsslab.core.integers",
    "fix_most_certain": "gnsslab.core.integers",
    "fix_subset": "gnsslab.core.integers",
    "given_combinations": "gnsslab.core.integers",
    "best_integer_equivariant": "gnsslab.core.integers",
    "igg3_weight": "gnsslab.core.robust",
    "huber_weight": "gnsslab.core.robust",
    "plot_attitude": "gnsslab.figures.attitude",
}

__all__ = sorted(_HOME_OF)


def __getattr__(name):
    if name not in _HOME_OF:
        raise AttributeError(f"gnsslab has no public name {name!r}")
    return getattr(import_module(_HOME_OF[name]), name)


def __dir__():
    return sorted([*globals(), *_HOME_OF])
