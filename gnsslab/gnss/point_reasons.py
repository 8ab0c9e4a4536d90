"""Why an epoch has no single point position, in words."""

import numpy as np
from scipy.special import chdtri

from gnsslab.gnss.signals import SYSTEM_NAMES

FALSE_ALARM = 1e-3  # of the chi-square test: one good epoch in a thousand would be refused
LARGEST_SIGMA = 100.0  # [m]: satellites nearly in one cone; a position this loose helps nobody
_NAMES_TOLD = 4  # satellites named in a reason, the rest are counted


def no_solution_reasons(sky, located, mask):
    """Return for each epoch (T,) why its position cannot be used, empty where it can.

    Asked in this order: measurements, ephemerides, satellites above the mask, geometry, residuals (chi-square of the fit).
    """
    reasons = np.full(len(sky.time), "", dtype="<U160")
    for epoch in np.flatnonzero(~_is_good(located)):
        reasons[epoch] = _reason(sky, located, mask, epoch)
    return reasons


def _is_good(located):
    fit = located.fit
    return fit.is_solved & (sigma_position(fit) < LARGEST_SIGMA) & (fit.chi_square <= chi_square_limit(fit.redundancy))


def sigma_position(fit):
    """Return sqrt(tr Q) [m] of the position part (T,), infinite where there is no solution."""
    Q = np.trace(fit.Q[:, :3, :3], axis1=-2, axis2=-1)
    return np.sqrt(np.where(np.isfinite(Q), Q, np.inf))


def chi_square_limit(redundancy):
    """Return the value that chi-square passes with probability FALSE_ALARM; infinite where nothing is redundant.

    >>> np.round(chi_square_limit(np.array([0, 1, 5])), 2).tolist()
    [inf, 10.83, 20.52]
    """
    checked = redundancy > 0
    return np.where(checked, chdtri(np.where(checked, redundancy, 1), FALSE_ALARM), np.inf)


def _reason(sky, located, mask, epoch):
    measured = np.isfinite(sky.code[epoch])
    if not measured.any():
        return f"no code measurements of {_systems_in_words(sky)}"
    without = _without_ephemeris(sky, epoch)
    if not sky.usable[epoch].any():
        return without
    fit = located.fit
    if not located.is_rough[epoch]:
        return _joined(_too_few(sky, sky.usable[epoch], "with a code and an ephemeris"), without)
    above = located.above[epoch]
    if fit.redundancy[epoch] < 0:
        return _joined(_too_few(sky, above, f"above {np.degrees(mask):g} deg"), without)
    sigma = sigma_position(fit)[epoch]
    if not sigma < LARGEST_SIGMA:
        return f"geometry too weak: {fit.used[epoch].sum()} satellites, " + ("position undetermined" if np.isinf(sigma) else f"sigma {sigma:.0f} m")
    return _too_large(located, epoch)


def _too_few(sky, seen, where):
    """Return in words that the satellites seen (m,) are too few for position and clocks."""
    systems = int((sky.clock_columns[seen].sum(axis=0) > 0).sum())
    count = int(seen.sum())
    if count == 0:
        return f"no satellite {where}"
    if count >= 3 + systems:
        return f"geometry too weak: {count} satellites {where} do not determine a position"
    words = f"only {count} satellite{'s' if count > 1 else ''} {where}"
    return words if systems < 2 else f"{words}, of {systems} systems: {3 + systems} are needed"


def _too_large(located, epoch):
    fit = located.fit
    used = fit.used[epoch]
    rms = np.sqrt(np.mean(fit.residual[epoch, used] ** 2))
    removed = int(located.above[epoch].sum() - used.sum())
    words = f"residuals too large: {rms:.1f} m rms with {used.sum()} satellites"
    return words if removed == 0 else f"{words} after {removed} were taken out"


def _without_ephemeris(sky, epoch):
    """Return "no ephemeris for G01, G05" for the satellites measured but not known, empty where there are none."""
    missing = np.flatnonzero(np.isfinite(sky.code[epoch]) & (sky.states.index[epoch] < 0))
    if not len(missing):
        return ""
    told = ", ".join(sky.names[i] for i in missing[:_NAMES_TOLD])
    more = f" and {len(missing) - _NAMES_TOLD} more" if len(missing) > _NAMES_TOLD else ""
    return f"no ephemeris for {told}{more}"


def _systems_in_words(sky):
    return ", ".join(SYSTEM_NAMES[letter] for letter in sky.systems) or "the systems asked for"


def _joined(*parts):
    return "; ".join(part for part in parts if part)
